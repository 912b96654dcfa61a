"""Run a scene: each solver it names, and no other."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, nullcontext
from dataclasses import replace
from os import PathLike
from typing import Any

from origins.errors import InputError, refuse
from origins.samples.from_samples import sampled_parts
from toolkit.processes.ranks import cores_of, on_root
from toolkit.processes.signals import TimeIsUp, deferred, no_longer_than
from toolkit.results.files import another
from toolkit.results.folders import check_folder, only_writer
from toolkit.results.records import Result, SolvedRecord, record_of, sample_curve
from toolkit.running.checkpoint import EVERY, Checkpoint, say
from toolkit.running.progress import Progress
from toolkit.running.rules import beside_other_rules
from toolkit.saving import save
from toolkit.scene import laws
from toolkit.scene.interfaces import foreseen, of_interface, of_so_many, remarks
from toolkit.scene.scene import Scene, load_scene
from toolkit.scene.sweep import solve_sweep
from toolkit.scene.tables import EqTable
from toolkit.version import __version__

_STOP = 7117  # tag of the message by which a rank passes a signal on to the others
_OWN = ("seed", "tolerance", "wall_time", "slip_fraction", "histograms")
_EQ_KEYS = {"n_contacts": "contacts", "n_replicas": "replicas"} | {name: name for name in _OWN}


def run(
    scene: Scene | Mapping[str, Any] | str | PathLike[str],
    comm: Any = None,
    progress: Callable[[int, int], None] | None = None,
    folder: str | PathLike[str] | None = None,
    checkpoint: float = EVERY,
) -> Result:
    """Solve what the scene asks for: a dict, a scene file or the name of a shipped scene.

    All ranks of the mpi4py communicator `comm` must call; they share the work, and each gets the whole result. None:
    this process alone. `progress` is called as progress(done, expected) after each block of the ensemble, with contacts
    of the whole run; with a tolerance the expected number changes during the run.

    The result is written into `folder`, as by `save`, and before that a checkpoint of the ensemble every `checkpoint`
    seconds; a run that finds one of the same scene continues from it, to the same bits. None: nothing is written.
    Interrupted (SIGINT, SIGTERM), it finishes its block and writes its checkpoint first.

    Raises InputError for a scene that cannot be run, and for a folder that cannot be written or that holds the
    checkpoint of another scene.
    """
    scene = load_scene(scene, comm=comm)
    if folder is None:
        return solve(scene, comm, progress)[0]
    with open_checkpoint(folder, scene, comm, checkpoint) as kept:
        result, finished = solve(scene, comm, progress, kept)
        write(result, comm, kept, finished)
    return result


@contextmanager
def open_checkpoint(
    folder: str | PathLike[str], scene: Scene, comm: Any, every: float
) -> Iterator[Checkpoint]:
    """The scene's checkpoint in `folder`, locked against other runs; InputError, before any work, where the folder
    cannot be written."""
    with ExitStack() as held:

        def hold() -> None:
            check_folder(folder)
            held.enter_context(only_writer(folder))
            if (other := another(folder, scene.name, scene.text)) is not None:
                say(f"{folder}: holds the result of {other}, which this run will replace")

        on_root(comm, hold)
        yield Checkpoint(folder, scene, comm, every)


def write(result: Result, comm: Any, kept: Checkpoint, finished: bool) -> None:
    """Save the result in the checkpoint's folder, on rank 0, and then remove the checkpoint if the run is finished."""

    def on_first() -> None:
        save(result, kept.folder)
        if finished and result.eq is not None:  # else a checkpoint there is that of another scene
            kept.remove()

    on_root(comm, on_first)


def solve(
    scene: Scene,
    comm: Any,
    progress: Callable[[int, int], None] | None = None,
    kept: Checkpoint | None = None,
    show_progress: bool = False,
) -> tuple[Result, bool]:
    """Run the scene's solvers, showing progress on stderr if asked; returns the result and whether it is finished."""
    interface, law, deadline = scene.contacts.interface, scene.contacts.thresholds, scene.deadline()

    def shown(what: str) -> Any:
        return closing(Progress(what)) if show_progress else nullcontext()

    ensemble, before = None, 0
    master = sweep = eq = None
    if scene.eq is not None:  # made first, so that it refuses bad input before any work
        with shown("eq"):
            earlier = [] if kept is None else kept.earlier()
            before = sum(state.contacts for state in earlier)
            ensemble = make_ensemble(scene, scene.eq, comm, earlier=earlier)
        del earlier  # the ensemble has a copy of these sums; free the memory
    if scene.master is not None:
        with shown("master equation") as bar, within(deadline, scene, "[master]"):
            master = solve_master(scene, scene.master.tolerance, bar and bar.refine)
    if scene.sweep is not None:
        with shown("sweep"), within(deadline, scene, "[sweep]"):
            sweep = solve_sweep(scene.contacts, scene.sweep)
    if ensemble is not None:
        with laws.inside("eq", _EQ_KEYS), shown("eq") as bar:
            eq = follow(ensemble, bar.count if bar else progress, kept, before, deadline)
    notes = [*remarks(law), *foreseen(scene)]
    if sampled_parts(law):
        notes.append(
            "errors are numerical only, not those of the samples: `mesofriction thresholds` tells sampling errors"
        )
    soft: Any = master if master is not None and master.regime is not None else None
    if soft is not None and soft.regime.verdict == "undecided" and not soft.slips.drive.size:
        far = float(law.isf(1e-3)) + scene.contacts.mean_threshold / (scene.drive.spring or 1.0)
        if max(scene.path) < far:
            notes.append(f"a first slip is to be expected before X_T = {far:.3g}; drive as far")
    if soft is not None:
        with shown("slip rules"):
            notes += beside_other_rules(scene, soft, deadline)
    if before:
        notes.append(
            f"went on from a checkpoint of {before:,} contacts: the run time of eq is that of all launches together, "
            "and breaks_per_rank counts the earlier ones' on rank 0"
        )
    result = Result(
        name=scene.name,
        title=scene.title,
        text=scene.text,
        version=__version__,
        mean_threshold=scene.contacts.mean_threshold,
        thresholds=sample_curve(law),
        master=master,
        eq=eq,
        interface=None if interface is None else of_interface(interface),
        sweep=sweep,
        domains=law.domains,
        notes=tuple(notes),
    )
    finished = ensemble is None or eq is None or eq.success or eq.contacts == ensemble.total
    if kept is not None and not finished and (comm is None or comm.Get_rank() == 0):
        say(f"stopped by the wall time; run it again with --out {kept.folder} to go on")
    return result, finished


def follow(
    ensemble: Any,
    progress: Callable[[int, int], None] | None = None,
    checkpoint: Checkpoint | None = None,
    done_before: int = 0,
    deadline: float | None = None,
) -> Any:
    """Run an ensemble from its first block to its result; all ranks of its communicator must call.

    SIGINT, SIGTERM and SIGHUP wait until the block is finished and its checkpoint written, and then act as usual: as a
    rule they end the program. A rank that gets one informs the others, which end too. `progress` includes contacts
    `done_before`, and takes the other ranks to be as far as this one. After the `deadline`, s of the monotonic clock,
    no block begins.
    """
    comm, shown = ensemble.comm, (-1, -1)
    ranks = 1 if comm is None else comm.Get_size()
    with deferred() as asked:
        for done, _ in ensemble:
            now = min(done_before + done * ranks, ensemble.expected), ensemble.expected
            if progress is not None and now != shown:
                progress(*now)
                shown = now
            if deadline is not None and time.monotonic() > deadline:
                ensemble.stop()
            if ranks > 1 and asked.signal is None and comm.Iprobe(tag=_STOP):
                asked.signal = comm.recv(tag=_STOP)
            elif ranks > 1 and asked.signal is not None:
                for rank in set(range(ranks)) - {comm.Get_rank()}:
                    comm.isend(asked.signal, dest=rank, tag=_STOP)
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
def within(deadline: float | None, scene: Scene, what: str) -> Iterator[None]:
    """Raise InputError within once the deadline, in s of the monotonic clock, has passed."""
    try:
        with no_longer_than(None if deadline is None else deadline - time.monotonic()):
            yield
    except TimeIsUp:
        hint = f"is over before {what} is solved; give more, or ask for less"
        refuse("wall_time", scene.wall_time, hint)


def solve_master(
    scene: Scene, tolerance: float, refined: Callable[[float], None] | None = None
) -> SolvedRecord:
    """The master equation's answer along the scene's drive; `refined` is called with each error on the way. Raises
    InputError where there is none; the message says so if the scene's ensemble would run without [master]."""
    import master

    drive, contacts = scene.drive, scene.contacts
    asked: dict[str, Any] = {"velocity": drive.velocity, "time": drive.time}
    asked |= {"progress": refined} if refined is not None else {}
    if drive.spring is not None:
        asked |= {name: getattr(drive, name) for name in ("spring", "slip", "mass", "damping")}
    try:
        with laws.inside("master", {"tolerance": "tolerance"}):
            solved: Any = master.solve(contacts, scene.path, tolerance, **asked)
            if not solved.path.size:
                raise InputError(solved.message)
    except InputError as error:
        if scene.eq is None or contacts.each_by_itself() is not contacts:
            raise
        raise InputError(f"{error}; without [master] the scene's [eq] runs alone") from error
    found = record_of(solved)
    if found.regime is not None:
        reason = f"{found.regime.reason}{of_so_many(scene, found.regime)}"
        found = replace(found, regime=replace(found.regime, reason=reason))
    # without a tolerance an error that is hardly visible in a picture will do
    as_asked = scene.tolerance_given or found.success or found.path.size != scene.path.size
    if as_asked or not found.force_error <= 1e-3:
        return found
    said = f"error {found.force_error:.1e} of <x_s>; no tolerance was asked for"
    return replace(found, success=True, message=said)


def make_ensemble(scene: Scene, asked: EqTable, comm: Any, **other: Any) -> Any:
    """The ensemble of the scene's [eq]; `other` arguments of its class replace those of the table. Raises InputError
    with the scene's own keys."""
    import eq_model

    drive, contacts = scene.drive, scene.contacts
    if scene.master is not None:
        # single contacts have no mean rate and no common P_c: they show the error of these closures
        contacts = contacts.each_by_itself()
    arguments: dict[str, Any] = {name: getattr(asked, key) for name, key in _EQ_KEYS.items()}
    arguments |= {"comm": comm, "threads": asked.threads or cores_of(comm)}
    arguments |= {"histograms": scene.histogram_points()}
    motion = ("velocity", "time", "spring", "slip", "mass", "damping")
    arguments |= {name: getattr(drive, name) for name in motion}
    with laws.inside("eq", _EQ_KEYS):
        return eq_model.Ensemble(contacts, scene.path, **(arguments | other))
