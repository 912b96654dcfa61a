"""The straight pieces of a path that turns round."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Move:
    """One straight piece of the path: where it begins, its direction, its travel, and the path's points on it."""

    turn: float
    direction: int
    travel: float
    points: slice


def moves(path: Array) -> list[Move]:
    """The straight pieces of a path that begins at X = 0; a turning point belongs to the piece that ends there."""
    step = np.diff(path, prepend=0.0)
    sign = np.sign(step).astype(int)
    moving = np.flatnonzero(sign)
    if not moving.size:
        return [Move(0.0, 1, 0.0, slice(0, path.size))]
    turns = moving[1:][np.diff(sign[moving]) != 0]
    begins = np.concatenate([[0], turns])
    ends = np.append(turns, path.size)
    out, at = [], 0.0
    for begin, end in zip(begins, ends, strict=True):
        direction = int(sign[moving[np.searchsorted(moving, begin)]])
        travel = abs(float(path[end - 1]) - at)
        out.append(Move(at, direction, travel, slice(int(begin), int(end))))
        at = float(path[end - 1])
    return out
