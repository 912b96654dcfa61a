"""The drive of a slider on a spring turns: slider and contacts are mirrored, so that kernels only ever go forward.

A contact breaks at its threshold on either side: one of stretch x on the way back is one of stretch -x on the way
forward. Where the drive turns the slider goes back with it, and no contact breaks.
"""

from typing import NamedTuple

import numpy as np

from eq_model.compiling import bare, entry
from eq_model.coupled.ages import place_of
from eq_model.coupled.heat import by_heat
from eq_model.coupled.heat_moves import new_windows
from eq_model.coupled.moves import balance, look_ahead, move, pass_time
from eq_model.coupled.queue_kernel import (
    BREAK,
    NOTHING,
    add_break,
    clear,
    next_event,
    open_bucket,
    take_next,
)
from origins import Drive
from origins.thresholds.law import Array


class Leg(NamedTuple):
    """A part of the drive that goes one way: its `way`, 1 or -1, and its points path[first:last]; `places` are X_T
    where it begins and at its points, `clock` the times."""

    way: int
    first: int
    last: int
    places: Array
    clock: Array


def legs_of(drive: Drive, begin: float) -> list[Leg]:
    """The legs of a drive that is at X_T = `begin` at t = 0; a rest belongs to the leg before it."""
    places, clock = np.append(begin, drive.path), np.append(0.0, drive.arrival_times(begin))
    steps = np.diff(places)
    moves = np.flatnonzero(steps)
    ways = np.sign(steps[moves])
    # the first step of each leg but the first
    turns = moves[1:][np.diff(ways) != 0.0]
    ends = zip(np.append(0, turns).tolist(), np.append(turns, steps.size).tolist(), strict=True)
    way = -1 if moves.size and ways[0] < 0.0 else 1
    return [
        Leg(way * (-1) ** k, i, j, places[i : j + 1], clock[i : j + 1])
        for k, (i, j) in enumerate(ends)
    ]


@entry
def turn(slider, queue, ages, pull, places, names):  # type: ignore[no-untyped-def]
    """Mirror a slider that sticks, and its contacts, where the drive turns to the way of `pull`; places, names: room
    for each contact."""
    s = slider[0]
    ahead = look_ahead(s, queue, pull)
    drive = pull.spring * (-pull.clock_drive[0] - np.float64(s.base))
    x = s.base + np.int64(np.rint(balance(s, pull, ahead, drive)))
    move(s, x if ahead.event == NOTHING else min(x, ahead.x))
    pass_time(s, pull.clock[0])
    s.at, s.base, s.force, s.drive, s.way = -s.at, -s.base, -s.force, -drive, -s.way
    s.point = 0
    mirror(ages.heat, s, queue, ages, places, names)


@bare
def _mirror_contacts(s, queue, ages, places, names):  # type: ignore[no-untyped-def]
    """Let contacts wait for their breaks on the other side of a slider that is mirrored already."""
    many = _take_all(queue, places, names)
    clear(queue, s.at)
    for i in range(many):
        b, x = places[i], names[i]
        if ages.numbered:
            ages.zero[x] = -ages.zero[x]
            b = place_of(ages, x, s)
        else:
            b = 2 * x - b
        add_break(queue, max(b, s.at), x)


@bare
def _take_all(queue, places, names):  # type: ignore[no-untyped-def]
    """Take all breaks out of the queue: their places, and by what it knows them. Returns how many."""
    many, (event, b) = 0, next_event(queue)
    while event != NOTHING:
        if event == BREAK:
            places[many], names[many] = b, take_next(queue)
            many += 1
        else:
            open_bucket(queue, b)
        event, b = next_event(queue)
    return many


@bare
def _mirror_warm_contacts(s, queue, ages):  # type: ignore[no-untyped-def]
    """Give contacts windows on the other side; numbers of those that do not hold have no place."""
    for contact in range(ages.zero.size):
        ages.zero[contact] = -ages.zero[contact]
    new_windows(s, queue, ages)


mirror = by_heat(
    lambda heat, s, queue, ages, places, names: _mirror_warm_contacts(s, queue, ages),
    lambda heat, *rest: _mirror_contacts(*rest),
)
