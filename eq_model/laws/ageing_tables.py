"""Table of the drift of a threshold y towards a final law P_cf that is not normal.

The drift is (d ln P_cf/dw) dw/dy with w = ln(y - a), or ln[(y - a)/(b - y)] where the law ends at b: as a function of
w, ln P_cf is linear at an end of the law where P_cf is a power, and in a tail that falls as a power.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from origins import InputError, Thresholds

Array = npt.NDArray[np.float64]

_NODES = 4097
_RARE = 1e-14  # tail probability of either law at which the table ends
_NEAREST = 1e-5  # distance of the table from an end of the law, over the width of its middle half
_NEGLIGIBLE = 0.02  # a power of the density at an end that counts as 0


class DriftTable(NamedTuple):
    """d ln P_cf/dw at equal steps of w, with lengths in whole units.

    low, high : ends of the final law, the upper one may be inf; near, far : the table's range of
    thresholds (units).
    """

    low: float
    high: float
    near: float
    far: float
    first: float
    step: float
    values: Array


NO_DRIFT = DriftTable(0.0, np.inf, 0.0, np.inf, 0.0, 1.0, np.zeros(2))


def drift_table(final: Thresholds, fresh: Thresholds, unit: float) -> DriftTable:
    """The table, in units of a length, for thresholds of `fresh` that diffuse towards `final`.

    Raises InputError for a final law whose density diverges at a wall.
    """
    low, high = final.support()
    width = float(final.isf(0.25) - final.ppf(0.25))
    near = min(float(final.ppf(_RARE)), float(fresh.ppf(_RARE)))
    far = max(float(final.isf(_RARE)), float(fresh.isf(_RARE)))
    near, far = max(near, low + _NEAREST * width), min(far, high - _NEAREST * width)
    edges = np.array([near, far])
    first, last = np.log((edges - low) / (high - edges) if high < np.inf else edges - low)
    w = np.linspace(first, last, _NODES)
    y = low + np.exp(w)
    if high < np.inf:  # computed from the closer end, where no digits are lost then
        below, above = (high - low) / (1.0 + np.exp(-w)), (high - low) / (1.0 + np.exp(w))
        y = np.where(below <= above, low + below, high - above)
    values = CubicSpline(w, final.logpdf(y))(w, 1)
    for end, power in ((low, values[0]), (high, -values[-1])):
        if np.isfinite(end) and end > 0.0 and power < -_NEGLIGIBLE:
            raise InputError(
                f"ageing: the density of the final law diverges at {end:g}, and thresholds stick to that end in steps "
                "too short to follow; use a final law with a finite density, or the master equation"
            )
    first -= 0.0 if high < np.inf else np.log(unit)
    step = w[1] - w[0]
    return DriftTable(low / unit, high / unit, near / unit, far / unit, first, step, values)
