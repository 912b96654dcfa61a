"""What becomes of a soft slider: smooth sliding, stick-slip, or slips that die out; and what that is concluded from."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.soft.regime import Regime, Verdict
from master.stick_slip.propensity import propensity
from origins import Contacts
from origins.drive import SlipRule

Array = npt.NDArray[np.float64]

_SILENT = 1.5  # times the longest pause between slips: nothing more is to come
_STEADY = 1e-3
_FEWEST = 4
_PASSED = 1.5  # stretches at which the oldest contacts break
_LOADS = 0.1  # of what F rises by while a slider sticks
_SETTLED = 1e-2  # of F
_SEEN = 4  # points of the path that show F settled


@dataclass(frozen=True)
class Course:
    """How the slider moved: F/(N_c <k>) and its position at times, arrays of shape (n,), and when the drive's last leg
    of one speed began, at which speed."""

    clock: Array
    force: Array
    position: Array
    begin: float
    speed: float


def regime(
    contacts: Contacts,
    spring: float,
    rule: SlipRule,
    drive: Array,
    drop: Array,
    path: Array,
    tolerance: float,
    velocity: float = 1.0,
    course: Course | None = None,
) -> Regime:
    """Judge slips of force `drop` at drive positions `drive` (lengths) along `path`; K* is that of a rigid slider which
    moves as fast as the drive. Where rates tell, `course` is how the slider moved."""
    start = propensity(contacts, tolerance, velocity=velocity)
    critical = start.critical_spring
    ratio = spring / critical if critical > 0.0 else np.inf
    trend = _trend(drop)
    verdict, reason = _judge(contacts, spring, rule, drive, trend, path, critical, tolerance, course)
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
    course: Course | None,
) -> tuple[Verdict, str]:
    slips = drive.size
    rates = contacts.thermal is not None or contacts.ageing is not None or contacts.grains is not None
    if rates and (not slips or rule == "reset"):
        return _judge_rates(contacts, spring, slips, critical, course)
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
    longest = float(pauses.max(initial=(spring + 1.0) / spring * _oldest(contacts, course)))
    if since > _SILENT * longest:
        return "decaying transient", f"{slips} slips, then none for {since / longest:.3g} times the longest pause"
    if trend is None:
        return "undecided", f"{slips} slips up to the end of the path are too few to tell; lengthen it"
    if trend < -_STEADY:
        return "decaying transient", f"{slips} slips, each drop {-trend:.2%} smaller than the one before"
    return "stick-slip", f"{slips} slips up to the end of the path, their drops not fading"


def _oldest(contacts: Contacts, course: Course | None) -> float:
    """Mean threshold of contacts as old as any that was there."""
    if contacts.grains is not None and contacts.grains.age is not None and course is not None:
        return contacts.grains.growth.thresholds(contacts.grains.age + float(course.clock[-1])).mean()
    return max(contacts.mean_threshold, contacts.ageing.final.mean() if contacts.ageing is not None else 0.0)


def _judge_rates(
    contacts: Contacts, spring: float, slips: int, critical: float, course: Course | None
) -> tuple[Verdict, str]:
    """Where rates tell, K* is that of a rigid slider as fast as the drive, and a soft one has a speed of its own; what
    slips must be resets."""
    beside = f"K = {spring:.6g}, and a rigid slider as fast as the drive has K* = {critical:.6g}"
    if not slips:
        ages = contacts.ageing is not None or contacts.grains is not None
        missing = _missing(contacts, spring, course) if ages else _unsettled(contacts, spring, critical, course)
        seen = "no slip up to the end of the path, at the slider's own speed"
        return "undecided" if missing else "smooth", f"{seen}{missing}; {beside}"
    alike = contacts.reforming is None and contacts.grains is None  # those that grow are younger than they began
    if slips == 1 and contacts.start.span == (0.0, 0.0) and alike:
        return "stick-slip", f"one slip, after which contacts stand as they began, and so slip again; {beside}"
    if slips == 1:
        return "undecided", f"one slip up to the end of the path is too few to tell, lengthen it; {beside}"
    return "stick-slip", f"{slips} slips, each after a reset that leaves nothing of what was before; {beside}"


def _missing(contacts: Contacts, spring: float, course: Course | None) -> str:
    """What a path lacks that shows contacts which grow older to slide smoothly; nothing where it lacks nothing.

    A slider that runs ahead gives its contacts no time to age: their drop is steeper than a rigid one's, and no K*
    tells. So all that age with the load must have broken, at thresholds as high as they have come to be by then.
    """
    if course is None:
        return ", of which too little is known; lengthen it"
    clock, place = np.append(0.0, course.clock), np.append(0.0, course.position)
    on = clock >= course.begin
    slid = np.abs(place - np.interp(course.begin, clock, place))[on]
    if contacts.grains is not None and contacts.grains.age is not None:
        reach = contacts.grains.quantile(1.0, contacts.grains.age + clock[on])
    else:
        reach = np.full(slid.shape, _oldest(contacts, course))
    if not (slid > _PASSED * reach).any():
        held = f"contacts that aged as the spring loaded may still hold, up to x = {reach[-1]:.3g}"
        return f", by which {held}; lengthen it"
    path, force = course.position + course.force / spring, np.abs(course.force)
    highest = force.size > 1 and force[-1] > force[:-1].max()
    if highest and force[-1] - force[-2] > _LOADS * spring / (1.0 + spring) * abs(path[-1] - path[-2]):
        return ", where the force still rises as high as never before; lengthen it"
    return ""


def _unsettled(contacts: Contacts, spring: float, critical: float, course: Course | None) -> str:
    """The same of contacts that break at a rate but do not age: a slider on a spring softer than K* may creep so fast,
    beside the drive, that it never slips. Then its force stays what it is."""
    if spring >= critical:
        return ""
    if course is not None:
        path = course.position + course.force / spring
        far = _PASSED * contacts.mean_threshold + course.speed * contacts.waiting_time
        stuck = far * spring / (1.0 + spring)
        last = (np.abs(path - path[-1]) <= far) & (course.clock >= course.begin)
        there = float(np.ptp(path[course.clock >= course.begin])) >= far and int(last.sum()) >= _SEEN
        if there and np.ptp(course.force[last]) <= min(_SETTLED * abs(float(course.force[-1])), _LOADS * stuck):
            return ""
    return (
        ", but K < K*: a slip may come yet, or the drive is slow beside the slider's creep and none ever comes, which "
        f"shows where the force stays as it is for {_PASSED:g} <x_s>; lengthen the path, or give it more points"
    )


def _trend(drop: Array) -> float | None:
    """Slope of log |drop| against number over the later half."""
    if drop.size < _FEWEST:
        return None
    late = np.abs(drop[drop.size // 2 :])
    if late.size < 2 or not (late > 0.0).all():
        return None
    return float(np.expm1(np.polyfit(np.arange(late.size), np.log(late), 1)[0]))
