"""Where coupled contacts get their numbers: a start for a replica, and thresholds one by one.

Everything that coupled contacts draw comes through this file: `begin`, `make_supply` and the
compiled `draw`. A replica has streams of its own, so that no order of replicas shows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.beginning import Beginning, reforming_table
from eq_model.compiled_table import kernel_table
from eq_model.compiling import compiled, inlined
from eq_model.kernel import LANES, MISSING, ROW, _draw, _exact, _find, _more, _values
from origins import Contacts
from origins.streams import LIFE_TAILS, LIVES, PURPOSE_SHIFT, THRESHOLD_TAILS, THRESHOLDS

Whole = npt.NDArray[np.int64]

UNIT_BITS, LARGEST_BITS = 28, 40
_PART = 1 << 16  # contacts that begin together: their arrays stay small


class Supply(NamedTuple):
    """Draws of one law for one replica, 4 LANES at a time.

    table : quantiles, in whole units; key, second, tail : of the streams; block, lane : counters;
    words, count, base, cell, place, got : scratch; ready : draws in whole units; at : the next of
    them, and how often they were drawn.
    """

    table: tuple[Any, ...]
    key: tuple[np.uint64, np.uint64]
    second: npt.NDArray[np.uint64]
    tail: np.uint64
    block: npt.NDArray[np.uint32]
    lane: npt.NDArray[np.uint64]
    words: npt.NDArray[np.uint32]
    count: npt.NDArray[np.uint32]
    base: npt.NDArray[np.uint32]
    cell: npt.NDArray[np.uint32]
    place: npt.NDArray[np.float64]
    got: Whole
    ready: Whole
    at: Whole


class Draws:
    """All draws of some contacts' replicas.

    contacts : Contacts; n : contacts in a replica; key : of origins.streams.key_of.
    unit : length of which all positions and thresholds are whole numbers: 2^-28 mean thresholds,
    unless 2^40 of these are less than the largest threshold.
    """

    def __init__(self, contacts: Contacts, n: int, key: tuple[int, int]) -> None:
        self.contacts, self.n = contacts, n
        self._start = Beginning(contacts, n, key)
        table = self._start.table
        largest = max(float(table.upper(0.0)) * table.scale, *map(abs, contacts.start.span))
        finest = 2.0**-UNIT_BITS * contacts.mean_threshold
        self.unit = unit = max(finest, 2.0**-LARGEST_BITS * largest)
        self._start.compile(unit)
        law = contacts.reforming
        table = None if law is None else kernel_table(reforming_table(contacts), unit)
        self._again = None if law is None or law.law.is_single else table

    def begin(self, replica: int) -> Iterator[tuple[Whole, Whole]]:
        """Starting stretches and thresholds of a replica, in whole units, part by part."""
        first = replica * self.n
        for done in range(first, first + self.n, _PART):
            part = range(done, min(done + _PART, first + self.n))
            births, thresholds = self._start.draw(part)
            yield -births, np.clip(thresholds, 1, (2 << LARGEST_BITS) - 1)

    def thresholds(self, replica: int) -> Supply:
        """Fresh thresholds of a replica."""
        return self._supply(self._start.compiled, replica, THRESHOLDS, THRESHOLD_TAILS)

    def stretches(self, replica: int) -> Supply:
        """Stretches at which contacts of a replica form again; those of one value are never drawn."""
        table = self._start.compiled if self._again is None else self._again
        supply = self._supply(table, replica, LIVES, LIFE_TAILS)
        if self._again is None:
            law = self.contacts.reforming
            value = 0.0 if law is None else law.law.mean()
            supply.ready[:] = round(value / self.unit)
        return supply

    def _supply(self, table: tuple[Any, ...], replica: int, purpose: int, tails: int) -> Supply:
        second, tail = (np.uint64((p << PURPOSE_SHIFT) | replica) for p in (purpose, tails))
        return Supply(
            table=table,
            key=self._start.words,
            second=np.full(LANES, second, np.uint64),
            tail=tail,
            block=np.empty(LANES, np.uint32),
            lane=np.arange(LANES, dtype=np.uint64),
            words=np.empty(4 * ROW, np.uint32),
            count=np.empty(LANES, np.uint32),
            base=np.empty(LANES, np.uint32),
            cell=np.empty(LANES, np.uint32),
            place=np.empty(LANES),
            got=np.empty(2 * LANES, np.int64),
            ready=np.empty(4 * LANES, np.int64),
            at=np.array([4 * LANES, 0]),
        )


@compiled
def refill(s):  # type: ignore[no-untyped-def]
    """The next 4 LANES draws."""
    hot, shift, pieces, factor, sides, first, edges, cubics = s.table
    s.block[:] = np.uint32(s.at[1])
    _draw(LANES, s.block, s.second, s.lane, s.key[0], s.key[1], s.words)
    for k in range(4):
        _find(LANES, k, s.words, shift, hot, pieces, s.count, s.base, s.cell, s.place, s.got)
        _values(LANES, s.got, s.place, factor, np.uint64(k * LANES), s.ready)
        for i in range(LANES):
            if s.ready[i + k * LANES] >= MISSING:
                word = s.words[i + k * ROW]
                more = _more(word, k, s.block[i], s.tail, s.lane[i], s.key[0], s.key[1])
                s.ready[i + k * LANES] = _exact(word, more, factor, sides, first, edges, cubics)
    s.at[0] = 0
    s.at[1] += 1


@inlined
def draw(s):  # type: ignore[no-untyped-def]
    """The next draw, in whole units."""
    if s.at[0] == s.ready.size:
        refill(s)
    s.at[0] += 1
    return s.ready[np.uint64(s.at[0] - 1)]
