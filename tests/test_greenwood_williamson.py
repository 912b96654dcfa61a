"""Greenwood and Williamson's summits with Gaussian heights: the family and its load against mpmath."""

import mpmath
import numpy as np
import pytest
from scipy.special import log_ndtr

import origins
from origins.greenwood_williamson import GaussianSummits, log_height_integral, separation_of_load
from origins.powered import Powered
from origins.weibull import Weibull


def mp_integral(order: float, z: float) -> mpmath.mpf:
    """By the parabolic cylinder function: Gamma(n+1) e^(-z²/4) D_{-n-1}(z)/(2 pi)^(1/2)."""
    mpmath.mp.dps = 40
    n, z = mpmath.mpf(order), mpmath.mpf(z)
    return mpmath.gamma(n + 1) * mpmath.exp(-z * z / 4) * mpmath.pcfd(-n - 1, z) / mpmath.sqrt(2 * mpmath.pi)


@pytest.mark.parametrize("z", [-20.0, -3.0, 0.0, 1.3, 5.0, 20.0, 37.0])
@pytest.mark.parametrize("order", [0.0, 0.5, 0.75, 1.0, 1.5, 3.0])
def test_height_integrals_against_mpmath(order: float, z: float) -> None:
    exact = mpmath.log(mp_integral(order, z))
    assert log_height_integral(order, z) == pytest.approx(float(exact), rel=1e-13, abs=2e-13)


@pytest.mark.parametrize("z", [-40.0, -3.0, 0.0, 7.0, 40.0, 200.0])
def test_height_integral_of_order_zero_is_the_normal_tail(z: float) -> None:
    assert log_height_integral(0.0, z) == pytest.approx(float(log_ndtr(-z)), rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("z", [-20.0, -3.0, 0.0, 0.7, 5.0, 20.0, 37.0])
def test_separation_comes_back_from_the_load(z: float) -> None:
    log_load = float(mpmath.log(mp_integral(1.5, z)))
    assert separation_of_load(log_load) == pytest.approx(z, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("z", [-3.0, 0.0, 2.0, 20.0, 40.0])
@pytest.mark.parametrize("exponent", [0.5, 0.75, 1.0])
def test_gaussian_summits_against_mpmath(z: float, exponent: float) -> None:
    std, scale = 2e-8, 3.0 * (2e-8) ** (1.0 - exponent)
    law = GaussianSummits(z, std, scale, exponent)
    mpmath.mp.dps = 40
    touching = mpmath.ncdf(-z)
    for t in (1e-6, 1e-3, 0.1, 1.0, 5.0, 20.0):
        height = mpmath.mpf(t) / max(z, 1.0)
        x = float(scale * (std * height) ** exponent)
        height = (mpmath.mpf(x) / scale) ** (1 / mpmath.mpf(exponent)) / std
        survival = mpmath.ncdf(-(z + height)) / touching
        density = mpmath.npdf(z + height) / touching * height / (exponent * x)
        assert float(law.sf(x)) == pytest.approx(float(survival), rel=2e-12, abs=0.0)
        assert float(law.pdf(x)) == pytest.approx(float(density), rel=2e-12, abs=0.0)
        assert float(law.cdf(x)) == pytest.approx(float(1 - survival), rel=1e-11, abs=0.0)
        assert float(law.logsf(x)) == pytest.approx(float(mpmath.log(survival)), rel=1e-10)
    q = np.array([1e-12, 1e-6, 0.01, 0.5, 0.99])
    assert law.cdf(law.ppf(q)) == pytest.approx(q, rel=1e-10)
    assert law.sf(law.isf(q)) == pytest.approx(q, rel=1e-10)
    # the moments are quadratures over heights; the panels of the base class integrate x^n P_c
    for n in (1, 2, 3):
        assert law.moment(n) == pytest.approx(super(GaussianSummits, law)._moment(n), rel=1e-10)
    assert law.onset_power == pytest.approx(1.0 / exponent - 1.0, abs=1e-15)


def test_density_at_zero_is_its_limit() -> None:
    for z in (-3.0, 0.0, 20.0):
        height = float(mpmath.npdf(z) / mpmath.ncdf(-z))
        assert float(GaussianSummits(z, 2e-8, 3.0, 1.0).pdf(0.0)) == pytest.approx(height / 6e-8, rel=1e-12)
        assert float(GaussianSummits(z, 2e-8, 3.0, 0.75).pdf(0.0)) == 0.0
    # an exponential written as the square of a Rayleigh
    square = Powered(origins.gw_plastic(B=4.0), 1.0, 2.0)
    assert square.onset_power == 0.0 and square.pdf(0.0) == pytest.approx(4.0, rel=1e-12)
    x = np.array([0.0, 1e-6, 0.3, 50.0])
    assert square.pdf(x) == pytest.approx(4.0 * np.exp(-4.0 * x), rel=1e-12)
    assert square.logpdf(x) == pytest.approx(np.log(4.0) - 4.0 * x, rel=1e-12)
    assert [square.moment(n) for n in (1, 2, 3)] == pytest.approx([1 / 4, 2 / 16, 6 / 64], rel=1e-12)


@pytest.mark.parametrize("exponent", [0.5, 0.75, 1.0])
def test_light_loads_tend_to_exponential_heights(exponent: float) -> None:
    far = []
    for z in (10.0, 20.0, 40.0):
        limit = Weibull(1.0 / exponent, z, 1.0 / exponent - 1.0)
        x = limit.isf(np.array([0.9, 0.5, 0.1, 0.01]))
        far.append(np.abs(GaussianSummits(z, 1.0, 1.0, exponent).sf(x) - limit.sf(x)).max())
    orders = np.log2(np.array(far[:-1]) / far[1:])
    assert np.abs(orders - 2.0).max() < 0.05 and far[-1] < 1e-3
