"""The regime of a soft slider: smooth sliding, stick-slip, or slips that die out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from master.soft.in_time.track import pieces, reached
from master.soft.slips import Slips
from master.stick_slip.extremes import critical_spring
from origins import Contacts
from origins.drive import Drive

Array = npt.NDArray[np.float64]
Verdict = Literal["smooth", "stick-slip", "decaying transient", "undecided"]

# SILENT: slips are over if the last is this many times the longest pause ago. The others: largest
# thresholds that the slider must have passed without slip for a verdict, with contacts that age, and
# without ageing on a spring softer than K*.
SILENT, PASSED, TWICE_PASSED = 1.5, 1.5, 3.0
# Fewest slips that have a trend, and relative change of the drop from one slip to the next below
# which drops do not fade.
FEWEST, STEADY = 4, 1e-3
# Laws by which what contacts do depends on the slider's speed.
RATES = frozenset({"thermal", "ageing", "grains"})


@dataclass(frozen=True)
class Regime:
    """Verdict and evidence.

    Attributes
    ----------
    verdict : "smooth", "stick-slip", "decaying transient" or "undecided"
    reason : str
        In words.
    critical_spring, critical_spring_error : float
        K*/(N_c <k>) from the start on, of a rigid slider that moves forward as fast as the drive:
        at T = 0 a stiffer spring slips only after a turn. It is not that of steady sliding, where the start is
        forgotten.
    stiffness_ratio : float
        K/K*.
    slips : int
        Slips found along the path.
    trend : float or None
        Relative change of the force drop from one slip to the next over the later half of the
        slips; None for fewer than 4 slips, and where these drops are not monotone.
    """

    verdict: Verdict
    reason: str
    critical_spring: float
    critical_spring_error: float
    stiffness_ratio: float
    slips: int
    trend: float | None


class Course(NamedTuple):
    """The motion of a slider.

    clock, force, position : arrays of shape (n,), times, F/(N_c <k>) and X (lengths)
    begin, last : time at which the drive's last straight way begins, and its speed
    speed : mean speed of the drive while it moves
    """

    clock: Array
    force: Array
    position: Array
    begin: float
    last: float
    speed: float

    @classmethod
    def of(cls, drive: Drive, balance: float, force: Array, position: Array) -> Course | None:
        """The course up to some point of the drive's path; None where it did not move."""
        moving = [piece for piece in pieces(drive, balance) if piece.travel != 0.0]
        if not moving or not force.size:
            return None
        way, lasts = (sum(getattr(one, name) for one in moving) for name in ("way", "duration"))
        speed = drive.velocity if drive.time is None else way / lasts
        times, last = reached(drive, balance)[: force.size], moving[-1]
        return cls(times, force, position, last.begin, last.speed, speed)


def regime(
    contacts: Contacts,
    drive: Drive,
    slips: Slips,
    tolerance: float,
    whole: bool = True,
    course: Course | None = None,
) -> Regime:
    """Judge the slips along the drive's path; `whole` is False if only a part of it was solved.

    course : the slider's motion; needed where the contacts' laws depend on time
    """
    spring, count, trend = float(drive.spring or 0.0), slips.drive.size, _trend(slips.drop)
    speed = drive.velocity if course is None else course.speed
    critical, error = critical_spring(contacts, speed, tolerance)
    known = f"K = {spring:.6g} N_c<k>, a rigid slider as fast as the drive has K* = {critical:.6g}"
    if count and spring >= critical and np.ptp(np.sign(np.diff(drive.path))) > 1:
        known += ", until the drive turns: F may fall more steeply then"
    verdict: Verdict = "undecided"
    if not whole:
        reason = f"{count} slips up to where the solution stopped"
    elif not count:
        # K* is that of a rigid slider; a soft slider's speed differs from the drive's
        lacking = _lacking(contacts, spring, critical, course)
        verdict = "undecided" if lacking else "smooth"
        reason = f"{known}; no slip up to the end of the path{lacking}"
    elif drive.slip == "reset":
        verdict, reason = _after_resets(contacts, spring, count, speed, tolerance)
        reason = f"{reason}; {known}"
    else:
        verdict, reason = _by_drops(contacts, drive, slips, trend, course)
    if abs(spring - critical) <= error:
        reason += f"; K* is known to {error:.1e} only, and K is nearer"
    ratio = spring / critical if critical > 0.0 else np.inf
    return Regime(verdict, reason, critical, error, ratio, count, trend)


def _after_resets(
    contacts: Contacts, spring: float, count: int, speed: float, tolerance: float
) -> tuple[Verdict, str]:
    """Whether resets continue: they do where the relaxed contacts that they leave slip again."""
    again = contacts.reforming
    relaxed = again is None and contacts.start.span == (0.0, 0.0)
    if not RATES.intersection(contacts.laws):
        start = contacts.replace(start=None if again is None else again.law)
        limit = critical_spring(start, speed, tolerance)[0]
        verdict: Verdict = "stick-slip" if spring < limit else "decaying transient"
        return verdict, f"{count} slips; the relaxed contacts that they leave have K* = {limit:.6g}"
    if count > 1:
        told = f"{count} slips, each after a reset that leaves nothing of what was before"
        return "stick-slip", told
    # growing grains are younger after a reset than at the start
    if relaxed and contacts.grains is None:
        return "stick-slip", "one slip, after which contacts stand as they began, and so slip again"
    return "undecided", "one slip up to the end of the path is too few to tell, lengthen it"


def _by_drops(
    contacts: Contacts, drive: Drive, slips: Slips, trend: float | None, course: Course | None
) -> tuple[Verdict, str]:
    """Whether slips that do not replace all contacts continue or fade."""
    spring, path, count = float(drive.spring or 0.0), drive.path, slips.drive.size
    way = np.abs(np.diff(path, prepend=path[0])).cumsum()
    since = float(way[-1] - way[np.abs(path - slips.drive[-1]).argmin()])
    oldest = _oldest(contacts, np.zeros(1) if course is None else course.clock[-1:])
    first = (spring + 1.0) / spring * float(oldest[0])
    longest = float(np.abs(np.diff(slips.drive)).max(initial=first))
    told, drops = f"{count} slips up to the end of the path", np.abs(slips.drop)
    if since > SILENT * longest:
        silent = f"then none for {since / longest:.3g} times the longest period"
        return "decaying transient", f"{count} slips, {silent}"
    if count < FEWEST:
        return "undecided", f"{told} are too few to tell; lengthen it"
    if trend is not None and trend < -STEADY:
        return "decaying transient", f"{count} slips, each drop {-trend:.2%} smaller than the last"
    # where large and small slips alternate, compare the largest drops of longer intervals
    last, before = (float(part.max()) for part in (drops[-(count // 3) :], drops[count // 3 :]))
    if trend is not None or last >= (1.0 - STEADY) * before:
        return "stick-slip", f"{told}, their drops not fading: the largest of late is {last:.3g}"
    fewer = f"the largest of the last third is {last:.3g}, that of the later two {before:.3g}"
    return "undecided", f"{told}, whose drops go up and down; {fewer}: lengthen it"


def _oldest(contacts: Contacts, clock: Array) -> Array:
    """About the mean threshold of the oldest contacts present at times `clock`; same shape."""
    grains = contacts.grains
    if grains is not None and grains.age is not None:
        return np.asarray(grains.quantile(1.0, grains.age + clock))
    final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
    return np.full(clock.shape, max(contacts.mean_threshold, final))


def _lacking(contacts: Contacts, spring: float, critical: float, course: Course | None) -> str:
    """Why a path without slips does not yet prove smooth sliding; "" if it does.

    Before a turn, without ageing, it cannot slip above K*; with heat it may creep along with the drive on a
    softer spring and never slip. With ageing, contacts under a slider that runs ahead have no time
    to age: F drops more steeply than on a rigid slider, and K* decides nothing. Once all contacts
    of the start have broken, the first drop is over, and it is the steepest.
    """
    ages = contacts.ageing is not None or contacts.grains is not None
    if not ages and spring >= critical:
        return ""
    if course is None or not RATES.intersection(contacts.laws):
        return ", and K < K*: it ends before the first slip"
    path, late = course.position + course.force / spring, course.clock >= course.begin
    place = np.append(0.0, course.position)
    turned = np.interp(course.begin, np.append(0.0, course.clock), place)
    slid, oldest = np.abs(course.position - turned), _oldest(contacts, course.clock)
    far = PASSED * oldest if ages else TWICE_PASSED * oldest + course.last * contacts.waiting_time
    if not (slid > far)[late].any():
        yet = "contacts that aged may still hold" if ages else "K < K*: a slip may come yet"
        return f", but {yet} until the slider has gone on by {far[-1]:.3g}; lengthen the path"
    last = np.abs(course.force[-2:])
    # 0.1 of the rise of F over the last step of the path if the slider sticks
    loads = 0.1 * spring / (1.0 + spring) * abs(path[-1] - path[-2:][0])
    if last[-1] - last[0] > loads and last[-1] > np.abs(course.force[:-1]).max():
        return ", where the force still rises as high as never before; lengthen it"
    return ""


def _trend(drop: Array) -> float | None:
    """Relative change of |drop| a slip, fitted over the later half; None where not monotone."""
    late = np.abs(drop[drop.size // 2 :])
    if drop.size < FEWEST or not (late > 0.0).all():
        return None
    change = np.diff(np.log(late))
    if change.max() > STEADY and change.min() < -STEADY:
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
