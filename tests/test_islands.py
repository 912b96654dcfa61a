"""Islands: outlines, structure factors, barriers of rigid ones against closed forms, a flood and ASE's own road."""

import ase
import numpy as np
import pytest

import origins

A = 2.5


def neighbours(points: np.ndarray, distance: float) -> np.ndarray:
    """How many others stand at `distance` from each point."""
    apart = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    return (np.abs(apart - distance) < 1e-9).sum(-1)


def test_triangular_island_is_the_papers() -> None:
    island = origins.triangular_island(A, 7, 6)
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
        assert len(origins.hexagonal_island(A, n * A)) == 3 * n * (n + 1) + 1
    i, j = np.meshgrid(np.arange(-30, 31), np.arange(-30, 31))
    for radius in (0.0, 1.0, 5.0, 7.3, 12.0):
        for kind, apart in (("triangular", i * i + i * j + j * j), ("square", i * i + j * j)):
            inside = (apart <= radius**2 + 1e-9).sum()
            assert len(origins.circular_island(A, radius * A, lattice=kind)) == inside
    assert len(origins.rectangular_island(A, 6 * A, 4 * A, lattice="square")) == 7 * 5
    # rows of a triangular lattice: seven atoms where one stands in the middle, six else; 5 rows within 4 a
    assert len(origins.rectangular_island(A, 6 * A, 4 * A)) == 7 + 2 * 6 + 2 * 7
    square = origins.square_island(A, 4, 3)
    assert len(square) == 12 and neighbours(square.positions[:, :2], A).max() == 4
    for outline in (origins.hexagonal_island, origins.circular_island, origins.irregular_island):
        counts = neighbours(outline(A, 6 * A).positions[:, :2], A)
        assert counts.max() == 6 and counts.min() >= 1


def test_irregular_islands_come_from_their_seed() -> None:
    islands = (origins.irregular_island(A, 10 * A, seed=seed) for seed in (1, 1, 2))
    one, same, other = (island.positions for island in islands)
    assert np.array_equal(one, same) and not np.array_equal(one, other)
    # of all outlines the smooth one is the nearest to a circle's number of atoms
    sizes = [
        [len(origins.irregular_island(A, 10 * A, roughness=r, seed=s)) for s in range(20)]
        for r in (0.0, 0.2)
    ]
    assert np.abs(np.array(sizes[0]) * np.sqrt(0.75) / (np.pi * 100) - 1).max() < 0.03
    assert np.std(sizes[1]) > 3 * np.std(sizes[0])


@pytest.mark.parametrize(
    "substrate",
    [
        origins.square_substrate(2.0, 3.0),
        origins.hexagonal_substrate(-0.5, 2.5),
        origins.fourier_substrate(
            np.array([[2, 0], [5, 0], [1, 5], [7, -11]]) @ [[0.9, 0.2], [-0.1, 1.1]],
            [1, 2, 3j, 1 + 1j],
            constant=7.0,
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


# -- structure factors -----------------------------------------------------------------------------

LONG = np.longdouble
COMMENSURATE = [2 * np.pi, 4 * np.pi, np.pi, 4 * np.pi / np.sqrt(3.0), 2 * np.pi / np.sqrt(3.0)]


def atom_by_atom(a: float, n_i: int, n_j: int, angle: float, wavevectors: np.ndarray) -> np.ndarray:
    """The sum over the atoms of the paper's island about their centre, in long precision."""
    j = np.repeat(np.arange(n_j), n_i)
    i = np.tile(np.arange(n_i), n_j) - j // 2
    x, y = (i + LONG(0.5) * j) * LONG(a), j * (LONG(a) * np.sqrt(LONG(3)) / 2)
    x, y = x - x.mean(), y - y.mean()
    cos, sin = np.cos(LONG(angle)), np.sin(LONG(angle))
    phases = [g[0] * (cos * x - sin * y) + g[1] * (sin * x + cos * y) for g in wavevectors]
    return np.array([complex(np.cos(phase).sum(), np.sin(phase).sum()) for phase in phases])


def test_random_islands_against_sums_over_atoms() -> None:
    """Structure factors, and barriers on sin x + sin y: 2 min(|S_x|, |S_y|)."""
    rng = np.random.default_rng(0)
    square, substrate = np.eye(2), origins.square_substrate()
    for case in range(300):
        a = rng.choice(COMMENSURATE) if case % 5 == 0 else rng.uniform(0.1, 20.0)
        n_i, n_j = (int(n) for n in rng.integers(1, 60, 2))
        angle = (
            rng.choice([0.0, np.pi / 6, np.pi / 2, np.pi])
            if case % 3 == 0
            else rng.uniform(-10.0, 10.0)
        )
        waves = rng.normal(size=(3, 2)) if case % 2 else square
        expected = atom_by_atom(a, n_i, n_j, angle, waves)
        closed = origins.triangular_structure_factors(a, n_i, n_j, angle, waves)
        assert np.abs(closed - expected).max() < 1e-12 * n_i * n_j
        island = origins.triangular_island(a, n_i, n_j)
        if waves is square:
            within = angle % (2.0 * np.pi)
            for barrier in (
                origins.triangular_barrier(a, n_i, n_j, within),
                origins.barrier(island, within, substrate),
            ):
                assert abs(barrier - 2.0 * np.abs(expected).min()) < 1e-12 * n_i * n_j
        if case % 10 == 0:
            summed = origins.structure_factors(island, angle, waves)
            assert np.abs(summed - expected).max() < 1e-12 * n_i * n_j
