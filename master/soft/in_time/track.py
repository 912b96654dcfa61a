"""Tracks: smooth stretches of a soft slider's way, and the clock in which its steps are even."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.motion.motion import Motion
from master.soft.in_time.past import lagrange
from origins import Drive

Array = npt.NDArray[np.float64]

# What the way of the drive counts less than that of the slider in a step: it is the slider that must
# be followed.
LESS = 0.25
# Steps, on the coarsest level, in which the time of a hold grows by a factor e.
PER_FOLD = 2.0
# Points of the polynomials that tell force and holding between steps.
STENCIL = 6
BISECTIONS = 60


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
    def duration(self) -> float:
        return self.end - self.begin

    def at(self, now: float) -> float:
        """Where the drive is."""
        return self.before + self.travel / self.duration * (now - self.begin)


def reached(drive: Drive, balance: float) -> Array:
    """When the points of the path are reached, from the balance at t = 0."""
    if drive.time is not None:
        return drive.time
    return np.asarray(np.abs(np.diff(drive.path, prepend=balance)).cumsum() / drive.velocity)


def fastest(drive: Drive) -> float:
    """Largest speed of the drive from the first point of its path on."""
    if drive.time is None or drive.path.size < 2:
        return drive.velocity
    steps = np.diff(drive.time)
    return float((np.abs(np.diff(drive.path))[steps > 0.0] / steps[steps > 0.0]).max(initial=0.0))


def pieces(drive: Drive, balance: float) -> list[Piece]:
    """The drive's way from the balance at t = 0 to the end of its path."""
    times = np.append(0.0, reached(drive, balance))
    motion = Motion(times, np.append(balance, drive.path)) if times[-1] > 0.0 else None
    if motion is None:
        return []
    knots = zip(motion.times, motion.positions, strict=True)
    ends = [(float(time), float(place)) for time, place in knots]
    return [Piece(a[0], b[0], a[1], b[1]) for a, b in pairwise(ends)]


class Read(NamedTuple):
    """Force (lengths) and share that holds, arrays of shape (n,)."""

    force: Array
    holding: Array


@dataclass
class Track:
    """One smooth stretch: step parameter, time, X, force and holding at its nodes."""

    step: list[float] = field(default_factory=list)
    clock: list[float] = field(default_factory=list)
    place: list[float] = field(default_factory=list)
    force: list[float] = field(default_factory=list)
    holding: list[float] = field(default_factory=list)

    def later(self, time: float, way: float) -> Track:
        """The same once more, after a time and a way."""
        clock, place = [at + time for at in self.clock], [at + way for at in self.place]
        return Track(self.step, clock, place, self.force, self.holding)

    def read(self, at: Array) -> Read:
        """Force and holding at times, through the step parameter, in which all is smooth."""
        clock, n = np.array(self.clock), len(self.clock)
        step, told = np.array(self.step), np.array([self.force, self.holding])
        if n == 1:
            return Read(*(np.full(at.size, row[0]) for row in told))
        size = min(STENCIL, n)
        cell = np.clip(np.searchsorted(clock, at, side="left"), 1, n - 1)
        low = np.clip(cell - size // 2, 0, n - size)
        nodes = low[:, None] + np.arange(size)
        a, b = step[cell - 1], step[cell]
        for _ in range(BISECTIONS):
            middle = 0.5 * (a + b)
            early = (lagrange(step[nodes], middle) * clock[nodes]).sum(axis=1) < at
            a, b = np.where(early, middle, a), np.where(early, b, middle)
        weights = lagrange(step[nodes], 0.5 * (a + b))
        return Read(*((weights * row[nodes]).sum(axis=1) for row in told))


class Clock:
    """Even steps in time, or in a hold even in ln(1 + t/first), of one piece of the drive.

    Parameters
    ----------
    piece : Piece
    length : float
        Travel of the drive that takes one step, but for LESS.
    time : float
        The shortest time over which contacts change in a hold.
    rate : float
        Steps per time that contacts ask for while the drive moves.
    """

    def __init__(self, piece: Piece, length: float, time: float, rate: float) -> None:
        self._piece, self._held = piece, piece.travel == 0.0
        if self._held and not np.isfinite(time):
            time = piece.duration
        speed = abs(piece.travel) / piece.duration
        self._first, self._rate = time, LESS * speed / length + rate

    def count(self, time: float) -> float:
        """Steps since the piece began."""
        since = time - self._piece.begin
        return PER_FOLD * float(np.log1p(since / self._first)) if self._held else since * self._rate

    def time(self, count: float) -> float:
        """The time after so many steps."""
        if self._held:
            grown = float(np.expm1(min(count / PER_FOLD, 700.0)))
            return self._piece.begin + self._first * grown
        return self._piece.begin + count / self._rate
