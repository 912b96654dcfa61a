"""What a run prints of its result: a line for each solver with its error and its run time."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from toolkit.results.beside import NOT_COMPARED, deviation, slip_line
from toolkit.results.kinds import HARDLY_SEEN, is_coupled, is_known_without_heat, is_precise
from toolkit.results.numbers import in_words, is_rough
from toolkit.results.verdicts import DISAGREE, contradiction
from toolkit.scene.interfaces import in_a_line
from toolkit.scene.scale import spoken, with_error, with_uncertainty

_SEEN = 1e-6  # of a period: a smaller error, numerical as a rule, is not told
APART = 6.0  # standard errors at which both solvers do not agree; chance makes about 3


def report(result: Any) -> list[str]:
    """A line for a rough surface, one per solver with its error and its run time, then the notes."""
    parts = _of_surface, _of_master, _of_sweep, _of_ensemble, _of_both
    return [
        result.title or result.name,
        *(line for part in parts for line in part(result)),
        *(f"note    {note}" for note in result.notes),
    ]


def _of_surface(result: Any) -> Iterator[str]:
    """What contradicts its verdict, if anything does; and of a rough surface its numbers."""
    if apart := contradiction(result):
        yield f"verdict {apart}"
    if result.interface is not None:
        along = () if result.sweep is None else result.sweep.along
        swept = any(key.startswith("contacts.thresholds") for key in along)
        without = "without the sweep: " if swept else ""
        yield f"surface {without}{in_a_line(result.interface)}"
        yield from in_words(result)


def _of_master(result: Any) -> Iterator[str]:
    """Of the master equation its error, the regime of a slider, and what its slips do in time."""
    solved = result.master
    if solved is None:
        return
    nothing = not np.isfinite(solved.force_error)
    error = f"numerical error {result.scale.error(solved.force_error, result.mean_threshold)}"
    if solved.success and is_rough(result):
        error = "solved to its tolerance (numerical errors are in summary.json)"
        if is_known_without_heat(solved) and solved.force_error > HARDLY_SEEN:
            error = "solved without heat, whose bound is the error of its numbers"
    # its message, which the command ends with, says why
    accuracy = "not solved" if nothing else error
    yield f"master  {accuracy}  run time {solved.run_time:.4f} s  {solved.path.size} points"
    if solved.slips is not None and not nothing:
        yield from _of_slips(result)
    if solved.outrun is not None:
        where = f"from X = {solved.outrun:.4g} on" if solved.outrun < float("inf") else "nowhere"
        yield (
            f"(Q15)   P_c: mass off by up to {abs(solved.mass_defect).max():.1e}, weight below 0 up to "
            f"{solved.positivity_defect.max():.1e}; contacts outrun it {where}"
        )


def _of_slips(result: Any) -> Iterator[str]:
    """The regime of a slider by the master equation, and of one with mass the motion in its slips."""
    solved = result.master
    period_text = ""
    if is_precise(solved) and solved.slips.period is not None:
        error = solved.slips.period_error
        period = with_error(solved.period, error * (error > _SEEN * solved.period), 6)
        if result.thresholds.in_metres:
            period = with_uncertainty(solved.period, error, "m", 3 if is_rough(result) else 4)
        period_text = f", last period {period}"
    yield f"regime  {solved.regime.verdict}{period_text}: {solved.regime.reason}"
    if solved.energy is not None and solved.slips.drive.size and is_precise(solved):
        lasts = spoken(solved.slips.duration.mean(), result.scale.time_unit)
        fastest = spoken(abs(solved.slips.top_speed).max(), result.scale.speed_unit)
        yield f"motion  slips last {lasts} on average, top speed {fastest}"


def _of_sweep(result: Any) -> Iterator[str]:
    """How many points a sweep has, with their errors, or with how many are of which regime."""
    sweep = result.sweep
    if sweep is None:
        return
    along = f"points along {' and '.join(sweep.along)}"
    if sweep.smooth:
        error = f"error {result.scale.error(sweep.force_error.max(), result.mean_threshold)}"
        if sweep.critical_spring_error is not None:
            error += f", K* error {sweep.critical_spring_error.max():.1e}"
        yield f"sweep   {error}  run time {sweep.run_time:.4f} s  {sweep.force.size} {along}"
        return
    took = f"{sweep.run_time:.4g} s of work"
    yield f"sweep   {sweep.size} {along}, {took}; their table is sweep.csv"
    if "regime" in sweep.columns:
        known = Counter(map(_regime, sweep["regime"].tolist(), sweep["message"].tolist()))
        each = [f"{verdict or 'not known'} at {n}" for verdict, n in known.most_common()]
        yield f"regime  {', '.join(each)} of the points{_farthest(result)}"


def _of_ensemble(result: Any) -> Iterator[str]:
    """The errors of the ensemble, and its slips."""
    eq, mean = result.eq, result.mean_threshold
    if eq is None:
        return
    errors = eq.force_standard_error.max(), eq.step_error.max()
    error, steps = (result.scale.error(each / mean, mean) for each in errors)
    besides = f"; of the time steps of ageing {steps}" * bool(errors[1])
    # of sliders that slip each at its own place the mean force is that of none of them
    whose = ""
    if is_coupled(eq) and eq.slips.number.size:
        whose = f", between {len(eq.forces)} sliders where some have slipped"
    yield (
        f"eq      standard error {error} at most{besides}{whose}  run time {eq.run_time:.4f} s, "
        f"compiled in {eq.compile_time:.2f} s  {int(eq.breaks):,} breaks on {len(eq.breaks_per_rank)} rank(s)"
    )
    if is_coupled(eq):
        yield slip_line(result)


def _of_both(result: Any) -> Iterator[str]:
    """How far both solvers are apart, but of sliders whose slips agree, which are told as they are."""
    there = result.master is not None and result.eq is not None
    if there and not (is_coupled(result.eq) and agreeing(result)):
        yield f"eq less master: {_agreement(result)}"


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
