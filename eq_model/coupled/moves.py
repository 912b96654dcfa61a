"""Moves of a slider on a spring between events, and the times and loads at which these are."""

from typing import NamedTuple

import numpy as np

from eq_model.compiling import bare, inlined
from eq_model.coupled.queue_kernel import NOTHING, next_event

# The largest distance from the base, 2^-9 units of which a float resolves; on shorter paths the base is 0.
FAR_FROM_BASE = 1 << 44


class NextEvent(NamedTuple):
    """What the slider meets next as it moves on: an event of the queue, where, and the load there."""

    event: int
    x: int  # the slider's own X if nothing is ahead
    load: float  # at x, if nothing breaks before
    force: float  # F there
    needs: float  # the load of the drive that takes the slider there, infinite if nothing is ahead


@bare
def straight(x, places, values):  # type: ignore[no-untyped-def]
    """Linear interpolation at x between increasing places; where places are equal, the first value."""
    k = min(max(np.searchsorted(places, x), 1), places.size - 1)
    step = places[k] - places[k - 1]
    fraction = (x - places[k - 1]) / step if step > 0.0 else 1.0
    return values[k - 1] + fraction * (values[k] - values[k - 1])


@inlined
def load_at(time, s, pull):  # type: ignore[no-untyped-def]
    """The load of the drive at a time."""
    return pull.spring * (straight(time, pull.clock, pull.clock_drive) - np.float64(s.base))


@inlined
def next_return(s, pull):  # type: ignore[no-untyped-def]
    """When contacts form again after their delay, and the load of the drive then; infinite if none are out."""
    if s.returning == s.returns:
        return np.inf, np.inf
    due = pull.due[s.returning % pull.due.size]
    return due, load_at(due, s, pull)


@inlined
def time_of_drive(s, pull):  # type: ignore[no-untyped-def]
    """When the load of the drive is `s.drive`; in a rest of the drive, the latest time that is known."""
    drive = np.float64(s.base) + s.drive / pull.spring
    return max(straight(drive, pull.clock_drive, pull.clock), s.now)


@inlined
def pass_time(s, now):  # type: ignore[no-untyped-def]
    """Let the time be `now`; since the time before, levels of heat have had the same total."""
    s.budget = max(s.budget - s.total * (now - s.now), 0.0)
    s.now = now


@inlined
def move(s, b):  # type: ignore[no-untyped-def]
    """Move the slider to b, without breaks."""
    s.force += s.stiffness * np.float64(b - s.at)
    s.at = b


@inlined
def rebase(s, pull):  # type: ignore[no-untyped-def]
    """Take the slider's X as the new base if the old one is far away."""
    moved = s.at - s.base
    if moved > FAR_FROM_BASE:
        s.base = s.at
        s.drive -= pull.spring * np.float64(moved)


@inlined
def look_ahead(s, queue, pull):  # type: ignore[no-untyped-def]
    """What the slider meets next."""
    event, b = next_event(queue)
    x = s.at if event == NOTHING else b
    force = s.force + s.stiffness * np.float64(x - s.at)
    load = force + pull.spring * np.float64(x - s.base)
    return NextEvent(event, x, load, force, np.inf if event == NOTHING else load)


@inlined
def balance(s, pull, ahead, drive):  # type: ignore[no-untyped-def]
    """X - base where the load is that of the drive, on the way to what is ahead."""
    return np.float64(ahead.x - s.base) - (ahead.load - drive) / (pull.spring + s.stiffness)


@inlined
def store_points(s, pull, ahead, drive, time):  # type: ignore[no-untyped-def]
    """Store X and F at the points that the drive passes before its load is `drive`, or there before `time`."""
    base = np.float64(s.base)
    while s.point < pull.path.size:
        load = pull.spring * (pull.path[s.point] - base)
        if load > drive or (load == drive and pull.time[s.point] >= time):
            return
        x = balance(s, pull, ahead, load)
        pull.at_points[0, s.point] = base + x
        pull.at_points[1, s.point] = load - pull.spring * x
        pull.at_points[2, s.point] = s.n_holding
        s.point += 1
