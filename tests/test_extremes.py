"""Stiff and extreme scenes, each against an answer that does not come from the solver."""

import numpy as np
import pytest
import scipy.stats

import eq_model
import master
import origins


def renewed(law: origins.Thresholds, start: float, end: float, cells: int) -> float:
    """F at X = end by the plainest road: thresholds on a lattice of `cells` through their survival alone."""
    step = end / cells
    edges = step * (np.arange(cells + 1) - 0.5)
    kernel = np.diff(-law.sf(np.maximum(edges, 0.0)))
    held = np.exp(law.logsf(np.maximum(abs(start), start + edges)) - law.logsf(abs(start)))
    breaks = -np.diff(held)
    for j in range(1, cells):
        breaks[j] += kernel[1 : j + 1] @ breaks[j - 1 :: -1][:j]
    age = end - step * np.arange(cells)
    born = float((breaks * age * law.sf(age)).sum())
    return born + (start + end) * float(np.exp(law.logsf(max(abs(start), start + end)) - law.logsf(abs(start))))


@pytest.mark.parametrize(
    ("law", "start", "end"),
    [
        (origins.gaussian(1.0, 0.05), 1.4, 0.5),
        (origins.gaussian(1.0, 0.05), 1.5, 0.125),
        (origins.gaussian(1.0, 0.05), 2.5, 0.125),
        (origins.gw_plastic(1.0), 7.0, 0.625),
    ],
)
def test_start_in_the_far_tail(law: origins.Thresholds, start: float, end: float) -> None:
    found = master.solve(origins.Contacts(law, start), [0.0, end], 1e-9)
    assert found.success
    # the lattice errs in the first order of its step: two of them leave the second
    coarse, fine = (renewed(law, start, end, cells) for cells in (1500, 3000))
    assert found.force[-1] == pytest.approx(2.0 * fine - coarse, abs=3e-4)


def test_exponential_thresholds_forget_where_they_start() -> None:
    found = master.solve(origins.Contacts(scipy.stats.expon(), 45.0), [0.0, 1.0, 5.0], 1e-10)
    assert found.force == pytest.approx(1.0 + 44.0 * np.exp(-found.path), abs=1e-9)


@pytest.mark.parametrize("width", [1e-2, 1e-3, 1e-4, 1e-6])
def test_narrow_rectangle_between_two_generations(width: float) -> None:
    """At X = n + 1/2 every contact has broken n times, and released n mean thresholds."""
    contacts = origins.Contacts(origins.rectangular(1.0, 1.0 + width))
    path = np.array([0.0, 5.5, 20.5])
    found = master.solve(contacts, path, 1e-8)
    error = np.abs(found.force - (path - np.floor(path) * (1.0 + 0.5 * width))).max()
    assert error <= found.force_error
    # where positions are rounded to 1e-10 of the width and less, the tolerance is out of reach
    assert found.success == (width > 1e-5)


@pytest.mark.parametrize("end", [20.0, 100.0])
def test_corners_that_a_foreign_law_does_not_declare(end: float) -> None:
    counts = np.histogram(np.random.default_rng(1).gamma(4.0, 0.25, 2000), bins=12)
    law = scipy.stats.rv_histogram(counts).freeze()
    contacts = origins.Contacts(law)
    # long after decoherence
    found = master.solve(contacts, [0.0, end], 1e-7)
    kinetic = master.steady_state(contacts).force
    assert abs(found.force[-1] - kinetic) <= found.force_error * contacts.mean_threshold
    assert found.force_error < 1e-6


def test_rare_thresholds_far_beyond_the_mean() -> None:
    law = origins.mixture([origins.gaussian(0.1, 0.03), origins.gaussian(200.0, 2.0)], [0.999, 0.001])
    contacts = origins.Contacts(law)
    found, steady = master.propensity(contacts), master.steady_state(contacts)
    path = np.linspace(0.0, 260.0, 5201)
    force = master.solve(contacts, path, 1e-6).force
    assert found.static_to_kinetic == pytest.approx(force.max() / steady.force, rel=1e-4)
    assert found.critical_spring == pytest.approx(-(np.diff(force) / np.diff(path)).min(), rel=1e-2)


def test_density_that_diverges_above_zero_has_no_critical_spring() -> None:
    assert master.propensity(origins.Contacts(scipy.stats.arcsine())).critical_spring == np.inf
    assert master.propensity(origins.Contacts(scipy.stats.beta(2.0, 0.9))).critical_spring == np.inf


@pytest.mark.parametrize("law", [scipy.stats.beta(0.5, 0.5), scipy.stats.beta(3.0, 0.2)])
def test_weight_at_a_point_that_no_node_can_reach_is_not_lost(law) -> None:
    contacts = origins.Contacts(law)
    # contacts of the second law remember their start for 5 thresholds
    found = master.solve(contacts, [0.0, 300.0 * contacts.mean_threshold], 1e-4)
    kinetic = master.steady_state(contacts).force
    assert abs(found.force[-1] - kinetic) <= found.force_error * contacts.mean_threshold
    # without that weight the force drifts by several mean thresholds
    assert found.force_error < 0.1


@pytest.mark.parametrize(
    "law",
    [scipy.stats.halfnorm(), scipy.stats.triang(0.5, 0.2, 1.6), scipy.stats.rice(1.0), scipy.stats.fisk(2.5)],
    ids=lambda law: law.dist.name,
)
def test_any_frozen_law_in_both_solvers(law) -> None:
    contacts = origins.Contacts(law)
    path = np.linspace(0.0, 4.0 * contacts.mean_threshold, 9)
    exact, found = master.solve(contacts, path, 1e-8), eq_model.simulate(contacts, path, n_contacts=20_000, seed=3)
    assert exact.success
    assert (np.abs(found.force - exact.force)[1:] < 5.0 * found.force_standard_error[1:]).all()


