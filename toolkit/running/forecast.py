"""What a scene's solvers will take and give, told beforehand by one pilot of each."""

import math
import signal
import sys
import time
from dataclasses import dataclass
from typing import Any

from origins.errors import InputError
from toolkit.running.blocks import follow
from toolkit.running.runner import make_ensemble, solve_master
from toolkit.running.signals import TimeIsUp, no_longer_than
from toolkit.scene.scene import Scene

_PILOT = 1 << 16  # contacts of each rank
_ENOUGH = 1.0  # seconds of a pilot
_LOOSEST = 1e-2  # tolerance of the first pilot of the master equation
_SPEED = 2.0  # other users, clock rates, sizes of blocks: a run is this much faster or slower
_AFTERWARDS = 160.0  # MB at most for result files and pictures, once the ensemble is done
_SIGMAS = 4.0
_TAILS = 2.5  # variance of a variance over its square: 0.5 for normal forces, more for rare breaks


@dataclass(frozen=True)
class Estimate:
    """A number and the range it is expected in."""

    value: float
    low: float
    high: float

    def less(self, done: float) -> "Estimate":
        """What is left of it."""
        return Estimate(*(max(x - done, 0.0) for x in (self.value, self.low, self.high)))


@dataclass(frozen=True)
class Forecast:
    """What the ensemble is expected to take and give.

    ranks : at work. contacts : to be followed, of `most`, `done` of them by an earlier run.
    breaks : of all of them. run_time : s, of those that are left. memory : MB of a rank.
    error : largest standard error of the force in mean thresholds; tolerance : that was asked for.
    pilot_contacts, pilot_time : of what tells this, s, compilation not counted.
    """

    ranks: int
    most: int
    done: int
    contacts: Estimate
    breaks: Estimate
    run_time: Estimate
    memory: float
    error: Estimate
    tolerance: float | None
    wall_time: float | None
    pilot_contacts: int
    pilot_time: float


def forecast(scene: Scene, comm: Any = None, done: int = 0) -> Forecast:
    """Follow some contacts of the scene's ensemble, and scale what they take to the whole.

    `done` contacts need not be followed again. All ranks of the communicator must call: they work
    at once, as they will. Raises InputError for a scene without [eq], and as a run does.
    """
    asked = scene.eq
    if asked is None:
        raise InputError("dry run: the scene has no [eq]; only an ensemble's work is foreseen so")
    ranks, most = 1 if comm is None else comm.Get_size(), asked.contacts * asked.replicas
    size = min(_PILOT * ranks, most)
    pilot: Any = make_ensemble(
        scene, asked, comm, n_contacts=size, n_replicas=1, tolerance=None, wall_time=_ENOUGH
    )
    ready = pilot.state.run_time  # tables are made once
    found: Any = follow(pilot)
    n, spent = found.contacts, found.run_time
    largest = float(found.force_standard_error.max()) / scene.contacts.mean_threshold
    # before many have broken it is those few that differ
    off = min(_SIGMAS * math.sqrt(_TAILS / min(n, max(found.breaks, 1))), 0.9)
    errors = largest, largest * (1.0 - off), largest * (1.0 + off)
    contacts = Estimate(*(_followed(asked.tolerance, n, error, most) for error in errors))
    if asked.tolerance is not None:  # they are followed in rounds, each of which doubles them
        contacts = Estimate(contacts.value, contacts.low, min(2.1 * contacts.high, most))
    numbers = contacts.value, contacts.high, contacts.low
    scatter = _SIGMAS * math.sqrt(found.breaks + 1.0)
    least, most_broken = max(found.breaks - scatter, 0.0), found.breaks + scatter
    each, left = (spent - ready) / n, contacts.less(done)
    return Forecast(
        ranks=ranks,
        most=most,
        done=done,
        contacts=contacts,
        breaks=Estimate(
            found.breaks / n * contacts.value,
            least / n * contacts.low,
            most_broken / n * contacts.high,
        ),
        run_time=Estimate(
            ready + each * left.value,
            (ready + each * left.low) / _SPEED,
            (ready + each * left.high) * _SPEED,
        ),
        memory=_peak() + _AFTERWARDS,
        error=Estimate(*(e * math.sqrt(n / m) for e, m in zip(errors, numbers, strict=True))),
        tolerance=asked.tolerance,
        wall_time=asked.wall_time,
        pilot_contacts=n,
        pilot_time=spent,
    )


def _followed(tolerance: float | None, n: int, error: float, most: int) -> float:
    """Contacts that reach the tolerance, if n have this error; all where there is none."""
    ratio = math.inf if tolerance is None else error / tolerance
    return min(math.ceil(min(n * ratio * ratio, most)), most)


@dataclass(frozen=True)
class Pilot:
    """The best that pilots of the master equation came to in their time.

    error : reached, inf where none was known yet; asked : the tolerance (both in <x_s>).
    run_time : s. ended : whether a pilot ended above its tolerance, so that no longer run is better.
    """

    error: float
    run_time: float
    asked: float
    ended: bool


def pilot(scene: Scene, most_seconds: float = _ENOUGH) -> Pilot:
    """Solve at tolerances ten times tighter each time, up to the one asked for, for so many seconds
    of this process's own work.

    Raises InputError for a scene without [master], and as a run does.
    """
    if scene.master is None:
        raise InputError("dry run: the scene has no [master]")
    asked, tolerance = scene.master.tolerance, max(_LOOSEST, scene.master.tolerance)
    error, run_time, began = math.inf, 0.0, time.perf_counter()

    def hear(found: float) -> None:
        nonlocal error, run_time
        error, run_time = min(error, found), time.perf_counter() - began

    try:
        with no_longer_than(most_seconds, signal.ITIMER_PROF):
            while True:
                before = time.perf_counter()
                solved = solve_master(scene, tolerance, hear)
                error = min(error, float(solved.force_error))
                run_time = time.perf_counter() - before
                if tolerance <= asked or not solved.success:
                    return Pilot(error, run_time, asked, ended=not solved.success)
                tolerance = max(0.1 * tolerance, asked)
    except TimeIsUp:
        run_time = run_time if math.isfinite(error) else time.perf_counter() - began
        return Pilot(error, run_time, asked, ended=False)


def pilot_lines(told: Pilot) -> list[str]:
    """The same as lines of text."""
    if not math.isfinite(told.error) and not told.ended:
        return [
            f"master          no error is known after {told.run_time:.2g} s; how long it takes is "
            "not foreseen"
        ]
    reached = f"master          error {told.error:.1e} of <x_s> after {told.run_time:.2g} s"
    if told.error <= told.asked:
        return [f"{reached}, within the {told.asked:.0e} asked for"]
    if told.ended:
        return [f"{reached}; {told.asked:.0e} was asked, and no more is reached"]
    return [f"{reached}; {told.asked:.0e}, as asked, takes longer, how much is not foreseen"]


def lines(told: Forecast) -> list[str]:
    """The forecast of an ensemble as lines of text."""
    seconds, error, tolerance = told.run_time, told.error, told.tolerance
    of_all = f", of {told.most:,} at most" if tolerance is not None else ""
    of_all += f", {told.done:,} of them done before" if told.done else ""
    besides = "for what is left, " * bool(told.done) + "[master] and compilation not counted"
    out = [
        f"contacts        {_range(told.contacts, ',.0f')}{of_all}",
        f"breaks          {_range(told.breaks, '.2g')}",
        f"run time        {_range(seconds, '.2g')} s on {told.ranks} rank(s), {besides}",
        f"memory          up to {told.memory:.0f} MB for each rank",
        f"standard error  {_range(error, '.2g')} of <x_s>, the largest over the path",
    ]
    if tolerance is not None:
        met = "yes" if error.high <= tolerance else "no" if error.low > tolerance else "perhaps"
        met = "yes" if told.contacts.high < told.most else met
        out.append(f"tolerance       {tolerance:.1e} reached: {met}")
    if told.wall_time is not None and seconds.high > told.wall_time:
        out.append(f"wall time       {told.wall_time:g} s stops it before, if it takes longer")
    end = f"from a pilot of {told.pilot_contacts:,} contacts in {told.pilot_time:.2g} s"
    return [*out, f"{end}; nothing was written"]


def _range(number: Estimate, form: str) -> str:
    value, low, high = (format(x, form) for x in (number.value, number.low, number.high))
    return value if low == high else f"{value} ({low} to {high})"


def _peak() -> float:
    """MB that this process has held at most."""
    import resource

    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return held / (2**20 if sys.platform == "darwin" else 2**10)
