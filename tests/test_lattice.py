"""Measures on a lattice: moments kept, integrals exact; series on panels against the functions they stand for."""

import numpy as np
import pytest

from master._old.lattice import STENCIL, cells, deposit_atoms, integrate, lagrange
from master._old.lattice import lay as lay_all
from master._old.piecewise import Piecewise, tabulate
from origins.thresholds.quadrature import gauss, panel_edges
from origins.thresholds.rectangular import rectangular
from origins.thresholds.weibull import gw_elastic

SIZE = 64


def lay(density, edges, step, size=SIZE):
    return lay_all(lambda x: [density(x)], 1, np.asarray(edges, dtype=float), step, size)[0]


def moments(masses, step, degree=7):
    nodes = step * np.arange(masses.size)
    return np.array([(masses * nodes**k).sum() for k in range(degree + 1)])


def assert_moments(masses, step, exact):
    # masses alternate in sign near 0, so round-off is counted in sums of their sizes
    sizes = moments(np.abs(masses), step)
    assert (np.abs(moments(masses, step) - exact) <= 4e-15 * np.maximum(sizes, np.abs(exact))).all()


def test_lagrange_weights_reproduce_polynomials_of_degree_seven():
    t = np.linspace(-1.0, 9.0, 41)
    weights = lagrange(t)
    assert weights.shape == (41, 8)
    for k in range(8):
        scale = np.abs(weights) @ np.arange(8.0) ** k
        assert (np.abs(weights @ np.arange(8.0) ** k - t**k) <= 1e-14 * scale).all()
    assert (lagrange(np.arange(8.0)) == np.eye(8)).all()


@pytest.mark.parametrize("step", [0.1, 0.0371, 1.7e-9, 3.1e8])
@pytest.mark.parametrize(("low", "high"), [(3.21, 8.67), (0.0, 5.0), (0.3, 0.6), (5.0, 5.2), (2.0, 2.0 + 1e-9)])
def test_a_box_keeps_eight_moments(low, high, step):
    masses = lay(lambda x: np.ones(x.shape), [low * step, high * step], step)
    k = np.arange(8)
    exact = ((high * step) ** (k + 1) - (low * step) ** (k + 1)) / (k + 1)
    if high - low < 1e-6:  # the difference of powers cancels
        exact = (high - low) * step * (0.5 * (low + high) * step) ** k
        assert np.abs(moments(masses, step) / exact - 1.0).max() < 1e-6
        return
    assert_moments(masses, step, exact)


def test_polynomial_densities_with_jumps_between_the_nodes_keep_eight_moments():
    # 8 Gauss nodes are exact to degree 15: jumps at every edge, cut anywhere
    rng = np.random.default_rng(4)
    step, edges = 0.07, np.sort(rng.uniform(0.0, 3.0, 9))
    heights = rng.normal(size=8)
    masses = lay(lambda x: heights[np.clip(np.searchsorted(edges, x) - 1, 0, 7)] * x**2, edges, step)
    exact = [(heights * np.diff(edges ** (k + 3.0)) / (k + 3.0)).sum() for k in range(8)]
    assert_moments(masses, step, np.array(exact))


@pytest.mark.parametrize("step", [0.05, 0.0123])
def test_cube_root_onset_keeps_eight_moments(step):
    law = gw_elastic(1.0)
    edges = panel_edges(law)
    masses = lay(law.pdf, edges, step, int(edges[-1] / step) + 20)
    nodes, weights = gauss(*cells(edges, step, masses.size))
    mass = weights * law.pdf(nodes)
    assert_moments(masses, step, np.array([(mass * nodes**k).sum() for k in range(8)]))
    # the panels end at survival 1e-18, which higher moments feel
    assert moments(masses, step, 2) == pytest.approx([1.0, law.moment(1), law.moment(2)], rel=4e-15)


def test_atoms_keep_eight_moments_and_stay_whole_on_a_node():
    step = 0.1
    positions, weights = np.array([0.0, 0.013, 0.25, 1.04999, 4.7]), np.array([0.2, 0.1, 0.3, 0.15, 0.25])
    masses = deposit_atoms(positions, weights, step, SIZE)
    assert_moments(masses, step, np.array([(weights * positions**k).sum() for k in range(8)]))
    whole = deposit_atoms(np.array([0.7]), np.array([0.4]), step, SIZE)
    assert whole[7] == 0.4
    assert np.count_nonzero(whole) == 1
    assert not deposit_atoms(np.empty(0), np.empty(0), step, SIZE).any()
    assert not deposit_atoms(np.array([SIZE * step]), np.array([1.0]), step, SIZE).any()


def test_no_mass_lands_before_the_first_node_or_beyond_the_last():
    masses = lay(lambda x: np.ones(x.shape), [0.0, 0.3], 1.0)
    assert masses.sum() == pytest.approx(0.3, rel=1e-14)
    assert masses.size == SIZE
    masses = lay(lambda x: np.ones(x.shape), [0.0, 1000.0], 1.0)
    assert masses[: SIZE - 8].sum() == pytest.approx(SIZE - 8.5, abs=1.0)


@pytest.mark.parametrize("shift", [0.0, 0.37])
def test_densities_laid_down_together_do_not_mix(shift):
    edges = np.array([shift, 2.0, 3.3])
    both = lay_all(lambda x: [np.ones(x.shape), x], 2, edges, 0.1, SIZE)
    assert (both[1] == lay(lambda x: x, edges, 0.1)).all()
    assert both[0].sum() == pytest.approx(3.3 - shift, rel=1e-14)
    assert both[1].sum() == pytest.approx((3.3**2 - shift**2) / 2, rel=1e-14)


def test_cells_hold_no_node_inside_and_cover_the_whole():
    step = 0.1
    edges = np.array([0.0, 0.03, 0.25, 0.3, 0.62])
    left, right = cells(edges, step, SIZE)
    assert left[0] == 0.0
    assert right[-1] == 0.62
    assert (left[1:] == right[:-1]).all()
    assert (np.floor(0.5 * (left + right) / step) == np.floor((left + 1e-12) / step)).all()
    assert np.isin(edges, np.append(left, right[-1])).all()
    assert cells(np.empty(0), step, SIZE)[0].size == 0


@pytest.mark.parametrize("degree", range(7))
def test_integral_of_a_deposited_polynomial_is_exact_away_from_its_ends(degree):
    size, step = 40, 0.5
    masses = lay(lambda x: x**degree, [0.0, (size - 1) * step], step, size)
    got, nodes = integrate(masses), step * np.arange(size)
    inner = slice(2 * STENCIL, size - STENCIL)  # the ends' stencils are one-sided
    assert np.abs(got - nodes ** (degree + 1) / (degree + 1))[inner].max() < 1e-14 * nodes[-1] ** (degree + 1)


def test_integral_converges_at_eighth_order():
    errors, steps = [], np.array([0.05, 0.0371, 0.025])
    for step in steps:
        size = round(6.0 / step) + 20
        masses = lay(lambda x: np.sin(3.0 * x), [0.0, (size - 1) * step], step, size)
        nodes = step * np.arange(size)
        error = np.abs(integrate(masses) - (1.0 - np.cos(3.0 * nodes)) / 3.0)
        errors.append(error[(nodes > 4.0) & (nodes < 6.0)].max())
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(order - 8.0) < 0.2


def test_running_sums_of_a_million_terms_lose_nothing():
    # equal terms rounded the same way at every addition would drift
    step = 0.0021
    masses = np.full(500_000, step)
    nodes = step * np.arange(masses.size)
    got = integrate(masses)
    assert np.abs(np.diff(got[[1000, -1]])[0] - (nodes[-1] - nodes[1000])) < 1e-12 * nodes[-1]


# -- series on panels --------------------------------------------------------------------------------------------


def test_series_and_its_integral_against_known_functions():
    def rows(x):
        return np.stack([np.exp(-x) * np.cos(5.0 * x), np.cbrt(x), np.exp(-0.5 * ((x - 1.3) / 1e-3) ** 2)])

    edges = np.array([0.0, 1.3, 2.0])
    wave, root, peak = tabulate(rows, edges)
    x = np.concatenate([np.linspace(0.0, 2.0, 1001), 1.3 + np.linspace(-5e-3, 5e-3, 101), [1e-12, 1e-6]])
    assert np.abs(wave(x) - np.exp(-x) * np.cos(5.0 * x)).max() < 1e-13
    assert np.abs(peak(x) - rows(x)[2]).max() < 1e-12
    integral = (1.0 + np.exp(-x) * (5.0 * np.sin(5.0 * x) - np.cos(5.0 * x))) / 26.0
    assert np.abs(wave.integral(x) - integral).max() < 1e-14
    assert np.abs(root.integral(x) - 0.75 * x ** (4.0 / 3.0)).max() < 1e-14
    assert root.total == pytest.approx(0.75 * 2.0 ** (4.0 / 3.0), rel=1e-14)
    assert peak.total == pytest.approx(1e-3 * np.sqrt(2.0 * np.pi), rel=1e-12)
    assert (wave.edges == root.edges).all()


def test_jumps_on_edges_stay_jumps():
    (step,) = tabulate(lambda x: np.where(x < 1.0, 2.0, 5.0)[None], np.array([0.0, 1.0, 3.0]))
    assert step.edges.size == 3
    assert step(np.array([0.0, 1.0 - 1e-14, 1.0, 3.0])) == pytest.approx([2.0, 2.0, 5.0, 5.0], rel=1e-13)
    assert step.integral(np.array([0.5, 1.0, 2.0, 3.0, 4.0])) == pytest.approx([1.0, 2.0, 7.0, 12.0, 12.0], rel=1e-14)


def test_outside_its_panels_a_series_is_zero_and_its_integral_constant():
    (ramp,) = tabulate(lambda x: x[None], np.array([1.0, 2.0]))
    assert (ramp(np.array([0.0, 0.999, 2.001, 7.0])) == 0.0).all()
    assert ramp.integral(np.array([0.0, 1.0, 2.0, 9.0])) == pytest.approx([0.0, 0.0, 1.5, 1.5], abs=1e-15)
    nothing = Piecewise(np.zeros(1), np.empty((16, 0)))
    assert (nothing(np.ones(3)) == 0.0).all()
    assert (nothing.integral(np.ones(3)) == 0.0).all()
    assert nothing.total == 0.0


@pytest.mark.parametrize("accuracy", [1e-4, 1e-7, 1e-10])
def test_stated_error_of_a_loose_series_holds_and_loose_costs_less(accuracy):
    def wave(x):
        return (np.sin(40.0 * x) / (0.01 + x**2))[None]

    (loose,), (tight,) = (tabulate(wave, np.array([0.0, 3.0]), a) for a in (accuracy, 1e-16))
    x = np.linspace(0.0, 3.0, 3001)
    true = np.abs(loose.integral(x) - tight.integral(x)).max()
    assert true <= loose.error
    assert abs(loose.total - tight.total) <= loose.total_error
    assert loose.edges.size < tight.edges.size


def test_panels_of_a_rectangular_law_hold_its_jumps():
    masses = lay(rectangular(0.5, 1.5).pdf, panel_edges(rectangular(0.5, 1.5)), 0.0317)
    assert_moments(masses, 0.0317, np.array([(1.5 ** (k + 1) - 0.5 ** (k + 1)) / (k + 1) for k in range(8)]))
