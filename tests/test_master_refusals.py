"""What master refuses: a call a line, and how its one line begins."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
import scipy.stats

import master
import origins
from master.paper.explicit import explicit
from master.paper.q15_transient import paper_transient
from origins import (
    Ageing,
    Contacts,
    Delay,
    Thermal,
    gaussian,
    gaussian_start,
    growing_grains,
    gw_plastic,
    identical,
    lubricated,
    mixture,
)

WIDE, FRESH = gaussian(1.0, 0.2), gaussian(0.5, 0.1)
PLAIN, ONE = Contacts(WIDE), Contacts(identical(1.0))
SOFT, PAPER = Thermal("soft", 0.1), Ageing(gaussian(1.0, 0.01), 1e-3, "paper")
OLD = Contacts(FRESH, ageing=Ageing(gaussian(1.0, 0.01), 1e-3))
PRINTED = Contacts(FRESH, gaussian_start(0.1, 0.025), ageing=PAPER)
GRAINS = growing_grains(1.0, 1.0, age=4.0)
PAIR = mixture([identical(0.95), identical(1.05)], [0.5, 0.5])
LOMAX = scipy.stats.lomax
UNEVEN = [origins.rectangular(0.5, 1.0), origins.rectangular(0.5, 1.5)]
AWAY = gaussian_start(0.0, 0.05)
solve, steady, propensity = master.solve, master.steady_state, master.propensity
curve, line, spectrum = master.kinetic_curve, master.phase_line, master.decoherence_spectrum
v_c = master.critical_velocity


def distribution(contacts: Contacts, path: list[float], *asked: object) -> object:
    return solve(contacts, path, 1e-3).distribution(*asked)


FIERCE = Contacts(WIDE, thermal=Thermal("soft", 0.1, 1e12))
WARM = Contacts(WIDE, thermal=SOFT)
BACK = Contacts(gaussian(1.0, 0.05), thermal=Thermal("soft", 10.0, 1e3), reforming=-0.3)
LATE = Contacts(WIDE, ageing=Ageing(gaussian(1.5, 0.1), 1e-2))
STEEP = Contacts(lubricated(1.0, power=-0.96))
CALLS = [
    # paths, tolerances and times
    *((partial(solve, PLAIN, [0.0, 1.0], t), "tolerance = ") for t in (0.0, np.nan, "1e-8", True)),
    (partial(propensity, ONE, 0.0), "tolerance = "),
    (partial(solve, PLAIN, [0.0, np.nan]), r"path\[1\]"),
    (partial(solve, PLAIN, []), "path"),
    (partial(solve, PLAIN, [0.0, 1e300]), r"path\[-1\] = 1e\+300: is 1e\+300 mean thresholds"),
    (partial(solve, PLAIN, [-1e50, 1e50]), r"path\[0\] = .*turn round within 1e\+06"),
    (partial(solve, PLAIN, [0.0, 1.0], wall_time=0.0), "wall_time"),
    pytest.param(
        partial(solve, Contacts(PAIR), [0.0, 1000.0]),
        ".*exact values break together more often",
        marks=pytest.mark.slow,
    ),
    (
        lambda: solve(PLAIN.replace(thermal=Thermal("soft", 1e3, 1e18), delay=Delay(0.3)), [1.0]),
        "delay = 0.3: contacts hold for .*, too short to follow",
    ),
    (partial(solve, FIERCE, [3.0, -3.0, 3.0]), r".*attempt_frequency = 10+\.0: .* on the way"),
    pytest.param(
        partial(solve, LATE, [1e3, -1e3]),
        r"ageing: a move of .* in time needs more than \d+ steps",
        marks=pytest.mark.slow,
    ),
    # Q(x;X)
    *((partial(distribution, PLAIN, [0.0, 3.0], at), "position = ") for at in (3.1, np.nan, "1")),
    (partial(distribution, ONE, [0.7, -0.6], 0.3), ".*is passed on legs 0, 1; say which"),
    (partial(distribution, ONE, [0.7, -0.6], 5.0), ".*does not come there"),
    (partial(distribution, ONE, [0.7, -0.6], 0.3, 7), "leg = 7"),
    (partial(distribution, Contacts(WIDE, delay=Delay(0.3)), [0.3, 0.2], 2), ".*index of a point"),
    (partial(distribution, Contacts(WIDE, reforming=AWAY), [0.3, 0.2], 1), ".*at many stretches"),
    (partial(distribution, OLD, [0.3, 0.2], 1), ".*where contacts age"),
    # steady sliding and its curves
    *((partial(f, Contacts(LOMAX(1.9))), r"thresholds: <x_s\^2> is") for f in (steady, propensity)),
    (
        partial(steady, Contacts(LOMAX(2.9), stiffness="linked")),
        r"thresholds: <x_s\^3> is infinite",
    ),
    (partial(curve, Contacts(LOMAX(1.9), thermal=SOFT)), r"thresholds: <x_s\^2> is infinite"),
    (partial(curve, PLAIN, [1.0, 0.0]), r"velocity = 0\.0: must be finite and above zero"),
    (partial(curve, PLAIN, []), "velocity .*must not be empty"),
    (
        partial(curve, PLAIN, [1, 2, 3], delay=[0, 1]),
        "velocity, delay: have shapes that do not fit",
    ),
    (partial(curve, PLAIN, delay=-1.0), r"delay = -1\.0: must be finite and zero or above"),
    (partial(curve, PLAIN, temperature=[0.1]), "temperature: these contacts have no law for it"),
    (partial(curve, PLAIN, rate=[0.1]), "rate: these contacts do not age"),
    (partial(line, PLAIN, temperature=[0.1]), "temperature: these contacts have no law for it"),
    (partial(curve, WARM, [1e-170]), "velocity = 1e-170: contacts break before they have moved"),
    (partial(steady, WARM, velocity=1e-170), "velocity = 1e-170: contacts break before they"),
    (partial(curve, WARM, [1e-200]), "velocity = 1e-200: contacts break before .* slide faster"),
    # propensity, spectrum, v_c
    (partial(propensity, BACK), r".*ask master\.phase_line for K"),
    (partial(propensity, STEEP), "thresholds: a weight of .* lies below 1e-290 of the mean"),
    (partial(solve, STEEP, [0.0, 2.0]), "thresholds: a weight of .* lies below 1e-290 of the mean"),
    (partial(spectrum, Contacts(PAIR)), ".*exact values alone: their roots come as near to Re s"),
    (partial(spectrum, Contacts(scipy.stats.lognorm(1.0))), ".*tail falls slower than any exp"),
    (partial(spectrum, PRINTED), ".*single contacts have no law of their own"),
    (partial(spectrum, Contacts(GRAINS), velocity=10.0), "velocity = 10.0: grains grow, unpinned"),
    (partial(spectrum, FIERCE), ".*among so many no leading oscillating wave"),
    (partial(spectrum, PLAIN, n_roots=0), "n_roots"),
    (partial(spectrum, Contacts(WIDE, delay=Delay(1e13))), r".*contacts wait for 1e\+13 times"),
    (partial(v_c, OLD, 50.0, 3.0, 4.0), "slowest, fastest: -F' is at most"),
    (partial(v_c, PRINTED, -1.0, 3.0, 4.0), r"spring = -1\.0: must be above zero"),
    (partial(v_c, PLAIN, 1.0, 3.0, 4.0), r"contacts\.ageing: is None; without ageing nothing"),
    (partial(v_c, Contacts(GRAINS), 1.0, 3.0, 4.0), r"contacts\.ageing: is None; v_c is that of"),
    # ageing, (Q15) and grains
    (
        partial(solve, Contacts(identical(0.5), ageing=OLD.ageing), [0.5, 0.5], time=[0.5, 1.0]),
        "thresholds: hold the single value 0.5",
    ),
    (
        partial(steady, Contacts(identical(0.5), ageing=Ageing(gw_plastic(1.0), 1.0))),
        "thresholds: hold the single value 0.5",
    ),
    (
        partial(solve, PRINTED.replace(delay=Delay(0.1)), [1.0]),
        r"contacts\.delay: \(Q15\), the paper",
    ),
    (partial(steady, PRINTED.replace(reforming=0.1)), r"contacts\.reforming: \(Q15\), the paper's"),
    (partial(solve, PRINTED, [1.0], time=[1.0]), "time: the paper's closure of ageing takes one"),
    (partial(propensity, PRINTED), r'contacts\.ageing: closure = "paper" \(Q15\) has one P_c'),
    (partial(solve, Contacts(FRESH, 0.1, ageing=PAPER), [1.0]), "start: all contacts at the one"),
    (
        lambda: steady(OLD.replace(thermal=Thermal("soft", 0.1, closure="paper"))),
        r'contacts\.thermal: closure = "paper" averages the rate',
    ),
    (partial(steady, OLD, velocity=-1.0), r"velocity = -1\.0: must be above"),
    (lambda: Ageing(mixture(UNEVEN, [0.5, 0.5]), 0.1), "final: the density jumps at 1: there"),
    (
        lambda: Contacts(UNEVEN[1], ageing=Ageing(origins.rectangular(0.7, 1.5), 0.1)),
        ".*fresh thresholds lies outside the final law",
    ),
    (partial(paper_transient, PRINTED, [1.0], 0.01, keep="both"), "keep = 'both': "),
    (partial(paper_transient, PRINTED, [1.0], 1e-6), "step = 1e-06: needs more than 20,000 cells"),
    (partial(propensity, Contacts(GRAINS), velocity=30.0), ".*none holds but a fraction"),
    *(
        (partial(curve, Contacts(GRAINS), v), "velocity = .* at which thresholds grow")
        for v in (1e-60, 1e300)
    ),
    (
        lambda: Contacts(GRAINS, thermal=Thermal("soft", 0.1, 1.0, "paper")),
        'thermal: closure = "paper" averages',
    ),
    (lambda: Contacts(GRAINS, ageing=OLD.ageing), "ageing: thresholds that grow with their age do"),
    (lambda: Contacts(GRAINS, reforming=0.1), "reforming: contacts form again as their grains pin"),
    (lambda: Contacts(GRAINS, stiffness="linked"), "stiffness = 'linked': not defined with"),
    # springs
    (
        partial(solve, Contacts(WIDE, reforming=0.1), [0.0, 2.0], spring=0.4, slip="reform-after"),
        "slip = 'reform-after': takes contacts that form again at x = 0",
    ),
    (
        partial(solve, WARM.replace(start=0.2), [0.0, 2.0], time=[0.0, 1.0], spring=0.4),
        r"path\[0\] = 0.0: at time 0 the drive stands where it balances the start",
    ),
    # the paper's explicit scheme
    (partial(explicit, PLAIN, [0.0, 1.0], 0.0), r"step = 0\.0: must be above zero"),
    (partial(explicit, PLAIN, [0.0, 1.0], 1e-9), ".*write step="),
    (partial(explicit, PLAIN, [1.0, 0.0], 0.1), ".*does not turn round"),
    (partial(explicit, PLAIN, [0.0, 1.0], 0.1, "exact"), '.*must be "survival" or "printed"'),
    (partial(explicit, ONE, [0.0, 1.0], 0.1, "printed"), '.*write "survival"'),
]


@pytest.mark.filterwarnings("ignore:the temperature is")
@pytest.mark.filterwarnings("ignore:The integral is probably divergent")  # as it is
@pytest.mark.parametrize(("call", "begins"), CALLS)
def test_a_refusal_is_one_line_that_names_the_value(call: Callable, begins: str) -> None:
    with pytest.raises(origins.InputError, match="^(?:" + begins + ")") as refusal:
        call()
    assert "\n" not in str(refusal.value)


def test_weight_cut_from_the_start_is_said() -> None:
    contacts = Contacts(origins.rectangular(0.5, 1.5), gaussian_start(1.4, 0.02))
    assert 0.0 < contacts.cut_weight < 1e-6
    assert "cut off" in solve(contacts, [0.0, 1.0]).message
