"""Cohorts of contacts that age, each by itself: every strand carries the density of its thresholds.

The density stands in the cells of master.lives.age.cells. As long as all thresholds are far above the
stretch a strand sleeps: then they are normal, of known mean and standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from master.lives.age.cells import ASLEEP, Cells
from master.lives.age.strands import fresh_rate, stepped
from master.lives.stretch_rule import StretchRule, stretch_rule
from master.soft.in_time.cohorts import Spread, Steps, halves
from master.soft.in_time.memory import BIRTHS, MORE_BIRTHS
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Nodes for a spread start, and more with each level.
STARTS, MORE_STARTS = 24, 8
# Length over which births change, in the narrowest widths of both laws.
STEPS = 2.0
# The shortest time that a hold's first step takes, of that in which thresholds spread by the
# narrowest width.
AT_ONCE = 1e-3
# Share that holds below which a strand is dropped.
DEAD = 1e-13


@dataclass(frozen=True)
class AgeingCohorts:
    """Cohorts (see there) of contacts with `ageing`, closure "exact".

    Attributes
    ----------
    cells : Cells
    again : StretchRule
        Stretches at birth.
    count : int
        Of cohorts.
    cohort, stretch, share, age : arrays of shape (n,), of the strands
    weights : array of shape (n, cells)
        Thresholds in the cells of strands that are awake.
    asleep : array of bool, shape (n,)
    """

    cells: Cells
    steps: Steps
    work: int
    again: StretchRule
    count: int
    cohort: Rows
    stretch: Array
    share: Array
    age: Array
    weights: Array
    asleep: npt.NDArray[np.bool_]
    error: float = 0.0

    @classmethod
    def of(cls, contacts: Contacts, level: int, fastest: float) -> AgeingCohorts:
        """All contacts at X = 0; the errors of cells fall by 8 with each level.

        fastest : speed at which an edge of the density is resolved
        """
        ageing = contacts.ageing
        assert ageing is not None
        cells = Cells(contacts, level, fastest)
        most = min(law.support()[1] for law in (contacts.thresholds, ageing.final))
        start = stretch_rule(contacts.start, most, STARTS + MORE_STARTS * level)
        law: Start = SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law
        again = stretch_rule(law, most, BIRTHS + MORE_BIRTHS * level)
        steps = Steps(
            STEPS * cells.width,
            AT_ONCE * cells.width**2 / ageing.rate,
            fresh_rate(contacts),
            fuzzy=True,
        )
        none, size = np.empty(0), cells.edges.size - 1
        out = cls(
            cells,
            steps,
            size // 3 * again.stretch.size,
            again,
            0,
            np.empty(0, dtype=np.intp),
            none,
            none,
            none,
            np.empty((0, size)),
            np.empty(0, dtype=bool),
        )
        return out._with(start)

    def _with(self, rule: StretchRule) -> AgeingCohorts:
        """With one more cohort, at the stretches of a rule."""
        n, cells = rule.stretch.size, self.cells
        age = np.zeros(n)
        asleep = cells.far_above(rule.stretch, age, ASLEEP)
        weights = np.zeros((n, cells.edges.size - 1))
        weights[~asleep] = cells.fresh(rule.stretch[~asleep])
        return replace(
            self,
            count=self.count + 1,
            cohort=np.append(self.cohort, np.full(n, self.count)),
            stretch=np.append(self.stretch, rule.stretch),
            share=np.append(self.share, rule.weight),
            age=np.append(self.age, age),
            weights=np.concatenate([self.weights, weights]),
            asleep=np.append(self.asleep, asleep),
        )

    @property
    def held(self) -> Array:
        return self._sums(self._holds())

    @property
    def pull(self) -> Array:
        return self._sums(self._holds() * self.stretch)

    def _holds(self) -> Array:
        return self.share * np.where(self.asleep, 1.0, self.weights.sum(axis=1))

    def _sums(self, each: Array) -> Array:
        return np.asarray(np.bincount(self.cohort, each, self.count), dtype=float)

    def born(self, speed: float) -> AgeingCohorts:
        """See Cohorts."""
        return self._with(self.again)

    def advance(self, travel: float, duration: float) -> AgeingCohorts:
        """See Cohorts."""
        alive = self.asleep | (self.weights.sum(axis=1) > DEAD)
        begin, before = self.stretch[alive], self.age[alive]
        end, age = begin + travel, before + duration
        furthest = np.maximum(np.abs(begin), np.abs(end))
        asleep = self.asleep[alive] & self.cells.far_above(furthest, age, ASLEEP)
        weights = self.weights[alive]
        up = np.flatnonzero(self.asleep[alive] & ~asleep)
        if up.size:
            weights[up] = self.cells.unmet(begin[up], before[up])
        awake = np.flatnonzero(~asleep)
        if awake.size:
            way, time = np.full(awake.size, travel), np.full(awake.size, duration)
            weights[awake] = stepped(
                self.cells, weights[awake], begin[awake], way, time, np.array([0.0, 1.0])
            )
        return replace(
            self,
            cohort=self.cohort[alive],
            stretch=end,
            share=self.share[alive],
            age=age,
            weights=weights,
            asleep=asleep,
        )

    def spread(self) -> Spread:
        """See Cohorts."""
        return Spread(halves(self.held), halves(self.pull))
