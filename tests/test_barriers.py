"""Barriers of islands, rigid and with atoms that follow: against closed forms, a flood, minimisation on lines."""

import ase
import numpy as np
import pytest
from ase.calculators.lj import LennardJones
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms
from scipy.ndimage import minimum_filter
from scipy.optimize import minimize_scalar

import origins
from origins import relaxed_barrier, substrate_calculator

HEXAGONAL = origins.hexagonal_substrate()


def inversion_symmetric(a: np.ndarray) -> float:
    """Barrier of a_1 cos u + a_2 cos v + a_3 cos(u + v), from the points where it can be level.

    Four of them are fixed by inversion. Where all a have one sign in their product and no 1/a exceeds the sum of the
    others there are two more, of energy -(a_1 a_2/a_3 + a_2 a_3/a_1 + a_3 a_1/a_2)/2. With a product above zero these
    are minima, joined by three saddles; a path round the torus needs two.
    """
    fixed = np.sort([a.sum(), a[0] - a[1] - a[2], a[1] - a[2] - a[0], a[2] - a[0] - a[1]])
    inverse = 1.0 / np.abs(a)
    if a.prod() > 0.0 and 2.0 * inverse.max() < inverse.sum():
        return fixed[1] + 0.5 * (a[0] * a[1] / a[2] + a[1] * a[2] / a[0] + a[2] * a[0] / a[1])
    return fixed[1] - fixed[0]


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


def test_one_atom_in_narrow_valleys() -> None:
    """Where one cosine is up to a million times the others, a grid of some hundred places sees no minimum."""
    atom = ase.Atoms("H", positions=[[0.0, 0.0, 0.0]])
    for sizes in 10.0 ** np.random.default_rng(3).uniform(-6.0, 0.0, (40, 3)) * [1.0, -1.0, 1.0]:
        substrate = origins.fourier_substrate([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], sizes)
        found = origins.barrier(atom, 0.0, substrate)
        assert abs(found - inversion_symmetric(sizes)) < 1e-12 * np.abs(sizes).max()


def flooded(substrate: origins.Substrate, factors: np.ndarray, n: int) -> float:
    """The barrier by raising the water on a grid of n x n points a cell, until the lowest pool reaches a copy of
    itself: a way round the torus that is simple reaches one within two cells by two."""
    share = np.stack(np.meshgrid(*[np.arange(2 * n) / n] * 2, indexing="ij"), axis=-1)
    waves = np.exp(2j * np.pi * share @ substrate.indices.T)
    heights = (waves @ (substrate.coefficients * factors)).real
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


def test_barriers_that_vanish() -> None:
    # nothing to climb along the troughs of a substrate that varies in one direction only
    troughs = origins.fourier_substrate([[1.0, 0.0], [3.0, 0.0]], [1.0, 0.5])
    island = origins.triangular_island(2.5, 5, 4)
    assert origins.barrier(island, [0.1, 0.2], troughs).tolist() == [0.0, 0.0]
    # three cosines, two of which vanish: two sites half a period apart along one of them
    pair = ase.Atoms("H2", positions=[[0.0, 0.0, 0.0], [np.pi, 0.0, 0.0]])
    assert origins.barrier(pair, 0.0, HEXAGONAL) < 1e-14


# -- on any calculator of ASE ----------------------------------------------------------------------


SQUARE = origins.square_substrate()


def turned(island: ase.Atoms, angle: float) -> ase.Atoms:
    copy = island.copy()
    copy.rotate(np.degrees(angle), "z", center="COM")
    return copy


def random_substrate(seed: int, waves: int) -> origins.Substrate:
    rng = np.random.default_rng(seed)
    indices = np.array([[1, 0], [0, 1], [1, 1], [1, -1], [2, 0], [0, 2], [2, 1]])[:waves]
    basis = [[1.0, 0.0], [rng.uniform(-0.6, 0.6), rng.uniform(0.7, 1.3)]]
    return origins.fourier_substrate(
        indices @ basis, rng.normal(size=waves) + 1j * rng.normal(size=waves)
    )


@pytest.mark.parametrize("seed", [51, 106])
def test_other_substrates_climb_what_the_exact_search_says(seed: int) -> None:
    # in the first Newton's steps may go back and forth for ever, in the second two saddles lie close by
    substrate = random_substrate(seed, 7)
    for island, angle in (
        (ase.Atoms("H", positions=[[0, 0, 0]]), 0.0),
        (origins.irregular_island(2.6, 6.0), 1.0),
    ):
        found = relaxed_barrier(turned(island, angle), substrate_calculator(substrate))
        exact = origins.barrier(island, angle, substrate)
        assert abs(found.barrier - exact) <= found.barrier_error + 1e-10


@pytest.mark.slow
def test_atom_on_a_slab_of_lennard_jones_atoms() -> None:
    """By symmetry the minimum is over the hollow and the saddle over the bridge; heights follow."""
    spots = 1.1 * np.array([[i, j, 0.0] for i in range(3) for j in range(3)])
    slab = ase.Atoms("Ar9", positions=spots, cell=[3.3, 3.3, 20.0], pbc=[True, True, False])
    atoms = slab + ase.Atoms("Ar", positions=[[0.1, 0.2, 0.9]])
    atoms.set_constraint(FixAtoms(range(9)))
    atoms.calc = own = LennardJones(sigma=1.0, epsilon=1.0, rc=2.0, ro=1.5, smooth=True)

    def lowest(x: float, y: float) -> float:
        probe = atoms.copy()
        probe.calc = own

        def energy(z: float) -> float:
            probe.positions[-1] = x, y, z
            return float(probe.get_potential_energy())

        return float(minimize_scalar(energy, bounds=(0.5, 1.5), method="bounded").fun)

    before = atoms.positions.copy()
    found = relaxed_barrier(atoms, own, planar=False, periods=1.1 * np.eye(2))
    assert found.barrier == pytest.approx(lowest(0.55, 0.0) - lowest(0.55, 0.55), abs=1e-7)
    assert np.array_equal(atoms.positions, before) and atoms.calc is own


@pytest.mark.slow
def test_two_atoms_on_a_spring() -> None:
    """One bond, its direction held: c_x(s) sin X + c_y(s) sin Y + K s²/2, the lowest in s of each kind of place."""
    length, angle, stiffness = 2.2, 0.6, 5.0
    atoms = turned(ase.Atoms(numbers=[0, 0], positions=[[0, 0, 0], [length, 0, 0]]), angle)
    bond = origins.harmonic_bonds(atoms, stiffness)
    found = relaxed_barrier(atoms, SumCalculator([substrate_calculator(SQUARE), bond]), rigid=False)

    def level(x: float, y: float) -> float:
        def energy(stretch: float) -> float:
            half = 0.5 * (length + stretch)
            waves = abs(np.cos(half * np.cos(angle))), abs(np.cos(half * np.sin(angle)))
            return 2.0 * (x * waves[0] + y * waves[1]) + 0.5 * stiffness * stretch**2

        within = {"bounds": (-0.9, 0.9), "method": "bounded", "options": {"xatol": 1e-12}}
        return float(minimize_scalar(energy, **within).fun)

    exact = min(level(1.0, -1.0), level(-1.0, 1.0)) - level(-1.0, -1.0)
    assert abs(found.barrier - exact) <= found.barrier_error + 4e-15 and found.barrier_error < 1e-12
