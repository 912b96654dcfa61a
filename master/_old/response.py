"""A start with a width on a law with powers: its force as that of a relaxed start, seen from many places.

With K(X) = X - F(X) of a relaxed start, and R(s) the integral of y P_c(y) up to s, a contact that starts at x_0 > 0
with a threshold above it has released on average

    [K(x_0 + X) - integral_0^x_0 P_c(y) (y + K(x_0 + X - y)) dy] / S(x_0)

by X: of all that a relaxed one does, what it does where its first threshold lies below x_0 is left out. From x_0 < 0 it
has crossed 0 at X = |x_0|, and the same holds from there on. With q = Q_ini/S(|x|) all this is

    integral m(w) K(X + w) dw - constant,     m(w) = q(w) - integral of P_c(y) q(w + y) over y < |w + y|,

and only K is rough, where the relaxed solution tells all about it.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from master._old.distribution import StretchDistribution, distribution_at
from master._old.forward import refined, round_off
from master._old.piecewise import Piecewise, tabulate
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from master._old.solution import Solution
from master._old.starting import StartSum
from master.outcome import Progress, outcome
from origins import Contacts
from origins.thresholds.quadrature import GAUSS_NODES, gauss

Array = npt.NDArray[np.float64]

_SHARE = 0.7  # of the tolerance, for the relaxed solution
_GRID = 100  # positions at which that is judged
_FINE = 5e-3  # of the tolerance: what tables may lack
_HALVINGS = 12.0  # of panels towards the lower end of the law
_EDGES = np.append(0.0, 0.5 ** np.arange(_HALVINGS, -1.0, -1.0))
_TOWARDS = 3
_PARTS = 12  # of the shifts, on each of which K is a polynomial where no place is near
_NOTHING = 1e-10  # of a start at its ends
_LEAST, _FELT = 1e-12, 1e-17
_ENOUGH, _LOW = 4, 0.6  # of these edges, where q is smooth; order from which on y is no high power
_CHUNK = 100_000  # nodes at a time


def solve_from_relaxed(
    contacts: Contacts, relaxed: Problem, path: Array, tolerance: float, began: float, progress: Progress
) -> Solution:
    """Force F(X) on a rigid slider from a start with a width; `relaxed` is the problem of a relaxed start, which goes
    beyond the path by the largest starting stretch."""
    x, end = path / relaxed.unit, relaxed.end
    # towards X = 0 as well, where K is a power
    grid = np.union1d(end / _GRID * np.arange(1.0, _GRID + 1.0), end / _GRID * _EDGES[1:] ** _TOWARDS)
    _, error, later, message = refined(relaxed, grid, _SHARE * tolerance, progress)
    later_places = relaxed.powers.places if relaxed.powers is not None else np.empty(0)
    places = np.union1d(later_places, relaxed.law.breakpoints[relaxed.law.breakpoints > 0.0])
    shifts = _Shifts(contacts, relaxed, _FINE * tolerance)

    def given(x: Array) -> Array:
        flat, above = x.ravel(), x.ravel() > 0.0
        order = np.argsort(flat[above])
        at = flat[above][order]
        found = relaxed.first.released(at) + (0.0 if later is None else later(at))
        out = np.zeros(flat.size)
        out[np.flatnonzero(above)[order]] = found
        return out.reshape(1, *x.shape)

    marks = np.concatenate([[0.0], places[places < end], [end]])
    (table,) = tabulate(given, marks, _FINE * tolerance)
    force = shifts.mean + x - shifts.folded(table, x, places) + shifts.left_out(x)
    tails = shifts.highest * table.error + (1.0 + end) * shifts.error
    error = shifts.whole * error + tails + round_off(relaxed)
    if not message:
        message = f"starting stretches are summed over to {error:.1e} only, above the tolerance {tolerance:.1e}"
    success, message = outcome(contacts, error, tolerance, message)
    return SpreadSolution(
        path=path,
        force=force * relaxed.unit,
        force_error=error,
        holding=np.ones(x.size),
        run_time=time.perf_counter() - began,
        nodes=0 if later is None else later.lattice.size,
        success=success,
        message=message,
        _problem=relaxed,
        _later=later,
        _contacts=contacts,
    )


@dataclass(frozen=True)
class SpreadSolution(Solution):
    """The same; what its distribution needs beside is found when asked for."""

    _contacts: Contacts = field(repr=False)

    @cached_property
    def _own(self) -> tuple[Problem, LaterReleased]:
        step = 1.0 if self._later is None else self._later.lattice.step
        tolerance = self.force_error
        problem = Problem(self._contacts, float(self.path[-1]) / self._problem.unit, tolerance, law=self._problem.law)
        return problem, LaterReleased(problem, step, self.path / problem.unit, 1e-2 * tolerance)

    def distribution(self, position: float) -> StretchDistribution:
        return distribution_at(*self._own, position, float(self.path[-1]))


class _Shifts:
    """m(w) on panels between the smallest and the largest shift, and sums over it; lengths in units of the law.

    Attributes
    ----------
    mean : float
        <x_ini>.
    error, highest, whole : float
        By how much the weight of m differs from 1, which it is; the largest |m|; the weight of |m|.
    """

    def __init__(self, contacts: Contacts, relaxed: Problem, accuracy: float) -> None:
        self._law, self._relaxed = relaxed.law, relaxed
        self._start = start = StartSum(contacts, relaxed.law, accuracy)
        self.mean = start.mean
        begin = relaxed.law.support[0]
        self._crossing = -start.low > begin
        lowest = 2.0 * start.low if self._crossing else min(start.low, 0.0) if start.high > begin else start.low
        marks = np.concatenate([[start.low, start.high, 0.0, lowest, begin, -begin, -2.0 * begin], start.edges])
        marks = np.unique(marks[(marks >= lowest) & (marks <= start.high)])
        order = relaxed.law.onset_order
        self._order = min(order, 1.0)
        # y as a power of what nodes are even in, and P_c dy, are smooth enough for few panels
        even = bool(order == np.round(order)) or order < _LOW
        # where they are not, as y^0.2 is not in y, the first of them is to weigh little
        deeper = _HALVINGS if even or order < 1.0 else 2.0 * _HALVINGS
        self._edges = np.append(0.0, 0.5 ** np.arange(deeper, -1.0, -1.0))
        ends = start.weight_at(np.array([start.low, start.high]))
        self._smooth = not contacts.start.breakpoints.size and float(ends.max()) * (start.high - start.low) < _NOTHING
        count = int(np.ceil((start.high - start.low) / start.widest)) + 1
        self._even = even and self._smooth
        self._marks = np.linspace(start.low, start.high, count) if self._smooth else start.edges
        self._nodes, self._masses = self._below(max(start.high, -start.low))
        (self._table,) = tabulate(lambda w: self._density(w)[None], marks, accuracy)
        self._low, self._high = lowest, start.high
        nodes, weights = gauss(self._table.edges[:-1], self._table.edges[1:])
        self._at, self._weights = nodes, weights * self._table.within(np.arange(nodes.shape[0]), nodes)
        self.error = abs(float(self._weights.sum()) - 1.0) + self._table.error
        self.whole = float(np.abs(self._weights).sum())
        self.highest = float(np.abs(self._table.coefficients).sum(axis=0).max())

    def _below(self, top: float) -> tuple[Array, Array]:
        """Nodes y and masses P_c dy of the thresholds below `top`, close enough for what is as smooth as the start."""
        length = top - self._law.support[0]
        if length <= 0.0:
            return np.empty(0), np.empty(0)
        parts = np.linspace(0.0, 1.0, int(np.ceil(length / self._start.widest)) + 1)[1:] ** self._order
        edges = np.append(self._edges[parts[0] > self._edges], parts)
        nodes, masses = self._towards(np.array([length]), edges[None])
        return nodes[0], masses[0]

    def _towards(self, length: Array, edges: Array) -> tuple[Array, Array]:
        """Nodes and masses of the thresholds to each of some lengths above the lower end of the law: Gauss on panels in
        the power of y that P_c dy is smooth in; edges has a row for each, from 0 to 1."""
        law, order = self._law, self._order
        nodes, weights = gauss(edges[:, :-1], edges[:, 1:])
        nodes, weights = nodes.reshape(edges.shape[0], -1), weights.reshape(edges.shape[0], -1)
        nodes = np.maximum(nodes, _LEAST)
        apart = length[:, None] * nodes ** (1.0 / order)
        y = law.support[0] + apart
        return y, law.pdf(y) * apart * (weights / (order * nodes))

    def _density(self, w: Array) -> Array:
        start, begin = self._start, self._law.support[0]
        out = start.weight_at(w)
        if not self._nodes.size:
            return out
        flat, total = w.ravel(), np.zeros(w.size)
        above, below = np.flatnonzero(flat > 0.0), np.flatnonzero(flat < -2.0 * begin)
        if self._smooth:
            total[above] = start.weight_at(flat[above, None] + self._nodes) @ self._masses
        else:
            above = above[flat[above] < start.high - begin]
            total[above] = self._summed(flat[above], start.high - flat[above] - begin)
        if self._crossing:
            # from x_0 < 0, y below half of |w|
            total[below] = self._summed(flat[below], -0.5 * flat[below] - begin)
        return np.asarray(out - total.reshape(w.shape))

    def _summed(self, w: Array, length: Array) -> Array:
        """Integral of P_c(y) q(w + y) over some lengths above the lower end of the law."""
        if not w.size:
            return np.zeros(0)
        marks = (self._marks - w[:, None] - self._law.support[0]) / length[:, None]
        some = self._edges[-_ENOUGH if self._even else 1 :]
        own = np.broadcast_to(np.append(0.0, some), (w.size, some.size + 1))
        edges = np.sort(np.concatenate([own, np.clip(marks, 0.0, 1.0) ** self._order], axis=1), axis=1)
        y, masses = self._towards(length, edges)
        return np.asarray((masses * self._start.weight_at(w[:, None] + y)).sum(axis=1))

    def folded(self, table: Piecewise, x: Array, places: Array) -> Array:
        """Integral of m(w) K(X + w) at each X = x."""
        parts = np.linspace(self._low, self._high, _PARTS + 1)
        width = parts[1] - parts[0]
        begin, end = np.searchsorted(np.append(0.0, places), np.stack([x + self._low - width, x + self._high + width]))
        out, rough = np.empty(x.size), end > begin
        coarse, lumps = gauss(parts[:-1], parts[1:])[0].ravel(), self._lumped(parts)
        felt = np.abs(lumps) > _FELT
        out[~rough] = table(x[~rough, None] + coarse[felt]) @ lumps[felt]
        some = np.flatnonzero(rough)
        size = 8 * (table.edges.size + self._table.edges.size)
        for chunk in np.array_split(some, max(1, some.size * size // _CHUNK)):
            out[chunk] = self._rough(table, x[chunk])
        return out

    def _lumped(self, parts: Array) -> Array:
        """Weights of eight nodes in each part that do for polynomials what m does."""
        part = (np.searchsorted(parts, self._at.ravel(), side="right") - 1).clip(0, _PARTS - 1)
        place = (self._at.ravel() - parts[part]) / (parts[1] - parts[0])
        shares = self._weights.ravel()[:, None] * _among_nodes(place)
        out = np.zeros((_PARTS, GAUSS_NODES.size))
        np.add.at(out, part, shares)
        return out.ravel()

    def _rough(self, table: Piecewise, x: Array) -> Array:
        """The same where K is rough."""
        own = np.broadcast_to(self._table.edges, (x.size, self._table.edges.size))
        edges = np.sort(np.clip(np.concatenate([own, table.edges - x[:, None]], axis=1), self._low, self._high), axis=1)
        row, piece = np.nonzero(edges[:, 1:] - edges[:, :-1] > 1e-15)
        left, right = edges[row, piece], edges[row, piece + 1]
        nodes, weights = gauss(left, right)
        middle, at = 0.5 * (left + right), x[row]
        weights *= self._table.within((np.searchsorted(self._table.edges, middle) - 1).clip(0), nodes)
        weights[at + middle < 0.0] = 0.0
        weights *= table.within((np.searchsorted(table.edges, at + middle) - 1).clip(0), nodes + at[:, None])
        return np.asarray(np.bincount(row, weights=weights.sum(axis=1), minlength=x.size), dtype=float)

    def left_out(self, x: Array) -> Array:
        """What thresholds below |x_0| would have released: R(|x_0|), or from x_0 < 0 R(X - |x_0|) before X = 2|x_0|."""
        start, begin = self._start, self._law.support[0]
        released = self._relaxed.first.released

        def summed(edges: Array, held: Callable[[Array], Array]) -> float:
            nodes, weights = gauss(edges[:-1], edges[1:])
            weights = weights * start.weight_at(nodes)
            return float((weights * released(held(nodes).ravel()).reshape(nodes.shape)).sum())

        edges = np.unique(np.append(start.edges, np.clip([-begin, 0.0, begin], start.low, start.high)))
        out = np.full(x.size, summed(edges[edges >= 0.0], np.abs))
        crossing = edges[edges <= 0.0]
        out += summed(crossing, np.abs)
        early = np.flatnonzero(x < -2.0 * start.low)
        out[early] -= summed(crossing, np.abs)
        for k in early:
            at = x[k]
            cut = np.clip(np.append(crossing, [-at, -0.5 * at, begin - at]), max(-at, start.low), 0.0)
            out[k] += summed(np.unique(cut), lambda y, at=at: np.minimum(at + y, -y))  # type: ignore[misc]
        return out


def _among_nodes(place: Array) -> Array:
    """Lagrange weights of the eight Gauss nodes on (0, 1) at places in between; shape (n, 8)."""
    apart = place[:, None] - GAUSS_NODES
    out = np.empty((place.size, GAUSS_NODES.size))
    for k, node in enumerate(GAUSS_NODES):
        others = np.delete(np.arange(GAUSS_NODES.size), k)
        out[:, k] = (apart[:, others] / (node - GAUSS_NODES[others])).prod(axis=1)
    return out
