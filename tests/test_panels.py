"""Number conservation on panels: order, claims beside true errors, Q(x;X), far paths, wall time."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.stats
from phase_type import gaussian_force

import master
import origins


@pytest.mark.parametrize("seed", range(8))
def test_claims_bound_true_errors_and_are_near_them(seed: int) -> None:
    """40 seeded Gaussian scenes against their closed form; what is refused or unsuccessful fails."""
    generator, ratios = np.random.default_rng([7, seed]), []
    for _ in range(5):
        std, x0 = generator.uniform(0.02, 0.11), generator.uniform(0.0, 0.1)
        s0, end = generator.uniform(0.01, 0.05), generator.uniform(1.0, 12.0)
        tolerance = 10.0 ** generator.uniform(-10.0, -5.0)
        start = origins.gaussian_start(x0, s0)
        path = np.linspace(0.0, end, 301)
        found = master.solve(origins.Contacts(origins.gaussian(1.0, std), start), path, tolerance)
        error = np.abs(found.force - gaussian_force(path, 1.0, std, x0, s0)).max()
        assert found.success and error <= found.force_error
        ratios.append(found.force_error / error)
    assert np.median(ratios) < 30.0


PATHS = {
    "forward": ({}, np.linspace(0.0, 3.0, 7)),
    "from a width": ({"start": origins.gaussian_start(0.1, 0.05)}, np.linspace(0.0, 3.0, 7)),
    "linked": ({"stiffness": "linked"}, np.linspace(0.0, 3.0, 7)),
    "delay": ({"delay": origins.Delay(0.3)}, np.linspace(0.0, 3.0, 7)),
    "re-forming behind": ({"reforming": -0.2}, np.linspace(0.0, 3.0, 7)),
}


@pytest.mark.parametrize("name", PATHS)
def test_stretches_add_up_to_what_holds_and_to_the_force(name: str) -> None:
    laws, path = PATHS[name]
    contacts = origins.Contacts(origins.gaussian(1.0, 0.15), **laws)
    found = master.solve(contacts, path, 1e-9)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    for position, force, holding in zip(path, found.force, found.holding, strict=True):
        spread = found.distribution(float(position))
        # births at X = 0 and now, and the start's own stretches, make corners of the density
        corners = [
            -0.7,
            -0.2,
            0.0,
            0.1,
            position - 0.5,
            position - 0.2,
            position,
            position + 0.6,
            3.9,
        ]
        edges = np.unique(np.concatenate([np.linspace(-0.7, 3.9, 231), corners]))
        half = 0.5 * np.diff(edges)[:, None]
        x = 0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes
        mass = half * weights * spread.density(x)
        total = mass.sum() + spread.delta_weights.sum()
        assert total == pytest.approx(holding, abs=1e-6)
        if name != "linked":
            mean = (mass * x).sum() + spread.delta_weights @ spread.delta_positions
            assert mean == pytest.approx(force, abs=1e-6)


def test_ten_thousand_breaks_of_a_narrow_law() -> None:
    path = np.append(np.linspace(0.0, 60.0, 301), [4000.3, 1e4])
    found = master.solve(origins.Contacts(origins.gaussian(1.0, 0.01)), path, 1e-6)
    exact = gaussian_force(path[:-1], 1.0, 0.01)
    assert found.success and found.force_error <= 1e-6
    assert np.abs(found.force[:-1] - exact).max() <= found.force_error


def test_wall_time_ends_a_solution_with_what_there_is() -> None:
    path = np.linspace(0.0, 50.0, 501)
    contacts = origins.Contacts(origins.gaussian(1.0, 1e-3))
    found = master.solve(contacts, path, wall_time=1e-9)
    assert not found.success and "wall_time" in found.message
    assert found.path.size == found.force.size < path.size
    with pytest.raises(origins.InputError, match="wall_time"):
        master.solve(contacts, path, wall_time=0.0)


def test_contacts_that_re_form_behind_on_a_path_that_turns() -> None:
    """No panel is narrow: a minute's work for 1e-5, when births were told by the leg before."""
    contacts = origins.Contacts(origins.gw_elastic(1.0), reforming=-0.04)
    found = master.solve(contacts, [0.0, 0.4, -0.2], 1e-6)
    best = master.solve(contacts, [0.0, 0.4, -0.2], 1e-11)
    assert found.success and found.nodes < 2000
    assert np.abs(found.force - best.force).max() <= found.force_error + best.force_error


def test_corners_that_a_law_does_not_declare_are_found_to_rounding() -> None:
    """Bins of a scipy histogram, whose edges nobody tells, take as few panels as told ones."""
    edges = np.linspace(0.5, 1.5, 13)
    counts = np.random.default_rng(1).random(12) + 0.1
    untold = scipy.stats.rv_histogram((counts, edges)).freeze()
    told = origins.mixture(
        [origins.rectangular(low, high) for low, high in pairwise(edges)],
        (counts / counts.sum()).tolist(),
    )
    path = np.linspace(0.0, 5.0, 101)
    found = [master.solve(origins.Contacts(thresholds=law), path) for law in (untold, told)]
    assert all(solved.success for solved in found)
    assert found[0].force == pytest.approx(found[1].force, abs=1e-11)
    assert found[0].nodes < 2 * found[1].nodes
