"""Integrals over summits, load against separation in every regime, and the plastic branch, each against mpmath."""

import mpmath
import numpy as np
import pytest

import origins
from origins.roughness.greenwood_williamson import critical_compression, pressed, summits_of

MOMENTS = origins.moments_of_summits(radius=20e-6, std=0.2e-6, density=3e9)
MATERIAL = origins.Material(contact_modulus=3e9, hardness=6e7)


def mp_whole(order: float, z: float) -> mpmath.mpf:
    """By the parabolic cylinder function: Gamma(n+1) e^(-z²/4) D_{-n-1}(z)/(2 pi)^(1/2)."""
    mpmath.mp.dps = 40
    n, z = mpmath.mpf(order), mpmath.mpf(z)
    return (
        mpmath.gamma(n + 1)
        * mpmath.exp(-z * z / 4)
        * mpmath.pcfd(-n - 1, z)
        / mpmath.sqrt(2 * mpmath.pi)
    )


def mp_beyond(order: int, z: float, lower: float) -> mpmath.mpf:
    """Whole orders from `lower` on, by parts: J_n = a^(n-1) phi + (n-1) J_{n-2} - z J_{n-1}, at digits to cancel."""
    mpmath.mp.dps = 80
    z, a = mpmath.mpf(z), mpmath.mpf(lower)
    values = [mpmath.ncdf(-(z + a)), mpmath.npdf(z + a) - z * mpmath.ncdf(-(z + a))]
    for n in range(2, order + 1):
        values.append(
            a ** (n - 1) * mpmath.npdf(z + a) + (n - 1) * values[n - 2] - z * values[n - 1]
        )
    return values[order]


def mp_below(order: float, z: float, upper: float) -> mpmath.mpf:
    """By the power series of e^(-zt) and of e^(-t²/2), for an upper end that is not large."""
    mpmath.mp.dps = 60
    z, a, n = mpmath.mpf(z), mpmath.mpf(upper), mpmath.mpf(order)
    coefficients = [mpmath.mpf(1), -z]
    for k in range(2, 220):
        coefficients.append((-z * coefficients[-1] - coefficients[-2]) / k)
    total = mpmath.fsum(c * a ** (n + 1 + k) / (n + 1 + k) for k, c in enumerate(coefficients))
    return total * mpmath.npdf(z)


@pytest.mark.parametrize("heights", ["gaussian", "exponential"])
@pytest.mark.parametrize("regime", ["elastic", "plastic", "mixed"])
def test_pressure_and_separation_undo_each_other(regime: str, heights: str) -> None:
    options = {"material": MATERIAL, "regime": regime, "height_law": heights}
    for z in (
        (0.0, 0.7, 5.0, 20.0, 37.0)
        if heights == "exponential"
        else (-1.0, 0.0, 0.7, 5.0, 20.0, 37.0)
    ):
        height = z * MOMENTS.summit_std
        pressure = origins.pressure_of_separation(MOMENTS, height, **options)
        again = origins.separation_of_pressure(MOMENTS, pressure, **options)
        assert again == pytest.approx(height, rel=1e-12, abs=1e-12 * MOMENTS.summit_std)
    # and where a summit that does not touch makes the pressure 1e-290 Pa
    far = origins.separation_of_pressure(MOMENTS, 1e-290, **options)
    assert far > 30.0 * MOMENTS.summit_std
    assert origins.pressure_of_separation(MOMENTS, far, **options) == pytest.approx(
        1e-290, rel=1e-10
    )


@pytest.mark.parametrize("z", [-30.0, 0.5, 37.0])
@pytest.mark.parametrize("index", [0.3, 7.0, 40.0])
def test_mixed_load_against_mpmath(z: float, index: float) -> None:
    """Load (4/3) E* r^(1/2) delta^(3/2) up to delta_c, then pi r delta H, each an integral of its own."""
    std, radius, density, e_star = (
        MOMENTS.summit_std,
        MOMENTS.summit_radius,
        MOMENTS.summit_density,
        3e9,
    )
    hardness = 3.0 * e_star / index * np.sqrt(std / radius)
    at = critical_compression(radius, e_star, hardness) / std
    assert at == pytest.approx((2.25 * np.pi / index) ** 2, rel=1e-12)
    elastic = mp_whole(1.5, z)
    if abs(z) * at < 40.0:
        below = mp_below(1.5, z, at)
    else:
        mpmath.mp.dps = 30
        edges = [
            at,
            *(at + k / max(z, 1.0) for k in (0.3, 1, 3, 8, 20, 60)),
            *([-z] if -z > at else []),
        ]
        below = elastic - mpmath.quad(lambda t: t**1.5 * mpmath.npdf(z + t), sorted(edges))
    exact = (
        density
        * std
        * (
            4.0 / 3.0 * e_star * np.sqrt(radius * std) * below
            + np.pi * radius * hardness * mp_beyond(1, z, at)
        )
    )
    summits = summits_of(
        MOMENTS, origins.Material(contact_modulus=e_star, hardness=hardness), "mixed", "gaussian"
    )
    assert np.log(summits.pressure(z)) == pytest.approx(
        float(mpmath.log(exact)), rel=1e-13, abs=1e-12
    )
    assert summits.separation(summits.pressure(z)) == pytest.approx(z, rel=1e-11)


def test_plastic_load_is_hardness_times_area() -> None:
    for heights in ("gaussian", "exponential"):
        contact = pressed(summits_of(MOMENTS, MATERIAL, "plastic", heights), 2e6)
        assert contact.area_fraction == pytest.approx(2e6 / 6e7, rel=1e-12)
    # exponential heights, in closed form: elastic contacts below delta_c, e^-tau of them beyond
    tau = critical_compression(MOMENTS.summit_radius, 3e9, 6e7) / MOMENTS.summit_std
    contact = pressed(summits_of(MOMENTS, MATERIAL, "mixed", "exponential"), 2e6)
    assert contact.fraction_beyond(tau * MOMENTS.summit_std) == pytest.approx(
        np.exp(-tau), rel=1e-12
    )
    per_contact = mpmath.gammainc(2.5, 0, tau) + mpmath.sqrt(tau) * mpmath.gammainc(2, tau)
    hertz = 4 / 3 * 3e9 * np.sqrt(MOMENTS.summit_radius) * MOMENTS.summit_std**1.5
    assert contact.contact_density == pytest.approx(2e6 / float(hertz * per_contact), rel=1e-12)


def test_summits_by_their_parameters() -> None:
    assert MOMENTS.summit_radius == pytest.approx(20e-6, rel=1e-14)
    assert MOMENTS.summit_std == pytest.approx(0.2e-6, rel=1e-14)
    assert MOMENTS.summit_density == pytest.approx(3e9, rel=1e-14)
