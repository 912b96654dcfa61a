"""Panels in the threshold x_s: those of a law, and those between which a contact's sum is cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.laws.rate_law import RateLaw
from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import finite_density, panel_edges

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Stiffness = Callable[[Array], Array]

# Gauss nodes of a panel, on (0, 1): e^-A falls through 1 on two to four panels of 16
_Z, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_X: Array = 0.5 * (_Z + 1.0)
_W: Array = 0.5 * _WEIGHTS
# and 12, which tell where 16 are more than enough for the law itself
_Z, _WEIGHTS = np.polynomial.legendre.leggauss(12)
_FEWER_X: Array = 0.5 * (_Z + 1.0)
_FEWER_W: Array = 0.5 * _WEIGHTS

_TAIL = 1e-30  # survival beyond which thresholds are not summed
SMALLEST = 1e-100  # a length: no rate is defined at a threshold of 0


class Panels(NamedTuple):
    """Panels in x_s, each for one contact.

    row : array of int, shape (n,), the contact
    low, high : arrays of shape (n,), the ends
    first, last : arrays of shape (n,), ln A at the ends
    """

    row: Rows
    low: Array
    high: Array
    first: Array
    last: Array

    def pick(self, which: npt.NDArray[np.bool_] | Rows | slice) -> Panels:
        """Some of the panels."""
        return Panels(
            self.row[which], self.low[which], self.high[which], self.first[which], self.last[which]
        )

    def cut(self, at: Array, level: Array) -> Panels:
        """Each panel cut in two, where ln A is `level`."""
        left = self._replace(high=at, last=level)
        return joined([left, self._replace(low=at, first=level)])


def joined(parts: list[Panels]) -> Panels:
    """All panels of several sets."""
    return Panels(
        np.concatenate([part.row for part in parts]),
        np.concatenate([part.low for part in parts]),
        np.concatenate([part.high for part in parts]),
        np.concatenate([part.first for part in parts]),
        np.concatenate([part.last for part in parts]),
    )


def nodes(law: Thresholds, panels: Panels, base: Array | None) -> tuple[Array, Array]:
    """Thresholds on each panel and their weights by P_c; both of shape (n, 16).

    base : array of shape (n,), where what is summed is a series in (x_s - base)^(1/2); else None
    """
    low, width = panels.low[:, None], (panels.high - panels.low)[:, None]
    if base is None:
        xi, weight = low + width * _X, width * _W
    else:
        base = base[:, None]
        near = np.sqrt(low - base)
        across = width / (np.sqrt(low - base + width) + near)  # of the roots, no cancellation
        root = near + across * _X
        xi, weight = base + root * root, 2.0 * across * root * _W
    return xi, weight * finite_density(law, xi)


def law_edges(law: Thresholds) -> Array:
    """Edges of panels on which 16 nodes sum P_c and x_s P_c; none where there are atoms alone.

    They are those of origins.quadrature, which are for 8 nodes, but for those that 12 do not need;
    breakpoints of the law stay.
    """
    if float(law.atoms[1].sum()) > 1.0 - 1e-14:
        return np.empty(0)
    edges = np.maximum(panel_edges(law, tail=_TAIL), SMALLEST)
    kept = np.isin(edges, np.maximum(law.breakpoints, SMALLEST))
    kept[[0, -1]] = True
    for first in (1, 2, 1, 2):
        if edges.size < 4:
            break
        middle = np.arange(first, edges.size - 1, 2)
        low, at, high = edges[middle - 1], edges[middle], edges[middle + 1]
        change = np.zeros(middle.size)
        for power in (0, 1):
            whole, left, right = (
                _weight(law, *ends, power) for ends in ((low, high), (low, at), (at, high))
            )
            change = np.maximum(change, np.abs(whole - left - right))
        gone = middle[(change < 1e-15) & ~kept[middle]]
        edges, kept = np.delete(edges, gone), np.delete(kept, gone)
    return edges


def _weight(law: Thresholds, low: Array, high: Array, power: int) -> Array:
    """Weight of P_c between ends by 12 nodes; for power 1, times x_s over the upper end."""
    width = (high - low)[:, None]
    xi = low[:, None] + width * _FEWER_X
    return (_FEWER_W * width * finite_density(law, xi) * (xi / high[:, None]) ** power).sum(axis=1)


def fastest_thresholds(rates: RateLaw, stiffness: Stiffness | None, x: Array) -> Array:
    """The threshold of the contacts that break fastest at each stretch x >= 0; same shape.

    To some 10 % of x_s - x: the first edge of a panel need not lie better.
    """
    steps = np.geomspace(1e-10, 1e10, 201)
    xi = np.maximum(x, SMALLEST)[:, None] * (1.0 + steps)
    rate = rates.log_rate(x[:, None], xi, 1.0 if stiffness is None else stiffness(xi))
    return xi[np.arange(x.size), rate.argmax(axis=1)]
