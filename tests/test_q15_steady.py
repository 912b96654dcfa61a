"""The paper's ageing closure in steady sliding: closed forms for a Gaussian target, other roads for other targets."""

import numpy as np
import pytest
from q15_references import gaussian_force
from scipy import stats
from scipy.linalg import solve_banded
from scipy.optimize import brentq

import master
import origins
from master.paper.q15_steady import paper_steady_state
from origins import Ageing, Contacts
from origins.laws.diffusion import Diffusion
from origins.thresholds.scipy_laws import as_thresholds

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)  # Fig. A05
FIGURE_A05 = [1e-5, 1e-4, 3e-4, 1e-3, 1e-2]


def closed_forms(mean_i, std_i, mean_f, std_f, diffusion):  # type: ignore[no-untyped-def]
    """C and F_k of diffusion with resetting between normal laws; C by bisection of its own equation."""
    rate = diffusion / std_f**2
    c = brentq(lambda c: mean_f - (mean_f - mean_i) / (1.0 + rate * c) - c, 0.5 * mean_i, 2.0 * mean_f, xtol=1e-15)
    first, second = 1.0 / (1.0 + rate * c), 1.0 / (1.0 + 2.0 * rate * c)
    square = mean_f**2 + 2.0 * mean_f * (mean_i - mean_f) * first + (mean_i - mean_f) ** 2 * second
    return c, 0.5 * (square + std_f**2 + (std_i**2 - std_f**2) * second) / c


@pytest.mark.parametrize("diffusion", [1e-8, *FIGURE_A05, 1.0, 1e4])
def test_direct_solution_and_closed_forms(diffusion: float) -> None:
    contacts = Contacts(FRESH, ageing=Ageing(FINAL, 2.0 * diffusion, closure="paper"))
    steady = master.steady_state(contacts, velocity=2.0)
    c, force = closed_forms(0.5, 0.1, 1.0, 0.01, diffusion)
    # of the fresh law 3e-7 lies below 0 and is cut off; the closed forms have it
    assert abs(steady.mean_threshold / c - 1.0) < 1e-6 and abs(steady.force / force - 1.0) < 1e-6
    # moments of the law as it is cut leave round-off
    c, cut = gaussian_force(FRESH.mean(), FRESH.moment(2), 1.0, 0.01, diffusion)
    assert abs(steady.mean_threshold - c) < 1e-12 and abs(steady.force - cut) < 1e-12
    assert abs(steady.force - cut) < 0.5 * steady.force_error < 5e-10 and steady.positivity_defect < 1e-15
    # C is both the mean of P_c and the integral of its survival
    x = np.linspace(0.0, 1.5, 30_001)
    assert np.trapezoid(steady.distribution(x), x) == pytest.approx(1.0, abs=1e-7)
    assert steady.thresholds.mean() == pytest.approx(steady.mean_threshold, rel=3e-9)


def test_crossover_and_limits() -> None:
    """λC = 1 at v = 7.5e3 D; F_k leaves both ends in proportion to D and to v."""
    d = np.geomspace(1e-12, 1e8, 400)
    c, force = gaussian_force(0.5, 0.26, 1.0, 0.01, d)
    assert (np.diff(force) > 0.0).all() and c[0] == pytest.approx(0.5) and c[-1] == pytest.approx(1.0)
    crossing = brentq(lambda d: d / 1e-4 * gaussian_force(0.5, 0.26, 1.0, 0.01, d)[0] - 1.0, 1e-6, 1e-2)
    assert 1.0 / crossing == pytest.approx(7.5e3, rel=1e-3)
    slope = np.polyfit(np.log(d[:100]), np.log(force[:100] - 0.26), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.01)
    slow = np.geomspace(1e2, 1e4, 20)
    slope = np.polyfit(np.log(slow), np.log(0.50005 - gaussian_force(0.5, 0.26, 1.0, 0.01, slow)[1]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.01)


def resting(fresh, final, amount, cells):  # type: ignore[no-untyped-def]
    """<x> and <x²> of diffusion with resetting, D C = amount: the resolvent of hops between cells."""
    edges = np.linspace(0.0, 6.0, cells + 1)
    hops = Diffusion(final, edges)
    up, down = amount * hops.up, amount * hops.down
    diagonal = 1.0 + np.append(up, 0.0) + np.append(0.0, down)
    p = solve_banded((1, 1), np.stack([np.append(0.0, -down), diagonal, np.append(-up, 0.0)]), hops.weights(fresh))
    middle = 0.5 * (edges[1:] + edges[:-1])
    return np.array([middle @ p, middle**2 @ p])


TWO_PEAKS = origins.mixture([origins.gaussian(0.7, 0.1), origins.gaussian(1.2, 0.1)], [0.5, 0.5])


@pytest.mark.parametrize("diffusion", [1e-3, 0.1])
@pytest.mark.parametrize(
    ("fresh", "final"),
    [
        (FRESH, origins.gw_plastic(1.5)),
        (origins.lubricated(0.4), as_thresholds(stats.gamma(9.0, scale=0.07))),
        (origins.rectangular(0.3, 0.7), TWO_PEAKS),
    ],
)
def test_other_targets_by_finite_volumes(fresh, final, diffusion: float) -> None:  # type: ignore[no-untyped-def]
    steady = paper_steady_state(fresh, Ageing(final, diffusion))
    c = steady.mean_threshold
    coarse, fine = (resting(fresh, final, diffusion * c, cells) for cells in (6000, 12_000))
    first, second = (4.0 * fine - coarse) / 3.0
    assert first == pytest.approx(c, rel=1e-6)
    assert 0.5 * second / c == pytest.approx(steady.force, rel=1e-6)


def test_single_fresh_value_and_any_speed() -> None:
    ageing = Ageing(FINAL, 1.0, closure="paper")
    for fresh in (origins.identical(0.5), FRESH):
        contacts = Contacts(fresh, ageing=ageing)
        forces = [master.steady_state(contacts, velocity=v).force for v in np.geomspace(1e-6, 1e9, 16)]
        known = gaussian_force(fresh.mean(), fresh.moment(2), 1.0, 0.01, 1.0 / np.geomspace(1e-6, 1e9, 16))[1]
        np.testing.assert_allclose(forces, known, rtol=1e-10)
