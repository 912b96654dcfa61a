"""Rotated domains: P_c over angles, sizes, energies; from forces to thresholds; in scenes."""

from pathlib import Path

import ase.io
import numpy as np
import pytest
from ase.calculators.mixing import SumCalculator
from scenes import scene
from scipy import stats
from scipy.optimize import minimize_scalar

import master
import origins
import toolkit
from origins import Contacts
from toolkit.scene.interfaces import doubts
from toolkit.scene.of_samples import of_islands

A = 2.5
SETTINGS = {"lattice_constant": A, "mean_atoms": 60.0, "stiffness": 1.0, "samples": 2000, "seed": 3}


@pytest.mark.parametrize("law", ["equal", "area", "paper"])
def test_laws_from_force_to_threshold(law: str) -> None:
    scale = {"stiffness": None, "coefficient": 4.0} if law == "paper" else {}
    found = origins.domains(**SETTINGS | scale, law=law)
    record, root = found.domains, np.sqrt(found.domains.n_atoms * -np.expm1(-1.0 / 60.0))
    force = record.barriers / record.period
    expected = {"equal": force, "area": force / root, "paper": np.sqrt(force / 4.0)}[law]
    same, x = origins.from_samples(expected), np.quantile(expected, [0.01, 0.1, 0.5, 0.9, 0.99])
    np.testing.assert_allclose(found.cdf(x), same.cdf(x), rtol=0.0, atol=1e-13)
    # k = c x_s in the paper's, so the mean force is that of k x_s
    stiffness = {"equal": 1.0, "area": root.mean(), "paper": 4.0 * expected.mean()}[law]
    assert record.mean_stiffness == pytest.approx(stiffness, rel=1e-12)


def test_sizes_fall_off_exponentially() -> None:
    """exp(-N/30) over N, each N made as n_i n_j with n_j = (4/3)^(1/4) N^(1/2) and n_i = N/n_j, rounded."""
    record = origins.domains(A, mean_atoms=30.0, stiffness=1.0, samples=40_000).domains
    count = np.arange(1, 2000)
    rows = np.maximum(np.rint(np.sqrt(2.0 * count / np.sqrt(3.0))), 1.0)
    made = (np.maximum(np.rint(count / rows), 1.0) * rows).astype(int)
    share = np.bincount(made, np.exp(-count / 30.0) * np.expm1(1.0 / 30.0), minlength=2500)
    found = np.bincount(record.n_atoms, minlength=2500)[:2500] / 40_000
    often = share > 1e-3
    assert often.sum() > 30 and (np.abs(found - share) < 5.0 * np.sqrt(share / 40_000))[often].all()
    assert (np.abs(made - count) <= rows / 2).all()


def test_angles_by_their_energy() -> None:
    """Mean barrier and mean cos 4 phi against the integral over exp(-U_min/k_BT), U_min = -|S_x| - |S_y|."""
    temperature = 0.3
    law = origins.domains(A, sizes=[(9, 8)], temperature=temperature, stiffness=1.0, samples=40_000)
    grid = 2.0 * np.pi * (np.arange(100_000) + 0.5) / 100_000
    factors = np.abs(origins.structure_factors(origins.triangular_island(A, 9, 8), grid))
    weight = np.exp((factors.sum(-1) - factors.sum(-1).max()) / temperature)
    record = law.domains
    for drawn, known in (
        (record.barriers, 2.0 * factors.min(-1)),
        (np.cos(4.0 * record.angles), np.cos(4.0 * grid)),
    ):
        mean = (weight * known).sum() / weight.sum()
        spread = np.sqrt((weight * (known - mean) ** 2).sum() / weight.sum() / 40_000)
        assert abs(drawn.mean() - mean) < 5.0 * spread
    share = np.cumsum(weight) / weight.sum()
    law_of_angles = stats.kstest(record.angles % (2.0 * np.pi), lambda x: np.interp(x, grid, share))
    assert law_of_angles.pvalue > 1e-4


def test_islands_without_a_barrier_are_left_out_and_told() -> None:
    """At phi = 0 rows of four at a quarter period slide freely; the other angle holds."""
    law = origins.domains(np.pi / 2, sizes=[(4, 3)], angles=[0.0, 0.4], stiffness=1.0, samples=1000)
    record = law.domains
    assert record.superlubric_weight == 0.5 and record.forces.size == 500
    assert (record.barriers[::2] == 0.0).all()
    np.testing.assert_array_equal(record.angles, np.tile([0.0, 0.4], 500))
    assert law.mean() == pytest.approx(
        origins.triangular_barrier(np.pi / 2, 4, 3, 0.4) / (2.0 * np.pi), rel=1e-12
    )
    assert record.mean_force == pytest.approx(law.mean(), rel=1e-12)


def test_few_listed_angles_are_told_of() -> None:
    """Up to 8 barriers are exact values; of more F_k is theirs, and K* hangs on the smoothing, as a note says."""
    angles = np.linspace(0.0, 0.4, 11)
    each = {"sizes": [(5, 4)], "stiffness": 1.0, "samples": 440}
    exact, smooth = (origins.domains(A, angles=angles[:n], **each) for n in (5, 11))
    assert exact.atoms[0].size == 5 and not of_islands(exact)
    assert not smooth.atoms[0].size
    values = np.unique(smooth.domains.barriers) / (2.0 * np.pi)
    kinetic = (values @ values) / (2.0 * values.sum())
    assert master.steady_state(Contacts(smooth)).force == pytest.approx(kinetic, rel=0.02)
    (note,) = of_islands(smooth)
    assert "11 listed angles" in note and "hangs on the smoothing" in note


# -- one island over all angles --------------------------------------------------------------------


def force(n_i: int, n_j: int, angle: np.ndarray) -> np.ndarray:
    return origins.triangular_barrier(A, n_i, n_j, angle) / (2.0 * np.pi)


def counted(n_i: int, n_j: int, number: int = 400_000) -> np.ndarray:
    return np.sort(force(n_i, n_j, 2.0 * np.pi * (np.arange(number) + 0.5) / number))


@pytest.fixture(scope="module")
def island_law() -> origins.Thresholds:
    return origins.domains(A, sizes=[(5, 4)], stiffness=1.0, samples=100)


def test_shares_and_moments_are_those_of_a_fine_grid_of_angles() -> None:
    n_i, n_j = 2, 2
    exact = counted(n_i, n_j)
    island_law = origins.domains(A, sizes=[(n_i, n_j)], stiffness=1.0, samples=100)
    x = np.quantile(exact, np.linspace(0.001, 0.999, 500))
    share = np.searchsorted(exact, x) / exact.size
    # where b stands still the grid itself misses the root of its spacing
    assert np.abs(island_law.cdf(x) - share).max() < 4e-5
    assert np.abs(island_law.sf(x) - (1.0 - share)).max() < 4e-5
    assert np.abs(island_law.cdf(island_law.ppf(share[10:-10])) - share[10:-10]).max() < 1e-7
    assert island_law.mean() == pytest.approx(exact.mean(), rel=1e-9)
    assert island_law.std() == pytest.approx(exact.std(), rel=1e-8)
    assert island_law.moment(3) == pytest.approx((exact**3).mean(), rel=1e-8)
    # the grid misses a ridge by its spacing times the slope
    assert island_law.support()[1] == pytest.approx(exact[-1], rel=1e-4)
    assert island_law.support()[1] >= exact[-1]


def test_peaks_stand_where_the_barrier_stands_still(island_law: origins.Thresholds) -> None:
    """By scipy's search between the crossings of |S_x| and |S_y|: there P_c is an inverse square root."""
    angles = np.linspace(0.0, np.pi / 2, 4001)
    b = force(5, 4, angles)
    waves = np.abs(origins.triangular_structure_factors(A, 5, 4, angles))
    first = waves[:, 0] < waves[:, 1]
    tops = [
        k
        for k in range(2, 3999)
        if b[k - 1] < b[k] > b[k + 1] and len(set(first[k - 2 : k + 3])) == 1
    ]
    assert tops
    for k in tops:
        between = {"bounds": (angles[k - 1], angles[k + 1]), "method": "bounded"}
        value = -minimize_scalar(lambda t: -float(force(5, 4, np.array(t))), **between).fun
        near = island_law.breakpoints[np.abs(island_law.breakpoints - value).argmin()]
        assert near == pytest.approx(value, rel=1e-9) and island_law.pdf(near) == np.inf
        ratio = island_law.pdf(near - 1e-6 * near) / island_law.pdf(near - 1e-8 * near)
        assert ratio == pytest.approx(0.1, rel=0.05)


def test_equal_barriers_at_both_ends_of_a_piece_count() -> None:
    """On a circle of a square lattice extrema lie so close that their barriers differ by rounding alone."""
    island = origins.circular_island(A, 9.0, lattice="square")
    found = origins.domains(islands=[island], stiffness=1.0, samples=100)
    exact = origins.barrier(island, 0.5 * np.pi * np.linspace(0.0, 1.0, 100_001)) / (2.0 * np.pi)
    assert found.mean() == pytest.approx(float(np.trapezoid(exact, dx=1e-5)), rel=2e-9)


@pytest.mark.slow  # quick: shares and moments of the same law, above
def test_what_it_means_for_sliding(island_law: origins.Thresholds) -> None:
    steady = master.steady_state(origins.Contacts(island_law), velocity=1.0)
    exact = counted(5, 4)
    assert steady.force == pytest.approx((exact**2).mean() / (2.0 * exact.mean()), rel=1e-7)
    paper = origins.domains(A, sizes=[(5, 4)], law="paper", coefficient=1.0, samples=100)
    assert paper.std() == pytest.approx(np.sqrt(exact).std(), rel=1e-6)


def thresholds_of(**table: object) -> origins.Thresholds:
    law = {"kind": "domains", "stiffness": 1.0, "samples": 200, **table}
    return toolkit.load_scene(scene(law, drive={"to": 0.5, "points": 6})).contacts.thresholds


def test_any_structure_that_ase_reads_in_a_scene(tmp_path: Path) -> None:
    island = origins.triangular_island(2.5, 5, 4)
    island.numbers[:] = 18
    island.set_cell([30.0, 30.0, 10.0])
    ase.io.write(tmp_path / "island.cif", island)
    law = thresholds_of(island={"kind": "file", "file": str(tmp_path / "island.cif")})
    same = origins.domains(2.5, sizes=[(5, 4)], stiffness=1.0, samples=200)
    assert law.mean() == pytest.approx(same.mean(), rel=1e-6) and law.domains.n_atoms[0] == 20
    given = {"sizes": [[5, 4], [6, 5]], "weights": [1.0, 2.0]}
    mixed = origins.domains(A, **given, stiffness=1.0, samples=200).domains
    found = thresholds_of(lattice_constant=A, **given).domains
    assert np.array_equal(found.barriers, mixed.barriers)


@pytest.mark.slow
def test_islands_whose_atoms_follow() -> None:
    """Two atoms on a spring, as origins.relaxed_barrier has it of the same calculator."""
    island = {"kind": "triangular", "lattice_constant": 2.5, "n_i": 2, "n_j": 1}
    found = thresholds_of(island=island, bonds=5.0, angles=[0.3], samples=1).domains.barriers
    atoms = origins.triangular_island(2.5, 2, 1)
    atoms.rotate(np.degrees(0.3), "z", center="COM")
    bonds = origins.harmonic_bonds(atoms, 5.0)
    calculator = SumCalculator([origins.substrate_calculator(origins.square_substrate()), bonds])
    direct = origins.relaxed_barrier(atoms, calculator, rigid=False)
    assert found[0] == pytest.approx(direct.barrier, abs=1e-9)
    assert abs(found[0] - origins.triangular_barrier(2.5, 2, 1, 0.3)) > 1e-3


def _stacked(*layers: tuple[str, float]) -> ase.Atoms:
    """Layers of one element each at heights z, laid out as three rows of three, from below."""
    made = ase.Atoms()
    for element, z in layers:
        layer = origins.triangular_island(2.6, 3, 3)
        layer.set_chemical_symbols([element] * len(layer))
        layer.translate((0.0, 0.0, z))
        made += layer
    return made


@pytest.mark.parametrize(
    ("layers", "said", "doubted"),
    [
        ([("C", 0.0)], "", False),
        ([("Au", 0.0), ("C", 3.35)], "18 atoms, C9Au9, in 2 layers, Au9 below C9: is the", True),
        ([("Au", 0.0), ("Au", 2.4), ("C", 5.7)], "in 3 layers, Au18 below C9: is the", True),
        # one material, and one whose layers are bonded to each other, as those of MoS2
        ([("C", 0.0), ("C", 3.35)], "18 atoms, C18, in 2 layers, and all of them meet", False),
        ([("S", 0.0), ("Mo", 1.5), ("S", 3.0)], "Mo9S18, in 3 layers, and all of them", False),
    ],
)
def test_an_island_that_may_hold_its_substrate_is_doubted(
    layers: list[tuple[str, float]], said: str, doubted: bool
) -> None:
    """All atoms of a file are the island, also those of a slab: F_k was 35 times too large, and nothing said so."""
    for unit in (1.0, 1e-10):
        island = _stacked(*layers)
        island.positions *= unit
        substrate = origins.hexagonal_substrate(1.0, 2.46 * unit)
        law = origins.domains(islands=[island], substrate=substrate, stiffness=1.0, samples=50)
        notes = [note for note in of_islands(law) if "layers" in note]
        assert len(notes) == bool(said) and all(said in note for note in notes)
        assert [note for note in doubts(Contacts(law)) if note in notes] == notes * doubted
