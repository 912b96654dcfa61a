"""The drive's straight pieces, at one speed each."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.motion.motion import Motion
from origins import Drive

Array = npt.NDArray[np.float64]


class Piece(NamedTuple):
    """The drive moves at one speed, or holds, from a time and a place to others."""

    begin: float
    end: float
    before: float
    after: float

    @property
    def travel(self) -> float:
        return self.after - self.before

    @property
    def speed(self) -> float:
        """|dX_T/dt|."""
        return abs(self.travel) / (self.end - self.begin)

    def at(self, now: float) -> float:
        """X_T at a time."""
        return self.before + self.travel / (self.end - self.begin) * (now - self.begin)


def reached(drive: Drive, balance: float) -> Array:
    """Times at which the points of the path are reached, from the balance at t = 0."""
    if drive.time is not None:
        return drive.time
    return np.asarray(np.abs(np.diff(drive.path, prepend=balance)).cumsum() / drive.velocity)


def pieces(drive: Drive, balance: float) -> list[Piece]:
    """The drive's straight pieces from the balance at t = 0 to the end of its path."""
    times = np.append(0.0, reached(drive, balance))
    motion = Motion(times, np.append(balance, drive.path)) if times[-1] > 0.0 else None
    if motion is None:
        return []
    knots = zip(motion.times, motion.positions, strict=True)
    ends = [(float(time), float(place)) for time, place in knots]
    return [Piece(a[0], b[0], a[1], b[1]) for a, b in pairwise(ends)]
