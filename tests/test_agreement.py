"""The two solvers as witnesses of one model: 200 seeds of the ensemble against the master equation.

Points of one path share contacts, so their errors go together: Hotelling's T^2 judges them all at once.
"""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.stats

import eq_model
import master
import origins
from eq_model.closest import closest

SEEDS = 200
LEVEL = 1e-3
WIDE = "persson, start wider than steady sliding"


@dataclass(frozen=True)
class Case:
    """A scene, at most 20 points where the force has come to differ between contacts, and contacts per run."""

    contacts: origins.Contacts
    path: np.ndarray
    number: int = 1000


CASES = {
    "gaussian, A02's start": Case(
        origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025)),
        np.array([0.95, 1.0, 1.05, 1.9, 2.0, 2.1, 2.9, 3.0, 3.1, 3.9, 4.0, 4.1, 4.3, 4.9, 5.0]),
    ),
    "rectangular, relaxed": Case(origins.Contacts(origins.rectangular(0.5, 1.5)), np.linspace(0.6, 4.4, 20)),
    "gw_elastic, gaussian start": Case(
        origins.Contacts(origins.gw_elastic(1.588), origins.gaussian_start(0.0, 0.025)), np.linspace(0.05, 2.9, 20)
    ),
    "unequal mixture with a gap": Case(
        origins.Contacts(origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])),
        np.array([0.3, 0.45, 0.6, 0.8, 0.95, 1.05, 1.2, 1.4, 1.6, 1.9, 2.1, 2.4, 2.8, 3.1, 3.6, 4.0]),
    ),
    "persson, start among the thresholds": Case(
        origins.Contacts(origins.persson(1.0, 0.5), scipy.stats.uniform(0.2, 0.9)), np.linspace(0.0, 3.8, 20)
    ),
    WIDE: Case(origins.Contacts(origins.persson(1.0, 0.5), scipy.stats.uniform(-0.9, 2.0)), np.linspace(0.0, 3.8, 20)),
    "one start below zero, among the thresholds": Case(
        origins.Contacts(origins.gaussian(1.0, 0.2), -0.9), np.linspace(1.85, 5.0, 16)
    ),
    "exact value and gaussian": Case(
        origins.Contacts(origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75])),
        np.array([0.9, 0.94, 0.96, 1.1, 1.3, 1.85, 1.92, 2.1, 2.3, 2.8, 2.9, 3.1, 3.9, 4.2]),
    ),
}


def exact(case: Case) -> np.ndarray:
    solution = master.solve(case.contacts, case.path, tolerance=1e-10)
    assert solution.success
    return solution.force


def judge(samples: np.ndarray, expected: np.ndarray) -> float:
    """Probability of a larger T^2 when the rows of samples have the expected mean: exact for normal rows."""
    seeds, points = samples.shape
    assert points <= 20
    off = samples.mean(axis=0) - expected
    # in standard errors first: forces at different X may differ by orders of magnitude in their scatter
    scatter = samples.std(axis=0, ddof=1)
    correlation = np.corrcoef(samples.T)
    z = np.sqrt(seeds) * off / scatter
    square = z @ np.linalg.solve(correlation, z)
    return float(scipy.stats.f.sf(square * (seeds - points) / (points * (seeds - 1)), points, seeds - points))


@pytest.fixture(scope="module", params=CASES)
def witnessed(request: pytest.FixtureRequest) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces and their standard errors (seeds, points) of the ensemble, and the master equation's force."""
    case = CASES[request.param]
    runs = [eq_model.simulate(case.contacts, case.path, n_contacts=case.number, seed=seed) for seed in range(SEEDS)]
    forces = np.array([run.force for run in runs])
    return forces, np.array([run.force_standard_error for run in runs]), exact(case)


def test_all_points_at_once(witnessed: tuple[np.ndarray, ...]) -> None:
    forces, _, expected = witnessed
    assert judge(forces, expected) > LEVEL


def test_no_point_is_far_off(witnessed: tuple[np.ndarray, ...]) -> None:
    forces, errors, expected = witnessed
    together = np.sqrt((errors**2).sum(axis=0)) / SEEDS
    assert (np.abs(forces.mean(axis=0) - expected) < 5.0 * together).all()


def test_reported_error_is_the_spread_over_seeds(witnessed: tuple[np.ndarray, ...]) -> None:
    forces, errors, _ = witnessed
    ratio = forces.var(axis=0, ddof=1) / (errors**2).mean(axis=0)
    # one in a million at each of some 120 points
    low, high = scipy.stats.chi2.ppf([5e-7, 1.0 - 5e-7], SEEDS - 1) / (SEEDS - 1)
    assert (ratio > low).all() and (ratio < high).all()


def test_the_judge_finds_what_is_there() -> None:
    case = CASES["rectangular, relaxed"]
    expected = exact(case)
    forces = np.array(
        [eq_model.simulate(case.contacts, case.path, n_contacts=1000, seed=seed).force for seed in range(SEEDS)]
    )
    # thresholds one percent larger, and a shift of a third of one run's scatter
    other = master.solve(origins.Contacts(origins.rectangular(0.505, 1.515)), case.path, tolerance=1e-10)
    assert judge(forces, other.force) < 1e-6
    assert judge(forces, expected + 0.33 * forces.std(axis=0)) < 1e-6


@pytest.mark.parametrize("start", [0.0, 0.123, -0.7])
def test_before_the_first_break_they_agree_to_round_off(start: float) -> None:
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5) if start >= 0.0 else origins.gaussian(1.0, 0.02), start)
    path = np.linspace(0.0, 0.37 if start >= 0.0 else 1.4, 20)
    run = eq_model.simulate(contacts, path, n_contacts=1000)
    assert run.breaks == 0 and (run.force_standard_error == 0.0).all()
    assert np.abs(run.force - master.solve(contacts, path).force).max() < 1e-14


PAPER = {
    "gaussian, A02's start": CASES["gaussian, A02's start"].path[2::3],
    "unequal mixture with a gap": np.array([0.45, 0.6, 0.95, 1.2, 2.1]),
    "one start below zero, among the thresholds": np.array([1.9, 2.1, 2.6, 3.2]),
}


@pytest.mark.parametrize("name", PAPER)
def test_the_papers_algorithm_agrees_with_the_master_equation(name: str) -> None:
    case = Case(CASES[name].contacts, PAPER[name])
    forces = np.array([closest(case.contacts, case.path, n_contacts=20, seed=seed)[0] for seed in range(SEEDS)])
    assert judge(forces, exact(case)) > LEVEL
