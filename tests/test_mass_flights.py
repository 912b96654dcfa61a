"""A slider with mass whose contacts wait for longer than a slip lasts: it flies on its spring alone, without steps."""

from typing import Any

import numpy as np
import pytest
import scipy.stats as st
from conftest import slow

import master
import origins
from master.outcome import unheard
from master.soft.inertia.in_time.flights import PARTS_LEFT, Bounds, Formed
from master.soft.inertia.in_time.refining import HeavyFound, follow_in_steps
from origins import Contacts, Delay, Drive, Thermal
from origins.errors import InputError

EYRING = Thermal("eyring", width=0.03, attempt_frequency=1e3)
# contacts come back 30 after they broke, where a slip of the first machine takes 4.5
WAITING = Contacts(origins.gaussian(1.0, 0.2), delay=Delay(30.0))
SOFT = {"spring": 1e-3, "mass": 1e-3, "damping": 6e-4, "velocity": 1.0}


def in_steps(contacts: Contacts, path: np.ndarray, machine: dict[str, float]) -> HeavyFound:
    """The slider in steps of time and flights, also of cold contacts, which master.solve follows otherwise."""
    return follow_in_steps(contacts, Drive(path, **machine), 1e-2, unheard, np.inf)


FIRST = 683.9  # X_T at which the first machine slips, which lasts up to 688.4


def points_beside_a_slip(first: float) -> np.ndarray:
    """Points of a path up to a slip at X_T = first, in it, and behind it."""
    return np.append(np.linspace(0.0, 0.97 * first, 6)[1:], first + np.array([0.3, 1.0, 2.0, 5.0]))


@pytest.fixture(scope="module")
def both_roads() -> tuple[Any, HeavyFound]:
    """The first machine past its slip, by collocation and in steps."""
    path = np.append(points_beside_a_slip(FIRST), 690.0)
    return master.solve(WAITING, path, 1e-4, **SOFT), in_steps(WAITING, path, SOFT)


def test_a_slip_is_that_of_the_road_at_no_temperature(both_roads: tuple[Any, HeavyFound]) -> None:
    """Without heat the slider is followed by collocation, too: forces, duration and top speed of a slip of 700 <x_s>,
    and the energies, before it and behind."""
    exact, found = both_roads
    ours, theirs = found.followed.slips, exact.slips
    assert exact.slips.drive_error < 1e-3 and found.followed.error_of_force_and_load <= 1e-2
    assert ours.drive.size == theirs.drive.size == 1
    for name in ("force_before", "force_after"):
        assert np.abs(getattr(ours, name) - getattr(theirs, name)).max() < 1e-3
    # the time in which the slider gets fast, which bounds it, is a tenth of the slip; it is known far better
    assert np.abs(ours.duration - theirs.duration).max() < 1e-3 < ours.duration_error < 0.7
    assert ours.top_speed == pytest.approx(theirs.top_speed, rel=2e-3)
    beside = (exact.path < FIRST) | (exact.path == 690.0)
    for mine, other in (
        (found.columns["work"], exact.energy.drive),
        (found.columns["damped"], exact.energy.damped),
    ):
        np.testing.assert_allclose(
            mine[beside], other[beside], atol=3e-3 * exact.energy.drive.max()
        )


@pytest.mark.slow
def test_in_heat_a_slip_leads_far_beyond_the_drive_and_back() -> None:
    """On a spring of 1e-4 N_c<k> the flight is that of an oscillator from rest at the force before the slip: its
    duration, top speed and the force after it in closed form, but for the few thresholds along which contacts let go
    at first."""
    spring = mass = 1e-4
    contacts = WAITING.replace(thermal=EYRING, delay=Delay(50.0))
    machine = {"spring": spring, "mass": mass, "damping": 6e-5, "velocity": 1.0}
    found = master.solve(contacts, np.linspace(0.0, 4550.0, 92)[1:], 5e-2, **machine)
    assert found.slips.drive.size == 1
    before = float(found.slips.force_before[0])
    half = 0.5 * machine["damping"] / mass
    swing = (spring / mass - half**2) ** 0.5
    after = -before * np.exp(-half * np.pi / swing)
    assert found.slips.force_after[0] == pytest.approx(after, abs=1e-3)
    # 0.07 are gone before the slider is fast
    assert found.slips.duration[0] == pytest.approx(np.pi / swing + 0.07, abs=0.03)
    at_top = np.arctan2(swing, half) / swing
    top = before / spring * (spring / mass) ** 0.5 * np.exp(-half * at_top)
    assert found.slips.top_speed[0] == pytest.approx(top, rel=2e-3)


def test_bounds_on_contacts_that_hold_are_bounds() -> None:
    """Contacts that form evenly along random ways there and back: the share that holds at the end, and the force that
    they bear, by sums over their own largest stretches, and the bounds above them, of few instants."""
    law, rng = origins.gaussian(1.0, 0.2), np.random.default_rng(5)
    bounds = Bounds(law.sf, 1.0, 3.0)
    for _ in range(20):
        turns = np.cumsum(rng.normal(0.0, 2.0, 6))
        fine = np.interp(np.linspace(0.0, 5.0, 2401), np.arange(6), turns)
        births = rng.uniform(0.0, 1.0, 2400)
        most = np.maximum.accumulate(fine[::-1])[::-1]
        least = np.minimum.accumulate(fine[::-1])[::-1]
        place = 0.5 * (fine[1:] + fine[:-1])
        largest = np.maximum(most[1:] - place, place - least[1:])
        held = births * law.sf(largest)
        some = slice(None, None, 8)
        grouped = np.append(0.0, births.reshape(-1, 8).sum(axis=1))
        formed = Formed(np.linspace(0.0, 5.0, 301), fine[some], grouped)
        bound = bounds.of(formed.births, formed.furthest())
        assert bound.holding >= held.sum()
        assert bound.force >= float(held @ np.abs(fine[-1] - place))
        assert formed.holding(law.sf) == pytest.approx(held.sum(), rel=0.03, abs=0.5)


@pytest.mark.parametrize("damped", [0.01, 0.03, 0.1])
def test_bounds_on_contacts_that_hold_are_bounds_along_a_long_ringing(damped: float) -> None:
    """More instants than are looked back on: those of older ones, born anywhere on the way, count by its range alone.
    They held as little as a half of what does. Swings of 20 to 0.3 about 20, with births even in time."""
    law = origins.gaussian(1.0, 0.2)
    bounds = Bounds(law.sf, 1.0, 3.0)

    def travel(phase: np.ndarray) -> np.ndarray:
        return 20.0 * (1.0 - np.exp(-damped * phase) * np.cos(phase))

    formed = Formed(np.zeros(1), np.zeros(1), np.zeros(1))
    for node, begin in enumerate(np.arange(0.0, 4.2 / damped, 0.15)):
        new = -0.15 * np.diff(PARTS_LEFT, prepend=1.0)
        instants = begin + 0.15 * (1.0 - PARTS_LEFT)
        formed = formed.and_then(Formed(instants, travel(instants), new))
        if node % 7:
            continue
        way = travel(np.linspace(0.0, begin + 0.15, 10 * node + 11))
        most, least = (each.accumulate(way[::-1])[::-1] for each in (np.maximum, np.minimum))
        place = 0.5 * (way[1:] + way[:-1])
        held = 0.015 * law.sf(np.maximum(most[1:] - place, place - least[1:]))
        bound = bounds.of(formed.births, formed.furthest())
        assert bound.holding >= held.sum()
        assert bound.force >= float(held @ np.abs(way[-1] - place))


@pytest.mark.slow  # quick: the slips at no temperature, above and below
def test_a_flight_ends_where_its_contacts_return_to_the_last_digit_of_the_time() -> None:
    """An interval was left that was lost in the digits of the time, on which births jumped: a fault of the program."""
    contacts = WAITING.replace(thermal=EYRING, delay=Delay(60.0))
    machine = {"spring": 1e-8, "mass": 1e-8, "damping": 6e-9, "velocity": 1e4}
    found = master.solve(contacts, np.linspace(0.0, 0.46e8, 5)[1:], 5e-2, **machine)
    assert found.slips.drive.size == 1 and np.isfinite(found.force_error)
    assert "fault" not in found.message


def test_a_stretched_contact_that_holds_counts_by_its_force() -> None:
    """A few contacts of a wide law hold far beyond the mean threshold: by their share times that, they bore a
    fraction of what they do."""
    law = st.lognorm(1.0)
    bounds = Bounds(law.sf, float(law.mean()), float(law.isf(1e-18)))
    far = 30.0
    bound = bounds.of(np.ones(1), np.array([far]))
    assert bound.force >= far * law.sf(far) > 10.0 * law.mean() * law.sf(far)
    # one that has just formed may bear any y S(y) ahead, met here to the mesh
    ahead = np.geomspace(0.1, 20.0, 4000)
    most = float((ahead * law.sf(ahead)).max())
    assert most <= bounds.of(np.ones(1), np.zeros(1)).force <= 1.02 * most


def test_beside_a_slip_the_error_is_as_large_as_its_fall(
    both_roads: tuple[Any, HeavyFound],
) -> None:
    """When the slip comes is known to its error in X_T; a point in between may lie before the slip or behind it."""
    exact, followed = both_roads[0], both_roads[1].followed
    assert FIRST - 5.0 < exact.slips.drive[0] < FIRST + 5.0
    off = np.abs(followed.force - exact.force).max()
    assert off <= followed.force_error and followed.force_error > 0.5
    assert np.abs(followed.holding - exact.holding).max() <= followed.holding_error
    # slips are known all the same
    assert followed.error_of_force_and_load <= 1e-2
    assert abs(followed.slips.drive[0] - exact.slips.drive[0]) <= followed.slips.drive_error


@pytest.mark.slow  # quick: the slip before their return, above
def test_contacts_that_come_back_are_back_at_once_beside_the_time_from_slip_to_slip() -> None:
    """One step led from a slip at 684 over their return at 714 far beyond: read in its middle half of them were still
    out, and 10,000 steps were taken for what 1,700 tell."""
    path = np.array([600.0, 720.0, 760.0, 800.0])
    exact, followed = (
        master.solve(WAITING, path, 1e-4, **SOFT),
        in_steps(WAITING, path, SOFT).followed,
    )
    assert np.abs(followed.holding - exact.holding).max() <= followed.holding_error <= 1e-2
    assert followed.error_of_force_and_load <= 1e-2 and followed.nodes < 3000


def test_attempts_quicker_than_the_last_digit_of_the_time_are_followed() -> None:
    """At 1e13 attempts per time their first ones are lost in the digits of the time: steps took none, and ended in a
    division by it. A slider without mass sticks as well."""
    contacts = WAITING.replace(thermal=Thermal("eyring", width=0.01, attempt_frequency=1e13))
    path, spring = np.array([100.0, 300.0, 400.0]), {"spring": 1e-3, "velocity": 1.0}
    heavy = master.solve(contacts, path, 1e-2, **SOFT)
    light = master.solve(contacts, path, 1e-2, slip="reset", **spring)
    assert heavy.success and light.success
    assert np.abs(heavy.force - light.force).max() <= heavy.force_error + light.force_error


@pytest.mark.slow  # quick: points beside a slip, below
def test_a_regime_hangs_on_slips_and_not_on_points_of_the_path_within_one() -> None:
    """At T = 0, where the second slip begins at 1379563 and lasts for 3: two runs with points in it were 0.7 apart, and
    neither force nor slips were known."""
    contacts = WAITING.replace(delay=Delay(60.0))
    machine = {"spring": 1e-6, "mass": 1e-6, "damping": 6e-7, "velocity": 1.0}
    path = np.array([5e5, 1379567.0, 1379568.0, 2.9e6])
    exact, found = (
        master.solve(contacts, path, tolerance, **machine) for tolerance in (1e-4, 3e-2)
    )
    assert found.regime.verdict == exact.regime.verdict == "stick-slip"
    assert np.abs(found.slips.drive - exact.slips.drive).max() <= found.slips.drive_error < 1e4
    assert not found.success and "farther from slips" in found.message
    assert np.abs(found.force - exact.force).max() <= found.force_error


@pytest.mark.slow  # quick: one without a law in time that fades, in test_mass_master.py
def test_the_end_of_a_slip_that_does_not_swing_is_not_known() -> None:
    """It comes to rest as its drive overtakes it, which hangs on the last digits of the force: no duration is told."""
    machine = SOFT | {"damping": 1.5 * 2.0 * 1e-3}
    drive = Drive(np.array([360.0, 720.0]), **machine)
    found = follow_in_steps(WAITING, drive, 1e-1, unheard, np.inf)
    assert found.followed.slips.drive.size == 1 and np.isinf(found.followed.slips.duration_error)
    # contacts come back from 714 on
    assert found.followed.nodes < 3000


@pytest.mark.parametrize("end", [683.0, slow(683.8)])
def test_a_path_that_ends_where_a_slip_may_begin_tells_so(end: float) -> None:
    """It begins at 683.86, and in steps half a length before: at 683.8 they were 0.04 off, and told 5e-5."""
    path = np.array([300.0, 600.0, end])
    exact, followed = (
        master.solve(WAITING, path, 1e-5, **SOFT),
        in_steps(WAITING, path, SOFT).followed,
    )
    assert np.abs(followed.force - exact.force).max() <= followed.force_error
    assert np.abs(followed.holding - exact.holding).max() <= followed.holding_error
    assert (followed.force_error > 0.5) == (end == 683.8)


@pytest.mark.slow
def test_a_path_of_two_speeds_is_told_that_one_would_be_followed() -> None:
    """Beside an end sooner, which leads nowhere near a slip; not where contacts come back before."""
    machine = {"spring": 1e-4, "mass": 1e-4, "damping": 6e-5}
    path, time = np.array([1000.0, 8000.0]), np.array([1000.0, 15000.0])
    for delay, told in (
        (50.0, "drive at one speed"),
        (5.0, "or take a slip rule, or eq_model.simulate"),
    ):
        contacts = WAITING.replace(delay=Delay(delay), thermal=EYRING)
        with pytest.raises(InputError, match=told):
            master.solve(contacts, path, 5e-2, time=time, **machine)
