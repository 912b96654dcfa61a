"""What becomes of a soft slider: smooth sliding, stick-slip, or slips that die out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from master.soft.slips import Slips
from master.stick_slip.extremes import critical_spring
from origins import Contacts
from origins.drive import Drive

Array = npt.NDArray[np.float64]
Verdict = Literal["smooth", "stick-slip", "decaying transient", "undecided"]

# No slip for so many times the longest pause between slips: nothing more is to come. And mean
# thresholds over which contacts must have slid to show what they do when they break.
SILENT = PASSED = 1.5
# Slips from which a trend is told, and relative change of the drop from one slip to the next below
# which drops do not fade.
FEWEST, STEADY = 4, 1e-3
# Share of what F rises by while a slider sticks, and of F, below which F stays what it is.
LOADS, SETTLED = 0.1, 1e-2


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
        at T = 0 a stiffer spring never lets go. It is not that of steady sliding, where contacts
        have forgotten their start.
    stiffness_ratio : float
        K/K*.
    slips : int
        Slips found along the path.
    trend : float or None
        Relative change of the force drop from one slip to the next over the later half; None for
        fewer than 4 slips, and where drops there go up and down.
    """

    verdict: Verdict
    reason: str
    critical_spring: float
    critical_spring_error: float
    stiffness_ratio: float
    slips: int
    trend: float | None


class Course(NamedTuple):
    """How a slider moved whose contacts have laws that tell time.

    clock, force, position : arrays of shape (n,), times, F/(N_c <k>) and X (lengths)
    begin, last : when the drive's last straight way began, and its speed
    speed : of the drive, the mean over all that it moves
    """

    clock: Array
    force: Array
    position: Array
    begin: float
    last: float
    speed: float


class Found(NamedTuple):
    """Verdict and reason."""

    verdict: Verdict
    reason: str


def regime(
    contacts: Contacts,
    drive: Drive,
    slips: Slips,
    tolerance: float,
    whole: bool = True,
    course: Course | None = None,
) -> Regime:
    """Judge the slips along the drive's path, or along a part of it if that is not the whole.

    course : how the slider moved; needed where contacts have laws that tell time
    """
    spring, count, trend = float(drive.spring or 0.0), slips.drive.size, _trend(slips.drop)
    speed = drive.velocity if course is None else course.speed
    critical, error = critical_spring(contacts, speed, tolerance)
    rates = {"thermal", "ageing", "grains"}.intersection(contacts.laws)
    known = f"K = {spring:.6g}, and a rigid slider as fast as the drive has K* = {critical:.6g}"
    if not whole:
        found = Found("undecided", f"{count} slips up to where the solution stopped")
    elif not count and rates:
        # K* is that of a rigid slider, and a soft one has a speed of its own
        lacking = _lacking(contacts, spring, critical, course)
        told = f"no slip up to the end of the path, at the slider's own speed{lacking}; {known}"
        found = Found("undecided" if lacking else "smooth", told)
    elif not count and spring >= critical:
        found = Found("smooth", f"{known}: the spring never lets go")
    elif not count:
        found = Found("undecided", f"{known}, but the path ends before the first slip")
    elif drive.slip == "reset" and rates:
        found = _after_resets(contacts, count, known)
    elif drive.slip == "reset":
        again, limit = contacts.reforming, critical
        if again is not None or contacts.start.span != (0.0, 0.0):
            relaxed = contacts.replace(start=None if again is None else again.law)
            limit = critical_spring(relaxed, speed, tolerance)[0]
        told = f"{known}; left by a slip, relaxed contacts have K* = {limit:.6g}"
        found = Found("stick-slip" if spring < limit else "decaying transient", told)
    else:
        found = _by_trend(contacts, drive, slips, trend, course)
    verdict, reason = found
    if abs(spring - critical) <= error:
        reason += f"; K* is known to {error:.1e} only, and K is nearer"
    ratio = spring / critical if critical > 0.0 else np.inf
    return Regime(verdict, reason, critical, error, ratio, count, trend)


def _after_resets(contacts: Contacts, count: int, known: str) -> Found:
    """Whether resets go on of contacts that have rates of their own."""
    # grains that grow are younger after a reset than they began
    alike = contacts.reforming is None and contacts.grains is None
    if count > 1:
        told = f"{count} slips, each after a reset that leaves nothing of what was before"
    elif contacts.start.span == (0.0, 0.0) and alike:
        told = "one slip, after which contacts stand as they began, and so slip again"
    else:
        few = "one slip up to the end of the path is too few to tell, lengthen it"
        return Found("undecided", f"{few}; {known}")
    return Found("stick-slip", f"{told}; {known}")


def _by_trend(
    contacts: Contacts, drive: Drive, slips: Slips, trend: float | None, course: Course | None
) -> Found:
    """Whether slips that leave something of what was before them go on or fade."""
    spring, path, count = float(drive.spring or 0.0), drive.path, slips.drive.size
    way = np.abs(np.diff(path, prepend=path[0])).cumsum()
    since = float(way[-1] - way[np.abs(path - slips.drive[-1]).argmin()])
    oldest = _oldest(contacts, np.zeros(1) if course is None else course.clock[-1:])
    first = (spring + 1.0) / spring * float(oldest[0])
    longest = float(np.abs(np.diff(slips.drive)).max(initial=first))
    if since > SILENT * longest:
        silent = f"then none for {since / longest:.3g} times the longest pause"
        return Found("decaying transient", f"{count} slips, {silent}")
    if count >= FEWEST and trend is None:
        return _by_largest(slips)
    if trend is None:
        few = f"{count} slips up to the end of the path are too few to tell; lengthen it"
        return Found("undecided", few)
    if trend < -STEADY:
        fading = f"{count} slips, each drop {-trend:.2%} smaller than the last"
        return Found("decaying transient", fading)
    told = f"{count} slips up to the end of the path, their drops not fading"
    return Found("stick-slip", told)


def _by_largest(slips: Slips) -> Found:
    """Whether slips fade of which large and small ones take turns: the largest of a while tells."""
    count, drops = slips.drop.size, np.abs(slips.drop)
    last, before = (float(part.max()) for part in (drops[-(count // 3) :], drops[count // 3 :]))
    told = f"{count} slips up to the end of the path, whose drops go up and down"
    if last >= (1.0 - STEADY) * before:
        return Found(
            "stick-slip", f"{told} and do not fade: the largest of the last third is {last:.3g}"
        )
    lengthen = f"the largest of the last third is {last:.3g}, that of the later two {before:.3g}"
    return Found("undecided", f"{told}; {lengthen}: lengthen it")


def _oldest(contacts: Contacts, clock: Array) -> Array:
    """Thresholds of contacts as old as any that is there at times, same shape: about the mean."""
    grains = contacts.grains
    if grains is not None and grains.age is not None:
        return np.asarray(grains.quantile(1.0, grains.age + clock))
    final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
    return np.full(clock.shape, max(contacts.mean_threshold, final))


def _lacking(contacts: Contacts, spring: float, critical: float, course: Course | None) -> str:
    """What a path without slips lacks that shows contacts with rates to slide smoothly; or nothing.

    Of contacts that do not age none slips above K*; on a softer spring they may creep so fast,
    beside the drive, that they never slip: then the force stays what it is. A slider that runs ahead
    gives its contacts no time to age: their drop is steeper than a rigid one's, and no K* tells. So
    all that age with the load must have broken, and the force no longer rise.
    """
    ages = contacts.ageing is not None or contacts.grains is not None
    if not ages and spring >= critical:
        return ""
    if course is None:
        return ", of which too little is known; lengthen it"
    path, force, on = course.position + course.force / spring, course.force, spring / (1.0 + spring)
    late = course.clock >= course.begin
    if ages:
        place = np.append(0.0, course.position)
        turned = np.interp(course.begin, np.append(0.0, course.clock), place)
        slid, oldest = np.abs(course.position - turned), _oldest(contacts, course.clock)
        if not (slid > PASSED * oldest)[late].any():
            reach = f"up to x = {oldest[-1]:.3g}"
            return f", by which contacts that aged may still hold, {reach}; lengthen it"
        last = np.abs(force[-2:])
        rises = last[-1] - last[0] > LOADS * on * abs(path[-1] - path[-2:][0])
        if rises and last[-1] > np.abs(force[:-1]).max():
            return ", where the force still rises as high as never before; lengthen it"
        return ""
    far = PASSED * contacts.mean_threshold + course.last * contacts.waiting_time
    late &= np.abs(path - path[-1]) <= far
    little = min(SETTLED * abs(float(force[-1])), LOADS * far * on)
    enough = np.ptp(path[course.clock >= course.begin]) >= far and np.count_nonzero(late) > 3
    if enough and np.ptp(force[late]) <= little:
        return ""
    return (
        f", but K < K*: a slip may come yet, unless the force stays as it is for {PASSED:g} <x_s>; "
        "lengthen the path, or give it more points"
    )


def _trend(drop: Array) -> float | None:
    """Slope of log |drop| against number over the later half; None where drops go up and down."""
    late = np.abs(drop[drop.size // 2 :])
    if drop.size < FEWEST or not (late > 0.0).all():
        return None
    change = np.diff(np.log(late))
    if change.max() > STEADY and change.min() < -STEADY:
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
