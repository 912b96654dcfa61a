"""A measured surface: heights in metres on a grid of pixels, missing points as NaN, trend removed."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import one_of, positive, refuse

Array = npt.NDArray[np.float64]

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "nm": 1e-9, "pm": 1e-12}
METRES |= dict.fromkeys(("\u00b5m", "\u03bcm", "um"), 1e-6)
METRES |= dict.fromkeys(("\u00c5", "\u212b", "A"), 1e-10)
DETRENDS = ("curvature", "tilt", "centre")
_ROUND_OFF = (
    1e-12  # of the largest height: a smaller standard deviation after detrending is round-off
)


@dataclass(frozen=True)
class Topography:
    """Heights of shape (n_x, n_y) and pixel sizes (dx, dy), all in metres; NaN where a point is missing."""

    heights: Array
    pixel_size: tuple[float, float]

    @property
    def missing_fraction(self) -> float:
        """Fraction of the points that are missing."""
        return float(np.isnan(self.heights).mean())


def as_topography(heights: object, pixel_size: object = None) -> Topography:
    """`heights` as a Topography in metres.

    Parameters
    ----------
    heights : array of shape (n_x, n_y), or an object with .heights(), .pixel_size and .unit
        Heights in metres, NaN or masked where missing; or a SurfaceTopography topography, converted by its unit.
    pixel_size : float or (dx, dy)
        Distances between points along the first and the second axis, in metres; left out for an object, which has them.

    Raises InputError for line scans, absent or unknown units, infinite heights and pixel sizes not above zero.
    """
    if isinstance(heights, Topography):
        return heights
    if callable(getattr(heights, "heights", None)):
        if pixel_size is not None:
            refuse("pixel_size", pixel_size, "the topography object has its own; leave it out")
        unit = getattr(heights, "unit", None)
        if unit not in METRES:
            rule = "lengths need one unit, such as 'nm'; open the scan with unit = 'nm', or pass heights and pixel_size"
            refuse("heights.unit", unit, f"{rule} in metres")
        if getattr(heights, "physical_sizes", True) is None or not hasattr(heights, "pixel_size"):
            refuse("heights.pixel_size", None, "open the scan with its physical_sizes given")
        sizes = np.asarray(heights.pixel_size)
        if sizes.shape != (2,):
            refuse("heights.pixel_size", sizes, "must be a pair (dx, dy)")
        scale = METRES[unit]
        values = _height_array(heights.heights()) * scale  # type: ignore[attr-defined]
        return Topography(values, pixel_sizes(sizes * scale, "heights.pixel_size"))
    values = _height_array(heights)
    if pixel_size is None:
        rule = "heights without it have no slope; write pixel_size=(dx, dy) in metres"
        refuse("pixel_size", pixel_size, rule)
    return Topography(values, pixel_sizes(pixel_size))


def pixel_sizes(pixel_size: object, name: str = "pixel_size") -> tuple[float, float]:
    """`pixel_size`, one number or a pair, as (dx, dy), both above zero."""
    if isinstance(pixel_size, tuple | list | np.ndarray):
        if len(pixel_size) != 2:
            refuse(name, pixel_size, "must be one number or a pair (dx, dy)")
        return positive(f"{name}[0]", pixel_size[0]), positive(f"{name}[1]", pixel_size[1])
    size = positive(name, pixel_size)
    return size, size


def detrended(surface: Topography, detrend: str = "curvature") -> Topography:
    """The surface minus its least-squares trend, fitted to the points that are not missing.

    "curvature": polynomial of second order with the xy term; "tilt": plane; "centre": mean height.

    Raises InputError for any other name and where the surface equals its trend.
    """
    one_of("detrend", detrend, DETRENDS)
    heights = surface.heights
    x, y = (np.linspace(-1.0, 1.0, n) for n in heights.shape)
    x, y = np.meshgrid(x, y, indexing="ij")
    terms = [np.ones_like(x)]
    if detrend != "centre":
        terms += [x, y]
    if detrend == "curvature":
        terms += [x * x, y * y, x * y]
    there = np.isfinite(heights)
    # fitted about their mean, in units of their range, for heights in any unit and far from zero
    known = heights[there]
    middle, span = float(known.mean()), float(np.ptp(known))
    basis = np.stack([term[there] for term in terms], axis=1)
    coefficients = np.linalg.lstsq(basis, (known - middle) / (span or 1.0), rcond=None)[0]
    left = heights - middle - span * np.tensordot(coefficients, np.stack(terms), axes=1)
    if not float(np.nanstd(left)) > _ROUND_OFF * float(np.abs(known).max()):
        rule = f"nothing is left after removing the {detrend}: a flat surface has no asperities"
        refuse("heights", heights, rule)
    return Topography(left, surface.pixel_size)


def _height_array(heights: object) -> Array:
    """`heights` as a grid of at least 3 by 3 points, NaN where masked; InputError where they are no such grid."""
    try:
        values: Array = np.ma.filled(np.ma.asarray(heights, dtype=float), np.nan)
    except (TypeError, ValueError):
        such = "SurfaceTopography.read_topography(file)"
        refuse("heights", heights, f"must be a two-dimensional array in metres, or {such}")
    if values.ndim != 2 or min(values.shape) < 3:
        refuse("heights", values, "must be two-dimensional with at least 3 points along each axis")
    infinite = np.argwhere(np.isinf(values))
    if infinite.size:
        i, j = infinite[0]
        refuse(f"heights[{i}, {j}]", values[i, j], "must be finite, or NaN where none is known")
    if not np.isfinite(values).any():
        refuse("heights", values, "every point is missing; a surface needs heights")
    return values
