"""Measures on a uniform lattice: each is laid down so that every smooth function sees no difference.

A measure dmu(x) on x >= 0 becomes weights on the nodes 0, h, 2h, ...: the mass at x is shared among eight
neighbouring nodes by Lagrange weights, so all moments up to the seventh survive in every neighbourhood, atoms,
jumps and x^(1/3) onsets included. Convolutions of such weights are then exact to O(h^8) wherever the *result*
is smooth, however rough the factors are (semi-Lagrangian interpolation of odd degree; stable, Strang 1962).
"""

import numpy as np
import numpy.typing as npt

from origins.quadrature import GAUSS_NODES, gauss

Array = npt.NDArray[np.float64]

STENCIL = 8
_CENTRE = STENCIL // 2 - 1
_ROW = 512
_OFFSETS = np.arange(STENCIL, dtype=float)
_BARYCENTRIC = np.array([1.0 / np.prod([k - j for j in range(STENCIL) if j != k]) for k in range(STENCIL)])


def lagrange(t: Array) -> Array:
    """Lagrange weights of the nodes 0..7 at t; shape t.shape + (8,)."""
    difference = t[..., None] - _OFFSETS
    below, above = np.ones_like(difference), np.ones_like(difference)
    np.cumprod(difference[..., :-1], axis=-1, out=below[..., 1:])
    above[..., :-1] = np.cumprod(difference[..., :0:-1], axis=-1)[..., ::-1]
    return _BARYCENTRIC * below * above


_CELL = lagrange(_CENTRE + GAUSS_NODES)  # a cell whose stencil is centred on it


def cells(edges: Array, step: float, size: int) -> tuple[Array, Array]:
    """Sub-intervals (left, right) of the pieces between `edges`, cut at every node of the lattice of `size` nodes."""
    if edges.size < 2:
        return np.empty(0), np.empty(0)
    top = min(edges[-1], (size - 1) * step)
    first, last = int(np.floor(edges[0] / step)), int(np.ceil(top / step))
    nodes = step * np.arange(first, last + 1)
    cuts = np.unique(np.concatenate([edges, nodes]))
    cuts = cuts[(cuts >= edges[0]) & (cuts <= top)]
    return cuts[:-1], cuts[1:]


def deposit(left: Array, right: Array, densities: list[Array], step: float, size: int) -> list[Array]:
    """Lay down densities known at the 8 Gauss nodes of each [left, right] (times their weights), shape (n, 8).

    No sub-interval may hold a node of the lattice inside. Near 0 the stencil is one-sided, so nothing lands
    before the first node.
    """
    cell = np.floor(0.5 * (left + right) / step).astype(np.int64)
    first = np.maximum(cell - _CENTRE, 0)
    whole = (np.abs(right - left - step) < 1e-9 * step) & (first == cell - _CENTRE)
    stack = np.stack(densities)
    shares = stack @ _CELL
    odd = np.flatnonzero(~whole)
    if odd.size:
        nodes, _ = gauss(left[odd], right[odd])
        shares[:, odd] = np.einsum("dij,ijk->dik", stack[:, odd], lagrange(nodes / step - first[odd, None]))
    at = (first[:, None] + np.arange(STENCIL)).ravel()
    sums = (np.bincount(at, weights=share.ravel(), minlength=size + STENCIL) for share in shares)
    return [total[:size].astype(float, copy=False) for total in sums]


def deposit_atoms(positions: Array, weights: Array, step: float, size: int) -> Array:
    """Lay down exact values; one that sits on a node stays there whole."""
    out = np.zeros(size + STENCIL)
    if not positions.size:
        return out[:size]
    inside = (positions >= 0.0) & (positions < (size - 1) * step)
    positions, weights = positions[inside] / step, weights[inside]
    nearest = np.rint(positions)
    positions = np.where(np.abs(positions - nearest) < 1e-9, nearest, positions)
    first = np.maximum(np.floor(positions).astype(np.int64) - _CENTRE, 0)
    shares = lagrange(positions - first) * weights[:, None]
    for k in range(STENCIL):
        np.add.at(out, first + k, shares[:, k])
    return out[:size]


def _integration_weights() -> Array:
    """Weights g_0..g_14 of the causal integral: (g * f)_j is the integral of f from 0 to jh, for f deposited."""
    edges = np.arange(16.0)
    left, right = edges[:-1], edges[1:]
    _, weights = gauss(left, right)
    (out,) = deposit(left, right, [weights], 1.0, 16)
    return out[: STENCIL]


INTEGRATE = _integration_weights() - 1.0


def integrate(masses: Array) -> Array:
    """Integral up to each node of a function laid down on the lattice."""
    out = _running_sum(masses)
    for k in range(STENCIL):
        out[k:] += INTEGRATE[k] * masses[: masses.size - k]
    return out


def _running_sum(values: Array) -> Array:
    """Cumulative sum in two levels: round-off grows with the square root of the length, not with the length."""
    rows = np.pad(values, (0, -values.size % _ROW)).reshape(-1, _ROW).cumsum(axis=1)
    rows[1:] += rows[:-1, -1].cumsum()[:, None]
    return rows.ravel()[: values.size]
