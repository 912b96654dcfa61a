"""Cohorts: what is left of contacts that were born together, all along one motion of the slider.

Contacts do not know of each other: what is left of those born at one moment depends on the motion
since and on nothing else. A cohort is one strand for each stretch at which its contacts are born: a
strand has its place, its largest |x|, and what its law's Memory keeps. How many are born follows
from number conservation alone (master.soft.in_time.carried), which knows no law of contacts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.stretch_rule import StretchRule, stretch_rule
from master.soft.in_time.memory import Left, Leg, Memory
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Nodes for births at many stretches, on the coarsest steps and more on each finer level.
BIRTHS, MORE_BIRTHS = 8, 4
# Share of a cohort below which it is forgotten.
DEAD = 1e-19


class Spread(NamedTuple):
    """Of contacts born evenly between two births that follow each other, arrays of shape (n - 1,).

    held : share that holds; pull : force per contact born and <k> (lengths)
    """

    held: Array
    pull: Array


@dataclass(frozen=True)
class Cohorts:
    """The contacts that hold at t = 0, and one cohort for every call of `born`.

    Nothing is changed in place: every method leaves the cohorts as they are and returns others.

    Attributes
    ----------
    memory : Memory
    start, births : StretchRule
        Stretches of those of t = 0 and at birth; shares over what holds then.
    started : int
        Strands of t = 0: those of `start`, or 0 when none is left.
    forgotten : int
        Births, from the first, of which none is left and which have no strand any more.
    at : float
        X of the slider (a length).
    place, furthest, side : arrays of shape (n,), of the strands in the order of their births
        X at which they are unstretched (lengths), the largest |x| so far, and where that was:
        ahead (1), behind (-1), or at birth (0).
    kept : array of shape (n, width)
    """

    memory: Memory
    start: StretchRule
    births: StretchRule
    started: int
    forgotten: int
    at: float
    place: Array
    furthest: Array
    side: Array
    kept: Array

    @classmethod
    def of(cls, contacts: Contacts, memory: Memory, level: int, reset: bool = False) -> Cohorts:
        """All contacts at X = 0, as they start or where all have just formed again.

        Births at many stretches have more nodes with each level.
        """
        again: Start = SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law
        births = stretch_rule(again, memory.reach, BIRTHS + MORE_BIRTHS * level)
        start = stretch_rule(again if reset else contacts.start, memory.reach, memory.starts)
        x = start.stretch
        kept = memory.fresh(x, 0.0) if reset else memory.start(x)
        rules = _over_held(memory, start), _over_held(memory, births)
        return cls(memory, *rules, x.size, 0, 0.0, -x, np.abs(x), np.zeros(x.size), kept)

    @property
    def work(self) -> int:
        """Numbers looked at for each cohort in one step: how many steps are affordable."""
        return (self.memory.width + 60) * self.births.stretch.size

    @cached_property
    def left(self) -> Left:
        """Of every strand."""
        return self.memory.left(self.kept, self.at - self.place, self.furthest)

    @cached_property
    def held(self) -> Array:
        """Share of each cohort that still holds, shape (cohorts,); number 0 are those of t = 0."""
        return self._sums(self.left.held)

    @cached_property
    def pull(self) -> Array:
        """Its force, the sum of k x over those that hold, per contact born and <k> (a length)."""
        return self._sums(self.left.force)

    def _sums(self, each: Array) -> Array:
        first = each[: self.started] @ self.start.weight[: self.started]
        births = self._of_births(each) @ self.births.weight
        return np.concatenate([[first], np.zeros(self.forgotten), births])

    def _of_births(self, values: Array) -> Array:
        """By cohort and node."""
        return values[self.started :].reshape(-1, self.births.stretch.size)

    def born(self, speed: float) -> Cohorts:
        """With a new cohort, where the slider stands now, which moves at this speed |dX/dt|."""
        x = self.births.stretch
        return replace(
            self,
            place=np.append(self.place, self.at - x),
            furthest=np.append(self.furthest, np.abs(x)),
            side=np.append(self.side, np.zeros(x.size)),
            kept=np.concatenate([self.kept, self.memory.fresh(x, speed)]),
        )

    def advance(self, travel: float, duration: float) -> Cohorts:
        """After a move by `travel` (a length of either sign) within `duration`, at one speed.

        A slip is a travel in no time, a hold is time without travel. Errors may be of second order
        in the step.
        """
        started = self.started if self.held[0] > DEAD else 0
        births = self.held[1 + self.forgotten :]
        # the last cohort stays, as neighbour of the next birth
        alive = np.flatnonzero(np.append(births[:-1] > DEAD, True))
        gone = int(alive[0]) if births.size else 0
        kept = np.ones(self.place.size, dtype=bool)
        kept[started : self.started] = False
        kept[self.started : self.started + gone * self.births.stretch.size] = False
        at, place, before = self.at + travel, self.place[kept], self.furthest[kept]
        stretch = at - place
        furthest = np.maximum(before, np.abs(stretch))
        leg = Leg(self.at - place, stretch, furthest, duration)
        return replace(
            self,
            started=started,
            forgotten=self.forgotten + gone,
            at=at,
            place=place,
            furthest=furthest,
            side=np.where(furthest > before, np.sign(stretch), self.side[kept]),
            kept=self.memory.advance(self.kept[kept], leg) if place.size else self.kept[kept],
        )

    def spread(self) -> Spread:
        """Of the births between neighbours, to second order in what lies between."""
        more = self._kinks()
        held, pull = (0.5 * (values[1:-1] + values[2:]) for values in (self.held, self.pull))
        held[self.forgotten :] += more.held
        pull[self.forgotten :] += more.pull
        return Spread(held, pull)

    def _kinks(self) -> Spread:
        """What the chord between two births misses where the largest |x| is a V between them.

        After a turn it is the way to the turn for those born early, and the way back for those born
        late: of births in between it is the smallest, and more of them hold.
        """
        side, place, m, edge, edge_stiff = (
            self._of_births(values)
            for values in (
                self.side,
                self.place,
                self.furthest,
                self.left.edge,
                self.left.edge_stiff,
            )
        )
        count = max(side.shape[0] - 1, 0)
        apart = (side[1:] != side[:-1]) & (place[1:] != place[:-1])
        # relaxed ones that are born now have no V beside them
        apart &= (side[1:] != 0) | (self.births.stretch != 0.0)
        row, node = np.nonzero(apart)
        if not row.size:
            return Spread(np.zeros(count), np.zeros(count))
        own = np.abs(self.births.stretch[node])
        high, low = np.full(row.size, np.nan), np.full(row.size, np.nan)
        flat = np.zeros(row.size, dtype=bool)
        for end in ((row, node), (row + 1, node)):
            # m is high - place ahead, place - low behind, and |r| where neither is larger
            high = np.where(side[end] > 0, place[end] + m[end], high)
            low = np.where(side[end] < 0, place[end] - m[end], low)
            flat |= side[end] == 0
        foot = np.where(flat, np.where(np.isnan(high), low + own, high - own), 0.5 * (high + low))
        least = np.where(flat, own, 0.5 * (high - low))
        part = (foot - place[row, node]) / (place[row + 1, node] - place[row, node])
        chord = m[row, node] * (1.0 - part) + m[row + 1, node] * part
        inside = (part > 0.0) & (part < 1.0)
        deep = np.where(inside, (chord - least) * (0.5 * self.births.weight[node]), 0.0)
        held, pull = (
            np.bincount(row, deep * 0.5 * (each[row, node] + each[row + 1, node]) * arm, count)
            for each, arm in ((edge, 1.0), (edge_stiff, self.at - foot))
        )
        return Spread(held.astype(float), pull.astype(float))


def _over_held(memory: Memory, rule: StretchRule) -> StretchRule:
    """The rule with shares over what holds at birth."""
    stretch = rule.stretch
    whole = memory.left(memory.start(stretch), stretch, np.abs(stretch)).held
    share = np.divide(rule.weight, whole, out=np.zeros(whole.size), where=whole > 0.0)
    return StretchRule(stretch, share)
