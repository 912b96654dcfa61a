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


class Supply(NamedTuple):
    """Draws of one law for one replica, in whole units, 4 LANES at a time.

    single : whether the law has one value only; ready : draws; at : the next of them, how often
    they were drawn, and how many thresholds were drawn beyond a stretch.
    """

    table: Table
    single: bool
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
    unless 2^40 of these are less than the largest threshold; furthest : the largest stretch (a
    length) at which contacts form.
    """

    def __init__(self, contacts: Contacts, seed: int) -> None:
        self._seed, self._again, self._start = seed, contacts.reforming, contacts.start
        cells = cells_of(contacts)
        self._largest = cells["thresholds"].largest
        finest = 2.0**-UNIT_BITS * contacts.mean_threshold
        self.unit = max(finest, 2.0**-LARGEST_BITS * self._largest)
        self._tables = {name: one.table(self.unit) for name, one in cells.items()}
        laws = [contacts.start] + ([self._again.law] if self._again else [])
        self.furthest = min(max(abs(end) for law in laws for end in law.span), self._largest)

    def of_replica(self, replica: int) -> Supplies:
        """From the first draw on."""
        stream = make_stream(self._seed, replica)
        again = self._again.law.mean() if self._again else 0.0
        return Supplies(
            thresholds=self._supply("thresholds", THRESHOLDS, stream, 0.0),
            starts=self._supply("start", STARTS, stream, self._start.mean()),
            again=self._supply("reforming", REFORMING, stream, again),
            stretched=self._start.span != (0.0, 0.0),
            again_stretched=self._again is not None,
            top=np.int64(self._largest / self.unit) + 1,
        )

    def _supply(self, name: str, purpose: np.int64, stream: Stream, single: float) -> Supply:
        """Of a law that has a table, or else of one value."""
        table, size = self._tables.get(name, self._tables["thresholds"]), 4 * LANES
        ready, at = np.full(size, round(single / self.unit), np.int64), np.array([size, 0, 0])
        is_single, words = name not in self._tables, words_of_round()
        return Supply(table, is_single, stream, purpose, words, scratch(), ready, at)


@bare
def refill(s):  # type: ignore[no-untyped-def]
    """The next 4 LANES draws."""
    s.at[0] = 0
    if s.single:
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
        a, b, c, d = words_at(np.uint64(0), thresholds.at[2], thresholds.stream, BEYOND)
        x = beyond(abs(r), uniform(a, b), uniform(c, d), thresholds.table, thresholds.rows)
        thresholds.at[2] += 1
    return max(x, np.int64(1)), r


@inlined
def relaxed_contact(thresholds):  # type: ignore[no-untyped-def]
    """Threshold of a contact that forms at x = 0."""
    return max(take(thresholds), np.int64(1))
