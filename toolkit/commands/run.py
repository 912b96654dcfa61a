"""mesofriction run SCENE: every solver the scene names, its error and run time, result files and a picture."""

import argparse
import sys
from contextlib import closing, nullcontext
from typing import Any

_FELT, _APART = 0.3, 6.0  # of a standard error, and so many of them

ALL_RANKS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """SCENE, --out, --checkpoint and --dry-run."""
    parser.add_argument(
        "scene", metavar="SCENE", help="a scene file, or the name of a shipped scene"
    )
    parser.add_argument(
        "--out", metavar="DIR", help="folder for the results (default: ./NAME-output)"
    )
    parser.add_argument(
        "--checkpoint",
        metavar="SECONDS",
        type=float,
        default=60.0,
        help="how often a long ensemble writes what it has found into DIR, from which the same command goes on "
        "(default: 60)",
    )
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="tell work, memory, time and error by small pilots; write nothing",
    )


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Run, report, write; 1 where a solver did not reach its tolerance (the results are written all the same)."""
    from toolkit.running.compiling_notice import CompilingNotice
    from toolkit.running.progress import Progress, Refinement
    from toolkit.running.runner import foreseen, open_checkpoint, solve, write
    from toolkit.scene.scene import load_scene

    scene = load_scene(arguments.scene, comm=comm)
    first = comm is None or comm.Get_rank() == 0
    for note in foreseen(scene) if first else []:
        print(f"mesofriction: {note}", file=sys.stderr, flush=True)
    notice = CompilingNotice() if first else nullcontext()
    folder = arguments.out or f"{scene.name}-output"
    if arguments.dry_run:
        with notice:
            told = _foretold(scene, folder, comm)
        print("\n".join(told))
        return 0
    # refused before the work, not after it
    with open_checkpoint(folder, scene, comm, arguments.checkpoint) as kept:
        with notice, closing(Progress()) as progress:
            result, finished = solve(
                scene, comm, progress if first else None, kept, Refinement if first else None
            )
        for line in report(result):
            print(line)
        write(result, folder, comm, kept if finished else None)
    print(f"written to {folder}")
    for name, answer in (("master", result.master), ("eq", result.eq), ("sweep", result.sweep)):
        if answer is not None and not answer.success and first:
            print(f"mesofriction: {name}: {answer.message}", file=sys.stderr)
    return 0 if result.success else 1


def _foretold(scene: Any, folder: str, comm: Any) -> list[str]:
    """What a run of the scene into this folder will take, in lines."""
    from toolkit.running.checkpoint import Checkpoint
    from toolkit.running.coupled import coupled_lines
    from toolkit.running.forecast import forecast, lines, pilot, pilot_lines

    told = [scene.title or scene.name]
    # one of another scene is refused, as the run would
    done = (
        sum(state.contacts for state in Checkpoint(folder, scene, comm).earlier())
        if scene.eq is not None
        else 0
    )
    if scene.master is not None:
        told += pilot_lines(pilot(scene))
    if scene.sweep is not None:
        told.append(
            f"sweep           {scene.sweep.velocity.size:,} points; their time is not foreseen"
        )
    if scene.eq is not None and scene.drive.spring is not None:
        told += coupled_lines(scene, scene.eq, comm, done)
    elif scene.eq is not None:
        told += lines(forecast(scene, comm, done))
    return told


def report(result: Any) -> list[str]:
    """A line for a rough surface, one per solver with its error and its run time, then the notes."""
    from toolkit.results.records import AgeingRecord, CoupledRecord, SoftRecord
    from toolkit.running.coupled import slip_lines
    from toolkit.scene.interfaces import in_a_line, with_error

    lines = [result.title or result.name]
    if result.interface is not None:
        lines.append(f"surface {in_a_line(result.interface)}")
    if result.master is not None:
        solved = result.master
        lines.append(
            f"master  error {solved.force_error:.1e} of <x_s>  run time {solved.run_time:.4f} s  "
            f"{solved.path.size} points"
        )
        if isinstance(solved, SoftRecord):
            slips = f"{solved.slip_drive.size} slips"
            period = f", period {with_error(solved.period, 2.0 * solved.slip_drive_error, 9)}"
            period = period if solved.slip_drive.size > 1 else ""
            lines.append(f"regime  {solved.verdict}, {slips}{period}: {solved.reason}")
        if isinstance(solved, AgeingRecord):
            lines.append(
                f"(Q15)   P_c: mass off by up to {abs(solved.mass_defect).max():.1e}, weight below 0 up to "
                f"{solved.positivity_defect.max():.1e}; " + _outrun(solved.outrun)
            )
    if result.sweep is not None:
        sweep = result.sweep
        springs = (
            ""
            if sweep.critical_spring_error is None
            else f", K* error {sweep.critical_spring_error.max():.1e}"
        )
        lines.append(
            f"sweep   error {sweep.force_error.max():.1e} of <x_s>{springs}  run time {sweep.run_time:.4f} s  "
            f"{sweep.force.size} points along {' and '.join(sweep.along)}"
        )
    if result.eq is not None:
        eq = result.eq
        error = eq.force_standard_error.max() / result.mean_threshold
        steps = eq.step_error.max() / result.mean_threshold
        besides = f", steps of ageing {steps:.1e}" if steps else ""
        lines.append(
            f"eq      error {error:.1e} of <x_s> (largest standard error{besides})  run time {eq.run_time:.4f} s, "
            f"compiled in {eq.compile_time:.2f} s  {int(eq.breaks):,} breaks on {len(eq.breaks_per_rank)} rank(s)"
        )
    if isinstance(result.eq, CoupledRecord):
        lines += slip_lines(result)
    elif result.master is not None and result.eq is not None:
        from toolkit.judge.deviation import why_not_compared, worst_deviation

        apart = worst_deviation(result)
        if apart is None:
            lines.append(f"eq less master: not compared: {why_not_compared(result)}")
        else:
            own = (
                result.master.force_error
                * result.mean_threshold
                / float(result.eq.force_standard_error.max())
            )
            besides = f" (each with master's own error, {own:.1g} of one)" if own > _FELT else ""
            chance = "chance makes about 3" + (
                "" if apart < _APART else ": they do not agree, please report it"
            )
            if result.papers_closure:
                chance = "chance makes about 3, the rest is the paper's closure, which single contacts do not follow"
            lines.append(
                f"eq less master: at most {apart:.1f} standard errors{besides} over the path; {chance}"
            )
    return [*lines, *(f"note    {note}" for note in result.notes)]


def _outrun(position: float) -> str:
    if position == float("inf"):
        return "contacts never outrun it"
    return f"contacts outrun it from X = {position:.4g} on, and what follows is one of many answers"
