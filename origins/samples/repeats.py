"""Values that repeat among samples: which are exact, and which only rounded."""

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

OFTEN = 10
_STANDS_OUT = 5  # least ratio of an exact value's count to that of its neighbours
_SAME = 1e-12  # relative distance at which samples count as equal
_SURELY_EXACT, _FEW = 3, 8  # numbers of different values
_EVEN = 1e-3  # deviation from equal spacing, over the step of a grid


def distinct(ordered: Array, shares: Array) -> tuple[Array, Array, Array]:
    """Sorted values that differ, their shares, and their counts, from sorted samples and their shares."""
    first = np.append(0, np.flatnonzero(np.diff(ordered) > _SAME * ordered[1:]) + 1)
    counts = np.diff(np.append(first, ordered.size)).astype(float)
    return ordered[first], np.add.reduceat(shares, first), counts


def exact(values: Array, counts: Array) -> npt.NDArray[np.bool_]:
    """Which of the values (sorted, each occurring `counts` times) are exact, by the rule that from_samples states."""
    if 1 < values.size <= _FEW and counts.min() >= OFTEN:
        return np.full(values.size, values.size <= _SURELY_EXACT or not _on_a_grid(values))
    around = np.pad(counts, 2)
    beside = np.sort([np.roll(around, shift)[2:-2] for shift in (-2, -1, 1, 2)], axis=0)
    # the second largest: another exact value may be next to it, and a rounded density may be steep
    return counts >= OFTEN + _STANDS_OUT * beside[-2]


def _on_a_grid(values: Array) -> bool:
    """Whether values, or their squares (lengths from rounded forces), are equally spaced."""
    for y in (values, values * values):
        steps = np.diff(y) / np.diff(y).min()
        if (np.abs(steps - np.round(steps)) < _EVEN).all() and np.median(steps) < 1.5:
            return True
    return False
