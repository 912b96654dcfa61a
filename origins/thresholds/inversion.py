"""Quantiles of a law without a closed inverse, by Newton steps within a bracket."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_STEPS = 400
# Newton's method squares the error: a step from within _MISS is the last, unless it is long, across a flat piece
_MISS, _STEP = 1e-9, 1e-8
_LAST_BIT = 4e-16


def invert_hazard(thresholds: Any, hazard: Array, left: Array, right: Array, guess: Array) -> Array:
    """Thresholds x in [left, right] with -log sf(x) = hazard; all arrays of one shape (n,).

    Newton's step is taken for log hazard against log distance from the support's lower end, where every power
    and every Weibull law is a straight line. It is replaced by a halving where it leaves the bracket or
    converges too slowly. Where P_c has a gap the result is the left end of the gap, as in scipy.
    """
    origin, bends = thresholds.support()[0], np.sort(thresholds.breakpoints)
    out, place = np.array(right, dtype=float), np.arange(right.size)
    goal, low, high = hazard, left, right
    x = np.where((guess > low) & (guess < high), guess, between(low, high))
    for step in range(_STEPS):
        # where no float lies between the two ends, the upper one is the first to reach the goal
        inside = (x > low) & (x < high)
        out[place[~inside]] = high[~inside]
        place, (goal, low, high, x) = place[inside], (part[inside] for part in (goal, low, high, x))
        if not place.size:
            return out
        log_survival = thresholds._logsf(x)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            miss = np.log(-log_survival / goal)
            slope = (x - origin) * np.exp(thresholds._logpdf(x) - log_survival) / -log_survival
            newton = origin + (x - origin) * np.exp(-miss / slope)
        short = -log_survival < goal
        low, high = np.where(short, x, low), np.where(short, high, x)
        distance, gap = np.abs(newton - x), np.abs(miss)
        # the slope on one side of a bend is not that on the other
        across = np.searchsorted(bends, x) != np.searchsorted(bends, newton)
        settled = (gap < _MISS) & (distance < _STEP * x) & ~across
        settled |= (gap < 1e-3) & (distance <= _LAST_BIT * x)
        out[place[settled]] = np.clip(newton, low, high)[settled]
        bad = ~((newton > low) & (newton < high)) | (step % 4 == 3) & (step > 8)
        x = np.where(bad, between(low, high), newton)
        place, (goal, low, high, x) = (
            place[~settled],
            (part[~settled] for part in (goal, low, high, x)),
        )
    out[place] = x
    return out


def between(left: Array, right: Array) -> Array:
    """Arithmetic mean, geometric where the two differ by more than a factor 4, so that tiny roots are found fast."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        wide = (left > 0.0) & (right > 4.0 * left)
        floor = np.where((left == 0.0) & (right > 1e-300), right * 2.0**-16, 0.0)
        middle = np.where(wide, np.sqrt(left) * np.sqrt(right), left + 0.5 * (right - left))
        return np.where(floor > 0.0, floor, middle)
