"""Integrals over many ranges at once: pieces are halved until a polynomial fits the integrand on each."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Gauss nodes of a piece, and the distance from its ends, over its length, at which the integrand is
# evaluated too, because the nodes would miss a steep change right at an end.
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
    largest error of each function's, as measured on some of the ranges, array of shape (functions,)."""

    value: Array
    missed: Array


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
    total, all_pieces, scale = _halved(integrand, pieces, ranges, accuracy, relative)
    looked = np.arange(ranges) % CHECKED == ranges // 2 % CHECKED
    halves = all_pieces.pick(looked[all_pieces.owner]).halves()
    again = _summed(_values(integrand, halves) @ _RULE, halves, ranges)
    missed = np.abs((again - total)[:, looked]) / scale[looked]
    return Integrals(total, missed.max(axis=1, initial=0.0))


class Nodes(NamedTuple):
    """Places at which a function is summed, and its values there times their weights; shape (n,)."""

    at: Array
    weight: Array


def nodes_of(integrand: Integrand, pieces: Pieces, accuracy: float) -> Nodes:
    """The nodes at which `integrals` sums one range, given in pieces."""
    pieces = _halved(integrand, pieces, 1, accuracy, relative=False).pieces
    length = (pieces.high - pieces.low)[:, None]
    at, weight = pieces.low[:, None] + length * _AT, _values(integrand, pieces)[0] * _RULE
    return Nodes(at[:, 1:-1].ravel(), weight[:, 1:-1].ravel())


class _Halved(NamedTuple):
    """Integrals (functions, ranges), the pieces that resolve them, and the unit of each range's error (ranges,)."""

    total: Array
    pieces: Pieces
    scale: Array


def _halved(
    integrand: Integrand, pieces: Pieces, ranges: int, accuracy: Array | float, relative: bool
) -> _Halved:
    """The pieces, halved until a polynomial fits the integrand on each."""
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
    joined = Pieces(*(np.concatenate(parts) for parts in zip(*done, strict=True)))
    return _Halved(total, joined, scale)


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
