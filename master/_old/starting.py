"""Sums over the starting stretches: b_0(X) and what it releases at single positions X, for a start with a width.

With q(x) = Q_ini(x) / S(|x|), a start with thresholds conditional on x_s > |x|:

    b_0(X) = integral of q(x) P_c(x + X) over x + X > |x|,       dJ_0/dX = the same, times (x + X).
"""

import numpy as np
import numpy.typing as npt

from master._old.law import Law
from master._old.piecewise import Piecewise, tabulate
from origins import Contacts
from origins.thresholds.quadrature import GAUSS_NODES, gauss

Array = npt.NDArray[np.float64]

_NO_THRESHOLDS = 1e-300  # survival from which starts are cut off
_LITTLE = 1e-6
NARROW = 256.0  # parts of a start, in each of which one edge leads to what is narrower
_CHUNK = 12_000  # nodes at a time, so that what is made on the way stays in the cache


class StartSum:
    """Panels over the start that its density and 1/S(|x|) are smooth on, and sums over them.

    Attributes
    ----------
    low, high : float
        Ends of the start, in units of the mean threshold.
    edges : array
        Edges of its panels.
    mean : float
        <x_ini>.
    widest : float
        Width of the widest panel with any weight to speak of.
    """

    def __init__(self, contacts: Contacts, law: Law, accuracy: float = 1e-13) -> None:
        self._law, self._start = law, contacts.start
        unit, reach = law.unit, law.support[1]
        if contacts.cut_weight > 0.0 and not np.isfinite(reach):
            reach = float(contacts.thresholds.isf(_NO_THRESHOLDS)) / unit
        self.low = max(contacts.start.span[0] / unit, -reach)
        self.high = min(contacts.start.span[1] / unit, reach)
        self._scale = unit / (1.0 - contacts.cut_weight)
        # where stiffnesses differ, k per length of the threshold
        self._stiffness = unit / contacts.mean_threshold if contacts.stiffness == "linked" else 0.0
        inner = contacts.start.breakpoints / unit
        self._conditional = law.held < 1.0
        seeds = np.concatenate([np.linspace(self.low, self.high, 9), inner])
        if self._conditional:
            # 1/S(|x|) has a cusp at 0 and the law's own kinks and narrow rises: panels follow it as well as the start
            rises = thin(law.edges, (self.high - self.low) / NARROW)
            marks = np.concatenate([rises, law.breakpoints, law.atoms])
            seeds = np.concatenate([seeds, marks, -marks])
        if self._conditional or contacts.thermal is not None:
            seeds = np.append(seeds, 0.0)
        seeds = np.unique(seeds[(seeds >= self.low) & (seeds <= self.high)])
        table, *_ = tables = tabulate(self._both, seeds, accuracy, scale=self._felt if self._conditional else None)
        self.mean = contacts.start.mean() / unit if contacts.cut_weight == 0.0 else _mean(table) / table.total
        self.edges = table.edges
        nodes, weights = gauss(self.edges[:-1], self.edges[1:])
        plain = weights * self._plain(nodes)
        # beside a start much narrower than its mean, positions are rounded: the weights' sum need not be
        mass = float(plain.sum())
        self._scale /= mass
        self._series, self._mass = tables[-1], mass
        self._nodes, self._shares = nodes, plain / mass * self._held(nodes)
        # where panels of the law are no narrower than these, sums over these alone do
        self.widest = float(np.diff(self.edges)[plain.sum(axis=1) > _LITTLE * mass].max())
        inner = law.inner_edges(self.widest)
        self._law_edges = np.unique(np.concatenate([law.breakpoints, inner]))

    def _plain(self, x: Array) -> Array:
        """Q_ini, but 0 where it diverges: at an end, where no weight sits."""
        density = self._start.pdf(x * self._law.unit) * self._scale
        return np.where(np.isfinite(density), density, 0.0)

    def _held(self, x: Array) -> Array:
        """1/S(|x|); 0 where no threshold is left."""
        if not self._conditional:
            return np.ones(x.shape)
        survival = self._law.sf(np.abs(x))
        return np.divide(1.0, survival, out=np.zeros(x.shape), where=survival > _NO_THRESHOLDS)

    @property
    def sample(self) -> tuple[Array, Array]:
        """Nodes over the start and Q_ini/S times their weights: sums of what is smooth on its panels."""
        return self._nodes, self._shares

    def density(self, x: Array) -> Array:
        """Q_ini(x)."""
        return self._plain(x)

    def weight(self, x: Array) -> Array:
        """q(x) = Q_ini(x)/S(|x|)."""
        return self._plain(x) * self._held(x)

    def weight_at(self, x: Array) -> Array:
        """The same, from a table; 0 outside the start."""
        return self._series(x) / self._mass

    def _both(self, x: Array) -> Array:
        plain = self._plain(x)
        return np.stack([plain, plain * self._held(x)] if self._conditional else [plain])

    def _felt(self, x: Array) -> Array:
        """How much errors of the same count: of what 1/S makes large, as much as there are thresholds left."""
        return np.stack([np.ones(x.shape), self._law.sf(np.abs(x))])

    def rows(self, x: Array) -> Array:
        """b_0, dJ_0/dX and, where stiffnesses differ, the stiffness released at positions x, shape (rows, *x.shape)."""
        flat, edges = x.ravel(), self._law_edges
        least = np.clip(-0.5 * flat, self.low, self.high)
        cut = np.searchsorted(edges, flat + self.high) - np.searchsorted(edges, flat + least, side="right")
        panels = self.edges.size - np.searchsorted(self.edges, least)
        nodes = GAUSS_NODES.size * np.cumsum(panels + cut)
        chunks = np.flatnonzero(np.diff(nodes // _CHUNK)) + 1
        parts = [
            self._sum(positions, cut_here)
            for positions, cut_here in zip(np.split(flat, chunks), np.split(cut, chunks), strict=True)
        ]
        return np.concatenate(parts, axis=1).reshape(-1, *x.shape)

    def _sum(self, x: Array, cut: npt.NDArray[np.intp]) -> Array:
        law = self._law
        apart = (x >= -2.0 * self.low) & (cut == 0) & (self._stiffness == 0.0)
        reached = x + self.high > law.begins
        out = np.zeros((3 if self._stiffness else 2, x.size))
        whole = np.flatnonzero(apart & reached)
        if whole.size:
            nodes, shares = self._nodes.ravel(), self._shares.ravel()
            # times 1 and times (x + X), in one product
            sums = law.pdf(nodes + x[whole, None]) @ np.stack([shares, shares * nodes], axis=1)
            out[0, whole] = sums[:, 0]
            out[1, whole] = sums[:, 1] + x[whole] * sums[:, 0]
        split = np.flatnonzero(~apart & reached)
        if split.size:
            out[:, split] = self._split(x[split])
        for atom, weight in zip(law.atoms, law.atom_weights, strict=True):
            at = atom - x
            inside = (np.abs(at) < atom) & (at >= self.low) & (at <= self.high)
            share = np.where(inside, weight * self._plain(at) * self._held(at), 0.0)
            stiff = share * (self._stiffness * atom)
            out += np.stack([share, atom * stiff, stiff] if self._stiffness else [share, atom * share])
        return out

    def _split(self, x: Array) -> Array:
        """The same where edges of the law, or the condition x_0 + X > |x_0|, cut the range of the start."""
        least = np.clip(-0.5 * x, self.low, self.high)[:, None]
        own = np.broadcast_to(self.edges, (x.size, self.edges.size))
        edges = np.concatenate([own, self._law_edges - x[:, None]], axis=1)
        edges = np.sort(np.clip(edges, least, self.high), axis=1)
        left, right = edges[:, :-1], edges[:, 1:]
        row, piece = np.nonzero(right - left > 1e-15 * (self.high - self.low))
        if not row.size:
            return np.zeros((3 if self._stiffness else 2, x.size))
        left, right = left[row, piece], right[row, piece]
        panel = np.searchsorted(self.edges, 0.5 * (left + right)) - 1
        # most panels are whole, and their sums over the start known
        cut = (left != self.edges[panel]) | (right != self.edges[panel + 1])
        nodes, weights = self._nodes[panel], self._shares[panel]
        if cut.any():
            nodes[cut], weights[cut] = gauss(left[cut], right[cut])
            weights[cut] *= self._series.within(panel[cut], nodes[cut]) / self._mass
        nodes += x[row, None]
        weights *= self._law.pdf(nodes)
        if self._stiffness:
            stiff = weights * (self._stiffness * nodes)
            parts = [weights, stiff * nodes, stiff]
            return np.stack([np.bincount(row, weights=part.sum(-1), minlength=x.size) for part in parts])
        return np.stack(
            [
                np.bincount(row, weights=weights.sum(-1), minlength=x.size),
                np.bincount(row, weights=np.einsum("ij,ij->i", weights, nodes), minlength=x.size),
            ]
        )

    def broken(self, x: float) -> float:
        """Fraction broken by X = x, from survival alone: no peak of b_0 that a table missed is missed here."""
        law = self._law
        inner = np.concatenate([law.edges - x, law.atoms - x, law.edges, -law.edges, [-0.5 * x]])
        edges = np.unique(np.concatenate([self.edges, inner[(inner > self.low) & (inner < self.high)]]))
        nodes, weights = gauss(edges[:-1], edges[1:])
        size = np.abs(nodes)
        held, beyond = law.sf(np.stack([size, np.maximum(size, nodes + x)]))
        share = np.divide(held - beyond, held, out=np.zeros(held.shape), where=held > _NO_THRESHOLDS)
        return float((weights * self._plain(nodes) * share).sum())


def thin(points: Array, spacing: float) -> Array:
    """Sorted points at least about `spacing` apart: what lies closer needs no edge of its own."""
    if not points.size:
        return points
    return points[np.unique(np.floor((points - points[0]) / spacing), return_index=True)[1]]


def _mean(table: Piecewise) -> float:
    nodes, weights = gauss(table.edges[:-1], table.edges[1:])
    return float((weights * nodes * table(nodes)).sum())
