"""What becomes of a soft slider at T = 0: smooth sliding, stick-slip, or slips that die out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from master.soft.slips import Slips
from master.stick_slip.propensity import propensity
from origins import Contacts
from origins.drive import Drive

Array = npt.NDArray[np.float64]
Verdict = Literal["smooth", "stick-slip", "decaying transient", "undecided"]

# No slip for so many times the longest pause between slips: nothing more is to come.
SILENT = 1.5
# Relative change of the force drop from one slip to the next below which drops do not fade.
STEADY = 1e-3
# Slips from which a trend is told.
FEWEST = 4


@dataclass(frozen=True)
class Regime:
    """Verdict and evidence.

    Attributes
    ----------
    verdict : "smooth", "stick-slip", "decaying transient" or "undecided"
    reason : str
        In words.
    critical_spring, critical_spring_error : float
        K*/(N_c <k>) from the start on, of a slider that moves forward: a stiffer spring never lets
        go. It is not that of steady sliding, where contacts have forgotten their start.
    stiffness_ratio : float
        K/K*.
    slips : int
        Slips found along the path.
    trend : float or None
        Relative change of the force drop from one slip to the next over the later half; None for
        fewer than 4 slips.
    """

    verdict: Verdict
    reason: str
    critical_spring: float
    critical_spring_error: float
    stiffness_ratio: float
    slips: int
    trend: float | None


def regime(
    contacts: Contacts, drive: Drive, slips: Slips, tolerance: float, whole: bool = True
) -> Regime:
    """Judge the slips along the drive's path, or along a part of it if that is not the whole."""
    spring = float(drive.spring or 0.0)
    start = propensity(contacts, tolerance)
    critical, error = start.critical_spring, start.critical_spring_error
    trend = _trend(slips.drop)
    again = critical
    if slips.drive.size and drive.slip == "reset" and contacts.start.span != (0.0, 0.0):
        again = propensity(_relaxed(contacts), tolerance).critical_spring
    verdict, reason = _judge(contacts, drive, slips, trend, critical, again)
    if not whole:
        verdict, reason = "undecided", f"{slips.drive.size} slips up to where the solution stopped"
    if abs(spring - critical) <= error:
        reason += f"; K* is known to {error:.1e} only, and K is nearer"
    ratio = spring / critical if critical > 0.0 else np.inf
    return Regime(verdict, reason, critical, error, ratio, slips.drive.size, trend)


def _relaxed(contacts: Contacts) -> Contacts:
    again = None if contacts.reforming is None else contacts.reforming.law
    return Contacts(contacts.thresholds, again, reforming=again, stiffness=contacts.stiffness)


def _judge(
    contacts: Contacts,
    drive: Drive,
    slips: Slips,
    trend: float | None,
    critical: float,
    again: float,
) -> tuple[Verdict, str]:
    """The verdict and the reason for it; K* is `critical` from the start, `again` from a reset."""
    spring, path, count = float(drive.spring or 0.0), drive.path, slips.drive.size
    known = f"K = {spring:.6g} is {{}} K* = {critical:.6g}"
    if not count and spring >= critical:
        return "smooth", f"{known.format('at least')}: the spring never lets go"
    if not count:
        return "undecided", f"{known.format('below')}, but the path ends before the first slip"
    if drive.slip == "reset":
        left = "of relaxed contacts, left by a slip"
        if again != critical:
            left += f"; from the start, up to the first slip, K* = {critical:.6g}"
        if spring < again:
            return "stick-slip", f"K = {spring:.6g} is below K* = {again:.6g} {left}"
        return "decaying transient", f"K = {spring:.6g} is at least K* = {again:.6g} {left}"
    way = np.abs(np.diff(path, prepend=path[0])).cumsum()
    since = float(way[-1] - way[np.abs(path - slips.drive[-1]).argmin()])
    first = (spring + 1.0) / spring * contacts.mean_threshold
    longest = float(np.abs(np.diff(slips.drive)).max(initial=first))
    if since > SILENT * longest:
        silent = f"then none for {since / longest:.3g} times the longest pause"
        return "decaying transient", f"{count} slips, {silent}"
    if trend is None:
        few = f"{count} slips up to the end of the path are too few to tell; lengthen it"
        return "undecided", few
    if trend < -STEADY:
        return "decaying transient", f"{count} slips, each drop {-trend:.2%} smaller than the last"
    return "stick-slip", f"{count} slips up to the end of the path, their drops not fading"


def _trend(drop: Array) -> float | None:
    """Slope of log |drop| against number over the later half."""
    late = np.abs(drop[drop.size // 2 :])
    if drop.size < FEWEST or not (late > 0.0).all():
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
