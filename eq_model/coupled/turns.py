"""The drive of a slider on a spring turns: slider and contacts are mirrored, so that kernels only ever go forward.

A contact breaks at its threshold on either side: one of stretch x on the way back is one of stretch -x on the way
forward. At the turn itself nothing breaks. Mirrored, a contact that is relaxed at the position z is relaxed at -z, and
breaks at -z + x_s ahead: from b = z + x_s, where it would have broken, that is 2 x_s - b.
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


class OneWay(NamedTuple):
    """A part of the drive that goes one way: its `direction`, 1 or -1, and its points path[first:last]; `places` are
    X_T where it begins and at its points, `clock` the times."""

    direction: int
    first: int
    last: int
    places: Array
    clock: Array


def legs_of(drive: Drive, begin: float) -> list[OneWay]:
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
        OneWay(way * (-1) ** k, i, j, places[i : j + 1], clock[i : j + 1])
        for k, (i, j) in enumerate(ends)
    ]


@entry
def turn(slider, queue, ages, pull, places, keys):  # type: ignore[no-untyped-def]
    """Mirror a slider that sticks, and its contacts, where the drive turns to the way of `pull`, which is mirrored
    already; places, keys: room for each contact."""
    s = slider[0]
    ahead = look_ahead(s, queue, pull)
    drive = pull.spring * (-pull.clock_drive[0] - np.float64(s.base))
    x = s.base + np.int64(np.rint(balance(s, pull, ahead, drive)))
    move(s, x if ahead.event == NOTHING else min(x, ahead.x))
    pass_time(s, pull.clock[0])
    s.at, s.base, s.force, s.drive, s.way = -s.at, -s.base, -s.force, -drive, -s.way
    s.point = 0
    mirror(ages.heat, s, queue, ages, places, keys)


@bare
def _mirror_contacts(s, queue, ages, places, keys):  # type: ignore[no-untyped-def]
    """Let contacts wait for their breaks on the other side of a slider that is mirrored already."""
    many = _take_all(queue, places, keys)
    clear(queue, s.at)
    for i in range(many):
        b, key = places[i], keys[i]
        if ages.numbered:
            ages.zero[key] = -ages.zero[key]
            b = place_of(ages, key, s)
        else:
            b = 2 * key - b
        # rounding may put it behind the slider
        add_break(queue, max(b, s.at), key)


@bare
def _take_all(queue, places, keys):  # type: ignore[no-untyped-def]
    """Take all breaks out of the queue: their places, and the keys by which it knows contacts, their numbers or else
    thresholds. Returns how many."""
    many, (event, b) = 0, next_event(queue)
    while event != NOTHING:
        if event == BREAK:
            places[many], keys[many] = b, take_next(queue)
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
    lambda heat, s, queue, ages, places, keys: _mirror_warm_contacts(s, queue, ages),
    lambda heat, *rest: _mirror_contacts(*rest),
)
