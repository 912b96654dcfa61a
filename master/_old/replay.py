"""Contacts born at any moments, moved along the path up to others."""

import numpy as np
import numpy.typing as npt

from master._old.timeline import Piece
from master._old.wear import Left, Wear

Array = npt.NDArray[np.float64]


def replay(
    wear: Wear, course: list[Piece], again: tuple[Array, Array], birth: Array, place: Array, time: Array, end: Array
) -> tuple[Array, Array]:
    """What is left at each `time` (the slider at X = `end`), and its force, of contacts born at `birth` with the slider
    at X = `place`, at the stretches `again` with weights over S(|r|); all of shape birth.shape."""
    stretch, share = again
    nodes = stretch.size
    begun, at, until, goal = (np.repeat(x, nodes) for x in (birth, place, time, end))
    worn = np.tile(wear.fresh(stretch), (birth.size, 1))
    left, x = lived(wear, course, worn, np.tile(stretch, birth.size), begun, at, until, goal)
    shape = (-1, nodes)
    return left.held.reshape(shape) @ share, (left.stiff * x).reshape(shape) @ share


def lived(
    wear: Wear, course: list[Piece], worn: Array, stretch: Array, birth: Array, place: Array, time: Array, end: Array
) -> tuple[Left, Array]:
    """What is left of strands, and their stretches, that have `worn` since `birth`, each at a stretch of its own."""
    at, zero, furthest = place.copy(), place - stretch, np.abs(stretch)
    earliest, latest = float(birth.min(initial=np.inf)), float(time.max(initial=-np.inf))
    for piece in course:
        if piece.end <= earliest or piece.begin >= latest:
            continue
        rows = (birth < piece.end) & (time > piece.begin)
        # an index that takes all rows costs a copy
        some = slice(None) if rows.all() else np.flatnonzero(rows)
        ends = np.where(time[some] > piece.end, piece.after, end[some])
        lasts = np.minimum(time[some], piece.end) - np.maximum(birth[some], piece.begin)
        part, first, last = worn[some], (at - zero)[some], ends - zero[some]
        wear.advance(part, first, last, furthest[some], lasts)
        worn[some] = part
        furthest[some] = np.maximum(furthest[some], np.abs(last))
        at[some] = ends
    x = at - zero
    return wear.left(worn, x, furthest), x
