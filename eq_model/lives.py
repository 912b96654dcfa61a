"""Contacts with laws of their own, or on any path in time: one lane loop for every law.

A contact is drawn, holds until its law breaks it (`life`, the only thing a law writes, found by the
type of its settings), waits where there is a delay, and is drawn again. The loop is compiled anew for
each type of law, so that other laws cost nothing, and kept on disk, which closures are not.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, compiled, inlined
from eq_model.contact import Contact, bin_of, count_event, later, life, look, place_of
from eq_model.quantiles import beyond, draw_inside, draw_values, scratch
from eq_model.streams import (
    BEYOND,
    EXPOSURES,
    LANES,
    REFORMING,
    STARTS,
    THRESHOLDS,
    draw,
    uniform,
    words_at,
    words_of_round,
)
from eq_model.tables import LEVEL_UNIT

_U, _I, _F = np.uint64, np.int64, np.float64


class Lanes(NamedTuple):
    """The contact of each lane, all of shape (LANES,)."""

    clock: npt.NDArray[np.int64]
    leg: npt.NDArray[np.int64]
    fresh: npt.NDArray[np.bool_]
    start: npt.NDArray[np.int64]  # stretch at X = 0
    left: npt.NDArray[np.int64]  # contacts to follow, this one among them
    lane: npt.NDArray[np.int64]
    drawn: npt.NDArray[np.int64]
    taken: npt.NDArray[np.int64]  # (1,): contacts of the block that were begun


@inlined
def _follow(  # type: ignore[no-untyped-def]
    i, contact, settings, law, course, bins, watch, lanes, sums, counts
):
    """One life of the contact in lane i, whose next one is prepared; whether it broke before the end."""
    birth, end = place_of(contact.clock, contact.leg, course) - contact.stretch, bins.end
    born, broken = bin_of(contact.clock, bins), bins.points.size
    found = life(law, contact, course, watch, counts)
    clock, leg, over = found.clock, found.leg, found.clock > end
    if found.held:
        count_event(1, settings.linked, contact.stiffness, birth, born, bins, sums)
        if not over:
            broken = bin_of(clock, bins)
            count_event(-1, settings.linked, contact.stiffness, birth, broken, bins, sums)
        if counts.shape[0]:
            look(law, contact, course, born, broken, birth, watch, counts)
    if not over and settings.wait > 0.0:
        clock, leg = later(clock, leg, settings.wait, course)
    lanes.drawn[i], lanes.fresh[i] = found.drawn, clock <= end
    lanes.clock[i], lanes.leg[i] = (clock, leg) if clock <= end else (_I(0), _I(0))
    lanes.left[i] -= _I(clock > end)
    return found.held and not over


@bare
def _follow_row(  # type: ignore[no-untyped-def]
    n,
    row,
    turn,
    stream,
    x,
    e,
    r,
    first,
    rows,
    settings,
    law,
    course,
    bins,
    watch,
    lanes,
    sums,
    counts,
):
    """One life in each of n lanes, with a row of draws: breaks and steps."""
    breaks, steps = _I(0), _I(0)
    for i in range(n):
        if lanes.left[i] <= 0:
            continue
        stretch, threshold, before = settings.single, x[i], lanes.drawn[i]
        if not lanes.fresh[i]:
            stretch = lanes.start[i]
        elif settings.spread:
            stretch = r[i]
        if threshold < abs(stretch):
            a, b, c, d = words_at(i, turn, stream, BEYOND + row)
            first_of_two, second = uniform(a, b), uniform(c, d)
            threshold = beyond(abs(stretch), first_of_two, second, settings.thresholds, rows)
        contact = Contact(
            lanes.clock[i],
            lanes.leg[i],
            stretch,
            threshold,
            _F(e[i]) * LEVEL_UNIT,
            _F(threshold) / settings.mean if settings.linked else 1.0,
            lanes.fresh[i],
            lanes.lane[i],
            before,
            stream,
        )
        breaks += _follow(i, contact, settings, law, course, bins, watch, lanes, sums, counts)
        steps += lanes.drawn[i] - before
        if not lanes.fresh[i] and lanes.left[i] > 0:
            lanes.start[i] = first[lanes.taken[0]]
            lanes.taken[0] += 1
    return breaks, steps


@compiled
def follow_lives(stream, count, settings, law, course, bins, watch, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the drive's end: breaks, and steps of those that take any.

    sums : increased. counts : as of contact.look_at.
    """
    n, top, rows = min(LANES, count), settings.top, scratch()
    words, more, again = words_of_round(), words_of_round(), words_of_round()
    x, e, r = np.zeros(LANES, _I), np.zeros(LANES, _I), np.zeros(LANES, _I)
    none, fresh = np.zeros((6, LANES), _I), np.zeros(LANES, np.bool_)
    lanes = Lanes(none[0], none[1], fresh, none[2], none[3], none[4], none[5], np.full(1, n))
    # the stretches at X = 0 of all contacts of the block
    first = np.full(-(-count // LANES) * LANES, settings.begun)
    for part in range(first.size // LANES if settings.drawn else 0):
        draw(_I(LANES), part, stream, STARTS, words)
        own = first[part * LANES : (part + 1) * LANES]
        draw_inside(_I(LANES), _I(0), part, stream, STARTS, words, settings.starts, top, rows, own)
    for i in range(n):
        lanes.lane[i], lanes.start[i], lanes.left[i] = i, first[i], count // n + (i < count % n)
    breaks, steps, turn = _I(0), _I(0), _I(0)
    while n > 0:
        draw(n, turn, stream, THRESHOLDS, words)
        if settings.bears:
            draw(n, turn, stream, EXPOSURES, more)
        if settings.spread:
            draw(n, turn, stream, REFORMING, again)
        for row in range(_I(4)):
            draw_values(n, row, turn, stream, THRESHOLDS, words, settings.thresholds, rows, x)
            if settings.bears:
                draw_values(n, row, turn, stream, EXPOSURES, more, settings.exposures, rows, e)
            if settings.spread:
                table = settings.reforming
                draw_inside(n, row, turn, stream, REFORMING, again, table, top, rows, r)
            found = _follow_row(
                n,
                row,
                turn,
                stream,
                x,
                e,
                r,
                first,
                rows,
                settings,
                law,
                course,
                bins,
                watch,
                lanes,
                sums,
                counts,
            )
            breaks += found[0]
            steps += found[1]
        turn += 1
        n = _kept(n, lanes)
    return breaks, steps


@inlined
def _kept(n, lanes):  # type: ignore[no-untyped-def]
    """Close the ranks of lanes that still have contacts to follow; how many."""
    m = 0
    for i in range(n):
        if lanes.left[i] > 0:
            for one in (lanes.clock, lanes.leg, lanes.start, lanes.left, lanes.lane, lanes.drawn):
                one[m] = one[i]
            lanes.fresh[m] = lanes.fresh[i]
            m += 1
    return m
