"""A mass that swings from its start on, on contacts that form at once: its swings are no stick-slip, as nothing feeds
them, and they were told as slips that go on for ever."""

import numpy as np
import pytest

import eq_model
import master
from master.soft.slips import Slips
from master.soft.unfed_swings import unfed_swings
from origins import Contacts, Delay, Thermal, gaussian, identical, mixture
from origins.drive import Drive

WIDE = Contacts(gaussian(1.0, 0.2))


def heavy(spring: float, part: float) -> dict[str, float]:
    """A mass of 1/K, whose swing has the time 2π/K and the force v at v = 1, with this part of critical damping."""
    return {"spring": spring, "mass": 1.0 / spring, "damping": 2.0 * part}


@pytest.mark.parametrize(
    ("spring", "part", "end", "says"),
    [
        (3.1, 0.0, 20.0, "without damping nothing ends them: give one"),
        (3.1, 1e-4, 20.0, "lessens them by e on each 3.23e+03 of the drive"),
        (10.4, 1e-4, 20.0, "lessens them by e on each 962 of the drive"),
        (0.05, 1e-4, 1000.0, "lessens them by e on each 2e+05 of the drive"),
    ],
)
def test_swings_of_the_start_are_no_stick_slip(
    spring: float, part: float, end: float, says: str
) -> None:
    """On springs above K* = 1.04 and below: each slip is one swing, all of one size."""
    found = master.solve(WIDE, np.linspace(0.1, end, 50), 1e-4, **heavy(spring, part))
    assert found.success and found.slips.drive.size > 5
    assert found.period == pytest.approx(2.0 * np.pi / spring, rel=0.01)
    assert found.regime.verdict == "undecided"
    assert "swings of the mass about F_k" in found.regime.reason and says in found.regime.reason


def test_swings_of_the_start_end_where_they_are_damped() -> None:
    """By single contacts: six time constants of the swing later none of 10,000 slips is left, and F is F_k and what the
    damping bears."""
    part, spring = 0.003, 3.1
    end = 6.0 / (part * spring)
    path = np.linspace(0.0, end, 2_000)
    given = {"n_contacts": 10_000, "seed": 1}
    found = eq_model.simulate(WIDE, path, **heavy(spring, part), **given)
    assert found.slips.drive.size > 10 and found.slips.drive.max() < 0.5 * end
    late = found.forces[:, path > 0.9 * end]
    assert late.mean() == pytest.approx(0.52 + 2.0 * part, abs=0.01) and np.ptp(late) < 0.1


@pytest.mark.parametrize(
    ("changed", "unfed"),
    [
        ({}, True),
        ({"delay": Delay(0.1)}, False),  # friction falls with the speed
        ({"thermal": Thermal("soft", 0.02, 1.0)}, False),
        ({"thresholds": identical(1.0)}, False),  # keep their order
        ({"spring": 0.9}, True),
        ({"spring": 0.9, "period": 7.4}, False),  # 6 % longer than a swing: it sticks in between
        ({"period": 7.4}, True),
    ],
)
def test_what_may_feed_a_swing_is_judged_by_its_slips(changed: dict, unfed: bool) -> None:
    given = {"spring": 1.1, "period": 2.0 * np.pi / changed.get("spring", 1.1)} | changed
    spring, period = given.pop("spring"), given.pop("period")
    drive, at = Drive([20.0], **heavy(spring, 0.0)), period * np.arange(5.0)
    slips = Slips(at, at, at + 1.0, 1.0 + 0.0 * at, 0.0 * at, 1e-6)
    found = unfed_swings(WIDE.replace(**given), drive, slips, 1.0, np.ones(1), None)
    assert bool(found) is unfed


TINY_WAIT = WIDE.replace(delay=Delay(1e-6))
FEW_EXACT = Contacts(mixture([gaussian(1.0, 0.2), identical(1.0)], [0.99, 0.01]))
THERE = np.linspace(0.1, 20.0, 50)


@pytest.mark.parametrize(
    ("contacts", "path", "more"),
    [
        pytest.param(TINY_WAIT, THERE, {}, id="a delay that feeds less than the damping takes"),
        pytest.param(FEW_EXACT, THERE, {}, id="few exact thresholds"),
        pytest.param(WIDE, np.append(THERE, 19.9), {}, id="a turn at the end"),
        pytest.param(WIDE, THERE, {"time": THERE}, id="times of the path"),
    ],
)
def test_swings_that_fade_as_their_damping_lets_them_are_no_stick_slip(
    contacts: Contacts, path: np.ndarray, more: dict
) -> None:
    """Other contacts, and other ways to give one drive, change no swing: its drop fades by 6.3e-4 a slip."""
    found = master.solve(contacts, path, 1e-4, **heavy(3.1, 1e-4), **more)
    assert found.success and found.regime.trend == pytest.approx(-6.3e-4, abs=2e-4)
    assert found.regime.verdict == "undecided"
    assert "swings of the mass about F_k" in found.regime.reason


def test_swings_whose_drop_stays_are_told_by_their_slips_where_contacts_may_feed_them() -> None:
    """A delay: with a trend of the damping they are swings, without one they may be fed."""
    drive, at = Drive([20.0], **heavy(1.1, 1e-4)), 2.0 * np.pi / 1.1 * np.arange(5.0)
    slips = Slips(at, at, at + 1.0, 1.0 + 0.0 * at, 0.0 * at, 1e-6)
    waits = WIDE.replace(delay=Delay(0.1))
    for trend, unfed in ((-6.3e-4, True), (-1e-4, False), (0.0, False), (None, False)):
        assert bool(unfed_swings(waits, drive, slips, 1.0, np.ones(1), trend)) is unfed
    # of two speeds, or slower than a swing, none is known to be free
    for speeds in (np.array([1.0, 0.5]), np.array([1.2])):
        assert not unfed_swings(waits, drive, slips, 1.0, speeds, -6.3e-4)
