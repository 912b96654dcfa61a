"""Moments of a surface from its power spectrum: closed forms, both conventions, and a surface that has it."""

import numpy as np
import pytest

import origins

HURST, LONG, SHORT = 0.8, 4e-6, 0.1e-6


def self_affine(q: np.ndarray) -> np.ndarray:
    """C(q) in m⁴, flat below the roll-off."""
    return 1e-31 * np.maximum(q * LONG / (2 * np.pi), 1.0) ** (-2 - 2 * HURST)


@pytest.mark.parametrize("points", [1, 40])
def test_self_affine_spectrum_in_closed_form(points: int) -> None:
    """A power law is integrated exactly, by however few points it is given."""
    low, bend, high = 1e3, 2 * np.pi / LONG, 2 * np.pi / SHORT
    q = np.unique(
        np.concatenate([np.geomspace(low, bend, points + 1), np.geomspace(bend, high, points + 1)])
    )
    found = origins.moments_of_spectrum(q, self_affine(q))
    flat, c = (lambda n: (bend ** (n + 2) - low ** (n + 2)) / (n + 2)), 1e-31 / (2 * np.pi)

    def falling(n: int) -> float:
        power = n - 2 * HURST
        return float(bend ** (2 + 2 * HURST) * (high**power - bend**power) / power)

    m0, slope2, curvature2 = (c * (flat(n) + falling(n)) for n in (0, 2, 4))
    assert found.m0 == pytest.approx(m0, rel=1e-12)
    assert found.rms_slope**2 == pytest.approx(slope2, rel=1e-12)
    assert found.m4 == pytest.approx(3 / 8 * curvature2, rel=1e-12)
    # the paper's R = ∫ q³ C dq/(4 pi) is half the mean square slope
    assert (
        found.m2 == pytest.approx(0.5 * slope2, rel=1e-12) and found.m2_axes[0] == found.m2_axes[1]
    )


@pytest.mark.parametrize("kind", ["isotropic", "profile"])
def test_gaussian_correlations_in_closed_form_in_order(kind: str) -> None:
    """<h(x)h(0)> = s² e^(-x²/l²): m0 = s², m2 = 2 s²/l², m4 = 12 s²/l⁴; between points the error is of second order."""
    s, length = 3e-8, 7e-7
    errors = []
    for points in (40, 80, 160):
        q = np.linspace(1e-4, 12.0, points) / length
        shape = np.exp(-((q * length) ** 2) / 4)
        c = (
            np.pi * s**2 * length**2 * shape
            if kind == "isotropic"
            else np.sqrt(np.pi) * s**2 * length * shape
        )
        found = origins.moments_of_spectrum(q, c, convention=kind)
        exact = s**2, 2 * s**2 / length**2, 12 * s**2 / length**4
        errors.append(
            [abs(a / b - 1) for a, b in zip((found.m0, found.m2, found.m4), exact, strict=True)]
        )
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.abs(orders[-1, 1:] - 2.0).max() < 0.2 and max(errors[-1]) < 4e-3


def test_spectrum_and_surface_give_the_same_thresholds() -> None:
    """A generated surface has this spectrum mode by mode: its slope to half a per cent, m0 but for the lowest q."""
    pixel, n = 20e-9, 512
    heights = origins.self_affine_surface(
        (n, n), pixel, hurst=HURST, rms_slope=0.1, seed=2, long_cutoff=LONG, short_cutoff=16 * pixel
    )
    area = (n * pixel) ** 2
    power = np.abs(np.fft.fft2(heights) / n**2) ** 2 * area
    q = 2 * np.pi * np.fft.fftfreq(n, pixel)[1 : n // 16 + 1]
    found = origins.moments_of_spectrum(q, power[1 : n // 16 + 1, 0])
    material = origins.Material(contact_modulus=2e9, local_friction=0.4, shear_modulus=1e9)
    for model, within in (("persson", 0.005), ("gw", 0.05)):
        options = {"model": model, "law": "amontons", "material": material, "pressure": 1e6}
        options |= {"patch_area": 1e-14} if model == "persson" else {}
        by_spectrum = origins.from_moments(found, **options)
        by_surface = origins.from_topography(
            heights, pixel, detrend="centre", periodic=True, **options
        )
        assert by_spectrum.mean() == pytest.approx(by_surface.mean(), rel=within)
        one, other = by_spectrum.interface, by_surface.interface
        assert one is not None and other is not None
        assert one.area_fraction == pytest.approx(other.area_fraction, rel=within)
