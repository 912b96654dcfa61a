"""Strands of contacts that age: groups born at one instant each, which follow the slider by their first passages."""

from collections.abc import Callable
from copy import copy

import numpy as np
from scipy.interpolate import make_interp_spline

from master.outcome import stop_after
from master.survival.age.passage import Passage
from origins.thresholds.law import Array

# Instants of a leg at which survivals are computed: MANY even in the root of the time, as many in its logarithm from
# FIRST durations on, and where splines between them are wrong, others in the middle, ADDED times at most.
MANY, FIRST, ADDED = 60, 1e-10, 8
# Degree of splines in time: survivals are smooth, and cubics would need some three times as many instants.
DEGREE = 5


class Passages:
    """Any number of strands: groups of contacts born together, at one or more stretches, the strand's parts.

    begin : gives the passage of contacts that are born at a stretch
    born, weights : arrays (parts,), stretches at birth (lengths), and their weights, of sum 1
    accuracy : aimed-at error of splines between instants
    until : reading of time.monotonic() after which `follow` raises StoppedError
    dropped_below : fraction that holds below which a strand is not followed any more
    error : the largest of a survival so far, and the sum over legs of those of splines
    """

    def __init__(
        self, begin: Callable[[float], Passage], born: Array, weights: Array, accuracy: float
    ) -> None:
        """Begin with one strand, right after its birth."""
        self.born, self._weights, self._accuracy = born, weights, accuracy
        self._strands = [[begin(float(x)) for x in born]]
        self.until, self.dropped_below = np.inf, 0.0
        self.error = self._survivals_error = self._splines_error = 0.0

    def aged(self, speed: float, ages: Array) -> "Passages":
        """Strands like this one, right after its birth, that have moved on at a speed dX/dt for `ages`, shape (n,)."""
        out, parts = copy(self), self._strands[0]
        for part in parts:
            part.move(speed, float(ages.max()))
        both = list(zip(parts, self.born, strict=True))
        out._strands = [[part.at(age, x + speed * age) for part, x in both] for age in ages]
        return out

    def follow(self, speed: float, duration: float) -> tuple[Array, Array]:
        """Move on to the end of a leg, at the speed dX/dt. Returns times since its beginning, shape (n,), and the
        fractions that hold and forces per contact born then, shape (n, 2, strands); the error of splines between these
        times is measured."""
        alive = np.flatnonzero(self.surviving_fractions()[0] > self.dropped_below)
        for part in (part for strand in alive for part in self._strands[strand]):
            stop_after(self.until)
            part.move(speed, duration)
            self._survivals_error = max(self._survivals_error, part.error)

        def at(times: Array) -> Array:
            out = np.zeros((times.size, 2, len(self._strands)))
            for strand in alive:
                for part, weight in zip(self._strands[strand], self._weights, strict=True):
                    holding = weight * part.survival(part.age - duration + times)
                    stretch = part.stretch - speed * (duration - times)
                    out[:, :, strand] += np.stack([holding, holding * stretch], axis=1)
            return out

        places = np.linspace(0.0, 1.0, MANY) ** 2, np.geomspace(FIRST, 1.0, MANY)
        times = duration * np.unique(np.concatenate(places))
        found = at(times)
        for _ in range(ADDED):
            between = (0.5 * (np.sqrt(times[1:]) + np.sqrt(times[:-1]))) ** 2
            exact = at(between)
            wrong = np.abs(over_root(times, found)(between) - exact)[:, 0].max(axis=1)
            worse = np.flatnonzero(wrong > self._accuracy)
            if not worse.size:
                break
            times = np.insert(times, worse + 1, between[worse])
            found = np.insert(found, worse + 1, exact[worse], axis=0)
        self._splines_error += float(wrong.max())
        self.error = self._survivals_error + self._splines_error
        return times, found

    def surviving_fractions(self) -> Array:
        """Fraction of each strand that holds now, and its force per contact born, shape (2, strands)."""
        now = [
            [(part.surviving, part.surviving * part.stretch) for part in parts]
            for parts in self._strands
        ]
        return np.moveaxis(np.array(now), 2, 0) @ self._weights


def over_root(times: Array, values: Array) -> Callable[[Array], Array]:
    """Values at times since a leg's beginning, shape (n, ...), between them as a spline over the root of
    the time, in which survivals are smooth; beyond the last time its values."""
    spline = make_interp_spline(np.sqrt(times), values, k=min(DEGREE, times.size - 1))
    return lambda t: np.asarray(spline(np.sqrt(np.clip(t, 0.0, times[-1]))))
