"""A rigid slider on any path: from contacts and drive to the march, and back to force and error."""

from __future__ import annotations

import time as clock

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import Motion
from master.outcome import Progress, outcome
from master.renewal import reading, rule
from master.renewal.births import Births, births_of
from master.renewal.edges import edges
from master.renewal.march import March
from master.solution import Solution
from origins import Contacts, Drive, InputError
from origins.errors import refuse

Array = npt.NDArray[np.float64]

# Mean thresholds: the square of a longer path is no number any more.
FURTHEST = 1e100
# Mean thresholds, of paths that turn round: contacts of one leg are stretched on the next by the
# difference of positions, which are rounded.
FURTHEST_TURN = 1e6
# How far beyond the path's end the motion goes on, in mean thresholds: contacts that reach an exact
# threshold at the end have broken there.
BEYOND = 1e-9
# Panels' tolerance is never below this: conservation itself rounds at some 1e-15.
FINEST = 1e-14
# Error of an integral over births, in units of the tolerance: a panel is the sum of some hundred.
ACCURACY = 3e-3
# Lives on a path on which the speed changes: births of each leg are followed on the next.
MOST_LIVES = 1e7
# Life over delay: positions at which contacts form again know no shorter ones.
SHORTEST_LIFE = 1e-12
# Share of the tolerance that is left to panels where what is left of contacts is not exact.
OF_PANELS = 0.8
# First guess of a panel's width, in units of the length over which the survival is resolved, at a
# tolerance of 1e-8; a polynomial of degree 16 on wider panels errs by the power 16 more.
GRAINS = 6.0
# Round-off of the force, in mean thresholds, for each mean threshold of the way.
ROUND_OFF = 1e-14


def solve_rigid(
    contacts: Contacts,
    drive: Drive,
    life: Life,
    tolerance: float,
    progress: Progress,
    wall_time: float | None = None,
) -> Solution:
    """F along the path of a rigid slider, for contacts of any life; see `solve`."""
    began, mean = clock.perf_counter(), contacts.mean_threshold
    until = np.inf if wall_time is None else clock.monotonic() + wall_time
    timeless = life.timeless and not contacts.waiting_time
    motion, moments = motion_of(drive, mean, timeless)
    check_lives(contacts, motion, life)
    march = march_of(contacts, motion, life, tolerance, until).run()
    reached = march.begin[-1] + march.width[-1] if march.begin else 0.0
    kept = np.full(moments.size, True)
    if march.unfinished:
        kept = (moments <= reached * (1.0 + 1e-12)) & bool(march.begin)
    error = error_of(march, mean)
    progress(error)
    worst = int(np.argmax(march.wrong)) if march.wrong else 0
    at = float(motion.at(np.array(march.begin[worst]))) if march.begin else 0.0
    reason = (
        f"error estimate {error:.1e} is above the tolerance {tolerance:.1e}, near X = {at:.6g}; "
        "loosen the tolerance"
    )
    success, message = outcome(contacts, error, tolerance, reason)
    if march.unfinished:
        end = f"X = {float(motion.at(np.array(reached))):.6g}"
        success, message = False, f"stopped at {end} by wall_time; the path is cut there"
    by_index = drive.time is not None or (not drive.forward and bool(contacts.laws))
    return Solution(
        path=drive.path[kept],
        time=times_of(drive)[kept],
        force=reading.force(march, moments[kept]) if kept.any() else np.empty(0),
        force_error=error,
        holding=reading.holding(march, moments[kept]) if kept.any() else np.empty(0),
        run_time=clock.perf_counter() - began,
        nodes=sum(breaks.size - 1 for breaks in march.breaks),
        success=success,
        message=message,
        _march=march,
        _by_index=by_index,
        _moments=moments[kept],
    )


def times_of(drive: Drive) -> Array:
    """When the path's points are reached."""
    if drive.time is not None:
        return drive.time
    return np.asarray(np.abs(np.diff(drive.path, prepend=0.0)).cumsum() / drive.velocity)


def motion_of(drive: Drive, mean: float, timeless: bool = False) -> tuple[Motion, Array]:
    """The slider's motion to just beyond the path's end, and when the path's points are reached.

    t is the time, or the way where that alone counts. Where the path turns round positions have to
    keep their digits: it may not reach far.
    """
    most = FURTHEST if drive.forward else FURTHEST_TURN
    away = np.abs(drive.path) / mean
    furthest = int(np.argmax(away))
    if not away[furthest] <= most:
        place = -1 if furthest == away.size - 1 else furthest
        limit = "follow at most" if drive.forward else "a path may turn round within"
        told = f"is {away[furthest]:.3g} mean thresholds; {limit} {most:.0e} of them"
        refuse(f"path[{place}]", drive.path[furthest], told)
    times = times_of(drive)
    if timeless:
        times = np.asarray(np.abs(np.diff(drive.path, prepend=0.0)).cumsum())
    steps, moves = np.diff(times, prepend=0.0), np.diff(drive.path, prepend=0.0)
    moved = np.flatnonzero(steps > 0.0)
    speed = float(moves[moved[-1]] / steps[moved[-1]]) if moved.size else drive.velocity
    speed = speed if not timeless or speed else 1.0
    longer = BEYOND * mean / abs(speed or drive.velocity)
    knots = np.concatenate([[0.0], times, [times[-1] + longer]])
    positions = np.concatenate([[0.0], drive.path, [drive.path[-1] + longer * speed]])
    return Motion(knots, positions), times


def check_lives(contacts: Contacts, motion: Motion, life: Life) -> None:
    """Refuse contacts that heat ends too soon for positions, or for turns, to be told.

    Raises InputError.
    """
    if life.timeless or contacts.thermal is None:
        return
    again, mean, scale = births_of(contacts), contacts.mean_threshold, contacts.thermal.rates.scale
    fastest = float(np.abs(motion.speeds).max())
    if not scale * mean < FURTHEST * fastest and fastest > 0.0:
        share = f"{fastest / scale / mean:.1g} of a mean threshold"
        refuse(
            "velocity",
            float(f"{fastest:.12g}"),
            f"contacts break by themselves within {share}; slide faster",
        )
    times = np.geomspace(1e-3, 1e50, 54)[:, None] / scale
    at_rest = Motion(np.array([0.0, times[-1, 0]]), np.zeros(2))
    held = life.left(again, at_rest.history(times, np.zeros((1, 1))))[0, :, 0]
    lasts = float(times[min(int((held > 0.5).sum()), times.size - 1), 0])
    moving = float(np.diff(motion.times)[motion.speeds != 0.0].sum())
    if not motion.one_leg and moving > MOST_LIVES * lasts:
        many = f"contacts break some {moving / lasts:.0e} times on the way"
        told = (
            f"{many}, of which {MOST_LIVES:.0e} are the most where the speed changes; slide faster"
        )
        refuse("attempt_frequency", scale, told)
    if lasts < SHORTEST_LIFE * contacts.waiting_time:
        told = f"contacts hold for {lasts:.0e}, too short to follow beside the delay"
        refuse("delay", contacts.waiting_time, told)


def march_of(
    contacts: Contacts,
    motion: Motion,
    life: Life,
    tolerance: float,
    until: float = np.inf,
    most: float = np.inf,
) -> March:
    """The march along a motion, with panels that end where the number of breaks may bend.

    most : the longest |x| that any contact that holds has, where that is known
    """
    again = births_of(contacts)
    stretch = min(longest_stretch(contacts, motion, life), most)
    # what rounding and the life take of the tolerance is not the panels' any more
    taken = round_off(motion, contacts.mean_threshold)
    taken += life.error * stretch / contacts.mean_threshold
    left = max(tolerance - taken, 0.4 * tolerance)
    left *= 1.0 if life.quick else OF_PANELS
    allowed = max(left * contacts.mean_threshold / stretch, FINEST)
    accuracy = max(ACCURACY * allowed, 1e-15)
    births = Births(life, again, motion, contacts.waiting_time, accuracy)
    found = edges(motion, life, contacts.start, again, contacts.waiting_time, allowed)
    if found.too_many_lumps:
        raise InputError(
            "thresholds: exact values break together more often on this path than can be followed; "
            "give them a width, as in gaussian(mean, std), or shorten the path"
        )
    grain = GRAINS * life.grain * (allowed / 1e-8) ** (1.0 / rule.DEGREE)
    return March(births, contacts.start, found.times, allowed, grain, stretch, until)


def longest_stretch(contacts: Contacts, motion: Motion, life: Life) -> float:
    """The longest |x| that a contact may have on the way: what an error of the number weighs."""
    first = max(abs(end) for end in contacts.start.span)
    most = max(first, *(abs(end) for end in births_of(contacts).span)) + float(
        np.ptp(motion.positions)
    )
    return max(min(life.reach, most), 1e-3 * contacts.mean_threshold)


def error_of(march: March, mean: float) -> float:
    """Bound on the error of the force, in mean thresholds: panels, the life itself, round-off."""
    wrong = max(march.wrong, default=np.inf) + march.life_error
    return float(wrong * march.stretch / mean + round_off(march.motion, mean, march.settled))


def round_off(motion: Motion, mean: float, settled: float = np.inf) -> float:
    """Round-off of the force, in mean thresholds; none is added once breaks are steady."""
    way = float(np.abs(np.diff(motion.positions)).sum())
    if motion.one_leg and np.isfinite(settled):
        way = settled * abs(float(motion.speeds[0]))
    return ROUND_OFF * (1.0 + way / mean)
