"""The regime of a soft slider, smooth, stick-slip or slips that die out, judged by the slips that were found."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.motion import drive_motion
from master.soft.drops import FEWEST, STEADY, closes_in, limit_of, trend_of
from master.soft.followed import NOTHING_KNOWN, UNRELIABLE, Followed
from master.soft.slips import Slips
from master.soft.unfed_swings import unfed_swings
from master.stick_slip.extremes import extremes
from master.survival.make import why_no_life
from origins import Contacts
from origins.drive import SLIP_FRACTION, Drive

Verdict = Literal["smooth", "stick-slip", "decaying transient", "undecided"]

# Part of the last drop above which the limit of drops that fade ever less is no end of the slips: those that fade as
# one over their number have an apparent limit of a half.
LASTING = 0.6
# Fewest slips that tell of those to come if each leaves all contacts new: where the second and the third are alike, so
# are the contacts before the third and the fourth. Part of the drop that their error may be, and share of the contacts
# that may hold on.
FEWEST_OF_NEW, OF_DROP, HOLD_ON = 3, 0.02, 1e-6
# Force, in mean thresholds, at or below which, and within its error, no contact holds on after a slip.
NO_FORCE = 1e-3


@dataclass(frozen=True)
class Regime:
    """Verdict and evidence.

    verdict, reason : "smooth", "stick-slip", "decaying transient" or "undecided", and why.
    critical_spring : K*/(N_c <k>) from the start on, of a rigid slider that moves forward as fast as the drive does at
        most: at T = 0 a stiffer spring slips only after a turn. It is not that of steady sliding, where the start is
        forgotten. nan, with an error of inf, where `wall_time` ended before, and for contacts that age in heat or
        towards a law that is not normal.
    stiffness_ratio : K/K*.
    slips : number found along the path.
    trend : relative change of the force drop from one slip to the next over the later half of the slips; None for fewer
        than 4 slips, and where these drops are not monotone.
    largest_slip : the largest share of the contacts that breaks in a slip; None where that of a slip is not known, and
        without slips. Below SLIP_FRACTION (0.2) these are no slips of the slider.
    drive_to : X_T to which a longer path tells more, a length; None where the verdict is known, where nobody knows how
        far, and on paths that turn.
    """

    verdict: Verdict
    reason: str
    critical_spring: float
    critical_spring_error: float
    stiffness_ratio: float
    slips: int
    trend: float | None
    largest_slip: float | None = None
    drive_to: float | None = None


class _Judged(NamedTuple):
    """A verdict and why; X_T to which a longer path tells more, a length, None where none is told."""

    verdict: Verdict
    reason: str
    drive_to: float | None = None


def regime(
    contacts: Contacts, drive: Drive, found: Followed, tolerance: float, until: float
) -> Regime:
    """Judge the slips along the drive's path; K* is looked for up to the reading `until` of time.monotonic()."""
    spring, slips = float(drive.spring or 0.0), found.slips
    count, trend = slips.drive.size, trend_of(slips.drop)
    motion = drive_motion(drive, found.balance)
    fastest = 0.0 if motion is None else float(np.abs(motion.speeds).max())
    unsolved = bool(why_no_life(contacts))  # on a rigid slider
    critical, error, latest = np.nan, np.inf, np.nan
    if not unsolved:
        found_along = extremes(contacts, fastest or drive.velocity, tolerance, until)
        critical, error, steepest = found_along.fall
        # where F falls most steeply a softer spring has slipped, and F was no larger than the largest one
        latest = steepest + found_along.force.value / spring
        if drive.mass is not None:  # and a slider with mass gets fast within one swing
            swing = 2.0 * np.pi * (drive.mass / spring) ** 0.5 + drive.damping / spring
            latest += fastest * swing
    on_spring = (
        f"K = {spring:.6g} N_c<k>, a rigid slider as fast as the drive has K* = {critical:.6g}"
    )
    if np.isnan(critical):
        why = (
            "of these laws is not solved for"
            if unsolved
            else "was not found within this solve's part of wall_time"
        )
        on_spring = f"K = {spring:.6g} N_c<k>; K* {why}"
    turns = motion is not None and np.ptp(np.sign(motion.speeds)) > 1
    if count and spring >= critical and turns:
        on_spring += ", until the drive turns: F may fall more steeply then"
    largest: float | None = None
    drive_to: float | None = None
    if (
        unknown := not found.error_of_force_and_load < UNRELIABLE
    ) or found.force.size < drive.path.size:
        verdict: Verdict = "undecided"
        reason = NOTHING_KNOWN if unknown else f"{count} slips up to where the solution stopped"
    elif not count:  # K* is that of a rigid slider; a soft slider's speed differs from the drive's
        verdict, lacking, drive_to = _without_slips(contacts, drive, found, critical, latest)
        reason = f"{on_spring}; no slip up to the end of the path{lacking}"
    else:
        verdict, reason, drive_to = _by_slips(contacts, drive, found, trend)
        if verdict != "decaying transient" and (ahead := found.slips_ahead()).all_found:
            verdict, reason, drive_to = "decaying transient", ahead.behind(count), None
        speeds = np.empty(0) if motion is None else motion.speeds
        if verdict == "stick-slip" and (
            unfed := unfed_swings(contacts, drive, slips, critical, speeds, trend)
        ):
            verdict, reason = "undecided", f"{reason}; {unfed}"
        fractions = found.fractions_broken[np.isfinite(found.fractions_broken)]
        if fractions.size:
            most = float(fractions.max())
            reason += f"; up to {100.0 * most:.3g}% of the contacts break in a slip"
            largest = most if fractions.size == count else None
        if verdict == "stick-slip" and largest is not None and largest < SLIP_FRACTION:
            verdict = "undecided"
            renewed = ", although a reset renews all" if drive.slip == "reset" else ""
            reason += f", fewer than {SLIP_FRACTION:g}: no stick-slip of the slider{renewed}"
        reason = f"{reason}; {on_spring}"
    if drive_to is not None:  # a little farther, so that its first four digits are far enough, too
        last_step = drive.path[-1] - np.append(found.balance, drive.path)[-2]
        drive_to += 5e-4 * abs(drive_to) * float(np.sign(last_step))
        reason += f"; drive to X_T = {drive_to:.4g}"
    if abs(spring - critical) <= error:
        reason += f"; K* is known to {error:.1e} only, and K is nearer"
    ratio = spring / critical if critical else np.inf
    return Regime(verdict, reason, critical, error, ratio, count, trend, largest, drive_to)


def _by_slips(contacts: Contacts, drive: Drive, found: Followed, trend: float | None) -> _Judged:
    """Whether the slips up to the end of the path continue or fade."""
    spring, slips = float(drive.spring or 0.0), found.slips
    drops, count = np.abs(slips.drop), slips.drive.size
    slipped = f"{count} slips" if count > 1 else "1 slip"
    counted = f"{slipped} up to the end of the path"
    if drive.slip == "reset" and count > 1:
        return _Judged("stick-slip", f"{counted}, and a reset leaves contacts that slip again")
    if (anew := _begins_anew(contacts, drive, found)).size:
        which = f"slip {anew[0] + 1}" if anew[0] else "the first"
        again = f"{counted}, and after {which} all contacts begin again as at first"
        return _Judged("stick-slip", again)
    silent = abs(float(drive.path[-1] - slips.drive[-1]))
    # contacts that broke in a slip wait for their delay, and then bear the slider until they break again
    motion = drive_motion(drive, found.balance)
    fastest = 0.0 if motion is None else float(np.abs(motion.speeds).max())
    first = (spring + 1.0) / spring * _oldest_threshold(contacts, drive, found)
    first += fastest * contacts.waiting_time
    longest = float(np.abs(np.diff(slips.drive)).max(initial=first))
    # slips are over if the last is this many times the longest period ago
    if silent > 1.5 * longest and not found.slips_ahead().drive:
        over = f"then none for {silent / longest:.3g} times the longest period"
        return _Judged("decaying transient", f"{slipped}, {over}")
    if _alike_and_new(contacts, drive, found):
        alike = f"{counted}, the last three alike, each of which leaves all contacts new"
        return _Judged("stick-slip", alike)
    if count < FEWEST:
        farther = _farther(drive, slips, (FEWEST + 1 - count) * longest)
        return _Judged("undecided", f"{counted} are too few to tell", farther)
    # a drop is known to the error of its two forces
    unsure = 2.0 * found.error_of_force_and_load * contacts.mean_threshold
    faded = trend is not None and trend < -STEADY
    if faded and drops[count // 2] - drops[-1] <= unsure:
        if unsure <= OF_DROP * drops[-1]:
            return _Judged("stick-slip", f"{counted}, their drops alike within their errors")
        may = f"{counted}, which may fade by less than their error; tighten the tolerance"
        return _Judged("undecided", may)
    if trend is not None and trend < -STEADY and (limit := limit_of(drops)) > LASTING * drops[-1]:
        fading = f"{counted}, whose drops fade ever less, perhaps to {limit:.3g}"
        return _Judged("undecided", fading, _farther(drive, slips, count * longest))
    if trend is not None and trend < -STEADY:
        may_keep_step = drive.slip == "instant" and contacts.thresholds.atoms[1].sum() > 0.5
        fades = f"{count} slips, each drop {-trend:.2%} smaller than the last"
        return _Judged("undecided" if may_keep_step else "decaying transient", fades)
    # the largest of the last third beside that of the last two thirds
    late, longer = float(drops[-(count // 3) :].max()), float(drops[count // 3 :].max())
    if trend is not None or late >= (1.0 - STEADY) * longer:
        lasting = f"{counted}, their drops not fading: the largest of late is {late:.3g}"
        return _Judged("stick-slip", lasting)
    if closes_in(drops) and unsure <= OF_DROP * drops[-1]:
        return _Judged("stick-slip", f"{counted}, each drop between the two before it")
    return _Judged("undecided", f"{counted}, whose drops go up and down: lengthen it")


def _farther(drive: Drive, slips: Slips, way: float) -> float | None:
    """X_T so far beyond the last slip; None on a path that turns, which does not go on so."""
    steps = np.diff(drive.path)
    if steps.min(initial=0.0) < 0.0 < steps.max(initial=0.0):
        return None
    last = float(slips.drive[-1])
    return last + float(np.sign(last)) * way


def _begins_anew(contacts: Contacts, drive: Drive, found: Followed) -> NDArray[np.int64]:
    """Indices of the slips that leave contacts as at the start: relaxed, on a drive that goes forward at one speed, and
    in a slip none forms again and none holds on. With a delay the first alone may: later, some are out already. And
    those that broke one delay before it, or less, come back before the others: only where the spring regains in a delay
    no more than the slip took do they slip together again. After longer ones they draw apart from slip to slip, and
    sliding may become smooth (`test_contacts_that_wait_long_draw_apart_from_slip_to_slip`)."""
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
    out = drive.slip != "instant" or contacts.delay is not None
    force_after = found.slips.force_after
    if contacts.delay:
        regained = float(drive.spring or 0.0) * drive.velocity * contacts.waiting_time
        force_after = force_after[:1][regained <= np.abs(found.slips.drop[:1])]
    force = np.abs(force_after) / contacts.mean_threshold
    steadily = drive.forward and (drive.time is None or not contacts.in_time)
    alike = relaxed and steadily and not contacts.older_at_start
    return np.flatnonzero((force <= min(found.error_of_force_and_load, NO_FORCE)) & (alike and out))


def _alike_and_new(contacts: Contacts, drive: Drive, found: Followed) -> bool:
    """Whether the last slips are alike within their error, a small one, each is longer than any threshold, and further
    from the next than the delay: contacts remember one slip then, and those that follow are alike."""
    slips, even = found.slips, drive.forward and drive.time is None
    if slips.drive.size < FEWEST_OF_NEW or not even or contacts.changing is not None:
        return False
    drop, period = slips.drop[-FEWEST_OF_NEW:], np.diff(slips.drive[-FEWEST_OF_NEW:])
    travel = (slips.after - slips.before)[-FEWEST_OF_NEW:]
    unknown = 2.0 * found.error_of_force_and_load * contacts.mean_threshold
    alike = float(np.ptp(drop)) <= unknown + STEADY * drop.min()
    in_turn = float(np.ptp(period)) <= 4.0 * slips.drive_error + STEADY * period.min()
    new = travel.min() > float(contacts.thresholds.isf(HOLD_ON))
    in_turn = in_turn and period.min() > drive.velocity * contacts.waiting_time
    return bool(unknown <= OF_DROP * drop.min() and alike and in_turn and new)


def _oldest_threshold(contacts: Contacts, drive: Drive, found: Followed) -> float:
    """See Contacts.oldest_threshold: that at the end of the path."""
    return contacts.oldest_threshold(float(drive.arrival_times(found.balance)[-1]))


def _without_slips(
    contacts: Contacts, drive: Drive, found: Followed, critical: float, latest: float
) -> _Judged:
    """Whether a path without slips proves smooth sliding; if not, what it lacks. `latest`: X_T before which a slider
    that is as fast as its drive slips below K*, nan where unknown.

    Without ageing it cannot slip above K* before it turns; with heat it may creep with the drive on a softer spring and
    never slip. With ageing, contacts under a slider that runs ahead have no time to age: F drops more steeply than on a
    rigid slider, and K* decides nothing. Once all contacts of the start have broken, the first, steepest drop is over.
    """
    ages = contacts.changing is not None
    spring = float(drive.spring or 0.0)
    smooth = _Judged("smooth", "")
    if not ages and spring >= critical:
        return smooth
    if found.steady_from is not None:  # known to creep on without slips
        last_step = float(drive.path[-1] - np.append(found.balance, drive.path)[-2])
        if last_step * (found.steady_from - drive.path[-1]) <= 0.0:
            return smooth
        lacks = ", but F, which creeps to that of steady sliding, is not there to the tolerance"
        return _Judged("undecided", lacks, found.steady_from)
    motion = drive_motion(drive, found.balance)
    moving = np.flatnonzero([] if motion is None else motion.speeds)
    if motion is None or not moving.size or not (ages or "thermal" in contacts.laws):
        if drive.mass is not None and drive.forward and drive.path[-1] > latest:
            return smooth  # it fell by less than what counts as a slip
        if drive.forward and np.isfinite(latest):
            return _Judged("undecided", ", but the first one comes later", latest)
        return _Judged("undecided", ", but it ends before a first slip may come; lengthen it")
    times, place = drive.arrival_times(found.balance), drive.path - found.force / spring
    begin, speed = motion.times[moving[-1]], abs(motion.speeds[moving[-1]])
    slid = abs(place[-1] - np.interp(begin, np.append(0.0, times), np.append(0.0, place)))
    # largest thresholds that the slider must have passed without slip, more on a spring below K*
    far = _oldest_threshold(contacts, drive, found) * (1.5 if ages else 3.0)
    far += 0.0 if ages else speed * contacts.waiting_time
    if slid <= far:
        text = f", but one may come until the slider has gone on by {far:.3g}"
        # the slider is behind its drive by F/K: once F is largest, it goes as far as the drive
        ahead = max(latest + far, float(abs(drive.path[-1])) + far - slid)
        if drive.forward and ahead > 0.0:
            return _Judged("undecided", text, ahead)
        return _Judged("undecided", f"{text}; lengthen the path")
    force = np.abs(found.force)
    # 0.1 of the rise of F over the last step of the path if the slider sticks: less may be rounding, or errors
    rise = 0.1 * spring / (1.0 + spring) * abs(drive.path[-1] - drive.path[-2:][0])
    if force[-1] > force[:-1].max(initial=0.0) + rise:
        lacks = ", where the force still rises as high as never before; lengthen it"
        return _Judged("undecided", lacks)
    return smooth
