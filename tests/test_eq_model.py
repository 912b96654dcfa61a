"""The ensemble against its plain twins, exact results and its own statistics."""

import dataclasses
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import clean_environment
from scipy import stats
from scipy.special import ndtr

import eq_model
import origins
from eq_model import compiling, kernel, layout, simulate, twin
from eq_model.beginning import redraw, tables
from eq_model.closest import closest, draw_start
from eq_model.compiled_table import kernel_table
from eq_model.ensemble import Ensemble
from eq_model.lattice import joined, make_lattice
from eq_model.rare import unseen_variance
from eq_model.thermal_tables import steady_for_kernel
from origins import streams
from origins.quantile import quantile_table

GAUSSIAN = origins.gaussian(mean=1.0, std=0.05)
GAP = origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])
ATOM = origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75])
GAUSSIAN_START = origins.gaussian_start(mean=0.1, std=0.025)
IRREGULAR = np.concatenate([[0.0], 3.0 + 1e-9 * np.arange(5), np.sort(np.random.default_rng(3).random(60)) * 6.0 + 3.1])


def _chi_square(samples: np.ndarray, exact: np.ndarray) -> float:
    """Probability of a larger Hotelling T^2; samples (seeds, points)."""
    seeds, points = samples.shape
    off = samples.mean(axis=0) - exact
    square = seeds * off @ np.linalg.solve(np.cov(samples.T), off)
    return float(stats.f.sf(square * (seeds - points) / (points * (seeds - 1)), points, seeds - points))


# -- the streams and the kernel's draws -------------------------------------------------------------------


def test_compiled_philox_equals_the_published_one() -> None:
    from numba import njit

    @njit
    def one(a, b, c, d, k0, k1):  # type: ignore[no-untyped-def]
        return kernel.philox(a, b, c, d, k0, k1)

    counters = np.random.default_rng(1).integers(0, 2**32, (4, 200), dtype=np.uint64)
    key = (0xA4093822, 0x299F31D0)
    expected = streams.philox(counters, key)
    for counter, words in zip(counters.T, expected.T, strict=True):
        assert [int(w) for w in one(*counter, np.uint64(key[0]), np.uint64(key[1]))] == words.tolist()
    # a contact that breaks or ages more than 2^32 times goes on drawing, from counters of 64 bits
    rest = [np.uint64(word) for word in (1, 2, 3, *key)]
    far = [one(np.uint64(high * 2**32 + low), *rest) for high in range(4) for low in range(200)]
    assert len(set(far)) == 800 and max(map(max, far)) < 2**32


PEAKS = origins.mixture([origins.gaussian(m, 0.1) for m in (1.0, 2.5, 4.0)], [0.2, 0.3, 0.5])


@pytest.mark.parametrize(
    "law", [GAUSSIAN, GAP, PEAKS, ATOM, origins.gw_elastic(1.0)], ids=["gaussian", "gap", "peaks", "atom", "gw"]
)
@pytest.mark.parametrize("path", [np.linspace(0.0, 7.0, 36), IRREGULAR], ids=["even", "irregular"])
def test_kernel_equals_its_plain_twin_bit_by_bit(law: Any, path: np.ndarray) -> None:
    table, start = quantile_table(law), quantile_table(GAUSSIAN_START)
    lattice = make_lattice(path, 0.0, table.scale, 8.0, exact=False)
    key, n_contacts, first, n = streams.key_of(7), 700, 500, 1500
    compiled, begun = kernel_table(table, lattice.unit), kernel_table(start, lattice.unit)
    words = tuple(np.uint64(word) for word in key)
    begins, firsts = np.empty(n, np.int64), np.empty(n, np.int64)
    kernel.begin(first, n_contacts, words, compiled, begun, False, begins, firsts)
    expected = twin.begin(first, n_contacts, key, table, start, lattice.unit, n)
    assert (begins == expected[0]).all() and (firsts == expected[1]).all()
    none = np.empty(0, np.int64)
    for births, thresholds in ((begins, np.maximum(firsts, np.abs(begins))), (none, none)):
        sums = np.zeros(2 * lattice.bin_cell.size + 2, np.int64)
        steady = steady_for_kernel(None, 1.0, lattice.unit)
        breaks = kernel.run(
            first, n, n_contacts, words, compiled, steady, births, thresholds, lattice.for_kernel, True, sums
        )
        expected_breaks, expected_sums = twin.run(first, n, n_contacts, key, table, births, thresholds, lattice)
        assert breaks == expected_breaks > 0
        assert (sums[:-2].reshape(-1, 2) == expected_sums).all()


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize(("temperature", "velocity"), [(0.05, 1.0), (1e-3, 1e-8), (30.0, 0.3)])
def test_kernel_with_temperature_against_its_plain_twin(law: Any, temperature: float, velocity: float) -> None:
    table, path, thermal = quantile_table(GAP), np.linspace(0.0, 4.0, 36), origins.Thermal(law, temperature)
    lattice = make_lattice(path, 0.0, table.scale, 4.0, exact=False)
    key, n_contacts, first, n = streams.key_of(7), 700, 500, 3000
    steady = steady_for_kernel(thermal, velocity, lattice.unit)
    none, sums = np.empty(0, np.int64), np.zeros(2 * lattice.bin_cell.size + 2, np.int64)
    words, compiled = tuple(np.uint64(word) for word in key), kernel_table(table, lattice.unit)
    breaks = kernel.run(first, n, n_contacts, words, compiled, steady, none, none, lattice.for_kernel, True, sums)
    expected_breaks, expected = twin.run(first, n, n_contacts, key, table, none, none, lattice, thermal, velocity)
    assert breaks == expected_breaks > 0
    moved = (sums[:-2:2] - expected[:, 0]) * lattice.unit
    # each of some breaks of a bin is off by at most 1e-8
    assert np.abs(moved).max() < 1e-8 * n and abs(moved.sum()) < 1e-9 * breaks


def test_many_draws_follow_the_law_into_its_tails() -> None:
    n = 5_000_000
    table = quantile_table(GAUSSIAN)
    unit = 2.0**-44
    firsts = np.empty(n, np.int64)
    words = tuple(np.uint64(word) for word in streams.key_of(3))
    kernel.begin(0, n, words, kernel_table(table, unit), kernel_table(table, unit), True, np.zeros(n, np.int64), firsts)
    x = np.sort(firsts * unit)
    assert stats.kstest(x, GAUSSIAN.cdf).pvalue > 1e-3
    for share in (2.0**-10, 2.0**-12, 2.0**-13, 1e-5, 3e-6):
        for count in ((x > GAUSSIAN.isf(share)).sum(), (x < GAUSSIAN.ppf(share)).sum()):
            assert stats.binomtest(int(count), n, share).pvalue > 1e-4


def test_draws_beyond_the_first_word_are_continued() -> None:
    # words that are all zero but for the side: the rest comes from the next word, down to 2^-65
    table = quantile_table(GAUSSIAN)
    words = np.array([0, 0, 1 << 31, 1 << 31], dtype=np.uint32)
    more = np.array([0, 1 << 20, 0, 1 << 20], dtype=np.uint32)
    x = twin.values(table, 2.0**-44, words, more) * 2.0**-44
    v = np.maximum((more + 0.5) * 2.0**-64, 2.0**-54)
    tail = np.where([True, True, False, False], GAUSSIAN.cdf(x), GAUSSIAN.sf(x))
    assert np.abs(tail / v - 1.0).max() < 1e-3


# -- exact results ----------------------------------------------------------------------------------------


def _gaussian_force(path: np.ndarray, mean: float, std: float, x_0: float, s_0: float) -> np.ndarray:
    """Exact for Gaussian thresholds and start whose weight below 0 is negligible."""
    force = x_0 + path
    for n in range(1, int(path[-1] / mean) + 12):
        w = np.sqrt(n * std**2 + s_0**2)
        z = (path - n * mean + x_0) / w
        force = force - mean * ndtr(z) + std**2 / w * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    return force


@pytest.mark.parametrize("start", [None, origins.gaussian_start(mean=0.0, std=0.025)], ids=["relaxed", "gaussian"])
def test_force_against_the_closed_form_over_seeds(start: Any) -> None:
    # three points in each wave of breaks: between the waves nothing changes, and forces differ by a constant
    waves = np.arange(1, 6)[:, None]
    path = (waves + 0.06 * np.sqrt(waves) * [-1.0, 0.1, 1.0]).ravel()
    contacts = origins.Contacts(GAUSSIAN, start=start)
    runs = [eq_model.simulate(contacts, path, n_contacts=4000, seed=seed) for seed in range(200)]
    exact = _gaussian_force(path, 1.0, 0.05, 0.0, 0.0 if start is None else 0.025)
    forces = np.array([run.force for run in runs])
    assert _chi_square(forces, exact) > 1e-3
    errors = np.array([run.force_standard_error for run in runs])
    # the error claimed against the scatter over seeds; 200 seeds know a variance to a tenth
    ratio = (errors**2).mean(axis=0) / forces.var(axis=0, ddof=1)
    assert np.abs(ratio - 1.0).max() < 5.0 * np.sqrt(2.0 / 200)
    z = (forces - exact) / errors
    assert stats.kstest(z[:, 5], "norm").pvalue > 1e-3


def test_steady_state_of_an_onset_law() -> None:
    law = origins.gw_elastic(1.0)
    run = eq_model.simulate(origins.Contacts(law), np.linspace(0.0, 40.0, 9), n_contacts=200_000)
    z = (run.force[-1] - law.moment(2) / (2.0 * law.mean())) / run.force_standard_error[-1]
    assert abs(z) < 5.0
    # one break per mean threshold, (cv^2 - 1) / 2 of them late: renewal theory
    expected = 40.0 / law.mean() + (law.std() ** 2 / law.mean() ** 2 - 1.0) / 2.0
    scatter = law.std() / law.mean() * np.sqrt(40.0 / law.mean() / 200_000)
    assert abs(run.breaks / 200_000 - expected) < 5.0 * scatter


def test_identical_thresholds_break_on_path_points_and_stay_periodic() -> None:
    path = np.linspace(0.0, 50.0, 501)
    run = eq_model.simulate(origins.Contacts(origins.identical(1.0)), path, n_contacts=10)
    exact = path - np.floor(path + 1e-9)
    assert np.abs(run.force - exact).max() < 1e-11
    assert (run.force_standard_error == 0.0).all() and run.breaks == 500
    shifted = eq_model.simulate(origins.Contacts(origins.identical(0.95), start=0.4), path, n_contacts=10)
    exact = path + 0.4 - 0.95 * np.floor((path + 0.4) / 0.95 + 1e-9)
    assert np.abs(shifted.force - exact).max() < 1e-11


def test_nothing_broken_yet_is_exact() -> None:
    path = np.linspace(0.0, 0.4, 7)
    run = eq_model.simulate(origins.Contacts(GAUSSIAN, start=0.123), path, n_contacts=1000)
    assert np.abs(run.force - (0.123 + path)).max() < 1e-15
    assert (run.force_standard_error == 0.0).all() and run.breaks == 0
    assert (run.holding == 1.0).all()


@pytest.mark.parametrize("value", [1.0, -1.0, 1.3, -1.6])
def test_a_start_among_the_thresholds_is_conditional(value: float) -> None:
    contacts = origins.Contacts(GAUSSIAN, start=value)
    # up to where the survivors of the start run out; their second break is still far
    path = np.linspace(0.0, 0.4, 41) + (0.0 if value > 0.0 else 2.0 * abs(value) - 0.01)
    run = eq_model.simulate(contacts, path, n_contacts=40_000, seed=1)
    # x_0 + X less the thresholds broken so far, whose law is the normal one between |x_0| and x_0 + X
    low, high = (abs(value) - 1.0) / 0.05, (np.maximum(abs(value), value + path) - 1.0) / 0.05
    lost = ndtr(-low) - ndtr(-high) - 0.05 * (stats.norm.pdf(high) - stats.norm.pdf(low))
    exact = value + path - lost / ndtr(-low)
    assert (np.abs(run.force - exact) < 5.0 * run.force_standard_error + 1e-12).all()
    held = float(GAUSSIAN.sf(max(abs(value), value + path[-1])) / GAUSSIAN.sf(abs(value)))
    assert abs(run.breaks - 40_000 * (1.0 - held)) < 5.0 * np.sqrt(40_000 * 0.25)


def test_redrawn_first_thresholds_follow_the_conditional_law() -> None:
    contacts = origins.Contacts(GAUSSIAN, start=origins.gaussian_start(mean=1.3, std=0.02))
    table, start_table = tables(contacts)
    n = 100_000
    replica, contact = twin.address(0, n, n)
    stretches = start_table.value(0.5 * np.random.default_rng(0).random(n), True)  # type: ignore[union-attr]
    x, thresholds = redraw(stretches, replica, contact, (5, 0), contacts, table, start_table)
    u = GAUSSIAN.sf(thresholds) / GAUSSIAN.sf(np.abs(x))
    assert (thresholds >= np.abs(x)).all()
    assert stats.kstest(u, "uniform").pvalue > 1e-3


def test_start_beyond_every_threshold_is_cut_off() -> None:
    law, start = origins.rectangular(0.5, 1.5), origins.gaussian_start(mean=1.0, std=0.105)
    contacts = origins.Contacts(law, start=start)
    assert 0.0 < contacts.cut_weight < 1e-5
    table, start_table = tables(contacts)
    stretches = np.array([1.51, 1.6, 1.499])
    replica, contact = twin.address(0, 3, 3)
    x, thresholds = redraw(stretches, replica, contact, (5, 0), contacts, table, start_table)
    assert (np.abs(x) < 1.5).all() and x[2] == 1.499 and (thresholds > x).all() and (thresholds <= 1.5).all()


# -- the paper's algorithm --------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [GAUSSIAN, GAP], ids=["gaussian", "gap"])
def test_the_papers_algorithm_agrees(law: Any) -> None:
    contacts = origins.Contacts(law, start=origins.gaussian_start(mean=0.05, std=0.02))
    path = np.linspace(0.3, 3.0, 8)
    plain = np.array([closest(contacts, path, n_contacts=200, seed=seed)[0] for seed in range(12)])
    run = eq_model.simulate(contacts, path, n_contacts=400_000)
    error = np.sqrt(run.force_standard_error**2 * (1.0 + 400_000 / (12 * 200)))
    assert (np.abs(plain.mean(axis=0) - run.force) < 5.0 * error).all()


def test_the_papers_algorithm_on_one_contact_is_its_own_path() -> None:
    contacts = origins.Contacts(origins.identical(0.75), start=0.25)
    force, breaks = closest(contacts, np.array([0.25, 0.5, 0.75, 1.25, 2.0]), n_contacts=1)
    assert np.abs(force - [0.5, 0.0, 0.25, 0.0, 0.0]).max() < 1e-12 and breaks == 3


# -- the ensemble as a whole ------------------------------------------------------------------------------


def _bits(run: eq_model.EnsembleResult) -> dict[str, Any]:
    kept = dataclasses.asdict(run)
    return {name: kept[name] for name in ("force", "force_standard_error", "breaks")}


def test_the_result_does_not_depend_on_the_cutting() -> None:
    contacts = origins.Contacts(GAP, start=GAUSSIAN_START)
    arguments: dict[str, Any] = {"n_contacts": 3000, "n_replicas": 3, "seed": 11}
    whole = eq_model.simulate(contacts, IRREGULAR, **arguments)
    pieces = Ensemble(contacts, IRREGULAR, **arguments)
    for first in range(0, 9000, 1234):
        block = range(first, min(first + 1234, 9000))
        pieces._state = pieces.state.after(block, *pieces._engine.follow(block))
    for name, value in _bits(pieces.result()).items():
        assert np.array_equal(value, _bits(whole)[name])


def test_path_points_may_be_any_and_need_no_order_of_size() -> None:
    contacts = origins.Contacts(GAUSSIAN)
    fine = np.linspace(0.0, 4.0, 4001)
    reference = eq_model.simulate(contacts, fine, n_contacts=5000)
    chosen = np.concatenate([[0, 0, 1, 950, 951, 951, 952], [1000, 1010, 1500, 2040, 3999, 4000]])
    run = eq_model.simulate(contacts, fine[chosen], n_contacts=5000)
    # positions are rounded to other units, so a break may change sides of a point, rarely
    assert np.abs(run.force - reference.force[chosen]).max() < 3e-4
    assert np.abs(run.force_standard_error - reference.force_standard_error[chosen]).max() < 1e-5
    single = eq_model.simulate(contacts, 2.04, n_contacts=5000)
    assert single.force.shape == (1,) and abs(single.force[0] - reference.force[2040]) < 3e-4


def test_error_from_the_variance_between_contacts() -> None:
    # two contacts whose stretches are known: the error is half their difference
    contacts = origins.Contacts(GAUSSIAN, start=origins.gaussian_start(mean=0.0, std=0.1))
    pair = eq_model.simulate(contacts, 0.0, n_contacts=2, seed=4)
    births, _ = twin.begin(0, 2, streams.key_of(4), *(t for t in tables(contacts) if t), 2.0**-44, 2)
    x = -births * 2.0**-44
    assert abs(pair.force[0] - x.mean()) < 1e-12
    assert abs(pair.force_standard_error[0] - abs(x[0] - x[1]) / 2.0) < 1e-6
    assert eq_model.simulate(contacts, 0.0, n_contacts=1).force_standard_error[0] == np.inf


@pytest.mark.parametrize("start", [None, 0.1, origins.gaussian_start(mean=0.0, std=0.01)])
def test_breaks_too_rare_to_be_seen_are_in_the_error(start: Any) -> None:
    law = origins.gw_elastic(1.0)
    contacts = origins.Contacts(law, start=start)
    path = np.linspace(0.0, 0.5, 51)
    variance, _ = unseen_variance(contacts, path, 400)
    generator = np.random.default_rng(1)
    x, gap = draw_start(contacts, 2_000_000, generator)
    rare = np.flatnonzero(variance > 0.0)
    assert 10 < rare.size < 51 and (np.diff(rare) == 1).all()
    for j in rare[[3, 6, -1]]:
        taken = np.where(gap <= path[j], x + gap, 0.0)
        count = np.count_nonzero(taken)
        assert 0.95 - 3.0 / np.sqrt(count) < variance[j] / (taken**2).mean() < 1.35 + 3.0 / np.sqrt(count)
    # far fewer contacts than would show one break: the exact force is still within the error
    few = [eq_model.simulate(contacts, path[rare], n_contacts=40, seed=seed) for seed in range(100)]
    many = eq_model.simulate(contacts, path[rare], n_contacts=2_000_000)
    z = np.array([(run.force - many.force) / np.hypot(run.force_standard_error, 1e-12) for run in few])
    assert np.abs(z[:, 1:]).max() < 5.0 and (z[:, 1:] ** 2).mean() < 1.3


def test_replicas_and_seeds_differ_and_repeat() -> None:
    contacts = origins.Contacts(GAUSSIAN)
    one = eq_model.simulate(contacts, 1.0, n_contacts=2000, n_replicas=2)
    again = eq_model.simulate(contacts, 1.0, n_contacts=2000, n_replicas=2)
    half = eq_model.simulate(contacts, 1.0, n_contacts=2000, n_replicas=1)
    other = eq_model.simulate(contacts, 1.0, n_contacts=2000, n_replicas=2, seed=1)
    assert one.force[0] == again.force[0]
    assert len({one.force[0], half.force[0], other.force[0]}) == 3
    # the first replica is the same contacts: the other one alone makes the difference
    second = 2.0 * one.force[0] - half.force[0]
    assert abs(second - half.force[0]) < 8.0 * half.force_standard_error[0] and second != half.force[0]


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_scaling_all_lengths_changes_the_scale_only(factor: float) -> None:
    path = np.linspace(0.0, 3.0, 31)
    base = eq_model.simulate(origins.Contacts(GAUSSIAN, start=GAUSSIAN_START), path, n_contacts=2000)
    law = origins.gaussian(mean=factor, std=0.05 * factor)
    start = origins.gaussian_start(mean=0.1 * factor, std=0.025 * factor)
    scaled = eq_model.simulate(origins.Contacts(law, start=start), path * factor, n_contacts=2000)
    assert np.abs(scaled.force / factor - base.force).max() < 1e-9
    assert np.abs(scaled.force_standard_error / factor - base.force_standard_error).max() < 1e-9
    assert scaled.breaks == base.breaks


def test_the_error_does_not_drift_over_a_million_breaks() -> None:
    # the same contacts' last steps, once with the whole way in one lattice of wide cells
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5))
    far = eq_model.simulate(contacts, 3e5, n_contacts=40)
    near = eq_model.simulate(contacts, np.linspace(3e5 - 50.0, 3e5, 501), n_contacts=40)
    assert abs(far.force_standard_error[0] / near.force_standard_error[-1] - 1.0) < 1e-3
    # stretches of 40 contacts, spread as the steady state has them: E / C
    exact = np.sqrt((1.25 / 3.0 - (13.0 / 24.0) ** 2) / 40.0)
    assert abs(near.force_standard_error[-1] / exact - 1.0) < 0.4


def test_heavy_tails_and_long_paths_do_not_overflow() -> None:
    law = stats.pareto(2.5)
    run = eq_model.simulate(origins.Contacts(law), np.array([0.0, 1e5]), n_contacts=50, n_replicas=1)
    assert abs(run.breaks / 50 / (1e5 / law.mean()) - 1.0) < 0.02
    z = (run.force[1] - law.moment(2) / (2.0 * law.mean())) / run.force_standard_error[1]
    assert -8.0 < z < 5.0  # the variance of the stretch is infinite: few contacts fall short of the mean


def test_work_arrives_in_blocks_and_compilation_is_apart() -> None:
    ensemble = Ensemble(origins.Contacts(GAUSSIAN), np.linspace(0.0, 1.0, 3), n_contacts=200_000)
    progress = list(ensemble)
    assert [total for _, total in progress] == [200_000] * len(progress)
    done = [n for n, _ in progress]
    assert len(done) > 1 and done == sorted(done) and done[-1] == 200_000
    result = ensemble.result()
    assert result.compile_time > 0.0 and result.run_time > 0.0
    assert result.breaks_per_rank == [result.breaks]


def test_compilation_is_not_in_the_run_time() -> None:
    code = """
import eq_model, origins
from eq_model import ensemble, kernel
from numba.core.dispatcher import Dispatcher

kernels = {name: made for name, made in vars(kernel).items() if isinstance(made, Dispatcher)}
# a clock that stands still but while something is compiled, or read back as it was compiled before
ensemble.Ensemble.clock = staticmethod(lambda: sum(len(made.signatures) for made in kernels.values()))
contacts = origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.9, 0.05))
ready = ensemble.Ensemble(contacts, 1.0, n_contacts=100)
before = {name: len(made.signatures) for name, made in kernels.items()}
run = [*ready] and ready.result()
after = {name: len(made.signatures) for name, made in kernels.items()}
kept = sum(sum(made.stats.cache_hits.values()) + sum(made.stats.cache_misses.values()) for made in kernels.values())
print(run.breaks > 0, before == after, kept > 0, run.compile_time == sum(after.values()) > 0, run.run_time == 0)
"""
    # in a process of its own, where nothing is compiled yet: nothing is once the ensemble is made
    done = subprocess.run([sys.executable, "-c", code], env=clean_environment(), capture_output=True, text=True)
    assert done.stdout.split() == ["True"] * 5, (done.stdout, done.stderr)


def half(x: float) -> float:
    return 0.5 * x


def test_kernels_are_compiled_anew_where_any_of_them_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))
    for version, hits in [("old", 0), ("old", 1), ("new", 0), ("new", 1)]:
        monkeypatch.setattr(compiling, "sources", lambda version=version: version)
        made = compiling.compiled(half)
        assert made(3.0) == 1.5 and sum(made.stats.cache_hits.values()) == hits


def test_the_kernel_works_where_no_folder_can_be_written() -> None:
    # a function without a file has no folder for its compiled code either
    namespace: dict[str, Any] = {}
    exec("def double(x): return 2 * x", namespace)
    assert compiling.compiled(namespace["double"])(21) == 42


def test_the_face_imports_no_compiler() -> None:
    code = "import sys, eq_model; print(sorted({'numba', 'mpi4py', 'scipy.stats'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "change, complaint",
    [
        ({"n_contacts": 0}, "n_contacts"),
        ({"n_contacts": 1.5}, "n_contacts"),
        ({"n_contacts": 2**40}, "n_contacts"),
        ({"n_replicas": 0}, "n_replicas"),
        ({"n_replicas": 2**30}, "n_replicas"),
        ({"seed": -1}, "seed"),
        ({"path": [0.0, float("nan")]}, "path"),
        ({"path": [0.0, 1e12]}, "path"),
        ({"contacts": GAUSSIAN}, "contacts"),
        ({"contacts": origins.Contacts(GAUSSIAN, start=2.83)}, "start"),
    ],
)
def test_bad_input_is_refused_by_name(change: dict[str, Any], complaint: str) -> None:
    arguments: dict[str, Any] = {"contacts": origins.Contacts(GAUSSIAN), "path": [0.0, 1.0], "n_contacts": 10, **change}
    with pytest.raises(origins.InputError, match=complaint):
        eq_model.simulate(arguments.pop("contacts"), arguments.pop("path"), **arguments)


def test_limbs_are_exact_beyond_one_word() -> None:
    from eq_model.lattice import carried, split

    parts = np.array([2**62 - 1, -(2**61), 3, 2**62], dtype=np.int64)
    total = sum(int(p) for p in parts) * 50
    limbs = sum((split(parts) for _ in range(50)), np.zeros((2, 4), np.int64)).sum(axis=1)
    high, low = (int(limb) for limb in carried(limbs))
    assert high * 2**32 + low == total and abs(joined(limbs) / total - 1.0) < 1e-15


def test_draws_that_the_hot_cells_do_not_hold_four_in_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """A contact all of whose draws of a round are left to the fine cells keeps its place: nothing overflows."""
    monkeypatch.setattr("origins.hot_cells._BITS", (3,))
    law = origins.mixture([origins.rectangular(0.2, 0.5), origins.gaussian(1.0, 0.05)], [0.3, 0.7])
    path = np.linspace(0.0, 60.0, 41)
    found = eq_model.simulate(origins.Contacts(law), path, n_contacts=3000, seed=5)
    kinetic = law.moment(2) / (2.0 * law.mean())
    assert abs(found.force[-1] - kinetic) < 5.0 * found.force_standard_error[-1]


@pytest.mark.parametrize("total", [1, 70_000, 1 << 18, (1 << 18) + 5, 1 << 19, (1 << 19) + 70_000, 3_000_000])
@pytest.mark.parametrize("size", [1, 3])
def test_blocks_are_measured_whole_and_counted_once(total: int, size: int) -> None:
    covered, measured = 0, 0
    for rank in range(size):
        shares = layout.share([range(total)], rank, size)
        while shares:
            block, rest = layout.cut(shares[0], layout.block_size(100.0))
            shares = [rest, *shares[1:]] if len(rest) else shares[1:]
            assert block.start == covered
            covered = block.stop
            kinds = {layout.is_measured(contact) for contact in (block.start, block.stop - 1)}
            assert len(kinds) == 1
            measured += len(block) if kinds.pop() else 0
    assert covered == total and measured == layout.measured([range(total)])


@pytest.mark.parametrize("start", [None, GAUSSIAN_START], ids=["relaxed", "gaussian"])
def test_the_part_that_is_measured_speaks_for_all(start: Any) -> None:
    contacts, path = origins.Contacts(origins.gw_elastic(1.0), start=start), np.linspace(0.0, 2.0, 9)[1:]
    few = simulate(contacts, path, n_contacts=1 << 18, seed=5)
    many = simulate(contacts, path, n_contacts=3 << 19, seed=5)
    # the variances are those of 2^18 and of 3 * 2^17 contacts, the first part the same
    ratio = many.force_standard_error / few.force_standard_error * np.sqrt(6.0)
    kurtosis = 9.0
    assert np.abs(ratio - 1.0).max() < 5.0 * np.sqrt((kurtosis - 1.0) / 4.0 * (1.0 - 2.0 / 3.0) / 2.0**18)
    # the mean is that of all
    assert (np.abs(many.force - few.force) > 0.0).all()
