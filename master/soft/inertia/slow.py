"""The slow motion of a slider with mass: how it follows its drive where nothing rings.

With y_0 the travel at which F(y_0) + K y_0 is the drive's pull, which grows at the rate r, and S = F' + K,

    y_0' = r/S,    y_0'' = -F'' y_0'^2/S,    y = y_0 - (g y_0' + m y_0'')/S + ...
"""

from typing import NamedTuple

import numpy as np

from master.soft.curve import LoadCurve
from origins.thresholds.law import Array

# Largest relative change of frequency or relaxation in a radian with which a slider follows slowly at all, in a run
# with the tolerance that is asked for; and the power of a run's part of that with which it falls, so that runs do not
# share this end, and what the series leaves out there, which their difference would not show (with 0.05 in all of
# them a slip of 28 thresholds began 1.6e-4 thresholds of the drive late, at 2e-2, 4e-3 and 8e-4 alike).
FASTEST, FALLS_AS = 0.02, 0.43
# Half the distance of two places of a panel by which F'' is compared, and the nearest to its ends, in its widths.
APART, INSIDE = 1e-4, 1e-9
# Largest part by which the lag may change the speed: the motion is not slow above, and the series not told by its
# first terms.
MOST_CHANGE = 0.5


class Slow(NamedTuple):
    """Slow motion on a curve at balances y_0, arrays of shape (n,).

    slope, travel, speed : S, y and y'; inertia : m y_0''
    missed : about the force of the next terms, which are left out; inf where the motion is not slow
    """

    slope: Array
    travel: Array
    speed: Array
    inertia: Array
    missed: Array


def slow_motion(
    curve: LoadCurve, y: Array, rate: float, mass: float, damping: float, fastest: float
) -> Slow:
    """The slow motion at balances y; where the slope is not above 0, or changes faster than by `fastest` in a radian,
    `missed` is inf."""
    slope = curve.load_slope(y)
    good = slope > 0.0
    s = np.where(good, slope, 1.0)
    bend = curve.bend(y)
    speed = rate / s
    faster = -bend * speed**2 / s
    changes = np.abs(bend) * np.abs(speed) * np.sqrt(mass) / s**1.5
    lags = damping * np.abs(bend * speed) / s**2
    missed = 3.0 * (mass * np.abs(faster) * changes + damping * np.abs(speed) * lags)
    missed += mass * np.abs(faster) * lags
    bad = ~good | (changes > fastest) | (lags > fastest)
    travel = y - (damping * speed + mass * faster) / s
    drifting = speed * (1.0 + 2.0 * damping * rate * bend / s**3)
    return Slow(slope, travel, drifting, mass * faster, np.where(bad, np.inf, missed))


def slope_of_speed(curve: LoadCurve, y: Array, rate: float, mass: float, damping: float) -> Array:
    """The slope of the load over which a slider is as fast as this one is: r divided by its speed, shape as y.

    The balance y moves at r/S. The slider lags behind it, and its own speed differs, as the lag changes with S:

        dX/dt = r/S [1 + 2 g r F''/S^3 + m r^2 (F''' - 4 F''^2/S)/S^4 + ...].
    """
    panel = curve.panel(y)
    begin, width = curve.from_travel[panel], curve.width[panel]
    low = np.maximum(y - APART * width, begin + INSIDE * width)
    high = np.maximum(np.minimum(y + APART * width, begin + width), low + INSIDE * width)
    bend, bends = curve.bend(y), (curve.bend(high) - curve.bend(low)) / (high - low)
    slope = curve.load_slope(y)
    s = np.where(slope > 0.0, slope, np.inf)
    change = 2.0 * damping * rate * bend / s**3
    change += mass * rate**2 * (bends - 4.0 * bend**2 / s) / s**4
    return np.asarray(slope / (1.0 + np.clip(change, -MOST_CHANGE, MOST_CHANGE)))
