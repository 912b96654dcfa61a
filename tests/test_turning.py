"""Paths that turn round: exact hysteresis, closed forms after one and two turns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from scipy.special import ndtr
from solving import held_to_claim, through

import eq_model
import master
import origins
from master.motion import Motion
from master.paper.explicit import explicit_loop
from master.renewal.births import Births
from master.renewal.few_times import FewTimes
from master.renewal.present import TARGETS
from master.survival.make import life_of
from origins import Contacts, Delay, Thermal, gaussian
from origins.start import SingleStart
from toolkit.stability.drawn import drawn

TURNS = [0.0, 2.35, -1.7, 0.6, -0.2, 0.45, -3.1, 1.0, -1.0]


def walk(start: float, path: np.ndarray, threshold: float) -> np.ndarray:
    """One contact whose every threshold is the same."""
    x, at, out = start, 0.0, []
    for position in path:
        x, at = x + position - at, position
        while abs(x) >= threshold - 1e-12:
            x -= np.sign(x) * threshold
        out.append(x)
    return np.array(out)


@pytest.mark.parametrize("start", [slow(0.3), -0.4])
def test_identical_thresholds_are_a_polygon(start):
    path = through(TURNS, 37)
    solution = master.solve(origins.Contacts(origins.identical(1.0), start), path, 1e-9)
    assert solution.success
    assert np.abs(solution.force - walk(start, path, 1.0)).max() <= 1e-12


@pytest.mark.parametrize("step", [0.2, 0.7])
def test_legs_on_which_a_contact_seldom_breaks(step: float) -> None:
    """The ensemble goes from leg to leg by what the slider reaches on them, not by all that it passes."""
    path = step * np.cumsum(np.random.default_rng(2).normal(size=400))
    found = eq_model.simulate(Contacts(origins.identical(1.0), 0.3), path, n_contacts=1)
    assert np.abs(found.force - walk(0.3, path, 1.0)).max() < 1e-9 and found.breaks > 5


def test_turns_that_fall_on_breaks():
    path = np.array([0.0, 0.5, 1.0, 0.5, 0.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 1.0, 0.0, -1.0, -2.0])
    solution = master.solve(origins.Contacts(origins.identical(1.0)), path, 1e-9)
    expected = [0, 0.5, 0, -0.5, 0, 0, 0.5, 0, 0.5, 0, 0, 0, 0, 0, 0]
    assert np.abs(solution.force - expected).max() <= 1e-12


def test_rectangular_thresholds_after_one_turn():
    # births at 0.5 < Y < 0.9 break at -x once Y - X > 0.5, and what they leave not before y = 1
    y = np.linspace(0.0, 1.0, 101)
    turned = 0.9 * 0.6 + 0.5 * 0.4**2
    low = np.clip(1.4 - y, 0.5, 0.9)
    released = ((y**3 - (y - 0.9 + low) ** 3) / 3.0 - 0.25 * (0.9 - low)) / 2.0
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5))
    held_to_claim(contacts, 0.9 - y, 1e-10, turned - y + released)


def test_gaussian_thresholds_after_one_turn():
    # broken once, at Y, then at -x_s again, where X = Y - x_s: two Gaussians, until the third break
    std, path = 0.05, np.linspace(1.4, -0.35, 176)
    z = path / (std * np.sqrt(2.0))
    exact = path - 1.0 + ndtr(-z) - std / np.sqrt(2.0) * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    held_to_claim(origins.Contacts(origins.gaussian(1.0, std)), path, 1e-10, exact)


def test_exponential_thresholds_break_again_and_again_after_two_turns():
    """P_c = e^-x: births are f + integral of f. From relaxed: b = 1; after a turn at L b_1 = 1 - e^(-y/2), y < 2L;
    after another at L - T, for y < T, only what was born on the way back has been through nothing worse."""
    first, second = 1.7, 2.4
    nodes, weights = np.polynomial.legendre.leggauss(26)

    def integral(function: Callable, end: np.ndarray) -> np.ndarray:
        s = 0.5 * end[..., None] * (nodes + 1.0)
        return 0.5 * end * (function(s) * weights).sum(-1)

    def born(y: np.ndarray) -> np.ndarray:
        return 1.0 - np.exp(-0.5 * y)

    def flux(y: np.ndarray, kept: Callable, power: int) -> np.ndarray:
        def share(a: np.ndarray) -> np.ndarray:
            return kept(a) * (y[..., None] - a) ** power * np.exp(a - y[..., None])

        return integral(share, 0.5 * y)

    def again(y: np.ndarray, births: Callable) -> np.ndarray:
        return integral(lambda s: births(y[..., None] - s) * s * np.exp(-s), y)

    def fresh(a: np.ndarray) -> np.ndarray:
        return np.ones(a.shape)

    def back(a: np.ndarray) -> np.ndarray:
        return born(second - a)

    def born_last(y: np.ndarray) -> np.ndarray:
        return flux(y, back, 0) + integral(lambda s: flux(s, back, 0), y)

    y = np.linspace(0.3, second, 5)
    down = integral(lambda s: flux(s, fresh, 1) + again(s, born), y) - y - np.expm1(-first)
    up = down[-1] + y - integral(lambda s: flux(s, back, 1) + again(s, born_last), y)
    path = np.concatenate([[first], first - y, first - second + y])
    exact = np.concatenate([[-np.expm1(-first)], down, up])
    held_to_claim(origins.Contacts(scipy.stats.expon()), path, 1e-10, exact)


WIDE = gaussian(1.0, 0.2)


def test_the_paper_closure_forgets_after_a_turn() -> None:
    """At next to no rate it is App. C, whose plain scheme is of first order."""
    path = through([0.0, 0.9, -0.9], 10)
    contacts = Contacts(WIDE, thermal=Thermal("soft", 0.1, 1e-12, closure="paper"))
    solved = master.solve(contacts, path, 1e-4)
    coarse, fine = (explicit_loop(Contacts(WIDE), path, step).force for step in (2e-3, 1e-3))
    assert solved.success and np.abs(solved.force - (2.0 * fine - coarse)).max() < 2e-4


@pytest.mark.parametrize(
    ("laws", "time", "digits"),
    [
        ({"delay": origins.Delay(0.3)}, [1e-3, 2.05e-3, 1e15], 1e-12),
        ({"delay": origins.Delay(1e-3)}, [1e-3, 1e-3 * (2.0 + 8e-8), 1e5], 1e-12),
        slow({"thermal": Thermal("soft", 0.1)}, [1e-3, 2.005e-3, 1e10], 1e-7),
    ],
)
def test_a_rest_changes_nothing_before_it(laws: dict, time: list[float], digits: float) -> None:
    """Speeds that differ little are two legs, however long the time is that follows and its rounding."""
    contacts, path = Contacts(gaussian(1.0, 0.2), **laws), [0.5, 1.0, 1.0]
    alone = master.solve(contacts, path[:2], 1e-9, time=time[:2])
    found = master.solve(contacts, path, 1e-7, time=time)
    assert found.success and np.abs(found.force[:2] - alone.force).max() < digits


def test_a_first_leg_of_no_time_to_speak_of_is_followed() -> None:
    """As slid at once: F is that of T = 0, and the rest as after any first leg that is quick."""
    warm = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1))
    quick, slower = (master.solve(warm, [1.0, 2.0], time=[t, 1.0]).force for t in (1e-20, 1e-12))
    assert np.abs(quick - slower).max() < 1e-9 and abs(quick[0] - 0.57969) < 1e-5


def test_births_that_rounding_puts_just_before_a_turn_belong_to_the_leg_behind_it() -> None:
    """Births of the breaks from 0.7 on begin at 1.05, where the slider turns, but 0.7 + 0.35 < 1.05 by rounding. They
    are all births of the leg behind it, on one panel. A delay longer by 1e-9 is rounded otherwise."""
    assert 0.7 + 0.35 < 1.05
    times, path = [1.0, 1.05, 1.35, 2.35], [1.0, 0.975, 1.2, 2.2]
    one, other = (
        master.solve(Contacts(gaussian(1.0, 0.2), delay=Delay(delay)), path, 1e-7, time=times)
        for delay in (0.35, 0.35 + 1e-9)
    )
    assert one.success and other.success, one.message
    assert np.abs(one.force - other.force).max() < 1e-8


@pytest.mark.parametrize("power", [3, 4, 6])
def test_sums_at_few_times_tell_how_far_the_cubic_through_them_is_off(power: int) -> None:
    """Number and force that go as powers of the time on a panel, at all its times and at six of them; where the force
    alone is off, the share of the contacts that is told gives its error by the longest stretch on the motion."""
    life = life_of(Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1)))
    longest = 0.05
    motion = Motion.along(np.array([0.0, longest]))
    births = Births(life, SingleStart(0.0), motion, longest_stretch=longest)
    for number in (1.0, 0.0):
        true = np.array([number * TARGETS**power, -0.04 * TARGETS**power])[:, None, :]
        both, error = FewTimes(births).interpolated(true[..., list(FewTimes.ASKED)])
        off = np.abs(both - true).max(axis=(1, 2)) / [1.0, longest]
        worst = float(off.max())
        assert worst < 1e-15 if power == 3 else 1e-3 < worst <= error < 10.0 * worst


@pytest.mark.slow  # quick: above, what the sums tell
def test_a_short_path_of_contacts_whose_thresholds_reach_far_is_as_good_as_it_claims() -> None:
    """Stretches of 0.9 mean thresholds, and thresholds up to 13: by these the error of the force between few times was
    made a share of the contacts, and was twice what was claimed."""
    case = drawn(1, 528)
    contacts = case.contacts()
    path = np.asarray(case.path) * contacts.mean_threshold
    fine = master.solve(contacts, path, 1e-3 * case.tolerance, **case.drive)
    held_to_claim(contacts, path, case.tolerance, fine, **case.drive)
