"""A seeded self-affine surface with an exact rms slope, for use without a scan."""

from __future__ import annotations

import os

import numpy as np

from origins.errors import InputError, between, positive, refuse, whole
from origins.roughness.topography import Array, pixel_sizes

_BYTES = 40  # largest memory per point while a surface is made; 36 were measured
_SLOPES = (1e-20, 1e20)  # least and largest rms slope


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

    Nearest-neighbour differences replace q_x by 2 sin(q_x dx/2)/dx: the mean square slope by periodic differences
    (spectral_moments with periodic=True) is exactly the sum over modes of
    |a_q|² [(2 sin(q_x dx/2)/dx)² + (2 sin(q_y dy/2)/dy)²].

    Parameters
    ----------
    shape : (int, int)
        Number of points along each axis, at least 4.
    pixel_size : float or (dx, dy)
        Distance between points.
    hurst : float
        Hurst exponent H, 0 to 1.
    rms_slope : float
        Root mean square slope of the surface, above zero.
    seed : int
        Seed of the phases, at least 0.
    long_cutoff, short_cutoff : float
        Wavelengths; left out, the longest and the shortest that the grid resolves in every direction.

    Returns
    -------
    heights : array of `shape`, with mean zero

    Raises InputError for values outside these, for a short_cutoff below two pixels, where no mode remains, and for a
    shape that needs, at 40 bytes a point, more than the memory of the machine.
    """
    if not isinstance(shape, tuple | list) or len(shape) != 2:
        refuse("shape", shape, "must be a pair of whole numbers, such as [256, 256]")
    if whole("seed", seed, 0) >= 2**64:
        refuse("seed", seed, "must be below 2**64")
    n_x, n_y = whole("shape[0]", shape[0], 4), whole("shape[1]", shape[1], 4)
    check_memory((n_x, n_y), _BYTES)
    dx, dy = pixel_sizes(pixel_size)
    if not 0.0 < positive("hurst", hurst) <= 1.0:
        refuse("hurst", hurst, "must be above 0 and at most 1")
    rms_slope = between("rms_slope", rms_slope, *_SLOPES, "it is metres per metre")
    least = 2.0 * max(dx, dy)
    shortest = least if short_cutoff is None else positive("short_cutoff", short_cutoff)
    if shortest < least:
        refuse("short_cutoff", short_cutoff, f"must be at least two pixels, {least:g}")
    box = max(n_x * dx, n_y * dy)
    longest = box if long_cutoff is None else positive("long_cutoff", long_cutoff)
    if longest < shortest and long_cutoff is None:
        refuse("short_cutoff", short_cutoff, f"must be at most the surface's length, {box:g}")
    if longest < shortest:
        refuse("long_cutoff", long_cutoff, f"must be at least the short cutoff, {shortest:g}")
    q_x = 2.0 * np.pi * np.fft.fftfreq(n_x, dx)
    q_y = 2.0 * np.pi * np.fft.rfftfreq(n_y, dy)
    q = np.hypot(q_x[:, None], q_y[None, :])
    kept = (q > 0.0) & (q <= 2.0 * np.pi / shortest * (1.0 + 1e-12))
    # a mode at half the sampling rate has no derivative on the grid
    kept[n_x // 2, :] &= n_x % 2 == 1
    kept[:, n_y // 2] &= n_y % 2 == 1
    if not kept.any():
        raise InputError(
            f"short_cutoff = {shortest:g}: no mode of the grid is longer; the surface would be flat"
        )
    # in units of the roll-off, so that the power does not overflow in any unit of length
    relative = np.maximum(q * min(longest, box) / (2.0 * np.pi), 1.0)
    amplitude = np.where(kept, relative ** (-1.0 - hurst), 0.0)
    # each mode of the half plane counts for itself and its conjugate, except those at the plane's edges
    count = np.full(q_y.size, 2.0)
    count[0] = 1.0
    if n_y % 2 == 0:
        count[-1] = 1.0
    amplitude *= rms_slope / np.sqrt((amplitude**2 * q**2 * count).sum())
    generator = np.random.Generator(np.random.Philox(key=seed))
    noise = np.fft.rfft2(generator.standard_normal((n_x, n_y)))
    return np.fft.irfft2(amplitude * noise / np.abs(noise), s=(n_x, n_y)) * (n_x * n_y)


def check_memory(shape: tuple[int, int], bytes_a_point: int) -> None:
    """InputError where `bytes_a_point` on each point of `shape` need more than the memory of the machine."""
    try:
        there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # some systems do not report it
        return
    needed = shape[0] * shape[1] * bytes_a_point
    if needed > there:
        amount = f"{needed / 1e9:.3g}" if needed < 1e300 else "over 1e300"
        rule = f"needs {amount} GB, {bytes_a_point} bytes a point, and this machine has {there / 1e9:.3g} GB"
        refuse("shape", shape, f"{rule}; take a smaller one, such as [4096, 4096]")
