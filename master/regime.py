"""What becomes of a soft slider: smooth sliding, stick-slip, or slips that die out; and what that is concluded from."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from master.propensity import propensity
from origins import Contacts
from origins.drive import SlipRule

Array = npt.NDArray[np.float64]
Verdict = Literal["smooth", "stick-slip", "decaying transient", "undecided"]

_SILENT = 1.5  # times the longest pause between slips: nothing more is to come
_STEADY = 1e-3
_FEWEST = 4
_PASSED = 1.5  # drives on which the oldest contacts break


@dataclass(frozen=True)
class Regime:
    """Verdict and evidence.

    Attributes
    ----------
    verdict : "smooth", "stick-slip", "decaying transient" or "undecided"
    reason : str
        In words.
    critical_spring, critical_spring_error : float
        K*/(N_c <k>) from the start on, of a slider that moves forward as fast as the drive: a stiffer spring never lets
        go. It is not that of steady sliding, where contacts have forgotten their start and F(X) falls no more.
    stiffness_ratio : float
        K/K*.
    slips : int
        Slips found along the path.
    trend : float or None
        Relative change of the force drop from one slip to the next over the later half; None for fewer than 4 slips.
    """

    verdict: Verdict
    reason: str
    critical_spring: float
    critical_spring_error: float
    stiffness_ratio: float
    slips: int
    trend: float | None


def regime(
    contacts: Contacts,
    spring: float,
    rule: SlipRule,
    drive: Array,
    drop: Array,
    path: Array,
    tolerance: float,
    velocity: float = 1.0,
) -> Regime:
    """Judge slips of force `drop` at drive positions `drive` (lengths) along `path`; K* is that of a rigid slider which
    moves as fast as the drive."""
    start = propensity(contacts, tolerance, velocity=velocity)
    critical = start.critical_spring
    ratio = spring / critical if critical > 0.0 else np.inf
    trend = _trend(drop)
    verdict, reason = _judge(contacts, spring, rule, drive, trend, path, critical, tolerance)
    if abs(spring - critical) <= start.critical_spring_error:
        reason += f"; K* is known to {start.critical_spring_error:.1e} only, and K is nearer"
    return Regime(verdict, reason, critical, start.critical_spring_error, ratio, drive.size, trend)


def _judge(
    contacts: Contacts,
    spring: float,
    rule: SlipRule,
    drive: Array,
    trend: float | None,
    path: Array,
    critical: float,
    tolerance: float,
) -> tuple[Verdict, str]:
    slips = drive.size
    rates = contacts.thermal is not None or contacts.ageing is not None or contacts.grains is not None
    if rates and (not slips or rule == "reset"):
        followed = spring >= critical
        if contacts.ageing is not None or contacts.grains is not None:
            # a slider that runs ahead gives its contacts no time to age: their drop is steeper than a rigid one's
            oldest = contacts.mean_threshold
            if contacts.ageing is not None:
                oldest = max(oldest, contacts.ageing.final.mean())
            followed = float(np.ptp(np.append(path, 0.0))) > _PASSED * (1.0 + 1.0 / spring) * oldest
        return _judge_rates(contacts, spring, slips, critical, followed)
    if not slips:
        if spring >= critical:
            return "smooth", f"K = {spring:.6g} is at least K* = {critical:.6g}: the spring never lets go"
        return "undecided", f"K = {spring:.6g} is below K* = {critical:.6g}, but the path ends before the first slip"
    if rule == "reset":
        again, left = critical, "of relaxed contacts, left by a slip"
        if contacts.start.span != (0.0, 0.0):
            again = propensity(Contacts(contacts.thresholds), tolerance).critical_spring
            left += f"; from the start, up to the first slip, K* = {critical:.6g}"
        if spring < again:
            return "stick-slip", f"K = {spring:.6g} is below K* = {again:.6g} {left}"
        return "decaying transient", f"K = {spring:.6g} is at least K* = {again:.6g} {left}"
    pauses = np.abs(np.diff(drive))
    travelled = np.abs(np.diff(path, prepend=path[0])).cumsum()
    since = float(travelled[-1] - travelled[np.abs(path - drive[-1]).argmin()])
    longest = float(pauses.max(initial=(spring + 1.0) / spring * contacts.mean_threshold))
    if since > _SILENT * longest:
        return "decaying transient", f"{slips} slips, then none for {since / longest:.3g} times the longest pause"
    if trend is None:
        return "undecided", f"{slips} slips up to the end of the path are too few to tell; lengthen it"
    if trend < -_STEADY:
        return "decaying transient", f"{slips} slips, each drop {-trend:.2%} smaller than the one before"
    return "stick-slip", f"{slips} slips up to the end of the path, their drops not fading"


def _judge_rates(contacts: Contacts, spring: float, slips: int, critical: float, followed: bool) -> tuple[Verdict, str]:
    """Where rates tell, K* is that of a rigid slider as fast as the drive, and a soft one has a speed of its own; what
    slips must be resets."""
    beside = f"K = {spring:.6g}, and a rigid slider as fast as the drive has K* = {critical:.6g}"
    if not slips:
        verdict: Verdict = "smooth" if followed else "undecided"
        return verdict, f"no slip up to the end of the path, at the slider's own speed; {beside}"
    alike = contacts.reforming is None and contacts.grains is None  # those that grow are younger than they began
    if slips == 1 and contacts.start.span == (0.0, 0.0) and alike:
        return "stick-slip", f"one slip, after which contacts stand as they began, and so slip again; {beside}"
    if slips == 1:
        return "undecided", f"one slip up to the end of the path is too few to tell, lengthen it; {beside}"
    return "stick-slip", f"{slips} slips, each after a reset that leaves nothing of what was before; {beside}"


def _trend(drop: Array) -> float | None:
    """Slope of log |drop| against number over the later half."""
    if drop.size < _FEWEST:
        return None
    late = np.abs(drop[drop.size // 2 :])
    if late.size < 2 or not (late > 0.0).all():
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
