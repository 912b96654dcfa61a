"""First breaks at a temperature of a start with a width: p(x; x_0) of thermal_law for many x_0 at once.

It depends on x_0 through e^{A(x_0; ξ)/v} under the integral over thresholds alone, once x is beyond |x_0| or where no
threshold lies below: a smooth function of x_0. Over a part of the start a few values of x_0 tell it; for each of them p
is tabulated over x, and at the nodes of the start it is a sum of these tables.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.law import Law
from master.piecewise import Bundle, bundle, tabulate
from master.starting import StartSum
from master.thermal_law import MOST_GROWTH, ThermalBreaking
from origins.quadrature import GAUSS_NODES, gauss

Array = npt.NDArray[np.float64]

_X = np.polynomial.legendre.leggauss(16)[0]
_TO_SERIES = np.linalg.inv(np.polynomial.legendre.legvander(_X, 15))
_SIZES = (1, 3, 5, 7, 9, 12, 15)
_RESOLVED = 1e-14
_FREE = 1e-15
_MOST = 40.0  # exponent: beyond, the round-off of a difference of two is felt
_PAIRS = 8_000
_LEAST = 3e-15
_HEAVY = 1e-14
_MOST_PANELS = 96.0
_MOST_PARTS = 8.0


@dataclass(frozen=True)
class Part:
    """Panels `first` up to `last` of the start, no |x_0| in which is above `reach`; `free` where no threshold lies
    below that. `breaks` and, where stiffnesses differ, `stiffness` are p of contacts from each node of these panels."""

    first: int
    last: int
    reach: float
    free: bool
    breaks: Bundle
    stiffness: Bundle | None


class SpreadBreaks:
    """Sums over those panels of `start` that a position X leaves whole; lengths in units of `law`.

    Parameters
    ----------
    breaking : ThermalBreaking
    start : StartSum
    law : Law
        Of relaxed births; the tables begin from its panels.
    marks : array
        Stretches at which p may not be smooth.
    accuracy : float
        Of each panel of a table.

    Attributes
    ----------
    edges : array
        Panels of the start, no wider than those on which p is smooth.
    cuts : array
        Stretches that sums over these must respect: the marks, and what narrower panels of the law there are.
    """

    def __init__(self, breaking: ThermalBreaking, start: StartSum, law: Law, marks: Array, accuracy: float) -> None:
        self._breaking, self._unit, self._accuracy = breaking, law.unit, max(accuracy, _LEAST)
        heavy = np.diff(law.cdf(law.edges)) > _HEAVY
        narrowest = float(np.diff(law.edges)[heavy].min(initial=np.inf))
        width = max(narrowest, (start.high - start.low) / _MOST_PANELS)
        self.cuts = np.unique(np.concatenate([law.inner_edges(0.99 * width), marks]))
        pieces = np.ceil(np.diff(start.edges) / width).astype(int)
        part = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        self.edges = np.append(
            np.repeat(start.edges[:-1], pieces) + part * np.repeat(np.diff(start.edges) / pieces, pieces), start.high
        )
        self._seeds = np.concatenate([[0.0], law.edges[::2], marks])
        self._resolved = max(_RESOLVED, 0.03 * self._accuracy)
        self._widest = (start.high - start.low) / _MOST_PARTS
        self._nodes, weights = gauss(self.edges[:-1], self.edges[1:])
        self._shares = weights * start.weight(self._nodes)
        self._parts: list[Part] = []
        self._split(0, self.edges.size - 1)

    def sums(self, x: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """b_0, dJ_0/dX and the stiffness released at positions x, shape (3, n), of those panels of the start that are
        known; which these are, shape (n, panels)."""
        left, right = self.edges[:-1] + x[:, None], self.edges[1:] + x[:, None]
        whole = self.cuts.searchsorted(right, side="left") <= self.cuts.searchsorted(left, side="right")
        known = np.zeros(whole.shape, dtype=bool)
        out = np.zeros((3, x.size))
        for part in self._parts:
            here = slice(part.first, part.last)
            known[:, here] = whole[:, here] & (part.free | (left[:, here] >= part.reach))
            rows, panels = np.nonzero(known[:, here])
            for i in range(0, rows.size, _PAIRS):
                row, panel = rows[i : i + _PAIRS], panels[i : i + _PAIRS] + part.first
                stretch = x[row, None] + self._nodes[panel]
                node = (panel - part.first)[:, None] * GAUSS_NODES.size + np.arange(GAUSS_NODES.size)
                breaks = self._shares[panel] * part.breaks(node, stretch)
                stiff = breaks if part.stiffness is None else self._shares[panel] * part.stiffness(node, stretch)
                sums = breaks.sum(-1), (stiff * stretch).sum(-1), stiff.sum(-1)
                out += np.stack([np.bincount(row, weights=one, minlength=x.size) for one in sums])
        return out, known

    def _split(self, first: int, last: int) -> None:
        """Parts of the panels `first` up to `last`, halved until a few x_0 tell the rest."""
        inner = self.edges[first + 1 : last]
        low, high = float(self.edges[first]), float(self.edges[last])
        reach = max(-low, high)
        across = self._breaking.bends_at_zero and low < 0.0 < high
        lost = float(self._breaking.law.cdf(reach * self._unit)) * float(self._shares[first:last].sum())
        origins = None
        if not across and (lost < _FREE or high - low < self._widest or not inner.size):
            origins = self._origins(low, high, reach)
        if origins is not None:
            self._tabulate(first, last, origins, reach, lost < _FREE)
        elif inner.size:
            middle = first + 1 + int(np.abs(inner - (0.0 if across else 0.5 * (low + high))).argmin())
            self._split(first, middle)
            self._split(middle, last)

    def _origins(self, low: float, high: float, reach: float) -> Array | None:
        """Few x_0 whose e^{A(x_0; ξ)/v} tell it for all others; None where that takes too many."""
        grown = self._breaking.grown(0.5 * (low + high + (high - low) * _X) * self._unit, reach * self._unit)
        if not grown.size:
            return np.array([0.5 * (low + high)])
        if np.abs(grown).max() > _MOST or np.ptp(grown, axis=0).max() > MOST_GROWTH:
            return None
        size = np.abs(_TO_SERIES @ np.exp(grown)).max(axis=1, initial=0.0)
        for count in _SIZES:
            if size[count:].max() <= self._resolved * size[0]:
                return 0.5 * (low + high - (high - low) * np.cos(np.pi * (np.arange(count) + 0.5) / count))
        return None

    def _tabulate(self, first: int, last: int, origins: Array, reach: float, free: bool) -> None:
        low = float(self.edges[first]) if free else reach
        top = self._breaking.top / self._unit
        if low >= top:
            return
        edges = np.unique(np.clip(np.concatenate([self._seeds, [reach], np.linspace(low, top, 9)]), low, top))

        def rows(x: Array) -> Array:
            fan = self._breaking.fan(x.ravel() * self._unit, origins * self._unit, reach * self._unit)
            return (fan * self._unit).reshape(-1, *x.shape)

        tables = tabulate(rows, edges, self._accuracy)
        at = self._nodes[first:last].ravel()
        bundles = [
            bundle(tables[k : k + origins.size], _shares(origins, at)) for k in range(0, len(tables), origins.size)
        ]
        self._parts.append(Part(first, last, reach, free, bundles[0], bundles[1] if len(bundles) > 1 else None))


def _shares(origins: Array, at: Array) -> Array:
    """Shares of the Chebyshev points `origins` in a polynomial's values at `at`; shape (at, origins)."""
    k = np.arange(origins.size)
    weights = np.where(k % 2, -1.0, 1.0) * np.sin(np.pi * (k + 0.5) / origins.size)
    apart = at[:, None] - origins
    apart[apart == 0.0] = 1e-300
    shares = weights / apart
    return shares / shares.sum(axis=1, keepdims=True)
