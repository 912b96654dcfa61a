"""What coupled contacts draw, one by one: stretches at which they form, and thresholds.

Nothing else in this folder knows of streams and tables. A replica has streams of its own, so that
no order of replicas shows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined
from eq_model.drawn import cells_of
from eq_model.quantiles import Scratch, beyond, draw_values, scratch
from eq_model.streams import (
    BEYOND,
    LANES,
    REFORMING,
    STARTS,
    THRESHOLDS,
    Stream,
    draw,
    make_stream,
    uniform,
    words_at,
    words_of_round,
)
from eq_model.tables import Table
from origins import Contacts

UNIT_BITS, LARGEST_BITS = 28, 40
_FREE, _FIRST = np.int64(BEYOND), np.uint64(0)


class Supply(NamedTuple):
    """Draws of one law for one replica, in whole units, 4 LANES at a time.

    ready : draws; at : the next of them, how often they were drawn, whether the law has one value
    only, and how many thresholds were drawn beyond a stretch.
    """

    table: Table
    stream: Stream
    purpose: np.int64
    words: npt.NDArray[np.uint32]
    rows: Scratch
    ready: npt.NDArray[np.int64]
    at: npt.NDArray[np.int64]


class Supplies(NamedTuple):
    """Of a replica: thresholds, stretches at X = 0, and those at which contacts form again.

    stretched, again_stretched : whether these are not all 0; top : the largest threshold.
    """

    thresholds: Supply
    starts: Supply
    again: Supply
    stretched: bool
    again_stretched: bool
    top: np.int64


class Draws:
    """Supplies of some contacts' replicas; `seed` is from 0 to 2^64 - 1.

    unit : length of which all positions and thresholds are whole numbers: 2^-28 mean thresholds,
    unless 2^40 of these are less than the largest threshold.
    """

    def __init__(self, contacts: Contacts, seed: int) -> None:
        self._contacts, self._seed, self._cells = contacts, seed, cells_of(contacts)
        self._largest = self._cells["thresholds"].largest
        finest = 2.0**-UNIT_BITS * contacts.mean_threshold
        self.unit = max(finest, 2.0**-LARGEST_BITS * self._largest)
        self._tables = {name: cells.table(self.unit) for name, cells in self._cells.items()}

    def of_replica(self, replica: int) -> Supplies:
        """From the first draw on."""
        law = self._contacts.reforming
        again = None if law is None else law.law
        start = self._contacts.start
        return Supplies(
            thresholds=self._supply("thresholds", int(THRESHOLDS), replica, 0.0),
            starts=self._supply("start", int(STARTS), replica, start.mean()),
            again=self._supply(
                "reforming", int(REFORMING), replica, again.mean() if again else 0.0
            ),
            stretched=start.span != (0.0, 0.0),
            again_stretched=again is not None,
            top=np.int64(self._largest / self.unit) + 1,
        )

    def _supply(self, name: str, purpose: int, replica: int, single: float) -> Supply:
        """Of a law that has a table, or else of one value."""
        table, size = self._tables.get(name), 4 * LANES
        ready = np.full(size, round(single / self.unit), np.int64)
        return Supply(
            table=self._tables["thresholds"] if table is None else table,
            stream=make_stream(self._seed, replica),
            purpose=np.int64(purpose),
            words=words_of_round(),
            rows=scratch(),
            ready=ready,
            at=np.array([size, 0, table is None, 0], np.int64),
        )


@bare
def refill(s):  # type: ignore[no-untyped-def]
    """The next 4 LANES draws."""
    s.at[0] = 0
    if s.at[2]:
        return
    draw(LANES, s.at[1], s.stream, s.purpose, s.words)
    for k in range(4):
        out = s.ready[k * LANES :]
        draw_values(LANES, k, s.at[1], s.stream, s.purpose, s.words, s.table, s.rows, out)
    s.at[1] += 1


@inlined
def take(s):  # type: ignore[no-untyped-def]
    """The next draw."""
    if s.at[0] == s.ready.size:
        refill(s)
    s.at[0] += 1
    return s.ready[np.uint64(s.at[0] - 1)]


@bare
def stretched_contact(thresholds, stretches, top):  # type: ignore[no-untyped-def]
    """Threshold and stretch of a contact that forms: P_c conditional on x_s > |r|."""
    r = take(stretches)
    while abs(r) >= top:  # beyond every threshold
        r = take(stretches)
    x = take(thresholds)
    if x <= abs(r):
        a, b, c, d = words_at(_FIRST, thresholds.at[3], thresholds.stream, _FREE)
        x = beyond(abs(r), uniform(a, b), uniform(c, d), thresholds.table, thresholds.rows)
        thresholds.at[3] += 1
    return max(x, np.int64(1)), r


@inlined
def relaxed_contact(thresholds):  # type: ignore[no-untyped-def]
    """Threshold of a contact that forms at x = 0."""
    return max(take(thresholds), np.int64(1))
