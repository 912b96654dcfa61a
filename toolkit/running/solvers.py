"""The solvers of a scene: the master equation, and the ensemble from its first block to its result."""

import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.contacts import Contacts
from origins.errors import InputError, refuse
from origins.laws.temperature import TooHot
from origins.thresholds.law import Array
from toolkit.processes.ranks import Relay, cores_of
from toolkit.processes.signals import TimeIsUp, deferred, no_longer_than
from toolkit.results.kinds import HARDLY_SEEN, is_known_without_heat
from toolkit.results.points import SMOOTH, SweepRecord
from toolkit.results.records import SolvedRecord, record_of
from toolkit.results.verdicts import with_units
from toolkit.running.checkpoint import Checkpoint
from toolkit.scene import laws
from toolkit.scene.messages import with_units_of
from toolkit.scene.scene import Scene
from toolkit.scene.sweep import QUANTITIES, Sweep
from toolkit.scene.tables import EqTable

_SPRINGS = ("critical_spring", "critical_spring_error")
_OWN = ("seed", "tolerance", "wall_time", "slip_fraction", "histograms")
EQ_KEYS = {"n_contacts": "contacts", "n_replicas": "replicas"} | {name: name for name in _OWN}


def follow(
    ensemble: Any,
    progress: Callable[[int, int], None] | None = None,
    checkpoint: Checkpoint | None = None,
    done_before: int = 0,
    deadline: float | None = None,
) -> Any:
    """Run an ensemble from its first block to its result; all ranks of its communicator must call.

    SIGINT, SIGTERM and SIGHUP wait until the block is finished and its checkpoint written, and then act as usual: as a
    rule they end the program; a replica on a spring, which may take minutes, is given up. A rank that gets one informs
    the others, which end in the same way. `progress` includes contacts `done_before`, and takes the other ranks to be
    as far as this one. After the `deadline`, s of the monotonic clock, no block begins, and replicas on a spring are
    given up: NothingInTimeError where none has reached the end of its path.
    """
    comm, shown = ensemble.comm, (-1, -1)
    ranks = 1 if comm is None else comm.Get_size()
    with deferred() as asked:
        relay = Relay(comm, asked)

        def interrupted() -> bool:
            relay.listen()
            late = deadline is not None and time.monotonic() > deadline
            return late or asked.signal is not None

        ensemble.interrupted = interrupted
        for done, _ in ensemble:
            now = min(done_before + done * ranks, ensemble.expected), ensemble.expected
            if progress is not None and now != shown:
                progress(*now)
                shown = now
            if deadline is not None and time.monotonic() > deadline:
                ensemble.stop()
            relay.listen()
            relay.pass_on()
            if checkpoint is not None and asked.signal is None:
                checkpoint.keep(ensemble.state)
            elif asked.signal is not None:
                if checkpoint is not None:
                    checkpoint.write(ensemble.state)
                asked.pass_on("nothing was written" if checkpoint is None else checkpoint.note)
    if checkpoint is not None:  # of a finished run too, in case the result cannot be written
        checkpoint.write(ensemble.state)
    return ensemble.result()


@contextmanager
def within(
    deadline: float | None,
    scene: Scene,
    what: str,
    remaining_time: Callable[[], float] | None = None,
) -> Iterator[None]:
    """Raise InputError within once the deadline, in s of the monotonic clock, has passed, and no time remains."""
    try:
        with no_longer_than(
            None if deadline is None else deadline - time.monotonic(), remaining_time=remaining_time
        ):
            yield
    except TimeIsUp as over:
        if scene.wall_time is None:
            hint = "give more, as wall_time = 300 (s) at the top of the scene, or ask for less"
            said = f"the command's own limit of time is over before {what} is solved; {hint}"
            raise InputError(said) from over
        hint = f"is over before {what} is solved; give more, or ask for less"
        hint = "; ".join([hint, *getattr(over, "__notes__", [])])
        refuse("wall_time", scene.wall_time, hint)


def solve_master(
    scene: Scene,
    tolerance: float,
    refined: Callable[[float], None] | None = None,
    wall_time: float | None = None,
) -> SolvedRecord:
    """The master equation's answer along the scene's drive; `refined` is called with each error on the way, and after
    `wall_time` s the path is cut. Raises InputError where there is none; the message says so if the scene's ensemble
    would run without [master]."""
    import master

    drive, contacts = scene.drive, scene.contacts
    asked = drive.keywords()
    asked |= {} if wall_time is None else {"wall_time": wall_time}
    asked |= {"progress": refined} if refined is not None else {}
    try:
        with laws.inside("master", {"tolerance": "tolerance"}):
            solved: Any = master.solve(contacts, scene.path, tolerance, **asked)
            if not solved.path.size:
                raise InputError(solved.message)
    except InputError as error:
        alone = scene.eq is not None and contacts.each_by_itself() is contacts
        other = "; without [master] the scene's [eq] runs alone" * alone
        said = f"{with_units_of(scene.scale, str(error), contacts.mean_threshold)}{other}"
        if said == str(error):
            raise
        raise InputError(said) from error
    found = record_of(solved)
    if found.regime is not None:
        mean = contacts.mean_threshold
        reason = with_units_of(scene.scale, with_units(scene, found.regime), mean)
        found = replace(found, regime=replace(found.regime, reason=reason))
        note, message = (
            with_units_of(scene.scale, said or "", mean) for said in (found.note, found.message)
        )
        found = replace(found, note=note, message=message)
    # without a tolerance an error that is hardly visible in a picture will do, and what heat may change that is left
    # out, which no tolerance lessens, is told beside the numbers
    as_asked = scene.tolerance_given or found.success or found.path.size != scene.path.size
    if as_asked or not (found.force_error <= HARDLY_SEEN or is_known_without_heat(found)):
        return found
    said = f"error {found.force_error:.1e} of <x_s>; no tolerance was asked for"
    said += f"; {found.note}" if found.note else ""
    return replace(found, success=True, message=said)


def make_ensemble(scene: Scene, asked: EqTable, comm: Any, **other: Any) -> Any:
    """The ensemble of the scene's [eq]; `other` arguments of its class replace those of the table. Raises InputError
    with the scene's own keys."""
    import eq_model

    drive, contacts = scene.drive, scene.contacts
    if scene.master is not None:
        # single contacts have no mean rate and no common P_c: they show the error of these closures
        contacts = contacts.each_by_itself()
    arguments: dict[str, Any] = {name: getattr(asked, key) for name, key in EQ_KEYS.items()}
    arguments |= {"comm": comm, "threads": asked.threads or cores_of(comm)}
    arguments |= {"histograms": scene.histogram_points()}
    arguments |= drive.keywords()
    with laws.inside("eq", EQ_KEYS):
        return eq_model.Ensemble(contacts, scene.path, **(arguments | other))


def solve_sweep(contacts: Contacts, asked: Sweep) -> SweepRecord:
    """F_k and the fraction that holds at all points in one call, and if requested K* in another."""
    import master

    began = time.perf_counter()
    velocity: Any = asked.at["velocity"]
    laws_at: dict[str, Any] = {name: asked.at[name] for name in QUANTITIES[1:] if name in asked.at}
    with laws.inside("sweep", {name: name for name in QUANTITIES}), warnings.catch_warnings():
        warnings.simplefilter("ignore", TooHot)  # a note of the run says it
        curve = master.kinetic_curve(contacts, velocity, **laws_at)
        success = _good(curve.success, curve.force_error * contacts.mean_threshold, curve.force)
        message, springs = curve.message, dict[str, Any]()
        if asked.critical_spring:
            line = master.phase_line(contacts, velocity, **laws_at)
            springs = {name: getattr(line, name) for name in _SPRINGS}
            success = success and _good(line.success, *reversed(springs.values()))
            message += f"; {line.message}"
    found = {name: getattr(curve, name, None) for name in SMOOTH} | springs
    found["kelvin"] = asked.at.get("kelvin")
    columns: Any = {name: found[name] for name in SMOOTH if found[name] is not None}
    took = time.perf_counter() - began
    return SweepRecord(asked.along, columns, {}, took, success, message)


def _good(success: npt.NDArray[np.bool_], error: Array, value: Array) -> bool:
    """Whether each point reaches its tolerance, or at least a relative error of 1e-3, less than a picture shows."""
    return bool((success | (error <= 1e-3 * np.maximum(value, 1e-300))).all())
