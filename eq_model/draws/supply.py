"""A replica's supply of contacts that form, one after the other: drawn in rows, taken one by one."""

from typing import NamedTuple

import numpy as np

from eq_model.blocks import Whole
from eq_model.compiling import bare, inlined
from eq_model.draws.births import (
    DrawnBirths,
    Scratch,
    draw_stretches,
    draw_thresholds,
    make_scratch,
)
from eq_model.draws.streams import LANES, Stream


class Supply(NamedTuple):
    """Draws the contacts of one replica that form, 4 LANES at a time."""

    births: DrawnBirths
    stream: Stream
    scratch: Scratch
    ready: Whole  # (2, 4, LANES): thresholds and stretches
    at: Whole  # index of the next contact, and the number of draws so far
    mean: float  # threshold at which k_i = <k>; 0 if all k_i are equal


def make_supply(births: DrawnBirths, stream: Stream, mean: float = 0.0) -> Supply:
    """The supply before its first draw."""
    ready, at = np.empty((2, 4, LANES), np.int64), np.array([4 * LANES, 0])
    return Supply(births, stream, make_scratch(), ready, at, mean)


@bare
def _refill(s):  # type: ignore[no-untyped-def]
    turn, n = s.at[1], np.int64(LANES)
    for row in range(np.int64(4)):
        x, r = s.ready[0, row], s.ready[1, row]
        draw_stretches(n, row, turn, s.stream, s.births, s.scratch, r)
        draw_thresholds(n, row, turn, s.stream, s.births, s.scratch, r, x)
    s.at[0], s.at[1] = 0, turn + 1


@inlined
def take(s):  # type: ignore[no-untyped-def]
    """Threshold and stretch of the next contact."""
    if s.at[0] == 4 * LANES:
        _refill(s)
    s.at[0] += 1
    k, lanes = np.uint64(s.at[0] - 1), np.uint64(LANES)
    return max(s.ready[0, k // lanes, k % lanes], np.int64(1)), s.ready[1, k // lanes, k % lanes]
