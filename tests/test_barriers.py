"""Barriers of rigid islands: closed sums, sums over atoms and the search for the lowest saddle against one another."""

import ase
import numpy as np
import numpy.typing as npt
import pytest
from scipy.ndimage import minimum_filter

import origins

HEXAGONAL = origins.hexagonal_substrate()


def atoms_at(points: np.ndarray) -> ase.Atoms:
    return ase.Atoms(
        numbers=[0] * len(points), positions=np.column_stack([points, np.zeros(len(points))])
    )


def searched(waves: npt.ArrayLike, sizes: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """Barriers of one atom on sum of sizes cos(K·r + phases), rows of sizes and phases; no closed form has a part."""
    # a third wave that is there, and counts for nothing, keeps two waves from their closed form
    waves = np.vstack([waves, [7.0, 3.0]])
    shares = np.column_stack(
        [sizes * np.exp(1j * phases), np.full(len(sizes), 1e-14 * np.max(sizes))]
    )
    one = atoms_at(np.zeros((1, 2)))
    return np.array(
        [origins.barrier(one, 0.0, origins.fourier_substrate(waves, row)) for row in shares]
    )


def inversion_symmetric(a: np.ndarray) -> float:
    """Barrier of a_1 cos u + a_2 cos v + a_3 cos(u + v), from the points where it can be level.

    Four of them are fixed by inversion. Where all a have one sign in their product and no 1/a exceeds the sum of the
    others there are two more, of energy -(a_1 a_2/a_3 + a_2 a_3/a_1 + a_3 a_1/a_2)/2. With a product above zero these
    are minima, joined by three saddles; a path round the torus needs two.
    """
    fixed = np.sort(
        [a[0] + a[1] + a[2], a[0] - a[1] - a[2], -a[0] + a[1] - a[2], -a[0] - a[1] + a[2]]
    )
    inverse = 1.0 / np.abs(a)
    if a.prod() > 0.0 and 2.0 * inverse.max() < inverse.sum():
        return fixed[1] + 0.5 * (a[0] * a[1] / a[2] + a[1] * a[2] / a[0] + a[2] * a[0] / a[1])
    return fixed[1] - fixed[0]


def test_a_thousand_random_islands_on_sin_x_plus_sin_y() -> None:
    rng = np.random.default_rng(0)
    sizes, phases = np.empty((1000, 2)), np.empty((1000, 2))
    closed = np.empty(1000)
    for case in range(1000):
        a, angle = rng.uniform(0.5, 12.0), rng.uniform(-6.2, 6.2)
        n_i, n_j = (int(n) for n in rng.integers(1, 40, 2))
        island = origins.triangular_island(a, n_i, n_j)
        turned = island.positions[:, :2] @ [
            [np.cos(angle), np.sin(angle)],
            [-np.sin(angle), np.cos(angle)],
        ]
        direct = np.exp(1j * turned).sum(0)
        closed[case] = origins.triangular_barrier(a, n_i, n_j, angle)
        assert abs(closed[case] - 2.0 * np.abs(direct).min()) < 1e-12 * n_i * n_j
        assert (
            abs(origins.barrier(island, angle, origins.square_substrate()) - closed[case])
            < 1e-12 * n_i * n_j
        )
        sizes[case], phases[case] = np.abs(direct), np.angle(direct)
    # the search for the lowest saddle knows of no closed form; energies in units of the larger wave
    assert np.abs(searched(np.eye(2), sizes[:300], phases[:300]) - closed[:300]).max() < 1e-10


def test_inversion_symmetric_islands_on_three_cosines() -> None:
    """A thousand islands against the closed form, the two places where minima split among them."""
    rng = np.random.default_rng(1)
    outlines = [
        origins.hexagonal_island(2.5, 7.5),
        origins.square_island(2.1, 6, 5),
        origins.triangular_island(2.5, 7, 4),
        origins.circular_island(3.0, 20.0),
    ]
    for island in outlines:
        angle = rng.uniform(0.0, 2.0 * np.pi, 250)
        factors = origins.structure_factors(island, angle, HEXAGONAL.wavevectors)
        assert np.abs(factors.imag).max() < 1e-12
        expected = np.array([inversion_symmetric(row) for row in factors.real])
        assert np.abs(origins.barrier(island, angle, HEXAGONAL) - expected).max() < 1e-10


@pytest.mark.parametrize("beyond", [0.0, -1e-9, 1e-6, -1e-3])
def test_where_minima_split(beyond: float) -> None:
    """Beside 1/a_3 = 1/a_1 + 1/a_2 the lowest point has no curvature in one direction."""
    rng = np.random.default_rng(2)
    a = rng.uniform(0.3, 1.0, size=(40, 3))
    a[:, 2] = (1.0 + beyond) / (1.0 / a[:, 0] + 1.0 / a[:, 1])
    a /= a.max(-1, keepdims=True)
    signs = rng.choice([-1.0, 1.0], size=a.shape)
    waves = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    found = searched(waves, a, np.where(signs > 0.0, 0.0, np.pi))
    expected = [inversion_symmetric(row) for row in a * signs]
    assert np.abs(found - expected).max() < 1e-10


def flooded(substrate: origins.Substrate, factors: np.ndarray, n: int) -> float:
    """The barrier by raising the water on a grid of n x n points a cell, until the lowest pool reaches a copy of
    itself: a way round the torus that is simple reaches one within two cells by two."""
    share = np.stack(np.meshgrid(*[np.arange(2 * n) / n] * 2, indexing="ij"), axis=-1)
    heights = (
        np.exp(2j * np.pi * share @ substrate.indices.T) @ (substrate.coefficients * factors)
    ).real
    i, j = np.unravel_index(heights[:n, :n].argmin(), (n, n))
    level = np.full(heights.shape, np.inf)
    level[i, j] = heights[i, j]
    while True:
        lower = np.minimum(level, np.maximum(heights, minimum_filter(level, 3, mode="wrap")))
        if (lower == level).all():
            return float(min(level[i + n, j], level[i, j + n], level[i + n, j + n]) - heights[i, j])
        level = lower


def test_random_islands_on_random_substrates_against_a_flood() -> None:
    """The exact barrier lies within the flood's own error, of the order of h²."""
    rng = np.random.default_rng(4)
    richer = origins.fourier_substrate(
        [[1.0, 0.2], [-0.1, 1.1], [0.9, 1.3], [1.8, 2.6], [1.1, -0.9]],
        [1.0, 0.8j, -0.6, 0.3, 0.5 + 0.2j],
    )
    for substrate, cases in ((HEXAGONAL, 5), (richer, 5)):
        for case in range(cases):
            island = origins.irregular_island(2.6, 6.0, seed=case)
            angle = rng.uniform(0.0, 2.0 * np.pi)
            factors = origins.structure_factors(island, angle, substrate.wavevectors)
            exact = float(origins.barrier(island, angle, substrate))
            scale = np.abs(substrate.coefficients * factors).sum()
            h = 2.0 * np.pi * np.abs(substrate.indices).max() / 96
            assert abs(flooded(substrate, factors, 96) - exact) < 0.25 * h * h * scale


def test_where_the_island_stands_or_what_it_weighs_does_not_matter() -> None:
    island, angle = origins.irregular_island(2.5, 8.0, seed=5), np.linspace(0.0, 6.0, 20)
    moved = island.copy()
    moved.positions += [3.3, -1.2, 4.0]
    moved.set_masses(np.random.default_rng(0).uniform(1.0, 9.0, len(island)))
    for substrate in (None, HEXAGONAL):
        np.testing.assert_allclose(
            origins.barrier(moved, angle, substrate),
            origins.barrier(island, angle, substrate),
            atol=1e-11,
        )
    # by symmetry: sin x + sin y and the hexagonal cosines look the same after a quarter and a sixth of a turn
    np.testing.assert_allclose(
        origins.barrier(island, angle - np.pi / 2), origins.barrier(island, angle), atol=1e-12
    )
    np.testing.assert_allclose(
        origins.barrier(island, angle - np.pi / 3, HEXAGONAL),
        origins.barrier(island, angle, HEXAGONAL),
        atol=1e-10,
    )


def test_commensurate_islands() -> None:
    """phi = 0 exactly: every atom in the same place of the cell, and a barrier per atom."""
    for n in (1, 3, 40):
        square = origins.square_island(2.0 * np.pi, n, n + 1)
        assert origins.barrier(square, 0.0) == pytest.approx(2.0 * len(square), rel=1e-13)
        assert origins.triangular_barrier(2.0 * np.pi, n, n + 1, 0.0, HEXAGONAL) == pytest.approx(
            0.5 * n * (n + 1)
        )
    assert origins.triangular_barrier(2.0 * np.pi, 2500, 4000, 0.0, HEXAGONAL) == pytest.approx(
        0.5e7, rel=1e-12
    )
    assert origins.triangular_barrier(2.0 * np.pi, 2500, 4000, np.pi / 3, HEXAGONAL) > 0.0


def test_barriers_that_vanish() -> None:
    # rows of 4 at a quarter of the period: the waves along x cancel
    assert origins.triangular_barrier(np.pi / 2, 4, 3, 0.0) < 1e-14
    assert origins.barrier(origins.square_island(np.pi / 2, 4, 3), 0.0) < 1e-14
    assert origins.triangular_barrier(np.pi, 3000, 3000, 0.0) < 1e-12 * 9e6
    # nothing to climb along the troughs of a substrate that varies in one direction only
    troughs = origins.fourier_substrate([[1.0, 0.0], [3.0, 0.0]], [1.0, 0.5])
    island = origins.triangular_island(2.5, 5, 4)
    assert origins.barrier(island, [0.1, 0.2], troughs).tolist() == [0.0, 0.0]
    assert (
        origins.triangular_barrier(2.5, [[3], [4]], 4, [0.1, 0.2], troughs).tolist()
        == [[0.0] * 2] * 2
    )
    # three cosines, two of which vanish: a square of two sites half a period apart along one of them
    pair = atoms_at(np.array([[0.0, 0.0], [np.pi, 0.0]]))
    assert origins.barrier(pair, 0.0, HEXAGONAL) < 1e-14
