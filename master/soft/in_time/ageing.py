"""Contacts that age (closure "exact"): every strand carries the density of its thresholds.

The density is given on the cells of master.lives.age.cells. As long as all thresholds are far above
the stretch, a strand sleeps: its thresholds are normal, with known mean and standard deviation.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.age.cells import ASLEEP, Cells
from master.lives.age.strands import fresh_rate
from master.soft.in_time.memory import Leg, Memory, Scales
from origins import Contacts

Array = npt.NDArray[np.float64]

# Columns of a strand's numbers: the age, whether the strand sleeps, and from there on the cells.
AGE, SLEEPS, CELLS = range(3)


class AgeingMemory(Memory):
    """Contacts with `ageing`, closure "exact"; the errors of cells fall by 8 with each level.

    fastest : speed at which an edge of the density is resolved
    """

    error = 0.0

    def __init__(self, contacts: Contacts, level: int, fastest: float) -> None:
        ageing = contacts.ageing
        assert ageing is not None
        self._cells = cells = Cells(contacts, level, fastest)
        self.width = CELLS + cells.edges.size - 1
        self.reach = min(law.support()[1] for law in (contacts.thresholds, ageing.final))
        self.starts = 24 + 8 * level
        # first step of a hold: 1e-3 of the time in which thresholds spread by the narrowest width
        shortest = 1e-3 * cells.width**2 / ageing.rate
        # births change over a length of some 2 narrowest widths of both laws
        self.scales = Scales(2.0 * cells.width, shortest, fresh_rate(contacts))

    def start(self, stretch: Array) -> Array:
        """See Memory."""
        kept = np.zeros((stretch.size, self.width))
        asleep = self._cells.far_above(stretch, kept[:, AGE], ASLEEP)
        kept[:, SLEEPS] = asleep
        kept[~asleep, CELLS:] = self._cells.fresh(stretch[~asleep])
        return kept

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        out = kept.copy()
        out[:, AGE] += leg.duration
        furthest = np.maximum(np.abs(leg.begin), np.abs(leg.end))
        slept = kept[:, SLEEPS] > 0.0
        asleep = slept & self._cells.far_above(furthest, out[:, AGE], ASLEEP)
        out[:, SLEEPS] = asleep
        up = np.flatnonzero(slept & ~asleep)
        if up.size:
            out[up, CELLS:] = self._cells.unmet(leg.begin[up], kept[up, AGE])
        # drop strands of which a smaller share holds
        holds = out[:, CELLS:].sum(axis=1) > 1e-13
        out[~holds, CELLS:] = 0.0
        awake = np.flatnonzero(~asleep & holds)
        if awake.size:
            begin, way = leg.begin[awake], (leg.end - leg.begin)[awake]
            time, ends = np.full(awake.size, leg.duration), np.array([0.0, 1.0])
            out[awake, CELLS:] = self._cells.stepped(out[awake, CELLS:], begin, way, time, ends)
        return out

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        held = np.where(kept[:, SLEEPS] > 0.0, 1.0, kept[:, CELLS:].sum(axis=1))
        return np.stack([held, stretch * held])
