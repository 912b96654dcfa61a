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
from eq_model import compiling
from eq_model.closest import closest

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


def test_starts_beyond_every_threshold_are_cut_off() -> None:
    law, start = origins.rectangular(0.5, 1.5), origins.gaussian_start(mean=1.0, std=0.105)
    contacts, n = origins.Contacts(law, start=start), 2_000_000
    assert 0.0 < contacts.cut_weight < 1e-5
    for path in (0.0, [0.0, -0.1]):
        run = eq_model.simulate(contacts, path, n_contacts=n, seed=1, histograms=[0])
        (found,) = run.histograms
        edges, counts = found.stretch_edges, found.stretches * np.diff(found.stretch_edges) * n
        # some of so many starts lie beyond, and are drawn again
        assert counts[edges[:-1] > 1.5].sum() == 0 and counts[edges[1:] > 1.45].sum() > 10
        below = np.cumsum(counts) / n
        exact = stats.norm.cdf((edges[1:] - 1.0) / 0.105)
        assert np.abs(below - exact).max() < 1.95 / np.sqrt(n) + contacts.cut_weight


# -- the paper's algorithm --------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [GAUSSIAN, GAP], ids=["gaussian", "gap"])
def test_the_papers_algorithm_agrees(law: Any) -> None:
    contacts = origins.Contacts(law, start=origins.gaussian_start(mean=0.05, std=0.02))
    path = np.linspace(0.3, 3.0, 8)
    plain = np.array([closest(contacts, path, n_contacts=200, seed=seed)[0] for seed in range(12)])
    run = eq_model.simulate(contacts, path, n_contacts=400_000)
    error = np.sqrt(run.force_standard_error**2 * (1.0 + 400_000 / (12 * 200)))
    assert (np.abs(plain.mean(axis=0) - run.force) < 5.0 * error).all()


# -- the ensemble as a whole ------------------------------------------------------------------------------


def _bits(run: eq_model.EnsembleResult) -> dict[str, Any]:
    kept = dataclasses.asdict(run)
    return {name: kept[name] for name in ("force", "force_standard_error", "breaks")}


def test_the_result_does_not_depend_on_threads_and_histograms() -> None:
    contacts = origins.Contacts(GAP, start=GAUSSIAN_START)
    arguments: dict[str, Any] = {"n_contacts": 30_000, "n_replicas": 3, "seed": 11}
    whole = eq_model.simulate(contacts, IRREGULAR, **arguments)
    for more in ({"threads": 3}, {"histograms": [3, -1]}):
        found = eq_model.simulate(contacts, IRREGULAR, **arguments, **more)
        for name, value in _bits(found).items():
            assert np.array_equal(value, _bits(whole)[name])


@pytest.mark.parametrize("path", [np.linspace(0.05, 7.0, 36), IRREGULAR], ids=["even", "irregular"])
@pytest.mark.parametrize("start", [None, -0.3, GAUSSIAN_START], ids=["relaxed", "single", "gaussian"])
def test_the_quick_way_forward_and_the_one_life_by_life_agree(start: Any, path: np.ndarray) -> None:
    """A path that turns in the end is followed by the loop for all laws."""
    contacts = origins.Contacts(GAP, start)
    one = eq_model.simulate(contacts, path, n_contacts=200_000, seed=1)
    other = eq_model.simulate(contacts, np.append(path, path[-1] - 0.1), n_contacts=200_000, seed=2)
    for name in ("force", "holding"):
        error = np.hypot(one.force_standard_error, other.force_standard_error[:-1])
        assert (np.abs(getattr(one, name) - getattr(other, name)[:-1]) <= 5.0 * error + 1e-15).all()
    late = one.force_standard_error > 1e-4
    ratio = one.force_standard_error[late] / other.force_standard_error[:-1][late]
    assert late.sum() > 20 and np.abs(ratio - 1.0).max() < 0.03


def test_histograms_of_the_quick_way_are_those_of_the_other() -> None:
    contacts, path = origins.Contacts(GAP, GAUSSIAN_START), np.linspace(0.0, 3.0, 7)
    asked: dict[str, Any] = {"n_contacts": 300_000, "histograms": [0, 2, 6]}
    one = eq_model.simulate(contacts, path, **asked, seed=1)
    other = eq_model.simulate(contacts, np.append(path, 2.9), **asked, seed=2)
    for first, second in zip(one.histograms, other.histograms, strict=True):
        assert first.count == second.count == 300_000
        for name in ("stretch", "threshold"):
            many = [getattr(h, {"stretch": "stretches", "threshold": "thresholds"}[name]) for h in (first, second)]
            edges = [getattr(h, f"{name}_edges") for h in (first, second)]
            below = [np.cumsum(h * np.diff(e)) for h, e in zip(many, edges, strict=True)]
            apart = np.abs(below[0] - np.interp(edges[0][1:], edges[1][1:], below[1])).max()
            assert apart < 2.2 * np.sqrt(2.0 / 300_000)
        mean = (first.stretches * np.diff(first.stretch_edges) * first.stretch_edges[1:]).sum()
        assert abs(mean - one.force[first.point]) < 3e-3


def test_error_from_the_variance_between_contacts() -> None:
    # two contacts whose stretches are known, by what is left once one, or the other, has broken
    contacts = origins.Contacts(GAUSSIAN, start=origins.gaussian_start(mean=0.0, std=0.1))
    pair = eq_model.simulate(contacts, 0.0, n_contacts=2, seed=4, histograms=[0])
    (found,) = pair.histograms
    low, high = (0.5 * (found.stretch_edges[1:] + found.stretch_edges[:-1]))[found.stretches > 0.0]
    width = float(np.diff(found.stretch_edges)[1])
    assert abs(pair.force[0] - 0.5 * (low + high)) < width
    assert abs(pair.force_standard_error[0] - (high - low) / 2.0) < width
    assert eq_model.simulate(contacts, 0.0, n_contacts=1).force_standard_error[0] == np.inf


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


def test_compilation_is_not_in_the_run_time() -> None:
    code = """
import eq_model, origins
from eq_model import ensemble, lanes
# a clock that stands still but while something is compiled, or read back as it was compiled before
ensemble.Ensemble.clock = staticmethod(lambda: float(len(lanes.forward.signatures)))
contacts = origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.9, 0.05))
ready = ensemble.Ensemble(contacts, 1.0, n_contacts=100)
before = len(lanes.forward.signatures)
run = [*ready] and ready.result()
print(run.breaks > 0, before == len(lanes.forward.signatures) == 1, run.compile_time == 1.0, run.run_time == 0)
"""
    # in a process of its own, where nothing is compiled yet: nothing is once the ensemble is made
    done = subprocess.run([sys.executable, "-c", code], env=clean_environment(), capture_output=True, text=True)
    assert done.stdout.split() == ["True"] * 4, (done.stdout, done.stderr)


def half(x: float) -> float:
    return 0.5 * x


def test_kernels_are_compiled_anew_where_any_of_them_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))
    for version, hits in [("old", 0), ("old", 1), ("new", 0), ("new", 1)]:
        monkeypatch.setattr(compiling, "sources", lambda version=version: version)
        made = compiling.compiled(half)
        assert made(3.0) == 1.5 and sum(made.stats.cache_hits.values()) == hits


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
