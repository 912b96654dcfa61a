"""What coupled contacts draw, one by one, in whole units; a replica has streams of its own, so that no order of
replicas shows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined
from eq_model.draws.births import Births, Room, draw_round, form_row, make_room
from eq_model.draws.drawn import births_of, cells_of
from eq_model.draws.streams import LANES, Stream, make_stream
from origins import Contacts

UNIT_BITS, LARGEST_BITS = 28, 40


class Supply(NamedTuple):
    """Contacts of one replica that form, 4 LANES at a time.

    x, r : thresholds and stretches; at : the next of them, and how often they were drawn.
    """

    births: Births
    stream: Stream
    room: Room
    x: npt.NDArray[np.int64]
    r: npt.NDArray[np.int64]
    at: npt.NDArray[np.int64]


class Draws:
    """Supplies of some contacts' replicas; `seed` is from 0 to 2^64 - 1.

    unit : length of which all positions and thresholds are whole numbers: 2^-28 mean thresholds,
    unless 2^40 of these are less than the largest threshold; furthest : the largest stretch (a
    length) at which contacts form.
    """

    def __init__(self, contacts: Contacts, seed: int) -> None:
        self._seed, largest = seed, cells_of(contacts)["thresholds"].largest
        self.unit = max(2.0**-UNIT_BITS * contacts.mean_threshold, 2.0**-LARGEST_BITS * largest)
        self._births = births_of(contacts, self.unit)
        laws = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        self.furthest = min(max(abs(end) for law in laws for end in law.span), largest)

    def of_replica(self, replica: int) -> tuple[Supply, Supply]:
        """At X = 0 and later on, from the first draw on."""
        stream, size = make_stream(self._seed, replica), 4 * LANES
        first, later = (
            Supply(
                births,
                stream,
                make_room(),
                np.empty(size, np.int64),
                np.empty(size, np.int64),
                np.array([size, 0]),
            )
            for births in self._births
        )
        return first, later


@bare
def _refill(s):  # type: ignore[no-untyped-def]
    turn = s.at[1]
    draw_round(np.int64(LANES), turn, s.stream, s.births, s.room)
    for row in range(np.int64(4)):
        x, r = s.x[row * LANES : (row + 1) * LANES], s.r[row * LANES : (row + 1) * LANES]
        form_row(np.int64(LANES), row, turn, s.stream, s.births, s.room, x, r)
    s.at[0], s.at[1] = 0, turn + 1


@inlined
def take(s):  # type: ignore[no-untyped-def]
    """Threshold and stretch of the next contact."""
    if s.at[0] == s.x.size:
        _refill(s)
    s.at[0] += 1
    k = np.uint64(s.at[0] - 1)
    return max(s.x[k], np.int64(1)), s.r[k]
