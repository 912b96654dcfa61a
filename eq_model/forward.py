"""Contacts in steady forward motion, in lanes: where a break is a sum.

A contact that breaks at x1, x2, ..., its thresholds or in heat less, stands relaxed where they add up to;
released stretch is summed in the bin where it is released. The stages are loops over the lanes, most of which the
compiler turns into vector code.
"""

import numpy as np

from eq_model.breaking import break_row
from eq_model.compiling import bare, compiled
from eq_model.contact import bin_of, look_at
from eq_model.quantiles import beyond, draw_inside, draw_values, scratch
from eq_model.streams import (
    BEYOND,
    EXPOSURES,
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
def _advance(n, x, at, left, begun, bins, found):  # type: ignore[no-untyped-def]
    """Move n lanes by their thresholds x to where they break, or begin the next contact; how many broke."""
    top, end, breaks = bins.points.size, bins.end, _I(0)
    if bins.even:
        for i in range(_U(n)):
            b = at[i] + x[i]
            over = (b > end) | (left[i] <= _I(0))
            found[i] = np.int32(top if over else max((b + bins.offset) >> bins.shift, _I(0)))
            breaks += _I(not over)
    else:
        for i in range(n):
            b = at[i] + x[i]
            over = (b > end) | (left[i] <= _I(0))
            found[i] = np.int32(top if over else bin_of(b, bins))
            breaks += _I(not over)
    for i in range(_U(n)):
        b = at[i] + x[i]
        over = b > end
        left[i] -= _I(over)
        at[i] = -begun if over else b
    return breaks


@bare
def _release(n, x, birth, bins, found, change, sums):  # type: ignore[no-untyped-def]
    """Add up what n lanes release that were relaxed at `birth` and broke at thresholds x; not in the last bin."""
    last = bins.points.size - 1
    for i in range(_U(n)):
        sums.all[_U(found[i]), _U(1)] += x[i]
    if not sums.measured:
        return
    for i in range(_U(n)):
        place = bins.origin + (_I(found[i]) << bins.shift)
        y = birth[i] - (place if bins.even else bins.places[min(_I(found[i]), last)])
        change[i] = np.floor(0.5 + _F(x[i]) * _F(2 * y + x[i]) * bins.square)
    for i in range(_U(n)):
        sums.some[_U(found[i]), _U(0)] += _I(change[i])


@bare
def _begin(n, start, at, left, before, least, bins, sums):  # type: ignore[no-untyped-def]
    """Let lanes whose contact is over begin the next one at stretches `start`, and count it."""
    many, total, square, origin = _I(0), _I(0), _I(0), bins.places[0]
    for i in range(_U(n)):
        over = left[i] < before[i]
        used = over & (left[i] > _I(0))
        many += _I(used)
        total += -start[i] - origin if used else _I(0)
        at[i] = -start[i] if over else at[i]
        least[i] = max(abs(start[i]), _I(1)) if over else _I(0)
    for i in range(_U(n) if sums.measured else _U(0)):
        used = (left[i] < before[i]) & (left[i] > _I(0))
        y = _F(start[i] + origin)
        square += _I(np.floor(0.5 + y * y * bins.square)) if used else _I(0)
    sums.all[0, 0] += many
    sums.all[0, 1] += total
    sums.some[0, 0] += square


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
def forward(stream, count, settings, law, course, bins, watch, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the path's end: how many breaks, and no steps.

    sums : increased. counts : as of contact.look_at.
    """
    n, thresholds, rows = min(LANES, count), settings.thresholds, scratch()
    words, others, more = words_of_round(), words_of_round(), words_of_round()
    e, own = np.zeros(LANES, _I), np.zeros(LANES, _I)
    x, at, start = np.empty(LANES, _I), np.empty(LANES, _I), np.empty(LANES, _I)
    least, birth, before = np.empty(LANES, _I), np.zeros(LANES, _I), np.zeros(LANES, _I)
    left, found = np.zeros(LANES, _I), np.zeros(LANES, np.int32)
    since = np.zeros(LANES, np.int32)
    for i in range(n):
        left[i] = count // n + (i < count % n)
    before[:] = left + 1
    if settings.drawn:
        turn = _FIRST_STARTS
        draw(n, turn, stream, STARTS, words)
        draw_inside(
            n, _NONE, turn, stream, STARTS, words, settings.starts, settings.top, rows, start
        )
        _begin(n, start, at, left, before, least, bins, sums)
    else:
        at[:], least[:] = -settings.begun, abs(settings.begun)
        y = -settings.begun - bins.places[0]
        sums.all[0, 0] += count
        sums.all[0, 1] += count * y
        sums.some[0, 0] += count * _I(np.floor(0.5 + _F(y) * _F(y) * bins.square))
    stretched, watched = settings.drawn or settings.begun != 0, counts.shape[0] > 0
    breaks, turn = _I(0), _I(0)
    while n > 0:
        draw(n, turn, stream, THRESHOLDS, words)
        if settings.drawn:
            draw(n, turn, stream, STARTS, others)
        if settings.bears:
            draw(n, turn, stream, EXPOSURES, more)
        for row in range(_I(4)):
            draw_values(n, row, turn, stream, THRESHOLDS, words, thresholds, rows, x)
            if stretched:
                _beyond_starts(n, row, turn, stream, least, thresholds, rows, x)
            if watched:
                own[:] = x
            if settings.bears:
                draw_values(n, row, turn, stream, EXPOSURES, more, settings.exposures, rows, e)
            break_row(law, n, x, e, at, least)
            if stretched or watched or sums.measured:
                for i in range(_U(n)):
                    before[i], birth[i] = left[i], at[i]
            breaks += _advance(n, x, at, left, settings.begun, bins, found)
            _release(n, x, birth, bins, found, rows.place, sums)
            if watched:
                _look(n, since, found, before, birth, own, watch, counts)
            if settings.drawn:
                draw_inside(
                    n, row, turn, stream, STARTS, others, settings.starts, settings.top, rows, start
                )
                _begin(n, start, at, left, before, least, bins, sums)
            elif stretched:
                for i in range(_U(n)):
                    least[i] = abs(settings.begun) if left[i] < before[i] else _I(0)
        turn += 1
        if turn % _REST == 0:
            n = _kept(n, at, left, least, since)
    return breaks, _I(0)


@bare
def _kept(n, at, left, least, since):  # type: ignore[no-untyped-def]
    """Close the ranks of lanes that still have contacts to follow; how many."""
    m = 0
    for i in range(n):
        if left[i] > 0:
            at[m], left[m], least[m], since[m] = at[i], left[i], least[i], since[i]
            m += 1
    return m
