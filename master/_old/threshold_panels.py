"""Sums over the thresholds above a stretch: nodes that all stretches share, and some beside each stretch of its own."""

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from master._old.weights import NodeWeights
from origins import Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

_TAIL = 1e-30
_HEAVY = 1e-13
_FURTHEST = 1e40  # means: its cube is still a number
_FINE = 20  # nodes of a panel over the root of the distance
_X, _W = np.polynomial.legendre.leggauss(_FINE)
_X, _W = 0.5 * (_X + 1.0), 0.5 * _W
_RUNG, _MOST_PARTS = 2.6, 12
_DISTANCE = 1.0  # from a root, in widths of a panel whose eight nodes do not feel it


class ThresholdPanels:
    """The continuous part of a law of thresholds in panels that eight nodes see through.

    Parameters
    ----------
    law : Thresholds
    rooted : bool
        Whether what is summed is a series in (ξ - least)^(1/2) rather than in ξ.
    barrier : callable
        Of a relaxed contact in units of k_BT, at thresholds of shape (n,).
    heavy : float
        Weight from which a panel is cut where the barrier rises on it.

    Attributes
    ----------
    edges : array of shape (n + 1,)
    nodes, mass : array of shape (8 n,)
        Thresholds and their weights.
    heavy : array of bool, shape (n,)
    even : bool
        Whether on none of these the barrier rises by many k_BT.
    top : float
        Beyond it no thresholds matter.
    """

    def __init__(
        self, law: Thresholds, rooted: bool, barrier: Callable[[Array], Array], heavy: float = _HEAVY
    ) -> None:
        self._weights, self._rooted = NodeWeights(law), rooted
        lower, upper = law.support()
        far = upper if np.isfinite(upper) else min(float(law.isf(1e-300)), _FURTHEST * law.mean())
        continuous = float(law.atoms[1].sum()) < 1.0 - 1e-14
        inner = panel_edges(law, tail=_TAIL) if continuous else np.empty(0)
        edges = np.unique(np.concatenate([[lower], inner, [min(far, upper)]]))
        parts = np.minimum(np.ceil(np.diff(barrier(edges)) / _RUNG), _MOST_PARTS + 1).astype(int)
        # where that takes many, stretches need panels of their own anyway
        much = np.abs(np.diff(law.cdf(edges))) > heavy
        self.even = not (much & (parts > _MOST_PARTS)).any()
        self.edges = _cut(edges, np.where(much & (parts <= _MOST_PARTS), np.maximum(parts, 1), 1))
        self.top = float(self.edges[-1])
        self.heavy = np.abs(np.diff(law.cdf(self.edges))) > heavy
        nodes, weights = gauss(self.edges[:-1], self.edges[1:])
        mass = self._weights(nodes, weights, self.edges[:-1], self.edges[1:])
        self.nodes, self.mass = nodes.ravel(), mass.ravel()
        self._width = np.diff(self.edges)

    def rows_in(self, many: int) -> int:
        """How many stretches have about so many nodes together."""
        return max(1, many // (self.nodes.size + 32))

    def above(self, least: Array) -> Iterator[tuple[Rows, Array, Array]]:
        """Thresholds above `least` for each of n stretches: rows they are for, weights and thresholds, both of shape
        (rows, k), or (1, k) where all these rows share them."""
        if not self._width.size:
            return
        apart = self.edges[:-1] - least[:, None]
        beside = apart < (_DISTANCE * self._width if self._rooted else 0.0)
        first = np.where(beside.any(axis=1), self._width.size - beside[:, ::-1].argmax(axis=1), 0)
        for begin in np.unique(first):
            if begin < self._width.size:
                shared = slice(8 * begin, None)
                yield np.flatnonzero(first == begin), self.mass[None, shared], self.nodes[None, shared]
        own = np.flatnonzero(first)
        edges = np.clip(self.edges, least[own, None], self.edges[first[own], None])
        if self._rooted:  # what is left of a panel and the next are one
            cut = np.searchsorted(self.edges, least[own], side="right")
            whole = np.flatnonzero((cut > 0) & (cut < first[own]))
            edges[whole, cut[whole]] = least[own[whole]]
        yield from self.between(own, edges, least[own])

    def between(self, rows: Rows, edges: Array, least: Array) -> Iterator[tuple[Rows, Array, Array]]:
        """The same on panels between `edges`, one row of them for each of `rows`, none from below `least`."""
        left, right = edges[:, :-1], edges[:, 1:]
        wide = right > left
        near = left - least[:, None] < _DISTANCE * (right - left) if self._rooted else np.zeros_like(wide)
        row, panel = np.nonzero(wide & ~near)
        if row.size:
            ends = left[row, panel], right[row, panel]
            nodes, weights = gauss(*ends)
            yield rows[row], self._weights(nodes, weights, *ends), nodes
        row, panel = np.nonzero(wide & near)
        if row.size:
            ends = left[row, panel], right[row, panel]
            begin, end = (np.sqrt(side - least[row])[:, None] for side in ends)
            roots = begin + (end - begin) * _X
            nodes = least[row, None] + roots * roots
            yield rows[row], self._weights(nodes, (2.0 * (end - begin) * _W) * roots, *ends), nodes


def _cut(edges: Array, parts: npt.NDArray[np.int_]) -> Array:
    """Edges of panels each cut in so many equal ones."""
    part = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(np.repeat(edges[:-1], parts) + part * np.repeat(np.diff(edges) / parts, parts), edges[-1:])
