"""Empty gaps between samples that are far wider than chance leaves them."""

import numpy as np

from origins.samples.spline import Places
from origins.thresholds.law import Array

FEW = 5  # distinct samples that make a group of their own; fewer are strays
_BESIDE = 50  # distances that a gap is held against, at most
_LEAST_BESIDE = 3
_OWN = 2.0  # of the next distances, that rounding may leave
SURE, DOUBTFUL = 4.5, 3.0  # -log of how rarely a law without gaps has one: for sure, and where no law goes across


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


def cut_off(x: Array, counts: Array, most: int, chance: float = SURE) -> tuple[int, int]:
    """The gap that up to `most` of the samples x (distinct, sorted, each there `counts` times) lie beyond, at either
    end, and that chance leaves least: the place of the first sample above it, and how many lie beyond; (0, 0) where
    none is rarer than e^-chance.

    In an exponential tail, and of the logarithms in a power-law tail, the distances from one sample to the next times
    the number of samples beyond are exponential variables of one mean (A. Rényi, Acta Math. Hung. 4, 191, 1953); in
    thinner tails they get smaller. A gap must be too wide for both. Samples that rounding makes equal count each, at a
    distance of 0, and rounding leaves gaps of its own: only what is wider than twice the next ones counts.
    """
    counts = counts / counts.min()
    upper = np.minimum(_surprise(x[::-1], counts[::-1], most), _surprise(np.log(x[::-1]), counts[::-1], most))
    lower = np.minimum(_surprise(x, counts, most), _surprise(np.log(x), counts, most))
    if not upper.size:
        return 0, 0
    above, below = int(upper.argmax()) + 1, int(lower.argmax()) + 1
    if max(upper[above - 1], lower[below - 1]) < chance:
        return 0, 0
    return (x.size - above, above) if upper[above - 1] > lower[below - 1] else (below, below)


def _surprise(y: Array, counts: Array, most: int) -> Array:
    """-log of the chance of a gap as wide as that after the first k values, beside the next ones; shape (k,)."""
    beyond = np.cumsum(counts)
    distance = np.abs(np.diff(y))
    sums = np.append(0.0, np.cumsum(distance * beyond[:-1]))
    k: Places = np.arange(min(most, y.size // 2, y.size - 1 - _LEAST_BESIDE))
    wanted = min(max(float(np.sqrt(beyond[-1])), FEW), _BESIDE)
    last = np.maximum(np.searchsorted(beyond, beyond[k] + wanted - 0.5) + 1, k + 1 + _LEAST_BESIDE)
    last = np.minimum(last, distance.size)
    held = beyond[last - 1] - beyond[k]
    number = np.minimum(held, wanted)
    next_ones = distance[k[:, None] + 1 + np.arange(_LEAST_BESIDE)].max(axis=1)
    wider = np.maximum(distance[k] - _OWN * next_ones, 0.0) * beyond[k]
    return number * np.log1p(wider * held / (number * (sums[last] - sums[k + 1])))
