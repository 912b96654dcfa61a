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
from eq_model.draws.streams import LANES, ROW, draw, words_at
from eq_model.draws.tables import CELL_BITS, FAR, OCTAVES, SIDE

_FRACTION_BITS = np.int64(52 - CELL_BITS)  # of a double, below those that number the cells
_FIRST = np.int64(((1023 + 31 - OCTAVES) << CELL_BITS) - 1)  # a double's bits above, in the tail


class Scratch(NamedTuple):
    """Arrays of one block, for LANES lanes: words of a round, and rows that one stage of a draw passes to the next."""

    thresholds: npt.NDArray[np.uint32]
    stretches: npt.NDArray[np.uint32]
    exposures: npt.NDArray[np.uint32]
    cell: npt.NDArray[np.uint32]
    share: npt.NDArray[np.float64]
    coefficients: npt.NDArray[np.int64]
    survival: npt.NDArray[np.float64]  # the last stretch at which it was wanted, and its value


@compiled
def make_scratch():  # type: ignore[no-untyped-def]
    """Arrays for one block."""
    words, cell = np.zeros((3, 4 * ROW), np.uint32), np.zeros(LANES, np.uint32)
    rows = cell, np.zeros(LANES), np.zeros(2 * LANES, np.int64), np.full(2, -1.0)
    return Scratch(words[0], words[1], words[2], *rows)


@inlined
def draw_values(n, row, turn, stream, purpose, table, words, scratch, out):  # type: ignore[no-untyped-def]
    """Whole quantiles for one of the four rows of a round; `words` are those of the round, drawn for its first row."""
    if row == 0:
        draw(n, turn, stream, purpose, words)
    start = unsigned(row * ROW)
    for i in range(unsigned(n)):
        word = words[i + start]
        bits = bits_of(real(np.int32(word & np.uint32(0x7FFFFFFF))) + 0.5)
        cell = max((bits >> _FRACTION_BITS) - _FIRST, whole(0))
        scratch.cell[i] = np.uint32(cell + (whole(np.int32(word) >> np.int32(31)) & whole(SIDE)))
        inside = (bits & ((whole(1) << _FRACTION_BITS) - whole(1))) << whole(CELL_BITS)
        scratch.share[i] = double_of(inside | whole(0x3FF << 52)) - 1.0
    for i in range(unsigned(n)):  # copies of sixteen bytes are faster than gather instructions
        k, j = unsigned(scratch.cell[i]) << unsigned(1), i << unsigned(1)
        first, slopes = table.hot[k], table.hot[k + unsigned(1)]
        scratch.coefficients[j], scratch.coefficients[j + unsigned(1)] = first, slopes
    largest = whole(0)
    for i in range(unsigned(n)):
        j, t = i << unsigned(1), scratch.share[i]
        first, slopes = scratch.coefficients[j], scratch.coefficients[j + unsigned(1)]
        c1, c2 = real(single_of(np.int32(slopes))), real(single_of(np.int32(slopes >> whole(32))))
        value = whole(np.floor(double_of(first) + t * (c1 + t * c2) + 0.5))
        out[i] = value
        largest = max(largest, value)
    if largest >= FAR:
        _replace_far(n, row, turn, stream, purpose, words, table, out)


@bare
def _replace_far(n, row, turn, stream, purpose, words, table, out):  # type: ignore[no-untyped-def]
    """Compute the values of a row that the quick cells do not contain, with further random words."""
    for i in range(unsigned(n)):
        if out[i] >= FAR:
            further, _, _, _ = words_at(i, turn, stream, purpose + 4 + row)
            out[i] = quantile(words[i + unsigned(row * ROW)], further, table)


@bare
def quantile(word, further, table):  # type: ignore[no-untyped-def]
    """The whole quantile of a word, with `further` as its next 32 bits."""
    low = real(word & np.uint32(0x7FFFFFFF))
    v = (low + (real(further) + 0.5) * 2.0**-32) * 2.0**-32
    return _value_at(word > np.uint32(0x7FFFFFFF), v, table)


@bare
def _value_at(above, v, table):  # type: ignore[no-untyped-def]
    """The whole quantile at v = 1 - u if `above`, else v = u; 0 < v <= 1/2."""
    cell = min(max((bits_of(v * 2.0**32) >> _FRACTION_BITS) - _FIRST, whole(0)), whole(SIDE - 1))
    node = cell + (table.above if above else 0)
    place = v if cell else min(-np.log2(v), table.cells[node, 0] + table.cells[node, 1])
    while table.child[node] >= 0:
        node = whole(table.child[node])
        node += whole(place >= table.cells[node + 1, 0])
    t = (place - table.cells[node, 0]) / table.cells[node, 1]
    y = table.cells[node, 2] + t * (table.cells[node, 3] + t * table.cells[node, 4])
    return whole(np.floor(min(max(y, real(1 - FAR)), real(FAR - 1)) + 0.5))


@bare
def _above(v, table):  # type: ignore[no-untyped-def]
    """The whole value that a share v of all values exceeds, 0 < v <= 1."""
    upper = v <= 0.5
    return _value_at(upper, v if upper else max(1.0 - v, 1e-300), table)


@bare
def beyond(x, share, table, known):  # type: ignore[no-untyped-def]
    """A whole threshold above x (whole), at a share of the law beyond: P_c conditional on x_s > x.

    known : a stretch and the survival there, of the last call; it is found by bisection with the table's own quantiles.
    """
    if known[0] != real(x):
        # from the tree's smallest share to 1, as bit patterns, which increase as the numbers do
        low, high = bits_of(1e-300), bits_of(1.0)
        while high - low > whole(1 << 26):  # 1.5e-8 of a share, finer than tables
            middle = low + ((high - low) >> 1)
            if _above(double_of(middle), table) > x:
                low = middle
            else:
                high = middle
        known[0], known[1] = real(x), double_of(high)
    return max(_above(max(known[1] * share, 1e-300), table), x)
