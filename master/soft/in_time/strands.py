"""Strands: cohorts whose contacts keep their thresholds, or their quantiles, for life.

A strand are the contacts born at one moment at one stretch. It has its stretch at birth, its
largest |x| so far, and what its law's Memory keeps. Births at many stretches are a few strands each,
at the nodes of a rule for their law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from master.lives.stretch_rule import StretchRule, stretch_rule
from master.soft.in_time.cohorts import Spread, Steps, halves
from master.soft.in_time.memory import BIRTHS, MORE_BIRTHS, Leg, Memory
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Share of a cohort below which it is forgotten.
DEAD = 1e-19


@dataclass(frozen=True)
class Strands:
    """Strands by cohort and node, in the order of their births; forgotten ones have no row.

    Attributes
    ----------
    memory : Memory
    rule : StretchRule
        Stretches at birth, and shares over what holds at birth.
    forgotten : int
        Cohorts, from the first, of which none is left.
    place : array of shape (rows, nodes)
        X at which a strand is unstretched (lengths).
    furthest : array of shape (rows, nodes)
        Largest |x| so far (lengths).
    side : array of shape (rows, nodes)
        Where that was: ahead (1), behind (-1), or at birth (0).
    kept : array of shape (rows, nodes, width)
    held, pull : arrays of shape (rows,)
        As in Cohorts.
    edge, edge_stiff : arrays of shape (rows, nodes)
        As in Left.
    """

    memory: Memory
    rule: StretchRule
    forgotten: int
    place: Array
    furthest: Array
    side: npt.NDArray[np.int8]
    kept: Array
    held: Array
    pull: Array
    edge: Array
    edge_stiff: Array

    @classmethod
    def none(cls, memory: Memory, rule: StretchRule) -> Strands:
        """No cohort yet; the rule has the shares of a law of stretches."""
        stretch = rule.stretch
        whole = memory.left(memory.start(stretch), stretch, np.abs(stretch)).held
        share = np.divide(rule.weight, whole, out=np.zeros(whole.size), where=whole > 0.0)
        grid, row = np.empty((0, stretch.size)), np.empty(0)
        return cls(
            memory,
            StretchRule(stretch, share),
            0,
            grid,
            grid,
            np.empty(grid.shape, dtype=np.int8),
            np.empty((*grid.shape, memory.width)),
            row,
            row,
            grid,
            grid,
        )

    def born(self, at: float, kept: Array) -> Strands:
        """One more cohort, where the slider stands at X = at, with these numbers (nodes, width)."""
        stretch = self.rule.stretch
        left = self.memory.left(kept, stretch, np.abs(stretch))
        held, pull = self.rule.weight @ left.held, self.rule.weight @ left.force
        return replace(
            self,
            place=np.concatenate([self.place, (at - stretch)[None]]),
            furthest=np.concatenate([self.furthest, np.abs(stretch)[None]]),
            side=np.concatenate([self.side, np.zeros((1, stretch.size), dtype=np.int8)]),
            kept=np.concatenate([self.kept, kept[None]]),
            held=np.append(self.held, held),
            pull=np.append(self.pull, pull),
            edge=np.concatenate([self.edge, left.edge[None]]),
            edge_stiff=np.concatenate([self.edge_stiff, left.edge_stiff[None]]),
        )

    def advance(self, before: float, at: float, duration: float) -> Strands:
        """All after the slider has gone from X = before to X = at."""
        alive = np.flatnonzero(self.held > DEAD)
        if not alive.size and self.held.size == 1 and self.place.size > 1:
            return self  # a start at many stretches of which none is left
        # the last cohort stays, as neighbour of the next birth
        last = max(self.held.size - 1, 0)
        rows = slice(int(alive[0]) if alive.size else last, None)
        place = self.place[rows]
        stretch = at - place
        furthest = np.maximum(self.furthest[rows], np.abs(stretch))
        grown = furthest > self.furthest[rows]
        side = np.where(grown, np.sign(stretch), self.side[rows]).astype(np.int8)
        kept = self.kept[rows].reshape(place.size, self.memory.width)
        leg = Leg((before - place).ravel(), stretch.ravel(), furthest.ravel(), duration)
        if place.size:
            kept = self.memory.advance(kept, leg)
        left = self.memory.left(kept, leg.end, leg.furthest)
        weight, shape = self.rule.weight, place.shape
        return replace(
            self,
            forgotten=self.forgotten + rows.start,
            place=place,
            furthest=furthest,
            side=side,
            kept=kept.reshape(*shape, self.memory.width),
            held=left.held.reshape(shape) @ weight,
            pull=left.force.reshape(shape) @ weight,
            edge=left.edge.reshape(shape),
            edge_stiff=left.edge_stiff.reshape(shape),
        )

    def kinks(self, at: float) -> Spread:
        """What the chord between two births misses where the largest |x| is a V between them.

        After a turn it is the way to the turn for those born early, and the way back for those born
        late: of births in between it is the smallest, and more of them hold.
        """
        side, place, m, n = self.side, self.place, self.furthest, self.held.size
        apart = (side[1:] != side[:-1]) & (place[1:] != place[:-1])
        # relaxed ones that are born now have no V beside them
        apart &= (side[1:] != 0) | (self.rule.stretch != 0.0)
        row, node = np.nonzero(apart)
        none = np.zeros(max(n - 1, 0))
        if not row.size:
            return Spread(none, none)
        own = np.abs(self.rule.stretch[node])
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
        deep = np.where(inside, (chord - least) * (0.5 * self.rule.weight[node]), 0.0)
        held, pull = (
            np.bincount(row, deep * 0.5 * (edge[row, node] + edge[row + 1, node]) * arm, n - 1)
            for edge, arm in ((self.edge, 1.0), (self.edge_stiff, at - foot))
        )
        return Spread(held.astype(float), pull.astype(float))


@dataclass(frozen=True)
class StrandCohorts:
    """Cohorts (see there) made of strands.

    start : Strands or None
        The contacts at X = 0; None where they are like all births, the first of which they are then.
    births : Strands
    at : X of the slider (a length)
    """

    start: Strands | None
    births: Strands
    work: int
    at: float = 0.0

    @classmethod
    def of(
        cls, contacts: Contacts, memory: Memory, level: int, reset: bool = False
    ) -> StrandCohorts:
        """All contacts at X = 0, as they start or where all have just formed again.

        Births at many stretches have more nodes with each level.
        """
        again: Start = SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law
        births = Strands.none(
            memory, stretch_rule(again, memory.reach, BIRTHS + MORE_BIRTHS * level)
        )
        work = (memory.width + 60) * births.rule.stretch.size
        first = again if reset else contacts.start
        start = Strands.none(memory, stretch_rule(first, memory.reach, memory.starts))
        stretch, fresh = start.rule.stretch, memory.fresh(births.rule.stretch, 0.0)
        kept = memory.fresh(stretch, 0.0) if reset else memory.start(stretch)
        if np.array_equal(stretch, births.rule.stretch) and np.array_equal(kept, fresh):
            return cls(None, births.born(0.0, kept), work)
        return cls(start.born(0.0, kept), births, work)

    @property
    def steps(self) -> Steps:
        return self.births.memory.steps

    @property
    def error(self) -> float:
        return self.births.memory.error

    @property
    def held(self) -> Array:
        return self._all(0.0 if self.start is None else self.start.held[0], self.births.held)

    @property
    def pull(self) -> Array:
        return self._all(0.0 if self.start is None else self.start.pull[0], self.births.pull)

    def _all(self, start: float, births: Array) -> Array:
        first = np.zeros(self.births.forgotten + (self.start is not None))
        first[:1] = start
        return np.concatenate([first, births])

    def born(self, speed: float) -> StrandCohorts:
        """See Cohorts."""
        births = self.births
        kept = births.memory.fresh(births.rule.stretch, speed)
        return replace(self, births=births.born(self.at, kept))

    def advance(self, travel: float, duration: float) -> StrandCohorts:
        """See Cohorts."""
        at = self.at + travel
        births = self.births.advance(self.at, at, duration)
        start = None if self.start is None else self.start.advance(self.at, at, duration)
        return replace(self, start=start, births=births, at=at)

    def spread(self) -> Spread:
        """See Cohorts."""
        more = self.births.kinks(self.at)
        held, pull = halves(self.held), halves(self.pull)
        # between which births, the start being none
        first = self.births.forgotten - (self.start is None)
        skipped = max(-first, 0)
        if more.held.size > skipped:
            held[max(first, 0) :] += more.held[skipped:]
            pull[max(first, 0) :] += more.pull[skipped:]
        return Spread(held, pull)
