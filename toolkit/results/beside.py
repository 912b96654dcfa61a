"""The two solvers beside each other: forces in standard errors, and slip by slip."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array
from toolkit.results.kinds import is_coupled, is_heavy, is_precise
from toolkit.results.records import Result
from toolkit.results.slips import main_slips
from toolkit.scene.scale import spoken, with_error, with_scatter

_FEWEST = 30  # least number of broken contacts for which standard errors are meaningful
# mean thresholds, times N^(-2/3), by which N contacts on a soft slider bear more than infinitely many: the most that
# was measured, of exponential thresholds on K = 1e-5 (2.4 of thresholds 1 ± 0.2, docs/sliders.md)
_BEYOND = 16.0


class Deviation(NamedTuple):
    """Ensemble minus master equation, `off`, in standard errors, at the `points` (indices) that can be compared."""

    points: npt.NDArray[np.intp]
    off: Array

    @property
    def worst(self) -> float | None:
        """The largest in size; None where there are no points."""
        return float(np.abs(self.off).max()) if self.off.size else None


def deviation(result: Result) -> Deviation:
    """Difference of the solvers where enough contacts have broken to compare; no points where one of them is missing or
    the master equation's force is not known, whose error would allow any difference.
    The standard errors include the master equation's error and that of the ensemble's steps."""
    solved, eq = result.master, result.eq
    if solved is None or eq is None or not is_precise(solved):
        return Deviation(np.empty(0, np.intp), np.empty(0))
    return (_before_slips if is_coupled(eq) else apart)(solved, eq, result.mean_threshold)


def apart(solved: Any, eq: Any, mean_threshold: float) -> Deviation:
    """The same of a solution and an ensemble of independent contacts, records or the solvers' own."""
    of_one_contact = np.minimum(np.abs(eq.path), mean_threshold) / eq.contacts
    enough = eq.force_standard_error > np.sqrt(_FEWEST) * of_one_contact
    enough[solved.path.size :] = False  # the paper's closure of ageing may end before the path does
    tell = np.flatnonzero(np.isfinite(eq.force_standard_error) & enough)
    own = solved.force_error * mean_threshold
    allowed = eq.force_standard_error[tell] + eq.step_error[tell] + own
    return Deviation(tell, (eq.force[tell] - solved.force[tell]) / allowed)


def _before_slips(solved: Any, eq: Any, mean_threshold: float) -> Deviation:
    """The same of contacts on a soft slider, up to the first slip of any slider: each slips at its own X_T, and in
    between their mean force is that of none of them. What N contacts bear beyond infinitely many is no deviation."""
    slips = np.append(solved.slips.drive, eq.slips.drive)
    reached = np.maximum.accumulate(np.abs(eq.path - eq.path[0]))
    first = np.searchsorted(reached, np.abs(slips - eq.path[0]).min(initial=np.inf))
    tell = np.arange(min(int(first), solved.path.size))
    # few sliders may agree by chance at a point, where their scatter is less than that of their contacts
    scatter = np.maximum.accumulate(eq.force_standard_error)[tell]
    tell = tell[np.isfinite(scatter)]
    scatter = np.maximum(scatter[tell], mean_threshold * eq.contacts**-0.5)
    allowed = scatter + eq.step_error[tell] + solved.force_error * mean_threshold
    beyond = _BEYOND * (eq.contacts / len(eq.forces)) ** (-2.0 / 3.0) * mean_threshold
    difference = eq.force[tell] - solved.force[tell]
    return Deviation(
        tell, np.sign(difference) * np.maximum(abs(difference) - beyond, 0.0) / allowed
    )


NOT_COMPARED = "force not known, too few contacts or breaks, all at once, or one soft slider alone"


def slips_beside(result: Result) -> list[dict[str, Any]]:
    """The master equation's slips in order, for a result of both solvers on a soft slider; else none. With a mass those
    of a fifth of the largest or more of either: of smaller ones, in which part of the contacts that hold breaks while
    most wait, each solver has its own.

    drive, drop : X_T and the fall of the force, lengths; mean_drive, drive_error and so on : mean and standard error of
    the same slip in the replicas, of which so many `have` it.
    """
    solved, eq = result.master, result.eq
    if solved is None or solved.slips is None or not is_coupled(eq) or not is_precise(solved):
        return []
    found, slips, of_eq = [], solved.slips, eq.slips
    which = slips.main if is_heavy(eq) else np.arange(slips.drive.size)
    if is_heavy(eq):
        of_eq = main_slips(of_eq)
    for number, each in enumerate(which.tolist()):
        if have := int((of_eq.number == number).sum()):
            slip: dict[str, Any] = {"number": number, "have": have}
            for own in ("drive", "drop"):
                slip[own] = float(getattr(slips, own)[each])
                slip[f"mean_{own}"], slip[f"{own}_error"] = of_eq.mean(own, number)
            found.append(slip)
    return found


def slip_line(result: Result) -> str:
    """The comparison slip by slip, as a line of text."""
    solved, eq, unit = result.master, result.eq, result.mean_threshold
    line = f"slips   {eq.slips.number.size} of eq in {len(eq.forces)} replicas"
    if solved is not None and solved.slips is not None:
        count = solved.slips.drive.size if is_precise(solved) else "an unknown number"
        line += f", {count} of the master equation"
    each = [slip for slip in slips_beside(result)[:10] if slip["have"] > 1]
    # behind on the drive's way, which goes back where the force that falls is below 0
    behind = [
        (np.sign(slip["drop"]) * (slip["mean_drive"] - slip["drive"]), slip["drive_error"])
        for slip in each
    ]
    if result.scale.length_unit == "m":
        late = [with_scatter(*one, "m", digits=2) for one in behind]
    else:
        late = [f"{with_error(way / unit, error / unit, 2)} of <x_s>" for way, error in behind]
    if is_heavy(eq):
        if smaller := eq.slips.number.size - main_slips(eq.slips).number.size:
            line += f"; {smaller} of eq lower the force by less than a fifth of the largest"
        if eq.slips.number.size:
            lasts, fastest = eq.slips.duration.mean(), eq.slips.top_speed.max()
            line += f"; they last {spoken(lasts, result.scale.time_unit)} on average, "
            line += f"top speed {spoken(fastest, result.scale.speed_unit)}"
        return f"{line}; energy kept to {np.abs(eq.energy.imbalance).max():.0e} of the work"
    if late:
        line += f"; place in eq less that of the master equation: {', '.join(late)}"
    line += "; N contacts slip late by some 0.5 N^(-2/3)/K <x_s>, more at each; unless N is large,"
    return f"{line} chance may make them slip early, and at K > K*, too"
