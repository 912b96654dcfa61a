"""First breaks by a temperature or with ageing, of contacts that hold at X = 0 with stretches on either side of 0.

With p(x; x_0) of thermal_law or ageing_breaking and q(x_0) = Q_ini(x_0)/S(|x_0|),

    b_0(X) = integral of q(x_0) p(x_0 + X; x_0),       dJ_0/dX = the same, times (x_0 + X).
"""

import numpy as np
import numpy.typing as npt

from master._old.ageing_breaking import AgeingBreaking
from master._old.breaking_law import LEAST, early
from master._old.corners import bends
from master._old.first import FirstBreaks, tabulate_rows
from master._old.grain_breaking import GrainBreaking
from master._old.law import Law
from master._old.starting import StartSum, thin
from master._old.thermal_law import ThermalBreaking
from master._old.thermal_paper import PaperBreaking
from master._old.thermal_spread import SpreadBreaks
from origins import Contacts
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

Breaking = ThermalBreaking | PaperBreaking | AgeingBreaking | GrainBreaking

_JUMP = 1e-11
_NARROW = 1e-9
_CHUNK = 8_000
_SAME = 1e-14
_SHORT = 0.5  # of a mean stretch at a break: panels of the start on which breaks hardly change but at cuts
_NEGLIGIBLE, _UNFELT = 1e-19, 1e-5
_SIGNS = 8.0
_NEAREST, _DECADES, _SAMPLES = 1e-12, 25, 9  # of the way, and how many positions: there sums tell which panels do
_HALVES = np.array([0.25, 0.75])
_FELT, _LEAST_FELT = 0.03, 1e-14  # of the accuracy, and of all contacts
_EPSILON = float(np.finfo(float).eps)


class OriginBreaks(FirstBreaks):
    """Density and atoms of the first breaks over X (in units of `law`), up to X = `end`, the same face as at T = 0."""

    def __init__(self, contacts: Contacts, law: Law, breaking: Breaking, end: float, accuracy: float) -> None:
        unit = law.unit
        self._furthest_start = float(np.abs(contacts.start.span).max()) / unit
        self.end, self._accuracy, self._law = end, max(accuracy / max(self._furthest_start, 1.0), 2e-15), law
        self._breaking = breaking = breaking.of(contacts.start)
        self._unit, self._contacts = unit, contacts
        self._spread: SpreadBreaks | None = None
        self._may_bend = True
        low, high = np.asarray(contacts.start.span) / unit
        self.single = bool(high - low < _NARROW)
        marks = breaking.marks / unit
        if self.single:
            start = contacts.start.mean() / unit
            self._origins, self._shares = np.array([start]), 1.0 / breaking.law.sf(np.array([abs(start * unit)]))
            self._sum: StartSum | None = None
            self.mean_start, low, high = start, start, start
            keep = breaking.atoms / unit > abs(start)
            self.atoms = breaking.atoms[keep] / unit - start
            begin = np.full(self.atoms.size, start * unit)
            left = breaking.held(breaking.atoms[keep], breaking.atoms[keep], begin) * self._shares
            self.atom_weights = breaking.atom_weights[keep] * left
            stiff = contacts.relative_stiffness(breaking.atoms[keep])
            self.atom_stiffness = self.atom_weights * stiff
            self.atom_released = self.atom_stiffness * breaking.atoms[keep] / unit
            seeds = np.concatenate([marks - start, [-2.0 * start]])
        else:
            self._sum = StartSum(contacts, Law(contacts, np.inf, unit=unit))
            self.mean_start, low, high = self._sum.mean, self._sum.low, self._sum.high
            self.atoms, self.atom_weights, self.atom_released = np.empty(0), np.empty(0), np.empty(0)
            self.atom_stiffness = np.empty(0)
            rough = contacts.start.breakpoints / unit
            rough = np.concatenate([rough[(rough >= low) & (rough <= high)], [low, high]])
            # what is known by a numerical solution bends by its error
            self._may_bend = marks.size + rough.size > 2 or isinstance(breaking, AgeingBreaking)
            seeds = np.concatenate([(marks[:, None] - rough).ravel(), -2.0 * rough, marks - self.mean_start])
            bend = np.zeros(1 if breaking.bends_at_zero else 0)
            self._cuts = np.unique(np.concatenate([law.inner_edges(self._sum.widest), marks, bend]))
            if isinstance(breaking, ThermalBreaking | PaperBreaking):
                self._spread = SpreadBreaks(breaking, self._sum, law, np.append(marks, bend), self._accuracy, end)
                self._cuts = self._spread.cuts
        top = min(end, breaking.top / unit - low)
        if self._spread is not None:
            self._leave_out(top, np.append(marks, bend))
        seeds = np.unique(seeds[(seeds > 0.0) & (seeds <= top)])
        # breaks vary over X as over x, or as over the start
        known = law.edges[::2] - self.mean_start
        known = known if self.single else thin(known, 0.06 * (high - low))
        edges = np.concatenate([known, breaking.panels / unit, np.linspace(0.0, top, 5)])
        edges = np.append(edges, early(lambda x: self._integrals(x)[0], top, LEAST * contacts.mean_threshold / unit))
        edges = np.unique(np.append(edges[(edges >= 0.0) & (edges <= top)], seeds))
        # closer than rounding is once
        edges = edges[np.append(np.diff(edges) > min(_SAME, 0.01 * top), True)]
        self.density, self._released, self.stiffness = tabulate_rows(
            self._rows, edges, self._accuracy, offset=max(abs(low), abs(high))
        )
        self._find_corners(seeds, law)
        rest = float(self._integrals(np.array([top]), holds=True)[1, 0]) if top < breaking.top / unit - low else 0.0
        broken = self.density.total + float(self.atom_weights[self.atoms <= top].sum())
        # over a start errors of many signs add up to the defect, and in the force with other weights
        self._defect = abs(1.0 - rest - broken) * (1.0 if self.single else _SIGNS) + breaking.error
        if self.single:
            width, weight = np.diff(self.density.edges), np.abs(np.diff(self.density.integral(self.density.edges)))
            self.rounding = _EPSILON * abs(low) * float((weight / width).sum())
            self._defect += self.rounding

    def _leave_out(self, top: float, marks: Array) -> None:
        """Edges of panels that direct sums do without: where those of the start are short, and where no table is to be
        had as many as sums at some positions up to `top` do not feel; there all cuts but at `marks`, too."""
        start, spread = self._sum, self._spread
        assert start is not None and spread is not None
        inner = spread.edges[1:-1]
        own = np.searchsorted(start.edges, inner, side="right") - 1
        added = ~np.isin(inner, start.edges)
        self._spare = short = added & (np.diff(start.edges)[own] < _SHORT)
        alone = added & ~short & spread.untold[1:] & spread.untold[:-1]
        if not alone.any() and not spread.untold.all():
            return
        place = 1 + np.arange(inner.size) - np.searchsorted(inner, start.edges, side="left")[own]
        x = self._places(top)

        def sums(every: int) -> Array:
            self._spare = short | (alone & (place % every != 0))
            return self._integrals(x)[[0, 2]] * x / np.array([[1.0], [1.0 + self._furthest_start]])

        allowed = max(_FELT * self._accuracy, _LEAST_FELT)
        every = 2 ** int(np.ceil(np.log2(1 + place[alone].max(initial=0))))
        finer = sums(every)
        while every > 1:
            coarse, finer = finer, sums(every // 2)
            if np.abs(finer - coarse).max() <= allowed:
                break
            every //= 2
        if spread.untold.all():
            cuts, self._cuts = self._cuts, marks
            if np.abs(sums(every) - finer).max() > allowed:
                self._cuts = cuts
        self._spare = short | (alone & (place % every != 0))

    def _places(self, top: float) -> Array:
        """Positions up to `top`: over all its decades, and where contacts of either half of the start meet what there
        is of the law, few strong thresholds far behind the many too."""
        start, edges = self._sum, self._law.edges
        assert start is not None
        felt = np.flatnonzero(np.diff(self._law.cdf(edges)) > _FELT * self._accuracy)
        felt = felt[np.unique(np.linspace(0, felt.size - 1, _SAMPLES).astype(int))] if felt.size else felt
        origins, shares = (part.ravel() for part in start.sample)
        share = np.cumsum(shares) / shares.sum()
        meet = 0.5 * (edges[felt] + edges[felt + 1]) - origins[np.searchsorted(share, _HALVES)][:, None]
        x = np.concatenate([top * np.geomspace(_NEAREST, 1.0, _DECADES), meet.ravel()])
        return np.unique(x[(x > 0.0) & (x <= top)])

    def _find_corners(self, seeds: Array, law: Law) -> None:
        """Jumps of b_0 between panels, and bends where the law has atoms."""
        table = self.density
        # where the strongest thresholds end there is nothing from one edge to the next
        ends = table.edges[-1] in seeds and table.edges[-1] < self.end
        size = np.append(table.jumps, -table(table.edges[-1:]) if ends else 0.0)
        known = np.isin(table.edges, seeds) & (np.abs(size) > _JUMP)
        known[0] = True
        self.jumps, self.jump_sizes = table.edges[known], size[known]
        self.bends, self.bend_sizes = np.empty(0), np.empty(0)
        if seeds.size and self._may_bend:  # round-off of the tables looks like bends where there are none
            self.bends, self.bend_sizes = bends(table, seeds, law.narrowest)
        self.onsets, self.onset_heights = np.empty(0), np.empty(0)
        self.has_corners = bool(known[1:].any() or self.bends.size)

    def _rows(self, x: Array) -> Array:
        """b_0, dJ_0/dX and, where stiffnesses differ, the stiffness released at positions x, shape (rows, *x.shape)."""
        flat = x.ravel()
        per = max(1, _CHUNK // self._origins.size) if self._sum is None else _CHUNK // 64
        parts = [self._integrals(flat[i : i + per]) for i in range(0, flat.size, per)]
        out = np.concatenate(parts, axis=1)
        return out[[0, 2, 3] if self._breaking.linked else [0, 2]].reshape(-1, *x.shape)

    def _integrals(self, x: Array, holds: bool = False) -> Array:
        """b_0, what holds where that is asked for, dJ_0/dX and the stiffness released; shape (4, n)."""
        if self._sum is None:
            return self._total(np.arange(x.size), x, self._origins[0], self._shares[0], x.size)
        out = np.zeros((4, x.size))
        some, known = np.arange(x.size), np.empty((0, 0), dtype=bool)
        if self._spread is not None and not holds:
            out[[0, 2, 3]], known = self._spread.sums(x)
            some = np.flatnonzero(~known.all(axis=1))
        if some.size:
            out += self._by_pieces(x, some, known)
        breaking, unit = self._breaking, self._unit
        for atom, weight in zip(breaking.atoms / unit, breaking.atom_weights, strict=True):
            low, high = self._sum.low, self._sum.high
            at = np.flatnonzero((np.abs(atom - x) < atom) & (atom - x >= low) & (atom - x <= high))
            threshold = np.full(at.size, atom * unit)
            share = weight * self._sum.weight(atom - x[at]) * breaking.held(threshold, threshold, (atom - x[at]) * unit)
            stiff = share * self._contacts.relative_stiffness(atom * unit)
            out[0, at] += share
            out[2, at] += stiff * atom
            out[3, at] += stiff
        return out

    def _by_pieces(self, x: Array, some: npt.NDArray[np.intp], known: npt.NDArray[np.bool_]) -> Array:
        """The same, atoms left out, at `some` of the positions, over those panels of the start that are not known."""
        start, at = self._sum, x[some, None]
        assert start is not None
        panels = start.edges if self._spread is None else self._spread.edges
        own = np.broadcast_to(panels, (some.size, panels.size))
        if known.size:  # where no table tells any of them
            own = own.copy()
            own[:, 1:-1][self._spare & ~(known[some, 1:] | known[some, :-1])] = start.low
        # where a stretch turns at 0, and where it is back at what it was
        turns = self._breaking.bends(x[some] * self._unit) / self._unit
        cuts = self._cuts - at
        if self._spread is not None:
            # before it is back at what it was, no threshold is passed
            cuts = np.maximum(cuts, -0.5 * at)
            turns = -at if self._breaking.bends_at_zero else turns
        edges = np.concatenate([own, cuts, turns, -0.5 * at], axis=1)
        edges = np.sort(np.clip(edges, start.low, start.high), axis=1)
        left, right = edges[:, :-1], edges[:, 1:]
        left_over = right - left > 1e-15 * (start.high - start.low)
        if known.size:
            panel = np.searchsorted(panels, 0.5 * (left + right)) - 1
            left_over &= ~np.take_along_axis(known[some], np.clip(panel, 0, known.shape[1] - 1), axis=1)
        row, piece = np.nonzero(left_over)
        origins, weights = gauss(left[row, piece], right[row, piece])
        weights = (weights * start.weight(origins)).ravel()
        felt = weights > max(_NEGLIGIBLE, _UNFELT * self._accuracy)
        row, origins, weights = np.repeat(some[row], origins.shape[1])[felt], origins.ravel()[felt], weights[felt]
        if not known.size:
            return self._total(row, x[row], origins, weights, x.size)
        assert self._spread is not None
        stretch = origins + x[row]
        (breaks, stiff), told = self._spread.read(stretch, origins)
        parts = breaks * weights, stiff * weights * stretch, stiff * weights
        out = np.zeros((4, x.size))
        out[[0, 2, 3]] = [np.bincount(row[told], weights=part[told], minlength=x.size) for part in parts]
        rest = ~told
        return out + self._total(row[rest], x[row[rest]], origins[rest], weights[rest], x.size)

    def _total(
        self, row: npt.NDArray[np.intp], x: Array, origins: Array | float, weights: Array | float, size: int
    ) -> Array:
        stretch = origins + x
        rows = self._breaking.rows(stretch * self._unit, np.asarray(origins) * self._unit)
        breaks, stiff = rows[0] * self._unit * weights, rows[-2] * self._unit * weights
        parts = breaks, rows[1] * weights, stiff * stretch, stiff
        return np.stack([np.bincount(row, weights=part, minlength=size) for part in parts])
