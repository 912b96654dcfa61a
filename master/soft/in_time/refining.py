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

from master.outcome import Progress, outcome, unheard
from master.soft.in_time.ageing import AgeingMemory
from master.soft.in_time.carried import Allowed, Carried, TooLongError
from master.soft.in_time.grains import GrainMemory
from master.soft.in_time.memory import MeanRateMemory, Memory
from master.soft.in_time.pulled import Pulled
from master.soft.in_time.track import pieces, reached, read
from master.soft.slips import Followed, Slips
from master.solution import Solution
from origins import Contacts, Drive
from origins.errors import refuse

Array = npt.NDArray[np.float64]

# Two positions of the drive nearer than this, in mean thresholds, count as equal.
SAME = 1e-12
# Most steps, and most operations in them, which take a minute or less.
MOST_STEPS, MOST_WORK = 6e3, 1e9
# Accuracy of a step's balance, as a share of the step: this share of the tolerance, between limits.
CLOSE, CLOSEST = 1e-2, (1e-10, 1e-6)
# Factor on the last change of extrapolated answers: changes fall irregularly where births jump or P_c
# bends, and by a half with growing thresholds; it is 1 with ageing, whose method is of third order.
MARGIN = 2.0


def memory_of(contacts: Contacts, level: int, fastest: float) -> Memory:
    """The memory of contacts on a drive of at most this speed; its meshes are halved with each level."""
    if contacts.ageing is not None:
        return AgeingMemory(contacts, level, fastest)
    if contacts.grains is not None:
        return GrainMemory(contacts, level)
    if contacts.thermal is not None and contacts.thermal.closure == "paper":
        return MeanRateMemory(contacts)
    return Memory(contacts, level)


def balance_of(contacts: Contacts, drive: Drive) -> float:
    """X_T = F(0)/K, where the drive begins (a length); refuses a path in time that begins elsewhere."""
    start = Carried(contacts, memory_of(contacts, 0, 1.0), 0, Allowed(0.0, 0.0))
    balance = start.force / float(drive.spring or 0.0)
    if abs(drive.path[0] - balance) <= SAME * contacts.mean_threshold:
        return float(drive.path[0])  # the difference is rounding
    if drive.time is not None and drive.time[0] == 0.0:
        rule = f"at time 0 the drive stands where it balances the start, {balance:.9g}"
        refuse("path[0]", drive.path[0], rule)
    return balance


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

    Raises InputError where the coarsest steps take too long.
    """
    course, asked = pieces(drive, balance), reached(drive, balance)
    fastest, spring = max((one.speed for one in course), default=0.0), float(drive.spring or 0.0)
    answers, best, plan = Answers(contacts, drive, balance), None, list[float]()
    close = float(np.clip(CLOSE * tolerance, *CLOSEST))
    for level in count():
        memory = memory_of(contacts, level, fastest)
        # an error estimate needs three levels with the same number of slips
        share = 0.5 ** max(2 - level, 0)
        allowed = Allowed(MOST_STEPS * share, MOST_WORK * share**2, until)
        here = Carried(contacts, memory, level, allowed)
        pulled = Pulled(here, drive, course, close, level, plan)
        try:
            pulled.run()
        except TooLongError as why:
            if best is not None:
                return best._replace(reason=str(why))
            if time.monotonic() <= until:
                refuse("path[-1]", drive.path[-1], f"{why}; end the path sooner")
            return answers.add(pulled, asked[asked <= here.now], np.inf)
        stiff = spring if pulled.slips else min(spring, 1.0)
        # round-off of the force grows with the number of steps
        rounding = 1e-13 * (1.0 + here.steps) * (1.0 + stiff)
        found = answers.add(pulled, asked, memory.error + rounding)
        progress(found.error)
        if best is None or found.error <= best.error:
            best = found
        # the next level takes twice the steps, each of which has twice the strands
        too_many = 2.0 * here.steps > MOST_STEPS or 4.0 * here.work > MOST_WORK
        if best.error <= tolerance or found.error < 2.0 * memory.error or too_many:
            told = f"error estimate {best.error:.1e} with {best.nodes} steps"
            told += f", above the tolerance {tolerance:.1e}"
            return best._replace(reason=f"{told}; shorten the path or loosen the tolerance")
        plan = pulled.stretches
    raise AssertionError


def solve_given(
    contacts: Contacts,
    drive: Drive,
    tolerance: float,
    progress: Progress = unheard,
    wall_time: float | None = None,
) -> Solution:
    """Force on a rigid slider, with steps halved until the tolerance is reached; see `solve`.

    It is used for growing grains with heat on paths that turn or hold. The slider is taken as one on
    a spring so stiff that it follows the drive.

    Raises InputError where a path takes too many steps.
    """
    began = time.perf_counter()
    until = np.inf if wall_time is None else time.monotonic() + wall_time
    # K/(N_c <k>) = 1e10: the slider is nearly rigid, with an error F/K of X
    stiff = Drive(drive.path, drive.velocity, drive.time, 1e10, drive.slip)
    found = refined(contacts, stiff, 0.0, tolerance, progress, until)
    end = drive.path[: found.force.size]
    success, message = outcome(contacts, found.error, tolerance, found.reason)
    if end.size < drive.path.size:
        last = f"X = {end[-1]:.6g}" if end.size else "the first point"
        success, message = False, f"stopped at {last} by wall_time; the path is cut there"
    times = reached(drive, 0.0)[: end.size]
    return Solution(
        path=end,
        force=found.force,
        time=times,
        force_error=found.error,
        holding=found.holding,
        run_time=time.perf_counter() - began,
        nodes=found.nodes,
        success=success,
        message=message,
        _march=None,
        _by_index=True,
        _moments=times,
    )


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
        better = answer[2 * n :].reshape(slips.shape) / scale
        return Followed(
            balance=self._balance,
            position=path - force * unit / self._spring,
            force=force * unit,
            holding=holding,
            slips=Slips.of(list(better.T), error * unit / self._spring),
            error=error,
            nodes=here.steps,
            over="by wall_time",
        )


def _beside(path: Array, before: Array, now: Array) -> npt.NDArray[np.bool_]:
    """Points of the path that the change of a slip moves across it, or nearly so."""
    apart, crossed = path[:, None] - now, (path[:, None] < now) != (path[:, None] < before)
    return np.asarray(((np.abs(apart) <= np.abs(now - before)) | crossed).any(axis=1))
