"""What master refuses: how its one line begins, and the call."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import master
import origins
from master.paper.explicit import explicit
from master.paper.q15_transient import paper_transient
from origins import Ageing, Contacts, Thermal, gaussian, gaussian_start, identical, mixture

WIDE, FRESH = gaussian(1.0, 0.2), gaussian(0.5, 0.1)
PLAIN, ONE = Contacts(WIDE), Contacts(identical(1.0))
SOFT, PAPER = Thermal("soft", 0.1), Ageing(gaussian(1.0, 0.01), 1e-3, "paper")
OLD = Contacts(FRESH, ageing=Ageing(gaussian(1.0, 0.01), 1e-3))
PRINTED = Contacts(FRESH, gaussian_start(0.1, 0.025), ageing=PAPER)
GROWING = Contacts(origins.growing_grains(1.0, 1.0, age=4.0))
PAIR = Contacts(mixture([identical(0.95), identical(1.05)], [0.5, 0.5]))
BOX = origins.rectangular(0.5, 1.5)
UNEVEN = mixture([origins.rectangular(0.5, 1.0), BOX], [0.5, 0.5])
FIERCE = Contacts(WIDE, thermal=Thermal("soft", 0.1, 1e12))
WARM = Contacts(WIDE, thermal=SOFT)
BACK = Contacts(gaussian(1.0, 0.05), thermal=Thermal("soft", 10.0, 1e3), reforming=-0.3)
STEEP = Contacts(origins.lubricated(1.0, power=-0.96))


def told(contacts: Contacts, path: list[float], *asked: object) -> object:
    """Q(x;X)"""
    return master.solve(contacts, path, 1e-3).distribution(*asked)


# how the line begins, as a regular expression, and the call
REFUSED: list[tuple[str, Callable[[], object]]] = [
    ("tolerance =", lambda: master.solve(PLAIN, [0.0, 1.0], 0.0)),
    ("tolerance =", lambda: master.solve(PLAIN, [0.0, 1.0], np.nan)),
    ("tolerance =", lambda: master.solve(PLAIN, [0.0, 1.0], "1e-8")),
    ("tolerance =", lambda: master.solve(PLAIN, [0.0, 1.0], True)),
    ("tolerance =", lambda: master.propensity(ONE, 0.0)),
    (r"path\[1\]", lambda: master.solve(PLAIN, [0.0, np.nan])),
    ("path", lambda: master.solve(PLAIN, [])),
    (
        r"path\[-1\] = 1e\+300: is 1e\+300 mean thresholds",
        lambda: master.solve(PLAIN, [0.0, 1e300]),
    ),
    (r"path\[0\] = .*turn round within 1e\+06", lambda: master.solve(PLAIN, [-1e50, 1e50])),
    ("wall_time", lambda: master.solve(PLAIN, [0.0, 1.0], wall_time=0.0)),
    (".*exact values break together more often", lambda: master.solve(PAIR, [0.0, 1000.0])),
    (
        "delay = 0.3: .*, too short to follow",
        lambda: master.solve(
            PLAIN.replace(thermal=Thermal("soft", 1e3, 1e18), delay=origins.Delay(0.3)), [1.0]
        ),
    ),
    (
        r".*attempt_frequency or scale = 10+\.0: .* on the path",
        lambda: master.solve(FIERCE, [3.0, -3.0, 3.0]),
    ),
    ("where =", lambda: told(PLAIN, [0.0, 3.0], 3.1)),
    ("where =", lambda: told(PLAIN, [0.0, 3.0], np.nan)),
    ("where =", lambda: told(PLAIN, [0.0, 3.0], "1")),
    (".*is passed on legs 0, 1; choose", lambda: told(ONE, [0.7, -0.6], 0.3)),
    (".*does not come there", lambda: told(ONE, [0.7, -0.6], 5.0)),
    ("leg = 7", lambda: told(ONE, [0.7, -0.6], 0.3, 7)),
    (".*index of a point", lambda: told(Contacts(WIDE, delay=origins.Delay(0.3)), [0.3, 0.2], 2)),
    (
        "leg = 0: is that of a position",
        lambda: told(Contacts(WIDE, delay=origins.Delay(0.3)), [0.3, 0.2], 1, 0),
    ),
    (
        ".*with many stretches",
        lambda: told(Contacts(WIDE, reforming=gaussian_start(0.0, 0.05)), [0.3, 0.2], 1),
    ),
    (r".*Q\(x;X\) is not known.*where contacts age", lambda: told(OLD, [0.3, 0.2], 1)),
    (r".*Q\(x;X\) is not known", lambda: told(GROWING, [0.3, 0.2], 1)),
    (r"thresholds: <x_s\^2> is", lambda: master.steady_state(Contacts(stats.lomax(1.9)))),
    (r"thresholds: <x_s\^2> is", lambda: master.propensity(Contacts(stats.lomax(1.9)))),
    (
        r"thresholds: <x_s\^3> is infinite",
        lambda: master.steady_state(Contacts(stats.lomax(2.9), stiffness="linked")),
    ),
    (
        r"thresholds: <x_s\^2> is infinite",
        lambda: master.kinetic_curve(Contacts(stats.lomax(1.9), thermal=SOFT)),
    ),
    (r"velocity = 0\.0: must be above zero", lambda: master.kinetic_curve(PLAIN, [1.0, 0.0])),
    ("velocity .*must not be empty", lambda: master.kinetic_curve(PLAIN, [])),
    (
        "velocity, delay: have shapes that do not fit",
        lambda: master.kinetic_curve(PLAIN, [1, 2, 3], delay=[0, 1]),
    ),
    (r"delay = -1\.0: must be zero or above", lambda: master.kinetic_curve(PLAIN, delay=-1.0)),
    (
        "temperature: these contacts have no law for it",
        lambda: master.kinetic_curve(PLAIN, temperature=[0.1]),
    ),
    ("rate: these contacts do not age", lambda: master.kinetic_curve(PLAIN, rate=[0.1])),
    ("velocity = 1e-170: must lie between 1e-100", lambda: master.kinetic_curve(WARM, [1e-170])),
    (
        "velocity = .* at which thresholds grow",
        lambda: master.steady_state(GROWING, velocity=1e-50),
    ),
    (r".*ask master\.phase_line for K", lambda: master.propensity(BACK)),
    ("thresholds: a weight of .* lies below 1e-290 of the mean", lambda: master.propensity(STEEP)),
    (
        "thresholds: a weight of .* lies below 1e-290 of the mean",
        lambda: master.solve(STEEP, [0.0, 2.0]),
    ),
    (
        ".*exact values alone: their roots come as near to Re s",
        lambda: master.decoherence_spectrum(PAIR),
    ),
    (
        ".*tail falls slower than any exp",
        lambda: master.decoherence_spectrum(Contacts(stats.lognorm(1.0))),
    ),
    (".*none for single ones", lambda: master.decoherence_spectrum(PRINTED)),
    (
        "velocity = 10.0: grains grow, unpinned",
        lambda: master.decoherence_spectrum(GROWING, velocity=10.0),
    ),
    (".*among so many no leading oscillating wave", lambda: master.decoherence_spectrum(FIERCE)),
    ("n_roots", lambda: master.decoherence_spectrum(PLAIN, n_roots=0)),
    (
        r".*contacts wait for 1e\+13 times",
        lambda: master.decoherence_spectrum(Contacts(WIDE, delay=origins.Delay(1e13))),
    ),
    ("slowest, fastest: -F' is at most", lambda: master.critical_velocity(OLD, 50.0, 3.0, 4.0)),
    (
        r"spring = -1\.0: must be above zero",
        lambda: master.critical_velocity(PRINTED, -1.0, 3.0, 4.0),
    ),
    (
        r"contacts\.ageing: is None; v_c is that of contacts that age",
        lambda: master.critical_velocity(PLAIN, 1.0, 3.0, 4.0),
    ),
    (
        "thresholds: hold the single",
        lambda: master.solve(
            Contacts(identical(0.5), ageing=Ageing(origins.gw_plastic(1.0), 1.0)), [1.0], spring=1.0
        ),
    ),
    (
        r"contacts\.delay: \(Q15\), the paper",
        lambda: master.solve(PRINTED.replace(delay=origins.Delay(0.1)), [1.0]),
    ),
    (
        r"contacts\.reforming: \(Q15\), the paper's",
        lambda: master.steady_state(PRINTED.replace(reforming=0.1)),
    ),
    (
        "time: the paper's closure of ageing takes one",
        lambda: master.solve(PRINTED, [1.0], time=[1.0]),
    ),
    (
        r'contacts\.ageing: closure = "paper" \(Q15\) has one P_c',
        lambda: master.propensity(PRINTED),
    ),
    (
        "start: all contacts at the one",
        lambda: master.solve(Contacts(FRESH, 0.1, ageing=PAPER), [1.0]),
    ),
    (
        'thermal: closure = "paper" averages',
        lambda: master.steady_state(OLD.replace(thermal=Thermal("soft", 0.1, closure="paper"))),
    ),
    (r"velocity = -1\.0: must be above", lambda: master.steady_state(OLD, velocity=-1.0)),
    ("final: the density jumps at 1: there", lambda: Ageing(UNEVEN, 0.1)),
    ("keep = 'both':", lambda: paper_transient(PRINTED, [1.0], 0.01, keep="both")),
    ("step = 1e-06: needs more than 20,000 steps", lambda: paper_transient(PRINTED, [1.0], 1e-6)),
    (".*none holds but a fraction", lambda: master.propensity(GROWING, velocity=30.0)),
    ("velocity = .* at which thresholds grow", lambda: master.kinetic_curve(GROWING, 1e-60)),
    ("velocity = .* at which thresholds grow", lambda: master.kinetic_curve(GROWING, 1e90)),
    (
        'thermal: closure = "paper" averages',
        lambda: GROWING.replace(thermal=Thermal("soft", 0.1, 1.0, "paper")),
    ),
    ("ageing: thresholds that grow with their age do", lambda: GROWING.replace(ageing=OLD.ageing)),
    ("reforming: contacts form again as their grains pin", lambda: GROWING.replace(reforming=0.1)),
    ("stiffness = 'linked': not defined with", lambda: GROWING.replace(stiffness="linked")),
    (
        "slip = 'reform-after': takes contacts",
        lambda: master.solve(
            PLAIN.replace(reforming=0.1), [0.0, 2.0], spring=0.4, slip="reform-after"
        ),
    ),
    (
        r"path\[0\] = 0.0: at time 0 the drive stands",
        lambda: master.solve(WARM.replace(start=0.2), [0.0, 2.0], time=[0.0, 1.0], spring=0.4),
    ),
    (r"step = 0\.0: must be above zero", lambda: explicit(PLAIN, [0.0, 1.0], 0.0)),
    (".*write step=", lambda: explicit(PLAIN, [0.0, 1.0], 1e-9)),
    (".*does not turn round", lambda: explicit(PLAIN, [1.0, 0.0], 0.1)),
    ('.*must be "survival" or "printed"', lambda: explicit(PLAIN, [0.0, 1.0], 0.1, "exact")),
    ('.*write "survival"', lambda: explicit(ONE, [0.0, 1.0], 0.1, "printed")),
]


# these are known only after some work
LATE = ("slowest, fastest: -F' is at most", ".*exact values break together more often")


@pytest.mark.filterwarnings("ignore:the temperature is")
@pytest.mark.filterwarnings("ignore:The integral is probably divergent")  # as it is
@pytest.mark.parametrize(
    ("begins", "call"),
    [slow(begins, call, when=begins in LATE, id=begins) for begins, call in REFUSED],
)
def test_a_refusal_is_one_line_that_names_the_value(
    begins: str, call: Callable[[], object]
) -> None:
    with pytest.raises(origins.InputError) as refusal:
        call()
    assert re.match(begins, str(refusal.value)) and "\n" not in str(refusal.value)


def test_weight_cut_from_the_start_is_said() -> None:
    contacts = Contacts(BOX, gaussian_start(1.4, 0.02))
    assert 0.0 < contacts.cut_weight < 1e-6
    assert "cut off" in master.solve(contacts, [0.0, 1.0]).message
