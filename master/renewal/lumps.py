"""Lumps: contacts born together at one moment, such as those that met one exact threshold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.motion.motion import Motion
from master.renewal.births import Births
from origins.start import Start

Array = npt.NDArray[np.float64]

# Share of contacts that is negligible beside the rounding of the number, 1e-16.
NOTHING = 1e-18


@dataclass
class Lump:
    """Contacts that were born at one moment, or hold at t = 0 (paper, Eqs. Q7b and Q6e).

    time : of the birth; weight : share of all contacts; law : of the stretches at birth
    holds : whether any of them still hold
    """

    time: float
    weight: float
    law: Start
    holds: bool = True


def breaking(births: Births, lumps: Sequence[Lump], before: float, t: float, after: float) -> float:
    """Share of all contacts that reach an exact threshold, together, at the edge t.

    before, after : moments before and after the edge. Sets `holds` of each lump.
    """
    lost = 0.0
    for lump in lumps:
        if not lump.holds or lump.time >= t:
            continue
        born = np.full((1, 1), lump.time)
        held = [
            float(births.life.left(lump.law, births.motion.history(at, born))[0, 0, 0])
            for at in (np.array([[t, before, t]]), np.array([[t, after, t]]))
        ]
        lost += lump.weight * (held[0] - held[1])
        lump.holds = lump.weight * held[1] > NOTHING
    return lost


def of_lumps(
    births: Births, lumps: Sequence[Lump], motion: Motion, late: float, grid: Array
) -> Array:
    """Number and force of lumps at times of shape (rows, columns), all on one leg.

    motion, late : the births' motion, whose times are counted from this time, as those of the grid

    The middle column decides on which side of an exact threshold a row lies. Returns an array of
    shape (2, *grid.shape).
    """
    out, middle = np.zeros((2, *grid.shape)), grid[:, grid.shape[1] // 2]
    for lump in lumps:
        if not lump.holds:
            continue
        s, (first, last) = np.full((1, 1), lump.time - late), lump.law.span
        if s < grid[0, 0]:
            moved = motion.history(grid[:1, :1], s)
            if max(first + moved.high[0, 0], -(last + moved.low[0, 0])) > births.life.reach:
                continue
        early = middle < lump.time - late
        out[0, early] += lump.weight
        if not early.all():
            history = motion.history(grid[~early], s)
            births.work += births.dear * grid.shape[0]
            out[:, ~early] += lump.weight * births.life.left(lump.law, history)
    return out
