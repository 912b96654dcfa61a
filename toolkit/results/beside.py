"""Comparison of the two solvers: their difference in standard errors, and soft sliders slip by slip."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolkit.results.records import Result, is_coupled

_FEWEST = 30  # least number of broken contacts for which standard errors are meaningful


class Deviation(NamedTuple):
    """Ensemble minus master equation, `off`, in standard errors, at the `points` (indices) that can be compared."""

    points: npt.NDArray[np.intp]
    off: npt.NDArray[np.float64]

    @property
    def worst(self) -> float | None:
        """The largest in size; None where there are no points."""
        return float(np.abs(self.off).max()) if self.off.size else None


def deviation(result: Result) -> Deviation:
    """Difference of the solvers where enough contacts have broken to compare; no points where one of them is missing.

    The standard errors include the master equation's error and that of the ensemble's steps.
    """
    solved, eq = result.master, result.eq
    if solved is None or eq is None or is_coupled(eq):
        # a slip comes at a different X_T in each replica: in between their mean force is that of none of them
        return Deviation(np.empty(0, np.intp), np.empty(0))
    of_one_contact = np.minimum(np.abs(eq.path), result.mean_threshold) / eq.contacts
    enough = eq.force_standard_error > np.sqrt(_FEWEST) * of_one_contact
    enough[solved.path.size :] = False  # the paper's closure of ageing may end before the path does
    tell = np.flatnonzero(np.isfinite(eq.force_standard_error) & enough)
    own = solved.force_error * result.mean_threshold
    allowed = eq.force_standard_error[tell] + eq.step_error[tell] + own
    return Deviation(tell, (eq.force[tell] - solved.force[tell]) / allowed)


def why_not_compared(result: Result) -> str | None:
    """Why no point of the path can be compared, in words; None where one can, or a solver is missing."""
    if result.master is None or result.eq is None or deviation(result).points.size:
        return None
    if result.eq.breaks == 0:
        return "no contact breaks on this path"
    if is_coupled(result.eq):
        return "slips are compared one by one, not the force between them"
    return f"too few contacts or breaks, or all break at once: below some {_FEWEST} standard errors mean little"


class SlipBeside(NamedTuple):
    """One slip of the master equation, and means and standard errors of the same slip in the replicas (lengths).

    drive, drop : X_T and the fall of the force, of the master equation; have : number of replicas with this slip.
    """

    number: int
    drive: float
    drop: float
    mean_drive: float
    drive_error: float
    mean_drop: float
    drop_error: float
    have: int


def slips_beside(result: Result) -> list[SlipBeside]:
    """The slips in order, for a result of both solvers on a soft slider; else none."""
    solved, eq = result.master, result.eq
    if solved is None or solved.slips is None or not is_coupled(eq):
        return []
    slips, found = eq.slips, []
    for number, (drive, drop) in enumerate(zip(solved.slips.drive, solved.slips.drop, strict=True)):
        if have := int((slips.number == number).sum()):
            (late, late_error), (fall, fall_error) = (
                slips.mean(own, number) for own in ("drive", "drop")
            )
            beside = late, late_error, fall, fall_error, have
            found.append(SlipBeside(number, float(drive), float(drop), *beside))
    return found


def slip_line(result: Result) -> str:
    """The comparison slip by slip, as a line of text."""
    solved, eq = result.master, result.eq
    told = f"slips   {eq.slips.number.size} of eq in {len(eq.forces)} replicas"
    if solved is not None and solved.slips is not None:
        told += f", {solved.slips.drive.size} of the master equation"
    late = [(slip.mean_drive - slip.drive) / result.mean_threshold for slip in slips_beside(result)]
    if late:
        told += f"; of eq the first are late by {', '.join(f'{x:.1e}' for x in late[:10])} of <x_s>"
    return told + "; N contacts slip late by some N^(-2/3)/K of <x_s>, more at each"


def resets_apart(result: Result) -> list[str]:
    """A note where [eq] does not reset at the master equation's first slip: too few contacts break there."""
    solved, eq, drive = result.master, result.eq, result.asked.drive
    if solved is None or solved.slips is None or not solved.slips.drive.size:
        return []
    if not is_coupled(eq) or drive is None or (drive.slip or "reset") != "reset":
        return []
    first = [slip for slip in slips_beside(result) if slip.number == 0]
    # more than finite numbers of contacts explain
    most = 10.0 * (eq.contacts / len(eq.forces)) ** (-2.0 / 3.0) * result.mean_threshold
    if first and first[0].mean_drive - first[0].drive <= most:
        return []
    return [
        'slip = "reset": the master equation resets at the first onset, however few contacts break there, [eq] at '
        f"avalanches of at least eq.slip_fraction = {eq.slip_fraction:g} of them, which come later, or not at all"
    ]
