"""The generated surface: its slope is what was asked for, exactly, whatever the seed."""

import numpy as np
import pytest

import origins

CASES = [
    ((64, 64), 1.0, {"hurst": 0.8}),
    ((63, 48), (1.0, 2.5), {"hurst": 0.5, "short_cutoff": 9.0}),
    ((40, 57), (3e-8, 2e-8), {"hurst": 1.0, "long_cutoff": 6e-7, "short_cutoff": 1e-7}),
]


def modes(h: np.ndarray, dx: float, dy: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """|a_q|², q_x, q_y over the full plane, off the heights alone."""
    power = np.abs(np.fft.fft2(h) / h.size) ** 2
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(h.shape, (dx, dy), strict=True))
    return power, *np.meshgrid(q_x, q_y, indexing="ij")


@pytest.mark.parametrize(("shape", "pixel_size", "options"), CASES)
@pytest.mark.parametrize("seed", [0, 7])
def test_slope_is_exact_in_fourier_space_and_by_differences(
    shape, pixel_size, options, seed
) -> None:  # type: ignore[no-untyped-def]
    h = origins.self_affine_surface(shape, pixel_size, rms_slope=0.13, seed=seed, **options)
    dx, dy = pixel_size if isinstance(pixel_size, tuple) else (pixel_size, pixel_size)
    power, q_x, q_y = modes(h, dx, dy)
    assert h.shape == shape and abs(h.mean()) < 1e-12 * h.std()
    assert np.sqrt((power * (q_x**2 + q_y**2)).sum()) == pytest.approx(0.13, rel=1e-12)
    moments = origins.spectral_moments(h, pixel_size, detrend="centre", periodic=True)
    # from the heights' own modes, with the transfer factor written as a sinc of each
    assert moments.m0 == pytest.approx(power.sum(), rel=1e-11)
    seen_x, seen_y = q_x * np.sinc(q_x * dx / (2 * np.pi)), q_y * np.sinc(q_y * dy / (2 * np.pi))
    assert moments.m2 == pytest.approx(0.5 * (power * (seen_x**2 + seen_y**2)).sum(), rel=1e-11)
    assert moments.m4 == pytest.approx(0.5 * (power * (seen_x**4 + seen_y**4)).sum(), rel=1e-11)


def test_spectrum_is_flat_then_a_power_then_nothing() -> None:
    n, hurst, longest, shortest = 128, 0.7, 40.0, 5.0
    h = origins.self_affine_surface(
        (n, n), 1.0, hurst=hurst, rms_slope=0.2, seed=3, long_cutoff=longest, short_cutoff=shortest
    )
    power, q_x, q_y = modes(h, 1.0, 1.0)
    q = np.hypot(q_x, q_y)
    low, high = 2 * np.pi / longest, 2 * np.pi / shortest
    shape = np.where((q > 0) & (q <= high), np.maximum(q, low) ** (-2 - 2 * hurst), 0.0)
    constant = 0.2**2 / (shape * q**2).sum()
    assert np.abs(power - constant * shape).max() < 1e-12 * power.max()


def test_seed_decides_the_phases_alone() -> None:
    options = {"hurst": 0.8, "rms_slope": 0.1}
    one, same, other = (
        origins.self_affine_surface((32, 32), 1.0, seed=s, **options) for s in (1, 1, 2)
    )
    assert (one == same).all() and not np.allclose(one, other)
    assert np.allclose(np.abs(np.fft.fft2(one)), np.abs(np.fft.fft2(other)), rtol=1e-10, atol=1e-10)
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.8
