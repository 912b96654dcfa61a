"""Paths that turn round: exact hysteresis, closed forms after one and two turns, a simulation, the paper's way."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
import scipy.stats
from scipy.special import ndtr

import master
import origins
from master.paper.explicit import explicit
from master.paper.explicit_loop import explicit_loop

TURNS = [0.0, 2.35, -1.7, 0.6, -0.2, 0.45, -3.1, 1.0, -1.0]


def through(turns: list[float], points: int = 37) -> np.ndarray:
    """A path from turn to turn, `points` to each straight piece."""
    return np.concatenate([turns[:1], *[np.linspace(a, b, points)[1:] for a, b in pairwise(turns)]])


def loop(amplitude: float, points: int = 41) -> np.ndarray:
    return through([0.0, amplitude, -amplitude, amplitude], points)


# -- exact answers -------------------------------------------------------------------------------------------------


def walk(start: float, path: np.ndarray, threshold: float) -> np.ndarray:
    """One contact whose every threshold is the same."""
    x, at, out = start, 0.0, []
    for position in path:
        x, at = x + position - at, position
        while abs(x) >= threshold - 1e-12:
            x -= np.sign(x) * threshold
        out.append(x)
    return np.array(out)


@pytest.mark.parametrize("start", [0.0, 0.3, -0.4])
def test_identical_thresholds_are_a_polygon(start):
    path = through(TURNS)
    solution = master.solve(origins.Contacts(origins.identical(1.0), start), path, 1e-9)
    assert solution.success
    assert np.abs(solution.force - walk(start, path, 1.0)).max() <= 1e-12


def test_turns_that_fall_on_breaks():
    path = np.array([0.0, 0.5, 1.0, 0.5, 0.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 1.0, 0.0, -1.0, -2.0])
    solution = master.solve(origins.Contacts(origins.identical(1.0)), path, 1e-9)
    assert np.abs(solution.force - [0, 0.5, 0, -0.5, 0, 0, 0.5, 0, 0.5, 0, 0, 0, 0, 0, 0]).max() <= 1e-12


def test_rectangular_thresholds_after_one_turn():
    # births at 0.5 < Y < 0.9 break at -x once Y - X > 0.5, and what they leave not before y = 1
    y = np.linspace(0.0, 1.0, 101)
    turned = 0.9 * 0.6 + 0.5 * 0.4**2
    low = np.clip(1.4 - y, 0.5, 0.9)
    released = ((y**3 - (y - 0.9 + low) ** 3) / 3.0 - 0.25 * (0.9 - low)) / 2.0
    solution = master.solve(origins.Contacts(origins.rectangular(0.5, 1.5)), np.append(0.0, 0.9 - y), 1e-10)
    assert np.abs(solution.force[1:] - (turned - y + released)).max() <= 1e-10


def test_gaussian_thresholds_after_one_turn():
    # broken once, at Y, then at -x_s again, where X = Y - x_s: two Gaussians, until the third break
    std, path = 0.05, np.linspace(1.4, -0.35, 176)
    z = path / (std * np.sqrt(2.0))
    exact = path - 1.0 + ndtr(-z) - std / np.sqrt(2.0) * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    solution = master.solve(origins.Contacts(origins.gaussian(1.0, std)), np.append(0.0, path), 1e-10)
    assert np.abs(solution.force[1:] - exact).max() <= 1e-10


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
    solution = master.solve(origins.Contacts(scipy.stats.expon()), path, 1e-10)
    assert solution.success
    assert np.abs(solution.force[1:] - np.concatenate([down, up])).max() <= 1e-10


def test_the_mirror_image_of_a_path_is_the_mirror_image_of_its_force():
    path = through([0.0, 1.3, -0.4, 0.9])
    one = master.solve(origins.Contacts(origins.gw_plastic(1.0), origins.gaussian_start(0.1, 0.05)), path, 1e-9)
    other = master.solve(origins.Contacts(origins.gw_plastic(1.0), origins.gaussian_start(-0.1, 0.05)), -path, 1e-9)
    assert np.abs(one.force + other.force).max() <= 1e-12


# -- a plain simulation ----------------------------------------------------------------------------------------------


# -- the paper's way --------------------------------------------------------------------------------------------------


def test_the_paper_forgets_and_by_how_much():
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), origins.gaussian_start(0.0, 0.025))
    for amplitude, missed in ((3.0, 0.040), (0.9, 0.183)):
        path = loop(amplitude, 61)
        coarse, fine = (explicit_loop(contacts, path, amplitude / n).force for n in (300, 600))
        extrapolated = 2.0 * fine - coarse
        difference = np.abs(extrapolated - master.solve(contacts, path, 1e-8).force)
        assert difference[:61].max() < 1e-4  # they agree until the first turn
        assert difference.max() == pytest.approx(missed, abs=5e-4)


def test_the_explicit_loop_is_the_explicit_scheme_where_nothing_turns():
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5), origins.gaussian_start(0.1, 0.05))
    path = np.linspace(0.0, 3.0, 61)
    assert np.abs(explicit_loop(contacts, path, 0.01).force - explicit(contacts, path, 0.01).force).max() < 1e-13


# -- accuracy ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize(
    "law", [lambda s: origins.gaussian(s, 0.1 * s), lambda s: origins.rectangular(0.5 * s, 1.5 * s)]
)
def test_lengths_only_set_the_scale(law, scale):
    path = through([0.0, 1.4, -0.8, 0.3], 9)
    one, other = (
        master.solve(origins.Contacts(law(s), origins.gaussian_start(0.02 * s, 0.05 * s)), s * path, 1e-8)
        for s in (1.0, scale)
    )
    assert np.abs(other.force / scale - one.force).max() <= 1e-12
    assert other.force_error == pytest.approx(one.force_error, rel=0.05, abs=1e-12)


def test_a_tolerance_beyond_reach_is_said():
    solution = master.solve(origins.Contacts(origins.gaussian(1.0, 0.2)), loop(0.9, 9), 1e-17)
    assert not solution.success
    assert "above the tolerance 1.0e-17" in solution.message


# -- what is returned -------------------------------------------------------------------------------------------------


def test_stretches_at_any_place_of_the_path():
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), origins.gaussian_start(0.1, 0.05))
    path = np.array([0.5, 1.3, 0.2, -0.6, 1.1])
    solution = master.solve(contacts, path, 1e-9)
    for position, leg, force in zip(path, [0, 0, 1, 1, 2], solution.force, strict=True):
        spread = solution.distribution(position, leg)
        # contacts from before a turn end where those from after it begin: cut there
        ends = position - np.array([0.0, position, 1.3, -0.6, 0.5 * (1.3 - 0.6), 0.5 * (position + 1.3)])
        cuts = np.unique(np.concatenate([ends, np.linspace(-2.0, 2.5, 300)]))
        nodes, weights = np.polynomial.legendre.leggauss(12)
        half = 0.5 * np.diff(cuts)[:, None]
        x = 0.5 * (cuts[1:] + cuts[:-1])[:, None] + half * nodes
        mass = half * weights * spread.density(x)
        assert abs(mass.sum() - 1.0) <= 1e-6
        assert abs((mass * x).sum() - force) <= 1e-6


def test_single_stretches_are_told_apart():
    solution = master.solve(origins.Contacts(origins.identical(1.0)), [0.7, -0.6], 1e-9)
    spread = solution.distribution(0.1, leg=0)
    assert spread.delta_positions == pytest.approx([0.1]) and spread.delta_weights == pytest.approx([1.0])
    assert solution.distribution(0.7).delta_positions == pytest.approx([0.7])


@pytest.mark.parametrize(
    ("position", "leg", "words"),
    [
        (0.3, None, "is passed on legs 0, 1; say which"),
        (5.0, None, "the path, between -0.6 and 0.7, does not come there"),
        (0.3, 7, "leg = 7"),
        (float("nan"), None, "must be finite"),
    ],
)
def test_a_place_must_be_told_from_others(position, leg, words):
    solution = master.solve(origins.Contacts(origins.identical(1.0)), [0.7, -0.6], 1e-9)
    with pytest.raises(origins.InputError, match=words):
        solution.distribution(position, leg)


@pytest.mark.parametrize(
    ("path", "tolerance", "words"),
    [([0.0, np.nan], 1e-8, r"path\[1\]"), ([], 1e-8, "path"), ([0.0, 1.0], 0.0, "tolerance = 0.0")],
)
def test_bad_input_is_refused_in_one_line(path, tolerance, words):
    with pytest.raises(origins.InputError, match=words) as caught:
        master.solve(origins.Contacts(origins.gaussian(1.0, 0.1)), path, tolerance)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("far", [1e7, 1e50, 1e160, 1e308])
def test_turns_too_far_apart_are_refused(far: float) -> None:
    with pytest.raises(origins.InputError, match=r"path\[0\] = .*turn round within 1e\+06"):
        master.solve(origins.Contacts(origins.gaussian(1.0, 0.2)), [-far, far], 1e-3)
