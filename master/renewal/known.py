"""Known: what lumps and solved panels add to number and force later on, where lives are quickly told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal.births import Births
from master.renewal.kernels import TARGETS
from master.renewal.lumps import Lump
from origins.start import Start

Array = npt.NDArray[np.float64]
Which = npt.NDArray[np.bool_]


class Added(NamedTuple):
    """What panels add.

    sums : array of shape (2, *grid.shape), number and force
    gone : array of shape (panels,), whether none of a panel's births holds any more
    """

    sums: Array
    gone: Which


def of_lumps(births: Births, lumps: Sequence[Lump], grid: Array) -> Array:
    """Number and force of lumps at times of shape (panels, TARGETS.size), all on one leg.

    The middle column tells on which side of an exact threshold a row is. Shape (2, *grid.shape).
    """
    out, now = np.zeros((2, *grid.shape)), float(grid[0, 0])
    middle = grid[:, TARGETS.size // 2]
    for lump in lumps:
        if not lump.holds or gone(births, now, lump.law, np.array([[lump.time]]))[0]:
            continue
        early = middle < lump.time
        out[0, early] += lump.weight
        if not early.all():
            history = births.motion.history(grid[~early], np.full((1, 1), lump.time))
            out[:, ~early] += lump.weight * births.life.left(lump.law, history)
    return out


def of_panels(births: Births, grid: Array, begin: Array, width: Array, breaks: Array) -> Added:
    """Number and force of the births of solved panels at later times; see of_lumps."""
    out = np.zeros((2, grid.size))
    s = np.stack([begin, begin + 0.5 * width, begin + width], axis=1) + births.delay
    dead = gone(births, float(grid[0, 0]), births.law, s)
    whole = births.still_whole(grid, begin, width)
    for which, sums in ((whole, births.whole_sums), (~whole & ~dead, births.sums)):
        if which.any():
            out += sums(grid.ravel(), begin[which], width[which], breaks[which])
    return Added(out.reshape(2, *grid.shape), dead)


def gone(births: Births, t: float, law: Start, s: Array) -> Which:
    """Whether contacts born at s, shape (n, columns), have all been stretched beyond reach by t.

    Those that are out at t are not gone.
    """
    first, last = law.span
    history = births.motion.history(np.full((1, 1), t), np.minimum(s, t))
    least = np.maximum(first + history.high.min(axis=1), -(last + history.low.max(axis=1)))
    return np.asarray((least >= births.life.reach) & (s.max(axis=1) < t))
