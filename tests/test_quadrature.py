"""Panels that follow a law wherever it is rough, and the moments they give."""

import numpy as np
import pytest
from scipy import stats
from scipy.special import gamma

import origins
from origins.thresholds.quadrature import gauss, panel_edges
from origins.thresholds.scipy_laws import as_thresholds

BETA = {1: 0.5, 2: 3.0 / 8.0, 3: 5.0 / 16.0, 4: 35.0 / 128.0}  # of the arcsine law

# law, its moments 1..4 in closed form, accuracy of the moments
CASES = {
    "x^(1/3) onset": (origins.gw_elastic(1.0), {n: gamma(1 + 0.75 * n) for n in BETA}, 1e-13),
    "weibull 0.4": (stats.weibull_min(0.4), {n: gamma(1 + 2.5 * n) for n in BETA}, 1e-12),
    "arcsine": (stats.beta(0.5, 0.5), BETA, 1e-12),
    "arcsine, far from 0": (
        stats.beta(0.5, 0.5, loc=1.0, scale=1e-3),
        {1: 1.0005, 2: 1.0 + 1e-3 + 0.375e-6, 3: 1 + 1.5e-3 + 3 * 0.375e-6 + 0.3125e-9},
        1e-12,
    ),
    "lognormal": (stats.lognorm(0.5), {n: np.exp(0.125 * n * n) for n in BETA}, 1e-13),
    "spike and broad": (
        origins.mixture([origins.gaussian(1.0, 1e-4), origins.gw_plastic(1.0)], [1e-3, 0.999]),
        {
            1: 1e-3 + 0.999 * gamma(1.5),
            2: 1e-3 * (1 + 1e-8) + 0.999,
            3: 1e-3 * (1 + 3e-8) + 0.999 * gamma(2.5),
        },
        1e-13,
    ),
    "atom inside": (
        origins.mixture(
            [origins.identical(0.5), origins.rectangular(0.0, 1.0), origins.identical(2.0)],
            [0.2, 0.5, 0.3],
        ),
        {1: 0.95, 2: 0.05 + 0.5 / 3 + 1.2, 3: 0.025 + 0.125 + 2.4},
        1e-14,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_moments(name: str) -> None:
    law, moments, accuracy = CASES[name]
    for n, exact in moments.items():
        assert as_thresholds(law).moment(n) == pytest.approx(exact, rel=accuracy)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_weight_far_from_the_edges_is_not_missed(scale: float) -> None:
    """Two narrow peaks a thousand widths apart, at any scale."""
    law = origins.mixture(
        [origins.gaussian(0.1 * scale, 1e-4 * scale), origins.gaussian(scale, 1e-3 * scale)],
        [1e-4, 1.0 - 1e-4],
    )
    edges = panel_edges(law)
    nodes, weights = gauss(edges[:-1], edges[1:])
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-13)
    first = nodes < 0.5 * scale
    assert (weights * law.pdf(nodes))[first].sum() == pytest.approx(1e-4, rel=1e-10)
    assert edges.size < 200


@pytest.mark.parametrize("name", CASES)
def test_edges_hold_breakpoints_and_stay_few(name: str) -> None:
    law = as_thresholds(CASES[name][0])
    edges = panel_edges(law)
    assert (np.diff(edges) > 0.0).all() and edges.size < 700
    assert np.isin(law.breakpoints[law.breakpoints <= edges[-1]], edges).all()
    assert edges[0] == law.support()[0] and law.sf(edges[-1]) <= 1.0001e-18


def test_upper_cuts_the_panels() -> None:
    law = origins.gw_elastic(1.0)
    edges = panel_edges(law, upper=0.7)
    nodes, weights = gauss(edges[:-1], edges[1:])
    assert edges[-1] == 0.7
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(float(law.cdf(0.7)), rel=1e-13)
    assert panel_edges(origins.rectangular(1.0, 2.0), upper=0.5).size == 0
    assert panel_edges(origins.identical(1.0)).size == 0
