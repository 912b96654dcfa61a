"""Places where a density steps, bends or rises as a power, as a lattice sees them: nodes around each, and its place."""

from dataclasses import dataclass
from functools import cache, cached_property
from math import comb

import numpy as np
import numpy.typing as npt

from master._old.lattice import INTEGRATE, STENCIL, lagrange, lay, share_atoms
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

AHEAD, BEHIND = 12.0, 24.0  # nodes around a place that are put right
_LEAST, _LEAD, _NODES = 16, 20, 72  # nodes kept before a place at least, or later, and in all
_SAME = 1e-9
_BLOCK = 64
_HALVINGS = 110


@dataclass(frozen=True)
class Singular:
    """Densities height (x - place)^(order - 1) above each place: order 1 steps, order 2 bends.

    Attributes
    ----------
    order : float
    shift : integers of shape (n,)
        First of the nodes kept.
    place : array of shape (n,)
        Where it is, in nodes after that.
    height : array of shape (n,)
        Factor before the power, in units of the lattice.
    seen : array of shape (n, nodes)
        Masses on the lattice's nodes.
    """

    order: float
    shift: Indices
    place: Array
    height: Array
    seen: Array

    @property
    def position(self) -> Array:
        return self.shift + self.place

    @property
    def size(self) -> Array:
        """How much of each there is: where heights cancel, what the lattice made of them need not."""
        before = np.arange(self.seen.shape[1]) <= self.place[:, None] + 1.0
        return np.maximum(np.abs(self.height), np.abs(self.seen * before).max(axis=1, initial=0.0))

    def __getitem__(self, which: "Indices | npt.NDArray[np.bool_] | slice") -> "Singular":
        return Singular(self.order, self.shift[which], self.place[which], self.height[which], self.seen[which])

    def times(self, factors: "Array | float") -> "Singular":
        column = np.broadcast_to(factors, self.height.shape)
        return Singular(self.order, self.shift, self.place, self.height * column, self.seen * column[:, None])

    def largest(self, count: int) -> "Singular":
        """The `count` of the largest height."""
        if self.height.size <= count:
            return self
        return self[np.argpartition(-np.abs(self.height), count)[:count].astype(np.int64)]

    def after(self, atoms: Array) -> "Singular":
        """One more break, for each place at an exact value of its own (in nodes)."""
        if not atoms.size:
            return self
        leading, shares = share_atoms(atoms)
        position = self.position + atoms
        shift = np.maximum(np.floor(position).astype(np.int64) - _LEAD, 0)
        padded = np.concatenate([np.zeros((atoms.size, 1)), self.seen, self._beyond()], axis=1)
        node = np.arange(_NODES) + (1 + shift - self.shift - leading)[:, None]
        seen = np.zeros((atoms.size, _NODES))
        for k in range(STENCIL):
            at = np.clip(node - k, 0, padded.shape[1] - 1)
            seen += shares[:, k, None] * np.take_along_axis(padded, at, axis=1)
        return Singular(self.order, shift, position - shift, self.height, seen)

    def summed(self) -> "Singular":
        """The integral of each, as the lattice tells it."""
        return Singular(self.order + 1.0, self.shift, self.place, self.height / self.order, self.integral)

    def _beyond(self) -> Array:
        """Masses on the nodes that follow, where the lattice is right again."""
        after = self.seen.shape[1] + np.arange(2 * STENCIL) - self.place[:, None]
        return self.height[:, None] * after ** (self.order - 1.0)

    def folded(self, steps: "Singular") -> "Singular":
        """Steps folded with each of the `steps`: bends, those with the first of them first."""
        padded = np.concatenate([np.zeros((steps.height.size, _NODES)), steps.seen], axis=1)
        node = np.arange(_NODES)
        causal = padded[:, _NODES + node - node[:, None]]
        return Singular(
            2.0,
            np.add.outer(steps.shift, self.shift).ravel(),
            np.add.outer(steps.place, self.place).ravel(),
            np.multiply.outer(steps.height, self.height).ravel(),
            (self.seen @ causal).reshape(-1, _NODES),
        )

    def missing(self, reading: "Reading", integrated: bool) -> Array:
        """What a density (or its integral) read from the lattice lacks."""
        position = reading.position
        total = np.zeros(position.size)
        power = self.order if integrated else self.order - 1.0
        begin = self.shift + np.maximum(self.place - AHEAD, 0.0)
        first, last = np.searchsorted(position, begin), np.searchsorted(position, self.position + BEHIND)
        met = np.flatnonzero(last > first)
        if not met.size:
            return total
        masses = self.integral if integrated else self.seen
        for some in (met[start : start + _BLOCK] for start in range(0, met.size, _BLOCK)):
            count = last[some] - first[some]
            item = np.repeat(some, count)
            at = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count - first[some], count)
            beyond = position[at] - self.shift[item] - self.place[item]
            above = beyond > 0.0 if power else beyond >= 0.0
            exact = np.power(beyond, power, out=np.zeros(at.size), where=above)
            exact *= self.height[item] / (self.order if integrated else 1.0)
            cell = item * _NODES + reading.cell[at] - self.shift[item]
            read = np.einsum("ij,ij->i", reading.weights[at], masses.ravel()[cell[:, None] + np.arange(STENCIL)])
            total += np.bincount(at, weights=exact - read, minlength=position.size)
        return total

    @cached_property
    def integral(self) -> Array:
        """`integrate` of every row."""
        total = self.seen.cumsum(axis=1)
        for k, weight in enumerate(INTEGRATE):
            total[:, k:] += weight * self.seen[:, : _NODES - k]
        return total


class Reading:
    """Sorted positions (in nodes), each with the first of the eight nodes around it and their Lagrange weights."""

    def __init__(self, position: Array) -> None:
        self.position = position
        self.cell = np.maximum(position.astype(np.int64) - (STENCIL // 2 - 1), 0)
        self.weights = lagrange(position - self.cell)


def units(order: float, positions: Array) -> Singular:
    """Places of height 1, each laid down on a short lattice of its own."""
    shift = np.maximum(np.floor(positions).astype(np.int64) - _LEAST, 0)
    place = positions - shift
    if float(order).is_integer():
        return Singular(order, shift, place, np.ones(positions.size), _seen_polynomials(int(order), place))
    seen = np.empty((positions.size, _NODES))
    # a power that is no polynomial is laid down right on ever narrower panels alone
    graded = 0.5 ** np.arange(_HALVINGS)
    for row, at in zip(seen, place, strict=True):
        edges = np.concatenate([[at, _NODES + STENCIL], at + graded])
        row[:] = lay(lambda x, at=at: [_power(x - at, order - 1.0)], 1, edges, 1.0, _NODES + 2 * STENCIL)[0, :_NODES]  # type: ignore[misc]
    return Singular(order, shift, place, np.ones(positions.size), seen)


def _seen_polynomials(order: int, place: Array) -> Array:
    """(x - place)^(order - 1) above each place, laid down: what is left of its own cell, then whole cells."""
    cell: Indices = place.astype(np.int64)
    # counted from the place's cell on, whole cells hold powers of x, and their sums are known
    since = place - cell
    seen = np.zeros((place.size, _NODES))
    for power, whole in enumerate(_whole_cells(order)):
        factor = comb(order - 1, power) * (-since) ** (order - 1 - power)
        seen += factor[:, None] * whole[cell]
    nodes, weights = gauss(place, np.floor(place) + 1.0)
    first = np.maximum(cell - (STENCIL // 2 - 1), 0)
    weights = weights * (nodes - place[:, None]) ** (order - 1)
    shares = np.einsum("ij,ijk->ik", weights, lagrange(nodes - first[:, None]))
    np.add.at(seen, (np.arange(place.size)[:, None], first[:, None] + np.arange(STENCIL)), shares)
    return seen


@cache
def _whole_cells(order: int) -> list[Array]:
    """(x - c)^k for each k below `order`, laid down from each node c + 1 on; shapes (_LEAST + 1, nodes)."""
    size = _NODES + 2 * STENCIL
    return [
        np.stack(
            [
                lay(lambda x, c=c, k=k: [(x - c) ** k], 1, np.array([c + 1.0, size]), 1.0, size)[0, :_NODES]  # type: ignore[misc]
                for c in range(_LEAST + 1)
            ]
        )
        for k in range(order)
    ]


def _power(x: Array, power: float) -> Array:
    """x^power, and 0 where rounding leaves no x."""
    return np.power(x, power, out=np.zeros(x.shape), where=x > 0.0)


def join(order: float, parts: list[Singular]) -> Singular:
    if not parts:
        return units(order, np.empty(0))
    shift = np.concatenate([part.shift for part in parts])
    place, height = np.concatenate([np.stack([part.place, part.height]) for part in parts], axis=1)
    return Singular(order, shift, place, height, np.concatenate([part.seen for part in parts]))


def merge(singular: Singular) -> Singular:
    """Places equal to within rounding become one."""
    singular = singular[np.argsort(singular.position, kind="stable")]
    position = singular.position
    new = np.append(True, np.diff(position) > _SAME * position[1:])[: position.size]
    new |= np.append(True, np.diff(singular.shift) != 0)[: position.size]
    if new.all():
        return singular
    group, first = np.cumsum(new) - 1, np.flatnonzero(new)
    seen = np.zeros((first.size, singular.seen.shape[1]))
    np.add.at(seen, group, singular.seen)
    height = np.bincount(group, weights=singular.height).astype(float)
    return Singular(singular.order, singular.shift[first], singular.place[first], height, seen)
