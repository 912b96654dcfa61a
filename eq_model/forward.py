"""Contacts without laws on a path forward, in lanes: where a break is a sum.

A contact that breaks at x1, x2, ... stands relaxed where these add up to; released stretch is summed
in the bin where it is released. The stages are loops over the lanes, most of which the compiler turns
into vector code.
"""

import numpy as np

from eq_model.compiling import bare, compiled
from eq_model.contact import bin_of, look_at
from eq_model.quantiles import beyond, draw_inside, draw_values, scratch
from eq_model.streams import (
    BEYOND,
    LANES,
    STARTS,
    THRESHOLDS,
    draw,
    uniform,
    words_at,
    words_of_round,
)

_U, _I, _F = np.uint64, np.int64, np.float64
_NONE, _FIRST_STARTS = np.int64(0), np.int64(1 << 39)  # a turn that no row of thresholds comes to
_REST = 4  # rounds after which lanes without contacts leave


@bare
def _advance(n, x, at, left, birth, begun, bins, found):  # type: ignore[no-untyped-def]
    """Move n lanes by their thresholds x to where they break, or begin the next contact; how many broke."""
    top, end, breaks = bins.points.size, bins.end, _I(0)
    for i in range(_U(n) if bins.even else _U(0)):
        b = at[i] + x[i]
        over = (b > end) | (left[i] <= _I(0))
        found[i] = np.int32(top if over else max((b + bins.offset) >> bins.shift, _I(0)))
        breaks += _I(not over)
    for i in range(_U(0) if bins.even else _U(n)):
        b = at[i] + x[i]
        over = (b > end) | (left[i] <= _I(0))
        found[i] = np.int32(top if over else bin_of(b, bins))
        breaks += _I(not over)
    for i in range(_U(n)):
        b = at[i] + x[i]
        over = b > end
        birth[i] = at[i]
        left[i] -= _I(over)
        at[i] = -begun if over else b
    return breaks


@bare
def _release(n, x, birth, bins, measured, found, change, sums):  # type: ignore[no-untyped-def]
    """Add up what n lanes release that were relaxed at `birth` and broke at thresholds x; not in the last bin."""
    last = bins.points.size - 1
    for i in range(_U(n)):
        sums[_U(found[i]), _U(1)] += x[i]
    for i in range(_U(n) if measured else _U(0)):
        y = birth[i] - bins.places[min(_I(found[i]), last)]
        change[i] = np.floor(0.5 + _F(x[i]) * _F(2 * y + x[i]) * bins.square)
    for i in range(_U(n) if measured else _U(0)):
        sums[_U(found[i]), _U(3)] += _I(change[i])


@bare
def _begin(n, start, at, left, before, least, bins, sums):  # type: ignore[no-untyped-def]
    """Let lanes whose contact is over begin the next one at stretches `start`, and count it."""
    many, total, square, origin = _I(0), _I(0), _I(0), bins.places[0]
    for i in range(_U(n)):
        over = left[i] < before[i]
        used = over & (left[i] > _I(0))
        y = _F(start[i] + origin)
        many += _I(used)
        total += -start[i] - origin if used else _I(0)
        square += _I(np.floor(0.5 + y * y * bins.square)) if used else _I(0)
        at[i] = -start[i] if over else at[i]
        least[i] = max(abs(start[i]), _I(1)) if over else _I(0)
    sums[0, 0] += many
    sums[0, 1] += total
    sums[0, 3] += square


@bare
def _beyond_starts(n, row, turn, stream, least, table, rows, x):  # type: ignore[no-untyped-def]
    """First thresholds exceed the stretches that contacts begin with: P_c conditional on x_s > |x|."""
    few = False
    for i in range(_U(n)):
        few |= x[i] < least[i]
    if few:
        for i in range(n):
            if x[i] < least[i]:
                a, b, c, d = words_at(i, turn, stream, BEYOND + row)
                x[i] = beyond(least[i], uniform(a, b), uniform(c, d), table, rows)


@bare
def _look(n, since, found, before, birth, x, watch, counts):  # type: ignore[no-untyped-def]
    """Count contacts at watched points from the bin `since` to before the bin `found`, the next `since`."""
    top = watch.before.size - 2
    for i in range(n):
        if before[i] > 0:
            for k in range(watch.before[since[i]], watch.before[found[i]]):
                look_at(k, birth[i], _F(x[i]), watch, counts)
        since[i] = 0 if found[i] == top else found[i]


@compiled
def forward(work, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the path's end: how many breaks, and no steps.

    sums : increased, as of contact.count_event. counts : as of contact.look_at.
    """
    n, stream, settings, rows = min(LANES, count), work.stream, work.settings, scratch()
    bins, measured, place = work.bins, work.measured, rows.place
    thresholds, starts, top = settings.thresholds, settings.starts, settings.top
    words, others = words_of_round(), words_of_round()
    x, at, start, birth = (
        np.empty(LANES, _I),
        np.empty(LANES, _I),
        np.empty(LANES, _I),
        np.empty(LANES, _I),
    )
    least, before, left = np.zeros(LANES, _I), np.zeros(LANES, _I), np.zeros(LANES, _I)
    found, since = np.zeros(LANES, np.int32), np.zeros(LANES, np.int32)
    for i in range(n):
        left[i] = count // n + (i < count % n)
    before[:] = left + 1
    if settings.drawn:
        turn = _FIRST_STARTS
        draw(n, turn, stream, STARTS, words)
        draw_inside(n, _NONE, turn, stream, STARTS, words, starts, top, rows, start)
        _begin(n, start, at, left, before, least, bins, sums)
    else:
        at[:], least[:] = -settings.begun, abs(settings.begun)
        y = -settings.begun - bins.places[0]
        sums[0, 0] += count
        sums[0, 1] += count * y
        sums[0, 3] += count * _I(np.floor(0.5 + _F(y) * _F(y) * bins.square))
    stretched, watched = settings.drawn or settings.begun != 0, counts.shape[0] > 0
    breaks, turn = _I(0), _I(0)
    while n > 0:
        draw(n, turn, stream, THRESHOLDS, words)
        if settings.drawn:
            draw(n, turn, stream, STARTS, others)
        for row in range(_I(4)):
            draw_values(n, row, turn, stream, THRESHOLDS, words, thresholds, rows, x)
            if stretched:
                _beyond_starts(n, row, turn, stream, least, thresholds, rows, x)
            if settings.drawn:
                draw_inside(n, row, turn, stream, STARTS, others, starts, top, rows, start)
            if stretched or watched:
                for i in range(_U(n)):
                    before[i] = left[i]
            breaks += _advance(n, x, at, left, birth, settings.begun, bins, found)
            _release(n, x, birth, bins, measured, found, place, sums)
            if watched:
                _look(n, since, found, before, birth, x, work.watch, counts)
            if settings.drawn:
                _begin(n, start, at, left, before, least, bins, sums)
            elif stretched:
                for i in range(_U(n)):
                    least[i] = abs(settings.begun) if left[i] < before[i] else _I(0)
        turn += 1
        if turn % _REST == 0:
            m = 0
            for i in range(n):  # lanes that have no more contacts leave
                if left[i] > 0:
                    at[m], left[m], least[m], since[m] = at[i], left[i], least[i], since[i]
                    m += 1
            n = m
    return breaks, _I(0)
