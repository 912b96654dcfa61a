"""Measures on a uniform lattice: each is laid down so that every smooth function sees no difference.

A measure dmu(x) on x >= 0 becomes weights on the nodes 0, h, 2h, ...: the mass at x is shared among eight
neighbouring nodes by Lagrange weights, so all moments up to the seventh survive in every neighbourhood, atoms,
jumps and x^(1/3) onsets included. Convolutions of such weights are then exact to O(h^8) wherever the *result*
is smooth, however rough the factors are (semi-Lagrangian interpolation of odd degree; stable, Strang 1962).
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from origins.thresholds.quadrature import GAUSS_NODES, gauss

Array = npt.NDArray[np.float64]

STENCIL = 8
FEW = 6
_CENTRE = STENCIL // 2 - 1
_ROW = 512
_BLOCK = 1024  # cells at a time, so that what is made on the way stays in the cache
_OFFSETS = np.arange(STENCIL, dtype=float)
_BARYCENTRIC = np.array([1.0 / np.prod([k - j for j in range(STENCIL) if j != k]) for k in range(STENCIL)])


def lagrange(t: Array) -> Array:
    """Lagrange weights of the nodes 0..7 at t; shape t.shape + (8,)."""
    column = (-1,) + (1,) * t.ndim
    apart = t - _OFFSETS.reshape(column)
    # the seven other distances as pairs, fours and the one left, with the nodes outermost: rows as long as t
    pairs = apart[::2] * apart[1::2]
    low, high = pairs[0] * pairs[1], pairs[2] * pairs[3]
    rest = pairs[1] * high, pairs[0] * high, pairs[3] * low, pairs[2] * low
    out = np.empty_like(apart)
    for k in range(STENCIL):
        np.multiply(apart[k ^ 1], rest[k // 2], out=out[k])
    out *= _BARYCENTRIC.reshape(column)
    return np.moveaxis(out, 0, -1)


def lagrange_few(t: Array) -> Array:
    """Lagrange weights of the nodes 0..FEW - 1 alone at t; shape t.shape + (8,)."""
    out = np.zeros((*t.shape, STENCIL))
    for k in range(FEW):
        others = [j for j in range(FEW) if j != k]
        out[..., k] = np.prod([(t - j) / (k - j) for j in others], axis=0)
    return out


_CELL = lagrange(_CENTRE + GAUSS_NODES)  # a cell whose stencil is centred on it


def cells(edges: Array, step: float, size: int) -> tuple[Array, Array]:
    """Sub-intervals (left, right) of the pieces between `edges`, cut at every node of the lattice of `size` nodes."""
    if edges.size < 2:
        return np.empty(0), np.empty(0)
    bottom, top = edges.min(), min(edges.max(), (size - 1) * step)
    if not top > bottom:  # nothing lies on the lattice, whose cells may not even have numbers there
        return np.empty(0), np.empty(0)
    first, last = int(np.floor(bottom / step)), int(np.ceil(top / step))
    cuts = np.concatenate([step * np.arange(first, last + 1), edges])
    cuts.sort(kind="stable")
    cuts = cuts[(cuts >= bottom) & (cuts <= top)]
    left, right = cuts[:-1], cuts[1:]
    wide = right > left
    return (left, right) if wide.all() else (left[wide], right[wide])


def lay(
    densities: Callable[[Array], list[Array]], count: int, edges: Array, step: float, size: int, stable: bool = False
) -> Array:
    """Lay down `count` densities on the first `size` nodes; shape (count, size).

    densities maps positions of shape (n, 8) to a list of arrays of that shape; between `edges`, which may come in any
    order, each is smooth. Near 0 the stencil is one-sided, so nothing lands before the first node; where `stable`, it
    has six nodes there: eight let what follows from itself within a step grow, as backward differentiation of order 7
    does.
    """
    out = np.zeros((count, size + STENCIL))
    left, right = cells(edges, step, size)
    for start in range(0, left.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        _deposit(out, densities, left[block], right[block], step, stable)
    return out[:, :size]


def _deposit(
    out: Array,
    densities: Callable[[Array], list[Array]],
    left: Array,
    right: Array,
    step: float,
    stable: bool,
) -> None:
    """Add what lies in the sub-intervals [left, right], none of which holds a node inside."""
    nodes, weights = gauss(left, right)
    cell = (0.5 * (left + right) / step).astype(np.int64)
    first = np.maximum(cell - _CENTRE, 0)
    odd = np.flatnonzero((np.abs(right - left - step) > 1e-9 * step) | (cell < _CENTRE))
    mass = weights * np.stack(densities(nodes))
    shares = mass @ _CELL
    shares[:, odd] = np.einsum("dij,ijk->dik", mass[:, odd], lagrange(nodes[odd] / step - first[odd, None]))
    if stable:
        near = np.flatnonzero(cell < _CENTRE)
        shares[:, near] = np.einsum("dij,ijk->dik", mass[:, near], lagrange_few(nodes[near] / step))
    begin = int(first[0])
    at = (first[:, None] + np.arange(-begin, STENCIL - begin)).ravel()
    for row, share in zip(out, shares, strict=True):
        found = np.bincount(at, weights=share.ravel())
        row[begin : begin + found.size] += found


def deposit_atoms(positions: Array, weights: Array, step: float, size: int) -> Array:
    """Lay down exact values; one that sits on a node stays there whole."""
    out = np.zeros(size + STENCIL)
    if not positions.size:
        return out[:size]
    inside = (positions >= 0.0) & (positions < (size - 1) * step)
    first, shares = share_atoms(positions[inside] / step)
    shares *= weights[inside, None]
    for k in range(STENCIL):
        np.add.at(out, first + k, shares[:, k])
    return out[:size]


def share_atoms(positions: Array) -> tuple[npt.NDArray[np.int64], Array]:
    """First of the eight nodes that each position (in nodes) is shared among, and its shares."""
    nearest = np.rint(positions)
    positions = np.where(np.abs(positions - nearest) < 1e-9, nearest, positions)
    first = np.maximum(np.floor(positions).astype(np.int64) - _CENTRE, 0)
    return first, lagrange(positions - first)


def _integration_weights() -> Array:
    """Weights g_0..g_7 of the causal integral: (g * f)_j is the integral of f from 0 to jh, for f laid down."""
    return lay(lambda x: [np.ones(x.shape)], 1, np.array([0.0, 15.0]), 1.0, 16)[0, :STENCIL]


INTEGRATE = _integration_weights() - 1.0


def integrate(masses: Array) -> Array:
    """Integral up to each node of a function laid down on the lattice."""
    return _running_sum(masses) + np.convolve(masses, INTEGRATE)[: masses.size]


def _running_sum(values: Array) -> Array:
    """Cumulative sum in two levels: round-off grows with the square root of the length, not with the length."""
    rows = np.zeros((-(-values.size // _ROW), _ROW))
    rows.ravel()[: values.size] = values
    np.cumsum(rows, axis=1, out=rows)
    rows[1:] += rows[:-1, -1].cumsum()[:, None]
    return rows.ravel()[: values.size]
