"""What a solution of a soft slider says of its behaviour, and how well that is known."""

from dataclasses import replace
from typing import Any

import numpy as np

from origins.drive import SLIP_FRACTION
from toolkit.results.kinds import is_precise, kind_of
from toolkit.results.mean_of_pairs import mean_of_pairs
from toolkit.results.slips import slips_to_tell
from toolkit.results.traces import with_slips
from toolkit.scene.scale import ROUNDING
from toolkit.verdict.sliders.budget import late
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.sliders.slips_in_time import slips_in_time

# Error, in mean thresholds, up to which a regime and its forces are told, the error beside them.
PRECISE_ENOUGH = 0.05


def error_of(solved: Any) -> float:
    """The error of the forces that are told of a solution, in mean thresholds. Of a slider with mass that slips it is
    that of the forces of its slips: these may be known where the force at a point of the path is not, as it is nearer
    to a slip than the slip's time is known. Of smooth sliding the force at the path's end is told, and its error."""
    slips = solved.slips
    with_mass = hasattr(slips, "duration")
    if not with_mass or not slips.drive.size or kind_of(solved) == "smooth":
        return float(solved.force_error)
    return float(min(solved.force_error, slips.force_error))


def is_known(solved: Any) -> bool:
    """Whether the forces of a solution are known well enough to be told."""
    return is_precise(solved) or error_of(solved) < PRECISE_ENOUGH


def hangs_on_heat(found: Behaviour) -> bool:
    """Whether heat was left out that may take a slip away, or bring one about: any other changes the force by less."""
    from master.soft.in_time.idle_heat import WEAK_EFFECT

    return found.heat_left_out is not None and found.heat_left_out >= WEAK_EFFECT


def _peak_before(solved: Any, slip: int, velocity: float) -> float:
    """The largest force at points of the path from the end of the slip before this one to its begin."""
    slips, since = solved.slips, 0
    if slip:
        end = slips.drive[slip - 1] + velocity * (
            slips.duration[slip - 1] if hasattr(slips, "duration") else 0.0
        )
        since = np.searchsorted(solved.path, end, "right")
    forces = solved.force[since : np.searchsorted(solved.path, slips.drive[slip])]
    return float(np.max(forces, initial=slips.force_before[slip]))


def behaviour_of(rule: str, solved: Any, velocity: float, unit: float, open_why: str) -> Behaviour:
    """What the solution of a soft slider says: no figure where its force is not known. `unit` : the mean threshold;
    `open_why` : why it is not known whether the slider will slip again, "" where that is to be seen."""
    if not is_known(solved):
        why = solved.message
        if "stopped by wall_time" in why:  # the path and its tolerance are the verdict's own
            why = late(why)
        unknown = not_followed(rule, why.partition("; take eq_model")[0])
        unknown = replace(unknown, heat_left_out=solved.heat_left_out)
        return replace(unknown, error=solved.force_error, run_time=solved.run_time)
    judged = error_of(solved)
    # a bound on heat that was left out is told beside the answer, and no more time lowers it
    followed_to = judged - (solved.heat_left_out or 0.0)
    # where slips are known, and points of the path beside them are not, the solver's message is of these points
    told = solved.success or judged < min(solved.force_error, PRECISE_ENOUGH)
    slips, kind = solved.slips, "undecided" if open_why else kind_of(solved)
    last = float(solved.force[-1]) if solved.force.size else float("nan")
    before, after, period, error = last, last, solved.period, judged
    period_error, peak = 0.0 if period is None else float(slips.period_error), last
    if slips.drive.size and kind in ("stick-slip", "undecided"):
        shown = slips_to_tell(slips, kind == "stick-slip")
        forces = slips.force_before[shown], slips.force_after[shown]
        before, after = (float(one.mean()) for one in forces)
        peak = float(np.mean([_peak_before(solved, one, velocity) for one in shown]))
        if shown.size > 1:
            # as many gaps as slips, with that before the first of them
            period, scatter = mean_of_pairs(np.diff(slips.drive[slips.main])[-shown.size :])
            period_error += scatter
            error += mean_of_pairs(slips.drop[shown]).error / unit
        after = after if abs(after) > ROUNDING * abs(before) else 0.0
    shrinks, left = max(-(solved.regime.trend or 0.0), 0.0), 0.0
    if shrinks and solved.period:  # drops go on to shrink as they did
        silent = float(solved.path[-1] - slips.drive[-1]) / solved.period
        left = float(slips.drop[-1] * (1.0 - shrinks) ** silent)
    part = solved.regime.largest_slip
    # by other rules contacts that break together come back together, so that such slips may grow to all of them
    alike = rule == "reset" and slips.drive.size > 1
    no_slips = kind == "undecided" and not open_why and alike
    drive, force = with_slips(solved, velocity)
    return Behaviour(
        rule=rule,
        kind=kind,
        before=before,
        after=after,
        peak=peak,
        period=period,
        period_error=period_error,
        slips=slips.drive.size,
        smaller=slips.drive.size - slips.main.size,
        error=error,
        success=bool(solved.success or (kind != "undecided" and followed_to < PRECISE_ENOUGH)),
        message=open_why or (solved.regime.reason if told else solved.message),
        run_time=solved.run_time,
        heat_left_out=solved.heat_left_out,
        shrinks_by=shrinks,
        left=left,
        few_break=part if no_slips and part is not None and part < SLIP_FRACTION else None,
        drive=drive,
        force=force,
        in_time=slips_in_time(slips),
    )
