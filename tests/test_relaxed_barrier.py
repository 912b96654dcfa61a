"""Barriers on any ASE calculator, against closed forms, the exact search and one-dimensional minimisation."""

from typing import Any

import ase
import numpy as np
import pytest
from ase.calculators.calculator import Calculator, all_changes
from ase.calculators.ff import ForceField
from ase.calculators.lj import LennardJones
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms
from ase.utils.ff import Bond
from scipy.optimize import minimize_scalar
from scipy.spatial import KDTree

import origins
from origins import InputError, relaxed_barrier, substrate_calculator

SQUARE = origins.square_substrate()
PERIODS = 2.0 * np.pi * np.eye(2)


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


class Wells(Calculator):
    """-exp(1.5 (cos x + cos y - 2)), which is no finite Fourier series; `wrong` forces are of another energy."""

    implemented_properties = ["energy", "forces"]  # noqa: RUF012

    def __init__(self, wrong: float = 1.0, energy: float | None = None) -> None:
        super().__init__()
        self.wrong, self.given = wrong, energy

    def calculate(
        self, atoms: Any = None, properties: Any = None, system_changes: Any = all_changes
    ) -> None:
        super().calculate(atoms, properties, system_changes)
        if self.given == 0.0:
            raise RuntimeError("no licence\nfor this machine")
        x, y = self.atoms.positions[:, :2].T
        depth = np.exp(1.5 * (np.cos(x) + np.cos(y) - 2.0))
        forces = (
            -1.5 * self.wrong * np.column_stack([np.sin(x) * depth, np.sin(y) * depth, 0.0 * x])
        )
        self.results = {
            "energy": -float(depth.sum()) if self.given is None else self.given,
            "forces": forces,
        }


@pytest.mark.parametrize("substrate", [SQUARE, random_substrate(3, 7)])
def test_forces_are_those_of_the_energy(substrate: origins.Substrate) -> None:
    island = turned(origins.triangular_island(2.4, 5, 4), 0.3)
    island.calc = substrate_calculator(substrate)
    forces, energy = island.get_forces(), island.get_potential_energy()
    assert (
        island.get_potential_energies().sum() == pytest.approx(energy, abs=1e-12)
        and not forces[:, 2].any()
    )
    factors = substrate.coefficients * np.exp(
        1j * (island.positions[:, :2] @ substrate.wavevectors.T)
    ).sum(0)
    assert energy == pytest.approx(substrate.constant + factors.real.sum(), abs=1e-11)
    assert forces[:, :2].sum(0) == pytest.approx(factors.imag @ substrate.wavevectors, abs=1e-11)
    island.positions[0, 0] += 5e-16  # a step that ASE's own comparison overlooks
    assert island.calc.calculation_required(island, ["energy"])


def test_bonds_are_those_of_ase_force_field() -> None:
    island = origins.triangular_island(2.5, 4, 4)
    pairs = KDTree(island.positions).query_pairs(2.6)
    assert len(pairs) == 33
    shaken = island.copy()
    shaken.positions += 0.3 * np.random.default_rng(5).standard_normal((16, 3))
    shaken.cell = [100.0, 100.0, 100.0]  # the force field wants one
    field = ForceField(bonds=[Bond(i, j, k=3.0, b0=2.5) for i, j in pairs])
    bonds = origins.harmonic_bonds(island, 3.0)
    assert bonds.get_potential_energy(shaken) == pytest.approx(
        field.get_potential_energy(shaken), rel=1e-12
    )
    assert bonds.get_forces(shaken) == pytest.approx(field.get_forces(shaken), abs=1e-11)
    assert bonds.get_potential_energy(island) == pytest.approx(0.0, abs=1e-25)
    longer = origins.harmonic_bonds(island, 3.0, reach=5.1)
    assert longer.get_potential_energy(shaken) > bonds.get_potential_energy(shaken)


def test_random_rigid_islands_climb_what_the_closed_form_says() -> None:
    rng = np.random.default_rng(7)
    for _ in range(8):
        a, angle = float(rng.uniform(1.5, 7.0)), float(rng.uniform(0.0, 2.0 * np.pi))
        n_i, n_j = (int(n) for n in rng.integers(1, 21, 2))
        island = turned(origins.triangular_island(a, n_i, n_j), angle)
        found = relaxed_barrier(island, substrate_calculator(SQUARE))
        off = abs(found.barrier - origins.triangular_barrier(a, n_i, n_j, angle))
        assert off <= found.barrier_error < 1e-9
        for place in (found.minimum, found.saddle):
            # what forces remain are promised to cost no more; curvatures are at most 1 for each atom
            assert (place.get_forces().sum(0) ** 2).sum() <= 2.0 * len(island) * found.barrier_error
            shift = place.positions - island.positions
            assert np.abs(shift - shift[0]).max() < 1e-12 and not shift[:, 2].any()


@pytest.mark.parametrize("seed", [51, 106, 325])
def test_other_substrates_climb_what_the_exact_search_says(seed: int) -> None:
    # in the first Newton's steps may go back and forth for ever, in the second two saddles lie close by
    substrate = random_substrate(seed, 7)
    for island, angle in (
        (ase.Atoms("H", positions=[[0, 0, 0]]), 0.0),
        (origins.irregular_island(2.6, 6.0), 1.0),
    ):
        found = relaxed_barrier(turned(island, angle), substrate_calculator(substrate))
        assert (
            abs(found.barrier - origins.barrier(island, angle, substrate))
            <= found.barrier_error + 1e-10
        )


def test_wells_of_all_harmonics() -> None:
    found = relaxed_barrier(ase.Atoms("H", positions=[[0.3, 0.0, 0.0]]), Wells(), periods=PERIODS)
    assert abs(found.barrier - (1.0 - np.exp(-3.0))) <= found.barrier_error < 1e-13
    assert 10 < found.evaluations < 5_000 and found.run_time > 0.0


def test_atom_on_a_slab_of_lennard_jones_atoms() -> None:
    # by symmetry the minimum is over the hollow and the saddle over the bridge; heights follow
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

        return float(
            minimize_scalar(
                energy, bounds=(0.5, 1.5), method="bounded", options={"xatol": 1e-9}
            ).fun
        )

    before = atoms.positions.copy()
    found = relaxed_barrier(atoms, own, planar=False, periods=1.1 * np.eye(2))
    assert found.barrier == pytest.approx(lowest(0.55, 0.0) - lowest(0.55, 0.55), abs=1e-7)
    assert np.array_equal(found.minimum.positions[:9], spots)
    assert np.array_equal(atoms.positions, before) and atoms.calc is own


def dimer_barrier(length: float, angle: float, stiffness: float) -> float:
    """Two atoms on sin x + sin y that one bond joins, its direction held: c_x(s) sin X + c_y(s) sin Y + K s²/2."""

    def level(wave: tuple[float, float]) -> float:
        def energy(stretch: np.ndarray) -> np.ndarray:
            apart = length + stretch
            x, y = (
                2.0 * np.cos(0.5 * apart * np.cos(angle)),
                2.0 * np.cos(0.5 * apart * np.sin(angle)),
            )
            return wave[0] * np.abs(x) + wave[1] * np.abs(y) + 0.5 * stiffness * stretch**2

        grid = np.linspace(-0.9, 0.9, 1801)
        best = grid[energy(grid).argmin()]
        found = minimize_scalar(
            energy, bounds=(best - 1e-3, best + 1e-3), method="bounded", options={"xatol": 1e-12}
        )
        return float(found.fun)

    return min(level((1.0, -1.0)), level((-1.0, 1.0))) - level((-1.0, -1.0))


def test_two_atoms_on_a_spring() -> None:
    atoms = turned(ase.Atoms(numbers=[0, 0], positions=[[0, 0, 0], [2.2, 0, 0]]), 0.6)
    calculator = SumCalculator([substrate_calculator(SQUARE), origins.harmonic_bonds(atoms, 5.0)])
    found = relaxed_barrier(atoms, calculator, rigid=False)
    assert abs(found.barrier - dimer_barrier(2.2, 0.6, 5.0)) <= found.barrier_error + 4e-15
    assert found.barrier_error < 1e-12
    for place in (found.minimum, found.saddle):
        moved, rest = place.positions - atoms.positions, atoms.positions - atoms.positions.mean(0)
        assert (rest[:, 0] * moved[:, 1] - rest[:, 1] * moved[:, 0]).sum() == pytest.approx(
            0.0, abs=1e-14
        )


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9])
def test_rows_out_of_step_slide_freely(off: float) -> None:
    island = origins.triangular_island(2.0 * np.pi * (1.0 + off), 5, 4)
    found = relaxed_barrier(island, substrate_calculator(SQUARE))
    assert abs(found.barrier - origins.barrier(island, 0.0)) <= found.barrier_error < 1e-10


@pytest.mark.parametrize("period", [1e-9, 1e9])
def test_any_unit_of_length(period: float) -> None:
    atoms = ase.Atoms("H", positions=[[0.1 * period, 0.05 * period, 0.0]])
    found = relaxed_barrier(atoms, substrate_calculator(origins.square_substrate(1.0, period)))
    assert abs(found.barrier - 2.0) <= found.barrier_error < 1e-12


ISLAND = origins.triangular_island(2.5, 2, 2)
ON = substrate_calculator(SQUARE)
TWO = SumCalculator([ON, substrate_calculator(origins.square_substrate(1.0, 3.0))])


@pytest.mark.parametrize(
    ("calculator", "keywords", "message"),
    [
        (Wells(energy=0.0), {"periods": PERIODS}, "calculator = 'RuntimeError: no licence'"),
        (Wells(energy=np.nan), {"periods": PERIODS}, "calculator = nan: must give finite"),
        (Wells(wrong=0.0), {"periods": PERIODS}, "calculator = 'no force anywhere'"),
        (Wells(wrong=1.5), {"periods": PERIODS}, "calculator = .*forces must be those of its"),
        (Wells(), {}, "periods = None: must be given"),
        (TWO, {}, "periods = None: must be given, as the parts"),
        (Wells(), {"periods": 3.0 * np.eye(2)}, "periods = .*must leave energies"),
    ],
)
def test_calculators_that_cannot_serve_are_refused_in_one_line(
    calculator: Any, keywords: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=f"^{message}") as caught:
        relaxed_barrier(ISLAND, calculator, **keywords)
    assert "\n" not in str(caught.value)
