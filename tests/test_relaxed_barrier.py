"""Barriers by ASE's relaxation and elastic bands, against closed forms, the exact search and plain scans."""

import heapq
from typing import Any

import ase
import numpy as np
import pytest
from ase.calculators.calculator import Calculator, all_changes
from ase.calculators.ff import ForceField
from ase.calculators.lj import LennardJones
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms, FixedLine
from ase.utils.ff import Bond
from scipy.optimize import minimize_scalar, root

import origins
from origins import InputError, relaxed_barrier, substrate_calculator

SQUARE = origins.square_substrate()


def turned(island: ase.Atoms, angle: float) -> ase.Atoms:
    copy = island.copy()
    copy.rotate(np.degrees(angle), "z", center="COM")
    return copy


def random_substrate(rng: np.random.Generator, waves: int) -> origins.Substrate:
    indices = np.array([[1, 0], [0, 1], [1, 1], [1, -1], [2, 0], [0, 2], [2, 1]])[:waves]
    basis = [[1.0, 0.0], [rng.uniform(-0.6, 0.6), rng.uniform(0.7, 1.3)]]
    return origins.fourier_substrate(indices @ basis, rng.normal(size=waves) + 1j * rng.normal(size=waves))


class Bumps(Calculator):
    """exp(cos x) + 0.7 exp(cos y + 0.4 sin x): every harmonic there is, in cells of 2 pi."""

    implemented_properties = ["energy", "forces"]  # noqa: RUF012

    def calculate(self, atoms: Any = None, properties: Any = None, system_changes: Any = all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        x, y = self.atoms.positions[:, :2].T
        one, other = np.exp(np.cos(x)), 0.7 * np.exp(np.cos(y) + 0.4 * np.sin(x))
        forces = np.column_stack([np.sin(x) * one - 0.4 * np.cos(x) * other, np.sin(y) * other, 0.0 * x])
        self.results = {"energy": float((one + other).sum()), "forces": forces}


class Wells(Calculator):
    """-exp(k (cos x + cos y - 2)): the flatter between the wells the larger k."""

    implemented_properties = ["energy", "forces"]  # noqa: RUF012

    def __init__(self, steepness: float) -> None:
        super().__init__()
        self.steepness = steepness

    def calculate(self, atoms: Any = None, properties: Any = None, system_changes: Any = all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        x, y = self.atoms.positions[:, :2].T
        depth = np.exp(self.steepness * (np.cos(x) + np.cos(y) - 2.0))
        forces = -self.steepness * np.column_stack([np.sin(x) * depth, np.sin(y) * depth, 0.0 * x])
        self.results = {"energy": -float(depth.sum()), "forces": forces}


def scanned(energy: Any, gradient: Any, cell: np.ndarray, n: int = 90) -> float:
    """Barrier by filling a plain map up to its first way around, both its ends polished by scipy's root."""
    places = np.stack(np.meshgrid(*[np.arange(n) / n] * 2, indexing="ij"), -1) @ cell
    heights = energy(places)
    start = tuple(int(k) for k in np.unravel_index(heights.argmin(), heights.shape))
    heap, seen, top = [(heights[start], start)], {}, (-np.inf, start)
    while heap:
        level, node = heapq.heappop(heap)
        top = max(top, (level, node))
        wrapped = node[0] % n, node[1] % n
        if wrapped in seen and seen[wrapped] != node:
            break
        if wrapped in seen:
            continue
        seen[wrapped] = node
        for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)):
            near = node[0] + i, node[1] + j
            heapq.heappush(heap, (heights[near[0] % n, near[1] % n], near))
    ends = [root(gradient, np.array(node) / n @ cell, tol=1e-13) for node in (start, top[1])]
    step = 2.0 * np.linalg.norm(cell / n)
    for end, node in zip(ends, (start, top[1]), strict=True):
        assert np.linalg.norm(end.x - np.array(node) / n @ cell) < step
    return float(energy(ends[1].x) - energy(ends[0].x))


@pytest.mark.parametrize(
    "substrate", [SQUARE, origins.hexagonal_substrate(-0.7, 3.0), random_substrate(np.random.default_rng(3), 7)]
)
def test_forces_are_those_of_the_energy(substrate: origins.Substrate) -> None:
    island = turned(origins.triangular_island(2.4, 5, 4), 0.3)
    island.calc = substrate_calculator(substrate)
    forces, energy = island.get_forces(), island.get_potential_energy()
    assert forces.shape == (20, 3) and not forces[:, 2].any()
    assert island.get_potential_energies().sum() == pytest.approx(energy, abs=1e-12)
    step = 1e-5
    for atom, axis in ((0, 0), (7, 1), (19, 0), (11, 2)):
        ends = []
        for sign in (1.0, -1.0):
            moved = island.copy()
            moved.calc = island.calc
            moved.positions[atom, axis] += sign * step
            ends.append(moved.get_potential_energy())
        assert forces[atom, axis] == pytest.approx((ends[1] - ends[0]) / (2.0 * step), abs=1e-8)
    # a cell further on everything is as it was, and all forces together are the slope of the rigid island's energy
    factors = substrate.coefficients * np.exp(1j * (island.positions[:, :2] @ substrate.wavevectors.T)).sum(0)
    assert forces[:, :2].sum(0) == pytest.approx(factors.imag @ substrate.wavevectors, abs=1e-11)
    island.positions[:, :2] += 3.0 * substrate.cell[0] - substrate.cell[1]
    assert island.get_forces() == pytest.approx(forces, abs=1e-11)
    assert island.get_potential_energy() == pytest.approx(energy, abs=1e-11)


def test_forces_of_the_square_substrate_in_closed_form() -> None:
    atoms = ase.Atoms(numbers=[0, 0], positions=np.random.default_rng(1).normal(0.0, 9.0, (2, 3)))
    atoms.calc = substrate_calculator(origins.square_substrate(1.7, 2.5))
    q, flat = 2.0 * np.pi / 2.5, atoms.positions[:, :2]
    assert atoms.get_potential_energies() == pytest.approx(1.7 * np.sin(q * flat).sum(1), abs=1e-13)
    assert atoms.get_forces()[:, :2] == pytest.approx(-1.7 * q * np.cos(q * flat), abs=1e-12)
    atoms.positions[0, 0] += 5e-16  # a step that ASE's own comparison overlooks
    assert atoms.calc.calculation_required(atoms, ["energy"])


def test_bonds_are_those_of_ase_force_field() -> None:
    rng = np.random.default_rng(5)
    island = origins.triangular_island(2.5, 4, 4)
    bonds = origins.harmonic_bonds(island, 3.0)
    assert len(bonds.pairs) == 33
    shaken = island.copy()
    shaken.positions += 0.3 * rng.standard_normal((16, 3))
    shaken.cell = [100.0, 100.0, 100.0]  # the force field wants one
    field = ForceField(bonds=[Bond(int(i), int(j), k=3.0, b0=2.5) for i, j in bonds.pairs])
    assert bonds.get_potential_energy(shaken) == pytest.approx(field.get_potential_energy(shaken), rel=1e-12)
    assert bonds.get_forces(shaken) == pytest.approx(field.get_forces(shaken), abs=1e-11)
    assert bonds.get_forces(shaken).sum(0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert bonds.get_potential_energy(island) == pytest.approx(0.0, abs=1e-25)
    assert len(origins.harmonic_bonds(island, 3.0, reach=5.1).pairs) > 60


def test_random_rigid_islands_climb_what_the_closed_form_says() -> None:
    rng = np.random.default_rng(7)
    calculator = substrate_calculator(SQUARE)
    for _ in range(20):
        a, angle = float(rng.uniform(1.5, 7.0)), float(rng.uniform(0.0, 2.0 * np.pi))
        n_i, n_j = (int(n) for n in rng.integers(1, 21, 2))
        island = turned(origins.triangular_island(a, n_i, n_j), angle)
        found = relaxed_barrier(island, calculator)
        off = abs(found.barrier - origins.triangular_barrier(a, n_i, n_j, angle))
        assert off <= found.barrier_error < 1e-9
        for place in (found.minimum, found.saddle):
            # what forces remain are promised to cost no more than barrier_error; curvatures are at most 1 for each atom
            assert (place.get_forces().sum(0) ** 2).sum() <= 2.0 * len(island) * found.barrier_error
            shift = place.positions - island.positions
            assert np.abs(shift - shift[0]).max() < 1e-12 and not shift[:, 2].any()
        between = found.saddle.get_potential_energy() - found.minimum.get_potential_energy()
        assert between == pytest.approx(found.barrier, abs=1e-12)


def test_random_rigid_islands_on_other_substrates_climb_what_the_exact_search_says() -> None:
    rng = np.random.default_rng(11)
    for k in range(9):
        if k % 3 < 2:
            substrate = origins.hexagonal_substrate([1.0, -1.0][k % 3])
        else:
            substrate = random_substrate(rng, int(rng.integers(3, 8)))
        island = origins.irregular_island(float(rng.uniform(1.5, 7.0)), float(rng.uniform(2.0, 20.0)), seed=k)
        angle = float(rng.uniform(0.0, 2.0 * np.pi))
        found = relaxed_barrier(turned(island, angle), substrate_calculator(substrate))
        off = abs(found.barrier - origins.barrier(island, angle, substrate))
        assert off <= found.barrier_error + 1e-11 * len(island)


@pytest.mark.parametrize("seed", [51, 106, 325])
def test_landscapes_that_are_hard_to_search(seed: int) -> None:
    # in the first Newton's steps by old curvatures go back and forth for ever, in the second two saddles lie close by,
    # in the last a band strays from the way it is laid on
    atom = ase.Atoms("H", positions=[[0, 0, 0]])
    substrate = random_substrate(np.random.default_rng(seed), 7)
    found = relaxed_barrier(atom, substrate_calculator(substrate))
    assert abs(found.barrier - origins.barrier(atom, 0.0, substrate)) <= found.barrier_error + 1e-10


def test_another_calculator_gives_another_barrier() -> None:
    island = turned(origins.triangular_island(2.5, 4, 3), 0.2)
    found = relaxed_barrier(island, Bumps(), periods=2.0 * np.pi * np.eye(2))
    x0, y0 = island.positions[:, :2].T

    def terms(place: np.ndarray) -> tuple[np.ndarray, ...]:
        x, y = x0 + place[..., :1], y0 + place[..., 1:]
        return x, y, np.exp(np.cos(x)), 0.7 * np.exp(np.cos(y) + 0.4 * np.sin(x))

    def energy(place: np.ndarray) -> np.ndarray:
        _, _, one, other = terms(place)
        return (one + other).sum(-1)

    def gradient(place: np.ndarray) -> np.ndarray:
        x, y, one, other = terms(place)
        return np.array([(-np.sin(x) * one + 0.4 * np.cos(x) * other).sum(-1), (-np.sin(y) * other).sum(-1)])

    exact = scanned(energy, gradient, 2.0 * np.pi * np.eye(2))
    assert found.barrier == pytest.approx(exact, abs=1e-9)
    assert abs(found.barrier - relaxed_barrier(island, substrate_calculator(SQUARE)).barrier) > 0.1


def test_atom_on_a_slab_of_lennard_jones_atoms() -> None:
    # by symmetry the minimum is over the hollow and the saddle over the bridge; heights follow
    spots = 1.1 * np.array([[i, j, 0.0] for i in range(3) for j in range(3)])
    slab = ase.Atoms("Ar9", positions=spots, cell=[3.3, 3.3, 20.0], pbc=[True, True, False])
    atoms = slab + ase.Atoms("Ar", positions=[[0.1, 0.2, 0.9]])
    atoms.set_constraint(FixAtoms(range(9)))
    settings = {"sigma": 1.0, "epsilon": 1.0, "rc": 2.0, "ro": 1.5, "smooth": True}

    def lowest(x: float, y: float) -> float:
        probe = atoms.copy()
        probe.calc = LennardJones(**settings)

        def energy(z: float) -> float:
            probe.positions[-1] = x, y, z
            return float(probe.get_potential_energy())

        return float(minimize_scalar(energy, bounds=(0.5, 1.5), method="bounded", options={"xatol": 1e-9}).fun)

    periods = 1.1 * np.eye(2)
    found = relaxed_barrier(atoms, LennardJones(**settings), rigid=False, planar=False, periods=periods)
    assert found.barrier == pytest.approx(lowest(0.55, 0.0) - lowest(0.55, 0.55), abs=1e-7)
    assert found.minimum.positions[:9] == pytest.approx(spots, abs=0.0)
    rigid = relaxed_barrier(atoms, LennardJones(**settings), planar=False, periods=periods)
    assert rigid.barrier == pytest.approx(found.barrier, abs=1e-8)


def dimer_barrier(length: float, angle: float, stiffness: float) -> float:
    """Two atoms on sin x + sin y that one bond joins, its direction held: c_x(s) sin X + c_y(s) sin Y + K s²/2."""

    def level(wave: tuple[float, float]) -> float:
        def energy(stretch: np.ndarray) -> np.ndarray:
            apart = length + stretch
            x, y = 2.0 * np.cos(0.5 * apart * np.cos(angle)), 2.0 * np.cos(0.5 * apart * np.sin(angle))
            return wave[0] * np.abs(x) + wave[1] * np.abs(y) + 0.5 * stiffness * stretch**2

        grid = np.linspace(-0.9, 0.9, 1801)
        best = grid[energy(grid).argmin()]
        found = minimize_scalar(energy, bounds=(best - 1e-3, best + 1e-3), method="bounded", options={"xatol": 1e-12})
        return float(found.fun)

    return min(level((1.0, -1.0)), level((-1.0, 1.0))) - level((-1.0, -1.0))


@pytest.mark.parametrize("stiffness", [1e4, 5.0])
def test_two_atoms_on_a_spring(stiffness: float) -> None:
    atoms = turned(ase.Atoms(numbers=[0, 0], positions=[[0, 0, 0], [2.2, 0, 0]]), 0.6)
    calculator = SumCalculator([substrate_calculator(SQUARE), origins.harmonic_bonds(atoms, stiffness)])
    found = relaxed_barrier(atoms, calculator, rigid=False)
    assert abs(found.barrier - dimer_barrier(2.2, 0.6, stiffness)) <= found.barrier_error + 4e-15
    assert found.barrier_error < 1e-12
    for place in (found.minimum, found.saddle):
        moved = place.positions - atoms.positions
        rest = atoms.positions - atoms.positions.mean(0)
        assert (rest[:, 0] * moved[:, 1] - rest[:, 1] * moved[:, 0]).sum() == pytest.approx(0.0, abs=1e-14)


def test_one_free_atom() -> None:
    atoms = ase.Atoms(numbers=[0], positions=[[1.0, 2.0, 0.5]])
    found = relaxed_barrier(atoms, substrate_calculator(SQUARE), rigid=False)
    assert found.barrier == pytest.approx(2.0, abs=1e-12)
    assert found.minimum.positions[0, 2] == 0.5


def test_flexible_island_tends_to_the_rigid_one() -> None:
    island = turned(origins.triangular_island(2.5, 3, 3), 0.3)
    substrate = substrate_calculator(SQUARE)
    rigid = relaxed_barrier(island, substrate)
    lows, tops = [], []
    for stiffness in (1e3, 1e2):
        calculator = SumCalculator([substrate, origins.harmonic_bonds(island, stiffness)])
        found = relaxed_barrier(island, calculator, rigid=False)
        lows.append(rigid.minimum.get_potential_energy() - found.minimum.get_potential_energy())
        tops.append(rigid.saddle.get_potential_energy() - found.saddle.get_potential_energy())
    # strain gains energy as 1/stiffness, at the saddle as at the minimum: the barrier may change either way
    for gains in (lows, tops):
        assert 0.0 < gains[0] < gains[1]
        assert gains[1] / gains[0] == pytest.approx(10.0, rel=0.05)
    assert abs(lows[0] - tops[0]) < 1e-2


def test_islands_that_slide_freely() -> None:
    for apart in ([np.pi, 0.0, 0.0], [np.pi, np.pi, 0.0]):
        atoms = ase.Atoms(numbers=[0, 0], positions=[[0, 0, 0], apart])
        found = relaxed_barrier(atoms, substrate_calculator(SQUARE))
        assert found.barrier <= found.barrier_error < 1e-12
    assert origins.barrier(atoms, 0.0) < 1e-12
    # in a channel: the rows are out of step along x
    for off in (0.0, 1e-12, 1e-9):
        island = origins.triangular_island(2.0 * np.pi * (1.0 + off), 5, 4)
        found = relaxed_barrier(island, substrate_calculator(SQUARE))
        assert abs(found.barrier - origins.barrier(island, 0.0)) <= found.barrier_error < 1e-10


@pytest.mark.parametrize("start", [0.0, 0.3])
@pytest.mark.parametrize("steepness", [1.0, 1.5])
def test_narrow_wells_apart_from_one_another(start: float, steepness: float) -> None:
    atoms = ase.Atoms("H", positions=[[start, 0.0, 0.0]])
    found = relaxed_barrier(atoms, Wells(steepness), periods=2.0 * np.pi * np.eye(2))
    assert abs(found.barrier - (1.0 - np.exp(-2.0 * steepness))) <= found.barrier_error < 1e-13
    assert found.evaluations < 5_000


@pytest.mark.parametrize("period", [1e-9, 25.0, 1e9])
def test_any_unit_of_length(period: float) -> None:
    atoms = ase.Atoms("H", positions=[[0.1 * period, 0.05 * period, 0.0]])
    found = relaxed_barrier(atoms, substrate_calculator(origins.square_substrate(1.0, period)))
    assert abs(found.barrier - 2.0) <= found.barrier_error < 1e-12


def test_the_atoms_given_stay_as_they_are() -> None:
    atoms = origins.triangular_island(2.5, 2, 2)
    atoms.calc = LennardJones()
    before = atoms.positions.copy()
    found = relaxed_barrier(atoms, substrate_calculator(SQUARE))
    assert np.array_equal(atoms.positions, before) and isinstance(atoms.calc, LennardJones)
    assert found.evaluations > 10 and found.run_time > 0.0


class Broken(Calculator):
    implemented_properties = ["energy", "forces"]  # noqa: RUF012

    def __init__(self, energy: float | None) -> None:
        super().__init__()
        self.given = energy

    def calculate(self, atoms: Any = None, properties: Any = None, system_changes: Any = all_changes) -> None:
        if self.given is None:
            raise RuntimeError("no licence\nfor this machine")
        self.results = {"energy": self.given, "forces": np.zeros((len(atoms), 3))}


class Wrong(Bumps):
    """Forces of another energy."""

    def calculate(self, atoms: Any = None, properties: Any = None, system_changes: Any = all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        self.results["forces"] = 1.5 * self.results["forces"]


ISLAND = origins.triangular_island(2.5, 2, 2)
PERIODS = 2.0 * np.pi * np.eye(2)
LINE = origins.triangular_island(2.5, 2, 2)
LINE.set_constraint(FixedLine(0, [1, 0, 0]))
FIXED = origins.triangular_island(2.5, 2, 2)
FIXED.set_constraint(FixAtoms(range(4)))
FAR = ase.Atoms("H", positions=[[np.nan, 0, 0]])
ON = substrate_calculator(SQUARE)
TWO = SumCalculator([ON, substrate_calculator(origins.square_substrate(1.0, 3.0))])


@pytest.mark.parametrize(
    ("atoms", "calculator", "keywords", "message"),
    [
        (np.zeros((3, 3)), ON, {}, "atoms = array of shape"),
        (ase.Atoms(), ON, {}, "atoms = Atoms.*at least one atom"),
        (FAR, ON, {}, "atoms = Atoms.*finite positions"),
        (LINE, ON, {}, "atoms.constraints = .*FixAtoms"),
        (FIXED, ON, {}, "atoms = .*FixAtoms does not fix"),
        (ISLAND, SQUARE, {}, "calculator = .*ASE calculator"),
        (ISLAND, Broken(None), {"periods": PERIODS}, "calculator = 'RuntimeError: no licence'"),
        (ISLAND, Broken(np.nan), {"periods": PERIODS}, "calculator = nan: must give finite"),
        (ISLAND, Broken(1.0), {"periods": PERIODS}, "calculator = 'no force anywhere'"),
        (ISLAND, Wrong(), {"periods": PERIODS}, "calculator = .*forces must be those of its energy"),
        (ISLAND, Bumps(), {}, "periods = None: must be given"),
        (ISLAND, TWO, {}, "periods = None: must be given, as the parts"),
        (ISLAND, Bumps(), {"periods": 3.0 * np.eye(2)}, "periods = .*must leave energies"),
        (ISLAND, ON, {"periods": [[1.0, 0.0], [1.0]]}, "periods = .*two vectors"),
        (ISLAND, ON, {"periods": [[1.0, 0.0], [2.0, 0.0]]}, "periods = .*not parallel"),
        (ISLAND, ON, {"rigid": 1}, "rigid = 1: must be True or False"),
        (origins.triangular_island(2.5, 40, 40), ON, {"rigid": False}, "atoms = .*at most 1500"),
    ],
)
def test_bad_input_is_refused_in_one_line(atoms: Any, calculator: Any, keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}") as caught:
        relaxed_barrier(atoms, calculator, **keywords)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "keywords", "message"),
    [
        ((ISLAND, 0.0), {}, "stiffness = 0.0: must be above zero"),
        ((np.zeros(3), 1.0), {}, "atoms = "),
        ((ase.Atoms("H"), 1.0), {}, "atoms = .*at least two"),
        ((ase.Atoms("H2"), 1.0), {}, "atoms = .*in one place"),
        ((ISLAND, 1.0), {"reach": 1.0}, "reach = 1.0: bonds no atoms"),
    ],
)
def test_bonds_that_cannot_be_are_refused(arguments: Any, keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        origins.harmonic_bonds(*arguments, **keywords)


def test_calculator_of_no_substrate_is_refused() -> None:
    with pytest.raises(InputError, match="substrate = 'square': must be a Substrate"):
        substrate_calculator("square")  # type: ignore[arg-type]
    level = substrate_calculator(origins.fourier_substrate([[1.0, 0.0]], [1.0]))
    with pytest.raises(InputError, match="all parallel"):
        relaxed_barrier(ISLAND, level)
