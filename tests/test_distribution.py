"""Q(x;X) from the solution: all contacts are there, their mean stretch is the force, exact single values are named."""

import numpy as np
import pytest
import scipy.stats

import master
import origins

END = 3.0
PATH = np.linspace(0.0, END, 31)
PLACES = (0.0, 0.37, 1.0, 1.9, END)

LAWS = {
    "gaussian": origins.gaussian(1.0, 0.1),
    "weibull": origins.gw_plastic(1.0),
    "onset": origins.gw_elastic(1.0),
    "rectangular": origins.rectangular(0.5, 1.5),
    "atoms": origins.mixture([origins.identical(0.95), origins.identical(1.05)], [0.5, 0.5]),
    "atom beside": origins.mixture([origins.identical(0.8), origins.gaussian(1.0, 0.1)], [0.3, 0.7]),
}
STARTS = {
    "relaxed": None,
    "stretched": 0.31,
    "behind": -0.21,
    "gaussian": origins.gaussian_start(0.05, 0.03),
    "uniform": scipy.stats.uniform(-0.2, 0.4),
}


def integrals(q, law, start, at):
    """Mass and mean of the density by Gauss nodes between everything it may jump or peak at."""
    atoms = law.atoms[0]
    points = [*law.breakpoints, *start.breakpoints, *start.span, *np.linspace(-1.0, 4.5, 441)]
    ends = np.array([*law.breakpoints, *atoms, *(at - np.array([*law.breakpoints, *atoms, 2.0 * atoms.sum()]))])
    sums = np.add.outer(atoms, atoms).ravel() if atoms.size else np.empty(0)
    sums = np.append(sums, np.add.outer(law.breakpoints, law.breakpoints).ravel())
    begin = np.array([*start.breakpoints, *start.span])
    twice = np.add.outer(sums, -begin).ravel()  # and those that broke before
    births = np.concatenate([np.add.outer(law.breakpoints, -begin).ravel(), sums, twice, np.abs(begin) - begin])
    # births begin as x^(1/3) below `at`, survival as 1 - x^(4/3) above 0: panels close in on both, and on the start's
    closing = np.geomspace(1e-13, 0.02, 60)
    places = at - np.append(births, np.abs(begin))
    corners = [closing, at - closing, np.add.outer(places, closing).ravel(), np.subtract.outer(places, closing).ravel()]
    edges = np.unique(np.concatenate([points, ends, begin + at, at - births, [0.0, 0.5 * at, at], *corners]))
    edges = edges[(edges >= -1.0) & (edges <= 4.5)]
    nodes, weights = np.polynomial.legendre.leggauss(10)
    half = 0.5 * np.diff(edges)[:, None]
    x = 0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes
    density = q.density(x) * half * weights
    return density.sum(), (density * x).sum()


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("law", LAWS)
def test_mass_is_one_and_the_mean_is_the_force(law, start):
    contacts = origins.Contacts(LAWS[law], STARTS[start])
    solution = master.solve(contacts, np.union1d(PATH, PLACES), 1e-9)
    for at in PLACES:
        q = solution.distribution(at)
        allowed = max(1e-8, 10.0 * solution.force_error)
        if law == "rectangular":  # bends of the third generation, within a few nodes of known places, are not put right
            allowed = max(allowed, 0.1 * (END / max(solution.nodes, 1)) ** 2)
        mass, mean = integrals(q, LAWS[law], contacts.start, at)
        assert mass + q.delta_weights.sum() == pytest.approx(1.0, abs=allowed)
        force = solution.force[np.searchsorted(solution.path, at)]
        assert mean + (q.delta_weights * q.delta_positions).sum() == pytest.approx(force, abs=allowed)


def test_contacts_from_one_stretch_stay_one_until_they_break():
    solution = master.solve(origins.Contacts(origins.gaussian(1.0, 0.1), 0.2), PATH, 1e-8)
    q = solution.distribution(0.75)
    assert q.delta_positions == pytest.approx([0.95], rel=1e-14)
    assert q.delta_weights == pytest.approx([scipy.stats.norm(1.0, 0.1).sf(0.95)], rel=1e-11)
    q = solution.distribution(0.0)
    assert q.delta_positions == pytest.approx([0.2])
    assert q.delta_weights == pytest.approx([1.0])
    assert (q.density(np.linspace(-1.0, 2.0, 32)) == 0.0).all()


def test_identical_contacts_are_all_at_one_stretch_for_ever():
    solution = master.solve(origins.Contacts(origins.identical(1.0)), np.linspace(0.0, 50.0, 101), 1e-9)
    for at in (0.0, 0.25, 1.0, 7.5, 49.999):
        q = solution.distribution(at)
        assert q.delta_positions == pytest.approx([at % 1.0], abs=1e-12)
        assert q.delta_weights == pytest.approx([1.0], abs=1e-13)


def test_late_contacts_follow_survival_over_the_mean():
    law = origins.gw_plastic(2.0)
    solution = master.solve(origins.Contacts(law, origins.gaussian_start(0.1, 0.05)), np.linspace(0.0, 30.0, 301), 1e-9)
    x = np.linspace(0.0, 2.5, 101)
    assert solution.distribution(30.0).density(x) == pytest.approx(law.sf(x) / law.mean(), abs=1e-9)


@pytest.mark.parametrize("position", [-0.1, 3.1, float("nan"), float("inf"), "1", None, True])
def test_positions_off_the_path_are_refused(position):
    solution = master.solve(origins.Contacts(origins.gaussian(1.0, 0.1)), PATH, 1e-8)
    with pytest.raises(origins.InputError, match=r"^position = "):
        solution.distribution(position)
