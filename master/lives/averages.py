"""Averages over the stretches at birth, and other integrals over many ranges at once.

Pieces of a range are halved until a polynomial fits the integrand on each.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.motion.motion import History
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Gauss nodes of a piece; the integrand is evaluated at BESIDE of its length from its ends, too,
# because the nodes would miss a steep change right at an end.
SIZE, BESIDE = 14, 1e-9
# Allowed error of the polynomial at the ends of its piece, over that of its last coefficients.
ENDS = 3.0
# Most halvings of a piece; and the least length of a piece, relative to its position, at which its
# nodes are still distinct in floating point.
HALVINGS, NARROWEST = 40, 4e-15
# One range in so many is summed again on halved pieces, to measure the error. A prime, so that all
# columns of a history are measured in turn.
CHECKED = 17
# Pieces evaluated together, so that their nodes stay in the processor's cache.
TOGETHER = 512

_NODES, _WEIGHTS = legendre.leggauss(SIZE)
_SERIES = np.linalg.inv(legendre.legvander(_NODES, SIZE - 1)).T
_AT = np.concatenate([[BESIDE], 0.5 * (_NODES + 1.0), [1.0 - BESIDE]])
# matrix from values to the last two coefficients and to the polynomial's errors at both ends
_TAIL = np.zeros((SIZE + 2, 4))
_TAIL[1:-1, :2] = _SERIES[:, -2:]
_TAIL[1:-1, 2:] = _SERIES @ legendre.legvander(np.array([-1.0, 1.0]), SIZE - 1).T / ENDS
_TAIL[[0, -1], [2, 3]] = -1.0 / ENDS
_RULE = np.concatenate([[0.0], 0.5 * _WEIGHTS, [0.0]])

# Values of the integrands of ranges (n,) at places (n, k), each row within one piece; (functions, n, k)
Integrand = Callable[[Rows, Array], Array]


class Pieces(NamedTuple):
    """Pieces of ranges, from low to high; arrays of shape (n,)."""

    owner: Rows
    low: Array
    high: Array

    def pick(self, which: npt.NDArray[np.bool_]) -> Pieces:
        """Some of the pieces."""
        return Pieces(self.owner[which], self.low[which], self.high[which])

    def halves(self) -> Pieces:
        """Both halves of all pieces."""
        middle = 0.5 * (self.low + self.high)
        low, high = np.append(self.low, middle), np.append(middle, self.high)
        return Pieces(np.tile(self.owner, 2), low, high)


class Integrals(NamedTuple):
    """value : of each function over each range, array of shape (functions, ranges); missed : the
    largest error of each function's, as measured on some of the ranges, array of shape (functions,);
    pieces : those that resolve the integrand."""

    value: Array
    missed: Array
    pieces: Pieces


def integrals(
    integrand: Integrand,
    pieces: Pieces,
    ranges: int,
    accuracy: Array | float,
    relative: bool = False,
) -> Integrals:
    """Integrals of functions over ranges, of which each is cut into pieces.

    integrand : smooth inside pieces; the first of its functions decides which pieces are halved
    accuracy : last coefficients, as contributions to the integral, below which a piece is not halved,
        for all ranges or for each;
        the error of the Gauss sum is then about their square, or 1e-3 of them near an onset
    relative : whether accuracy and error are relative to each range's integral of the last function
    """
    done: list[Pieces] = []
    total, scale = np.zeros((1, ranges)), np.ones(ranges)
    for halving in range(HALVINGS + 1):
        values = _values(integrand, pieces)
        sums = _summed(values @ _RULE, pieces, ranges)
        if relative:
            scale = np.maximum(np.abs(total + sums)[-1], np.finfo(float).tiny)
        limit = accuracy * scale
        rough = np.abs(values[0] @ _TAIL).max(axis=1, initial=0.0) > limit[pieces.owner]
        size = np.maximum(np.abs(pieces.low), np.abs(pieces.high))
        rough &= (pieces.high - pieces.low > NARROWEST * size) & (halving < HALVINGS)
        total = total + _summed(values[:, ~rough] @ _RULE, pieces.pick(~rough), ranges)
        done.append(pieces.pick(~rough))
        if not rough.any():
            break
        pieces = pieces.pick(rough).halves()
    pieces = Pieces(*(np.concatenate(parts) for parts in zip(*done, strict=True)))
    looked = np.arange(ranges) % CHECKED == ranges // 2 % CHECKED
    halves = pieces.pick(looked[pieces.owner]).halves()
    again = _summed(_values(integrand, halves) @ _RULE, halves, ranges)
    missed = np.abs((again - total)[:, looked]) / scale[looked]
    return Integrals(total, missed.max(axis=1, initial=0.0), pieces)


def _values(integrand: Integrand, pieces: Pieces) -> Array:
    """The functions, times the pieces' lengths, at all places; shape (functions, n, SIZE + 2)."""
    length = (pieces.high - pieces.low)[:, None]
    at, found = pieces.low[:, None] + length * _AT, []
    for begin in range(0, max(length.size, 1), TOGETHER):
        some = slice(begin, begin + TOGETHER)
        found.append(integrand(pieces.owner[some], at[some]) * length[some])
    return np.concatenate(found, axis=1)


def _summed(sums: Array, pieces: Pieces, ranges: int) -> Array:
    """Sums over the pieces of each range; shape (functions, ranges)."""
    return np.stack([np.bincount(pieces.owner, row, minlength=ranges) for row in sums])


class Moves(NamedTuple):
    """Motion of the slider between birth and a later moment, for many pairs of these two.

    now, high, low : arrays of shape (n,), the slider's displacement, its largest and smallest value
    """

    now: Array
    high: Array
    low: Array

    @classmethod
    def of(cls, history: History) -> Moves:
        """The moves of all rows and columns of a history, flattened."""
        parts = np.broadcast_arrays(history.now, history.high, history.low)
        return cls(*(part.ravel() for part in parts))

    def largest(self, pair: Rows, born: Array) -> Array:
        """Largest |x| of contacts born at `born`; shape (n,) or (n, k) as `born`."""
        columns = (slice(None),) + (None,) * (born.ndim - 1)
        high, low = self.high[pair][columns], self.low[pair][columns]
        return np.maximum(np.abs(born), np.maximum(born + high, -(born + low)))


def averaged(
    law: Start,
    moves: Moves,
    reach: float,
    bends: Array,
    left: Integrand,
    resolved: float,
    pieces: int,
) -> Integrals:
    """Share and force averaged over the law's stretches, shape (2, pairs), and their errors.

    Pieces of the law end where x is 0, and where the largest |x| changes sides or meets a bend.

    reach : length: no contact beyond it holds
    bends : array of shape (n,), the largest |x| at which the survival has a bend
    left : share and force of pairs, by their numbers (n,), born at stretches of shape (n, k), of
        which each row lies within one smooth piece; (2, n, k)
    resolved : last coefficients below which pieces are not halved
    pieces : first number of pieces of the law's span
    """
    # cut at the reach, beyond which no contact holds, as each piece is judged by its middle
    bends = np.append(bends, reach)
    first, last = max(law.span[0], -reach), min(law.span[1], reach)
    even = np.linspace(first, last, pieces + 1)
    fixed = np.concatenate([even, law.breakpoints, np.zeros(1), bends, -bends])
    now, high, low = (part[:, None] for part in moves)
    moving = [-now, -high, -low, -0.5 * high, -0.5 * low, -0.5 * (high + low)]
    cuts = [np.tile(fixed, (now.size, 1)), *moving, bends - high, -bends - low]
    edges = np.sort(np.clip(np.concatenate(cuts, axis=1), first, last), axis=1)
    # pieces narrower than 1e-13 of the span are left out
    pair, piece = np.nonzero(np.diff(edges, axis=1) > 1e-13 * (last - first))
    found = Pieces(pair, edges[pair, piece], edges[pair, piece + 1])
    found = found.pick(moves.largest(pair, 0.5 * (found.low + found.high)) < reach)
    kept = law.cdf(reach) - law.cdf(-reach)

    def weighed(pair: Rows, born: Array) -> Array:
        return left(pair, born) * (finite_density(law, born) / kept)

    return integrals(weighed, found, now.size, resolved)


class StretchRule(NamedTuple):
    """Stretches that represent a law of stretches, and their weights.

    stretch : array of shape (n,), lengths
    weight : array of shape (n,), of sum 1
    """

    stretch: Array
    weight: Array


def stretch_rule(born: Start, most: float, count: int) -> StretchRule:
    """The Gauss rule of `count` nodes for the stretches of `born` below `most` in size.

    It averages polynomials of degree 2 count - 1 over the law exactly. It has one node where all
    contacts have the same stretch.
    """
    if born.is_single:
        return StretchRule(np.array([born.mean()]), np.ones(1))
    low, high = max(born.span[0], -most), min(born.span[1], most)
    edges = np.append(np.linspace(low, high, 9), born.breakpoints)
    edges = np.unique(np.clip(edges, low, high))
    whole = Pieces(np.zeros(edges.size - 1, dtype=int), edges[:-1], edges[1:])
    fine = integrals(lambda _, x: finite_density(born, x)[None], whole, 1, 1e-12).pieces
    half = 0.5 * (fine.high - fine.low)[:, None]
    nodes = (fine.low[:, None] + half * (_NODES + 1.0)).ravel()
    weights = (half * _WEIGHTS).ravel() * finite_density(born, nodes)
    nodes, weights = nodes[weights > 0.0], weights[weights > 0.0] / weights.sum()
    if nodes.size <= count:
        return StretchRule(nodes, weights)
    # orthogonal polynomials on the nodes: their Jacobi matrix has the rule's nodes as eigenvalues
    middle, scale = 0.5 * (nodes.min() + nodes.max()), 0.5 * np.ptp(nodes)
    at, root = (nodes - middle) / scale, np.sqrt(weights)
    basis = np.linalg.qr(root[:, None] * legendre.legvander(at, count - 1))[0]
    values, vectors = np.linalg.eigh(basis.T @ (at[:, None] * basis))
    return StretchRule(middle + scale * values, (root @ basis @ vectors) ** 2)
