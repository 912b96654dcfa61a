"""Sums over breaks up to some X, and their integral over X."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from master.cut_law import SLACK
from master.piecewise import Piecewise, tabulate

Array = npt.NDArray[np.float64]


class Tally:
    """Of breaks with a density and of breaks at exact X, each with a weight, at a stretch each."""

    def __init__(self, table: Piecewise | None, atoms: Array, weights: Array, stretch: Array) -> None:
        order = np.argsort(atoms, kind="stable")
        self._table, self._atoms, self._stretch = table, atoms[order], stretch[order]
        self._met = _met(self._atoms, self._stretch)
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
        met = self._met if wait == 0.0 else _met(self._atoms + wait, self._stretch)
        found = self._sums[np.searchsorted(met, x, side="right")]
        return found if self._table is None else found + self._table.integral(x - wait)

    def twice(self, x: Array) -> Array:
        """Integral of that sum from 0 to x; 0 for x below 0."""
        x = np.maximum(x, 0.0)
        before = self._moments[np.searchsorted(self._met, x, side="right")]
        if self._moment is not None:
            before = before + self._moment.integral(x)
        return x * self.once(x) - before


def _met(atoms: Array, stretch: Array) -> Array:
    """Where contacts have broken that do so at these places in their order, at a stretch each: what x, or the stretch,
    misses by rounding alone is reached."""
    return np.maximum.accumulate(atoms - SLACK * np.maximum(np.abs(atoms), stretch))
