"""Run a scene: each solver it names, and no other."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, nullcontext
from os import PathLike
from typing import Any

from origins.errors import NothingInTimeError
from origins.samples.from_samples import sampled_parts
from toolkit.processes.ranks import on_root
from toolkit.processes.signals import Terminated
from toolkit.results.files import another
from toolkit.results.folders import check_folder, only_writer
from toolkit.results.records import Result, sample_curve
from toolkit.running.checkpoint import EVERY, Checkpoint, say
from toolkit.running.left_out import with_change_of_f_k
from toolkit.running.points import forget_points, solve_points
from toolkit.running.progress import Progress
from toolkit.running.rules import beside_other_rules
from toolkit.running.solvers import (
    EQ_KEYS,
    follow,
    make_ensemble,
    solve_master,
    solve_sweep,
    within,
)
from toolkit.saving import save
from toolkit.scene import laws
from toolkit.scene.drive import MACHINE_KEYS
from toolkit.scene.interfaces import foreseen, of_interface, remarks
from toolkit.scene.scene import Scene, load_scene
from toolkit.version import __version__

# In s: what the master equation may take beyond a wall_time to end with what it has; and the least time it is given.
TO_END, LEAST_TIME = 2.0, 1e-3
# of thresholds from samples
NUMERICAL_ONLY = "errors are numerical only, not those of the samples: `mesofriction thresholds` tells sampling errors"


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
    with ExitStack() as stack:

        def hold() -> None:
            check_folder(folder)
            stack.enter_context(only_writer(folder))
            if (other := another(folder, scene.name, scene.text)) is not None:
                say(f"{folder}: holds the result of {other}, which this run will replace")

        on_root(comm, hold)
        yield Checkpoint(folder, scene, comm, every)


def write(
    result: Result, comm: Any, kept: Checkpoint, finished: bool, formats: Sequence[str] = ()
) -> None:
    """Save the result in the checkpoint's folder, on rank 0, its pictures in `formats` beside PNG, and then remove the
    checkpoint if the run is finished."""

    def on_first() -> None:
        save(result, kept.folder, formats)
        if result.sweep is not None and not result.sweep.smooth:
            forget_points(kept.folder / "checkpoint")
        elif finished and result.eq is not None:  # else a checkpoint there is that of another scene
            kept.remove()

    try:
        on_root(comm, on_first)
    except (KeyboardInterrupt, Terminated) as stop:
        if result.eq is not None:
            stop.add_note(kept.note)
        raise


def solve(
    scene: Scene,
    comm: Any,
    progress: Callable[[int, int], None] | None = None,
    kept: Checkpoint | None = None,
    show_progress: bool = False,
    say_before: Sequence[str] = (),
) -> tuple[Result, bool]:
    """Run the scene's solvers, showing progress on stderr if asked; returns the result and whether it is finished.

    `say_before`: what the user is told before the work, but after an ensemble that is refused, which is told alone.
    """
    if scene.grid is not None:
        return _solve_points(scene, comm, progress, kept, show_progress), True
    law, deadline = scene.contacts.thresholds, scene.deadline()

    def shown(what: str) -> Any:
        return closing(Progress(what)) if show_progress else nullcontext()

    ensemble, before, nothing = None, 0, list[str]()
    master = sweep = eq = None
    if scene.eq is not None:  # made first, so that it refuses bad input before any work
        with shown("eq"):
            earlier = [] if kept is None else kept.earlier()
            before = sum(state.contacts for state in earlier)
            ensemble = make_ensemble(scene, scene.eq, comm, earlier=earlier)
        del earlier  # the ensemble has a copy of these sums; free the memory
    for note in say_before:
        say(note)
    if scene.master is not None:
        last = None if deadline is None else deadline + TO_END
        with shown("master equation") as bar, within(last, scene, "[master]"):
            left = None if deadline is None else max(deadline - time.monotonic(), LEAST_TIME)
            master = solve_master(scene, scene.master.tolerance, bar and bar.refine, left)
    if scene.sweep is not None:
        with shown("sweep"), within(deadline, scene, "[sweep]"):
            sweep = solve_sweep(scene.contacts, scene.sweep)
    if ensemble is not None:
        with laws.inside("eq", EQ_KEYS), shown("eq") as bar:
            try:
                eq = follow(ensemble, bar.count if bar else progress, kept, before, deadline)
            except NothingInTimeError as over:
                asked: Any = scene.eq
                nothing = [f"{'' if asked.wall_time is None else 'eq.'}{over}"]
        if nothing and master is None and sweep is None:
            raise NothingInTimeError(*nothing)
    notes = [*nothing, *remarks(law), *foreseen(scene)]
    if sampled_parts(law):
        notes.append(NUMERICAL_ONLY)
    soft: Any = master if master is not None and master.regime is not None else None
    if soft is not None:
        notes += [with_change_of_f_k(scene, soft)] if soft.note else []
        with shown("slip rules"):
            notes += beside_other_rules(scene, soft, deadline)
    if before:
        all_of_them = ensemble.total if ensemble is not None else before
        notes.append(
            f"went on from a checkpoint of {before:,} of {all_of_them:,} contacts: the run time of eq is that of all "
            "launches together, and breaks_per_rank counts the earlier ones' on rank 0"
        )
    answers = {"master": master, "eq": eq, "sweep": sweep, "domains": law.domains}
    result = _result(scene, notes, **answers)
    finished = ensemble is None or eq is None or eq.success or eq.contacts == ensemble.total
    if kept is not None and not finished and (comm is None or comm.Get_rank() == 0):
        far = f" after {eq.contacts:,} of {ensemble.total:,} contacts" if ensemble and eq else ""
        say(f"stopped by the wall time{far}; run it again with --out {kept.folder} to go on")
    return result, finished


def _solve_points(
    scene: Scene, comm: Any, progress: Any, kept: Checkpoint | None, show_progress: bool
) -> Result:
    """The result of a sweep over keys of the scene: all its points, beside the thresholds of the scene itself."""
    home = None if kept is None else kept.folder / "checkpoint"
    shown: Any = closing(Progress("sweep", "points")) if show_progress else nullcontext()
    with shown as bar, within(scene.deadline(), scene, "[sweep]"):
        record = solve_points(scene, comm, home, bar.count if bar else progress)
    notes, table = remarks(scene.contacts.thresholds), scene.drive_table
    if sampled_parts(scene.contacts.thresholds):
        notes.append(NUMERICAL_ONLY)
    by_rule = "regime" in record.columns and not {"drive.slip", "drive.mass"} & {*record.along}
    if by_rule and table is not None and table.mass is None:
        notes.append(
            f'the regimes are those of drive.slip = "{table.slip or "reset"}", and other rules may have others: sweep '
            'over "drive.slip" = ["reset", "reform-after", "instant"], too'
        )
    of_machine = [key for key in record.along if key in MACHINE_KEYS]
    if of_machine and scene.master is None and scene.eq is None:
        notes.append(
            f"{' and '.join(of_machine)}: no number hangs on it here, as all are of a rigid slider; for slips add "
            "drive.to and [master]"
        )
    return _result(scene, notes, sweep=record)


def _result(scene: Scene, notes: Iterable[str], **answers: Any) -> Result:
    """The answers of a scene, beside its thresholds and its surface."""
    interface = scene.contacts.interface
    return Result(
        name=scene.name,
        title=scene.title,
        text=scene.text,
        version=__version__,
        mean_threshold=scene.contacts.mean_threshold,
        thresholds=sample_curve(scene.contacts.thresholds),
        interface=None if interface is None else of_interface(interface),
        notes=tuple(notes),
        **({"master": None, "eq": None} | answers),
    )
