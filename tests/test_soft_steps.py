"""A soft slider in steps of time: what strands remember, the order of the steps, how a solution ends."""

from typing import Any

import numpy as np
import pytest
from rate_laws import Tilted

import master
from master.lives.heat.thermal import ThermalLife
from master.motion.motion import Motion
from master.soft.in_time.carried import Allowed
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.make import memory_of
from master.soft.in_time.memory import Memory
from master.soft.in_time.pulled import Pulled, Task
from master.soft.in_time.solution import solve_in_time
from master.soft.in_time.track import pieces
from origins import (
    Ageing,
    Contacts,
    Drive,
    Thermal,
    gaussian,
    gaussian_start,
    growing_grains,
    identical,
    mixture,
    rectangular,
)
from origins.start import SingleStart

WIDE = gaussian(1.0, 0.2)
MIXED = mixture([identical(0.8), WIDE], [0.3, 0.7])
# forward, a hold, on, back, a hold, far forward
PLACES = np.concatenate(
    [
        np.linspace(0.0, 0.9, 10),
        [0.9],
        np.linspace(0.95, 1.3, 7),
        np.linspace(1.2, 0.2, 8),
        [0.2],
        np.linspace(0.3, 1.9, 13),
    ]
)
KEPT = {
    "soft": Contacts(WIDE, thermal=Thermal("soft", 0.05)),
    "one value, soft": Contacts(MIXED, thermal=Thermal("soft", 0.05, 10.0)),
    "stiff": Contacts(WIDE, thermal=Thermal("stiff", 0.05)),
    "stiff, cold": Contacts(WIDE, thermal=Thermal("stiff", 0.005, 1e3)),
    "stiff, jumps": Contacts(rectangular(0.5, 1.5), thermal=Thermal("stiff", 0.05)),
    "one value, stiff": Contacts(MIXED, thermal=Thermal("stiff", 0.05, 10.0)),
    "linked": Contacts(WIDE, thermal=Thermal("soft", 0.05), stiffness="linked"),
    "a law of the test's own": Contacts(WIDE, thermal=Tilted(0.05)),
}


def off_a_replay(contacts: Contacts, memory: Memory) -> float:
    """How far off strands are, at most, from what a replay of all their moves tells."""
    exact = ThermalLife(contacts)
    cohorts = Cohorts.of(contacts, memory, 0)
    rng = np.random.default_rng(1)
    lasts = np.where(np.diff(PLACES) == 0.0, 5.0, rng.uniform(0.03, 0.3, PLACES.size - 1))
    times = np.append(0.0, np.cumsum(lasts))
    off = []
    for k in range(1, PLACES.size):
        cohorts = cohorts.born(0.0).advance(PLACES[k] - PLACES[k - 1], lasts[k - 1])
        motion, born = Motion(times[: k + 1], PLACES[: k + 1]), times[:k, None]
        told = exact.left(SingleStart(0.0), motion.history(np.full((k, 1), times[k]), born))
        off.append(np.abs(cohorts.left[:, 1:] - told[:, :, 0]).max())
    return float(max(off))


@pytest.mark.parametrize("name", KEPT)
def test_strands_remember_what_a_replay_of_all_moves_tells(name: str) -> None:
    contacts = KEPT[name]
    coarse, fine = (memory_of(contacts, level, 1.0) for level in (1, 4))
    off = off_a_replay(contacts, fine)
    if coarse.error:
        assert off < coarse.error + 1e-11
        return
    # errors of cells fall as the square, or the power 3/2 where rates have a root at the threshold
    assert off < 5e-4 and off < off_a_replay(contacts, coarse) / 8.0


ORDERS: dict[str, tuple[Contacts, float]] = {
    "soft": (Contacts(WIDE, thermal=Thermal("soft", 0.1)), 2.0),
    "stiff": (Contacts(WIDE, -0.3, thermal=Thermal("stiff", 0.1)), 2.0),
    "growing grains": (Contacts(growing_grains(1.0, 1.0, age=4.0)), 1.0),
}


@pytest.mark.parametrize("name", ORDERS)
def test_second_order_in_the_step(name: str) -> None:
    contacts, spring = ORDERS[name]
    balance = contacts.start.mean() / spring
    drive = Drive(np.array([balance, balance + 1.6]), spring=spring)
    told: list[Any] = []
    # the first finds how long the way is, in steps, for the others
    for level in range(2, 6):
        start, again = (
            Cohorts.of(contacts, memory_of(contacts, 3, 1.0), 3, reset) for reset in (False, True)
        )
        task = Task(
            pieces(drive, balance), spring, "reset", contacts.waiting_time, 1.0, again, 1e-10
        )
        plan = told[-1][1] if told else []
        pulled = Pulled(start, task, level, plan, Allowed(1e4, 1e9))
        pulled.run()
        assert not pulled.slips
        told.append((pulled.contacts.force, pulled.stretches))
    change = np.abs(np.diff([force for force, _ in told[1:]]))
    assert np.abs(np.log2(change[:-1] / change[1:]) - 2.0).max() < 0.2, change


@pytest.mark.parametrize("rule", ["reset", "instant", "reform-after"])
def test_steps_find_what_panels_of_the_way_find(rule: Any) -> None:
    """At T = 0, with turns: two roads to one answer."""
    back = np.concatenate([np.linspace(0.0, 4.0, 21), np.linspace(3.8, 1.0, 15), [2.0, 3.0]])
    contacts = Contacts(WIDE, gaussian_start(0.05, 0.03))
    exact = master.solve(contacts, back, 1e-9, spring=0.3, slip=rule)
    found = solve_in_time(contacts, Drive(back, spring=0.3, slip=rule), 1e-4)
    assert exact.success and found.success and exact.slips.drive.size == found.slips.drive.size > 0
    assert np.abs(found.force - exact.force).max() <= found.force_error
    assert np.abs(found.slips.drive - exact.slips.drive).max() <= found.slips.drive_error


def test_contacts_that_re_form_behind_are_followed_through_turns() -> None:
    """One by one they come back to their largest |x|: by steps, which panels do not resolve."""
    back = np.concatenate([np.linspace(0.0, 4.0, 21), np.linspace(3.8, 1.0, 15), [2.0, 3.0]])
    coarse, fine = (
        master.solve(Contacts(WIDE, reforming=-0.1), back, tolerance, spring=0.2)
        for tolerance in (1e-3, 1e-6)
    )
    assert coarse.success and fine.success and fine.force_error < 1e-6
    assert np.abs(coarse.force - fine.force).max() <= coarse.force_error + fine.force_error


BOUNDED: dict[str, tuple[Contacts, dict[str, Any]]] = {
    "soft, instant": (Contacts(WIDE, thermal=Thermal("soft", 0.05)), {"slip": "instant"}),
    "stiff": (Contacts(WIDE, thermal=Thermal("stiff", 0.05)), {}),
    "own law": (Contacts(WIDE, thermal=Tilted()), {"slip": "reform-after"}),
    "re-forming behind": (Contacts(WIDE, thermal=Tilted(), reforming=-0.1), {"slip": "instant"}),
    "linked": (Contacts(WIDE, thermal=Thermal("soft", 0.05), stiffness="linked"), {}),
    "grains": (Contacts(growing_grains(1.0, 1.0, age=4.0)), {"slip": "reform-after"}),
}


@pytest.mark.parametrize("name", BOUNDED)
def test_the_error_bounds_what_finer_steps_change(name: str) -> None:
    contacts, keywords = BOUNDED[name]
    path = np.linspace(0.0, 5.0, 101)
    rough, fine = (
        master.solve(contacts, path, tolerance, spring=0.3, **keywords)
        for tolerance in (1e-2, 1e-4)
    )
    assert rough.success and rough.slips.drive.size == fine.slips.drive.size
    slips, known = rough.slips, fine.slips
    apart = 0.3 * np.abs(slips.drive - known.drive).max(initial=0.0)
    bound = (rough.force_error + fine.force_error) * contacts.mean_threshold
    assert apart <= bound
    # points that the slip's own error takes to its other side are not told
    beside = np.abs(path[:, None] - known.drive).min(axis=1, initial=np.inf)
    told = beside > 2.0 * slips.drive_error
    assert told.sum() > 90
    assert np.abs(rough.force - fine.force)[told].max() <= bound


def test_a_solution_ends_with_what_it_has() -> None:
    """Counting steps, as times are no two machines' own: no time at all is over at the first."""
    contacts, path = Contacts(WIDE, thermal=Thermal("soft", 0.1)), np.linspace(0.0, 5.0, 51)
    cut = master.solve(contacts, path, 1e-3, spring=0.4, wall_time=1e-9)
    assert not cut.success and cut.path.size < path.size and "wall_time" in cut.message
    assert cut.force.size == cut.position.size == cut.holding.size == cut.path.size
    assert cut.regime.verdict == "undecided"
    aged = Contacts(WIDE, ageing=Ageing(gaussian(1.2, 0.1), 1e-2))
    assert not master.solve(aged, path, 1e-3, spring=0.4, wall_time=1e-9).success
