"""Sums over breaks up to some X, and their integral over X."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from master.piecewise import Piecewise, tabulate

Array = npt.NDArray[np.float64]

_SAME = 1e-13


class Tally:
    """Of breaks with a density and of breaks at exact X, each with a weight."""

    def __init__(self, table: Piecewise | None, atoms: Array, weights: Array) -> None:
        order = np.argsort(atoms, kind="stable")
        self._table, self._atoms = table, atoms[order]
        self._sums = np.concatenate([[0.0], np.cumsum(weights[order])])
        self._moments = np.concatenate([[0.0], np.cumsum(weights[order] * self._atoms)])

    @cached_property
    def _moment(self) -> Piecewise | None:
        table = self._table
        if table is None or table.edges.size < 2:
            return None
        return tabulate(lambda x: (x * table(x))[None], table.edges, np.inf)[0]

    def once(self, x: Array) -> Array:
        """Sum up to x; a break at x itself counts."""
        found = self._sums[np.searchsorted(self._atoms, x * (1.0 + _SAME), side="right")]
        return found if self._table is None else found + self._table.integral(x)

    def twice(self, x: Array) -> Array:
        """Integral of that sum from 0 to x; 0 for x below 0."""
        x = np.maximum(x, 0.0)
        before = self._moments[np.searchsorted(self._atoms, x * (1.0 + _SAME), side="right")]
        if self._moment is not None:
            before = before + self._moment.integral(x)
        return x * self.once(x) - before
