"""Values that samples repeat: exact ones apart from those that are only rounded."""

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

Flags = npt.NDArray[np.bool_]

_SAME = 1e-12  # relative distance of samples that are one value
OFTEN = 10
_STANDS_OUT = 5  # times as often as the values beside it
_ALWAYS_EXACT, _FEW = 3, 8  # values in all
_EVEN = 1e-3  # of the step of a grid


def distinct(ordered: Array, shares: Array) -> tuple[Array, Array, Array]:
    """Sorted values that differ, their shares, and how often each is there, from sorted samples and their shares."""
    first = np.append(0, np.flatnonzero(np.diff(ordered) > _SAME * ordered[1:]) + 1)
    counts = np.diff(np.append(first, ordered.size)).astype(float)
    # the first of each, and the mean of the rest's distances from it: equal values stay what they are
    values, weights = ordered[first], np.add.reduceat(shares, first)
    away = ordered - np.repeat(values, counts.astype(int))
    return values + np.add.reduceat(shares * away, first) / weights, weights, counts


def exact(values: Array, counts: Array) -> Flags:
    """Which of the values (sorted, each there `counts` times) are exact, by the rule that from_samples states."""
    found = np.zeros(values.size, dtype=bool)
    if 1 < values.size <= _FEW and counts.min() >= OFTEN and not (values.size > _ALWAYS_EXACT and _rounded(values)):
        return ~found
    while True:
        rest = np.flatnonzero(~found)
        new = rest[_stand_out(values[rest], counts[rest])]
        if not new.size:
            return found
        found[new] = True


def _rounded(values: Array) -> bool:
    """Whether most values, or their squares (lengths from rounded forces), follow each other at one step."""
    for y in (values, values * values):
        steps = np.diff(y) / np.diff(y).min()
        if (np.abs(steps - np.round(steps)) < _EVEN).all() and np.median(steps) < 1.5:
            return True
    return False


def _stand_out(values: Array, counts: Array) -> Flags:
    """Values there ten times more often than five times what is beside them."""
    if values.size < 2:
        return np.zeros(values.size, dtype=bool)
    window = np.arange(values.size)[:, None] + np.arange(-2, 3)
    there = (window >= 0) & (window < values.size)
    inside, window = there[:, 1:] & there[:, :-1], np.clip(window, 0, values.size - 1)
    beside = [0, 1, 3, 4]
    near = np.where(there, counts[window], np.nan)[:, beside]
    # a density may be steep on the scale of rounding: there the larger neighbour explains most
    even = np.zeros(values.size, dtype=bool)
    for y in (values, values * values):
        gaps = np.where(inside, np.diff(y[window], axis=1), np.nan)
        steps = gaps / np.nanmin(gaps, axis=1, keepdims=True)
        even |= ~(np.abs(steps - np.round(steps)) > _EVEN).any(axis=1)
    explained = np.where(even, np.nanmax(near[:, 1:3], axis=1), np.nanmin(near, axis=1))
    return counts >= OFTEN + _STANDS_OUT * explained
