"""What a run prints of its result: a line for each solver with its error and its run time."""

from collections import Counter
from typing import Any

import numpy as np

from toolkit.results.beside import NOT_COMPARED, deviation, slip_line
from toolkit.results.kinds import (
    HARDLY_SEEN,
    is_coupled,
    is_known_without_heat,
    is_precise,
)
from toolkit.results.numbers import in_words, is_rough
from toolkit.results.verdicts import DISAGREE, contradiction
from toolkit.scene.interfaces import in_a_line
from toolkit.scene.scale import spoken, with_error, with_uncertainty

_SEEN = 1e-6  # of a period: a smaller error, numerical as a rule, is not told
APART = 6.0  # standard errors at which both solvers do not agree; chance makes about 3


def report(result: Any) -> list[str]:
    """A line for a rough surface, one per solver with its error and its run time, then the notes."""
    lines = [result.title or result.name]
    solved, eq, sweep = result.master, result.eq, result.sweep
    if apart := contradiction(result):
        lines.append(f"verdict {apart}")
    if result.interface is not None:
        along = () if sweep is None else sweep.along
        swept = any(key.startswith("contacts.thresholds") for key in along)
        without = "without the sweep: " if swept else ""
        lines.append(f"surface {without}{in_a_line(result.interface)}")
        lines += in_words(result)
    nothing = solved is not None and not np.isfinite(solved.force_error)
    if solved is not None:
        error = f"numerical error {result.scale.error(solved.force_error, result.mean_threshold)}"
        if solved.success and is_rough(result):
            error = "solved to its tolerance (numerical errors are in summary.json)"
            if is_known_without_heat(solved) and solved.force_error > HARDLY_SEEN:
                error = "solved without heat, whose bound is the error of its numbers"
        took = f"{solved.run_time:.4f} s"
        # its message, which the command ends with, says why
        accuracy = "not solved" if nothing else error
        lines.append(f"master  {accuracy}  run time {took}  {solved.path.size} points")
    if solved is not None and solved.slips is not None and not nothing:
        error = solved.slips.period_error
        period = with_error(solved.period, error * (error > _SEEN * solved.period), 6)
        if result.thresholds.in_metres:
            period = with_uncertainty(solved.period, error, "m", 3 if is_rough(result) else 4)
        periodic = is_precise(solved) and solved.slips.period is not None
        period_text = f", last period {period}" if periodic else ""
        lines.append(f"regime  {solved.regime.verdict}{period_text}: {solved.regime.reason}")
        if solved.energy is not None and solved.slips.drive.size and is_precise(solved):
            lasts = spoken(solved.slips.duration.mean(), result.scale.time_unit)
            fastest = spoken(abs(solved.slips.top_speed).max(), result.scale.speed_unit)
            lines.append(f"motion  slips last {lasts} on average, top speed {fastest}")
    if solved is not None and solved.outrun is not None:
        where = f"from X = {solved.outrun:.4g} on" if solved.outrun < float("inf") else "nowhere"
        lines.append(
            f"(Q15)   P_c: mass off by up to {abs(solved.mass_defect).max():.1e}, weight below 0 up to "
            f"{solved.positivity_defect.max():.1e}; contacts outrun it {where}"
        )
    if sweep is not None and not sweep.smooth:
        at = f"{sweep.size} points along {' and '.join(sweep.along)}"
        lines.append(f"sweep   {at}, {sweep.run_time:.4g} s of work; their table is sweep.csv")
        if "regime" in sweep.columns:
            known = Counter(map(_regime, sweep["regime"].tolist(), sweep["message"].tolist()))
            each = [f"{verdict or 'not known'} at {n}" for verdict, n in known.most_common()]
            lines.append(f"regime  {', '.join(each)} of the points{_farthest(result)}")
    elif sweep is not None:
        error = f"error {result.scale.error(sweep.force_error.max(), result.mean_threshold)}"
        if sweep.critical_spring_error is not None:
            error += f", K* error {sweep.critical_spring_error.max():.1e}"
        points = f"{sweep.force.size} points along {' and '.join(sweep.along)}"
        lines.append(f"sweep   {error}  run time {sweep.run_time:.4f} s  {points}")
    if eq is not None:
        errors = eq.force_standard_error.max(), eq.step_error.max()
        error, steps = (
            result.scale.error(each / result.mean_threshold, result.mean_threshold)
            for each in errors
        )
        besides = f"; of the time steps of ageing {steps}" * bool(errors[1])
        # of sliders that slip each at its own place the mean force is that of none of them
        whose = ""
        if is_coupled(eq) and eq.slips.number.size:
            whose = f", between {len(eq.forces)} sliders where some have slipped"
        lines.append(
            f"eq      standard error {error} at most{besides}{whose}  run time {eq.run_time:.4f} s, "
            f"compiled in {eq.compile_time:.2f} s  {int(eq.breaks):,} breaks on {len(eq.breaks_per_rank)} rank(s)"
        )
    if is_coupled(eq):
        lines.append(slip_line(result))
    if solved is not None and eq is not None and not (is_coupled(eq) and agreeing(result)):
        lines.append(f"eq less master: {_agreement(result)}")
    return [*lines, *(f"note    {note}" for note in result.notes)]


def _regime(verdict: str, message: str) -> str:
    """The regime of a point, which master's verdict is none of where its ensemble contradicts it."""
    return "told otherwise by the ensemble" if DISAGREE in message else verdict


def _farthest(result: Any) -> str:
    """How far the undecided points of a sweep ask to be driven, the one that asks for most told; "" where none says."""
    sweep = result.sweep
    ways = np.abs(sweep.columns.get("drive_to", np.array([np.nan])))
    if np.isnan(ways).all():
        return ""
    most = int(np.nanargmax(ways))
    at = ", ".join(f"{key} = {sweep[key][most]}" for key in sweep.along)
    how_far = spoken(sweep["drive_to"][most], result.scale.length_unit)
    return (
        f"; undecided ones ask for a longer drive, up to X_T = {how_far} (at {at}): see sweep.csv"
    )


def agreeing(result: Any) -> bool:
    """Whether both solvers agree, as far as chance lets tell; the paper's closures need not."""
    return result.papers_closure or (deviation(result).worst or 0.0) < APART


def _agreement(result: Any) -> str:
    """The difference of both solvers in words."""
    apart = deviation(result).worst
    if apart is None:
        return f"not compared: {NOT_COMPARED}"
    chance = "chance makes about 3"
    if result.papers_closure:
        chance += ", the rest is the paper's closure, which single contacts do not follow"
    elif apart >= APART:
        chance += ": they do not agree, please report it"
    where = "before the first slip" if is_coupled(result.eq) else "over the path"
    return f"at most {apart:.1f} standard errors {where}; {chance}"
