"""Contacts in steady forward motion, in lanes: where a break is a sum.

A contact that breaks at stretches x1, x2, ..., its thresholds or at a temperature less, stands relaxed
where they add up to; released stretch is summed in the bin where it is released. The stages are loops
over the lanes, most of which the compiler turns into vector code.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.bins import bin_of
from eq_model.breaking import passed, reached
from eq_model.compiling import bare, compiled
from eq_model.quantiles import Scratch, beyond, draw_inside, draw_values
from eq_model.streams import (
    BEYOND,
    EXPOSURES,
    LANES,
    ROW,
    STARTS,
    THRESHOLDS,
    draw,
    uniform,
    words_at,
)
from eq_model.tables import FAR, LEVEL_UNIT, Table
from eq_model.watch import look

_U, _I, _F = np.uint64, np.int64, np.float64
_NONE, _FIRST_STARTS = np.int64(0), np.int64(1 << 39)  # a turn that no row of thresholds comes to
_NOTHING = 1e-300
_REST = 4  # rounds after which lanes without contacts leave


class Plain(NamedTuple):
    """What these contacts are made of."""

    thresholds: Table
    starts: Table  # of the stretches at X = 0, where drawn
    drawn: bool
    begun: np.int64  # the stretch at X = 0 of all, or about the mean where drawn
    square: float  # squared distances from that, whole, are this times unit^-2
    top: np.int64  # no threshold lies beyond
    exposures: Table  # ln e, e of the exponential law of mean 1
    warm: bool  # whether they break at rates
    rates: Any
    unit: float  # a length
    slow: float  # time for a length


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
def _second_moments(n, x, at, bins, found, out):  # type: ignore[no-untyped-def]
    """Changes of y² as n lanes that stand at `at` break at thresholds x; of no use in the last bin."""
    if bins.even:
        for i in range(_U(n)):
            y = at[i] - bins.origin - (_I(found[i]) << bins.shift)
            out[i] = np.floor(0.5 + _F(x[i]) * _F(2 * y + x[i]) * bins.square)
    else:
        last = bins.points.size - 1
        for i in range(_U(n)):
            y = at[i] - bins.places[min(_I(found[i]), last)]
            out[i] = np.floor(0.5 + _F(x[i]) * _F(2 * y + x[i]) * bins.square)


@bare
def _restart(n, start, at, left, before, least, plain, measured):  # type: ignore[no-untyped-def]
    """Let lanes whose contact is over begin the next one at stretches `start`.

    The sums of their distances from `begun`, and of the squares.
    """
    total, square = _I(0), _I(0)
    for i in range(_U(n)):
        over = left[i] < before[i]
        total += start[i] - plain.begun if over & (left[i] > _I(0)) else _I(0)
        at[i] = -start[i] if over else at[i]
        least[i] = max(abs(start[i]), _I(1)) if over else _I(0)
    for i in range(_U(n) if measured else _U(0)):
        used = (left[i] < before[i]) & (left[i] > _I(0))
        apart = _F(start[i] - plain.begun)
        square += _I(np.floor(0.5 + apart * apart * plain.square)) if used else _I(0)
    return total, square


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
def _early(n, x, e, at, least, plain):  # type: ignore[no-untyped-def]
    """Of n lanes with thresholds x the stretches at which they break that bear the exposures e."""
    per, log_slow, one = 1.0 / plain.unit, np.log(plain.slow), 1.0
    for i in range(_U(n)):
        threshold, log_bears = _F(x[i]) * plain.unit, _F(e[i]) * LEVEL_UNIT - log_slow
        # contacts that form again are relaxed; others begin at a stretch of either sign
        near = _F(-at[i]) * plain.unit if least[i] > 0 else 0.0
        if near < 0.0:
            bears = np.exp(log_bears)
            whole = passed(plain.rates, 0.0, -near, threshold, one)
            if whole >= bears:
                left = np.log(max(whole - bears, _NOTHING))
                own = min(reached(plain.rates, left, 0.0, threshold, one), -near)
                x[i] = -_I(np.floor(own * per + 0.5))
                continue
            log_bears, near = np.log(bears - whole), 0.0
        own = reached(plain.rates, log_bears, near, threshold, one)
        x[i] = min(_I(np.floor(min(own * per, _F(FAR)) + 0.5)), x[i])


@bare
def _look(n, since, found, before, birth, threshold, watch, rows, counts):  # type: ignore[no-untyped-def]
    """Count contacts at watched points from the bin `since` to before the bin `found`, which is the next `since`."""
    top = watch.before.size - 2
    for i in range(_U(n)):
        seen = watch.before[_U(found[i])] - watch.before[_U(since[i])]
        rows.got[i] = seen if before[i] > _I(0) else _I(0)
    for i in range(_U(n)):
        if rows.got[i] > 0:
            look(since[i], found[i], birth[i], _F(threshold[i]), watch, counts)
    for i in range(_U(n)):
        since[i] = 0 if found[i] == top else found[i]


@compiled
def forward(stream, count, plain, bins, watch, measured, sums, squares, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the path's end; how many breaks.

    sums : (bins + 1, 2), increased by changes of the number of contacts, which are none, and of the sum
    of y, minus a contact's stretch when its bin ends; squares : (bins + 1, 1), by those of y², where
    `measured`. The last row is that of the start: contacts, distances from `begun` and squares of
    these. counts : as of watch.look.
    """
    n, top = min(LANES, count), bins.points.size
    words, others = np.empty(4 * ROW, np.uint32), np.empty(4 * ROW, np.uint32)
    rows = Scratch(
        np.full(9, -1.0),
        np.empty(LANES, np.uint32),
        np.empty(LANES, np.uint32),
        np.empty(LANES, np.uint32),
        np.empty(LANES),
        np.empty(2 * LANES, _I),
    )
    x, at, start = np.empty(LANES, _I), np.zeros(LANES, _I), np.zeros(LANES, _I)
    more, e, own = np.empty(4 * ROW, np.uint32), np.zeros(LANES, _I), np.zeros(LANES, _I)
    least, used, before = np.zeros(LANES, _I), np.zeros(LANES, _I), np.zeros(LANES, _I)
    left, found = np.zeros(LANES, _I), np.zeros(LANES, np.int32)
    since = np.zeros(LANES, np.int32)
    apart, squared = _I(0), _I(0)
    at[:], least[:] = -plain.begun, abs(plain.begun)
    for i in range(n):
        left[i] = count // n + (i < count % n)
    if plain.drawn:
        draw(n, _FIRST_STARTS, stream, STARTS, words)
        draw_inside(
            n, _NONE, _FIRST_STARTS, stream, STARTS, words, plain.starts, plain.top, rows, start
        )
        before[:] = left + 1
        apart, squared = _restart(n, start, at, left, before, least, plain, measured)
    begins_stretched = plain.drawn or plain.begun != 0
    breaks, turn = _I(0), _I(0)
    while n > 0:
        draw(n, turn, stream, THRESHOLDS, words)
        if plain.drawn:
            draw(n, turn, stream, STARTS, others)
        if plain.warm:
            draw(n, turn, stream, EXPOSURES, more)
        for row in range(_I(4)):
            draw_values(n, row, turn, stream, THRESHOLDS, words, plain.thresholds, rows, x)
            if begins_stretched:
                _beyond_starts(n, row, turn, stream, least, plain.thresholds, rows, x)
            if counts.shape[0]:
                own[:] = x
            if plain.warm:
                draw_values(n, row, turn, stream, EXPOSURES, more, plain.exposures, rows, e)
                _early(n, x, e, at, least, plain)
            if begins_stretched or measured or counts.shape[0]:
                for i in range(_U(n)):
                    before[i], used[i] = left[i], at[i]
            breaks += _advance(n, x, at, left, plain.begun, bins, found)
            for i in range(_U(n)):
                sums[_U(found[i]), _U(1)] += x[i]
            if measured:
                _second_moments(n, x, used, bins, found, rows.place)
                for i in range(_U(n)):
                    squares[_U(found[i]), _U(0)] += _I(rows.place[i])
            if counts.shape[0]:
                _look(n, since, found, before, used, own, watch, rows, counts)
            if plain.drawn:
                draw_inside(
                    n, row, turn, stream, STARTS, others, plain.starts, plain.top, rows, start
                )
                begun = _restart(n, start, at, left, before, least, plain, measured)
                apart += begun[0]
                squared += begun[1]
            elif begins_stretched:
                for i in range(_U(n)):
                    least[i] = abs(plain.begun) if left[i] < before[i] else _I(0)
        turn += 1
        if turn % _REST == 0:
            n = _kept(n, at, left, least, since)
    sums[top, 0], sums[top, 1], squares[top, 0] = count, apart, squared
    return breaks


@bare
def _kept(n, at, left, least, since):  # type: ignore[no-untyped-def]
    """Close the ranks of lanes that still have contacts to follow; how many."""
    m = 0
    for i in range(n):
        if left[i] > 0:
            at[m], left[m], least[m], since[m] = at[i], left[i], least[i], since[i]
            m += 1
    return m
