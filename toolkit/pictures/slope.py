"""The slope of F_k with the logarithm of the speed, in the picture of a sweep over speeds."""

from typing import Any

import numpy as np

from master.rate_state.result import CONSTANT
from master.rate_state.speeds import constant_between
from origins.thresholds.law import Array

# last over first of the speeds along which F_k is a straight line of ln v; along fewer its slope says little
_STRAIGHT = 100.0


def draw_slope(axes: Any, speed: Array, force: Array, error: Array, color: str) -> float:
    """dF_k/d ln v where it is steepest, drawn as a pale line where it is constant within CONSTANT. It is 0 and nothing
    is drawn where these speeds are fewer than _STRAIGHT asks for, or the errors of F_k do not tell it."""
    if speed.size < 4 or not (speed[0] > 0.0 and (np.diff(speed) > 0.0).all()):
        return 0.0
    log, steps = np.log(speed), np.diff(np.log(speed))
    slopes = np.gradient(force, log)
    if not np.isfinite(slopes).any():
        return 0.0
    steepest = int(np.nanargmax(np.abs(slopes)))
    slope, room = float(slopes[steepest]), CONSTANT * abs(float(slopes[steepest]))
    low, high = constant_between(speed, slopes, steepest, room)
    if high < _STRAIGHT * low or 2.0 * error.max() > room * steps.min():
        return 0.0
    at = np.geomspace(low, high, 50)  # as the axis of F_k may be logarithmic
    line = force[steepest] + slope * np.log(at / speed[steepest])
    axes.plot(at, line, color=color, lw=7.0, alpha=0.25, solid_capstyle="butt", zorder=1)
    return slope
