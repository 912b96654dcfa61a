"""Forecast of the cost and error of a scene's solvers, by a short pilot run of each."""

import math
import resource
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.running.checkpoint import Checkpoint
from toolkit.running.runner import follow, make_ensemble, solve_master
from toolkit.running.signals import TimeIsUp, no_longer_than
from toolkit.scene.scene import Scene

_PILOT, _COUPLED_PILOT = 1 << 16, 1 << 12  # contacts of each rank; of a replica on a soft slider
_ENOUGH = 1.0  # seconds of a pilot
_AFTERWARDS = 160.0  # MB at most for result files and pictures, once the ensemble is done
_EACH = 24e-6  # MB of a contact on a soft slider


@dataclass(frozen=True)
class Forecast:
    """Expected cost and error of the ensemble, good to a factor of about two; with a tolerance to four, as the number
    of contacts is doubled round by round, and as few breaks hardly determine the error.

    contacts : to be followed, `done` of them by an earlier run. breaks : of all of them. run_time : s, of those not yet
    done. memory : MB of a rank. error : largest standard error of the force in mean thresholds; nan on a soft slider,
    where it comes from replicas. pilot : number of contacts of the pilot run.
    """

    done: int
    contacts: int
    breaks: float
    run_time: float
    memory: float
    error: float
    pilot: int


def forecast(scene: Scene, comm: Any = None, done: int = 0) -> Forecast:
    """Follow some contacts of the scene's ensemble, and scale their time and memory to the whole.

    `done` contacts need not be followed again. All ranks must call. Raises InputError as a run does.
    """
    asked: Any = scene.eq
    soft, ranks = scene.drive.spring is not None, 1 if comm is None else comm.Get_size()
    contacts = asked.contacts * asked.replicas
    size = min(_COUPLED_PILOT, asked.contacts) if soft else min(_PILOT * ranks, contacts)
    small: dict[str, Any] = {"n_contacts": size, "n_replicas": 1, "wall_time": _ENOUGH}
    ensemble: Any = make_ensemble(scene, asked, comm, **small, tolerance=None)
    ready = ensemble.state.run_time  # tables are made once
    found: Any = follow(ensemble)
    error = float(found.force_standard_error.max()) / scene.contacts.mean_threshold
    if asked.tolerance is not None:
        wanted = found.contacts * np.square(error / np.float64(asked.tolerance))
        contacts = math.ceil(min(wanted, contacts))
    shared = min(ranks, asked.replicas) if soft else 1  # a pilot on a soft slider is one rank's
    each = (found.run_time - ready) / found.contacts / shared
    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10  # of kB, but for macOS
    held = held / 2**10 if sys.platform == "darwin" else held
    return Forecast(
        done=done,
        contacts=contacts,
        breaks=found.breaks / found.contacts * contacts,
        run_time=ready + each * max(contacts - done, 0),
        memory=held + _AFTERWARDS + (_EACH * asked.contacts if soft else 0.0),
        error=math.nan if soft else error * math.sqrt(found.contacts / contacts),
        pilot=found.contacts,
    )


def forecast_lines(scene: Scene, folder: str, comm: Any = None) -> list[str]:
    """The cost of a run of the scene into `folder`, as lines of text; nothing is written. All ranks must call.

    Raises InputError as the run would, also for a checkpoint of another scene.
    """
    out = [scene.title or scene.name]
    earlier = [] if scene.eq is None else Checkpoint(folder, scene, comm).earlier(only_look=True)
    if scene.master is not None:
        out.append(_master_line(scene, scene.master.tolerance))
    if scene.sweep is not None:
        points = scene.sweep.velocity.size
        out.append(f"sweep           {points:,} points; their time is not foreseen")
    if scene.eq is None:
        return out
    told = forecast(scene, comm, sum(state.contacts for state in earlier))
    tolerance, most = scene.eq.tolerance, scene.eq.contacts * scene.eq.replicas
    of_all = "" if tolerance is None else f", of {most:,} at most"
    of_all += f" in {scene.eq.replicas:,} replicas" if scene.drive.spring is not None else ""
    of_all += f", {told.done:,} of them done before" if told.done else ""
    besides = "for what is left, " * bool(told.done) + "[master] and compilation not counted"
    ranks = 1 if comm is None else comm.Get_size()
    out += [
        f"contacts        {told.contacts:,}{of_all}",
        f"breaks          {told.breaks:.2g}",
        f"run time        {told.run_time:.2g} s on {ranks} rank(s), {besides}",
        f"memory          up to {told.memory:.0f} MB for each rank",
    ]
    if not math.isnan(told.error):
        out.append(f"standard error  {told.error:.2g} of <x_s>, the largest over the path")
    if told.run_time > (scene.eq.wall_time or math.inf):
        out.append(f"wall time       {scene.eq.wall_time:g} s stops it before")
    return [*out, f"good to a factor of two, as {told.pilot:,} contacts tell; nothing was written"]


def _master_line(scene: Scene, asked: float) -> str:
    """The error that the master equation reaches within a second."""
    errors, began = [math.inf], time.perf_counter()
    ends = f"; {asked:.0e} was asked, and no more is reached"
    try:
        with no_longer_than(_ENOUGH):
            errors.append(float(solve_master(scene, asked, errors.append).force_error))
    except TimeIsUp:
        ends = f"; {asked:.0e}, as asked, takes longer, how much is not foreseen"
    if min(errors) <= asked:
        ends = f", within the {asked:.0e} asked for"
    took = time.perf_counter() - began
    return f"master          error {min(errors):.1e} of <x_s> after {took:.2g} s{ends}"
