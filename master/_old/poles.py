"""First breaks beside points where P_c diverges, closer than its density can be told for the rounding of x."""

import numpy as np
import numpy.typing as npt

from master._old.law import Law
from master._old.piecewise import Piecewise

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_CLOSE = 1e-8  # of a pole: how close is told from the cdf alone
_MENDED = 1e-3  # how close panels have the weight that the cdf tells


class Poles:
    """One panel to either side of each pole, whose weight the cdf tells; contacts start from one stretch `start`.

    Within a panel they break as the cdf says. All of them release the stretch at the pole, to 1e-8 of what they weigh.
    """

    def __init__(self, law: Law, start: float, survival: float, linked: float) -> None:
        """survival : of contacts at the start; linked : stiffness per length of a threshold, or 0."""
        self._law, self._start, self._survival, self._linked = law, start, survival, linked
        self._poles = law.poles
        self._edges = np.empty(0)  # of the tables, X

    def outside(self, edges: Array) -> Array:
        """The edges without those too close to a pole, but with those of the panels beside it."""
        kept = edges[~self._near(edges, 1.001 * _CLOSE)]
        beside = (self._poles * (1.0 + _CLOSE * np.array([[-1.0], [0.0], [1.0]]))).ravel()
        return np.union1d(kept, beside[(beside >= edges[0]) & (beside <= edges[-1])])

    def among(self, positions: Array) -> Flags:
        """Which positions are poles."""
        return self._near(positions, _CLOSE)

    def beside(self, left: Array, right: Array) -> Flags:
        """Which panels over X are those beside a pole."""
        return self._near(0.5 * (left + right) + self._start, _CLOSE)

    def filled(self, tables: list[Piecewise]) -> list[Piecewise]:
        """The tables of density, release and stiffness with the weight that these panels have."""
        self._edges = edges = tables[0].edges
        middle, width = 0.5 * (edges[:-1] + edges[1:]), np.diff(edges)
        beside, about = self.beside(edges[:-1], edges[1:]), self._near(middle + self._start, _MENDED)
        weight = self._weight(edges[:-1][about], edges[1:][about])
        found = (tables[0].coefficients[0] * width)[about]
        factor = np.divide(weight, found, out=np.ones(found.size), where=found > 0.0)
        at, weight = self._pole(middle[beside]), weight[beside[about]]
        stiffness = at * self._linked if self._linked else 1.0
        filled = []
        lean = self._lean(edges[:-1][beside], edges[1:][beside])
        for table, value in zip(tables, (weight, weight * at * stiffness, weight * stiffness), strict=False):
            coefficients = table.coefficients.copy()
            coefficients[:, about] *= factor
            coefficients[:, beside] = 0.0
            coefficients[0, beside] = value / width[beside]
            coefficients[1, beside] = lean * value / width[beside]
            filled.append(Piecewise(edges, coefficients))
        self._before = np.concatenate([[0.0], np.cumsum(filled[1].coefficients[0] * np.diff(edges))])
        return filled

    def put_right(self, x: Array, released: Array) -> Array:
        """`released` up to positions x, as tables have it, put right beside the poles."""
        near = self._near(x + self._start, _CLOSE) & (x > self._edges[0]) & (x < self._edges[-1])
        if near.any():
            panel = np.searchsorted(self._edges, x[near], side="right") - 1
            at = self._pole(x[near])
            each = at * (at * self._linked if self._linked else 1.0)
            released[near] = self._before[panel] + each * self._weight(self._edges[panel], x[near])
        return released

    def _lean(self, left: Array, right: Array) -> Array:
        """Slope of a density on each panel that has its mean where that of a power of the distance from the pole is."""
        middle = 0.5 * (left + right)
        lower, upper = self._weight(left, middle), self._weight(middle, right)
        near = np.maximum(lower, upper) / np.maximum(lower + upper, 1e-300)
        power = -np.log2(np.clip(near, 0.5, 1.0 - 1e-15))
        return np.asarray(3.0 * (2.0 * power / (1.0 + power) - 1.0) * np.where(upper > lower, -1.0, 1.0))

    def _weight(self, left: Array, right: Array) -> Array:
        return self._law.weight_between(left + self._start, right + self._start) / self._survival

    def _pole(self, x: Array) -> Array:
        """The pole nearest to each break at X = x."""
        return self._poles[np.abs((x + self._start)[:, None] - self._poles).argmin(axis=1)]

    def _near(self, positions: Array, close: float) -> Flags:
        return np.asarray((np.abs(positions[:, None] - self._poles) < close * self._poles).any(axis=1), dtype=bool)
