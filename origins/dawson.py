"""G(y), the integral of exp(t²) from 0 to y, in logarithms, and its inverse: thermal breaking of soft contacts."""

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

Array = npt.NDArray[np.float64]

_STEPS = 20  # five do from the first guess
_LAST = 1e-8  # Newton squares what is missing: a step from this close is the last


def log_growth(y: npt.ArrayLike) -> Array:
    """ln G(y) = y² + ln D(y) for y >= 0, D being Dawson's integral; -inf at 0. Finite where exp(y²) overflows."""
    y = np.asarray(y, dtype=float)
    with np.errstate(divide="ignore", over="ignore"):
        return y * y + np.log(dawsn(y))


def inverse_log_growth(level: npt.ArrayLike) -> Array:
    """The y >= 0 at which ln G(y) = level, for any level; shape as level.

    ln G is convex in ln y, so that Newton's steps from above never overshoot.
    """
    level = np.asarray(level, dtype=float)
    out = np.where(level > 0.0, np.inf, 0.0)
    place = np.flatnonzero(np.isfinite(level))
    goal = level.ravel()[place]
    with np.errstate(over="ignore"):
        # G(y) > y below, and G(y) > exp(y²)/(2y + 1) above
        rough = np.sqrt(np.maximum(goal, 0.0) + 1.0)
        y = np.minimum(np.exp(goal), np.sqrt(np.maximum(goal, 0.0) + np.log(2.0 * rough + 3.0)))
    flat = out.reshape(-1)
    for _ in range(_STEPS):
        # what underflows is where the logarithm of y is below that of any float: y = exp(level) = 0
        alive = y > 0.0
        flat[place[~alive]] = 0.0
        place, goal, y = place[alive], goal[alive], y[alive]
        if not place.size:
            break
        slope = y / dawsn(y)
        step = (log_growth(y) - goal) / slope
        y = y * np.exp(-step)
        settled = np.abs(step) < _LAST
        flat[place] = y
        place, goal, y = place[~settled], goal[~settled], y[~settled]
    return flat.reshape(level.shape)[()]
