"""P_c of one island over all angles: against angles counted on a fine grid, and what it means for sliding."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import master
import origins

A = 2.5


def force(n_i: int, n_j: int, angle: np.ndarray) -> np.ndarray:
    return origins.triangular_barrier(A, n_i, n_j, angle) / (2.0 * np.pi)


def counted(n_i: int, n_j: int, number: int = 1_000_000) -> np.ndarray:
    return np.sort(force(n_i, n_j, 2.0 * np.pi * (np.arange(number) + 0.5) / number))


@pytest.fixture(scope="module")
def law() -> origins.Thresholds:
    return origins.domains(A, sizes=[(5, 4)], stiffness=1.0, samples=100)


@pytest.mark.parametrize("n_i, n_j", [(2, 2), (20, 19)])
def test_shares_and_moments_are_those_of_a_fine_grid_of_angles(n_i: int, n_j: int) -> None:
    exact = counted(n_i, n_j)
    law = origins.domains(A, sizes=[(n_i, n_j)], stiffness=1.0, samples=100)
    x = np.quantile(exact, np.linspace(0.001, 0.999, 500))
    share = np.searchsorted(exact, x) / exact.size
    # where b stands still the grid itself misses the root of its spacing
    assert np.abs(law.cdf(x) - share).max() < 4e-5
    assert np.abs(law.sf(x) - (1.0 - share)).max() < 4e-5
    assert np.abs(law.cdf(law.ppf(share[10:-10])) - share[10:-10]).max() < 1e-7
    assert law.mean() == pytest.approx(exact.mean(), rel=1e-9)
    assert law.std() == pytest.approx(exact.std(), rel=1e-8)
    assert law.moment(3) == pytest.approx((exact**3).mean(), rel=1e-8)
    # the grid misses a ridge by its spacing times the slope
    assert law.support()[1] == pytest.approx(exact[-1], rel=1e-4) and law.support()[1] >= exact[-1]


def test_the_density_is_the_slope_of_the_shares(law: origins.Thresholds) -> None:
    lower, upper = law.support()
    x = np.linspace(lower, upper, 400)[1:-1]
    step = 1e-7 * upper
    slope = (law.cdf(x + step) - law.cdf(x - step)) / (2.0 * step)
    assert np.median(np.abs(law.pdf(x) / slope - 1.0)) < 1e-7
    assert np.quantile(np.abs(law.pdf(x) / slope - 1.0), 0.98) < 1e-3


def test_peaks_and_jumps_stand_where_the_barrier_stands_still_and_bends(
    law: origins.Thresholds,
) -> None:
    """Stationary angles by scipy's search and crossings of |S_x| and |S_y| by brentq, of their own."""
    angles = np.linspace(0.0, np.pi / 2, 4001)
    b = force(5, 4, angles)
    tops = np.flatnonzero((b[1:-1] > b[:-2]) & (b[1:-1] > b[2:])) + 1
    waves = np.abs(origins.triangular_structure_factors(A, 5, 4, angles))
    difference = waves[:, 0] - waves[:, 1]

    def apart(angle: float) -> float:
        one, other = np.abs(origins.triangular_structure_factors(A, 5, 4, angle))
        return float(one - other)

    crossings = [
        brentq(apart, angles[k], angles[k + 1], xtol=1e-14)
        for k in np.flatnonzero(difference[1:] * difference[:-1] < 0.0)
    ]
    values = [float(force(5, 4, np.array(c))) for c in crossings]
    smooth = []
    for k in tops:
        if not any(angles[k - 1] <= c <= angles[k + 1] for c in crossings):
            found = minimize_scalar(
                lambda t: -float(force(5, 4, np.array(t))),
                bounds=(angles[k - 1], angles[k + 1]),
                method="bounded",
            )
            smooth.append(-found.fun)
    assert smooth
    for value in smooth:
        # an inverse square root below, which the law declares
        near = law.breakpoints[np.abs(law.breakpoints - value).argmin()]
        assert near == pytest.approx(value, rel=1e-9) and law.pdf(near) == np.inf
        ratio = law.pdf(near - 1e-6 * near) / law.pdf(near - 1e-8 * near)
        assert ratio == pytest.approx(0.1, rel=0.05)
    declared = np.array([np.abs(law.breakpoints - v).min() < 1e-9 * v for v in values])
    assert declared.any()


def test_what_it_means_for_sliding(law: origins.Thresholds) -> None:
    """The force drops with a vertical slope where P_c diverges: K* is infinite for every seed."""
    contacts = origins.Contacts(law)
    found = master.propensity(contacts, velocity=1.0, tolerance=1e-3)
    assert found.critical_spring == np.inf
    steady = master.steady_state(contacts, velocity=1.0)
    exact = counted(5, 4)
    assert steady.force == pytest.approx((exact**2).mean() / (2.0 * exact.mean()), rel=1e-7)


@pytest.mark.parametrize("law", ["area", "paper"])
def test_two_sizes_have_their_shares(law: str) -> None:
    """The barrier of a single atom is the same at all angles: an exact value among those of the others."""
    scale = {"coefficient": 4.0} if law == "paper" else {"stiffness": 1.0}
    sizes, weights = [(5, 4), (1, 1)], np.array([0.8, 0.2])
    mixed = origins.domains(A, sizes=sizes, weights=weights, law=law, samples=100, **scale)
    atoms = np.array([20.0, 1.0])
    forces = [counted(*size, number=200_001) for size in sizes]
    relative = np.sqrt(atoms / (weights @ atoms))
    exact = [
        np.sqrt(f / 4.0) if law == "paper" else f / r for f, r in zip(forces, relative, strict=True)
    ]
    x = np.linspace(0.05, 0.95, 40) * max(part[-1] for part in exact)
    share = sum(
        w * np.searchsorted(part, x) / part.size for w, part in zip(weights, exact, strict=True)
    )
    assert np.abs(mixed.cdf(x) - share).max() < 2e-4
    assert mixed.mean() == pytest.approx(
        sum(w * part.mean() for w, part in zip(weights, exact, strict=True)), rel=2e-5
    )
    np.testing.assert_allclose(mixed.atoms, [[exact[1][0]], [0.2]], rtol=1e-12)
    assert not mixed.knows_breakpoints and np.isinf(mixed.pdf(mixed.breakpoints)).any()


def test_large_islands_many_sizes_and_other_substrates_are_sampled() -> None:
    large = origins.domains(A, sizes=[(900, 900)], stiffness=1.0, samples=200)
    many = origins.domains(A, mean_atoms=10.0, stiffness=1.0, samples=200)
    other = origins.domains(
        A, sizes=[(3, 3)], stiffness=1.0, samples=200, substrate=origins.hexagonal_substrate()
    )
    three = origins.domains(A, sizes=[(3, 3), (4, 4), (5, 5)], stiffness=1.0, samples=200)
    assert {law.n_samples for law in (large, other, many, three)} == {200}
