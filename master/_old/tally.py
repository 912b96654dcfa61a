"""Sums over breaks up to some X, and their integral over X."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from master._old.piecewise import Piecewise, tabulate

Array = npt.NDArray[np.float64]

_SAME = 1e-13


class Tally:
    """Of breaks with a density and of breaks at exact X, each with a weight, at a stretch each; what x, or the stretch,
    misses by rounding, a share `same` of the larger, is reached."""

    def __init__(
        self, table: Piecewise | None, atoms: Array, weights: Array, stretch: Array, same: float = _SAME
    ) -> None:
        order = np.argsort(atoms, kind="stable")
        self._table, self._atoms, self._stretch = table, atoms[order], stretch[order]
        self._same = same
        self._met = self._reached(self._atoms)
        self._sums = np.concatenate([[0.0], np.cumsum(weights[order])])
        self._moments = np.concatenate([[0.0], np.cumsum(weights[order] * self._atoms)])

    @cached_property
    def _moment(self) -> Piecewise | None:
        table = self._table
        if table is None or table.edges.size < 2:
            return None
        return tabulate(lambda x: (x * table(x))[None], table.edges, np.inf)[0]

    def once(self, x: Array, wait: float = 0.0) -> Array:
        """Sum up to x less a wait; a break right there counts."""
        met = self._met if wait == 0.0 else self._reached(self._atoms + wait)
        found = self._sums[np.searchsorted(met, x, side="right")]
        return found if self._table is None else found + self._table.integral(x - wait)

    def twice(self, x: Array) -> Array:
        """Integral of that sum from 0 to x; 0 for x below 0."""
        x = np.maximum(x, 0.0)
        before = self._moments[np.searchsorted(self._met, x, side="right")]
        if self._moment is not None:
            before = before + self._moment.integral(x)
        return x * self.once(x) - before

    def _reached(self, atoms: Array) -> Array:
        """X from which those are broken that break at these places, in their order."""
        return np.maximum.accumulate(atoms - self._same * np.maximum(np.abs(atoms), self._stretch))
