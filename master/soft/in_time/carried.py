"""Carried: all contacts of a slider on its way, trial steps, and the steps taken.

With J(t) the births per contact since t = 0, B(t) the breaks, and E(t, s) the survival of contacts
born at s, number conservation says

    G_0(t) + integral of E(t, s) dJ(s) + [B(t) - J(t)] = 1,        J(t) = B(t - delay).

Within a step the rate of births is taken as constant: the integral becomes a sum over steps with
means of E, of second order in the step.
"""

from __future__ import annotations

import time as clock
from typing import NamedTuple

import numpy as np

from master.soft.in_time.cohorts import Cohorts

# Points of the polynomial that interpolates the breaks of one delay before.
STENCIL = 4


class TooLongError(Exception):
    """The solution has reached its limit of work or time."""


class Allowed(NamedTuple):
    """Limits: of steps, of the work in all of them, and a reading of time.monotonic()."""

    steps: float
    work: float
    until: float = np.inf


class Trial(NamedTuple):
    """A step that is not taken yet: its travel, its end in time, and the state it leads to.

    force : F/(N_c <k>) (a length); holding : share of the contacts
    breaks, births : per contact since t = 0
    """

    travel: float
    now: float
    cohorts: Cohorts
    force: float
    holding: float
    breaks: float
    births: float


class Pending(NamedTuple):
    """A time at which births bend, and a share of the contacts, possibly 0, is born at once."""

    at: float
    weight: float


class Carried:
    """Contacts on a slider, from X = 0 and t = 0 on, which re-form one delay after they break.

    Attributes
    ----------
    place, now, force, holding : float
        X (a length), the time, F/(N_c <k>) (a length), and the share of the contacts that holds.
    pending : list of Pending
    steps : int
        Number of steps taken so far.
    work : float
        Operations in them: evaluated cohorts times the cost of each.
    unresolved : float
        Bound on the force (a length) of contacts whose share that holds the steps do not resolve.
    """

    def __init__(self, cohorts: Cohorts, delay: float, allowed: Allowed) -> None:
        self.delay, self._allowed = delay, allowed
        self.steps, self.work, self.unresolved = 0, 0.0, 0.0
        self.place, self.now = 0.0, 0.0
        self.settle(cohorts)

    def settle(self, cohorts: Cohorts) -> None:
        """Begin with these contacts, and no breaks and births before."""
        self.holding, self.force = cohorts.left[:, 0].tolist()
        self.cohorts, self._last = cohorts.born(0.0), (0.0, 0.0)
        # ends of steps, with breaks and births up to there; and bends, across which no polynomial goes
        self._times, self._bends = [self.now], [0]
        self._breaks, self._births = [0.0], [0.0]
        self.pending: list[Pending] = []

    @property
    def breaks(self) -> float:
        """Breaks per contact since t = 0."""
        return self._breaks[-1]

    def tried(self, travel: float, now: float, frozen: bool = False) -> Trial:
        """A trial step by `travel` until `now`; where `frozen`, without births."""
        duration, before = now - self.now, self._births[-1]
        cohorts = self.cohorts.advance(travel, duration).born(self._speed(travel, duration))
        frozen |= bool(self.delay) and now == self.now
        slope, rest = (0.0, before) if frozen else self._births_at(now)
        between = cohorts.between()
        known, force = (cohorts.left[:, 0] + between[:, :-1] @ np.diff(self._births)).tolist()
        last, pull = between[:, -1].tolist()
        # known + last (J - J_before) + B - J = 1, J = slope B + rest
        breaks = (1.0 - known + last * before + (1.0 - last) * rest) / (1.0 - (1.0 - last) * slope)
        new = slope * breaks + rest - before
        force, held = force + pull * new, known + last * new
        return Trial(travel, now, cohorts, force, held, breaks, before + new)

    def _births_at(self, now: float) -> tuple[float, float]:
        """Births up to a later moment, as a linear function of the breaks B up to then: (slope, rest)."""
        if not self.delay:
            return 1.0, 0.0
        times = np.array([*self._times, now])
        # the delay is prolonged by 1e-13 of the time, so that births at one moment do not come early
        at = now - self.delay - 1e-13 * (now - times[0])
        if at <= times[0]:
            return 0.0, 0.0
        last = times.size - 1
        cell = int(np.searchsorted(times, at, side="left"))
        bends = np.array([*self._bends, last])
        part = int(np.searchsorted(bends, cell, side="left"))
        low, high = int(bends[part - 1]), min(int(bends[part]), last)
        begin = min(max(cell - STENCIL // 2, low), max(high - STENCIL + 1, low))
        nodes = np.arange(begin, min(begin + STENCIL - 1, high) + 1)
        # births at one moment are stored as two nodes at one time
        nodes = nodes[np.append(np.diff(times[nodes]) > 0.0, True)]
        weights = _lagrange(times[nodes], at)
        known = np.array([*self._breaks, 0.0])[nodes]
        return float(weights[-1]) if nodes[-1] == last else 0.0, float(weights @ known)

    def _speed(self, travel: float, duration: float) -> float:
        """|dX/dt| at the end of a step, from the mean speeds of this step and of the last."""
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
        self.work += np.count_nonzero(trial.cohorts.left[0]) * trial.cohorts.work
        if self.steps > self._allowed.steps or self.work > self._allowed.work:
            done = f"{self.steps - 1} steps led to a time of {self.now:.4g} only"
            raise TooLongError(f"{done}, and more are not taken on")
        if clock.monotonic() > self._allowed.until:
            raise TooLongError("stopped by wall_time")
        self._last = trial.travel, trial.now - self.now
        self.place, self.now = self.place + trial.travel, trial.now
        self.cohorts, self.force, self.holding = trial.cohorts, trial.force, trial.holding
        self._add(trial.breaks, trial.births)
        held, pull = self.cohorts.left[:, 1:]
        # a step is unresolved if the survival of its first births is less than half that of its
        # last: then it is unknown how many of the births in between hold
        apart = np.where(held[:-1] < 0.5 * held[1:], 0.5 * np.abs(np.diff(pull)), 0.0)
        self.unresolved = max(self.unresolved, float(apart @ np.abs(np.diff(self._births))))

    def _add(self, breaks: float, births: float) -> None:
        self._times.append(self.now)
        self._breaks.append(breaks)
        self._births.append(births)

    def born_at_once(self, weight: float) -> None:
        """Add a finite share that is born at one moment: two births without time between."""
        self.bend()
        self.cohorts = self.cohorts.born(0.0)
        held, pull = self.cohorts.between()[:, -1].tolist()
        self.force += pull * weight
        self.holding += held * weight
        self._add(self.breaks, self._births[-1] + weight)
        self.bend()

    def bend(self) -> None:
        """Breaks may bend or jump at this moment: no polynomial goes across it."""
        self._bends.append(len(self._times) - 1)
        self._last = 0.0, 0.0

    def mark_later(self, at: float, weight: float = 0.0) -> None:
        """A bend or jump of the breaks, by a share `weight`, is repeated by births one delay later."""
        if self.delay:
            again = Pending(at + self.delay, weight), Pending(at + 2.0 * self.delay, 0.0)
            self.pending += again

    def born_now(self) -> None:
        """Let all contacts that are due be born."""
        weight = sum(one.weight for one in self.pending if one.at <= self.now)
        self.pending = [one for one in self.pending if one.at > self.now]
        if weight > 0.0:
            self.born_at_once(weight)


def _lagrange(nodes: np.ndarray, at: float) -> np.ndarray:
    """Weights of values at nodes (n,) in the polynomial through them, at a point."""
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    ways = np.tile(at - nodes, (nodes.size, 1))
    np.fill_diagonal(ways, 1.0)
    return np.asarray((ways / apart).prod(axis=1))
