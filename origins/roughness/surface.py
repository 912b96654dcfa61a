"""Heights of a surface in metres on a grid of pixels: measured, NaN where missing, trend removed; or self-affine."""

import math
import os
from dataclasses import dataclass

import numpy as np

from origins.errors import between, check_seed, one_of, pair, positive, refuse, whole
from origins.thresholds.law import Array

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "nm": 1e-9, "pm": 1e-12}
METRES |= dict.fromkeys(("\u00b5m", "\u03bcm", "um"), 1e-6)
METRES |= dict.fromkeys(("\u00c5", "\u212b", "A"), 1e-10)


@dataclass(frozen=True)
class Topography:
    """Heights of shape (n_x, n_y) and pixel sizes (dx, dy), all in metres; NaN where a point is missing."""

    heights: Array
    pixel_size: tuple[float, float]


def as_topography(heights: object, pixel_size: object = None) -> Topography:
    """`heights` as a Topography in metres.

    heights : metres, array of shape (n_x, n_y), NaN or masked where missing; or a SurfaceTopography topography, an
        object with .heights(), .pixel_size and .unit, converted by its unit.
    pixel_size : distances between points, one number or (dx, dy), in metres; left out for an object, which has them.
    Raises InputError for line scans, absent or unknown units, infinite heights and pixel sizes not above zero.
    """
    if isinstance(heights, Topography):
        return heights
    values, scale = heights, 1.0
    if callable(getattr(heights, "heights", None)):
        if pixel_size is not None:
            refuse("pixel_size", pixel_size, "the topography object has its own; leave it out")
        if (unit := getattr(heights, "unit", None)) not in METRES:
            refuse("heights.unit", unit, "must be one unit of length; open the scan with unit='nm'")
        if getattr(heights, "physical_sizes", True) is not None:
            pixel_size = getattr(heights, "pixel_size", None)
        values, scale = heights.heights(), METRES[unit]  # type: ignore[attr-defined]
    if pixel_size is None:
        refuse("pixel_size", None, "give (dx, dy) in metres, or open the scan with physical_sizes")
    dx, dy = _pixel_sizes(pixel_size)
    try:
        grid: Array = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)
    except (TypeError, ValueError):
        refuse("heights", values, "must be a two-dimensional array in metres, or a topography")
    if grid.ndim != 2 or min(grid.shape) < 3:
        refuse("heights", grid, "must be two-dimensional with at least 3 points along each axis")
    if np.isinf(grid).any() or np.isnan(grid).all():
        refuse("heights", grid, "must be finite, or NaN at some points, where none is known")
    return Topography(grid * scale, (dx * scale, dy * scale))


def _pixel_sizes(pixel_size: object) -> tuple[float, float]:
    dx, dy = pair("pixel_size", pixel_size)
    return positive("pixel_size[0]", dx), positive("pixel_size[1]", dy)


def detrended(heights: Array, detrend: str) -> Array:
    """Heights minus their least-squares trend, fitted to the points that are not missing; shape and unit as given.

    "curvature": polynomial of second order with the xy term; "tilt": plane; "centre": mean height. Raises InputError
    for any other name and where the surface equals its trend.
    """
    one_of("detrend", detrend, ("curvature", "tilt", "centre"))
    x, y = np.meshgrid(*(np.linspace(-1.0, 1.0, n) for n in heights.shape), indexing="ij")
    count = {"centre": 1, "tilt": 3, "curvature": 6}[detrend]
    terms = np.stack([np.ones_like(x), x, y, x * x, y * y, x * y][:count], axis=-1)
    measured = np.isfinite(heights)
    from_mean = heights - np.nanmean(heights)  # for heights far from zero
    coefficients = np.linalg.lstsq(terms[measured], from_mean[measured], rcond=None)[0]
    rest = from_mean - terms @ coefficients
    if not np.nanstd(rest) > 1e-12 * np.nanmax(np.abs(heights)):  # else it is round-off
        refuse("heights", heights, f"are flat but for the {detrend}: there are no asperities")
    return rest


def self_affine_surface(
    shape: tuple[int, int],
    pixel_size: float | tuple[float, float],
    *,
    hurst: float,
    rms_slope: float,
    seed: int,
    long_cutoff: float | None = None,
    short_cutoff: float | None = None,
) -> Array:
    """Heights of a periodic self-affine surface, in the unit of pixel_size.

    Every Fourier mode has the amplitude of the spectrum and a random phase, so that only the phases depend on
    the seed: the rms slope, from the sum over modes of |a_q|² q², is `rms_slope` exactly. The power spectrum is
    ~ q^(-2-2H) between 2 pi/long_cutoff and 2 pi/short_cutoff, constant below and zero above.

    shape, pixel_size : number of points, at least 4, and their distance along both axes: one number or a pair.
    hurst, rms_slope : the Hurst exponent H, 0 to 1; root mean square slope of the surface, above zero.
    seed : of the phases, at least 0.
    long_cutoff, short_cutoff : wavelengths; left out, the extreme ones that the grid resolves in every direction.

    Returns heights of `shape`, with mean zero. Raises InputError for values outside these, for a short_cutoff below two
    pixels, where no mode remains, and for a shape that needs, at 40 bytes a point, more than the machine's memory.
    """
    n_x, n_y = (whole("shape", number, 4) for number in pair("shape", shape))
    needed = 40 * n_x * n_y  # bytes; 36 a point were measured
    pages = ("SC_PHYS_PAGES", "SC_PAGE_SIZE")
    total = math.prod(map(os.sysconf, pages)) if hasattr(os, "sysconf") else np.inf
    if needed > total:
        hint = f"needs {min(needed, 10**300) / 1e9:.3g} GB, 40 bytes a point, and this machine has {total / 1e9:.3g} GB"
        refuse("shape", (n_x, n_y), f"{hint}; take a smaller one, such as [4096, 4096]")
    dx, dy = _pixel_sizes(pixel_size)
    hurst = between("hurst", hurst, 0.0, 1.0, "it is the Hurst exponent")
    rms_slope = between("rms_slope", rms_slope, 1e-20, 1e20, "it is metres per metre")
    least, box = 2.0 * max(dx, dy), max(n_x * dx, n_y * dy)
    shortest = least if short_cutoff is None else positive("short_cutoff", short_cutoff)
    longest = box if long_cutoff is None else positive("long_cutoff", long_cutoff)
    if not least <= shortest <= longest:
        hint = f"must be at least two pixels, {least:g}, and at most long_cutoff, {longest:g}"
        refuse("short_cutoff", shortest, hint)
    q_x = 2.0 * np.pi * np.fft.fftfreq(n_x, dx)
    q_y = 2.0 * np.pi * np.fft.rfftfreq(n_y, dy)
    q = np.hypot(q_x[:, None], q_y[None, :])
    kept = (q > 0.0) & (q <= 2.0 * np.pi / shortest * (1.0 + 1e-12))
    # a mode at half the sampling rate has no derivative on the grid
    kept[n_x // 2, :] &= n_x % 2 == 1
    kept[:, n_y // 2] &= n_y % 2 == 1
    if not kept.any():
        refuse("short_cutoff", shortest, "no mode of the grid is longer; the surface would be flat")
    # in units of the roll-off, so that the power does not overflow in any unit of length
    relative = np.maximum(q * min(longest, box) / (2.0 * np.pi), 1.0)
    amplitude = np.where(kept, relative ** (-1.0 - hurst), 0.0)
    count = np.where(q_y == 0.0, 1.0, 2.0)  # a mode of the half plane counts for its conjugate, too
    amplitude *= rms_slope / np.sqrt((amplitude**2 * q**2 * count).sum())
    generator = np.random.Generator(np.random.Philox(key=check_seed(seed)))
    noise = np.fft.rfft2(generator.standard_normal((n_x, n_y)))
    return np.fft.irfft2(amplitude * noise / np.abs(noise), s=(n_x, n_y)) * (n_x * n_y)
