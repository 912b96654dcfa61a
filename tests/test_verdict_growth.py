"""What a verdict says of contacts that strengthen with age beside a mass: the ensemble follows them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from conftest import slow

import eq_model
import master
from origins import Ageing, Contacts, Delay, InputError, Thermal, gaussian, strengthening
from tests.verdicts import raising
from toolkit.verdict.sliders.budget import MOST_BREAKS_IN_TIME, may_follow, most_breaks
from toolkit.verdict.sliders.ensemble import NOT_SLID, PILOT, sliders
from toolkit.verdict.sliders.finite import follow_finite
from toolkit.verdict.sliders.follow import TOLERANCE_IN_TIME, follow
from toolkit.verdict.sliders.machine import Machine, RigidSlider, slip_duration
from toolkit.verdict.sliders.records import Behaviour

GROWING = Contacts(strengthening(gaussian(1.0, 0.3), beta=0.05, time=1e-2), delay=Delay(0.3))
LIGHT = Machine(spring=0.1, mass=None, damping=0.0, velocity=0.1)
# beyond critical damping; a slip takes 0.29 units of time, and its contacts come back after it
HEAVY = replace(LIGHT, mass=1e-5, damping=4e-3)
KNOWN = RigidSlider(0.8669, 0.7312, 1e-9, 0.4165, 1.01)
# of infinitely many of them without a mass, whose contacts form again after a slip: see the slow test
BEFORE, PERIOD = 0.94231, 10.7202


def of_many(**named: Any) -> Behaviour:
    """What infinitely many contacts do."""
    told: dict[str, Any] = {"error": 5e-5, "success": True, "message": "", "run_time": 0.0}
    told |= {"kind": "stick-slip", "before": BEFORE, "after": 0.0, "period": PERIOD, "slips": 5}
    return Behaviour(rule="mass", **(told | named))


@pytest.mark.slow  # quick: such contacts in place of infinitely many, below
def test_contacts_of_the_area_grow_as_they_are_followed_beside_a_mass() -> None:
    """A slip of a light, overdamped mass is one without a mass, but for the 0.29 units of time that it takes: the drive
    goes on by 0.03 then, in which the contacts that it broke wait already."""
    found = follow_finite(HEAVY, GROWING, 4000, of_many(), KNOWN.static, 1e4)
    assert (found.kind, found.contacts, found.message) == ("stick-slip", 4000, "")
    assert found.slips >= 8.0
    assert abs(found.before - BEFORE) < 4.0 * found.before_error < 0.06
    gone_on = HEAVY.velocity * slip_duration(HEAVY, BEFORE)
    assert gone_on == pytest.approx(0.03, abs=5e-3)
    assert abs(found.period - (PERIOD - gone_on)) < 4.0 * found.period_error < 0.15
    assert abs(found.after) < 0.02


def test_growing_contacts_are_pulled_beyond_the_static_force_of_a_rigid_slider() -> None:
    """Where nobody knows what infinitely many do: they bear more on a slider that sticks, and it had not slipped when
    the path ended."""
    law = strengthening(gaussian(1.0, 0.2), beta=0.1, time=1e-2)
    slow = Contacts(law, delay=Delay(1.0))
    machine = Machine(spring=3e-3, mass=3e-6, damping=9e-5, velocity=0.1)
    static = master.propensity(slow, velocity=0.1).static_to_kinetic
    static *= master.steady_state(slow, velocity=0.1).force
    nobody = of_many(kind="undecided", before=np.nan, after=np.nan, period=None, slips=0)
    found = follow_finite(machine, slow, 4000, nobody, static, 1e4)
    assert found.message != NOT_SLID and found.slips > 0.0
    assert found.before > 1.2 * static


@pytest.mark.slow  # some 35 s; quick: the test before, against the numbers of this one
def test_infinitely_many_growing_contacts_slip_so_without_a_mass() -> None:
    steady = master.steady_state(GROWING, velocity=LIGHT.velocity)
    assert steady.force == pytest.approx(KNOWN.kinetic, abs=1e-3)
    told = follow(LIGHT, GROWING, "reform-after", KNOWN, 1e4)
    assert told.kind == "stick-slip" and told.error < TOLERANCE_IN_TIME
    assert told.before == pytest.approx(BEFORE, abs=2.0 * told.error + 1e-5)
    assert told.period == pytest.approx(PERIOD, abs=1e-3)


@pytest.mark.parametrize("number", [1500, slow(4000)])
def test_growing_contacts_are_followed_in_place_of_infinitely_many(
    number: int, monkeypatch: Any
) -> None:
    """Where the master equation takes no such slider; with heat beside them, too, by which they slip from less."""

    monkeypatch.setattr(master, "solve", raising(InputError("mass: takes 8001 steps")))
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.CONTACTS", number)
    waiting = GROWING.replace(delay=Delay(1.0))
    told = follow(HEAVY, waiting, "mass", KNOWN, 1e4)
    assert told.kind == "stick-slip" and told.contacts == number
    assert abs(told.before - BEFORE) < 4.0 * told.error + 0.01
    hot = waiting.replace(thermal=Thermal("soft", 0.05, 100.0))
    if number == 4000:  # of fewer contacts the error is as large as what heat takes
        warm = follow(HEAVY, hot, "mass", KNOWN, 1e4)
        assert warm.kind == "stick-slip" and warm.contacts == number
        assert warm.before + 3.0 * warm.error < told.before
    assert may_follow(HEAVY, waiting, "mass", KNOWN)
    assert may_follow(HEAVY, hot, "mass", KNOWN)
    ageing = waiting.replace(thresholds=gaussian(1.0, 0.2), ageing=Ageing(gaussian(1.0, 0.3), 1.0))
    assert not may_follow(HEAVY, ageing, "mass", KNOWN)
    assert not may_follow(LIGHT, GROWING, "reset", KNOWN)


def test_fewer_contacts_that_are_late_cost_no_verdict(monkeypatch: Any) -> None:
    """By a thousand it is told how much earlier the others slip than infinitely many. Where they are not followed in
    time the others' own force bounds that; their refusal ended the whole verdict."""

    def late(machine: Any, contacts: Any, rule: str, path: Any, number: int, *rest: Any) -> Any:
        if number == PILOT:
            raise InputError("1,000 contacts take more than 2 s: raise wall_time")
        return sliders(machine, contacts, rule, path, number, *rest)

    monkeypatch.setattr(master, "solve", raising(InputError("mass: takes 8001 steps")))
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.CONTACTS", 4000)
    monkeypatch.setattr("toolkit.verdict.sliders.ensemble.sliders", late)
    told = follow(HEAVY, GROWING.replace(delay=Delay(1.0)), "mass", KNOWN, 1e4)
    assert told.kind == "stick-slip" and told.contacts == 4000
    assert abs(told.before - BEFORE) < told.error + 0.01


def test_breaks_of_growing_contacts_are_counted_as_the_dear_ones_they_are(monkeypatch: Any) -> None:
    """Fewer are followed than of others, and none where a pilot says that no more can be than are known already."""
    cold = Contacts(gaussian(1.0, 0.3))
    assert most_breaks(GROWING, "mass") == MOST_BREAKS_IN_TIME < most_breaks(GROWING, "reset")
    assert most_breaks(GROWING, "reset") < most_breaks(cold, "mass")
    path, asked = np.linspace(0.0, 30.0, 5), list[int]()
    pilot = eq_model.simulate(
        GROWING, path, n_contacts=PILOT, n_replicas=4, seed=1, **HEAVY.keywords("mass")
    )
    monkeypatch.setattr(
        "toolkit.verdict.sliders.budget.MOST_BREAKS_IN_TIME", 4.5 * float(pilot.breaks)
    )
    for known in (0, 2000):
        found = sliders(HEAVY, GROWING, "mass", path, 20_000, 1e4, known=known)
        asked.append(found.contacts // 4)
    assert asked == [4000, 4000]
    with pytest.raises(InputError, match="20,000 contacts break some"):
        sliders(HEAVY, GROWING, "mass", path, 20_000, 1e4, known=4000)
