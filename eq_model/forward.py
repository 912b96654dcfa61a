"""Contacts in steady forward motion, cold or warm, in lanes: where a break is a sum.

A contact that breaks at x1, x2, ... stands relaxed where these add up to; released stretch is summed
in the bin where it is released. The stages are loops over the lanes, most of which the compiler turns
into vector code.
"""

import numpy as np

from eq_model.compiling import compiled, inlined
from eq_model.contact import bin_of, look_at
from eq_model.draws.births import draw_round, form_all, make_room
from eq_model.draws.quantiles import draw_values
from eq_model.draws.streams import EXPOSURES, LANES, ROW, THRESHOLDS, draw
from eq_model.laws.breaking import break_row

_U, _I, _F = np.uint64, np.int64, np.float64
_STARTS = np.int64(12)  # of a purpose: words of the contacts at X = 0
_REST = 4  # rounds after which lanes without contacts leave


@inlined
def _advance(n, x, birth, at, bins, found):  # type: ignore[no-untyped-def]
    """Move n contacts from where they are relaxed by their thresholds x to where they break, at; how many broke."""
    top, end, breaks = bins.points.size, bins.end, _I(0)
    for i in range(_U(n) if bins.even else _U(0)):
        b = birth[i] + x[i]
        found[i] = np.int32(top if b > end else max((b + bins.offset) >> bins.shift, _I(0)))
        breaks += _I(b <= end)
        at[i] = b
    for i in range(_U(0) if bins.even else _U(n)):
        b = birth[i] + x[i]
        found[i] = np.int32(top if b > end else bin_of(b, bins))
        breaks += _I(b <= end)
        at[i] = b
    return breaks


@inlined
def _release(n, x, birth, bins, measured, found, change, sums):  # type: ignore[no-untyped-def]
    """Add up what n contacts release that were relaxed at `birth` and broke at thresholds x; not in the last bin."""
    last, first, shift, per = bins.points.size - 1, bins.places[0], bins.shift, bins.square
    for i in range(_U(n)):
        sums[_U(found[i]), _U(1)] += x[i]
    for i in range(_U(n) if measured and bins.even else _U(0)):
        y = birth[i] - (first + (_I(found[i]) << shift))
        change[i] = np.floor(0.5 + _F(x[i]) * _F(2 * y + x[i]) * per)
    for i in range(_U(n) if measured and not bins.even else _U(0)):
        y = birth[i] - bins.places[min(_I(found[i]), last)]
        change[i] = np.floor(0.5 + _F(x[i]) * _F(2 * y + x[i]) * per)
    for i in range(_U(n) if measured else _U(0)):
        sums[_U(found[i]), _U(3)] += _I(change[i])


@inlined
def _look(n, x, birth, since, found, bins, watch, counts):  # type: ignore[no-untyped-def]
    """Count n contacts at watched points between where they form, `since`, and the bins where they break."""
    for i in range(n if counts.shape[0] else 0):
        if since[i] <= bins.end:
            for k in range(watch.before[bin_of(since[i], bins)], watch.before[found[i]]):
                look_at(k, birth[i], _F(x[i]), watch, counts)


@inlined
def _next(n, at, number, firsts, end, ends):  # type: ignore[no-untyped-def]
    """Lanes whose contact holds to the end take the next one, where it broke first."""
    last, many = firsts.size - 1, _U(0)
    for i in range(_U(n)):  # no branch: which contacts end cannot be foreseen
        ends[many] = np.int32(i)
        many += _U(at[i] > end)
    for lane in ends[:many]:
        k = _U(lane)
        number[k] = min(number[k] + LANES, last)
        at[k] = firsts[_U(number[k])]


@compiled
def forward(work, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the path's end: how many breaks, and no steps.

    sums : increased, as of contact.count_event. counts : as of contact.look_at.
    """
    stream, again, bins, watch = work.stream, work.settings.again, work.bins, work.watch
    room, measured, end, place = make_room(), work.measured, bins.end, bins.places[0]
    x, at, birth = np.empty(LANES, _I), np.empty(LANES, _I), np.empty(LANES, _I)
    zeros, found, change = np.zeros(LANES, _I), np.empty(LANES, np.int32), room.rows.place
    # all contacts as they begin, up to their first break; those that break go on in the lanes
    warm, e, words = work.settings.bears, np.zeros(LANES, _I), np.empty(4 * ROW, np.uint32)
    begun, breaks = form_all(count, stream, work.settings.starts, room), _I(0)
    firsts, many = np.full(count + 1, end + 1), 0
    for part in range(-(-count // LANES)):
        own = begun[:, part * LANES : (part + 1) * LANES]
        n, total, square = own.shape[1], _I(0), _I(0)
        x[:n] = own[0]
        if warm:
            draw(n, _I(part), stream, EXPOSURES + _STARTS, words)
            table = work.settings.exposures
            draw_values(n, _I(0), _I(part), stream, EXPOSURES + _STARTS, words, table, room.rows, e)
        break_row(work.law, n, x, e, own[1])
        for i in range(_U(n)):
            birth[i] = -own[1, i]
            y = birth[i] - place
            total += y
            square += _I(np.floor(0.5 + _F(y) * _F(y) * bins.square))
        sums[0, 0] += n
        sums[0, 1] += total
        sums[0, 3] += square
        breaks += _advance(n, x, birth, at, bins, found)
        _release(n, x, birth, bins, measured, found, change, sums)
        _look(n, own[0], birth, zeros, found, bins, watch, counts)
        for i in range(n):
            firsts[many] = at[i]
            many += at[i] <= end
    firsts[many:] = end + 1
    number, n, turn = np.arange(LANES), min(LANES, many), _I(0)
    own = np.empty((1, LANES), _I)
    at[:n] = firsts[:n]
    while n > 0:
        draw_round(n, turn, stream, again, room)
        if warm:
            draw(n, turn, stream, EXPOSURES, words)
        for row in range(_I(4)):
            table = again.thresholds
            draw_values(n, row, turn, stream, THRESHOLDS, room.words, table, room.rows, x)
            if warm:
                own[0, :n] = x[:n]
                table = work.settings.exposures
                draw_values(n, row, turn, stream, EXPOSURES, words, table, room.rows, e)
                break_row(work.law, n, x, e, zeros)
            birth, at = at, birth
            breaks += _advance(n, x, birth, at, bins, found)
            _release(n, x, birth, bins, measured, found, change, sums)
            _look(n, own[0] if warm else x, birth, birth, found, bins, watch, counts)
            _next(n, at, number, firsts, end, found)
        turn += 1
        if turn % _REST == 0:
            m = 0
            for i in range(n):  # lanes that have no more contacts leave
                if number[i] < many:
                    at[m], number[m] = at[i], number[i]
                    m += 1
            n = m
    return breaks, _I(0)
