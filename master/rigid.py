"""A rigid slider on any path: from contacts and drive to the march, and back to force and error."""

from __future__ import annotations

import time as clock

import numpy as np
import numpy.typing as npt

from master._old.lives.life import Life
from master._old.renewal import reading
from master._old.renewal.births import Births
from master._old.renewal.edges import edges
from master._old.renewal.march import March
from master._old.solution import Solution
from master.motion.motion import Motion
from master.outcome import Progress, outcome
from origins import Contacts, Drive, InputError
from origins.errors import refuse
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Mean thresholds: the square of a longer path is no number any more.
FURTHEST = 1e100
# How far beyond the path's end the motion goes on, in mean thresholds: contacts that reach an exact
# threshold at the end have broken there.
BEYOND = 1e-9
# Panels' tolerance is never below this: conservation itself rounds at some 1e-15.
FINEST = 1e-14
# First guess of a panel's width, in units of the length over which the survival is resolved.
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
    motion, times = motion_of(drive, mean)
    march = march_of(contacts, motion, life, tolerance, until).run()
    reached = march.begin[-1] + march.width[-1] if march.begin else 0.0
    kept = times <= reached * (1.0 + 1e-12) if march.unfinished else np.full(times.size, True)
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
    by_index = drive.time is not None or not (drive.forward or contacts.plain)
    return Solution(
        path=drive.path[kept],
        time=times[kept],
        force=reading.force(march, times[kept]) if kept.any() else np.empty(0),
        force_error=error,
        holding=reading.holding(march, times[kept]) if kept.any() else np.empty(0),
        run_time=clock.perf_counter() - began,
        nodes=sum(breaks.size - 1 for breaks in march.breaks),
        success=success,
        message=message,
        _march=march,
        _by_index=by_index,
    )


def motion_of(drive: Drive, mean: float) -> tuple[Motion, Array]:
    """The slider's motion to just beyond the path's end, and when the path's points are reached."""
    if not np.abs(drive.path).max() < FURTHEST * mean:
        most = f"follow at most {FURTHEST:.0e} mean thresholds"
        refuse("path", drive.path, f"goes beyond {FURTHEST:.0e} mean thresholds; {most}")
    motion = Motion.of(drive)
    way = np.append(0.0, drive.time if drive.time is not None else _times(drive))
    speed = float(motion.speeds[-1]) if motion.speeds.size else 0.0
    longer = BEYOND * mean / abs(speed or drive.velocity)
    times = np.append(motion.times, motion.times[-1] + longer)
    positions = np.append(motion.positions, motion.positions[-1] + longer * speed)
    return Motion(times, positions), way[1:]


def _times(drive: Drive) -> Array:
    return np.abs(np.diff(drive.path, prepend=0.0)).cumsum() / drive.velocity


def march_of(
    contacts: Contacts, motion: Motion, life: Life, tolerance: float, until: float = np.inf
) -> March:
    """The march along a motion, with panels that end where the number of breaks may bend."""
    again: Start = SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law
    births = Births(life, again, motion, contacts.waiting_time)
    stretch = longest_stretch(contacts, motion, life)
    allowed = max(tolerance * contacts.mean_threshold / stretch, FINEST)
    found = edges(motion, life, contacts.start, again, contacts.waiting_time, allowed)
    if found.too_many_lumps:
        raise InputError(
            "thresholds: exact values break together more often on this path than can be followed; "
            "give them a width, as in gaussian(mean, std), or shorten the path"
        )
    return March(births, contacts.start, found.times, allowed, GRAINS * life.grain, stretch, until)


def longest_stretch(contacts: Contacts, motion: Motion, life: Life) -> float:
    """The longest |x| that a contact may have on the way: what an error of the number weighs."""
    first = max(abs(end) for end in contacts.start.span)
    again = contacts.reforming.law.span if contacts.reforming is not None else (0.0, 0.0)
    most = max(first, *(abs(end) for end in again)) + float(np.ptp(motion.positions))
    return max(min(life.reach, most), 1e-3 * contacts.mean_threshold)


def error_of(march: March, mean: float) -> float:
    """Bound on the error of the force, in mean thresholds: panels, the life itself, round-off."""
    way = float(np.abs(np.diff(march.motion.positions)).sum())
    wrong = max(march.wrong, default=np.inf) + march.life_error
    return wrong * march.stretch / mean + ROUND_OFF * (1.0 + way / mean)
