"""Refining: the whole way on steps halved each time, and what follows of the answers."""

from __future__ import annotations

import time
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.outcome import Progress
from master.soft.in_time.carried import Allowed, TooLongError
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.make import Maker
from master.soft.in_time.pulled import Pulled, Task
from master.soft.in_time.rigid import Given
from master.soft.in_time.track import Piece, Read, Track, pieces
from origins import Contacts, Drive
from origins.errors import refuse

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Steps, and numbers looked at in all of them: these take a minute or less.
MOST_STEPS, MOST_WORK = 6e3, 1e9
# Share of the most steps that a next level may need, lest it ends before it is done.
FULL = 0.7
# Halvings until there is an error; and the most where slips come and go, with so much more work.
TELLING, LAST, MORE = 2, 4, 1.25
# Of the tolerance, the share of a step to which its balance is found; no less and no more than.
CLOSE, CLOSEST = 1e-2, (1e-10, 1e-6)
# Breaks per mean threshold of the drive's way beyond which contacts are far hotter than it is fast.
OFTEN = 5.0
# Round-off of the force for each step, in mean thresholds.
ROUND_OFF = 1e-13
# Thresholds near 0 are felt where more of them than this lie below a tenth of the mean.
LOW, FELT = 0.1, 1e-6
# Extrapolations of one answer: each takes one more power of the square of the step away.
COLUMNS = 2
# Shares of the last change that are left at least: of three answers, and of two that are seen to
# fall as the square of the step (a ratio of a quarter, and a little more).
LEAST_LEFT, FIRST_LEFT, EVEN = 1.0 / 8.0, 1.0 / 4.0, 0.27
# Margin on the ratio at which changes fall; a ratio above 1 is chance and tells nothing.
MARGIN, BY_CHANCE = 4.0, 8.0


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
    asked: Array,
    tolerance: float,
    progress: Progress,
    until: float,
) -> Refined:
    """Slips, and force and holding at the times asked for, on finer and finer steps.

    until : reading of time.monotonic() at which to stop with what there is
    """
    unit, spring = contacts.mean_threshold, float(drive.spring or 0.0)
    course = pieces(drive, balance)
    cohorts = maker.all(0)
    if not course:
        stands = [np.full(asked.size, row[0]) for row in (cohorts.pull, cohorts.held)]
        return Refined(np.empty((5, 0)), stands[0], stands[1], cohorts.error, 0, "")
    levels = Levels(unit, spring, drive.path, uneven(contacts))
    close = float(np.clip(CLOSE * tolerance, *CLOSEST))
    plan: list[float] = []
    finer = maker.all(1)
    # an error takes steps of three sizes
    grown = max(maker.all(TELLING).work / cohorts.work, 1.0) ** (1.0 / TELLING)
    most = FULL * MOST_STEPS * 0.5**TELLING, FULL**2 * MOST_WORK * (0.25 / grown) ** TELLING
    level = 0
    while True:

        def again(level: int = level) -> Cohorts:
            return maker.fresh(level)

        task = Task(course, spring, drive.slip, contacts.waiting_time, unit, again, close)
        kind = Pulled if spring else Given
        pulled = kind(cohorts, task, level, plan, Allowed(*most, until))
        here = pulled.contacts
        try:
            pulled.run()
        except TooLongError as why:
            reason = str(why) or "no steps were found that follow the slider"
            if levels.best is not None:
                return levels.best._replace(reason=reason)
            if time.monotonic() <= until:
                hot = _hot(contacts, cohorts, course)
                refuse("path[-1]", drive.path[-1], f"{reason}; {hot}end the path sooner")
            reached = asked[asked <= here.now]
            return levels.add(pulled, reached, np.inf)._replace(reason=reason)
        plan = pulled.stretches
        error = cohorts.error + ROUND_OFF * (1.0 + here.steps) * (
            1.0 + (spring if pulled.slips else min(spring, 1.0))
        )
        found = levels.add(pulled, asked, error)
        progress(levels.error)
        # coarse steps may find slips that finer ones do not: then there is no error yet
        untold = not np.isfinite(found.error) and levels.alike <= TELLING and level < LAST
        # twice as many, each with twice as many cohorts
        more = 2.0 * here.steps, 4.0 * here.work * finer.work / cohorts.work
        too_many = more[0] > FULL * MOST_STEPS or more[1] > FULL**2 * MOST_WORK
        enough = found.error <= tolerance or levels.error < 2.0 * cohorts.error
        if enough or (too_many and not untold):
            reached_error = f"error estimate {found.error:.1e} with {found.steps} steps"
            told = f"{reached_error}, above the tolerance {tolerance:.1e}"
            return found._replace(reason=f"{told}; shorten the path or loosen the tolerance")
        cohorts, finer = finer, maker.all(level + 2)
        level += 1
        most = (2.0 * most[0], 4.0 * most[1] * grown)
        if level >= TELLING:
            most = MOST_STEPS, MOST_WORK
        if untold:
            most = max(most[0], MORE * more[0]), max(most[1], MORE**2 * more[1])


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

    def __init__(self, unit: float, spring: float, path: Array, rough: bool) -> None:
        self._unit, self._spring, self._path, self._rough = unit, spring, path, rough
        self._table, self._slips = Extrapolation(rough), list[Array]()
        self._last = np.empty((2, 0))
        self.best: Refined | None = None
        self.error = np.inf

    @property
    def alike(self) -> int:
        return len(self._slips)

    def add(self, pulled: Pulled | Given, asked: Array, beside: float) -> Refined:
        """The best of all levels so far; `beside` is what steps do not tell of the error."""
        unit, spring, here = self._unit, self._spring, pulled.contacts
        slips = np.array(pulled.slips).reshape(-1, 5).T
        force, holding = _read(pulled.tracks, asked)
        if self._slips and self._slips[-1].shape != slips.shape:
            self._table, self._slips = Extrapolation(self._rough), []
        self._slips.append(slips)
        count, n = slips.shape[1], asked.size
        near, crossed = self._beside_slips(self._path[:n])
        scale = np.array([spring, 1.0, 1.0, 1.0, 1.0])[:, None] / unit
        everything = np.concatenate([force / unit, holding, (slips * scale).ravel()])
        off = near | crossed
        watched = np.concatenate([~off, ~off, np.ones(5 * count, dtype=bool)])
        # where F + K X is flat X is not known as well
        watched[2 * n + count : 2 * n + 3 * count] = False
        error, answer = self._table.add(everything, watched)
        told = np.stack([force / unit, holding])
        by_two = told
        if off.any():
            # of these the last two levels tell, where both are on one side of the slip
            change = np.where(
                _swapped(self._path[:n], *(one[0] for one in self._slips[-2:])),
                0.0,
                (told - self._last) / 3.0,
            )
            by_two = told + change
            error = max(error, float(np.abs(change)[:, crossed & ~near].max(initial=0.0)))
        self._last = told
        self.error = max(error + beside, here.unresolved / unit)
        if self.best is None or self.error < self.best.error:
            best, holds = np.where(off, by_two, answer[: 2 * n].reshape(2, n))
            better = answer[2 * n :].reshape(5, count) / scale
            self.best = Refined(better, best * unit, holds, self.error, here.steps, "")
        return self.best

    def _beside_slips(self, path: Array) -> tuple[Mask, Mask]:
        """Points that a slip's own error takes to its other side, and those that coarser steps do.

        Of the first no error is told.
        """
        near, crossed = np.zeros((2, path.size), dtype=bool)
        for before, now in pairwise(self._slips[-3:]):
            apart = np.abs(path[:, None] - now[0])
            near = (apart <= np.abs(now[0] - before[0])).any(axis=1)
            crossed = crossed | _swapped(path, before[0], now[0])
        return near, crossed


class Extrapolation:
    """Answers on steps halved each time, whose errors are series in the square of the step (Romberg).

    uneven : whether errors may fall in another way: then the last change is taken as the error.
    """

    def __init__(self, uneven: bool) -> None:
        self._uneven = uneven
        self._row: list[Array] = []
        self._changes: list[float] = []

    def add(self, answer: Array, watched: Mask) -> tuple[float, Array]:
        """Error estimate, of those watched, and best answer; `answer` is that on the finest steps."""
        before, row = self._row, [answer]
        for k, coarse in enumerate(before[:COLUMNS]):
            row.append(row[k] + (row[k] - coarse) / (4.0 ** (k + 1) - 1.0))
        best, error, even = answer, np.inf, False
        changes: list[float] = []
        for k, coarse in enumerate(before):
            changes.append(float(np.abs((row[k] - coarse)[watched]).max(initial=0.0)))
            last = self._changes[k] if k < len(self._changes) else np.inf
            # the answers themselves fall as the square of the step: those extrapolated do so faster
            even |= k == 0 and changes[0] < EVEN * last < np.inf
            if k > 0:
                # of two answers of one order the finer is better by far, where they are seen to fall
                left = changes[k]
                if not self._uneven:
                    known = np.isfinite(last)
                    left *= _left(changes[k], last) if known else (FIRST_LEFT if even else 1.0)
                if left < error:
                    best, error = row[k], left
        self._row, self._changes = row, changes
        return error, best


def _swapped(path: Array, before: Array, now: Array) -> Mask:
    """Points of the path that were on the other side of a slip before."""
    return np.asarray(((path[:, None] < now) != (path[:, None] < before)).any(axis=1))


def _left(change: float, before: float) -> float:
    """Share of the last change that is left as error, from the one before."""
    ratio = change / before if before > 0.0 else 1.0
    if ratio > 1.0:
        return BY_CHANCE
    return max(MARGIN * ratio if ratio < 0.25 else 2.0, LEAST_LEFT)


def _read(tracks: list[Track], asked: Array) -> Read:
    """Force and holding at times; at a slip, after it."""
    ends = np.array([track.clock[-1] for track in tracks])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(tracks) - 1)
    out = Read(np.empty(asked.size), np.empty(asked.size))
    for k in np.unique(which):
        mine = which == k
        out.force[mine], out.holding[mine] = tracks[k].read(asked[mine])
    return out


def uneven(contacts: Contacts) -> bool:
    """Whether errors do not fall as powers of the squared step.

    As where P_c jumps or bends, also where it begins at 0, so that births do; and thresholds that
    age or grow are followed in steps of another order.
    """
    law = contacts.thresholds
    begins = law.support()[0] == 0.0 and float(law.cdf(LOW * contacts.mean_threshold)) > FELT
    bends = law.atoms[0].size > 0 or bool((law.breakpoints > 0.0).any())
    other = contacts.ageing is not None or contacts.grains is not None
    return begins or bends or other or not law.knows_breakpoints


def _hot(contacts: Contacts, cohorts: Cohorts, course: list[Piece]) -> str:
    """Why steps are so many, and what else to ask, where fresh contacts break far sooner than they
    are stretched."""
    fastest = max(abs(piece.travel) / piece.duration for piece in course)
    rate = cohorts.steps.rate
    if not rate * contacts.mean_threshold > OFTEN * fastest:
        return ""
    return (
        f"fresh contacts break within a time of {1.0 / rate:.1g}, long before they reach their "
        "thresholds, and F soon stays near F_k, which steady_state and kinetic_curve tell; ask "
        "these, or "
    )
