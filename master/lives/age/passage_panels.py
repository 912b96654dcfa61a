"""Panels of the first passage's march: Legendre series in s, the root of the way gone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Nodes of a panel: with sixteen the last Legendre coefficients reach round-off on panels as wide as
# a standard deviation of what breaks.
NODES = 16
X = legendre.leggauss(NODES)[0]
SHARE = 0.5 * (X + 1.0)
SERIES = legendre.legvander(X, NODES - 1)
# Nodes and weights on (0, 1) of the integral over earlier breaks, between two of its cuts.
INNER, INNER_WEIGHTS = (0.5 * (legendre.leggauss(12)[k] + (1 - k)) for k in (0, 1))
# Halvings of the integral's cuts towards its upper end: from D/v up to any length.
DOUBLINGS = 40


class Cuts(NamedTuple):
    """Nodes σ of integrals over 0 < σ < top, one row for each part between two cuts.

    row : array (n,), which of the integrals; node, below = top - σ and weight : arrays (n, 12)
    """

    row: Rows
    node: Array
    below: Array
    weight: Array


def cuts_towards(top: Array, edges: Array, scale: Array, finest: float) -> Cuts:
    """Nodes for integrals up to each `top`, cut at the panels' edges and ever finer towards it.

    top, scale : arrays (n,); in s the finest part is finest/(2 scale) long
    edges : array (m,), ends of panels in s

    Nodes are even in (top - σ)^(1/2), in which what is singular there is smooth.
    """
    first = np.sqrt(np.minimum(finest / (2.0 * scale), top))
    steps = first[:, None] * 2.0 ** np.arange(DOUBLINGS)
    cut = np.maximum(top[:, None] - steps * steps, 0.0)
    cut = cut[:, : int((cut > 0.0).any(axis=0).sum()) + 1]
    fixed = np.minimum(np.broadcast_to(edges, (top.size, edges.size)), top[:, None])
    ends = np.sort(np.concatenate([fixed, cut, top[:, None]], axis=1), axis=1)
    row, column = np.nonzero(ends[:, 1:] > ends[:, :-1])
    far = np.sqrt(top[row] - ends[row, column])
    near = np.sqrt(np.maximum(top[row] - ends[row, column + 1], 0.0))
    root = near[:, None] + (far - near)[:, None] * INNER
    weight = (far - near)[:, None] * INNER_WEIGHTS * 2.0 * root
    return Cuts(row, top[row, None] - root * root, root * root, weight)


class Phase:
    """A part of the way on which the level moves by `sign` per unit from `level`, and its panels.

    edges are those of the panels in s, the root of the way since `begin`; series the Legendre
    coefficients of 2 s g on each.
    """

    def __init__(self, begin: float, level: float, sign: float) -> None:
        self.begin, self.level, self.sign = begin, level, sign
        self.edges: list[float] = [0.0]
        self.series: list[Array] = []

    @property
    def broken(self) -> float:
        """Share of contacts that break in the phase: the first coefficient is a panel's mean."""
        return float(np.diff(self.edges) @ np.array([series[0] for series in self.series]))

    def add(self, right: float, series: Array) -> None:
        """One more panel, up to s = right."""
        self.edges.append(right)
        self.series.append(series)

    def value(self, s: Array) -> Array:
        """2 s g at points of finished panels; each row lies on one panel."""
        panel = np.searchsorted(self.edges, s[:, :1], side="right") - 1
        return self._read(np.array(self.series).T, panel.clip(0, len(self.series) - 1), s)

    def density_at_end(self) -> tuple[float, float]:
        """g and dg/dt at the end of the last panel."""
        s, width, series = self.edges[-1], self.edges[-1] - self.edges[-2], self.series[-1]
        value = float(legendre.legval(1.0, series))
        slope = float(legendre.legval(1.0, legendre.legder(series))) * 2.0 / width
        change = (slope / (2.0 * s) - value / (2.0 * s * s)) / (2.0 * s)
        return value / (2.0 * s), change

    def finish(self, after: float, scale: float) -> float:
        """Survival at the beginning of the phase, where it is `after` at its end and the breaks
        are to be multiplied by `scale`."""
        width, series = np.diff(self.edges), np.array(self.series).T * scale
        breaks = width * series[0]
        self._after = after + np.append(np.cumsum(breaks[::-1])[::-1], 0.0)[1:]
        self._breaks = legendre.legint(series, lbnd=1.0) * (-0.5 * width)
        return after + float(breaks.sum())

    def survival(self, s: Array) -> Array:
        """E at s of any shape; at the end of the phase beyond it."""
        s = np.minimum(s, self.edges[-1])
        panel = np.searchsorted(self.edges, s, side="right") - 1
        panel = panel.clip(0, len(self.series) - 1)
        return self._after[panel] + self._read(self._breaks, panel, s)

    def _read(self, series: Array, panel: Rows, s: Array) -> Array:
        edges = np.array(self.edges)
        left, right = edges[panel], edges[panel + 1]
        at = (2.0 * s - left - right) / (right - left)
        columns = np.broadcast_to(series[:, panel], (series.shape[0], *s.shape))
        return np.asarray(legendre.legval(at, columns, tensor=False), dtype=float)


class CutPanel(NamedTuple):
    right: float
    series: Array


def cut_panel(left: float, right: float, series: Array, weight: float) -> CutPanel:
    """The panel up to where its integral from the left reaches `weight`."""
    integral = legendre.legint(series, lbnd=-1.0) * 0.5 * (right - left)
    low, high = -1.0, 1.0
    for _ in range(60):
        x = 0.5 * (low + high)
        low, high = (x, high) if legendre.legval(x, integral) < weight else (low, x)
    values = legendre.legval(-1.0 + (high + 1.0) * SHARE, series)
    found = np.asarray(np.linalg.solve(SERIES, values), dtype=float)
    return CutPanel(left + 0.5 * (right - left) * (high + 1.0), found)
