"""Any path in time: collocation on panels (master.on_panels), or for contacts whose thresholds grow steps halved until
the force along it, extrapolated, changes by less than the tolerance."""

import time as clocks
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from master._old.collocation import Course
from master._old.forward import ROUND_OFF, estimate
from master._old.jumps import jumps
from master._old.lives import Lives
from master._old.make_lives import make_lives, prepare
from master._old.marching import March, lagrange, march
from master._old.moment import MomentDistribution, distribution_at
from master._old.on_panels import follow, too_long
from master._old.timeline import Part, beside, marks, parts, pieces, times
from master.outcome import Progress, outcome, unheard
from origins import Contacts, Drive, InputError
from origins.brief import brief
from origins.errors import refuse

Array = npt.NDArray[np.float64]

_COARSE = 0.5  # of the length over which births change
_PER_FOLD = 2.0
_MOST_STEPS = 6_000
_MOST_WORK = 8e8
_TRIED, _FALLS = 3, 0.8  # halvings, and what each leaves at most, or what is not resolved will not be
_STENCIL = 6
_WATCH = 5
_LOW, _FELT = 0.1, 1e-6


@dataclass(frozen=True)
class TimedSolution:
    """F along a path in time, with the error it is good to.

    Attributes
    ----------
    path, time : arrays of shape (n,)
        Slider positions X (lengths), and when they are reached.
    force : array of shape (n,)
        F/(N_c <k>), the mean stretch of the contacts (a length).
    force_error : float
        Bound on the largest error of `force` over the path, in units of the mean threshold.
    holding : array of shape (n,)
        Fraction of contacts that hold: 1 but with a delay.
    run_time : float
        Seconds that the solution took, compilation not counted.
    nodes : int
        Points in time of the finest solution.
    success : bool
        Whether force_error is at or below the tolerance asked for.
    message : str
        In words: what was reached, or why not; what was cut off from the start.
    """

    path: Array
    time: Array
    force: Array
    force_error: float
    holding: Array
    run_time: float
    nodes: int
    success: bool
    message: str
    _contacts: Contacts = field(repr=False)
    _drive: Drive = field(repr=False)
    _course: Course | None = field(repr=False)

    __repr__ = brief

    def distribution(self, point: int) -> MomentDistribution:
        """Q(x;X) at one point of the path, told by its index as X may be passed often; X stands still in a hold.

        InputError where there is no such point, for contacts that age, and where they form again at many stretches.
        """
        if self._contacts.ageing is not None or self._contacts.grains is not None:
            raise InputError("contacts.ageing, .grains: Q(x;X) is not known along paths in time yet where contacts age")
        if isinstance(point, bool) or not isinstance(point, int | np.integer) or not 0 <= point < self.path.size:
            refuse("point", point, f"must be the index of a point of the path, 0 to {self.path.size - 1}")
        if self._course is None:
            raise InputError("path: the slider never moves and no time passes; Q(x;X) is that of the start")
        time, place = float(self.time[point]), float(self.path[point])
        return distribution_at(self._contacts, self._course, pieces(self._drive), time, place)


def solve_timed(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress = unheard
) -> TimedSolution:
    """Force on a rigid slider that moves as the drive says, for contacts with any laws; arguments checked before.

    On panels of eight nodes, cut up where breaks change fast; for contacts whose thresholds grow by marches of second
    order in the step, on steps halved again and again; what they tell is extrapolated to step 0.
    """
    prepare(contacts)
    began = clocks.perf_counter()
    asked = times(drive)
    path: Course | None = None
    if contacts.grains is None:
        found = follow(contacts, drive, tolerance, progress)
        force, holding, error, nodes, message = found.force, found.holding, found.error, found.nodes, found.message
        path = found.course
    else:
        force, holding, error, nodes, message = _refine(contacts, drive, asked, tolerance, progress)
    success, message = outcome(contacts, error, tolerance, message)
    return TimedSolution(
        path=drive.path,
        time=asked,
        force=force,
        force_error=error,
        holding=holding,
        run_time=clocks.perf_counter() - began,
        nodes=nodes,
        success=success,
        message=message,
        _contacts=contacts,
        _drive=drive,
        _course=path,
    )


def _refine(
    contacts: Contacts, drive: Drive, asked: Array, tolerance: float, progress: Progress
) -> tuple[Array, Array, float, int, str]:
    unit, delay = contacts.mean_threshold, contacts.waiting_time
    course = pieces(drive)
    if not course:
        lives = make_lives(contacts)
        return np.full(asked.size, lives.pull[0]), np.full(asked.size, lives.held[0]), lives.error, 0, ""
    lives = make_lives(contacts)
    lone = [contacts.start.mean()] if contacts.start.is_single else []
    again = 0.0 if contacts.reforming is None else contacts.reforming.law.mean()
    limits = np.append(contacts.thresholds.breakpoints, contacts.thresholds.atoms[0])
    atoms = contacts.thresholds.atoms[0]
    sharp = jumps(course, lone, again, atoms, delay)
    steps = parts(
        course,
        beside(marks(course, lone, again, limits, delay), [one.time for one in sharp or []], course[-1].end),
        _COARSE * lives.length,
        lives.time,
        lives.rate / _COARSE,
        _PER_FOLD,
    )
    needed, most = sum(part.steps for part in steps), most_steps(lives)
    if needed > most:
        too_long(contacts, course, needed, f"{most:,} are the most", lives.rate)
    watch = np.concatenate([part.clock(np.arange(1, _WATCH) / _WATCH) for part in steps])
    everywhere = np.concatenate([asked, watch])
    scale = np.concatenate([np.full(everywhere.size, unit), np.ones(everywhere.size)])
    table = Extrapolation(uneven(contacts))
    best: tuple[float, Array, int] = np.inf, np.empty(0), 0
    level, unknown = 0, np.inf
    while True:
        finer = [part.finer(level) for part in steps]
        count = sum(part.steps for part in finer)
        if level and count > most_steps(lives):
            break
        if level:
            lives = make_lives(contacts, level)
        found = march(lives, finer, delay)
        error, answer = table.add(np.concatenate([at(found, finer, row, everywhere) for row in _ROWS]) / scale)
        error += ROUND_OFF * (1.0 + count) + lives.error
        unknown, before = found.unresolved / unit, unknown
        error = max(error, unknown)
        if sharp is None:
            error = np.inf
        progress(error)
        if error < best[0] or not level:
            best = error, answer, count
        lost = level >= _TRIED and unknown > max(tolerance, _FALLS * before)
        if best[0] <= tolerance or error < 2.0 * lives.error or lost:
            break
        level += 1
    error, answer, count = best
    here = answer.reshape(2, -1)[:, : asked.size]
    reached = f"error estimate {error:.1e} with {count} steps, above the tolerance {tolerance:.1e}"
    return here[0] * unit, here[1], error, count, f"{reached}; loosen the tolerance, or end the path sooner"


def most_steps(lives: Lives) -> int:
    """As many as take a minute or less: every step asks all cohorts born before."""
    return int(min(_MOST_STEPS, (_MOST_WORK / lives.work) ** 0.5))


def uneven(contacts: Contacts) -> bool:
    """Whether P_c jumps or bends, also where it begins at 0, so that births do."""
    law = contacts.thresholds
    begins = law.support()[0] == 0.0 and float(law.cdf(_LOW * contacts.mean_threshold)) > _FELT
    return begins or law.atoms[0].size > 0 or bool((law.breakpoints > 0.0).any()) or not law.knows_breakpoints


class Extrapolation:
    """Answers on steps halved each time, whose errors are series in the square of the step (Romberg's table).

    uneven : whether errors may fall in another way, as `uneven` tells; then the last change is taken as the error.
    """

    def __init__(self, uneven: bool) -> None:
        self._uneven = uneven
        self._rows: list[list[Array]] = []
        self._changes: list[float] = []

    def add(self, answer: Array, watched: npt.NDArray[np.bool_] | slice = slice(None)) -> tuple[float, Array]:
        """Error estimate and best answer, `answer` being the one on the finest steps; of `watched` ones alone."""
        row = [answer]
        before = self._rows[-1] if self._rows else []
        for k, coarse in enumerate(before[:_COLUMNS]):
            row.append(row[k] + (row[k] - coarse) / (4.0 ** (k + 1) - 1.0))
        self._rows.append(row)
        best, error = answer, np.inf
        changes: list[float] = []
        even = False
        for k, coarse in enumerate(before):
            changes.append(float(np.abs((row[k] - coarse)[watched]).max(initial=0.0)))
            last = self._changes[k] if k < len(self._changes) else np.inf
            # the answers themselves fall as the square of the step: those extrapolated do so faster
            even |= k == 0 and changes[0] < _EVEN * last < np.inf
            if k > 0 and np.isfinite(changes[k]):
                # of two answers of one order the finer is better by far, where they are seen to fall
                if self._uneven:
                    left = changes[k]
                elif np.isfinite(last):
                    left = estimate(changes[k], last, _LEAST, False)
                else:
                    left = changes[k] * (_FIRST if even else 1.0)
                if left < error:
                    best, error = row[k], left
        self._changes = changes
        return error, best


_COLUMNS = 2
_LEAST, _FIRST, _EVEN = 1.0 / 8.0, 1.0 / 4.0, 0.27


def at(found: March, steps: list[Part], row: str, asked: Array) -> Array:
    """A row of the march at the times asked for, from the steps around."""
    values = getattr(found, row)
    ends = np.array([part.end for part in steps])
    firsts = np.concatenate([[0], np.cumsum([part.steps for part in steps])])
    out = np.empty(asked.size)
    which = np.minimum(np.searchsorted(ends, asked, side="left"), len(steps) - 1)
    for number in np.unique(which):
        part, mine = steps[number], which == number
        if part.whole:  # a contact whose stretch has reached its threshold is broken
            out[mine] = values[firsts[number + 1]]
            continue
        place = part.share(asked[mine]) * part.steps
        size = min(_STENCIL, part.steps + 1)
        low = np.clip(np.round(place).astype(int) - size // 2, 0, part.steps + 1 - size)
        nodes = low[:, None] + np.arange(size)
        out[mine] = (_weights(place - low, size) * values[firsts[number] + nodes]).sum(axis=1)
    return out


def _weights(at: Array, size: int) -> Array:
    nodes = np.arange(size, dtype=float)
    return np.stack([lagrange(nodes, float(one)) for one in at])


_ROWS = ("force", "holding")
