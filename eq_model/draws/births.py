"""Contacts that form, each with a stretch and a larger threshold: their tables, and compiled draws of whole rows.

In a row each lane has one random word, of which a table makes a whole length.
"""

from functools import cache
from types import SimpleNamespace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, bits_of, double_of, inlined, real, unsigned, whole
from eq_model.draws.streams import LANES, ROW, STARTS, THRESHOLDS, draw, uniform, words_at
from eq_model.draws.tables import CELL_BITS, DEEPEST, FAR, OCTAVES, SIDE, QuantileTable, make_table
from origins import Contacts
from origins.errors import InputError
from origins.start import Start

LEVEL_UNIT = 2.0**-40  # logs of exposures are drawn as whole multiples of this


class DrawnBirths(NamedTuple):
    """The laws of contacts that form, in whole units."""

    thresholds: QuantileTable
    stretches: QuantileTable  # used if `drawn`
    single: np.int64  # the stretch of all contacts, if not `drawn`
    drawn: bool
    largest: np.int64  # upper end of the thresholds: larger stretches are drawn again
    purpose: np.int64  # of the random words
    relaxed: bool  # whether contacts only form at the stretch 0, both at X = 0 and later on


# runs with many seeds share the tables of the same contacts
_tables_made: WeakKeyDictionary[Contacts, dict[str, QuantileTable]] = WeakKeyDictionary()


def tables_of(contacts: Contacts) -> dict[str, QuantileTable]:
    """Tables (lengths) of "thresholds" and, unless these are single values, "start" and "reforming"; made once.

    Raises InputError where they cannot be certified, and where stretches reach so far that the
    survival of the thresholds is below 1e-290.
    """
    if contacts not in _tables_made:
        laws, thresholds = laws_of(contacts), contacts.thresholds
        furthest = max(abs(end) for law in laws.values() for end in law.span)
        # stretches beyond the largest threshold are drawn again, but the others may come close to it
        largest = thresholds.support()[1]
        rarest = float(thresholds.sf(min(furthest, np.nextafter(largest, 0.0))))
        if rarest < 1e-290 and furthest < largest:
            raise InputError(
                f"{' or '.join(laws)}: reaches |x| = {furthest:g}, where the survival of the thresholds is below "
                f"1e-290; use stretches that contacts can have reached, below {thresholds.isf(1e-290):.6g}"
            )
        found = {"thresholds": make_table(thresholds, max(DEEPEST * rarest, 1e-300))}
        spread = ((name, law) for name, law in laws.items() if not law.is_single)
        _tables_made[contacts] = found | {name: make_table(law, name=name) for name, law in spread}
    return _tables_made[contacts]


def laws_of(contacts: Contacts) -> dict[str, Start]:
    """Laws of the stretches at which contacts form: at X = 0, and later on unless they re-form relaxed."""
    reforming = contacts.reforming
    return {"start": contacts.start} | ({"reforming": reforming.law} if reforming else {})


def births_of(contacts: Contacts, unit: float) -> tuple[DrawnBirths, DrawnBirths]:
    """Births at X = 0 and later on, in whole multiples of the length `unit`."""
    tables = {name: table.in_units(unit) for name, table in tables_of(contacts).items()}
    thresholds = tables["thresholds"]
    largest = np.int64(min(contacts.thresholds.support()[1] / unit, float(FAR)))
    relaxed = all(law.span == (0.0, 0.0) for law in laws_of(contacts).values())

    def make(name: str, purpose: np.int64) -> DrawnBirths:
        law, stretches = laws_of(contacts).get(name), tables.get(name, thresholds)
        single = np.int64(round(law.mean() / unit) if law else 0)
        return DrawnBirths(thresholds, stretches, single, name in tables, largest, purpose, relaxed)

    return make("start", STARTS), make("reforming", THRESHOLDS)


class Scratch(NamedTuple):
    """Arrays of one block, for LANES lanes: words of a round, and rows that one stage of a draw passes to the next."""

    thresholds: npt.NDArray[np.uint32]
    stretches: npt.NDArray[np.uint32]
    exposures: npt.NDArray[np.uint32]
    cell: npt.NDArray[np.uint32]
    within: npt.NDArray[np.float64]
    coefficients: npt.NDArray[np.int64]
    survival: npt.NDArray[np.float64]  # the last stretch at which it was wanted, and its value


def make_scratch() -> Scratch:
    """Arrays for one block."""
    words, survival = (
        np.zeros((3, 4 * ROW), np.uint32),
        np.array([-1.0, 0.0]),
    )  # wanted at no stretch so far
    rows = np.zeros(LANES, np.uint32), np.zeros(LANES), np.zeros(2 * LANES, np.int64), survival
    return Scratch(words[0], words[1], words[2], *rows)


@inlined
def _cell_of(v, bits):  # type: ignore[no-untyped-def]
    """The cell of v in units of 2^-32, at 2^bits cells an octave: exponent and first bits of the double's fraction."""
    return max((bits_of(v) >> (52 - bits)) - (whole(1023 + 31 - OCTAVES) << bits) + 1, whole(0))


@inlined
def draw_values(n, row, turn, stream, purpose, table, words, scratch, out):  # type: ignore[no-untyped-def]
    """Whole quantiles for a row of a round. A word's top bit is the side; the rest are octave, cell and place in it.

    `plain_values` is its plain twin.
    """
    if row == 0:
        draw(n, turn, stream, purpose, words)
    start, bits, fraction = unsigned(row * ROW), table.bits, (whole(1) << 52) - 1
    for i in range(unsigned(n)):
        word = words[i + start]
        v = real(np.int32(word & np.uint32(0x7FFFFFFF))) + 0.5
        side = whole(np.int32(word) >> np.int32(31)) & whole((whole(OCTAVES) << bits) + 1)
        scratch.cell[i] = np.uint32(_cell_of(v, bits) + side)
        scratch.within[i] = double_of((bits_of(v) << bits) & fraction | whole(0x3FF << 52)) - 1.0
    for i in range(unsigned(n)):  # copies of sixteen bytes are faster than gather instructions
        k, j = unsigned(scratch.cell[i]) << unsigned(1), i << unsigned(1)
        first, slopes = table.hot[k], table.hot[k + unsigned(1)]
        scratch.coefficients[j], scratch.coefficients[j + unsigned(1)] = first, slopes
    largest = whole(0)
    for i in range(unsigned(n)):
        j, t = i << unsigned(1), scratch.within[i]
        first, slopes = scratch.coefficients[j], scratch.coefficients[j + unsigned(1)]
        # both slopes share one word: the lower half of a double's bits, here c2's, changes it by 1e-6 at most
        c1, c2 = double_of(slopes), double_of(slopes << whole(32))
        value = whole(np.floor(double_of(first) + t * (c1 + t * c2)))
        out[i] = value
        largest = max(largest, value)
    if largest >= FAR:
        _replace_far(n, row, turn, stream, purpose, words, table, out)


def plain_values(
    words: npt.NDArray[np.uint32], further: npt.NDArray[np.uint32], table: QuantileTable
) -> list[int]:
    """Plain twin of `draw_values`: the whole quantiles of random words, to the same bits.

    further : the next 32 bits of each word, which only values beyond the quick cells use.
    """
    return [
        _plain_value(int(word), int(more), table) for word, more in zip(words, further, strict=True)
    ]


def _plain_value(word: int, further: int, table: QuantileTable) -> int:
    """The whole quantile of one word, from its quick cell or else from its tree."""
    above, v = word >> 31, (word & 0x7FFFFFFF) + 0.5  # which side; v in units of 2^-32
    fraction, exponent = np.frexp(v)  # v = fraction 2^exponent, fraction from 1/2 to 1
    octave, across = int(exponent) - 32 + OCTAVES, 2.0 * float(fraction) - 1.0

    within, cell = np.modf(across * 2.0**table.bits)
    cells = OCTAVES << int(table.bits)
    quick = above * (cells + 1)  # the first cell of a side is its tail
    quick += 1 + (octave << int(table.bits)) + int(cell) if octave >= 0 else 0
    first, slopes = table.hot[2 * quick : 2 * quick + 2]
    c0, c1, c2 = np.array([first, slopes, slopes << 32]).view(np.float64)
    value = int(np.floor(c0 + within * (c1 + within * c2)))
    if value < FAR:
        return value

    v = ((word & 0x7FFFFFFF) + (further + 0.5) * 2.0**-32) * 2.0**-32
    node = 1 + (octave << CELL_BITS) + int(across * 2**CELL_BITS) if octave >= 0 else 0
    place = v if node else -np.log2(v)  # tails are tables in -log2 v
    node += above * int(table.above)
    while (lower := int(table.child[node])) >= 0:  # a cell's lower half, and its upper one
        node = lower + int(place >= table.cells[lower + 1, 0])
    left, width, c0, c1, c2 = table.cells[node]
    within = (place - left) / width
    value = c0 + within * (c1 + within * c2)
    return int(np.floor(min(max(value, 1.0 - FAR), FAR - 1.0) + 0.5))


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
    v = (real(word & np.uint32(0x7FFFFFFF)) + (real(further) + 0.5) * 2.0**-32) * 2.0**-32
    return _value_at(word > np.uint32(0x7FFFFFFF), v, table)


@bare
def _value_at(above, v, table):  # type: ignore[no-untyped-def]
    """The whole quantile at v = 1 - u if `above`, else v = u; 0 < v <= 1."""
    if v > 0.5:
        above, v = not above, max(1.0 - v, 1e-300)
    cell = min(_cell_of(v * 2.0**32, whole(CELL_BITS)), whole(SIDE - 1))
    node = cell + (table.above if above else 0)
    place = v if cell else min(-np.log2(v), table.cells[node, 0] + table.cells[node, 1])
    while table.child[node] >= 0:
        node = whole(table.child[node])
        node += whole(place >= table.cells[node + 1, 0])
    t = (place - table.cells[node, 0]) / table.cells[node, 1]
    y = table.cells[node, 2] + t * (table.cells[node, 3] + t * table.cells[node, 4])
    return whole(np.floor(min(max(y, real(1 - FAR)), real(FAR - 1)) + 0.5))


@bare
def beyond(x, fraction, table, last_survival):  # type: ignore[no-untyped-def]
    """A whole threshold above x (whole), at a share of the law beyond: P_c conditional on x_s > x.

    last_survival : a stretch and the survival there, of the last call; the survival is found by bisection
    with the table's own quantiles.
    """
    if last_survival[0] != real(x):
        # from the tree's smallest share to 1, as bit patterns, which increase as the numbers do
        low, high = bits_of(1e-300), bits_of(1.0)
        while high - low > whole(1 << 26):  # 1.5e-8 of a share, finer than tables
            middle = low + ((high - low) >> 1)
            if _value_at(True, double_of(middle), table) > x:
                low = middle
            else:
                high = middle
        last_survival[0], last_survival[1] = real(x), double_of(high)
    return max(_value_at(True, max(last_survival[1] * fraction, 1e-300), table), x)


@cache
def exposures() -> QuantileTable:
    """Table of ln ξ, ξ of the exponential law of mean 1: contacts break where the integral of their rate is ξ."""
    law = SimpleNamespace(
        cdf=lambda x: -np.expm1(-np.exp(x)),
        sf=lambda x: np.exp(-np.exp(x)),
        ppf=lambda q: np.log(-np.log1p(-np.asarray(q))),
        isf=lambda q: np.log(-np.log(q)),
    )
    return make_table(law).in_units(LEVEL_UNIT)


@inlined
def draw_stretches(n, row, turn, stream, births, scratch, r):  # type: ignore[no-untyped-def]
    """Stretches r at which n contacts form."""
    if not births.drawn:
        for i in range(unsigned(n)):
            r[i] = births.single
        return
    purpose, table = births.purpose + 16, births.stretches
    draw_values(n, row, turn, stream, purpose, table, scratch.stretches, scratch, r)
    for i in range(unsigned(n)):
        attempt = 0
        while abs(r[i]) >= births.largest:
            attempt += 1
            word, further, _, _ = words_at(i, turn + (attempt << 48), stream, purpose + 8 + row)
            r[i] = quantile(word, further, table)


@inlined
def draw_thresholds(n, row, turn, stream, births, scratch, r, x):  # type: ignore[no-untyped-def]
    """Thresholds x of n contacts that form at stretches r: P_c conditional on x_s > |r|."""
    purpose, table = births.purpose, births.thresholds
    draw_values(n, row, turn, stream, purpose, table, scratch.thresholds, scratch, x)
    if not births.relaxed:
        _raise_thresholds(n, row, turn, stream, purpose + 32, table, scratch.survival, r, x)


@bare
def _raise_thresholds(n, row, turn, stream, purpose, table, last_survival, r, x):  # type: ignore[no-untyped-def]
    """Draw anew, beyond |r|, the thresholds x that are below it; `last_survival` as `beyond` has it."""
    room = whole(0)
    for i in range(unsigned(n)):  # in vector code
        room = min(room, x[i] - abs(r[i]))
    for i in range(n if room < 0 else 0):
        if x[i] < abs(r[i]):
            a, b, _, _ = words_at(i, turn, stream, purpose + row)
            x[i] = beyond(abs(r[i]), uniform(a, b), table, last_survival)
