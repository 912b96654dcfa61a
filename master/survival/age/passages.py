"""Strands of contacts that age towards a normal law without heat: passages that follow the slider."""

from collections.abc import Callable
from copy import copy

import numpy as np

from master.outcome import stop_after
from master.survival.age.passage import Passage
from master.survival.age.strands import over_root
from origins.thresholds.law import Array

# Moments of a leg at which survivals are computed: MANY even in the root of the time, as many in its logarithm from
# FIRST durations on, and where splines between them are wrong, others in the middle, ADDED times at most.
MANY, FIRST, ADDED = 60, 1e-10, 8


class Passages:
    """Groups of contacts born together, with `aged`, `follow` and `surviving_shares` of
    master.survival.age.strands.Strands.

    begin : gives the passage of contacts that are born at a stretch
    born, share : arrays (parts,), stretches at birth, and weights of sum 1
    accuracy : aimed-at error of splines between moments
    until : reading of time.monotonic() after which `follow` raises StoppedError
    dropped_below : share below which a strand is not followed any more
    error : the largest of a survival so far, and the sum over legs of those of splines
    """

    def __init__(
        self, begin: Callable[[float], Passage], born: Array, share: Array, accuracy: float
    ) -> None:
        """Begin with one strand, right after its birth."""
        self.born, self._share, self._accuracy = born, share, accuracy
        self._strands = [[begin(float(x)) for x in born]]
        self.until, self.dropped_below = np.inf, 0.0
        self.error = self._survivals_error = self._splines_error = 0.0

    def aged(self, speed: float, ages: Array) -> "Passages":
        """As Strands.aged."""
        out, parts = copy(self), self._strands[0]
        for part in parts:
            part.move(speed, float(ages.max()))
        both = list(zip(parts, self.born, strict=True))
        out._strands = [[part.at(age, x + speed * age) for part, x in both] for age in ages]
        return out

    def follow(self, speed: float, duration: float) -> tuple[Array, Array]:
        """As Strands.follow, to the end of the leg; the error of splines between the moments is measured."""
        alive = np.flatnonzero(self.surviving_shares()[0] > self.dropped_below)
        for part in (part for strand in alive for part in self._strands[strand]):
            stop_after(self.until)
            part.move(speed, duration)
            self._survivals_error = max(self._survivals_error, part.error)

        def told(times: Array) -> Array:
            out = np.zeros((times.size, 2, len(self._strands)))
            for strand in alive:
                for part, share in zip(self._strands[strand], self._share, strict=True):
                    holds = share * part.survival(part.age - duration + times)
                    stretch = part.stretch - speed * (duration - times)
                    out[:, :, strand] += np.stack([holds, holds * stretch], axis=1)
            return out

        shares = np.linspace(0.0, 1.0, MANY) ** 2, np.geomspace(FIRST, 1.0, MANY)
        times = duration * np.unique(np.concatenate(shares))
        found = told(times)
        for _ in range(ADDED):
            between = (0.5 * (np.sqrt(times[1:]) + np.sqrt(times[:-1]))) ** 2
            exact = told(between)
            wrong = np.abs(over_root(times, found)(between) - exact)[:, 0].max(axis=1)
            worse = np.flatnonzero(wrong > self._accuracy)
            if not worse.size:
                break
            times = np.insert(times, worse + 1, between[worse])
            found = np.insert(found, worse + 1, exact[worse], axis=0)
        self._splines_error += float(wrong.max())
        self.error = self._survivals_error + self._splines_error
        return times, found

    def surviving_shares(self) -> Array:
        """As Strands.surviving_shares."""
        left = [[(p.left, p.left * p.stretch) for p in parts] for parts in self._strands]
        return np.moveaxis(np.array(left), 2, 0) @ self._share
