"""The paper's ageing closure in steady sliding: closed forms for a Gaussian target, other roads for other targets."""

import numpy as np
import pytest
from q15_references import gaussian_force
from scipy import stats
from scipy.linalg import solve_banded
from scipy.optimize import brentq
from scipy.special import ive

import master
import origins
from master.paper.q15_steady import paper_steady_state
from origins import Ageing, Contacts
from origins.laws.diffusion import Diffusion
from origins.thresholds.quadrature import gauss
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


def rice_mean(distance, spread):  # type: ignore[no-untyped-def]
    """Mean length of a plane vector: one of length `distance` and normal noise of `spread` on each component."""
    u = np.minimum(0.25 * (distance / spread) ** 2, 1e5)
    near = spread * np.sqrt(np.pi / 2.0) * ((1.0 + 2.0 * u) * ive(0, u) + 2.0 * u * ive(1, u))
    share = (spread / np.maximum(distance, spread)) ** 2
    return np.where(u < 1e5, near, distance * (1.0 + 0.5 * share + 0.125 * share**2))


@pytest.mark.parametrize("diffusion", [1e-5, 1e-3, 0.03, 1.0, 100.0])
def test_rayleigh_target_by_quadrature(diffusion: float) -> None:
    """P_cf = x exp(-x²/2s²): the length of a plane Ornstein-Uhlenbeck process, averaged over ages between resets."""
    s = 0.8
    fresh, final = origins.gaussian(0.6, 0.1), origins.gw_plastic(0.5 / s**2)
    assert final.mean() == pytest.approx(s * np.sqrt(np.pi / 2.0))
    steady = paper_steady_state(fresh, Ageing(final, diffusion))
    nodes, weights = np.polynomial.legendre.leggauss(120)
    x0 = 0.6 + 0.6 * nodes
    fresh_weights = 0.6 * weights * fresh.pdf(x0)
    rate = diffusion / s**2
    # ages in units of C, on panels that grow from next to nothing
    edges = np.append(0.0, np.geomspace(1e-14, 45.0, 50))
    ages, shares = (part.ravel() for part in gauss(edges[:-1], edges[1:]))
    shares *= np.exp(-ages)

    def moments(c):  # type: ignore[no-untyped-def]
        kept = np.exp(-rate * c * ages)
        spread = s * np.sqrt(-np.expm1(-2.0 * rate * c * ages))
        mean = shares @ (rice_mean(x0 * kept[:, None], spread[:, None]) @ fresh_weights)
        second = 1.0 / (1.0 + 2.0 * rate * c)
        return mean, 2.0 * s**2 + (fresh.moment(2) - 2.0 * s**2) * second

    c = brentq(lambda c: moments(c)[0] - c, 0.3, 2.0, xtol=1e-15)
    assert steady.mean_threshold == pytest.approx(c, rel=2e-8)
    assert steady.force == pytest.approx(0.5 * moments(c)[1] / c, rel=2e-8)
    assert steady.force_error < 1e-8


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


def test_a_far_tail_is_told() -> None:
    """A final law whose <x²> lies far out: by finite volumes on a grid of its own, and an error that says so."""
    final = as_thresholds(stats.lomax(4.0, scale=3.0))
    steady = paper_steady_state(FRESH, Ageing(final, 0.1))
    c, edges = steady.mean_threshold, np.sinh(np.linspace(0.0, np.arcsinh(1e6), 40_001))
    hops = Diffusion(final, edges)
    up, down = 0.1 * c * hops.up, 0.1 * c * hops.down
    diagonal = 1.0 + np.append(up, 0.0) + np.append(0.0, down)
    p = solve_banded((1, 1), np.stack([np.append(0.0, -down), diagonal, np.append(-up, 0.0)]), hops.weights(FRESH))
    middle = 0.5 * (edges[1:] + edges[:-1])
    np.testing.assert_allclose([middle @ p, 0.5 * (middle**2 @ p) / c], [c, steady.force], rtol=2e-7)
    heavy = paper_steady_state(FRESH, Ageing(as_thresholds(stats.lomax(2.1, scale=3.0)), 1e6))
    assert not heavy.success and heavy.message.startswith("F_k known to")
