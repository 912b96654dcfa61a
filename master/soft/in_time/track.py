"""Tracks: the drive's straight pieces, the clock in which steps are uniform, and the steps' results."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline
from scipy.optimize.elementwise import find_root
from scipy.special import wrightomega

from master.motion.motion import Motion
from origins import Drive

Array = npt.NDArray[np.float64]

# Steps, on the coarsest level, in which the time since a bend grows by a factor e: while the drive
# holds; and while it moves, in addition to the steps of its travel.
PER_FOLD_HELD, PER_FOLD = 2.0, 0.4


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


class Clock:
    """Count of steps: uniform in time, and after a bend, where changes slow down, in its logarithm.

    Parameters
    ----------
    begin, end : float
        Times of two consecutive bends.
    held : bool
        Whether the drive holds.
    rate : float
        Uniform steps per time.
    first : float
        The shortest time over which contacts change after a bend; inf where nothing changes then.
    """

    def __init__(self, begin: float, end: float, held: bool, rate: float, first: float) -> None:
        self._begin, self._rate = begin, rate
        lasts = end - begin
        self._first = min(first, lasts)
        per_fold = PER_FOLD_HELD if held else PER_FOLD
        self._folds = per_fold if held or first < lasts else 0.0

    def count(self, time: float) -> float:
        """Steps since the beginning."""
        since = time - self._begin
        folds = float(np.log1p(since / self._first)) if self._folds else 0.0
        return self._rate * since + self._folds * folds

    def time(self, count: float) -> float:
        """The time after so many steps."""
        if not self._folds:
            return self._begin + count / self._rate
        folds, even = count / self._folds, self._rate * self._first / self._folds
        if not even:
            return self._begin + self._first * float(np.expm1(min(folds, 700.0)))
        # even u + log(1 + u) = folds
        grown = float(wrightomega(folds + even + np.log(even)).real) / even
        return self._begin + self._first * (grown - 1.0)


class Node(NamedTuple):
    """The end of a step: the size of all steps so far of its smooth section, time, force and holding."""

    step: float
    clock: float
    force: float
    holding: float


def read(tracks: list[list[Node]], asked: Array) -> Array:
    """Force (lengths) and holding share at times (n,), shape (2, n); at a slip, after it.

    By splines in the size of all steps, in which the time, too, is smooth.
    """
    ends = np.array([track[-1].clock for track in tracks])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(tracks) - 1)
    out = np.empty((2, asked.size))
    for k in np.unique(which):
        at, nodes = asked[which == k], np.array(tracks[k])
        nodes = nodes[np.unique(nodes[:, 0], return_index=True)[1]]
        step, clock = nodes[:, 0], nodes[:, 1]
        if step.size == 1:
            out[:, which == k] = nodes[0, 2:, None]
            continue
        # splines are best at odd degrees
        values = make_interp_spline(step, nodes[:, 1:], k=min(5, 2 * ((step.size - 2) // 2) + 1))
        cell = np.clip(np.searchsorted(clock, at, side="left"), 1, step.size - 1)
        found = find_root(
            lambda x, time, values=values: values(x)[..., 0] - time,
            (step[cell - 1], step[cell]),
            args=(np.clip(at, clock[cell - 1], clock[cell]),),
        )
        out[:, which == k] = values(found.x)[:, 1:].T
    return out
