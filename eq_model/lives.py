"""Contacts with laws of their own, or on any path in time: one lane loop for every law.

A contact is drawn, holds until its law breaks it (`life`, found by the type of the law's settings),
waits where there is a delay, and is drawn again. The loop is compiled anew for each type of law, so
that other laws cost nothing, and kept on disk, which closures are not.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, compiled, inlined
from eq_model.contact import Contact, bin_of, count_event, later, life, look_at, place_of, seen
from eq_model.draws.births import draw_round, form_all, form_row, make_room
from eq_model.draws.quantiles import draw_values
from eq_model.draws.streams import EXPOSURES, LANES, ROW, draw
from eq_model.draws.tables import LEVEL_UNIT

_U, _I, _F = np.uint64, np.int64, np.float64


class Lanes(NamedTuple):
    """The contact of each lane, all of shape (LANES,)."""

    clock: npt.NDArray[np.int64]
    leg: npt.NDArray[np.int64]
    again: npt.NDArray[np.int64]  # 0 of a contact as it is at X = 0
    number: npt.NDArray[np.int64]  # of those of the block; the lane's next one is LANES further
    drawn: npt.NDArray[np.int64]


@inlined
def _follow(i, contact, work, lanes, sums, counts):  # type: ignore[no-untyped-def]
    """One life of the contact in lane i, whose next one is prepared; whether it broke before the end."""
    course, bins, law, wait = work.course, work.bins, work.law, work.settings.wait
    birth = place_of(contact.clock, contact.leg, course) - contact.stretch
    found = life(law, contact, course, work.watch, counts)
    clock, leg, over = found.clock, found.leg, found.clock > bins.end
    if found.held:
        born, broken = bin_of(contact.clock, bins), bins.points.size
        count_event(_I(1), contact.stiffness, birth, born, work, sums)
        if not over:
            broken = bin_of(clock, bins)
            count_event(_I(-1), contact.stiffness, birth, broken, work, sums)
        if counts.shape[0]:
            for k in range(work.watch.before[born], work.watch.before[broken]):
                threshold = seen(law, contact, course, work.watch.moments[k])
                if threshold >= 0.0:
                    look_at(k, birth, threshold, work.watch, counts)
    if not over and wait > 0.0:
        clock, leg = later(clock, leg, wait, course)
    ends = clock > bins.end
    lanes.drawn[i], lanes.again[i] = found.drawn, _I(not ends)
    lanes.clock[i], lanes.leg[i] = (_I(0), _I(0)) if ends else (clock, leg)
    lanes.number[i] += LANES if ends else 0
    return found.held and not over


@bare
def _follow_row(n, turn, x, r, e, first, work, lanes, sums, counts):  # type: ignore[no-untyped-def]
    """One life in each of n lanes, with a row of draws: breaks and steps."""
    breaks, steps, settings, count = _I(0), _I(0), work.settings, first.shape[1]
    for i in range(_U(n)):
        number, before = lanes.number[i], lanes.drawn[i]
        if number >= count:
            continue
        threshold, stretch = x[i], r[i]
        if not lanes.again[i]:
            threshold, stretch = first[0, number], first[1, number]
        contact = Contact(
            lanes.clock[i],
            lanes.leg[i],
            stretch,
            threshold,
            _F(e[i]) * LEVEL_UNIT,
            _F(threshold) / settings.mean if settings.linked else 1.0,
            lanes.again[i] != 0,
            number % LANES,
            before,
            work.stream,
        )
        breaks += _I(_follow(i, contact, work, lanes, sums, counts))
        steps += lanes.drawn[i] - before
    return breaks, steps


@compiled
def follow_lives(work, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the drive's end: breaks, and steps of those that take any.

    sums : increased, as of contact.count_event. counts : as of contact.look_at.
    """
    n, stream, settings, room = min(LANES, count), work.stream, work.settings, make_room()
    x, r, e = np.empty(LANES, _I), np.empty(LANES, _I), np.zeros(LANES, _I)
    more, none = np.zeros(4 * ROW, np.uint32), np.zeros((4, LANES), _I)
    lanes = Lanes(none[0], none[1], none[2], np.arange(LANES), none[3])
    first = form_all(count, stream, settings.starts, room)
    breaks, steps, turn = _I(0), _I(0), _I(0)
    while n > 0:
        draw_round(n, turn, stream, settings.again, room)
        if settings.bears:
            draw(n, turn, stream, EXPOSURES, more)
        for row in range(_I(4)):
            form_row(n, row, turn, stream, settings.again, room, x, r)
            if settings.bears:
                table = settings.exposures
                draw_values(n, row, turn, stream, EXPOSURES, more, table, room.rows, e)
            broke, stepped = _follow_row(n, turn, x, r, e, first, work, lanes, sums, counts)
            breaks += broke
            steps += stepped
        turn += 1
        m = 0
        for i in range(n):  # lanes that have no more contacts leave
            if lanes.number[i] < count:
                for one in (lanes.clock, lanes.leg, lanes.again, lanes.number, lanes.drawn):
                    one[m] = one[i]
                m += 1
        n = m
    return breaks, steps
