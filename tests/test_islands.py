"""Islands: the paper's lattice and not its look-alikes, outlines counted, substrates repeat as their cells say."""

import ase
import numpy as np
import pytest

from origins.domains.islands import (
    circular_island,
    hexagonal_island,
    irregular_island,
    rectangular_island,
    square_island,
    triangular_island,
)
from origins.domains.substrates import fourier_substrate, hexagonal_substrate, square_substrate

A = 2.5


def neighbours(points: np.ndarray, distance: float) -> np.ndarray:
    """How many others stand at `distance` from each point."""
    apart = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    return (np.abs(apart - distance) < 1e-9).sum(-1)


def test_triangular_island_is_the_papers() -> None:
    island = triangular_island(A, 7, 6)
    assert isinstance(island, ase.Atoms) and len(island) == 42 and not island.pbc.any()
    points = island.positions[:, :2]
    # the paper's coordinates: i begins at -(j // 2), neither at -j/2 nor at (-j) // 2
    cells = [(m - j // 2, j) for j in range(6) for m in range(7)]
    expected = [((i + j / 2) * A, j * A * np.sqrt(3.0) / 2) for i, j in cells]
    np.testing.assert_allclose(points, expected, atol=1e-13)
    assert (island.positions[:, 2] == 0.0).all()
    # inside, six neighbours at the lattice constant; odd rows lead by half of it
    assert neighbours(points, A)[[8, 9, 10, 15, 16, 22, 30]].tolist() == [6] * 7
    assert points[7, 0] - points[0, 0] == pytest.approx(A / 2)


def test_outlines_are_counted() -> None:
    for n in range(6):
        assert len(hexagonal_island(A, n * A)) == 3 * n * (n + 1) + 1
    i, j = np.meshgrid(np.arange(-30, 31), np.arange(-30, 31))
    for radius in (0.0, 1.0, 5.0, 7.3, 12.0):
        for kind, apart in (("triangular", i * i + i * j + j * j), ("square", i * i + j * j)):
            inside = (apart <= radius**2 + 1e-9).sum()
            assert len(circular_island(A, radius * A, lattice=kind)) == inside
    assert len(rectangular_island(A, 6 * A, 4 * A, lattice="square")) == 7 * 5
    # rows of a triangular lattice: seven atoms where one stands in the middle, six else; 5 rows within 4 a
    assert len(rectangular_island(A, 6 * A, 4 * A)) == 7 + 2 * 6 + 2 * 7
    square = square_island(A, 4, 3)
    assert len(square) == 12 and neighbours(square.positions[:, :2], A).max() == 4
    for outline in (hexagonal_island, circular_island, irregular_island):
        counts = neighbours(outline(A, 6 * A).positions[:, :2], A)
        assert counts.max() == 6 and counts.min() >= 1


def test_irregular_islands_come_from_their_seed() -> None:
    islands = [irregular_island(A, 10 * A, seed=seed).positions for seed in (1, 1, 2)]
    assert np.array_equal(islands[0], islands[1]) and not np.array_equal(islands[0], islands[2])
    # of all outlines the smooth one is the nearest to a circle's number of atoms
    sizes = [
        [len(irregular_island(A, 10 * A, roughness=r, seed=s)) for s in range(20)]
        for r in (0.0, 0.2)
    ]
    circle = np.pi * 100 / (np.sqrt(3) / 2)
    assert np.abs(np.array(sizes[0]) / circle - 1).max() < 0.03 and np.std(sizes[1]) > 3 * np.std(
        sizes[0]
    )
    assert len(irregular_island(A, 1e-3 * A)) == 1


@pytest.mark.parametrize(
    "substrate",
    [
        square_substrate(2.0, 3.0),
        hexagonal_substrate(-0.5, 2.5),
        fourier_substrate([[2.0, 0.0], [3.0, 0.0], [1.0, 5.0]], [1.0, 2.0, 3.0j], constant=7.0),
        fourier_substrate(
            np.array([[2, 0], [3, 1], [1, 5], [7, -11]]) @ [[0.9, 0.2], [-0.1, 1.1]],
            [1, 2, 3j, 1 + 1j],
        ),
    ],
)
def test_substrates_repeat_and_push(substrate) -> None:
    r = np.random.default_rng(0).normal(size=(4, 5, 2)) * 3.0
    size = np.abs(substrate.coefficients).sum()
    for step in substrate.cell:
        np.testing.assert_allclose(
            substrate.energy(r + step), substrate.energy(r), atol=1e-12 * size
        )
        # the cell is the smallest: half a step is none
        assert np.abs(substrate.energy(r + step / 2) - substrate.energy(r)).max() > 0.1 * size
    reciprocal = 2.0 * np.pi * np.linalg.inv(substrate.cell).T
    np.testing.assert_allclose(substrate.indices @ reciprocal, substrate.wavevectors, atol=1e-12)
    h = 1e-6
    for axis in (0, 1):
        step = np.eye(2)[axis] * h
        slope = (substrate.energy(r + step) - substrate.energy(r - step)) / (2 * h)
        np.testing.assert_allclose(substrate.forces(r)[..., axis], -slope, atol=1e-7 * size)


def test_substrates_of_one_and_of_no_period() -> None:
    r = np.array([[0.3, -1.2], [2.0, 0.7]])
    assert square_substrate().energy(r) == pytest.approx(np.sin(r).sum(-1), abs=1e-15)
    hexagonal = hexagonal_substrate(2.0, 3.0)
    assert hexagonal.energy([0.0, 0.0]) == pytest.approx(6.0) and hexagonal.energy(
        [3.0, 0.0]
    ) == pytest.approx(6.0)
    assert hexagonal.energy([1.5, np.sqrt(0.75)]) == pytest.approx(-3.0)
    together = fourier_substrate([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]], [1.0, 1.0j, 3.0])
    assert len(together.coefficients) == 1
    assert together.energy([0.4, 0.0]) == pytest.approx(3.0 + np.cos(0.4) + np.sin(0.4))
    assert (
        square_substrate().rank == 2
        and fourier_substrate([[1.0, 2.0], [-3.0, -6.0]], [1, 1]).rank == 1
    )
