"""What is written down of a soft slider's way: smooth stretches, slips, and the clock in which steps are even."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from master._old.timeline import Piece

LESS = 0.25  # that the drive goes on counts the less for a step: it is the slider that must be followed
_PER_FOLD = 2.0


class TooLong(Exception):
    """More steps than memory and time allow."""


@dataclass
class Slip:
    """Lengths, as in master.soft.Slips."""

    drive: float
    before: float
    after: float
    force_before: float
    force_after: float


@dataclass
class Track:
    """One smooth stretch: step parameter, time, X, force and holding at its nodes."""

    step: list[float] = field(default_factory=list)
    clock: list[float] = field(default_factory=list)
    place: list[float] = field(default_factory=list)
    force: list[float] = field(default_factory=list)
    holding: list[float] = field(default_factory=list)

    def later(self, time: float, way: float) -> Track:
        """The same once more."""
        clock, place = [at + time for at in self.clock], [at + way for at in self.place]
        return Track(self.step, clock, place, self.force, self.holding)


class Clock:
    """Even steps in time, or in a hold even in ln(1 + t/first), of one piece of the drive."""

    def __init__(self, piece: Piece, length: float, time: float, rate: float) -> None:
        self._piece, self._held = piece, piece.travel == 0.0
        speed = abs(piece.travel) / piece.duration
        if self._held and not np.isfinite(time):
            time = piece.duration
        self._first, self._rate = time, LESS * speed / length + rate

    def count(self, time: float) -> float:
        since = time - self._piece.begin
        return _PER_FOLD * float(np.log1p(since / self._first)) if self._held else since * self._rate

    def time(self, count: float) -> float:
        if self._held:
            return self._piece.begin + self._first * float(np.expm1(min(count / _PER_FOLD, 700.0)))
        return self._piece.begin + count / self._rate
