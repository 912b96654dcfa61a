"""Contacts with laws of their own, or on any path in time: one lane loop for every law.

A contact is drawn, holds until its law breaks it (`life`, the only thing a law writes, found by the
type of its settings), waits where there is a delay, and is drawn again. The loop is compiled anew for
each type of law, so that other laws cost nothing, and kept on disk, which closures are not.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.bins import bin_of, later, place_of
from eq_model.compiling import bare, compiled, inlined
from eq_model.contact import Contact, life, look
from eq_model.moments import STIFFNESS_UNIT
from eq_model.quantiles import Scratch, beyond, draw_inside, draw_values
from eq_model.streams import (
    BEYOND,
    EXPOSURES,
    LANES,
    REFORMING,
    ROW,
    STARTS,
    THRESHOLDS,
    draw,
    uniform,
    words_at,
)
from eq_model.tables import LEVEL_UNIT, Table

_U, _I, _F = np.uint64, np.int64, np.float64


class Settings(NamedTuple):
    """What all contacts share, beside their law; in whole units."""

    thresholds: Table
    reforming: Table
    exposures: Table  # ln e, e of the exponential law of mean 1
    single: np.int64  # the stretch at which contacts form again, where it is not drawn
    top: np.int64  # no threshold lies beyond: stretches from here on are drawn again
    mean: float  # threshold, of mean stiffness
    wait: float  # a time
    starts: Table  # of the stretches at X = 0, where drawn
    begun: np.int64  # the stretch at X = 0 of all, or about the mean where drawn
    square: float  # squared distances from that, whole, are this times unit^-2
    drawn: bool
    spread: bool  # whether stretches of re-forming are drawn
    bears: bool  # whether the law asks what contacts bear
    linked: bool  # stiffness to the threshold


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


class Sums(NamedTuple):
    """What is added up in each bin; y: a contact's stretch when its bin ends, with the other sign.

    all : (bins + 1, 2) of the contacts that hold, their number and y; or where stiffness is linked
    (bins + 1, 3), number, k and k y. some : (bins + 1, 5) of measured blocks, (k y)², breaks, squares
    of the forces they took, and where linked k² and k² y. The last row is that of the start, unless
    linked: contacts, their distances from `begun`, and in `some` the squares of these.
    """

    all: npt.NDArray[np.int64]
    some: npt.NDArray[np.int64]
    measured: bool


@inlined
def _event(sign, linked, stiffness, birth, j, bins, sums):  # type: ignore[no-untyped-def]
    """Add to bin j a contact that is born (sign 1) or breaks (-1); birth: slider where it is relaxed."""
    y, j = birth - bins.places[_U(j)], _U(j)
    sums.all[j, _U(0)] += sign
    if not linked:
        sums.all[j, 1] += sign * y
        if sums.measured:
            sums.some[j, 0] += sign * _I(np.rint(_F(y) * _F(y) * bins.square))
        return
    sums.all[j, 1] += sign * _I(np.rint(stiffness * STIFFNESS_UNIT))
    sums.all[j, 2] += sign * _I(np.rint(stiffness * y))
    if sums.measured:
        square, exact = stiffness * stiffness, _F(y)
        sums.some[j, 0] += sign * _I(np.rint(square * exact * exact * bins.square))
        sums.some[j, 3] += sign * _I(np.rint(square * STIFFNESS_UNIT))
        sums.some[j, 4] += sign * _I(np.rint(square * exact))


@inlined
def _follow(  # type: ignore[no-untyped-def]
    i, contact, settings, law, course, bins, watch, lanes, sums, counts
):
    """One life of the contact in lane i, whose next one is prepared; whether it broke before the end."""
    birth, end = place_of(contact.clock, contact.leg, course) - contact.stretch, bins.end
    born, broken = bin_of(contact.clock, bins), bins.points.size
    found = life(law, contact, course, watch, counts)
    lanes.drawn[i] = found.drawn
    clock, leg, over = found.clock, found.leg, found.clock > end
    if found.held:
        if contact.fresh or settings.linked:
            _event(1, settings.linked, contact.stiffness, birth, born, bins, sums)
        else:
            apart, top = contact.stretch - settings.begun, bins.points.size
            sums.all[top, 0] += 1
            sums.all[top, 1] += apart
            sums.some[top, 0] += _I(np.rint(_F(apart) * _F(apart) * settings.square))
        if not over:
            broken = bin_of(clock, bins)
            _event(-1, settings.linked, contact.stiffness, birth, broken, bins, sums)
            if sums.measured:
                force = contact.stiffness * _F(place_of(clock, leg, course) - birth)
                sums.some[broken, 1] += 1
                sums.some[broken, 2] += _I(np.rint(force * force * bins.square))
        if counts.shape[0]:
            look(law, contact, course, born, broken, birth, watch, counts)
    if not over and settings.wait > 0.0:
        clock, leg = later(clock, leg, settings.wait, course)
    if clock > end:
        lanes.left[i] -= 1
        lanes.clock[i], lanes.leg[i], lanes.fresh[i] = 0, 0, False
    else:
        lanes.clock[i], lanes.leg[i], lanes.fresh[i] = clock, leg, True
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
            threshold = beyond(
                abs(stretch), uniform(a, b), uniform(c, d), settings.thresholds, rows
            )
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

    sums : of Sums, increased. counts : as of watch.look.
    """
    n = min(LANES, count)
    words, more = np.empty(4 * ROW, np.uint32), np.empty(4 * ROW, np.uint32)
    again = np.empty(4 * ROW, np.uint32)
    rows = Scratch(
        np.full(9, -1.0),
        np.empty(LANES, np.uint32),
        np.empty(LANES, np.uint32),
        np.empty(LANES, np.uint32),
        np.empty(LANES),
        np.empty(2 * LANES, _I),
    )
    x, e, r = np.zeros(LANES, _I), np.zeros(LANES, _I), np.zeros(LANES, _I)
    lanes = Lanes(
        np.zeros(LANES, _I),
        np.zeros(LANES, _I),
        np.zeros(LANES, np.bool_),
        np.zeros(LANES, _I),
        np.zeros(LANES, _I),
        np.zeros(LANES, _I),
        np.zeros(LANES, _I),
        np.full(1, n),
    )
    # the stretches at X = 0 of all contacts of the block
    first = np.full(-(-count // LANES) * LANES, settings.begun)
    for part in range(first.size // LANES if settings.drawn else 0):
        draw(_I(LANES), part, stream, STARTS, words)
        own = first[part * LANES : (part + 1) * LANES]
        draw_inside(
            _I(LANES), _I(0), part, stream, STARTS, words, settings.starts, settings.top, rows, own
        )
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
                draw_inside(
                    n,
                    row,
                    turn,
                    stream,
                    REFORMING,
                    again,
                    settings.reforming,
                    settings.top,
                    rows,
                    r,
                )
            more_breaks, more_steps = _follow_row(
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
            breaks += more_breaks
            steps += more_steps
        turn += 1
        n = _kept(n, lanes)
    return breaks, steps


@inlined
def _kept(n, lanes):  # type: ignore[no-untyped-def]
    """Close the ranks of lanes that still have contacts to follow; how many."""
    m = 0
    for i in range(n):
        if lanes.left[i] > 0:
            lanes.clock[m], lanes.leg[m], lanes.fresh[m] = (
                lanes.clock[i],
                lanes.leg[i],
                lanes.fresh[i],
            )
            lanes.start[m], lanes.left[m] = lanes.start[i], lanes.left[i]
            lanes.lane[m], lanes.drawn[m] = lanes.lane[i], lanes.drawn[i]
            m += 1
    return m
