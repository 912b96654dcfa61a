"""Contacts of one block in lanes: drawn, followed until they break, and drawn again.

forward : steady forward motion, cold or warm. A contact that breaks at the stretches x1, x2, ... is relaxed again at
x1, x1 + x2, ... of the slider; the released stretches are summed in the bins of the breaks. The stages are loops over
the lanes, most of which the compiler turns into vector code.

follow_lives : any laws, on any path in time. A contact holds until its law breaks it (`break_of`, selected by the type
of the law's settings), is out for the delay if there is one, and is drawn again. The loop is compiled for each type of
law, so that other laws cost nothing, and cached on disk, which closures cannot be.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, compiled, inlined, real, unsigned, whole
from eq_model.contact import (
    Contact,
    aged_threshold,
    bin_of,
    break_of,
    break_row,
    count_event,
    later,
    look_at,
    place_of,
)
from eq_model.draws.births import LEVEL_UNIT, draw_round, form_all, form_row
from eq_model.draws.quantiles import draw_values, make_room
from eq_model.draws.streams import EXPOSURES, LANES, ROW, THRESHOLDS, draw

_STARTS = np.int64(12)  # added to a purpose: words of the contacts at X = 0
_REST = 4  # rounds between removals of lanes without contacts


@inlined
def _advance(n, x, birth, at, since, drawn, work, found, change, sums, counts):  # type: ignore[no-untyped-def]
    """Move n contacts from positions `birth`, where they are relaxed, by stretches x to their breaks `at`.

    Returns the number of breaks. The released stretches are summed in the bins of the breaks, `found`; contacts of
    thresholds `drawn` that hold at watched points from `since` on are counted.
    """
    way, measured, breaks = work.way, work.measured, whole(0)
    top, end, last = way.points.size, way.end, way.points.size - 1
    for i in range(unsigned(n)):
        b = birth[i] + x[i]
        breaks += whole(b <= end)
        at[i] = b
    for i in range(unsigned(n) if way.even else unsigned(0)):
        found[i] = np.int32(
            top if at[i] > end else max((at[i] + way.offset) >> way.shift, whole(0))
        )
    for i in range(unsigned(0) if way.even else unsigned(n)):
        found[i] = np.int32(top if at[i] > end else bin_of(at[i], way))
    for i in range(unsigned(n)):
        sums[unsigned(found[i]), 1] += x[i]
    first = way.places[0]
    for i in range(unsigned(n) if measured and way.even else unsigned(0)):
        y = birth[i] - (first + (whole(found[i]) << way.shift))
        change[i] = np.floor(0.5 + real(x[i]) * real(2 * y + x[i]) * way.square)
    for i in range(unsigned(n) if measured and not way.even else unsigned(0)):
        y = birth[i] - way.places[min(whole(found[i]), last)]
        change[i] = np.floor(0.5 + real(x[i]) * real(2 * y + x[i]) * way.square)
    for i in range(unsigned(n) if measured else unsigned(0)):
        sums[unsigned(found[i]), 2] += whole(change[i])
    for i in range(n if counts.shape[0] else 0):
        if since[i] <= end:
            for k in range(way.before[bin_of(since[i], way)], way.before[found[i]]):
                look_at(k, birth[i], real(drawn[i]), way, counts)
    return breaks


@inlined
def _next(n, at, number, firsts, end, ends):  # type: ignore[no-untyped-def]
    """Lanes whose contact holds to the end continue with the next contact, from its first break."""
    last, many = firsts.size - 1, unsigned(0)
    for i in range(unsigned(n)):  # without a branch, which could not be predicted
        ends[many] = np.int32(i)
        many += unsigned(at[i] > end)
    for lane in ends[:many]:
        k = unsigned(lane)
        number[k] = min(number[k] + LANES, last)
        at[k] = firsts[unsigned(number[k])]


@compiled
def forward(work, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the path's end. Returns the number of breaks, and 0 steps.

    sums : increased, as in contact.count_event. counts : increased, as in contact.look_at.
    """
    stream, again, way = work.stream, work.again, work.way
    room, end, place = make_room(), way.end, way.places[0]
    x, at, birth = np.empty(LANES, whole), np.empty(LANES, whole), np.empty(LANES, whole)
    zeros, found, change = np.zeros(LANES, whole), np.empty(LANES, np.int32), room.place
    # all contacts up to their first break; those that break before the end continue in the lanes
    warm, table = work.needs_exposure, work.exposures
    e, words = np.zeros(LANES, whole), np.empty(4 * ROW, np.uint32)
    begun, breaks = form_all(count, stream, work.starts, room), whole(0)
    firsts, many = np.full(count + 1, end + 1), 0
    for part in range(-(-count // LANES)):
        own = begun[:, part * LANES : (part + 1) * LANES]
        n, total, square = own.shape[1], whole(0), whole(0)
        x[:n] = own[0]
        if warm:
            draw(n, whole(part), stream, EXPOSURES + _STARTS, words)
            draw_values(
                n, whole(0), whole(part), stream, EXPOSURES + _STARTS, words, table, room, e
            )
        break_row(work.law, n, x, e, own[1])
        for i in range(unsigned(n)):
            birth[i] = -own[1, i]
            y = birth[i] - place
            total += y
            square += whole(np.floor(0.5 + real(y) * real(y) * way.square))
        sums[0, 0] += n
        sums[0, 1] += total
        sums[0, 2] += square
        breaks += _advance(n, x, birth, at, zeros, own[0], work, found, change, sums, counts)
        for i in range(n):
            firsts[many] = at[i]
            many += at[i] <= end
    firsts[many:] = end + 1
    number, n, turn = np.arange(LANES), min(LANES, many), whole(0)
    own = np.empty((1, LANES), whole)
    at[:n] = firsts[:n]
    while n > 0:
        draw_round(n, turn, stream, again, room)
        if warm:
            draw(n, turn, stream, EXPOSURES, words)
        for row in range(whole(4)):
            draw_values(n, row, turn, stream, THRESHOLDS, room.words, again.thresholds, room, x)
            if warm:
                own[0, :n] = x[:n]
                draw_values(n, row, turn, stream, EXPOSURES, words, table, room, e)
                break_row(work.law, n, x, e, zeros)
            birth, at = at, birth
            drawn = own[0] if warm else x
            breaks += _advance(n, x, birth, at, birth, drawn, work, found, change, sums, counts)
            _next(n, at, number, firsts, end, found)
        turn += 1
        if turn % _REST == 0:
            m = 0
            for i in range(n):  # lanes without further contacts are removed
                if number[i] < many:
                    at[m], number[m] = at[i], number[i]
                    m += 1
            n = m
    return breaks, whole(0)


class Lanes(NamedTuple):
    """The contact of each lane, all of shape (LANES,)."""

    clock: npt.NDArray[np.int64]
    leg: npt.NDArray[np.int64]
    again: npt.NDArray[np.int64]  # 0 for a contact of the start that has not broken
    number: npt.NDArray[np.int64]  # index in the block; the lane's next contact is LANES further
    drawn: npt.NDArray[np.int64]  # steps for which the lane has drawn words


@bare
def _follow_row(n, x, r, e, first, work, lanes, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one life in each of n lanes with a row of draws. Returns the numbers of breaks and steps."""
    breaks, steps, count = whole(0), whole(0), first.shape[1]
    way, law, wait = work.way, work.law, work.wait
    for i in range(unsigned(n)):
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
            real(e[i]) * LEVEL_UNIT,
            real(threshold) / work.mean if work.linked else 1.0,
            lanes.again[i] != 0,
            number % LANES,
            before,
            work.stream,
        )
        birth = place_of(contact.clock, contact.leg, way) - stretch
        found = break_of(law, contact, way, counts)
        clock, leg, over = found.clock, found.leg, found.clock > way.end
        if found.held:
            born, broken = bin_of(contact.clock, way), way.points.size
            count_event(whole(1), contact.stiffness, birth, born, work, sums)
            if not over:
                broken = bin_of(clock, way)
                count_event(whole(-1), contact.stiffness, birth, broken, work, sums)
                breaks += 1
            if counts.shape[0]:
                for k in range(way.before[born], way.before[broken]):
                    threshold_then = aged_threshold(law, contact, way, way.moments[k])
                    if threshold_then >= 0.0:
                        look_at(k, birth, threshold_then, way, counts)
        if not over and wait > 0.0:
            clock, leg = later(clock, leg, wait, way)
        ends = clock > way.end
        steps += found.drawn - before
        lanes.drawn[i], lanes.again[i] = found.drawn, whole(not ends)
        lanes.clock[i], lanes.leg[i] = (whole(0), whole(0)) if ends else (clock, leg)
        lanes.number[i] += LANES if ends else 0
    return breaks, steps


@compiled
def follow_lives(work, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the drive's end. Returns the numbers of breaks and of steps.

    sums : increased, as in contact.count_event. counts : increased, as in contact.look_at.
    """
    n, stream, room = min(LANES, count), work.stream, make_room()
    x, r, e = np.empty(LANES, whole), np.empty(LANES, whole), np.zeros(LANES, whole)
    more, none = np.zeros(4 * ROW, np.uint32), np.zeros((4, LANES), whole)
    lanes = Lanes(none[0], none[1], none[2], np.arange(LANES), none[3])
    first = form_all(count, stream, work.starts, room)
    breaks, steps, turn = whole(0), whole(0), whole(0)
    while n > 0:
        draw_round(n, turn, stream, work.again, room)
        if work.needs_exposure:
            draw(n, turn, stream, EXPOSURES, more)
        for row in range(whole(4)):
            form_row(n, row, turn, stream, work.again, room, x, r)
            if work.needs_exposure:
                table = work.exposures
                draw_values(n, row, turn, stream, EXPOSURES, more, table, room, e)
            broke, stepped = _follow_row(n, x, r, e, first, work, lanes, sums, counts)
            breaks += broke
            steps += stepped
        turn += 1
        m = 0
        for i in range(n):  # lanes without further contacts are removed
            if lanes.number[i] < count:
                for one in lanes:
                    one[m] = one[i]
                m += 1
        n = m
    return breaks, steps
