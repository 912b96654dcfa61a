"""First breaks at a temperature of a start with a width: p(x; x_0) of thermal_law for many x_0 at once.

It depends on x_0 through e^{A(x_0; ξ)/v} under the integral over thresholds alone, once x is beyond |x_0| or where no
threshold lies below: a smooth function of x_0. Over a part of the start a few values of x_0 tell it; for each of them p
is tabulated over x, and at the nodes of the start it is a sum of these tables.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from master._old.law import Law
from master._old.piecewise import Bundle, bundle, tabulate
from master._old.starting import StartSum
from master._old.thermal_law import MOST_GROWTH, MOST_SPENT, ThermalBreaking
from master._old.thermal_paper import PaperBreaking
from origins.thresholds.quadrature import GAUSS_NODES, gauss

Array = npt.NDArray[np.float64]

_X = np.polynomial.legendre.leggauss(16)[0]
_TO_SERIES = np.linalg.inv(np.polynomial.legendre.legvander(_X, 15))
_SIZES = (1, 3, 5, 7, 9, 12, 15)
_RESOLVED = 1e-15
_UNFELT = 1e-19
_SAME = 1e-14
_NOTHING = 1e-20
_MOST_PARTS = 16.0  # of a start among whose stretches thresholds lie
_FREE = 1e-15
_PAIRS = 1_000
_LEAST = 3e-15
_FEW = 0.01
_MOST_PANELS = 96.0


@dataclass
class Part:
    """Panels `first` up to `last` of the start, told by the stretches x_0 = `origins`: from the stretch `begin` on,
    with thresholds above `least`. `share` is the weight of these panels in the start.

    `told` are p and, where stiffnesses differ, the same with these, of contacts from each of the origins; `mixed` from
    each node of the panels, one for all where there is one origin; `felt` the stretches between which these break."""

    first: int
    last: int
    begin: float
    least: float
    origins: Array
    share: float
    told: list[Bundle] = field(default_factory=list)
    mixed: list[Bundle] = field(default_factory=list)
    felt: tuple[float, float] = (-np.inf, np.inf)


class SpreadBreaks:
    """Sums over those panels of `start` that a position X leaves whole; lengths in units of `law`.

    Parameters
    ----------
    breaking : ThermalBreaking or PaperBreaking
    start : StartSum
    law : Law
        Of relaxed births; the tables begin from its panels.
    marks : array
        Stretches at which p may not be smooth.
    accuracy : float
        Of each panel of a table.
    end : float
        The furthest position asked for.

    Attributes
    ----------
    edges : array
        Panels of the start, no wider than those on which p is smooth.
    untold : array of bool
        Which panels no table tells.
    cuts : array
        Stretches that sums over these must respect: the marks, and what narrower panels of the law there are.
    """

    def __init__(
        self,
        breaking: ThermalBreaking | PaperBreaking,
        start: StartSum,
        law: Law,
        marks: Array,
        accuracy: float,
        end: float,
    ) -> None:
        self._breaking, self._unit, self._accuracy = breaking, law.unit, max(accuracy, _LEAST)
        # narrower panels are cut out of sums where they come: such as those beside 0, which few starts pass
        weight, across = np.diff(law.cdf(law.edges)), np.diff(law.edges)
        order = across.argsort()
        enough = int(np.searchsorted(weight[order].cumsum(), _FEW))
        narrowest = float(across[order][enough]) if enough < across.size else float(across.max(initial=start.widest))
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
        self._top = min(breaking.top / law.unit, end + start.high)
        self._parts: list[Part] = []
        self._split(0, self.edges.size - 1)
        self.untold = np.ones(self.edges.size - 1, dtype=bool)
        for part in self._parts:
            self.untold[part.first : part.last] = False
        if self._parts:
            self._tabulate()

    def sums(self, x: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """b_0, dJ_0/dX and the stiffness released at positions x, shape (3, n), of those panels of the start that are
        known; which these are, shape (n, panels)."""
        left, right = self.edges[:-1] + x[:, None], self.edges[1:] + x[:, None]
        whole = self.cuts.searchsorted(right, side="left") <= self.cuts.searchsorted(left, side="right")
        known = np.zeros(whole.shape, dtype=bool)
        out = np.zeros((3, x.size))
        for part in self._parts:
            here = slice(part.first, part.last)
            known[:, here] = whole[:, here] & (left[:, here] >= part.begin)
            felt = known[:, here] & (left[:, here] < part.felt[1]) & (right[:, here] > part.felt[0])
            rows, panels = np.nonzero(felt)
            for i in range(0, rows.size, _PAIRS):
                row, panel = rows[i : i + _PAIRS], panels[i : i + _PAIRS] + part.first
                stretch = x[row, None] + self._nodes[panel]
                node = (panel - part.first)[:, None] * GAUSS_NODES.size + np.arange(GAUSS_NODES.size)
                if part.origins.size == 1:  # all nodes alike
                    node = np.zeros_like(node)
                breaks, *rest = (self._shares[panel] * table(node, stretch) for table in part.mixed)
                stiff = rest[0] if rest else breaks
                sums = breaks.sum(-1), np.einsum("ij,ij->i", stiff, stretch), stiff.sum(-1)
                out += np.stack([np.bincount(row, weights=one, minlength=x.size) for one in sums])
        return out, known

    def read(self, stretch: Array, origin: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """p of contacts from each origin, and the same with stiffnesses, where that is known; shape (2, n); and where
        it is."""
        out, known = np.zeros((2, stretch.size)), np.zeros(stretch.size, dtype=bool)
        for part in self._parts:
            inside = (origin >= self.edges[part.first]) & (origin <= self.edges[part.last]) & (stretch >= part.begin)
            all_here = np.flatnonzero(inside & ~known)
            known[all_here] = True
            for i in range(0, all_here.size, _PAIRS):
                here = all_here[i : i + _PAIRS]
                shares = _shares(part.origins, origin[here]) / part.share
                for row, table in enumerate(part.told):
                    out[row, here] = np.einsum("nk,kn->n", shares, table.every(stretch[here]))
        return out if self._breaking.linked else out[[0, 0]], known

    def _split(self, first: int, last: int) -> None:
        """Parts of the panels `first` up to `last`, halved until a few x_0 tell the rest."""
        low, high = float(self.edges[first]), float(self.edges[last])
        bends, rooted = self._breaking.bends_at_zero, self._breaking.rooted
        share = float(self._shares[first:last].sum())
        # thresholds below |x_0| are none of the contact's own; soft contacts' rates from above go on below smoothly
        reach = max(-low, high if rooted else 0.0)
        free = float(self._breaking.law.cdf(reach * self._unit)) * share < _FREE
        narrow = high - low < self._widest or last - first == 1
        ways = []  # from which stretch on, with thresholds above what
        if free and not (bends and low < 0.0 < high):
            ways.append((low, reach if rooted else 0.0))
        if narrow and not low < 0.0 < high:
            ways.append((max(-low, high), max(-low, high)))
        for begin, least in ways:
            origins = self._origins(low, high, max(least, -low, low), share)
            if origins is not None:
                self._parts.append(Part(first, last, begin, least, origins, share))
                return
        if last - first > 1:
            middle = 0.5 * (low + high) if not low < 0.0 < high else 0.0
            cut = first + 1 + int(np.abs(self.edges[first + 1 : last] - middle).argmin())
            self._split(first, cut)
            self._split(cut, last)

    def _origins(self, low: float, high: float, least: float, share: float) -> Array | None:
        """Few x_0 whose e^{A(x_0; ξ)/v} tell it for all others; None where that takes too many."""
        stretches = 0.5 * (low + high + (high - low) * _X) * self._unit
        grown, mass = self._breaking.grown(stretches, least * self._unit, _UNFELT / max(share, _UNFELT))
        if not mass.size:
            return np.array([0.5 * (low + high)])
        if np.abs(grown).max() > MOST_SPENT or np.ptp(grown, axis=0).max() > MOST_GROWTH:
            return None
        size = np.abs(_TO_SERIES @ np.exp(grown - grown[0])) @ mass
        for count in _SIZES:
            if size[count:].max() * share <= self._resolved:
                return 0.5 * (low + high - (high - low) * np.cos(np.pi * (np.arange(count) + 0.5) / count))
        return None

    def _tabulate(self) -> None:
        """Tables of p from all origins on the same panels, each times the share of its part."""
        breaking, unit, parts = self._breaking, self._unit, self._parts
        top = self._top
        begins, ends = np.array([part.begin for part in parts]), np.cumsum([part.origins.size for part in parts])
        low = float(begins.min())
        edges = np.concatenate([self._seeds, begins, [low, top]])
        edges = np.unique(np.clip(edges, low, top))
        edges = edges[np.append(np.diff(edges) > _SAME * (1.0 + top), True)]
        origins = np.concatenate([part.origins for part in parts])
        lowest, begin, least, share = np.repeat(
            [[self.edges[part.first], part.begin, part.least, part.share] for part in parts],
            [part.origins.size for part in parts],
            axis=0,
        ).T

        def rows(x: Array) -> Array:
            fan = breaking.fan(x.ravel() * unit, origins * unit, lowest * unit, least * unit) * unit
            fan *= share[:, None]
            fan[:, x.ravel() < begin[:, None]] = 0.0
            return fan.reshape(-1, *x.shape)

        tables = tabulate(rows, edges, self._accuracy)
        for part, end in zip(parts, ends, strict=True):
            mine = slice(end - part.origins.size, end)
            part.told = [bundle(tables[mine])]
            if breaking.linked:
                part.told.append(bundle(tables[origins.size :][mine]))
            at = part.origins if part.origins.size == 1 else self._nodes[part.first : part.last].ravel()
            shares = _shares(part.origins, at) / part.share
            part.mixed = [table.mixed(shares) for table in part.told]
            size = np.max([np.abs(table.coefficients).sum(axis=0) for table in tables[mine]], axis=0)
            felt = np.flatnonzero(size > _NOTHING)
            if felt.size:
                part.felt = float(tables[0].edges[felt[0]]), float(tables[0].edges[felt[-1] + 1])


def _shares(origins: Array, at: Array) -> Array:
    """Shares of the Chebyshev points `origins` in a polynomial's values at `at`; shape (at, origins)."""
    k = np.arange(origins.size)
    weights = np.where(k % 2, -1.0, 1.0) * np.sin(np.pi * (k + 0.5) / origins.size)
    apart = at[:, None] - origins
    apart[apart == 0.0] = 1e-300
    shares = weights / apart
    return shares / shares.sum(axis=1, keepdims=True)
