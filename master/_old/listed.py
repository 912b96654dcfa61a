"""Thresholds of exact values alone, starts spread: every birth repeats an earlier one, shifted by sums of the values.

With thresholds a_j of weight p_j and first breaks f, births are b(y) = sum over k of w_k f(y - s_k), s_k the sums of
thresholds up to y and w_k how likely each is reached. Nothing is smeared, however sharp f is.
"""

import numpy as np
import numpy.typing as npt

from master._old.atomic import AtomicChain
from master._old.first import FirstBreaks
from master._old.law import Law

Array = npt.NDArray[np.float64]

_CHUNK = 200_000


class ListedLater:
    """Breaks of the second and later generations up to y = `end`, for a law of exact values alone.

    Attributes
    ----------
    sums, weights : arrays of shape (n,)
        The sums s_k, 0 among them, and how many of the births at 0 are born again there.
    """

    def __init__(self, law: Law, first: FirstBreaks, chain: AtomicChain, end: float) -> None:
        self._law, self._first, self._chain = law, first, chain
        unit = AtomicChain(law, np.zeros(1), np.ones(1), end)
        self.sums, self.weights = unit.births, unit.weights

    def __call__(self, y: Array) -> Array:
        """Stretch released up to travels y by all but first breaks, single births included."""
        atoms, weights = self._law.atoms, self._law.atom_weights * self._law.atoms
        total = self._chain.released(y)
        for atom, weight in zip(atoms, weights, strict=True):
            total = total + weight * self._shifted(self._first.density.integral, y - atom, self.sums, self.weights)
        return total

    def rate(self, y: Array) -> Array:
        """Slope of the same, single births left out."""
        total = np.zeros(y.size)
        for atom, weight in zip(self._law.atoms, self._law.atom_weights * self._law.atoms, strict=True):
            total += weight * self._shifted(self._first.density, y - atom, self.sums, self.weights)
        return total

    def births(self, y: Array) -> Array:
        """b - f at travels y."""
        return self._shifted(self._first.density, y, self.sums[1:], self.weights[1:])

    def edges(self, end: float) -> Array:
        """Edges of panels up to `end` on each of which b is one polynomial."""
        edges = (self._first.density.edges + self.sums[:, None]).ravel()
        return edges[(edges > 0.0) & (edges < end)]

    @staticmethod
    def _shifted(function, y: Array, sums: Array, weights: Array) -> Array:  # type: ignore[no-untyped-def]
        out = np.zeros(y.size)
        if not sums.size:
            return out
        rows = max(1, _CHUNK // sums.size)
        for begin in range(0, y.size, rows):
            part = y[begin : begin + rows]
            out[begin : begin + rows] = function((part[:, None] - sums).ravel()).reshape(-1, sums.size) @ weights
        return out
