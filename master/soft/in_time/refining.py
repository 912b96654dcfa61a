"""Refining: the whole way on steps halved each time, and what follows of the answers.

The error is what answers extrapolated to steps of no length (Romberg) still change by, what the
contacts' memory errs by, what steps do not resolve, and rounding.
"""

from __future__ import annotations

import time
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.outcome import Progress
from master.soft.in_time.carried import Allowed, TooLongError
from master.soft.in_time.make import Maker
from master.soft.in_time.pulled import Pulled, Task
from master.soft.in_time.track import Read, Track, pieces, reached
from origins import Contacts, Drive
from origins.errors import refuse

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Scales, and numbers looked at in all of them: these take a minute or less.
MOST_STEPS, MOST_WORK = 6e3, 1e9
# Halvings until there is an error; and the most where slips come and go, with so much more work.
TELLING, LAST, MORE = 2, 4, 1.5
# Of the tolerance, the share of a step to which its balance is found; no less and no more than.
CLOSE, CLOSEST = 1e-2, (1e-10, 1e-6)
# Round-off of the force for each step, in mean thresholds.
ROUND_OFF = 1e-13
# Thresholds near 0 are felt where more of them than this lie below a tenth of the mean.
LOW, FELT = 0.1, 1e-6
# Extrapolations of one answer: each takes one more power of the square of the step away.
COLUMNS = 2
# Changes that fall by a quarter, or a little less, are those of answers that fall as the square of
# the step; of their extrapolations' change a quarter is left at most; of one that falls slowly, by
# a half or less with each level, as much as twice.
EVEN, LEFT, SLOWLY = 0.27, 0.25, 2.0


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
    maker: Maker,
    drive: Drive,
    balance: float,
    tolerance: float,
    progress: Progress,
    until: float,
) -> Refined:
    """Slips, and force and holding at the points of the path, on finer and finer steps.

    drive : without a spring the slider is rigid
    until : reading of time.monotonic() at which to stop with what there is
    """
    unit, spring = contacts.mean_threshold, drive.spring or np.inf
    course, asked = pieces(drive, balance), reached(drive, balance)
    cohorts = maker.all(0)
    if not course:
        stands = [np.full(asked.size, row[0]) for row in (cohorts.pull, cohorts.held)]
        return Refined(np.empty((5, 0)), stands[0], stands[1], cohorts.memory.error, 0, "")
    # a rigid slider has no slips, whose X_T would count
    levels = Levels(unit, drive.spring or 1.0, drive.path, left_over(contacts))
    close, wait = float(np.clip(CLOSE * tolerance, *CLOSEST)), contacts.waiting_time
    plan: list[float] = []
    level, extra = 0, 1.0
    while True:
        task = Task(course, spring, drive.slip, wait, unit, partial(maker.all, level, True), close)
        share = 0.5 ** max(TELLING - level, 0)
        allowed = Allowed(extra * MOST_STEPS * share, extra * MOST_WORK * share**2, until)
        pulled = Pulled(cohorts, task, level, plan, allowed)
        here = pulled.contacts
        try:
            pulled.run()
        except TooLongError as why:
            reason = str(why) or "no steps were found that follow the slider"
            if levels.best is not None:
                return levels.best._replace(reason=reason)
            if time.monotonic() <= until:
                refuse("path[-1]", drive.path[-1], f"{reason}; end the path sooner")
            return levels.add(pulled, asked[asked <= here.now], np.inf)._replace(reason=reason)
        plan = pulled.stretches
        stiff = drive.spring or 0.0
        rounding = (
            ROUND_OFF * (1.0 + here.steps) * (1.0 + (stiff if pulled.slips else min(stiff, 1.0)))
        )
        known = cohorts.memory.error
        found = levels.add(pulled, asked, known + rounding)
        progress(levels.error)
        # coarse steps may find slips that finer ones do not: then there is no error yet
        untold = not np.isfinite(found.error) and levels.alike <= TELLING and level < LAST
        # twice as many, each with twice as many cohorts
        finer = maker.all(level + 1)
        more = (
            2.0 * here.steps / MOST_STEPS,
            4.0 * here.work * finer.work / cohorts.work / MOST_WORK,
        )
        too_many = max(more) > 1.0
        enough = found.error <= tolerance or levels.error < 2.0 * known
        if enough or (too_many and not untold):
            reached_error = f"error estimate {found.error:.1e} with {found.steps} steps"
            told = f"{reached_error}, above the tolerance {tolerance:.1e}"
            return found._replace(reason=f"{told}; shorten the path or loosen the tolerance")
        cohorts, level = finer, level + 1
        extra = max(1.0, MORE * max(more)) if untold else 1.0


class Levels:
    """The answers on the steps of all levels, and the best one.

    Attributes
    ----------
    best : Refined or None
    error : float
        That of the last level.
    alike : int
        The last levels that have as many slips.
    """

    def __init__(self, unit: float, spring: float, path: Array, left: float) -> None:
        self._unit, self._spring, self._path, self._left = unit, spring, path, left
        self._table, self._drives = Extrapolation(left), list[Array]()
        self._last = np.empty((2, 0))
        self.best: Refined | None = None
        self.error = np.inf

    @property
    def alike(self) -> int:
        return len(self._drives)

    def add(self, pulled: Pulled, asked: Array, beside: float) -> Refined:
        """The best of all levels so far; `beside` is what steps do not tell of the error."""
        unit, here = self._unit, pulled.contacts
        slips = np.array(pulled.slips).reshape(-1, 5).T
        force, holding = _read(pulled.tracks, asked)
        told = np.stack([force / unit, holding])
        if self._drives and self._drives[-1].size != slips.shape[1]:
            self._table, self._drives = Extrapolation(self._left), []
        self._drives.append(slips[0])
        count, n = slips.shape[1], asked.size
        scale = np.array([self._spring, 1.0, 1.0, 1.0, 1.0])[:, None] / unit
        everything = np.concatenate([told.ravel(), (slips * scale).ravel()])
        off, other = self._beside_slips(self._path[:n])
        # where F + K X is flat, X before and after is not known as well
        known = np.repeat([True, False, False, True, True], count)
        error, answer = self._table.add(everything, np.concatenate([~off, ~off, known]))
        holds, by_two = answer[: 2 * n].reshape(2, n), told
        if off.any():
            # of these the last two levels tell, where both are on one side of the slip
            change = np.where(other, 0.0, (told - self._last) / 3.0)
            by_two = told + change
            error = max(error, float(np.abs(change[:, off]).max()))
        self._last = told
        self.error = max(error + beside, here.unresolved / unit)
        if self.best is None or self.error < self.best.error:
            force, holding = np.where(off, by_two, holds)
            better = answer[2 * n :].reshape(5, count) / scale
            self.best = Refined(better, force * unit, holding, self.error, here.steps, "")
        return self.best

    def _beside_slips(self, path: Array) -> tuple[Mask, Mask]:
        """Points of which levels before may tell of the other side of a slip.

        And those that the slip's own error, by its last change, takes there: of them none tells.
        """
        off: Mask = np.zeros(path.size, dtype=bool)
        other: Mask = off
        for before, now in pairwise(self._drives[-3:]):
            apart = np.abs(path[:, None] - now)
            other = np.asarray((apart <= np.abs(now - before)).any(axis=1))
            crossed = ((path[:, None] < now) != (path[:, None] < before)).any(axis=1)
            other = other | crossed
            off = off | other
        return off, other


class Extrapolation:
    """Answers on steps halved each time, whose errors are series in the square of the step (Romberg).

    left : share of the last change that is left as error; where it is below 1, if answers are seen
        to fall as the square of the step.
    """

    def __init__(self, left: float) -> None:
        self._left = left
        self._row: list[Array] = []
        self._change = np.inf

    def add(self, answer: Array, watched: Mask) -> tuple[float, Array]:
        """Error estimate, of those watched, and best answer; `answer` is that on the finest steps."""
        before, row = self._row, [answer]
        for k, coarse in enumerate(before[:COLUMNS]):
            row.append(row[k] + (row[k] - coarse) / (4.0 ** (k + 1) - 1.0))
        changes = [
            float(np.abs((fine - coarse)[watched]).max(initial=0.0))
            for fine, coarse in zip(row, before, strict=False)
        ]
        best, error = answer, np.inf
        if len(changes) > 1:
            even = changes[0] < EVEN * self._change
            k = 1 + int(np.argmin(changes[1:]))
            best, error = row[k], changes[k] * (self._left if even else max(self._left, 1.0))
        self._row, self._change = row, changes[0] if changes else np.inf
        return error, best


def _read(tracks: list[Track], asked: Array) -> Read:
    """Force and holding at times; at a slip, after it."""
    ends = np.array([track.clock[-1] for track in tracks])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(tracks) - 1)
    out = Read(np.empty(asked.size), np.empty(asked.size))
    for k in np.unique(which):
        mine = which == k
        out.force[mine], out.holding[mine] = tracks[k].read(asked[mine])
    return out


def left_over(contacts: Contacts) -> float:
    """Share of the last change of extrapolated answers that may be left as their error.

    Errors do not fall as powers of the squared step where P_c jumps or bends, also where it begins
    at 0, so that births do; and thresholds that age or grow are followed in steps of another order,
    the changes of those that grow falling slowly.
    """
    law = contacts.thresholds
    if contacts.grains is not None:
        return SLOWLY
    begins = law.support()[0] == 0.0 and float(law.cdf(LOW * contacts.mean_threshold)) > FELT
    bends = law.atoms[0].size > 0 or bool((law.breakpoints > 0.0).any())
    ages = contacts.ageing is not None
    return 1.0 if ages or begins or bends or not law.knows_breakpoints else LEFT
