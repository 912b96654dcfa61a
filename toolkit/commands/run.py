"""mesofriction run SCENE: every solver the scene names, its error and run time, result files and a picture."""

import argparse
import sys
from typing import Any

ALL_RANKS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """SCENE and --out."""
    parser.add_argument("scene", metavar="SCENE", help="a scene file, or the name of a shipped scene")
    parser.add_argument("--out", metavar="DIR", help="folder for the results (default: ./NAME-output)")


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Run, report, write; 1 where a solver did not reach its tolerance (the results are written all the same)."""
    from toolkit.files import save
    from toolkit.folders import check_folder
    from toolkit.progress import Progress
    from toolkit.ranks import on_root
    from toolkit.running import run
    from toolkit.scene import load_scene

    scene = load_scene(arguments.scene, comm=comm)
    folder = arguments.out or f"{scene.name}-output"
    # refused before the work, not after it
    on_root(comm, lambda: check_folder(folder))
    first = comm is None or comm.Get_rank() == 0
    result = run(scene, comm=comm, progress=Progress() if first else None)
    for line in report(result):
        print(line)
    on_root(comm, lambda: save(result, folder))
    print(f"written to {folder}")
    if result.master is not None and not result.master.success:
        if first:
            print(f"mesofriction: master: {result.master.message}", file=sys.stderr)
        return 1
    return 0


def report(result: Any) -> list[str]:
    """A line for a rough surface, one per solver with its error and its run time, then the notes."""
    from toolkit.interfaces import in_a_line
    from toolkit.results import AgeingRecord, SoftRecord

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
            period = f", period {solved.period:.6g}" if solved.slip_drive.size > 1 else ""
            lines.append(f"regime  {solved.verdict}, {slips}{period}: {solved.reason}")
        if isinstance(solved, AgeingRecord):
            lines.append(
                f"(Q15)   P_c: mass off by up to {abs(solved.mass_defect).max():.1e}, weight below 0 up to "
                f"{solved.positivity_defect.max():.1e}; " + _outrun(solved.outrun)
            )
    if result.eq is not None:
        eq = result.eq
        error = eq.force_standard_error.max() / result.mean_threshold
        lines.append(
            f"eq      error {error:.1e} of <x_s> (largest standard error)  run time {eq.run_time:.4f} s, "
            f"compiled in {eq.compile_time:.2f} s  {int(eq.breaks):,} breaks on {len(eq.breaks_per_rank)} rank(s)"
        )
    if result.master is not None and result.eq is not None:
        from toolkit.deviation import why_not_compared, worst_deviation

        apart = worst_deviation(result)
        if apart is None:
            lines.append(f"eq less master: not compared: {why_not_compared(result)}")
        else:
            lines.append(f"eq less master: at most {apart:.1f} standard errors over the path; chance makes about 3")
    return [*lines, *(f"note    {note}" for note in result.notes)]


def _outrun(position: float) -> str:
    if position == float("inf"):
        return "contacts never outrun it"
    return f"contacts outrun it from X = {position:.4g} on, and what follows is one of many answers"
