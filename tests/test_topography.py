"""Heights in metres, trends, missing points, and the spectral moments by differences."""

import numpy as np
import pytest

import origins
from origins.roughness.topography import Topography, as_topography, detrended

RNG = np.random.default_rng(20100807)


class Scan:
    """What a topography object must offer."""

    def __init__(self, heights: np.ndarray, pixel_size: tuple, unit: object) -> None:
        self._heights, self.pixel_size, self.unit = heights, pixel_size, unit

    def heights(self) -> np.ndarray:
        return self._heights


def by_loops(h: np.ndarray, dx: float, dy: float, step: int) -> tuple[float, float, float, float]:
    """Mean squares of the two slopes and the two curvatures, point by point."""
    slopes, curvatures = [], []
    n, m = h.shape
    for i in range(n):
        for j in range(m):
            if i + step < n and j + step < m:
                slopes.append(
                    (
                        (h[i + step, j] - h[i, j]) / (step * dx),
                        (h[i, j + step] - h[i, j]) / (step * dy),
                    )
                )
            if step <= i < n - step and step <= j < m - step:
                curvatures.append(
                    (
                        (h[i + step, j] - 2 * h[i, j] + h[i - step, j]) / (step * dx) ** 2,
                        (h[i, j + step] - 2 * h[i, j] + h[i, j - step]) / (step * dy) ** 2,
                    )
                )
    slopes = [pair for pair in slopes if np.isfinite(pair).all()]
    curvatures = [pair for pair in curvatures if np.isfinite(pair).all()]
    return (*np.mean(np.square(slopes), axis=0), *np.mean(np.square(curvatures), axis=0))


@pytest.mark.parametrize(("dx", "dy"), [(1e-7, 1e-7), (1e-7, 3.7e-7)])
def test_a_periodic_sine_has_its_exact_moments(dx: float, dy: float) -> None:
    amplitude, n, m = 3e-8, 48, 60
    phase_x, phase_y = 2 * np.pi / 12, 2 * np.pi / 15
    i, j = np.arange(n)[:, None], np.arange(m)[None, :]
    h = amplitude * (np.sin(phase_x * i) + 0.5 * np.cos(phase_y * j))
    moments = origins.spectral_moments(h, (dx, dy), detrend="centre", periodic=True)
    slope_x, slope_y = 2 * np.sin(phase_x / 2) / dx, 2 * np.sin(phase_y / 2) / dy
    assert moments.m0 == pytest.approx(amplitude**2 * (0.5 + 0.125), rel=1e-13)
    assert moments.m2_axes == pytest.approx(
        (amplitude**2 / 2 * slope_x**2, amplitude**2 / 8 * slope_y**2), rel=1e-12
    )
    assert moments.m4_axes == pytest.approx(
        (amplitude**2 / 2 * slope_x**4, amplitude**2 / 8 * slope_y**4), rel=1e-12
    )
    assert moments.rms_slope == pytest.approx(np.sqrt(sum(moments.m2_axes)), rel=1e-14)


@pytest.mark.parametrize("step", [1, 2, 3])
@pytest.mark.parametrize("missing", [0.0, 0.05])
def test_moments_equal_plain_loops(step: int, missing: float) -> None:
    h = RNG.standard_normal((17, 23)).cumsum(axis=0).cumsum(axis=1)
    h[RNG.random(h.shape) < missing] = np.nan
    moments = origins.spectral_moments(h, (0.2, 0.5), detrend="tilt", step=step)
    level = detrended(Topography(h, (0.2, 0.5)), "tilt").heights
    assert (*moments.m2_axes, *moments.m4_axes) == pytest.approx(
        by_loops(level, 0.2, 0.5, step), rel=1e-12
    )
    assert moments.m0 == pytest.approx(np.nanmean(level**2), rel=1e-13)
    assert moments.missing_fraction == np.isnan(h).mean()
    assert moments.pixel_size == (0.2 * step, 0.5 * step)


@pytest.mark.parametrize(("detrend", "terms"), [("centre", 1), ("tilt", 3), ("curvature", 6)])
@pytest.mark.parametrize("missing", [0.0, 0.1])
def test_detrending_removes_just_its_polynomial(detrend: str, terms: int, missing: float) -> None:
    h = RNG.standard_normal((20, 31)) * 1e-8
    h[RNG.random(h.shape) < missing] = np.nan
    x, y = np.meshgrid(np.arange(20) * 1e-6, np.arange(31) * 2e-6, indexing="ij")
    polynomial = [3e-6, 0.02, -0.01, 900.0, -500.0, 700.0]
    basis = [np.ones_like(x), x, y, x * x, y * y, x * y]
    trend = sum(c * b for c, b in zip(polynomial[:terms], basis[:terms], strict=True))
    plain = detrended(Topography(h, (1e-6, 2e-6)), detrend).heights
    bent = detrended(Topography(h + trend, (1e-6, 2e-6)), detrend).heights
    there = np.isfinite(h)
    assert np.abs(bent - plain)[there].max() < 1e-13 * np.abs(trend).max()
    assert (np.isnan(bent) == ~there).all()
    # the residue is orthogonal to every term removed
    for b in basis[:terms]:
        assert abs((plain * b)[there].sum()) < 1e-12 * (np.abs(plain) * np.abs(b))[there].sum()


def test_summits_of_a_gaussian_surface_are_those_the_moments_say() -> None:
    # Nayak's results are exact for Gaussian surfaces; here some 5,000 summits are looked up one by one
    counts, heights, curvatures, predicted = [], [], [], []
    for seed in range(6):
        h = origins.self_affine_surface(
            (640, 400),
            (1.0, 1.3),
            hurst=0.8,
            rms_slope=0.1,
            seed=seed,
            long_cutoff=60.0,
            short_cutoff=10.0,
        )
        m = origins.spectral_moments(h, (1.0, 1.3), detrend="centre", periodic=True)
        neighbours = [
            np.roll(h, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)
        ]
        top = np.all([h > other for other in neighbours], axis=0)
        bend = -(np.roll(h, 1, 0) - 2 * h + np.roll(h, -1, 0)) / 2 - (
            np.roll(h, 1, 1) - 2 * h + np.roll(h, -1, 1)
        ) / (2 * 1.3**2)
        counts.append(top.sum())
        heights.append(h[top])
        curvatures.append(bend[top])
        predicted.append(
            (m.summit_density * h.size * 1.3, m.summit_offset, m.summit_std, 1.0 / m.summit_radius)
        )
    number, offset, std, curvature = np.mean(predicted, axis=0)
    found = np.concatenate(heights)
    assert found.size > 4000
    assert np.mean(counts) == pytest.approx(number, rel=0.04)
    assert found.mean() == pytest.approx(offset, rel=0.02)
    assert found.std() == pytest.approx(std, rel=0.02)
    assert np.concatenate(curvatures).mean() == pytest.approx(curvature, rel=0.02)


def test_objects_are_converted_by_their_unit_and_masks_are_missing_points() -> None:
    h = RNG.standard_normal((12, 15))
    plain = as_topography(h * 1e-9, (5e-9, 7e-9))
    for unit, factor in (
        ("nm", 1.0),
        ("m", 1e-9),
        ("µm", 1e-3),
        ("μm", 1e-3),
        ("Å", 10.0),
        ("mm", 1e-6),
    ):
        scan = as_topography(Scan(h * factor, (5.0 * factor, 7.0 * factor), unit))
        assert np.allclose(scan.heights, plain.heights, rtol=1e-13, atol=0.0)
        assert scan.pixel_size == pytest.approx(plain.pixel_size, rel=1e-13)
    mask = RNG.random(h.shape) < 0.2
    masked = as_topography(np.ma.array(h, mask=mask), 1.0)
    assert (np.isnan(masked.heights) == mask).all() and masked.missing_fraction == mask.mean()
