"""Whether the slips of an ensemble's sliders get ever rarer along the drive's way."""

from dataclasses import dataclass
from typing import Any

import numpy as np

# parts of the way beyond the first slip that are held against each other; standard errors by which the first and the
# last differ, and how many times fewer slips the last has at least, as those of a start are in the first alone
PARTS, APART, FEWER = 3, 3.0, 2.0


@dataclass(frozen=True)
class Rarer:
    """How slips get ever rarer: mean `first` and `last` spacing of the drive, in the first and last third of the `way`
    beyond the first slip (lengths), of `slips` a slider. Where none is left in the last, `last` is all of it."""

    first: float
    last: float
    way: float
    slips: float


def rarer(slips: Any, sliders: int, end: float) -> Rarer | None:
    """How the slips of so many sliders get rarer up to the drive's `end`; None where they do not: the last third has as
    many as the first within APART standard errors of their ratio, or more than half of them, or more than the second.
    The error is that between sliders, no less than if each slip came by chance."""
    if np.unique(slips.replica).size < sliders:
        return None
    begin = float(slips.drive.min())
    edges = np.linspace(begin, end, PARTS + 1)
    edges[0] = -np.inf
    counts = np.array(
        [np.histogram(slips.drive[slips.replica == n], edges)[0] for n in range(sliders)]
    )
    means = counts.mean(axis=0)
    # of each slider, as some slip more often than others all along: the logarithm, with a half for none
    gone = np.log((counts[:, 0] + 0.5) / (counts[:, -1] + 0.5))
    by_chance = (1.0 / (counts[:, [0, -1]] + 0.5)).sum(axis=1).mean()
    off = np.sqrt(max(gone.var(ddof=1), by_chance) / sliders)
    if gone.mean() < max(APART * off, np.log(FEWER)) or means[-2] < means[-1]:
        return None
    first, last = means[[0, -1]]
    third = (end - begin) / PARTS
    spacings = float(third / first), float(third / max(last, 1.0 / sliders))
    return Rarer(*spacings, end - begin, float(means.sum()))
