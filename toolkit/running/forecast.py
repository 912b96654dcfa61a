"""What a scene's solvers will take and give, told beforehand by small pilots of them."""

import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from eq_model import layout
from eq_model.histogram import no_counts
from origins.errors import InputError
from toolkit.running.blocks import follow
from toolkit.running.runner import make_ensemble, solve_master
from toolkit.scene.scene import EqTable, Scene

if TYPE_CHECKING:
    from eq_model import EnsembleResult

_FIRST, _GROWTH = (
    64,
    4,
)  # contacts of each rank in the first pilot, and how many times as many in the next
_LONG_ENOUGH = 0.05  # seconds of a pilot
_LOOSEST, _ENOUGH = (
    1e-2,
    1.0,
)  # tolerance of the first pilot of the master equation; seconds of all of them
_SPEED = 2.0  # other users, another clock rate, tables that leave the cache: a machine is this much faster or slower
_AFTERWARDS = 160.0  # MB at most for result files and pictures, once the ensemble is done
_COMPILED = 0.6  # of a pilot's peak, if it compiled what the run finds compiled
_SIGMAS = 4.0
_TAILS = 2.5  # variance of a variance, in units of its square: 0.5 for normal forces, more where some contacts differ


Seconds = Callable[["EnsembleResult", int], float]
"""How long an ensemble takes that has this result and followed so many blocks."""


@dataclass(frozen=True)
class Estimate:
    """A number and the range it is expected in."""

    value: float
    low: float
    high: float

    def times(self, other: "Estimate") -> "Estimate":
        """Both above zero and independent of each other."""
        return Estimate(self.value * other.value, self.low * other.low, self.high * other.high)

    def less(self, done: float) -> "Estimate":
        """What is left of it."""
        return Estimate(*(max(x - done, 0.0) for x in (self.value, self.low, self.high)))

    def after(self, ready: float) -> "Estimate":
        """And what it takes to get ready, of which no range is known."""
        return Estimate(self.value + ready, self.low, self.high + _SPEED * ready)


@dataclass(frozen=True)
class Forecast:
    """What the ensemble is expected to take and give.

    ranks : at work. contacts : to be followed, of `most`, `done` of them by an earlier run; breaks : of all of them.
    run_time : s, as of EnsembleResult, of those that are left.
    memory : MB of a rank at its peak. kept : MB of a rank's histograms, in its checkpoint.
    error : largest standard error of the force in mean thresholds; tolerance : that was asked for.
    pilot_contacts, pilot_time : of what tells this, s, compilation not counted.
    """

    ranks: int
    most: int
    done: int
    contacts: Estimate
    breaks: Estimate
    run_time: Estimate
    memory: Estimate
    kept: float
    error: Estimate
    tolerance: float | None
    wall_time: float | None
    pilot_contacts: int
    pilot_time: float


def forecast(
    scene: Scene, comm: Any = None, done: int = 0, seconds: Seconds | None = None
) -> Forecast:
    """Run pilots of the scene's ensemble, each larger than the one before, for some tenths of a second in all; `done`
    contacts need not be followed again.

    `seconds` says how long a pilot took, given its result and its number of blocks on this rank, so that the size of
    the pilots and the run time hang on their work alone; None: as the clock has it.

    All ranks of the communicator must call: they work at once, as they will. Raises InputError for a scene without
    [eq], and as a run does.
    """
    asked = scene.eq
    if asked is None:
        raise InputError("dry run: the scene has no [eq]; only an ensemble's work is foreseen so")
    ranks, most = 1 if comm is None else comm.Get_size(), asked.contacts * asked.replicas
    few = _follow_few(scene, asked, comm, min(ranks, most), seconds)
    # what a block takes whatever its contacts, above all its histograms, is no part of what contacts take
    each_block, ready, spent, n = few.blocks, few.ready, few.run_time, min(_FIRST * ranks, most)
    while True:
        few = _follow_few(scene, asked, comm, n, seconds)
        ready, spent = max(ready, few.ready), spent + few.run_time  # tables are made once
        found, aside = few.result, few.number * each_block
        largest = float(found.force_standard_error.max()) / scene.contacts.mean_threshold
        long_enough = few.blocks - aside > max(_LONG_ENOUGH, aside)
        if long_enough or _GROWTH * n > _followed(asked.tolerance, n, largest, few.whole):
            break
        n *= _GROWTH
    # before many have broken it is those few that differ
    off = min(_SIGMAS * math.sqrt(_TAILS / min(n, max(found.breaks, 1))), 0.9)
    of_n = Estimate(largest, largest * (1.0 - off), largest * (1.0 + off))
    errors = of_n.value, of_n.low, of_n.high
    contacts = Estimate(*(_followed(asked.tolerance, n, error, few.whole) for error in errors))
    cost = max(few.blocks - aside, 0.0) / n + each_block * few.whole.total / (ranks * most)
    each = Estimate(cost, cost / _SPEED, cost * _SPEED)
    counts = no_counts(scene.histogram_points().size, most).nbytes
    memory = _largest(comm, _peak())
    return Forecast(
        ranks=ranks,
        most=most,
        done=done,
        contacts=contacts,
        breaks=contacts.times(_each(scene, found.breaks / n, n)),
        run_time=contacts.less(done).times(each).after(ready + each_block + few.once),
        memory=Estimate(memory + 0.5 * _AFTERWARDS, _COMPILED * memory, memory + _AFTERWARDS),
        kept=counts / 1e6,
        error=Estimate(
            of_n.value * math.sqrt(n / contacts.value),
            of_n.low * math.sqrt(n / contacts.high),
            of_n.high * math.sqrt(n / contacts.low),
        ),
        tolerance=asked.tolerance,
        wall_time=asked.wall_time,
        pilot_contacts=n,
        pilot_time=spent,
    )


@dataclass(frozen=True)
class _Few:
    """What a few contacts tell: `result`; the blocks of the `whole` run; `number` of this rank's blocks; seconds of the
    slowest rank for its `blocks`, the tables before (`ready`), and the result (`once`)."""

    result: "EnsembleResult"
    whole: layout.Blocks
    number: int
    blocks: float
    ready: float
    once: float

    @property
    def run_time(self) -> float:
        return self.ready + self.blocks + self.once


def _follow_few(scene: Scene, asked: EqTable, comm: Any, n: int, seconds: Seconds | None) -> _Few:
    ensemble: Any = make_ensemble(
        scene, asked, comm, n_contacts=n, n_replicas=1, tolerance=None, wall_time=None
    )
    ready = ensemble.state.run_time
    finished, whole = (
        set[int](),
        layout.make_blocks(asked.contacts, asked.replicas, ensemble.seconds),
    )
    result: Any = follow(ensemble, lambda done, expected: finished.add(done))
    if seconds is not None:
        told = _largest(comm, seconds(result, len(finished)))
        return _Few(result, whole, len(finished), told, ready=0.0, once=0.0)
    taken = ensemble.state.run_time
    blocks, ready, taken = (_largest(comm, measured) for measured in (taken - ready, ready, taken))
    return _Few(result, whole, len(finished), blocks, ready, result.run_time - taken)


@dataclass(frozen=True)
class Pilot:
    """The best that pilots of the master equation came to in their time: the error they reached, inf where none was
    known yet, and the tolerance that is asked for (both in <x_s>); s; and whether a pilot ended above its tolerance, so
    that no longer run is better."""

    error: float
    run_time: float
    asked: float
    ended: bool


class _TimeIsUp(Exception):
    """Of a pilot."""


def pilot(scene: Scene, most_seconds: float = _ENOUGH) -> Pilot:
    """Solve at tolerances ten times tighter each time, up to the one asked for, for so many seconds of this process's
    own work in all.

    Raises InputError for a scene without [master], and as a run does."""
    if scene.master is None:
        raise InputError("dry run: the scene has no [master]")
    asked, tolerance = scene.master.tolerance, max(_LOOSEST, scene.master.tolerance)
    error, run_time, began = math.inf, 0.0, time.perf_counter()

    def hear(found: float) -> None:
        nonlocal error, run_time
        error, run_time = min(error, found), time.perf_counter() - began

    try:
        with _no_longer_than(most_seconds):
            while True:
                before = time.perf_counter()
                solved = solve_master(scene, tolerance, hear)
                error, run_time = (
                    min(error, float(solved.force_error)),
                    time.perf_counter() - before,
                )
                if tolerance <= asked or not solved.success:
                    return Pilot(error, run_time, asked, ended=not solved.success)
                tolerance = max(0.1 * tolerance, asked)
    except _TimeIsUp:
        run_time = run_time if math.isfinite(error) else time.perf_counter() - began
        return Pilot(error, run_time, asked, ended=False)


@contextmanager
def _no_longer_than(seconds: float) -> Iterator[None]:
    """Raise _TimeIsUp within once that time is up, in the main thread, which alone can be told."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(number: int, frame: FrameType | None) -> NoReturn:
        raise _TimeIsUp

    # of this process's own work: others may keep the machine busy
    before = signal.signal(signal.SIGPROF, ring)
    try:
        signal.setitimer(signal.ITIMER_PROF, max(seconds, 1e-6))
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def pilot_lines(told: Pilot) -> list[str]:
    """The same as lines of text."""
    if not math.isfinite(told.error) and not told.ended:
        return [
            f"master          no error is known after {told.run_time:.2g} s; how long it takes is not foreseen"
        ]
    reached = f"master          error {told.error:.1e} of <x_s> after {told.run_time:.2g} s"
    if told.error <= told.asked:
        return [f"{reached}, within the {told.asked:.0e} asked for"]
    if told.ended:
        return [f"{reached}; {told.asked:.0e} was asked, and no more is reached"]
    return [f"{reached}; {told.asked:.0e}, as asked, takes longer, how much is not foreseen"]


def lines(told: Forecast) -> list[str]:
    """The forecast of an ensemble as lines of text."""
    contacts, seconds, error = told.contacts, told.run_time, told.error
    of_all = f", of {told.most:,} at most" if told.tolerance is not None else ""
    of_all += f", {told.done:,} of them done before" if told.done else ""
    besides = "for what is left, " * bool(told.done) + "[master] and compilation not counted"
    out = [
        f"contacts        {_range(contacts, ',.0f')}{of_all}",
        f"breaks          {_range(told.breaks, '.2g')}",
        f"run time        {_range(seconds, '.2g')} s on {told.ranks} rank(s), {besides}",
        f"memory          {_range(told.memory, '.0f')} MB for each rank",
        *_on_disk(told),
        f"standard error  {_range(error, '.2g')} of <x_s>, the largest over the path",
    ]
    if told.tolerance is not None:
        met = (
            "yes"
            if error.high <= told.tolerance
            else "no"
            if error.low > told.tolerance
            else "perhaps"
        )
        met = "yes" if contacts.high < told.most else met
        out.append(f"tolerance       {told.tolerance:.1e} reached: {met}")
    if told.wall_time is not None and seconds.high > told.wall_time:
        out.append(f"wall time       {told.wall_time:g} s stops it before, if it takes longer")
    return [
        *out,
        f"from a pilot of {told.pilot_contacts:,} contacts in {told.pilot_time:.2g} s; nothing was written",
    ]


def _on_disk(told: Forecast) -> list[str]:
    """Room for histograms, where there are any."""
    if not told.kept:
        return []
    return [f"on disk         {told.kept:.2g} MB in its checkpoint, of the histograms of each rank"]


def _range(number: Estimate, form: str) -> str:
    value, low, high = (format(x, form) for x in (number.value, number.low, number.high))
    return value if low == high else f"{value} ({low} to {high})"


def _followed(tolerance: float | None, n: int, error: float, whole: layout.Blocks) -> int:
    """Contacts until the tolerance is reached, if n have this error: whole rounds of the ensemble."""
    most = whole.before(whole.total)
    if tolerance is None:
        return most
    ratio = error / tolerance
    wanted = n * ratio * ratio  # not as a power, which may overflow
    ends = (whole.before(part.stop) for part in whole.rounds(True))
    return next((end for end in ends if end >= wanted), most)


def _each(scene: Scene, breaks: float, n: int) -> Estimate:
    """Breaks of one contact, as n contacts tell: at long last their variance is that of the thresholds."""
    law = scene.contacts.thresholds
    uneven = max((law.std() / law.mean()) ** 2, 1.0)
    off = _SIGMAS * math.sqrt((breaks * uneven + 1.0) / n) if np.isfinite(uneven) else breaks
    return Estimate(breaks, max(breaks - off, 0.0), breaks + off)


def _largest(comm: Any, value: float) -> float:
    return value if comm is None else max(comm.allgather(value))


def _peak() -> float:
    """MB that this process has held at most."""
    import resource

    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return held / (2**20 if sys.platform == "darwin" else 2**10)
