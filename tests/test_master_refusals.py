"""What master refuses: a call a line, and how its one line begins, as a regular expression."""

from __future__ import annotations

import re

import numpy as np
import pytest
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
CALLED = {"np": np, "stats": stats, "explicit": explicit, "paper_transient": paper_transient}


def told(contacts: Contacts, path: list[float], *asked: object) -> object:
    """Q(x;X)"""
    return master.solve(contacts, path, 1e-3).distribution(*asked)


REFUSED = r"""
solve(PLAIN, [0.0, 1.0], 0.0)  tolerance =
solve(PLAIN, [0.0, 1.0], np.nan)  tolerance =
solve(PLAIN, [0.0, 1.0], "1e-8")  tolerance =
solve(PLAIN, [0.0, 1.0], True)  tolerance =
propensity(ONE, 0.0)  tolerance =
solve(PLAIN, [0.0, np.nan])  path\[1\]
solve(PLAIN, [])  path
solve(PLAIN, [0.0, 1e300])  path\[-1\] = 1e\+300: is 1e\+300 mean thresholds
solve(PLAIN, [-1e50, 1e50])  path\[0\] = .*turn round within 1e\+06
solve(PLAIN, [0.0, 1.0], wall_time=0.0)  wall_time
solve(PAIR, [0.0, 1000.0])  .*exact values break together more often
solve(PLAIN.replace(thermal=Thermal("soft", 1e3, 1e18), delay=Delay(0.3)), [1.0])  delay = 0.3: .*, too short to follow
solve(FIERCE, [3.0, -3.0, 3.0])  .*attempt_frequency or scale = 10+\.0: .* on the path
told(PLAIN, [0.0, 3.0], 3.1)  where =
told(PLAIN, [0.0, 3.0], np.nan)  where =
told(PLAIN, [0.0, 3.0], "1")  where =
told(ONE, [0.7, -0.6], 0.3)  .*is passed on legs 0, 1; choose
told(ONE, [0.7, -0.6], 5.0)  .*does not come there
told(ONE, [0.7, -0.6], 0.3, 7)  leg = 7
told(Contacts(WIDE, delay=Delay(0.3)), [0.3, 0.2], 2)  .*index of a point
told(Contacts(WIDE, delay=Delay(0.3)), [0.3, 0.2], 1, 0)  leg = 0: is that of a position
told(Contacts(WIDE, reforming=gaussian_start(0.0, 0.05)), [0.3, 0.2], 1)  .*with many stretches
told(OLD, [0.3, 0.2], 1)  .*Q\(x;X\) is not known.*where contacts age
told(GROWING, [0.3, 0.2], 1)  .*Q\(x;X\) is not known
steady_state(Contacts(stats.lomax(1.9)))  thresholds: <x_s\^2> is
propensity(Contacts(stats.lomax(1.9)))  thresholds: <x_s\^2> is
steady_state(Contacts(stats.lomax(2.9), stiffness="linked"))  thresholds: <x_s\^3> is infinite
kinetic_curve(Contacts(stats.lomax(1.9), thermal=SOFT))  thresholds: <x_s\^2> is infinite
kinetic_curve(PLAIN, [1.0, 0.0])  velocity = 0\.0: must be above zero
kinetic_curve(PLAIN, [])  velocity .*must not be empty
kinetic_curve(PLAIN, [1, 2, 3], delay=[0, 1])  velocity, delay: have shapes that do not fit
kinetic_curve(PLAIN, delay=-1.0)  delay = -1\.0: must be zero or above
kinetic_curve(PLAIN, temperature=[0.1])  temperature: these contacts have no law for it
kinetic_curve(PLAIN, rate=[0.1])  rate: these contacts do not age
kinetic_curve(WARM, [1e-170])  velocity = 1e-170: must lie between 1e-100
steady_state(GROWING, velocity=1e-50)  velocity = .* at which thresholds grow
propensity(BACK)  .*ask master\.phase_line for K
propensity(STEEP)  thresholds: a weight of .* lies below 1e-290 of the mean
solve(STEEP, [0.0, 2.0])  thresholds: a weight of .* lies below 1e-290 of the mean
decoherence_spectrum(PAIR)  .*exact values alone: their roots come as near to Re s
decoherence_spectrum(Contacts(stats.lognorm(1.0)))  .*tail falls slower than any exp
decoherence_spectrum(PRINTED)  .*none for single ones
decoherence_spectrum(GROWING, velocity=10.0)  velocity = 10.0: grains grow, unpinned
decoherence_spectrum(FIERCE)  .*among so many no leading oscillating wave
decoherence_spectrum(PLAIN, n_roots=0)  n_roots
decoherence_spectrum(Contacts(WIDE, delay=Delay(1e13)))  .*contacts wait for 1e\+13 times
critical_velocity(OLD, 50.0, 3.0, 4.0)  slowest, fastest: -F' is at most
critical_velocity(PRINTED, -1.0, 3.0, 4.0)  spring = -1\.0: must be above zero
critical_velocity(PLAIN, 1.0, 3.0, 4.0)  contacts\.ageing: is None; v_c is that of contacts that age
solve(Contacts(identical(0.5), ageing=Ageing(gw_plastic(1.0), 1.0)), [1.0], spring=1.0)  thresholds: hold the single
solve(PRINTED.replace(delay=Delay(0.1)), [1.0])  contacts\.delay: \(Q15\), the paper
steady_state(PRINTED.replace(reforming=0.1))  contacts\.reforming: \(Q15\), the paper's
solve(PRINTED, [1.0], time=[1.0])  time: the paper's closure of ageing takes one
propensity(PRINTED)  contacts\.ageing: closure = "paper" \(Q15\) has one P_c
solve(Contacts(FRESH, 0.1, ageing=PAPER), [1.0])  start: all contacts at the one
steady_state(OLD.replace(thermal=Thermal("soft", 0.1, closure="paper")))  thermal: closure = "paper" averages
steady_state(OLD, velocity=-1.0)  velocity = -1\.0: must be above
Ageing(UNEVEN, 0.1)  final: the density jumps at 1: there
paper_transient(PRINTED, [1.0], 0.01, keep="both")  keep = 'both':
paper_transient(PRINTED, [1.0], 1e-6)  step = 1e-06: needs more than 20,000 steps
propensity(GROWING, velocity=30.0)  .*none holds but a fraction
kinetic_curve(GROWING, 1e-60)  velocity = .* at which thresholds grow
kinetic_curve(GROWING, 1e90)  velocity = .* at which thresholds grow
GROWING.replace(thermal=Thermal("soft", 0.1, 1.0, "paper"))  thermal: closure = "paper" averages
GROWING.replace(ageing=OLD.ageing)  ageing: thresholds that grow with their age do
GROWING.replace(reforming=0.1)  reforming: contacts form again as their grains pin
GROWING.replace(stiffness="linked")  stiffness = 'linked': not defined with
solve(PLAIN.replace(reforming=0.1), [0.0, 2.0], spring=0.4, slip="reform-after")  slip = 'reform-after': takes contacts
solve(WARM.replace(start=0.2), [0.0, 2.0], time=[0.0, 1.0], spring=0.4)  path\[0\] = 0.0: at time 0 the drive stands
explicit(PLAIN, [0.0, 1.0], 0.0)  step = 0\.0: must be above zero
explicit(PLAIN, [0.0, 1.0], 1e-9)  .*write step=
explicit(PLAIN, [1.0, 0.0], 0.1)  .*does not turn round
explicit(PLAIN, [0.0, 1.0], 0.1, "exact")  .*must be "survival" or "printed"
explicit(ONE, [0.0, 1.0], 0.1, "printed")  .*write "survival"
"""
ROWS = [line.split("  ", 1) for line in REFUSED.strip().splitlines()]


@pytest.mark.filterwarnings("ignore:the temperature is")
@pytest.mark.filterwarnings("ignore:The integral is probably divergent")  # as it is
@pytest.mark.parametrize(("call", "begins"), ROWS, ids=[call for call, _ in ROWS])
def test_a_refusal_is_one_line_that_names_the_value(call: str, begins: str) -> None:
    with pytest.raises(origins.InputError) as refusal:
        eval(call, {**vars(origins), **vars(master), **globals(), **CALLED})
    assert re.match(begins, str(refusal.value)) and "\n" not in str(refusal.value)


def test_weight_cut_from_the_start_is_said() -> None:
    contacts = Contacts(BOX, gaussian_start(1.4, 0.02))
    assert 0.0 < contacts.cut_weight < 1e-6
    assert "cut off" in master.solve(contacts, [0.0, 1.0]).message
