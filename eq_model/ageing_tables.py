"""How a threshold drifts towards a law that is not Gaussian, and how far it may diffuse in one step: tables.

Over w = ln(y - a), or ln[(y - a)/(b - y)] where the final law ends at b, any power at an end a of the law is a straight
line of ln P_cf, and a tail that falls as a power too: the drift is (d ln P_cf/dw) dw/dy.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from origins import InputError, Thresholds

Array = npt.NDArray[np.float64]

_NODES = 4097
_RARE = 1e-14
_RELAXES = (
    0.02  # in one step, of the time in which two thresholds side by side come closer, or part
)
_OF_THE_WAY = 0.25  # to an end at which the drift has a pole, a step's standard deviation
_POLE = 0.25  # of a power there that is felt
_SURROUNDINGS = 3.0  # standard deviations within which the drift is to change as little
_BETWEEN_WALLS = 0.125
# of the width of the final law's middle half: the least standard deviation of a step, at x = 0, where stretches may be
# too, and at a wall, which returns what comes; and how close to an end the table is
_LEAST, _AT_A_WALL, _NEAREST = 1e-3, 3e-3, 1e-5
_NEGLIGIBLE = 0.02  # a power that tells nothing of an end
_TYPICAL = np.linspace(0.05, 0.95, 19)


@dataclass(frozen=True)
class DriftTable:
    """Of d ln P_cf/dy and of the standard deviation of a step, over w.

    ends : support of the final law, the upper end may be inf; reach : thresholds between which the table is (lengths).
    first, step : of w, that of lengths if the law has no upper end.
    values, slopes : shape (n,), d ln P_cf/dw and its slope.
    spreads : shape (n,), standard deviation of a step (lengths); typical : of the final law's thresholds.
    """

    ends: tuple[float, float]
    reach: tuple[float, float]
    first: float
    step: float
    values: Array
    slopes: Array
    spreads: Array
    typical: float


def drift_table(final: Thresholds, fresh: Thresholds) -> DriftTable:
    """The table for thresholds of `fresh` that diffuse towards `final`.

    Raises InputError for a final law whose density diverges at a wall.
    """
    low, high = final.support()
    width = float(final.isf(0.25) - final.ppf(0.25))
    near = min(float(final.ppf(_RARE)), float(fresh.ppf(_RARE)))
    far = max(float(final.isf(_RARE)), float(fresh.isf(_RARE)))
    near = max(near, low + _NEAREST * width)
    far = min(far, high - _NEAREST * width)
    ended = np.isfinite(high)

    def place(y: Array | float) -> Array:
        return np.asarray(np.log((y - low) / (high - y)) if ended else np.log(y - low))

    w = np.linspace(float(place(near)), float(place(far)), _NODES)
    # from the end that is closer, so that no digits are lost there
    below, above = np.exp(w), np.full(w.size, np.inf)
    if ended:
        below, above = (high - low) / (1.0 + np.exp(-w)), (high - low) / (1.0 + np.exp(w))
    y = np.where(below <= above, low + below, high - above) if ended else low + below
    logarithm = CubicSpline(w, final.logpdf(y))
    values, slopes = logarithm(w, 1), logarithm(w, 2)
    steep = 1.0 / below + 1.0 / above
    change = slopes * steep**2 + values * (1.0 / above**2 - 1.0 / below**2)
    _check_ends(final, values, low, high)
    with np.errstate(divide="ignore"):
        spreads = np.sqrt(2.0 * _RELAXES / np.abs(change))
        of_the_way = _OF_THE_WAY / np.minimum(np.abs(values) / _POLE, 1.0)
    spreads = np.minimum(spreads, of_the_way * np.minimum(below, above))
    if ended:
        spreads = np.minimum(spreads, _BETWEEN_WALLS * (high - low))
    # no more than a share of the way to where the drift changes faster
    spreads = np.minimum.accumulate(spreads - y / _SURROUNDINGS) + y / _SURROUNDINGS
    spreads = np.minimum.accumulate((spreads + y / _SURROUNDINGS)[::-1])[::-1] - y / _SURROUNDINGS
    spreads = np.maximum(
        spreads, width * np.where((below < above) & (low == 0.0), _LEAST, _AT_A_WALL)
    )
    typical = float(np.median(np.interp(final.ppf(_TYPICAL), y, spreads)))
    return DriftTable((low, high), (near, far), w[0], w[1] - w[0], values, slopes, spreads, typical)


def _check_ends(final: Thresholds, values: Array, low: float, high: float) -> None:
    """Where the density diverges, the drift leads to the end and has a pole there."""
    powers = (low, values[0]), (high, -values[-1])
    for end, power in powers:
        if np.isfinite(end) and end > 0.0 and power < -_NEGLIGIBLE:
            raise InputError(
                f"ageing: the density of the final law diverges at {end:g}, and thresholds stick to that end in steps "
                "too short to follow; use a final law with a finite density, or the master equation"
            )
