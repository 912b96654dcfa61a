"""Times at which the number of breaks along a path bends.

It jumps or bends where the speed changes, and wherever contacts born at such a time - of which more, or fewer, are
born than before - come back to the largest |x| of their lives or pass a bend of P_c: there one order smoother. After
each of these the delay brings the same again.
"""

from heapq import heappop, heappush

import numpy as np
import numpy.typing as npt

from master._old.timeline import Piece, ways, where

Array = npt.NDArray[np.float64]

_CLOSE = 1e-9
WIDTH = 1e-10  # of a piece's time, to either side of a jump
_ROUNDING = 4e-16
_MOST = 150


def bends(course: list[Piece], lone: list[float], again: float, limits: Array, delay: float, orders: int) -> Array:
    """Those times but the path's ends, to this many orders of smoothness.

    lone : stretches at which a finite share stands at t = 0
    again : stretch at which contacts are born
    limits : where P_c bends or jumps
    """
    end = course[-1].end
    pending: list[tuple[int, float, float, float]] = []  # order, time, place, largest |x| so far
    found: list[float] = []

    def note(order: int, time: float) -> None:
        if order > orders or time >= end - sliver(course, time) or len(found) > _MOST:
            return
        if any(abs(time - other) <= 10.0 * sliver(course, time) for other in found):
            return
        if time > 0.0:
            found.append(time)
        heappush(pending, (order + 1, time, where(course, time) - again, abs(again)))
        if delay > 0.0:
            note(order + 1, time + delay)

    for x in lone:
        heappush(pending, (0, 0.0, -x, abs(x)))
    for piece in course:
        note(0, piece.begin)
    while pending and len(found) <= _MOST:
        order, since, place, furthest = heappop(pending)
        for time in _passings(course, since, place, furthest, limits):
            note(order, time)
    return np.array(sorted(found))


def sliver(course: list[Piece], time: float) -> float:
    """A time as short as nothing, there."""
    piece = next((piece for piece in course if time <= piece.end), course[-1])
    return WIDTH * piece.duration + _ROUNDING * course[-1].end


def beside(bends: Array, slivers: Array) -> Array:
    """The bends, and both sides of each of the slivers, shape (n, 2)."""
    out = bends
    for begin, end in slivers.tolist():
        near = end - begin
        out = np.append(out[(out < begin - near) | (out > end + near)], [begin, end])
    return np.sort(out)


def _passings(course: list[Piece], since: float, place: float, furthest: float, limits: Array) -> list[float]:
    """When contacts born at a time and place come back to their largest |x|, or first pass one of the limits."""
    out: list[float] = []
    began = True
    for begin, end, first, last, speed in ways(course, since, place):
        goals = [furthest, *limits[limits > furthest * (1.0 + _CLOSE)].tolist()]
        for goal in goals:
            reached = goal * np.sign(speed)
            share = (reached - first) / (last - first)
            if (0.0 if began else -_CLOSE) < share < 1.0:
                out.append(begin + share * (end - begin))
        furthest = max(furthest, abs(first), abs(last))
        began = False
    return out
