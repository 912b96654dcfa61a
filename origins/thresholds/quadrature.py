"""Panels on which a threshold density is smooth, found by bisection, and Gauss-Legendre sums over them.

The panels resolve the law at all its scales: jumps are on edges, an x^(1/3) onset is approached by
halving, and a spike that all nodes miss is detected because the panel's weight differs from the cdf's.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

NODES = 8
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(NODES)
GAUSS_NODES = 0.5 * (GAUSS_NODES + 1.0)  # on (0, 1)
GAUSS_WEIGHTS = 0.5 * GAUSS_WEIGHTS

_SEEDS = np.array([1e-15, 1e-9, 1e-5, 1e-3, 0.03, 0.25, 0.5])
_TAIL = 1e-18  # survival at which panels end
_EPSILON = float(np.finfo(float).eps)


def gauss(left: Array, right: Array) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on each [left, right]; both of shape left.shape + (8,)."""
    width = (right - left)[..., None]
    return left[..., None] + width * GAUSS_NODES, width * GAUSS_WEIGHTS


def panel_edges(thresholds: Any, upper: float = np.inf, tail: float = _TAIL) -> Array:
    """Edges of panels on each of which 8 nodes integrate P_c(x) and x P_c(x) to 1e-15 of the whole.

    Covers the support up to `upper`, and an infinite tail to survival `tail`. Atoms are ignored.
    """
    lower, end = thresholds.support()
    far = _TAIL * 10.0 ** -np.arange(0.0, np.log10(_TAIL / tail), 5.0)
    places = thresholds.isf(np.concatenate([1.0 - _SEEDS, _SEEDS, far, [tail]]))
    top = min(upper, end if np.isfinite(end) else float(places[-1]))
    if not top > lower:
        return np.empty(0)
    edges = np.unique(np.concatenate([[lower, top], places[:-1], thresholds.breakpoints]))
    edges = edges[(edges >= lower) & (edges <= top)]
    left, right = edges[:-1], edges[1:]
    scale = float(places[_SEEDS.size - 1]) or 1.0
    done, found = np.zeros(2), [edges]
    for _ in range(64):
        middle = 0.5 * (left + right)
        # all three in one call, since for many laws calls take longer than evaluations
        ends = np.stack([left, left, middle]), np.stack([right, middle, right])
        whole, first, second = _mass(thresholds, *ends, scale)
        # distant weight makes <x> large beside the median; halving does not reduce the nodes' rounding
        level = np.maximum(done + whole.sum(axis=1), 1.0)[:, None]
        rounding = _EPSILON * np.abs(whole) * right / (right - left)
        missed = np.abs(_cdf_mass(thresholds, left, right) - whole[0]) > 1e-12 + 64.0 * rounding[0]
        open_ = (np.abs(first + second - whole) > 1e-15 * level + rounding).any(axis=0) | missed
        open_ &= (middle > left) & (middle < right)
        if not 0 < open_.sum() <= 8192:  # only a cdf that contradicts its density leaves more
            break
        done += whole[:, ~open_].sum(axis=1)
        left, middle, right = left[open_], middle[open_], right[open_]
        found.append(middle)
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
    return np.unique(np.concatenate(found))


def _mass(thresholds: Any, left: Array, right: Array, scale: float) -> Array:
    """Weight, and first moment divided by `scale`, of panels, shape (m, 2, n) for ends of shape (m, n)."""
    nodes, weights = gauss(left, right)
    weights *= finite_density(thresholds, nodes)
    return np.stack([weights.sum(-1), np.einsum("...i,...i->...", weights, nodes) / scale], axis=-2)


def finite_density(thresholds: Any, nodes: Array) -> Array:
    """P_c, with 0 where a node was rounded onto a point at which it diverges."""
    density = thresholds.pdf(nodes)
    return np.where(np.isfinite(density), density, 0.0)


def _cdf_mass(thresholds: Any, left: Array, right: Array) -> Array:
    """Weight between left and right, without atoms."""
    ends = np.stack([left, right])
    below, above = thresholds.cdf(ends), thresholds.sf(ends)
    mass = np.where(below[0] < 0.5, below[1] - below[0], above[0] - above[1])
    for position, weight in zip(*thresholds.atoms, strict=True):
        mass = mass - weight * ((left < position) & (position <= right))
    return mass
