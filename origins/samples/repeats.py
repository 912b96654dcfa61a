"""Values that samples repeat: exact ones apart from those that are only rounded."""

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

OFTEN = 10
_STANDS_OUT = 5  # times as often as the values beside it
_SAME = 1e-12  # relative distance of samples that are one value
_SURELY_EXACT, _FEW = 3, 8  # values in all
_EVEN = 1e-3  # of the step of a grid


def distinct(ordered: Array, shares: Array) -> tuple[Array, Array, Array]:
    """Sorted values that differ, their shares, and how often each is there, from sorted samples and their shares."""
    first = np.append(0, np.flatnonzero(np.diff(ordered) > _SAME * ordered[1:]) + 1)
    counts = np.diff(np.append(first, ordered.size)).astype(float)
    return ordered[first], np.add.reduceat(shares, first), counts


def exact(values: Array, counts: Array) -> npt.NDArray[np.bool_]:
    """Which of the values (sorted, each there `counts` times) are exact, by the rule that from_samples states."""
    if 1 < values.size <= _FEW and counts.min() >= OFTEN:
        return np.full(values.size, values.size <= _SURELY_EXACT or not _on_a_grid(values))
    around = np.pad(counts, 2)
    beside = np.sort([np.roll(around, shift)[2:-2] for shift in (-2, -1, 1, 2)], axis=0)
    # the second largest: another exact value may be next to it, and a rounded density may be steep
    return counts >= OFTEN + _STANDS_OUT * beside[-2]


def _on_a_grid(values: Array) -> bool:
    """Whether values, or their squares (lengths from rounded forces), follow each other at one step."""
    for y in (values, values * values):
        steps = np.diff(y) / np.diff(y).min()
        if (np.abs(steps - np.round(steps)) < _EVEN).all() and np.median(steps) < 1.5:
            return True
    return False
