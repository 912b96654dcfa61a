"""Whether the drops of a slider's slips fade, and where they lead to."""

import numpy as np

from origins.thresholds.law import Array

# Fewest slips that have a trend, and relative change of the drop from one slip to the next below
# which drops do not fade.
FEWEST, STEADY = 4, 1e-3


def closes_in(drops: Array) -> bool:
    """Whether late |drops| go up and down, each between the two before it, as a short slip follows a long one."""
    late = drops[-FEWEST:]
    low, high = np.minimum(late[:-2], late[1:-1]), np.maximum(late[:-2], late[1:-1])
    return bool(((low < late[2:]) & (late[2:] < high)).all())


def limit_of(drops: Array) -> float:
    """What the last three |drops| lead to if each change is the same part of the one before (Aitken); 0 where changes
    do not get smaller."""
    first, second = -np.diff(drops[-3:])
    return float(drops[-1] - second**2 / (first - second)) if first > second > 0.0 else 0.0


def trend_of(drop: Array) -> float | None:
    """Relative change of |drop| a slip, fitted over the later half; None where not monotone."""
    late = np.abs(drop[drop.size // 2 :])
    if drop.size < FEWEST or not (late > 0.0).all():
        return None
    change = np.diff(np.log(late))
    if change.max() > STEADY and change.min() < -STEADY:
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
