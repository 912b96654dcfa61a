"""Refining: the whole path solved with steps halved each time, and extrapolated.

Errors of the answers are series in the square of the step. The error estimate is the last change of
the answers extrapolated to step 0, plus the error of the contacts' memory and rounding, or what the
steps do not resolve if that is larger.
"""

from __future__ import annotations

import time
from itertools import count, pairwise

import numpy as np
import numpy.typing as npt

from master.outcome import Progress
from master.soft.in_time.carried import Allowed, Carried, TooLongError
from master.soft.in_time.make import memory_of
from master.soft.in_time.pulled import Pulled, Task
from master.soft.in_time.track import pieces, reached, read
from master.soft.slips import Followed
from origins import Contacts, Drive
from origins.errors import refuse

Array = npt.NDArray[np.float64]

# Most steps, and most operations in them, which take a minute or less; MORE times as many where the
# number of slips still changes from level to level, so that there is no error estimate yet.
MOST_STEPS, MOST_WORK, MORE = 6e3, 1e9, 10.0
# Accuracy of a step's balance, as a share of the step: this share of the tolerance, between limits.
CLOSE, CLOSEST = 1e-2, (1e-10, 1e-6)
# Factor on the last change of extrapolated answers: changes fall irregularly where births jump or P_c
# bends, and by a half with growing thresholds; it is 1 with ageing, whose method is of third order.
MARGIN = 2.0


def refined(
    contacts: Contacts,
    drive: Drive,
    balance: float,
    tolerance: float,
    progress: Progress,
    until: float,
) -> Followed:
    """Slips, and force and holding at the points of the path, on finer and finer steps.

    until : reading of time.monotonic() at which to stop
    """
    unit, course, asked = contacts.mean_threshold, pieces(drive, balance), reached(drive, balance)
    fastest, spring = max((one.speed for one in course), default=0.0), float(drive.spring or 0.0)
    answers, best = Answers(contacts, drive, balance), None
    close = float(np.clip(CLOSE * tolerance, *CLOSEST))
    plan, before = list[float](), 0.0
    for level in count():
        memory = memory_of(contacts, level, fastest)
        # an error estimate needs three levels with the same number of slips
        share = 0.5 ** max(2 - level, 0)
        more = 1.0 if best is None or np.isfinite(best.error) else MORE
        allowed = Allowed(more * MOST_STEPS * share, more * MOST_WORK * share**2, until)
        task = Task(course, spring, drive.slip, unit, close)
        here = Carried(contacts, memory, level, allowed)
        pulled = Pulled(here, task, level, plan)
        try:
            pulled.run()
        except TooLongError as why:
            reason = str(why) or "no steps were found that follow the slider"
            if best is not None:
                return best._replace(reason=reason)
            if time.monotonic() <= until:
                refuse("path[-1]", drive.path[-1], f"{reason}; end the path sooner")
            return answers.add(pulled, asked[asked <= here.now], np.inf)._replace(reason=reason)
        stiff = spring if pulled.slips else min(spring, 1.0)
        # round-off of the force grows with the number of steps
        rounding = 1e-13 * (1.0 + here.steps) * (1.0 + stiff)
        found = answers.add(pulled, asked, memory.error + rounding)
        progress(found.error)
        if best is None or found.error <= best.error:
            best = found
        # the next level doubles the steps, and multiplies the work as this level did
        more = 1.0 if np.isfinite(best.error) else MORE
        work = here.work * max(here.work / before, 4.0) if before else 0.0
        too_many = max(2.0 * here.steps / MOST_STEPS, work / MOST_WORK) > more
        if best.error <= tolerance or found.error < 2.0 * memory.error or too_many:
            told = f"error estimate {best.error:.1e} with {best.nodes} steps"
            told += f", above the tolerance {tolerance:.1e}"
            return best._replace(reason=f"{told}; shorten the path or loosen the tolerance")
        plan, before = pulled.stretches, here.work
    raise AssertionError


class Answers:
    """The answers of all levels, and their extrapolation."""

    def __init__(self, contacts: Contacts, drive: Drive, balance: float) -> None:
        self._unit, self._spring = contacts.mean_threshold, float(drive.spring or 0.0)
        self._path, self._balance = drive.path, balance
        self._margin = 1.0 if contacts.ageing is not None else MARGIN
        self._told: list[Array] = []  # answers of the last levels with the same number of slips
        self._drives: list[Array] = []

    def add(self, pulled: Pulled, asked: Array, beside: float) -> Followed:
        """The answer of all levels so far; `beside` is the error that finer steps do not reduce."""
        unit, here, n = self._unit, pulled.contacts, asked.size
        path, slips = self._path[:n], np.array(pulled.slips).reshape(-1, 5).T
        scale = np.array([self._spring, 1.0, 1.0, 1.0, 1.0])[:, None] / unit
        force, holding = read(pulled.tracks, asked)
        told = np.concatenate([force / unit, holding, (slips * scale).ravel()])
        if self._told and self._told[-1].size != told.size:
            self._told, self._drives = [], []
        self._told, self._drives = [*self._told[-2:], told], [*self._drives[-2:], slips[0]]
        answer, error = told, np.inf
        if len(self._told) == 3:
            first, second = np.diff(self._told, axis=0)
            # points that the last change of a slip moves across it are left out of the error; where
            # only the change before did, the last two levels are used
            crossed = [_beside(path, *pair) for pair in pairwise(self._drives)]
            now, ever = crossed[1], crossed[0] | crossed[1]
            none = np.zeros(slips.size, dtype=bool)
            off, other = (np.concatenate([some, some, none]) for some in (now, ever & ~now))
            # X at slips is left out of the error: F + K X is flat there
            watched = ~(off | other)
            watched[2 * n :] = np.repeat([True, False, False, True, True], slips.shape[1])
            changes = np.abs((second + (second - first) / 3.0)[watched])
            error = self._margin * changes.max(initial=0.0)
            error = max(error, np.abs(second[other]).max(initial=0.0) / 3.0)
            answer = told + np.where(off, 0.0, second / 3.0)
        error = max(float(error) + beside, here.unresolved / unit)
        force, holding = answer[: 2 * n].reshape(2, n)
        better, force = answer[2 * n :].reshape(slips.shape) / scale, force * unit
        position, drive_error = path - force / self._spring, error * unit / self._spring
        found = self._balance, position, force, holding, better, drive_error, error
        return Followed(*found, here.steps, "", "by wall_time")


def _beside(path: Array, before: Array, now: Array) -> npt.NDArray[np.bool_]:
    """Points of the path that the change of a slip moves across it, or nearly so."""
    apart, crossed = path[:, None] - now, (path[:, None] < now) != (path[:, None] < before)
    return np.asarray(((np.abs(apart) <= np.abs(now - before)) | crossed).any(axis=1))
