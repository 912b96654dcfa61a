"""Empty gaps between samples that are far wider than chance leaves them."""

import numpy as np

from origins.spline import Places
from origins.thresholds import Array

FEW = 5  # distinct samples that make a group of their own; fewer are strays
_BESIDE = 50  # distances that a gap is held against, at most
_LEAST_BESIDE = 3
_CHANCE = 10.0  # -log of how rarely a law without gaps has one


def widest_gap(x: Array) -> tuple[int, float]:
    """The gap between groups that is widest beside the samples to either side of it: the place of the first sample
    above it, and its width in units of their mean distance."""
    if x.size < 2 * FEW:
        return 0, 0.0
    place = np.arange(FEW, x.size - FEW + 1)
    many = max(int(np.sqrt(x.size)), FEW)
    low, high = np.maximum(place - 1 - many, 0), np.minimum(place + many, x.size - 1)
    beside = np.maximum((x[place - 1] - x[low]) / (place - 1 - low), (x[high] - x[place]) / (high - place))
    ratio = (x[place] - x[place - 1]) / beside
    best = int(ratio.argmax())
    return int(place[best]), float(ratio[best])


def cut_off(x: Array, most: int) -> tuple[int, int]:
    """The gap that up to `most` of the samples x (distinct, sorted) lie beyond, at either end, and that chance leaves
    least: the place of the first sample above it, and how many lie beyond; (0, 0) where there is none.

    In an exponential tail, and of the logarithms in a power-law tail, the distances from one sample to the next times
    the number of samples beyond are exponential variables of one mean (A. Rényi, Acta Math. Hung. 4, 191, 1953); in
    thinner tails they get smaller. A gap must be too wide for both.
    """
    upper = np.minimum(_surprise(x[::-1], most), _surprise(np.log(x[::-1]), most))
    lower = np.minimum(_surprise(x, most), _surprise(np.log(x), most))
    if not upper.size:
        return 0, 0
    above, below = int(upper.argmax()) + 1, int(lower.argmax()) + 1
    if max(upper[above - 1], lower[below - 1]) < _CHANCE:
        return 0, 0
    return (x.size - above, above) if upper[above - 1] > lower[below - 1] else (below, below)


def _surprise(y: Array, most: int) -> Array:
    """-log of the chance of a gap as wide as that after the first k samples, beside the next ones; shape (k,)."""
    beyond = np.arange(1, y.size)
    spacing = np.abs(np.diff(y)) * beyond
    sums = np.append(0.0, np.cumsum(spacing))
    k: Places = np.arange(min(most, y.size // 2, y.size - 1 - _LEAST_BESIDE))
    last = np.minimum(k + 1 + min(max(int(np.sqrt(y.size)), FEW), _BESIDE), spacing.size)
    number = last - k - 1
    return number * np.log1p(spacing[k] / (sums[last] - sums[k + 1]))
