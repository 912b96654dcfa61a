"""Forecast of the cost and error of a scene's solvers, by a short pilot run of each."""

import math
from typing import Any, NamedTuple

import numpy as np

from toolkit.processes.signals import TimeIsUp, no_longer_than
from toolkit.running.checkpoint import Checkpoint
from toolkit.running.solvers import follow, make_ensemble, solve_master
from toolkit.scene.scene import Scene


class Forecast(NamedTuple):
    """What an ensemble takes: contacts to be followed, their breaks, s of those not yet done, and the largest standard
    error of the force in mean thresholds (nan on a soft slider, where replicas tell it); `pilot` contacts tell."""

    contacts: int
    breaks: float
    run_time: float
    error: float
    pilot: int


def forecast(scene: Scene, comm: Any = None, done: int = 0) -> Forecast:
    """Follow some contacts of the scene's ensemble for a second, and scale their time to the whole. `done` contacts
    need not be followed again. All ranks must call. Raises InputError as a run does."""
    asked: Any = scene.eq
    soft, ranks = scene.drive.spring is not None, 1 if comm is None else comm.Get_size()
    contacts = asked.contacts * asked.replicas
    size = min(1 << 12, asked.contacts) if soft else min(ranks << 16, contacts)
    # of one replica on a spring nothing is known before its path ends
    small: dict[str, Any] = {"n_contacts": size, "n_replicas": 1}
    small["wall_time"] = None if soft else 1.0
    ensemble: Any = make_ensemble(scene, asked, comm, **small, tolerance=None)
    ready = ensemble.state.run_time  # tables are made once
    found: Any = follow(ensemble)
    error = float(found.force_standard_error.max()) / scene.contacts.mean_threshold
    if asked.tolerance is not None:
        wanted = found.contacts * np.square(error / np.float64(asked.tolerance))
        contacts = math.ceil(min(wanted, contacts))
    shared = min(ranks, asked.replicas) if soft else 1  # a pilot on a soft slider is one rank's
    each = (found.run_time - ready) / found.contacts / shared
    error = math.nan if soft else error * math.sqrt(found.contacts / contacts)
    breaks = found.breaks / found.contacts * contacts
    return Forecast(contacts, breaks, ready + each * max(contacts - done, 0), error, found.contacts)


def forecast_lines(scene: Scene, folder: str, comm: Any = None) -> list[str]:
    """The cost of a run of the scene into `folder`, as lines of text; nothing is written. All ranks must call. Raises
    InputError as the run would, also for a checkpoint of another scene."""
    out = [scene.title or scene.name]
    if scene.grid is not None:
        return [*out, f"sweep   {len(scene.grid.points):,} points; their time is not foreseen"]
    earlier = [] if scene.eq is None else Checkpoint(folder, scene, comm).earlier(only_look=True)
    if scene.master is not None:
        try:
            with no_longer_than(1.0):
                solved = solve_master(scene, scene.master.tolerance)
            error = scene.scale.error(solved.force_error, scene.contacts.mean_threshold)
            out.append(f"master  error {error} in {solved.run_time:.2g} s")
        except TimeIsUp:
            out.append(f"master  {scene.master.tolerance:.0e} takes longer than a second")
    if scene.sweep is not None:
        points = scene.sweep.at["velocity"].size
        out.append(f"sweep   {points:,} points; their time is not foreseen")
    if scene.eq is None:
        return out
    done = sum(state.contacts for state in earlier)
    found = forecast(scene, comm, done)
    so_far = f", {done:,} of them done before" if done else ""
    ranks = f"{1 if comm is None else comm.Get_size()} rank(s)"
    took = (
        f"{found.run_time:.2g} s on {ranks} for what is left, [master] and compilation not counted"
    )
    out += [f"contacts        {found.contacts:,}{so_far}", f"breaks          {found.breaks:.2g}"]
    out.append(f"run time        {took}")
    if not math.isnan(found.error):
        error = scene.scale.error(found.error, scene.contacts.mean_threshold)
        out.append(f"standard error  {error}, the largest over the path")
    if found.run_time > (scene.eq.wall_time or math.inf):
        out.append(f"wall time       {scene.eq.wall_time:g} s stops it before")
    return [*out, f"good to a factor of two, as {found.pilot:,} contacts tell; nothing was written"]
