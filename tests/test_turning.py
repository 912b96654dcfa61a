"""Paths that turn round: exact hysteresis, closed forms after one and two turns, a simulation, the paper's way."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
import scipy.stats
from counted_calls import CountedCalls
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


def test_identical_thresholds_from_a_gaussian_start():
    mean, std, path = 0.1, 0.05, through(TURNS[:6], 21)
    # all stretches are x_0 + shift, one shift to each interval of x_0
    pieces, at, exact = [(-np.inf, np.inf, 0.0)], 0.0, []
    for position in path:
        moved = [(low, high, shift + position - at) for low, high, shift in pieces]
        at, pieces = position, []
        while moved:
            low, high, shift = moved.pop()
            up, down = 1.0 - shift, -1.0 - shift
            if high > up:
                moved += [(low, min(high, up), shift)] if low < up else []
                moved.append((max(low, up), high, shift - 1.0)) if up < mean + 10 * std else None
            elif low < down:
                moved += [(max(low, down), high, shift)] if high > down else []
                moved.append((low, min(high, down), shift + 1.0)) if down > mean - 10 * std else None
            else:
                pieces.append((low, high, shift))
        z = (np.array([[low, high] for low, high, _ in pieces]) - mean) / std
        weight, bell = np.diff(ndtr(z))[:, 0], np.diff(np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi))[:, 0]
        shifts = np.array([shift for *_, shift in pieces])
        exact.append(float((weight * (mean + shifts) - std * bell).sum()))
    contacts = origins.Contacts(origins.identical(1.0), origins.gaussian_start(mean, std))
    solution = master.solve(contacts, path, 1e-10)
    assert solution.success
    assert np.abs(solution.force - exact).max() <= solution.force_error <= 1e-10


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


def simulate(thresholds, x: np.ndarray, path: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Mean stretch and its standard error of contacts that break where |x| reaches x_s, one by one."""
    x_s = thresholds.isf(thresholds.sf(np.abs(x)) * (1.0 - rng.random(x.size)))
    at, mean, error = 0.0, [], []
    for position in path:
        direction, left = np.sign(position - at), np.full(x.size, abs(position - at))
        at, breaking = position, np.flatnonzero(x_s - direction * x <= left[0])
        left[breaking] -= x_s[breaking] - direction * x[breaking]
        while breaking.size:
            x[breaking], x_s[breaking] = 0.0, thresholds.isf(1.0 - rng.random(breaking.size))
            breaking = breaking[x_s[breaking] <= left[breaking]]
            left[breaking] -= x_s[breaking]
        x = x + direction * left
        mean.append(x.mean())
        error.append(x.std(ddof=1) / np.sqrt(x.size))
    return np.array(mean), np.array(error)


@pytest.mark.parametrize(
    ("thresholds", "amplitudes"),
    [
        (origins.gaussian(1.0, 0.2), [0.0, 3.0, -3.0, 3.0]),
        (origins.gw_elastic(1.0), [0.0, 0.9, -0.9, 0.9, -0.5, 0.2, -1.4]),
    ],
    ids=["wide", "narrowing"],
)
def test_a_million_contacts(thresholds, amplitudes):
    path, rng = through(amplitudes, 9)[1:], np.random.default_rng(20100902)
    mean, error = simulate(thresholds, rng.normal(0.0, 0.025, 1_000_000), path, rng)
    contacts = origins.Contacts(thresholds, origins.gaussian_start(0.0, 0.025))
    solution = master.solve(contacts, path, 1e-8)
    assert np.abs((solution.force - mean) / error).max() < 5.0


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


def test_the_explicit_loop_keeps_contacts_and_converges_at_first_order():
    contacts, path = origins.Contacts(origins.gw_plastic(1.0), 0.1), loop(1.2, 25)
    steps = 1.2 / np.array([100.0, 200.0, 400.0, 800.0])
    solutions = [explicit_loop(contacts, path, step) for step in steps]
    assert np.abs(solutions[0].holding - 1.0).max() < 1e-13
    limit = 2.0 * solutions[-1].force - solutions[-2].force
    errors = [np.abs(solution.force - limit).max() for solution in solutions[:-1]]
    assert abs(np.polyfit(np.log(steps[:-1]), np.log(errors), 1)[0] - 1.0) <= 0.2


# -- accuracy ---------------------------------------------------------------------------------------------------------


def claimed_and_true(
    contacts: origins.Contacts, path: np.ndarray, tolerance: float, finer: float | None = None
) -> tuple[float, float]:
    solution = master.solve(contacts, path, tolerance)
    # another end of the last leg makes lattices that share no nodes with the first
    longer = np.append(path, path[-1] + 0.37 * (path[-1] - path[-2]))
    known = master.solve(contacts, longer, finer or max(1e-3 * tolerance, 1e-11))
    error = np.abs(solution.force - known.force[:-1]).max() / contacts.mean_threshold
    assert error <= solution.force_error + known.force_error
    return solution.force_error, float(error)


def test_bends_of_what_older_cohorts_break_are_not_smeared():
    """A narrow start of wide thresholds: what is born on the way out begins to break in the middle of a cell."""
    contacts = origins.Contacts(origins.gaussian(1.05, 0.52), origins.gaussian_start(0.1, 0.0016))
    claimed, true = claimed_and_true(contacts, through([0.0, 0.63, -1.43], 60), 1e-10)
    assert true <= claimed <= 1e-10


def test_jumps_that_exact_values_hand_on_are_followed():
    """Births jump again one exact value later, on the next leg too; and where two such jumps cancel, what a lattice
    makes of each does not."""
    parts = [origins.identical(0.46), origins.identical(1.08), origins.gaussian(1.0, 0.1)]
    law = origins.mixture(parts, [0.2, 0.3, 0.5])
    contacts = origins.Contacts(law, scipy.stats.uniform(0.092, 0.139))
    path = through([0.0, -0.77, -0.1, -0.1006, 1.96, 1.41], 12)
    claimed, true = claimed_and_true(contacts, path, 1e-6, 1e-8)
    assert true <= 5e-8 and true <= claimed <= 1e-6


def test_a_law_far_narrower_than_the_path_takes_little_longer():
    """Births of such a law lie on thousands of panels, all but empty: only what weighs is looked at."""
    path = through([0.0, 1.3, -0.8, 0.9], 20)
    with CountedCalls() as wide:
        master.solve(origins.Contacts(origins.gaussian(1.0, 0.1)), path, 1e-6)
    with CountedCalls() as narrow:
        solution = master.solve(origins.Contacts(origins.gaussian(1.0, 1e-4)), path, 1e-6)
    assert narrow.number < 15 * wide.number
    assert solution.success
    assert np.abs(solution.force - walk(0.0, solution.path, 1.0)).max() <= 1e-6


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


@pytest.mark.parametrize("path", [[0.0], [0.0, 0.0], [-0.3], [1e-300, -1e-12, 0.2], [0.2, 0.2, 0.1, 0.1]])
def test_any_path(path):
    contacts = origins.Contacts(origins.gaussian(1.0, 0.1), 0.1)
    solution = master.solve(contacts, path, 1e-9)
    # nothing breaks so near to the start
    assert solution.success
    assert np.abs(solution.force - (0.1 + np.asarray(path))).max() <= 1e-9
    assert (solution.holding == 1.0).all() and solution.force.shape == (len(path),)


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


