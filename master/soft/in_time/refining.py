"""Refining: the whole way on steps halved each time, and what follows of the answers.

The error is what answers extrapolated to steps of no length still change by, what the contacts'
memory errs by, what steps do not resolve, and rounding.
"""

from __future__ import annotations

import time
from itertools import count, pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.outcome import Progress
from master.soft.in_time.carried import Allowed, TooLongError
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.make import memory_of
from master.soft.in_time.pulled import Pulled, Task
from master.soft.in_time.track import pieces, reached, read
from origins import Contacts, Drive
from origins.errors import refuse

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Scales, and numbers looked at in all of them: these take a minute or less; so much more where slips
# come and go, and there is no error yet.
MOST_STEPS, MOST_WORK, MORE = 6e3, 1e9, 10.0
# Of the tolerance, the share of a step to which its balance is found; no less and no more than.
CLOSE, CLOSEST = 1e-2, (1e-10, 1e-6)
# Changes that fall by a quarter, or a little less, are those of answers that fall as the square of
# the step; of their extrapolations' change a quarter is left at most.
EVEN, LEFT = 0.27, 0.25


class Refined(NamedTuple):
    """What was found, all lengths but holding.

    slips : array of shape (5, m), rows as in Slip
    force, holding : arrays of shape (n,), at the times asked for that were reached
    error : of force and K X_T, in mean thresholds
    steps : int
    reason : why no finer steps were taken
    """

    slips: Array
    force: Array
    holding: Array
    error: float
    steps: int
    reason: str


def refined(
    contacts: Contacts,
    drive: Drive,
    balance: float,
    tolerance: float,
    progress: Progress,
    until: float,
) -> Refined:
    """Slips, and force and holding at the points of the path, on finer and finer steps.

    until : reading of time.monotonic() at which to stop with what there is
    """
    unit, course, asked = contacts.mean_threshold, pieces(drive, balance), reached(drive, balance)
    fastest, spring = (
        max((piece.speed for piece in course), default=0.0),
        float(drive.spring or 0.0),
    )
    memory = memory_of(contacts, 0, fastest)
    if not course:
        stands = [
            np.full(asked.size, value) for value in Cohorts.of(contacts, memory, 0).left[:, 0]
        ]
        return Refined(np.empty((5, 0)), stands[1], stands[0], memory.error, 0, "")
    answers, best = Answers(unit, spring, drive.path, left_over(contacts)), None
    close = float(np.clip(CLOSE * tolerance, *CLOSEST))
    plan: list[float] = []
    for level in count():
        cohorts, again = (Cohorts.of(contacts, memory, level, reset) for reset in (False, True))
        # there is an error from the second halving on
        share = 0.5 ** max(2 - level, 0)
        more = 1.0 if best is None or np.isfinite(best.error) else MORE
        allowed = Allowed(more * MOST_STEPS * share, more * MOST_WORK * share**2, until)
        task = Task(course, spring, drive.slip, contacts.waiting_time, unit, again, close)
        pulled = Pulled(cohorts, task, level, plan, allowed)
        here = pulled.contacts
        try:
            pulled.run()
        except TooLongError as why:
            reason = str(why) or "no steps were found that follow the slider"
            if best is not None:
                return best._replace(reason=reason)
            if time.monotonic() <= until:
                refuse("path[-1]", drive.path[-1], f"{reason}; end the path sooner")
            return answers.add(pulled, asked[asked <= here.now], np.inf)._replace(reason=reason)
        plan, known = pulled.stretches, memory.error
        stiff = spring if pulled.slips else min(spring, 1.0)
        # round-off of the force for each step, in mean thresholds
        rounding = 1e-13 * (1.0 + here.steps) * (1.0 + stiff)
        found = answers.add(pulled, asked, known + rounding)
        progress(found.error)
        if best is None or found.error <= best.error:
            best = found
        # coarse steps may find slips that finer ones do not: then there is no error yet
        more = 1.0 if np.isfinite(best.error) else MORE
        memory = memory_of(contacts, level + 1, fastest)
        finer = 4.0 * here.work * Cohorts.of(contacts, memory, level + 1).work / cohorts.work
        too_many = max(2.0 * here.steps / MOST_STEPS, finer / MOST_WORK) > more
        if best.error <= tolerance or found.error < 2.0 * known or too_many:
            told = f"error estimate {best.error:.1e} with {best.steps} steps"
            told += f", above the tolerance {tolerance:.1e}"
            return best._replace(reason=f"{told}; shorten the path or loosen the tolerance")
    raise AssertionError


class Answers:
    """The answers on steps halved each time, whose errors are series in the square of the step."""

    def __init__(self, unit: float, spring: float, path: Array, left: float) -> None:
        self._unit, self._spring, self._path, self._left = unit, spring, path, left
        self._told: list[Array] = []  # of the last levels, of as many slips each
        self._drives: list[Array] = []

    def add(self, pulled: Pulled, asked: Array, beside: float) -> Refined:
        """The answer of all levels so far; `beside` is what steps do not tell of the error."""
        unit, here = self._unit, pulled.contacts
        slips = np.array(pulled.slips).reshape(-1, 5).T
        m, n = slips.shape[1], asked.size
        if self._drives and self._drives[-1].size != m:
            self._told, self._drives = [], []
        scale = np.array([self._spring, 1.0, 1.0, 1.0, 1.0])[:, None] / unit
        force, holding = read(pulled.tracks, asked)
        told = np.concatenate([force / unit, holding, (slips * scale).ravel()])
        self._told, self._drives = [*self._told[-2:], told], [*self._drives[-2:], slips[0]]
        answer, error = told, np.inf
        if len(self._told) == 3:
            first, second = np.diff(self._told, axis=0)
            now, ever = self._beside_slips(self._path[:n])
            # where F + K X is flat, X before and after is not known as well
            known = np.repeat([True, False, False, True, True], m)
            watched = np.concatenate([~ever, ~ever, known])
            changes = [np.abs(one[watched]).max(initial=0.0) for one in (first, second)]
            even = changes[1] < EVEN * changes[0]
            steady = np.abs((second + (second - first) / 3.0)[watched]).max(initial=0.0)
            error = steady * (self._left if even else max(self._left, 1.0))
            # beside slips the last two levels tell, where both are on one side of the slip
            none = np.zeros(5 * m, dtype=bool)
            off, other = (np.concatenate([some, some, none]) for some in (now, ever & ~now))
            answer = told + np.where(off, 0.0, second / 3.0)
            error = max(error, float(np.abs(second[other] / 3.0).max(initial=0.0)))
        error = max(error + beside, here.unresolved / unit)
        force, holding = answer[: 2 * n].reshape(2, n)
        better = answer[2 * n :].reshape(5, m) / scale
        return Refined(better, force * unit, holding, error, here.steps, "")

    def _beside_slips(self, path: Array) -> tuple[Mask, Mask]:
        """Points that a slip's error, by its last change, takes to its other side; and by any of the
        last changes."""
        found = []
        for before, now in pairwise(self._drives):
            apart, crossed = path[:, None] - now, (path[:, None] < now) != (path[:, None] < before)
            found.append(((np.abs(apart) <= np.abs(now - before)) | crossed).any(axis=1))
        return found[-1], np.logical_or.reduce(found)


def left_over(contacts: Contacts) -> float:
    """Share of the last change of extrapolated answers that may be left as their error.

    Errors do not fall as powers of the squared step where P_c jumps or bends, also where it begins
    at 0, so that births do; and thresholds that age or grow are followed in steps of another order,
    the changes of those that grow falling slowly, by a half or less with each level.
    """
    law = contacts.thresholds
    if contacts.grains is not None:
        return 2.0
    begins = law.support()[0] == 0.0 and float(law.cdf(0.1 * contacts.mean_threshold)) > 1e-6
    bends = law.atoms[0].size > 0 or bool((law.breakpoints > 0.0).any())
    ages = contacts.ageing is not None
    return 1.0 if ages or begins or bends or not law.knows_breakpoints else LEFT
