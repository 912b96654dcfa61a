"""Carried: all contacts of a slider on its way, what a step would lead to, and the step taken."""

from __future__ import annotations

import time as clock
from typing import NamedTuple

import numpy as np

from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.past import Counted, Line, Past, count, unknown

# Share of the length over which births change by which the slider moves to see how F changes.
BESIDE = 1e-4


class TooLongError(Exception):
    """The work or the time that a solution may take has come to its end."""


class Allowed(NamedTuple):
    """Steps, numbers looked at in all of them, and the reading of time.monotonic() at the end."""

    steps: float
    work: float
    until: float = np.inf


class Trial(NamedTuple):
    """A step that is not taken yet: how far and until when, and what it leads to."""

    travel: float
    now: float
    cohorts: Cohorts
    counted: Counted


class Carried:
    """Contacts on a slider at X = 0 and t = 0, which form again a delay after they break.

    Attributes
    ----------
    place, now : float
        X (a length) and the time.
    force : float
        F/(N_c <k>) (a length).
    holding : float
        Share of the contacts.
    """

    def __init__(self, cohorts: Cohorts, delay: float, allowed: Allowed) -> None:
        self.delay, self.allowed, self.length = delay, allowed, cohorts.steps.length
        self.steps, self.work, self.unresolved = 0, 0.0, 0.0
        self.place, self.now = 0.0, 0.0
        self.settle(cohorts)

    def settle(self, cohorts: Cohorts) -> None:
        """These contacts, and nothing before them."""
        self.force, self.holding = float(cohorts.pull[0]), float(cohorts.held[0])
        self.cohorts = cohorts.born(0.0)
        self.past, self._last = Past(self.delay, [self.now]), (0.0, 0.0)
        self.pending: list[tuple[float, float]] = []

    def tried(self, travel: float, now: float, frozen: bool = False) -> Trial:
        """The slider moves on by `travel` until `now`; where `frozen` none is born."""
        duration = now - self.now
        speed = self._speed(travel, duration)
        cohorts = self.cohorts.advance(travel, duration).born(speed)
        if frozen or (self.delay and now == self.now):
            births = Line(0.0, self.past.births[-1])
        else:
            births = self.past.births_at(now)
        return Trial(travel, now, cohorts, count(cohorts, self.past, births))

    def _speed(self, travel: float, duration: float) -> float:
        """|dX/dt| at the end of a step, from the mean of this one and of the last."""
        if duration <= 0.0:
            return np.inf if travel else 0.0
        mean, (way, time) = abs(travel) / duration, self._last
        if not way or travel * way <= 0.0 or time <= 0.0:
            return mean
        slower = (duration / travel - time / way) / (travel + way) * travel / duration * travel
        return mean / float(np.clip(1.0 + slower, 0.05, 2.0))

    def take(self, trial: Trial) -> None:
        """Take the step."""
        self.steps += 1
        self.work += np.count_nonzero(trial.cohorts.held) * trial.cohorts.work
        allowed = self.allowed
        if self.steps > allowed.steps or self.work > allowed.work:
            done = f"{self.steps - 1} steps led to a time of {self.now:.4g} only"
            raise TooLongError(f"{done}, and more are not taken on")
        if clock.monotonic() > allowed.until:
            raise TooLongError("stopped by wall_time")
        self._last = trial.travel, trial.now - self.now
        self.place, self.now = self.place + trial.travel, trial.now
        self.cohorts = trial.cohorts
        self.force, self.holding = trial.counted.force, trial.counted.holding
        self.past.add(self.now, trial.counted.breaks, trial.counted.births)
        self.unresolved = max(self.unresolved, unknown(self.cohorts, self.past))

    def born_at_once(self, weight: float, breaks: float) -> None:
        """A finite share is born where the slider stands: two births with nothing between."""
        self.bend()
        self.cohorts = self.cohorts.born(0.0)
        held, pull = self.cohorts.spread()
        self.force += float(pull[-1]) * weight
        self.holding += float(held[-1]) * weight
        self.past.add(self.now, breaks, self.past.births[-1] + weight)
        self.bend()

    def bend(self) -> None:
        """Breaks may bend or jump here: nothing is read across."""
        self.past.bends.append(len(self.past.times) - 1)
        self._last = 0.0, 0.0

    def mark_later(self, at: float, weight: float = 0.0) -> None:
        """What bends or jumps here, by a share of the contacts, does so again after the delay."""
        if self.delay:
            self.pending += [(at + self.delay, weight), (at + 2.0 * self.delay, 0.0)]

    def force_slope(self, sign: float, trial: Trial | None = None) -> float:
        """F'(X) in motion that takes no time, here or where a trial ends."""
        ahead = self if trial is None else self._after(trial)
        step = sign * BESIDE * self.length
        first, second = (ahead.tried(k * step, ahead.now).counted.force for k in (1, 2))
        return (2.0 * first - 0.5 * second - 1.5 * ahead.force) / step

    def _after(self, trial: Trial) -> Carried:
        """These contacts as they would be after a trial."""
        out, past = Carried.__new__(Carried), self.past
        out.__dict__.update(self.__dict__)
        out.cohorts, out.force, out.now = trial.cohorts, trial.counted.force, trial.now
        out.past = Past(
            past.delay,
            [*past.times, trial.now],
            [*past.breaks, trial.counted.breaks],
            [*past.births, trial.counted.births],
            past.bends,
        )
        return out
