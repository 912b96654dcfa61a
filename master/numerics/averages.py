"""Integrals over many ranges at once: pieces are halved until a polynomial fits the integrand on each."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.numerics import polynomials
from master.numerics.polynomials import Pieces, Rows
from origins.start import Start
from origins.thresholds.law import Array
from origins.thresholds.quadrature import finite_density

# Gauss nodes of a piece; the integrand is evaluated at BESIDE of its length from its ends, too,
# because the nodes would miss a steep change right at an end.
SIZE, BESIDE = 14, 1e-9
# Allowed error of the polynomial at the ends of its piece, divided by that of its last coefficients.
ENDS = 3.0
# Most halvings of a piece; and the least length of a piece, relative to its position, at which its
# nodes are still distinct in floating point.
HALVINGS, NARROWEST = 40, 4e-15
# One range in so many is summed once more on halved pieces, to measure the error. A prime, so that all
# columns of a history are measured in turn.
CHECKED = 17
# Pieces evaluated together, so that their nodes stay in the processor's cache.
PIECES_TOGETHER = 1024

_GAUSS = polynomials.gauss(SIZE)
_AT = np.concatenate([[BESIDE], _GAUSS.nodes, [1.0 - BESIDE]])
# matrix from values to the last two coefficients and to the polynomial's errors at both ends
_TAIL = np.zeros((SIZE + 2, 4))
_TAIL[1:-1] = np.append(_GAUSS.series[:, -2:], _GAUSS.at(_AT[[0, -1]]) / ENDS, axis=1)
_TAIL[[0, -1], [2, 3]] = -1.0 / ENDS
_RULE = np.concatenate([[0.0], _GAUSS.series[:, 0], [0.0]])
# Half of the places of a piece, and the matrix from values there to those at all, for a function that takes long and is
# smoother than the integrand made of it.
HALF_OF_NODES = [0, 2, 4, 6, 9, 11, 13, 15]
FROM_HALF = polynomials.Points(2.0 * _AT[HALF_OF_NODES] - 1.0).at(_AT)

# Values of the integrands of ranges (n,) at places (n, k), each row within one piece; (functions, n, k)
Integrand = Callable[[Rows, Array], Array]


def _sums(pieces: Pieces, integrand: Integrand) -> tuple[Array, Array]:
    """Integral of each function over each piece, shape (functions, n), and the largest of the last
    coefficients and errors at ends of the first function, shape (n,), as contributions to it."""
    sums, tails = [], []
    for begin in range(0, max(pieces.owner.size, 1), PIECES_TOGETHER):
        some = slice(begin, begin + PIECES_TOGETHER)
        owner, low, high = pieces.owner[some], pieces.low[some], pieces.high[some]
        values = integrand(owner, low[:, None] + (high - low)[:, None] * _AT)
        sums.append(values @ _RULE * (high - low))
        tails.append(np.abs(_TAIL.T @ values[0].T).max(axis=0) * (high - low))
    return np.concatenate(sums, axis=1), np.concatenate(tails)


class Integrals(NamedTuple):
    """value : of each function over each range, array of shape (functions, ranges); missed : errors of
    the same shape, 0 on ranges where they are not measured; pieces : those that resolve the integrand."""

    value: Array
    missed: Array
    pieces: Pieces


def integrals(
    integrand: Integrand,
    pieces: Pieces,
    ranges: int,
    accuracy: Array | float,
    relative: bool = False,
    checked: int = CHECKED,
) -> Integrals:
    """Integrals of functions over ranges, of which each is cut into pieces.

    integrand : smooth inside pieces; the first of its functions decides which pieces are halved
    accuracy : last coefficients, as contributions to the integral, below which a piece is not halved, for all
        ranges or each; the Gauss sum's error is then about their square, or 1e-3 of them near an onset
    relative : whether the accuracy counts in units of the last function's integral
    checked : the error of one range in so many is measured; 0: of none
    """
    done: list[Pieces] = []
    total, limit = np.zeros((1, ranges)), np.broadcast_to(accuracy, ranges)

    def summed(owner: Rows, sums: Array) -> Array:
        return np.stack([np.bincount(owner, row, minlength=ranges) for row in sums])

    for halving in range(HALVINGS + 1):
        sums, tails = _sums(pieces, integrand)
        if relative:  # nodes of the first pieces may miss nearly all of the integral
            limit = accuracy * (total[-1] + summed(pieces.owner, sums[-1:])[0])
        size = np.maximum(np.abs(pieces.low), np.abs(pieces.high))
        rough = (tails > limit[pieces.owner]) & (pieces.high - pieces.low > NARROWEST * size)
        rough &= halving < HALVINGS
        done.append(pieces.pick(~rough))
        total = total + summed(done[-1].owner, sums[:, ~rough])
        if not rough.any():
            break
        pieces = pieces.pick(rough).halves()
    pieces = Pieces(*(np.concatenate(parts) for parts in zip(*done, strict=True)))
    if not checked:
        return Integrals(total, np.zeros(total.shape), pieces)
    measured = np.arange(ranges) % checked == ranges // 2 % checked
    halves = pieces.pick(measured[pieces.owner]).halves()
    finer = summed(halves.owner, _sums(halves, integrand)[0])
    return Integrals(total, np.where(measured, np.abs(finer - total), 0.0), pieces)


def integrals_above(
    integrand: Integrand,
    least: Array,
    ends: Array,
    counted: npt.NDArray[np.bool_] | bool,
    accuracy: Array | float,
    relative: bool = False,
    checked: int = CHECKED,
) -> Integrals:
    """Integrals of functions over y above `least`, where they may be series in (y - least)^(1/2).

    That root is the variable of integration; the accuracy is that of the first function without its
    weight, which is 0 at `least`.

    least : array of shape (n,)
    ends : array of shape (k + 1,) or (n, k + 1), sorted, between which functions are smooth
    counted : of shape (n, k), where they count
    """
    roots = np.sqrt(np.maximum(ends, least[:, None]) - least[:, None])
    row, piece = np.nonzero(counted & (np.diff(roots, axis=1) > 0.0))

    def of_root(row: Rows, root: Array) -> Array:
        values = 2.0 * integrand(row, least[row, None] + root * root)
        return np.concatenate([values[:1] * root[:, -1:], values * root])

    pieces = Pieces(row, roots[row, piece], roots[row, piece + 1])
    value, missed, fine = integrals(of_root, pieces, least.size, accuracy, relative, checked)
    return Integrals(value[1:], missed[1:], fine)


class StretchNodes(NamedTuple):
    """Stretches (lengths) that represent a law of stretches, and their weights, of sum 1; shape (n,)."""

    stretch: Array
    weight: Array


def stretch_nodes(born: Start, most: float, count: int) -> StretchNodes:
    """The `count` Gauss nodes for the stretches of `born` below `most` in size. It averages polynomials of
    degree 2 count - 1 over the law exactly. It has one node where all contacts have the same stretch."""
    if born.is_single:
        return StretchNodes(np.array([born.mean()]), np.ones(1))
    low, high = np.clip(born.span, -most, most)
    pieces = np.linspace(low, high, max(9, count // 4))  # some 3 count nodes
    edges = np.clip(np.append(pieces, born.breakpoints), low, high)
    whole = Pieces.between(edges[None])
    # pieces on which the density is a polynomial to 1e-12: finer ones would resolve its rounding
    fine = integrals(lambda _, x: finite_density(born, x)[None], whole, 1, 1e-12).pieces
    width = (fine.high - fine.low)[:, None]
    nodes = (fine.low[:, None] + width * _GAUSS.nodes).ravel()
    weights = (width * _GAUSS.series[:, 0]).ravel() * finite_density(born, nodes)
    nodes, weights = nodes[weights > 0.0], weights[weights > 0.0] / weights.sum()
    # orthogonal polynomials on the nodes: their Jacobi matrix has these nodes as eigenvalues
    middle, scale = 0.5 * (nodes.min() + nodes.max()), 0.5 * np.ptp(nodes)
    at, root = (nodes - middle) / scale, np.sqrt(weights)
    basis = np.linalg.qr(root[:, None] * legendre.legvander(at, min(count, nodes.size) - 1))[0]
    values, vectors = np.linalg.eigh(basis.T @ (at[:, None] * basis))
    return StretchNodes(middle + scale * values, (root @ basis @ vectors) ** 2)
