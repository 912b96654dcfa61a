"""The slow motion of a slider with mass: how it follows its drive where nothing rings.

With y_0 the travel at which F(y_0) + K y_0 is the drive's pull, which grows at the rate r, and S = F' + K,

    y_0' = r/S,    y_0'' = -F'' y_0'^2/S,    y = y_0 - (g y_0' + m y_0'')/S + ...
"""

from typing import NamedTuple

import numpy as np

from master.soft.curve import LoadCurve
from origins.thresholds.law import Array

# Largest relative change of frequency or relaxation in a radian with which a slider follows slowly at all.
FASTEST = 0.1


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


def slow_motion(curve: LoadCurve, y: Array, rate: float, mass: float, damping: float) -> Slow:
    """The slow motion at balances y; where the slope is not above 0, or it changes too fast, `missed` is inf."""
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
    bad = ~good | (changes > FASTEST) | (lags > FASTEST)
    travel = y - (damping * speed + mass * faster) / s
    drifting = speed * (1.0 + 2.0 * damping * rate * bend / s**3)
    return Slow(slope, travel, drifting, mass * faster, np.where(bad, np.inf, missed))
