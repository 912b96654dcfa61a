"""Slipping: what a slip does, which takes no time."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from master.soft.in_time.carried import Carried, TooLongError, Trial
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.secants import first_root
from master.soft.in_time.track import Piece
from origins.drive import SlipRule

# Share of the length over which births change that is a step on the coarsest level.
COARSEST = 0.5
# Steps of a search for the end of a slip, in lengths over which births change.
SCAN = 0.125
MOST_SLIPS = 20_000
# Share of a step by which a slip goes on at least.
LEAST_SLIP = 1e-4
# Accuracy of a slip's end: of the mean threshold.
ENDS = 1e-15


class Slip(NamedTuple):
    """Lengths, as in master.soft.slips.Slips."""

    drive: float
    before: float
    after: float
    force_before: float
    force_after: float


class Task(NamedTuple):
    """What is asked of a soft slider.

    pieces : of the drive; spring : K/(N_c <k>); rule : what a slip does
    delay : of the contacts; unit : mean threshold (a length)
    again : makes the contacts that a reset leaves
    close : share of a step to which its balance is found
    """

    pieces: list[Piece]
    spring: float
    rule: SlipRule
    delay: float
    unit: float
    again: Callable[[], Cohorts]
    close: float


class Slipping:
    """Slips of a slider, by the rule of its task.

    Parameters
    ----------
    contacts : Carried
    task : Task
    level, length
        Steps of 2^-level of this length.
    thin : bool
        Whether the weakest contacts break by themselves before they are met: a slip goes on for a
        mean threshold at least, as they hold again when they are pushed.
    """

    def __init__(
        self, contacts: Carried, task: Task, level: int, length: float, thin: bool
    ) -> None:
        self._contacts, self._task, self._level = contacts, task, level
        self._length, self._thin = length, thin

    @property
    def smooth(self) -> bool:
        """Whether contacts are born all along a slip, so that steps follow it."""
        return self._task.rule == "instant" and not self._task.delay

    def slip(self, drive: float, sign: float, planned: float) -> Slip:
        """The slider slips while the drive stands.

        planned : length of the slip in steps of the coarsest, as coarser steps found it, or 0
        """
        here = self._contacts
        before, force = here.place, here.force
        if self._task.rule == "reset":
            cohorts = self._task.again()
            here.place = drive - float(cohorts.pull[0]) / self._task.spring
            here.settle(cohorts)
        elif self.smooth:
            self._rush(drive, sign, planned)
        else:
            self._hold_out(drive, sign)
        return Slip(drive, before, here.place, force, here.force)

    def _rush(self, drive: float, sign: float, planned: float) -> None:
        """Contacts re-form at once, on to the first balance."""
        here = self._contacts
        steps = int(np.ceil(max(planned, 1e-6))) * 2**self._level
        share = planned / steps if planned else 0.5**self._level
        size = sign * self._length * share
        here.bend()
        begin, away = here.place, not self._thin
        while True:
            trial = here.tried(size, here.now)
            over = self._over(trial, drive, sign)
            if over >= 0.0 and (away or abs(here.place - begin) > self._task.unit):
                break
            away |= over < 0.0
            here.take(trial)
        low = 0.0 if here.place != begin else LEAST_SLIP * size
        here.take(self._ends(low, size, drive, sign, frozen=False))
        here.bend()

    def _hold_out(self, drive: float, sign: float) -> None:
        """Broken contacts stay out until the rest balance the spring."""
        here = self._contacts
        step = sign * SCAN * here.length * COARSEST
        low, high, away = LEAST_SLIP * step, step, not self._thin
        for _ in range(MOST_SLIPS):
            over = self._over(here.tried(high, here.now, frozen=True), drive, sign)
            if over >= 0.0 and (away or abs(high) > self._task.unit):
                break
            away |= over < 0.0
            low, high = high, high + step
        else:
            raise TooLongError
        broken = here.past.breaks[-1]
        here.bend()
        trial = self._ends(low, high, drive, sign, frozen=True)
        here.take(trial)
        here.bend()
        fresh = trial.counted.breaks - broken
        here.mark_later(here.now, fresh)
        if not here.delay:
            here.born_at_once(fresh, here.past.breaks[-1])

    def _over(self, trial: Trial, drive: float, sign: float) -> float:
        """By how much the force exceeds the spring's."""
        pulls = self._task.spring * (drive - self._contacts.place - trial.travel)
        return sign * (trial.counted.force - pulls)

    def _ends(self, low: float, high: float, drive: float, sign: float, frozen: bool) -> Trial:
        """Where the slider is caught, between a travel and one further on."""
        here = self._contacts

        def excess(travel: float) -> float:
            return self._over(here.tried(travel, here.now, frozen), drive, sign)

        travel = low
        if excess(low) < 0.0:
            travel = first_root(excess, low, high, ENDS * self._task.unit)
        return here.tried(travel, here.now, frozen)
