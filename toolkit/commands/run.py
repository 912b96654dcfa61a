"""mesofriction run SCENE: every solver the scene names, its error and run time, result files and a picture."""

import argparse
import sys
from typing import Any

_FELT, _APART = 0.3, 6.0  # of a standard error, and so many of them

ALL_RANKS = True


def execute(arguments: argparse.Namespace, comm: Any) -> int:
    """Run, report, write; 1 where a solver did not reach its tolerance (the results are written all the same)."""
    from toolkit.running.notes import foreseen
    from toolkit.running.runner import open_checkpoint, solve, write
    from toolkit.scene.scene import load_scene

    scene = load_scene(arguments.scene, comm=comm)
    first = comm is None or comm.Get_rank() == 0
    for note in foreseen(scene) if first else []:
        print(f"mesofriction: {note}", file=sys.stderr, flush=True)
    folder = arguments.out or f"{scene.name}-output"
    if arguments.dry_run:
        from toolkit.running.forecast import forecast_lines

        print("\n".join(forecast_lines(scene, folder, comm)))
        return 0
    # refused before the work, not after it
    with open_checkpoint(folder, scene, comm, arguments.checkpoint) as kept:
        result, finished = solve(scene, comm, kept=kept, told=first)
        print("\n".join(report(result)))
        write(result, folder, comm, kept if finished else None)
    print(f"written to {folder}")
    for name, answer in (("master", result.master), ("eq", result.eq), ("sweep", result.sweep)):
        if answer is not None and not answer.success and first:
            print(f"mesofriction: {name}: {answer.message}", file=sys.stderr)
    return 0 if result.success else 1


def report(result: Any) -> list[str]:
    """A line for a rough surface, one per solver with its error and its run time, then the notes."""
    from toolkit.results.records import AgeingRecord, SoftRecord, is_coupled
    from toolkit.results.slips import slip_lines
    from toolkit.scene.interfaces import in_a_line, with_error

    lines, solved, eq, sweep = [result.title or result.name], result.master, result.eq, result.sweep
    if result.interface is not None:
        lines.append(f"surface {in_a_line(result.interface)}")
    if solved is not None:
        error = f"error {solved.force_error:.1e} of <x_s>"
        lines.append(
            f"master  {error}  run time {solved.run_time:.4f} s  {solved.path.size} points"
        )
    if isinstance(solved, SoftRecord):
        slips = f"{solved.slips.drive.size} slips"
        if solved.slips.drive.size > 1:
            drops = abs(solved.slips.drop)
            # where large and small slips take turns no single pause is their period
            name = "period" if abs(drops[-1] - drops[-2]) < 0.1 * drops[-2] else "last pause"
            slips += f", {name} {with_error(solved.period, 2.0 * solved.slips.drive_error, 9)}"
        lines.append(f"regime  {solved.regime.verdict}, {slips}: {solved.regime.reason}")
    if isinstance(solved, AgeingRecord):
        outrun = "contacts never outrun it"
        if solved.outrun < float("inf"):
            outrun = f"contacts outrun it from X = {solved.outrun:.4g} on, and what follows is one of many answers"
        lines.append(
            f"(Q15)   P_c: mass off by up to {abs(solved.mass_defect).max():.1e}, weight below 0 up to "
            f"{solved.positivity_defect.max():.1e}; {outrun}"
        )
    if sweep is not None:
        error = f"error {sweep.force_error.max():.1e} of <x_s>"
        if sweep.critical_spring_error is not None:
            error += f", K* error {sweep.critical_spring_error.max():.1e}"
        points = f"{sweep.force.size} points along {' and '.join(sweep.along)}"
        lines.append(f"sweep   {error}  run time {sweep.run_time:.4f} s  {points}")
    if eq is not None:
        error = eq.force_standard_error.max() / result.mean_threshold
        steps = eq.step_error.max() / result.mean_threshold
        besides = f", steps of ageing {steps:.1e}" if steps else ""
        lines.append(
            f"eq      error {error:.1e} of <x_s> (largest standard error{besides})  run time {eq.run_time:.4f} s, "
            f"compiled in {eq.compile_time:.2f} s  {int(eq.breaks):,} breaks on {len(eq.breaks_per_rank)} rank(s)"
        )
    if is_coupled(eq):
        lines += slip_lines(result)
    elif solved is not None and eq is not None:
        lines.append(_agreement(result))
    return [*lines, *(f"note    {note}" for note in result.notes)]


def _agreement(result: Any) -> str:
    """A line on the difference of both solvers."""
    from toolkit.judge.deviation import why_not_compared, worst_deviation

    apart = worst_deviation(result)
    if apart is None:
        return f"eq less master: not compared: {why_not_compared(result)}"
    error = result.master.force_error * result.mean_threshold
    own = error / float(result.eq.force_standard_error.max())
    besides = f" (each with master's own error, {own:.1g} of one)" if own > _FELT else ""
    chance = "chance makes about 3"
    if result.papers_closure:
        chance += ", the rest is the paper's closure, which single contacts do not follow"
    elif apart >= _APART:
        chance += ": they do not agree, please report it"
    return f"eq less master: at most {apart:.1f} standard errors{besides} over the path; {chance}"
