"""Panels on which a threshold density is smooth, found by bisection, and Gauss-Legendre sums over them.

The panels follow the law at every scale it has: jumps sit on edges, an x^(1/3) onset is approached by
halving, and a spike that every node misses betrays itself because the panel's mass differs from the cdf's.
"""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from origins.thresholds import Thresholds

Array = npt.NDArray[np.float64]

NODES = 8
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(NODES)
GAUSS_NODES = 0.5 * (GAUSS_NODES + 1.0)  # on (0, 1)
GAUSS_WEIGHTS = 0.5 * GAUSS_WEIGHTS

_SEEDS = np.array([1e-15, 1e-9, 1e-5, 1e-3, 0.03, 0.25, 0.5])
_TAIL = 1e-18
_DEPTH = 64


def gauss(left: Array, right: Array) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on each [left, right]; both of shape left.shape + (8,)."""
    width = (right - left)[..., None]
    return left[..., None] + width * GAUSS_NODES, width * GAUSS_WEIGHTS


def panel_edges(thresholds: "Thresholds", upper: float = np.inf, accuracy: float = 1e-15) -> Array:
    """Edges of panels on each of which 8 nodes integrate P_c(x) and x P_c(x) to `accuracy` of the whole.

    Covers the support up to `upper`, and an infinite tail to survival 1e-18. Atoms are not looked at.
    """
    lower, end = thresholds.support()
    seeds = [thresholds.ppf(_SEEDS), thresholds.isf(_SEEDS), thresholds.breakpoints]
    top = min(upper, end if np.isfinite(end) else float(thresholds.isf(_TAIL)))
    if not top > lower:
        return np.empty(0)
    edges = np.unique(np.concatenate([[lower, top], *seeds]))
    edges = edges[(edges >= lower) & (edges <= top)]
    left, right = edges[:-1], edges[1:]
    scale = float(thresholds.ppf(0.5)) or 1.0
    whole = _mass(thresholds, left, right, scale)
    known = _cdf_mass(thresholds, left, right)
    atoms, weights = thresholds.atoms
    for position, weight in zip(atoms, weights, strict=True):
        known = known - weight * ((left < position) & (position <= right))
    finished_left, finished_right = [], []
    for _ in range(_DEPTH):
        middle = 0.5 * (left + right)
        first, second = _mass(thresholds, left, middle, scale), _mass(thresholds, middle, right, scale)
        step = np.abs(first + second - whole).max(axis=0)
        missed = np.abs(known - whole[0]) > 1e-9
        open_ = (step > accuracy) | missed
        open_ &= (middle > left) & (middle < right)
        finished_left.append(left[~open_])
        finished_right.append(right[~open_])
        if not open_.any():
            break
        left, right = (
            np.concatenate([left[open_], middle[open_]]),
            np.concatenate([middle[open_], right[open_]]),
        )
        whole = np.concatenate([first[:, open_], second[:, open_]], axis=1)
        # the cdf is asked again only where it told something: elsewhere the halves agree with the whole
        known = np.where(np.tile(missed[open_], 2), _cdf_mass(thresholds, left, right), whole[0])
    else:
        finished_left.append(left)
        finished_right.append(right)
    return np.unique(np.concatenate(finished_left + finished_right))


def _mass(thresholds: "Thresholds", left: Array, right: Array, scale: float) -> Array:
    nodes, weights = gauss(left, right)
    density = thresholds.pdf(nodes)
    density = np.where(np.isfinite(density), density, 0.0)
    return np.stack([(density * weights).sum(-1), (density * weights * nodes).sum(-1) / scale])


def _cdf_mass(thresholds: "Thresholds", left: Array, right: Array) -> Array:
    low = thresholds.cdf(right) - thresholds.cdf(left)
    high = thresholds.sf(left) - thresholds.sf(right)
    return np.where(thresholds.cdf(left) < 0.5, low, high)


def moment(thresholds: "Thresholds", n: int, centre: float = 0.0) -> float:
    """<(x_s - centre)^n> by panels, atoms added; for laws whose tail falls faster than any power."""
    edges = panel_edges(thresholds)
    atoms, weights = thresholds.atoms
    total = float((weights * (atoms - centre) ** n).sum())
    if edges.size:
        nodes, factors = gauss(edges[:-1], edges[1:])
        total += float((factors * (nodes - centre) ** n * thresholds.pdf(nodes)).sum())
    return total
