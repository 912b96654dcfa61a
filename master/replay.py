"""Contacts born at any moments, moved along the path up to others."""

import numpy as np
import numpy.typing as npt

from master.timeline import Piece
from master.wear import Wear

Array = npt.NDArray[np.float64]


def replay(
    wear: Wear, course: list[Piece], again: tuple[Array, Array], birth: Array, place: Array, time: Array, end: Array
) -> tuple[Array, Array]:
    """What is left at each `time` (the slider at X = `end`), and its force, of contacts born at `birth` with the slider
    at X = `place`, at the stretches `again` with weights over S(|r|); all of shape birth.shape."""
    stretch, share = again
    nodes = stretch.size
    begun, at, until, goal = (np.repeat(x, nodes) for x in (birth, place, time, end))
    zero = at - np.tile(stretch, birth.size)
    worn = np.tile(wear.fresh(stretch), (birth.size, 1))
    furthest = np.tile(np.abs(stretch), birth.size)
    earliest, latest = float(birth.min(initial=np.inf)), float(time.max(initial=-np.inf))
    for piece in course:
        if piece.end <= earliest or piece.begin >= latest:
            continue
        rows = (begun < piece.end) & (until > piece.begin)
        # an index that takes all rows costs a copy
        some = slice(None) if rows.all() else np.flatnonzero(rows)
        ends = np.where(until[some] > piece.end, piece.after, goal[some])
        lasts = np.minimum(until[some], piece.end) - np.maximum(begun[some], piece.begin)
        part, first, last = worn[some], (at - zero)[some], ends - zero[some]
        wear.advance(part, first, last, furthest[some], lasts)
        worn[some] = part
        furthest[some] = np.maximum(furthest[some], np.abs(last))
        at[some] = ends
    x = at - zero
    left = wear.left(worn, x, furthest)
    shape = (-1, nodes)
    return left.held.reshape(shape) @ share, (left.stiff * x).reshape(shape) @ share
