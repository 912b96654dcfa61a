"""Compiled draws from the tables: rows of random words, one for each lane, become whole lengths."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import (
    bare,
    bits_of,
    compiled,
    double_of,
    inlined,
    real,
    single_of,
    unsigned,
    whole,
)
from eq_model.draws.streams import FINE, LANES, ROW, words_at
from eq_model.draws.tables import CELL_BITS, FAR, OCTAVES, SIDE

_LOW31, _EXPONENT = np.uint32(0x7FFFFFFF), np.int64(0x3FF << 52)
_FIRST = np.int64(((1023 + 31 - OCTAVES) << CELL_BITS) - 1)
_SHIFT = np.int64(52 - CELL_BITS)
_CLOSE = np.int64(1 << 26)  # in units of a double's last bit: 1.5e-8 of it, finer than tables


class Room(NamedTuple):
    """Scratch rows that one stage of a draw passes to the next, for LANES lanes."""

    words: npt.NDArray[np.uint32]  # of a round
    others: npt.NDArray[np.uint32]  # for stretches
    known: npt.NDArray[np.float64]  # (1 + parts,): a stretch, and the weight of each part above it
    part: npt.NDArray[np.uint32]
    local: npt.NDArray[np.uint32]
    cell: npt.NDArray[np.uint32]
    place: npt.NDArray[np.float64]
    got: npt.NDArray[np.int64]


@compiled
def make_room():  # type: ignore[no-untyped-def]
    """Scratch rows for one block."""
    words, lanes = np.zeros((2, 4 * ROW), np.uint32), np.zeros((3, LANES), np.uint32)
    rows = lanes[0], lanes[1], lanes[2], np.zeros(LANES), np.zeros(2 * LANES, np.int64)
    return Room(words[0], words[1], np.full(9, -1.0), *rows)


@inlined
def _spread(word, part, table):  # type: ignore[no-untyped-def]
    """A word that selects this part, stretched from the part's range of words to all words."""
    spread = table.spreads[part]
    return np.uint32(
        ((unsigned(word) - unsigned(table.begins[part])) * spread + (spread >> unsigned(1)))
        >> unsigned(32)
    )


@bare
def _choose(n, row, words, table, room):  # type: ignore[no-untyped-def]
    """The part that each word of a row selects, and the word stretched to all words."""
    start = unsigned(row * ROW)
    for i in range(unsigned(n)):
        room.part[i] = np.uint32(0)
    for k in range(1, table.begins.size):
        begin = table.begins[k]
        for i in range(unsigned(n)):
            room.part[i] += np.uint32(whole(words[i + start]) >= begin)
    for i in range(unsigned(n)):
        room.local[i] = _spread(words[i + start], unsigned(room.part[i]), table)


@inlined
def _values(n, row, words, table, room, out):  # type: ignore[no-untyped-def]
    """Whole quantiles of n words of a row; True if some are FAR, which `_mend` takes from the tree."""
    start, many = unsigned(row * ROW), table.begins.size
    if many > 1:
        _choose(n, row, words, table, room)
    else:
        for i in range(unsigned(n)):
            room.local[i] = words[i + start]
    for i in range(unsigned(n)):
        word = room.local[i]
        bits = bits_of(real(np.int32(word & _LOW31)) + 0.5)
        cell = max((bits >> _SHIFT) - _FIRST, whole(0))
        room.cell[i] = np.uint32(cell + (whole(np.int32(word) >> np.int32(31)) & whole(SIDE)))
        inside = (bits & ((whole(1) << _SHIFT) - whole(1))) << whole(CELL_BITS)
        room.place[i] = double_of(inside | _EXPONENT) - 1.0
    if many > 1:
        for i in range(unsigned(n)):
            room.cell[i] += room.part[i] * np.uint32(2 * SIDE)
    for i in range(unsigned(n)):  # copies of sixteen bytes are faster than gather instructions
        k, j = unsigned(room.cell[i]) << unsigned(1), i << unsigned(1)
        first, slopes = table.hot[k], table.hot[k + unsigned(1)]
        room.got[j], room.got[j + unsigned(1)] = first, slopes
    most = whole(0)
    for i in range(unsigned(n)):
        j, t = i << unsigned(1), room.place[i]
        slopes = room.got[j + unsigned(1)]
        c1, c2 = real(single_of(np.int32(slopes))), real(single_of(np.int32(slopes >> whole(32))))
        value = whole(np.floor(double_of(room.got[j]) + t * (c1 + t * c2) + 0.5))
        out[i] = value
        most = max(most, value)
    return most >= FAR


@bare
def _mend(n, row, turn, stream, purpose, words, table, out):  # type: ignore[no-untyped-def]
    """Compute the values of a row that the quick cells do not contain, with further random words."""
    for i in range(unsigned(n)):
        if out[i] >= FAR:
            fine, _, _, _ = words_at(i, turn, stream, purpose + FINE + row)
            out[i] = quantile(words[i + unsigned(row * ROW)], fine, table)


@inlined
def draw_values(n, row, turn, stream, purpose, words, table, room, out):  # type: ignore[no-untyped-def]
    """Whole quantiles of n words of a row, also of those that the quick cells do not contain."""
    if _values(n, row, words, table, room, out):
        _mend(n, row, turn, stream, purpose, words, table, out)


@bare
def quantile(word, fine, table):  # type: ignore[no-untyped-def]
    """The whole quantile of a word, with `fine` as its next 32 bits."""
    part = whole(0)
    while part + 1 < table.begins.size and whole(word) >= table.begins[part + 1]:
        part += 1
    local, grain = np.uint32(word), 1.0
    if table.begins.size > 1:
        local, grain = _spread(word, part, table), real(table.spreads[part]) * 2.0**-32
    v = abs(real(local & _LOW31) + 0.5 + ((real(fine) + 0.5) * 2.0**-32 - 0.5) * grain) * 2.0**-32
    return _whole(value_at(part, local > _LOW31, v, table))


@inlined
def _whole(y):  # type: ignore[no-untyped-def]
    return whole(np.floor(min(max(y, real(1 - FAR)), real(FAR - 1)) + 0.5))


@bare
def value_at(part, above, v, table):  # type: ignore[no-untyped-def]
    """The quantile, in units, of a part at v = 1 - u if `above`, else v = u; 0 < v <= 1/2."""
    cell = min(max((bits_of(v * 2.0**32) >> _SHIFT) - _FIRST, whole(0)), whole(SIDE - 1))
    node = table.first[part] + (SIDE if above else 0) + cell
    place = v if cell else min(-np.log2(v), table.cells[node, 0] + table.cells[node, 1])
    while table.child[node] >= 0:
        node = whole(table.child[node])
        node += whole(place >= table.cells[node + 1, 0])
    t = (place - table.cells[node, 0]) / table.cells[node, 1]
    return table.cells[node, 2] + t * (table.cells[node, 3] + t * table.cells[node, 4])


@bare
def _survival(part, x, table):  # type: ignore[no-untyped-def]
    """The share of a part above x (in units), by bisection with the part's own quantiles."""
    # from the tree's smallest share to 1, as bit patterns, which increase as the numbers do
    first, high = bits_of(1e-300), bits_of(1.0)
    low = first
    while high - low > _CLOSE:
        middle = low + ((high - low) >> 1)
        v = double_of(middle)
        upper = v <= 0.5
        if value_at(part, upper, v if upper else 1.0 - v, table) > x:
            low = middle
        else:
            high = middle
    return double_of(high) if low > first else 0.0


@bare
def beyond(x, first, second, table, room):  # type: ignore[no-untyped-def]
    """A whole threshold above x (whole), from two numbers between 0 and 1: P_c conditional on x_s > x."""
    known, many = room.known, table.begins.size
    if known[0] != real(x):
        known[0] = real(x)
        for k in range(many):
            known[k + 1] = table.weights[k] * _survival(whole(k), real(x), table)
    first *= known[1 : many + 1].sum()
    part = whole(0)
    while part + 1 < many and first >= known[part + 1]:
        first -= known[part + 1]
        part += 1
    v = known[part + 1] / table.weights[part] * second
    if v <= 0.5:
        return max(_whole(value_at(part, True, max(v, 1e-300), table)), x)
    return max(_whole(value_at(part, False, 1.0 - v, table)), x)
