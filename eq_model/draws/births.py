"""Compiled: how contacts form, each with a stretch and a threshold beyond it, rows of them at a time."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import compiled, inlined
from eq_model.draws.quantiles import Scratch, beyond, draw_values, quantile, scratch
from eq_model.draws.streams import LANES, ROW, draw, uniform, words_at
from eq_model.draws.tables import Table

_U, _I = np.uint64, np.int64
_STRETCHES, _BEYOND = np.int64(16), np.int64(32)  # of a purpose: what else its words are for
_OTHERS = 8  # of a purpose: words in place of those that cannot be used


class Births(NamedTuple):
    """The laws of contacts that form, in whole units."""

    thresholds: Table
    stretches: Table  # where these are drawn
    single: np.int64  # the stretch of all, where not drawn
    drawn: bool
    top: np.int64  # no threshold lies beyond: stretches from here on are drawn again
    purpose: np.int64  # of the words


class Room(NamedTuple):
    """Words of a round for thresholds and for stretches, and rows to work in."""

    words: npt.NDArray[np.uint32]
    others: npt.NDArray[np.uint32]
    rows: Scratch


@compiled
def make_room():  # type: ignore[no-untyped-def]
    """For LANES lanes."""
    return Room(np.zeros(4 * ROW, np.uint32), np.zeros(4 * ROW, np.uint32), scratch())


@inlined
def draw_round(n, turn, stream, births, room):  # type: ignore[no-untyped-def]
    """The words of n lanes for the four rows of a round."""
    draw(n, turn, stream, births.purpose, room.words)
    if births.drawn:
        draw(n, turn, stream, births.purpose + _STRETCHES, room.others)


@inlined
def form_row(n, row, turn, stream, births, room, x, r):  # type: ignore[no-untyped-def]
    """Thresholds x and stretches r of n contacts that form: P_c conditional on x_s > |r|."""
    table, purpose = births.thresholds, births.purpose
    draw_values(n, row, turn, stream, purpose, room.words, table, room.rows, x)
    if births.drawn:
        own, stretches = purpose + _STRETCHES, births.stretches
        draw_values(n, row, turn, stream, own, room.others, stretches, room.rows, r)
        for i in range(_U(n)):
            attempt = 0
            while abs(r[i]) >= births.top:
                attempt += 1
                word, fine, _, _ = words_at(i, turn + (attempt << 48), stream, own + _OTHERS + row)
                r[i] = quantile(word, fine, stretches)
    else:
        for i in range(_U(n)):
            r[i] = births.single
    few = False
    for i in range(_U(n)):
        few |= x[i] < abs(r[i])
    if few:
        for i in range(n):
            if x[i] < abs(r[i]):
                a, b, c, d = words_at(i, turn, stream, purpose + _BEYOND + row)
                x[i] = beyond(abs(r[i]), uniform(a, b), uniform(c, d), table, room.rows)


@compiled
def form_all(count, stream, births, room):  # type: ignore[no-untyped-def]
    """Thresholds and stretches of `count` contacts, shape (2, count)."""
    out = np.empty((2, -(-count // LANES) * LANES), _I)
    for part in range(_I(out.shape[1] // LANES)):
        x, r = out[0, part * LANES : (part + 1) * LANES], out[1, part * LANES : (part + 1) * LANES]
        turn, row = part >> _I(2), part & _I(3)
        if row == 0:
            draw_round(_I(LANES), turn, stream, births, room)
        form_row(_I(LANES), row, turn, stream, births, room, x, r)
    return out[:, :count]
