"""Sums over the stretches at which contacts start or form again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.lives.halving import Pieces, nodes_of
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]


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
    nodes, weights = nodes_of(lambda _, x: finite_density(born, x)[None], whole, 1e-12)
    kept = weights > 0.0
    nodes, weights = nodes[kept], weights[kept] / weights[kept].sum()
    if nodes.size <= count:
        return StretchRule(nodes, weights)
    # orthogonal polynomials on the nodes: their Jacobi matrix has the rule's nodes as eigenvalues
    middle, scale = 0.5 * (nodes.min() + nodes.max()), 0.5 * np.ptp(nodes)
    at, root = (nodes - middle) / scale, np.sqrt(weights)
    basis = np.linalg.qr(root[:, None] * legendre.legvander(at, count - 1))[0]
    values, vectors = np.linalg.eigh(basis.T @ (at[:, None] * basis))
    return StretchRule(middle + scale * values, (root @ basis @ vectors) ** 2)
