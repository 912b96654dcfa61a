"""Strands of contacts that age towards a normal law without heat: passages that follow the slider."""

import time as clock
from collections.abc import Callable
from copy import copy

import numpy as np

from master.lives.age.passage import Passage
from master.outcome import StoppedError
from origins.thresholds.law import Array

# Moments of a leg at which survivals are told, splines of degree 5 between them: MANY even in the root of the time, and
# in its logarithm from FIRST durations on; and even ones, apart by this share of the narrowest width of the laws.
MANY, FIRST, APART = 200, 1e-10, 0.03


class Passages:
    """Groups of contacts born together, with the methods of master.lives.age.strands.Strands.

    begin : gives the passage of contacts that are born at a stretch
    stretch, share : arrays (parts,), stretches at birth, and weights of sum 1
    width : the narrowest width of the laws (a length)
    until : reading of time.monotonic() after which `follow` raises StoppedError
    spent : share below which a strand is not followed any more
    error : estimate of the largest error of a survival
    """

    def __init__(
        self, begin: Callable[[float], Passage], stretch: Array, share: Array, width: float
    ) -> None:
        """Begin with one strand, right after its birth."""
        self.stretch, self._share, self._width = stretch, share, width
        self._strands = [[begin(float(x)) for x in stretch]]
        self.until, self.spent, self.error = np.inf, 0.0, 0.0

    def aged(self, speed: float, ages: Array) -> "Passages":
        """As Strands.aged."""
        out, parts = copy(self), self._strands[0]
        for part in parts:
            part.move(speed, float(ages.max()))
        both = list(zip(parts, self.stretch, strict=True))
        out._strands = [[part.at(age, x + speed * age) for part, x in both] for age in ages]
        return out

    def follow(self, speed: float, duration: float) -> tuple[Array, Array]:
        """As Strands.follow, to the end of the leg."""
        ways = int(np.ceil(abs(speed) * duration / (APART * self._width))) + 1
        early = np.append(0.0, np.geomspace(FIRST, 1.0, MANY))
        grids = early, np.linspace(0.0, 1.0, MANY) ** 2, np.linspace(0.0, 1.0, ways)
        times, held = duration * np.unique(np.concatenate(grids)), self.left()[0]
        told = np.zeros((times.size, 2, held.size))
        for strand in np.flatnonzero(held > self.spent):
            for part, share in zip(self._strands[strand], self._share, strict=True):
                if clock.monotonic() > self.until:
                    raise StoppedError("stopped by wall_time")
                age, stretch = part.age, part.stretch + speed * times
                part.move(speed, duration)
                holds = share * part.survival(age + times)
                told[:, :, strand] += np.stack([holds, holds * stretch], axis=1)
                self.error = max(self.error, part.error)
        return times, told

    def left(self) -> Array:
        """As Strands.left."""
        left = [
            [(part.left, part.left * part.stretch) for part in parts] for parts in self._strands
        ]
        return np.moveaxis(np.array(left), 2, 0) @ self._share
