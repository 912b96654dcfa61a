"""Draws of one law, compiled: 4 LANES of them at a time, and then one by one."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import compiled, inlined
from eq_model.kernel import LANES, MISSING, ROW, _draw, _exact, _find, _more, _values

Whole = npt.NDArray[np.int64]


class Supply(NamedTuple):
    """Draws of one law for one replica, 4 LANES at a time.

    table : quantiles, in whole units; key, second, tail : of the streams; block, lane : counters;
    words, counts, base, cell, place, got : scratch; ready : draws in whole units; at : the next of
    them, and how often they were drawn.
    """

    table: tuple[Any, ...]
    key: tuple[np.uint64, ...]
    second: npt.NDArray[np.uint64]
    tail: np.uint64
    block: npt.NDArray[np.uint32]
    lane: npt.NDArray[np.uint64]
    words: npt.NDArray[np.uint32]
    counts: npt.NDArray[np.uint32]
    base: npt.NDArray[np.uint32]
    cell: npt.NDArray[np.uint32]
    place: npt.NDArray[np.float64]
    got: Whole
    ready: Whole
    at: Whole


def make_supply(
    table: tuple[Any, ...], key: tuple[np.uint64, ...], second: int, tail: int
) -> Supply:
    """Draws of a law with this table, from the stream `second`, and far in the tails `tail` too, of a key."""
    return Supply(
        table=table,
        key=key,
        second=np.full(LANES, second, np.uint64),
        tail=np.uint64(tail),
        block=np.empty(LANES, np.uint32),
        lane=np.arange(LANES, dtype=np.uint64),
        words=np.empty(4 * ROW, np.uint32),
        counts=np.empty(LANES, np.uint32),
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
        _find(LANES, k, s.words, shift, hot, pieces, s.counts, s.base, s.cell, s.place, s.got)
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
