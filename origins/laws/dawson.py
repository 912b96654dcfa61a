"""G(y), the integral of exp(t²) from 0 to y, in logarithms, and its inverse: thermal breaking of soft contacts."""

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

Array = npt.NDArray[np.float64]

_STEPS = 5  # Newton steps from a start within 1.3 of y; each squares the error
_LEAST = 1e-290  # y below which ln G = ln y to the last bit; its square underflows


def log_growth(y: npt.ArrayLike) -> Array:
    """ln G(y) = y² + ln D(y) for y >= 0, D being Dawson's integral; -inf at 0. Finite where exp(y²) overflows."""
    y = np.asarray(y, dtype=float)
    with np.errstate(divide="ignore", over="ignore"):
        return y * y + np.log(dawsn(y))


def inverse_log_growth(level: npt.ArrayLike) -> Array:
    """The y >= 0 at which ln G(y) = level, for any level; shape as level. To a relative 1e-14."""
    level = np.asarray(level, dtype=float)
    # levels outside these bounds are handled in the last line
    goal = np.clip(level, np.log(_LEAST), 1e300)
    # ln G is convex in ln y, so that Newton's steps from above never overshoot;
    # G(y) > y below, and G(y) > exp(y²)/(2y + 1) above
    rough = np.sqrt(np.maximum(goal, 0.0) + 1.0)
    with np.errstate(over="ignore"):
        low = np.exp(goal)
    y = np.minimum(low, np.sqrt(np.maximum(goal, 0.0) + np.log(2.0 * rough + 3.0)))
    for _ in range(_STEPS):
        growth = dawsn(y)
        y = y * np.exp(-(y * y + np.log(growth) - goal) * growth / y)
    return np.where(
        level == goal, y, np.where(level < 0.0, np.exp(np.minimum(level, 0.0)), np.inf)
    )[()]
