"""Rotated domains: the law of barriers against its own definition, the laws to thresholds, ranks and refusals."""

import re

import numpy as np
import pytest
from scipy import stats

import origins
from origins.errors import InputError
from toolkit.scene.scene import load_scene

A = 2.5
SETTINGS = {"lattice_constant": A, "mean_atoms": 60.0, "stiffness": 1.0, "samples": 9000, "seed": 3}


def forces_at(n_i: int, n_j: int, angle: np.ndarray) -> np.ndarray:
    return origins.triangular_barrier(A, n_i, n_j, angle) / (2.0 * np.pi)


def test_one_size_at_all_angles() -> None:
    """The forces are those of angles equally likely over the circle."""
    law = origins.domains(A, sizes=[(10, 9)], stiffness=2.0, samples=50_000)
    record = law.domains
    assert record.barriers.shape == record.angles.shape == record.n_atoms.shape == (50_000,)
    assert (record.n_atoms == 90).all() and record.period == pytest.approx(2.0 * np.pi)
    assert stats.kstest(record.angles / (2.0 * np.pi), "uniform").pvalue > 1e-3
    np.testing.assert_array_equal(
        record.barriers, origins.triangular_barrier(A, 10, 9, record.angles)
    )
    exact = np.sort(forces_at(10, 9, 2.0 * np.pi * (np.arange(200_001) + 0.5) / 200_001))
    assert stats.ks_2samp(record.forces, exact).pvalue > 1e-3
    # one size: x_s = f_s/k, whatever the law between sizes, and no sampling error
    x = np.quantile(exact / 2.0, np.linspace(0.02, 0.98, 49))
    assert np.abs(law.cdf(x) - np.linspace(0.02, 0.98, 49)).max() < 1e-4
    assert law.mean() == pytest.approx(exact.mean() / 2.0, rel=1e-8)
    assert record.superlubric_weight == 0.0 and record.mean_stiffness == 2.0
    # how far the forces are from an exponential law, by scipy's own test: not even nearly one
    mean = record.forces.mean()
    distance = stats.kstest(record.forces, stats.expon(0, mean).cdf).statistic
    assert record.exponential_distance == pytest.approx(distance, rel=1e-12) and distance > 0.15
    ratios = (record.forces**2).mean() / 2 / mean**2, (record.forces**3).mean() / 6 / mean**3
    assert record.exponential_ratios == pytest.approx(ratios, rel=1e-12)
    assert record.mean_force == pytest.approx(mean)
    density, edges = record.histogram(40)
    assert (density * np.diff(edges)).sum() == pytest.approx(1.0) and edges.size == 41


def test_sizes_fall_off_exponentially() -> None:
    record = origins.domains(A, mean_atoms=30.0, stiffness=1.0, samples=40_000).domains
    # exp(-N/30) over N, each N made as n_i n_j with n_j = (4/3)^(1/4) N^(1/2) and n_i = N/n_j, rounded
    count = np.arange(1, 2000)
    rows = np.maximum(np.rint(np.sqrt(2.0 * count / np.sqrt(3.0))), 1.0)
    made = (np.maximum(np.rint(count / rows), 1.0) * rows).astype(int)
    share = np.bincount(made, np.exp(-count / 30.0) * np.expm1(1.0 / 30.0), minlength=2500)
    often = share > 1e-3
    found = np.bincount(record.n_atoms, minlength=2500)[:2500] / 40_000
    allowed = 5.0 * np.sqrt(share / 40_000)
    assert (np.abs(found - share) < allowed)[often].all() and often.sum() > 30
    assert record.n_atoms.mean() == pytest.approx(1.0 / -np.expm1(-1.0 / 30.0), rel=0.03)
    # the atoms made differ from N by less than half a row, and the island is nearly as high as wide
    assert (np.abs(made - count) <= rows / 2).all()
    assert (np.abs(made / rows - rows * np.sqrt(0.75)) < 1.5).all()


def test_laws_from_force_to_threshold() -> None:
    laws = {
        "equal": origins.domains(**SETTINGS, law="equal"),
        "area": origins.domains(**SETTINGS, law="area"),
        "paper": origins.domains(**{**SETTINGS, "stiffness": None}, law="paper", coefficient=4.0),
    }
    record = laws["equal"].domains
    force, atoms = record.barriers / record.period, record.n_atoms
    mean_atoms = 1.0 / -np.expm1(-1.0 / 60.0)
    root = np.sqrt(atoms / mean_atoms)
    expected = {"equal": force, "area": force / root, "paper": np.sqrt(force / 4.0)}
    for name, law in laws.items():
        np.testing.assert_array_equal(law.domains.barriers, record.barriers)
        same = origins.from_samples(expected[name])
        x = np.quantile(expected[name], [0.01, 0.1, 0.5, 0.9, 0.99])
        np.testing.assert_allclose(law.cdf(x), same.cdf(x), rtol=0.0, atol=1e-13)
        assert law.n_samples == 9000
    assert laws["equal"].domains.mean_stiffness == 1.0
    assert laws["area"].domains.mean_stiffness == pytest.approx(root.mean(), rel=1e-12)
    # k = c x_s, so the mean force is that of k x_s
    mean = 4.0 * expected["paper"].mean()
    assert laws["paper"].domains.mean_stiffness == pytest.approx(mean, rel=1e-12)


@pytest.mark.parametrize("temperature", [0.3, 3.0])
def test_angles_by_their_energy(temperature: float) -> None:
    """Mean barrier and mean cos 4 phi against the integral over exp(-U_min/k_BT), U_min = -|S_x| - |S_y|."""
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


def test_islands_of_your_own_on_another_substrate() -> None:
    substrate = origins.hexagonal_substrate(0.3, 3.0)
    islands = [origins.hexagonal_island(A, 2 * A), origins.irregular_island(A, 3 * A, seed=1)]
    given = {"islands": islands, "weights": [1, 3], "substrate": substrate}
    record = origins.domains(**given, law="equal", stiffness=1.0, samples=400).domains
    assert record.period == pytest.approx(3.0)
    first = record.n_atoms == 19
    assert first.mean() == pytest.approx(0.25, abs=0.1)
    for island, own in ((islands[0], first), (islands[1], ~first)):
        np.testing.assert_allclose(
            record.barriers[own], origins.barrier(island, record.angles[own], substrate), atol=1e-11
        )


def test_one_atom_ten_million_atoms_and_one_angle() -> None:
    single = origins.domains(A, sizes=[(1, 1)], stiffness=1.0, samples=50)
    # every angle gives the bare substrate's barrier of 2
    assert single.support() == (1.0 / np.pi, 1.0 / np.pi) and single.atoms[1].tolist() == [1.0]
    large = origins.domains(A, sizes=[(3162, 3163)], stiffness=1.0, samples=5000)
    assert large.cdf(0.0) == 0.0 < large.mean() and large.domains.n_atoms[0] == 3162 * 3163
    given = {"sizes": [(50, 40)], "angles": [0.0], "substrate": origins.hexagonal_substrate()}
    commensurate = origins.domains(2.0 * np.pi, **given, stiffness=1.0, samples=5)
    assert commensurate.mean() == pytest.approx(0.5 * 2000 / (2.0 * np.pi), rel=1e-10)


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


def test_a_sample_depends_on_its_number_alone() -> None:
    longer = origins.domains(**{**SETTINGS, "samples": 12_000}).domains
    shorter = origins.domains(**SETTINGS).domains
    # whole blocks: to the last bit
    assert np.array_equal(longer.barriers[:8192], shorter.barriers[:8192])
    np.testing.assert_allclose(longer.barriers[:9000], shorter.barriers, rtol=1e-12, atol=1e-12)
    other = origins.domains(**{**SETTINGS, "seed": 4}).domains
    assert not np.isin(other.angles, shorter.angles).any()


def test_domains_in_a_scene() -> None:
    def thresholds(**table: object) -> origins.Thresholds:
        law = {"kind": "domains", "stiffness": 1.0, "samples": 300, **table}
        drive = {"to": 1.0, "points": 3}
        scene = load_scene({"contacts": {"thresholds": law}, "drive": drive}, solved=False)
        return scene.contacts.thresholds

    given = {"sizes": [[5, 4], [6, 5]], "weights": [1.0, 2.0]}
    plain = thresholds(lattice_constant=A, **given)
    same = origins.domains(A, **given, stiffness=1.0, samples=300)
    assert np.array_equal(plain.domains.barriers, same.domains.barriers)
    waves = {"kind": "fourier", "wavevectors": [[1.0, 0.0], [0.0, 1.0]], "sines": [1.0, 1.0]}
    island = {"kind": "hexagonal", "lattice_constant": A, "radius": 3 * A}
    shaped = thresholds(island=island, substrate=waves)
    direct = origins.barrier(origins.hexagonal_island(A, 3 * A), shaped.domains.angles)
    np.testing.assert_allclose(shaped.domains.barriers, direct, atol=1e-12)
    for table, begins in (
        ({}, "domains: give exactly one of sizes, such as [[10, 9]], mean_atoms, such as 100, and"),
        ({"lattice_constant": A, "island": island}, "lattice_constant = 2.5: the table"),
        ({"island": [{"kind": "oval"}]}, "island = [{'kind': 'oval'}]: must be a table"),
        ({"island": {"kind": "oval"}}, "island.kind = 'oval': "),
        ({"island": island, "substrate": waves | {"cosines": [1.0]}}, "substrate.cosines = [1.0]:"),
    ):
        with pytest.raises(InputError) as refusal:
            thresholds(**table)
        assert re.match(r"contacts\.thresholds(: |\.)" + re.escape(begins), str(refusal.value))
