"""What becomes of a soft slider: smooth sliding, stick-slip, or slips that die out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.make import steady_life
from master.soft.slips import Slips
from master.steady.forward import births_table
from master.stick_slip.extremes import extremes
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
# Mean thresholds over which contacts must have slid to show what they do when they break.
PASSED = 1.5
# Share of what F rises by while a slider sticks, and of F, below which F stays what it is; and the
# points of the path that show it.
LOADS, SETTLED, SEEN = 0.1, 1e-2, 4


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
        fewer than 4 slips.
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


class Critical(NamedTuple):
    """K*/(N_c <k>) and its error."""

    spring: float
    error: float


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
    spring = float(drive.spring or 0.0)
    speed = drive.velocity if course is None else course.speed
    critical, error = _critical(contacts, tolerance, speed)
    trend, rates = _trend(slips.drop), {"thermal", "ageing", "grains"}.intersection(contacts.laws)
    count = slips.drive.size
    if not whole:
        found = Found("undecided", f"{count} slips up to where the solution stopped")
    elif rates and (not count or drive.slip == "reset"):
        # K* is that of a rigid slider, and a soft one has a speed of its own
        found = _rated(contacts, drive, count, critical, course)
    elif not count:
        found = _without_slips(spring, critical)
    elif drive.slip == "reset":
        again = critical
        if contacts.start.span != (0.0, 0.0):
            again = _critical(_relaxed(contacts), tolerance, speed).spring
        found = _after_resets(spring, critical, again)
    else:
        found = _by_trend(contacts, drive, slips, trend, course)
    verdict, reason = found
    if abs(spring - critical) <= error:
        reason += f"; K* is known to {error:.1e} only, and K is nearer"
    ratio = spring / critical if critical > 0.0 else np.inf
    return Regime(verdict, reason, critical, error, ratio, count, trend)


def _critical(contacts: Contacts, tolerance: float, speed: float) -> Critical:
    """K* of a rigid slider that moves forward at a speed, as master.propensity tells it."""
    life = steady_life(contacts, speed)
    travel = births_table(contacts, life, speed, tolerance)
    found = extremes(contacts, life, travel, speed, tolerance)
    return Critical(found.spring, found.spring_error)


def _relaxed(contacts: Contacts) -> Contacts:
    """The same contacts, all just formed again."""
    again = None if contacts.reforming is None else contacts.reforming.law
    return contacts.replace(start=again)


def _without_slips(spring: float, critical: float) -> Found:
    known = f"K = {spring:.6g} is {{}} K* = {critical:.6g}"
    if spring >= critical:
        return Found("smooth", f"{known.format('at least')}: the spring never lets go")
    early = f"{known.format('below')}, but the path ends before the first slip"
    return Found("undecided", early)


def _after_resets(spring: float, critical: float, again: float) -> Found:
    """K* is `critical` from the start, `again` from a reset."""
    left = "of relaxed contacts, left by a slip"
    if again != critical:
        left += f"; from the start, up to the first slip, K* = {critical:.6g}"
    if spring < again:
        return Found("stick-slip", f"K = {spring:.6g} is below K* = {again:.6g} {left}")
    return Found("decaying transient", f"K = {spring:.6g} is at least K* = {again:.6g} {left}")


def _by_trend(
    contacts: Contacts, drive: Drive, slips: Slips, trend: float | None, course: Course | None
) -> Found:
    """Whether slips that leave something of what was before them go on or fade."""
    spring, path, count = float(drive.spring or 0.0), drive.path, slips.drive.size
    way = np.abs(np.diff(path, prepend=path[0])).cumsum()
    since = float(way[-1] - way[np.abs(path - slips.drive[-1]).argmin()])
    first = (spring + 1.0) / spring * _oldest(contacts, course)
    longest = float(np.abs(np.diff(slips.drive)).max(initial=first))
    if since > SILENT * longest:
        silent = f"then none for {since / longest:.3g} times the longest pause"
        return Found("decaying transient", f"{count} slips, {silent}")
    if trend is None:
        few = f"{count} slips up to the end of the path are too few to tell; lengthen it"
        return Found("undecided", few)
    if trend < -STEADY:
        fading = f"{count} slips, each drop {-trend:.2%} smaller than the last"
        return Found("decaying transient", fading)
    told = f"{count} slips up to the end of the path, their drops not fading"
    return Found("stick-slip", told)


def _oldest(contacts: Contacts, course: Course | None) -> float:
    """Mean threshold of contacts as old as any that was there."""
    grains = contacts.grains
    if grains is not None and grains.age is not None and course is not None:
        return grains.growth.thresholds(grains.age + float(course.clock[-1])).mean()
    final = 0.0 if contacts.ageing is None else contacts.ageing.final.mean()
    return max(contacts.mean_threshold, final)


def _rated(
    contacts: Contacts, drive: Drive, count: int, critical: float, course: Course | None
) -> Found:
    """Where contacts have rates of their own; what slips there are must be resets."""
    spring = float(drive.spring or 0.0)
    beside = f"K = {spring:.6g}, and a rigid slider as fast as the drive has K* = {critical:.6g}"
    if not count:
        if contacts.ageing is not None or contacts.grains is not None:
            missing = _missing(contacts, spring, course)
        else:
            missing = _unsettled(contacts, spring, critical, course)
        seen = "no slip up to the end of the path, at the slider's own speed"
        return Found("undecided" if missing else "smooth", f"{seen}{missing}; {beside}")
    # grains that grow are younger than they began
    alike = contacts.reforming is None and contacts.grains is None
    if count > 1:
        told = f"{count} slips, each after a reset that leaves nothing of what was before"
    elif contacts.start.span == (0.0, 0.0) and alike:
        told = "one slip, after which contacts stand as they began, and so slip again"
    else:
        few = "one slip up to the end of the path is too few to tell, lengthen it"
        return Found("undecided", f"{few}; {beside}")
    return Found("stick-slip", f"{told}; {beside}")


def _missing(contacts: Contacts, spring: float, course: Course | None) -> str:
    """What a path lacks that shows contacts which grow older to slide smoothly; or nothing.

    A slider that runs ahead gives its contacts no time to age: their drop is steeper than a rigid
    one's, and no K* tells. So all that age with the load must have broken, at thresholds as high as
    they have come to be by then.
    """
    if course is None:
        return ", of which too little is known; lengthen it"
    clock, place = np.append(0.0, course.clock), np.append(0.0, course.position)
    on = clock >= course.begin
    slid = np.abs(place - np.interp(course.begin, clock, place))[on]
    grains = contacts.grains
    if grains is not None and grains.age is not None:
        reach = grains.quantile(1.0, grains.age + clock[on])
    else:
        reach = np.full(slid.shape, _oldest(contacts, course))
    if not (slid > PASSED * reach).any():
        held = f"contacts that aged as the spring loaded may still hold, up to x = {reach[-1]:.3g}"
        return f", by which {held}; lengthen it"
    path, force = course.position + course.force / spring, np.abs(course.force)
    if force.size > 1 and force[-1] > force[:-1].max():
        loads = LOADS * spring / (1.0 + spring) * abs(path[-1] - path[-2])
        if force[-1] - force[-2] > loads:
            return ", where the force still rises as high as never before; lengthen it"
    return ""


def _unsettled(contacts: Contacts, spring: float, critical: float, course: Course | None) -> str:
    """The same of contacts that break at a rate but do not age.

    A slider on a spring softer than K* may creep so fast, beside the drive, that it never slips.
    Then its force stays what it is.
    """
    if spring >= critical:
        return ""
    if course is not None:
        path, on = course.position + course.force / spring, course.clock >= course.begin
        far = PASSED * contacts.mean_threshold + course.last * contacts.waiting_time
        stuck = far * spring / (1.0 + spring)
        late = (np.abs(path - path[-1]) <= far) & on
        there = float(np.ptp(path[on])) >= far and int(late.sum()) >= SEEN
        little = min(SETTLED * abs(float(course.force[-1])), LOADS * stuck)
        if there and np.ptp(course.force[late]) <= little:
            return ""
    return (
        ", but K < K*: a slip may come yet, or the drive is slow beside the slider's creep and none "
        f"ever comes, which shows where the force stays as it is for {PASSED:g} <x_s>; lengthen the "
        "path, or give it more points"
    )


def _trend(drop: Array) -> float | None:
    """Slope of log |drop| against number over the later half."""
    late = np.abs(drop[drop.size // 2 :])
    if drop.size < FEWEST or not (late > 0.0).all():
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
