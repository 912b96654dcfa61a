"""Cohorts: survival and force of contacts that were born together, along one motion of the slider.

Contacts are independent: the survival of those born at one moment depends on the motion since and on
nothing else. A cohort has one strand for each stretch at which its contacts are born: a strand has
its place, its largest |x|, and the numbers of its law's Memory. The number of births follows from
number conservation (master.soft.in_time.carried), which is independent of the contacts' law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from master.lives.averages import StretchRule, stretch_rule
from master.soft.in_time.memory import Leg, Memory
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Nodes for births at many stretches: on the coarsest level, and more for each finer level.
BIRTHS, MORE_BIRTHS = 8, 4
# Share of a cohort that holds below which it is dropped.
DEAD = 1e-19


@dataclass(frozen=True)
class Cohorts:
    """The contacts that hold at t = 0, and one cohort for every call of `born`.

    Cohorts are immutable: every method returns new ones.

    Attributes
    ----------
    memory : Memory
    start, births : StretchRule
        Stretches at t = 0 and at birth; weights divided by the share that holds there.
    started : int
        Number of strands of t = 0: those of `start`, or 0 when they have been dropped.
    forgotten : int
        Number of cohorts, from the first birth on, that have been dropped with their strands.
    at : float
        X of the slider (a length).
    place, furthest : arrays of shape (n,), of the strands in the order of their births
        X at which they are unstretched, and the largest |x| so far (lengths).
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
    kept: Array

    @classmethod
    def of(cls, contacts: Contacts, memory: Memory, level: int, reset: bool = False) -> Cohorts:
        """All contacts at X = 0: those of the start, or (`reset`) all just re-formed.

        Births at many stretches have more nodes with each level.
        """
        again: Start = SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law
        births = stretch_rule(again, memory.reach, BIRTHS + MORE_BIRTHS * level)
        start = stretch_rule(again if reset else contacts.start, memory.reach, memory.starts)
        x = start.stretch
        kept = memory.fresh(x, 0.0) if reset else memory.start(x)
        rules = _over_held(memory, start), _over_held(memory, births)
        return cls(memory, *rules, x.size, 0, 0.0, -x, np.abs(x), kept)

    @property
    def work(self) -> int:
        """Estimated operations for each cohort in one step."""
        return (self.memory.width + 60) * self.births.stretch.size

    @cached_property
    def left(self) -> Array:
        """Share of each cohort that still holds, and its force per contact born and <k> (a length).

        Shape (2, cohorts); number 0 are those of t = 0.
        """
        each = self.memory.left(self.kept, self.at - self.place, self.furthest)
        first = each[:, : self.started] @ self.start.weight[: self.started]
        rows = each[:, self.started :].reshape(2, -1, self.births.stretch.size)
        gone = np.zeros((2, self.forgotten))
        return np.concatenate([first[:, None], gone, rows @ self.births.weight], axis=1)

    def born(self, speed: float) -> Cohorts:
        """These cohorts and a new one, born at the slider's present X and speed |dX/dt|."""
        x = self.births.stretch
        return replace(
            self,
            place=np.append(self.place, self.at - x),
            furthest=np.append(self.furthest, np.abs(x)),
            kept=np.concatenate([self.kept, self.memory.fresh(x, speed)]),
        )

    def advance(self, travel: float, duration: float) -> Cohorts:
        """The cohorts after a move by `travel` (a length of either sign) in `duration`, at one speed.

        A slip is a travel in no time, a hold is time without travel. Errors may be of second order
        in the step.
        """
        held = self.left[0]
        started = self.started if held[0] > DEAD else 0
        births = held[1 + self.forgotten :]
        # the last cohort is kept, since `between` needs it beside the next one
        alive = np.flatnonzero(np.append(births[:-1] > DEAD, True))
        gone = int(alive[0]) if births.size else 0
        kept = np.ones(self.place.size, dtype=bool)
        kept[started : self.started] = False
        kept[self.started : self.started + gone * self.births.stretch.size] = False
        at, place = self.at + travel, self.place[kept]
        stretch = at - place
        furthest = np.maximum(self.furthest[kept], np.abs(stretch))
        leg = Leg(self.at - place, stretch, furthest, duration)
        return replace(
            self,
            started=started,
            forgotten=self.forgotten + gone,
            at=at,
            place=place,
            furthest=furthest,
            kept=self.memory.advance(self.kept[kept], leg) if place.size else self.kept[kept],
        )

    def between(self) -> Array:
        """As `left`, for contacts born at a constant rate between consecutive cohorts: their mean.

        Shape (2, births - 1).
        """
        return np.asarray(0.5 * (self.left[:, 1:-1] + self.left[:, 2:]))


def _over_held(memory: Memory, rule: StretchRule) -> StretchRule:
    """The rule with weights divided by the share that holds at birth."""
    stretch = rule.stretch
    whole = memory.left(memory.start(stretch), stretch, np.abs(stretch))[0]
    share = np.divide(rule.weight, whole, out=np.zeros(whole.size), where=whole > 0.0)
    return StretchRule(stretch, share)
