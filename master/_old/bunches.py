"""Births on many panels, bunched into ever wider intervals, each of which 16 nodes stand for.

Where thresholds are smooth across an interval, w + y for all w in it, 16 weights at its Gauss nodes say of the births
in it all that P_c can tell, however many panels they lie on: the integrals of B(w) times each Lagrange polynomial.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master._old.law import Law

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.intp]

_NODES = 16
_X, _W = legendre.leggauss(_NODES)
# Legendre polynomials at a place -> Lagrange polynomials of the nodes
_LAGRANGE = (np.arange(_NODES) + 0.5)[:, None] * legendre.legvander(_X, _NODES - 1).T * _W
_JUST = 1.0 - 1e-9  # of a panel of the law: one as wide is not narrower
_FEWER = 0.7  # intervals on a wider level, as a share


@dataclass(frozen=True)
class Level:
    """Intervals apart from each other, in order, with nodes and weights of shape (n, 16) for the births in each.

    `edges` are those of the law that sums over one interval must respect; the intervals of the next finer level that
    are in the k-th are those from first[k] to first[k + 1].
    """

    left: Array
    right: Array
    nodes: Array
    mass: Array
    edges: Array
    first: Whole

    def between(self, low: Array, high: Array) -> tuple[Whole, Whole]:
        """Pairs of rows and the intervals that reach into [low, high] of each row."""
        first = np.searchsorted(self.right, low, side="right")
        return ranges(np.arange(low.size), first, np.searchsorted(self.left, high, side="left"))

    def split(self, rows: Whole, at: Whole) -> tuple[Whole, Whole]:
        """Pairs of rows with the intervals `at` as pairs with the intervals of the next finer level."""
        return ranges(rows, self.first[at], self.first[at + 1])


def ranges(rows: Whole, first: Whole, last: Whole) -> tuple[Whole, Whole]:
    """Each of the rows with every number from `first` to before `last`, as pairs."""
    count = np.maximum(last - first, 0)
    place = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    return np.repeat(rows, count), np.repeat(first, count) + place


def bunched(law: Law, left: Array, right: Array, nodes: Array, mass: Array) -> list[Level]:
    """Levels from the panels [left, right] themselves to the widest intervals that are of use.

    nodes and mass, shape (n, 16), are the Gauss nodes of the panels and the births there with the nodes' weights.
    """
    finest = Level(left, right, nodes, mass, law.edges_for(0.125 * float((right - left).max())), np.empty(0, np.intp))
    levels = [finest]
    # a hard edge may lie within any interval: those that it cuts are looked at more closely
    widths = np.unique(np.diff(law.edges)) * _JUST
    wanted, narrowest = 0.0, float((right - left).min())
    for width in widths:
        if width < 2.0 * wanted:
            continue
        wanted = width
        if width <= narrowest:  # each panel is by itself
            continue
        below = levels[-1]
        cell = np.floor((below.left - left[0]) / width)
        first = np.append(np.flatnonzero(np.diff(cell, prepend=-1.0)), cell.size)
        if first.size - 1 <= _FEWER * cell.size:
            levels.append(_joined(law, below, first))
    return levels


def _joined(law: Law, below: Level, first: Whole) -> Level:
    left, right = below.left[first[:-1]], below.right[first[1:] - 1]
    group = np.repeat(np.arange(left.size), np.diff(first))
    begin, end = left[group, None], right[group, None]
    place = ((below.nodes - begin) - (end - below.nodes)) / (end - begin)
    moments = (legendre.legvander(place, _NODES - 1) * below.mass[..., None]).sum(axis=1)
    mass = np.add.reduceat(moments, first[:-1], axis=0) @ _LAGRANGE
    nodes = left[:, None] + 0.5 * (right - left)[:, None] * (_X + 1.0)
    return Level(left, right, nodes, mass, law.edges_for(0.25 * float((right - left).max())), first)
