"""Weights of thresholds on Gauss nodes, also beside points where P_c diverges: there the cdf tells them.

So near to a point the rounding of x is felt in the density, and as much as 1e-8 of the weight has no node at all. The
weight between two edges is known nevertheless, and from panel to panel it adds up to all there is.
"""

import numpy as np
import numpy.typing as npt

from origins import Thresholds
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]

_NEAR = 1e-3  # of a point at which P_c diverges: panels whose weight the cdf tells
_ROUNDED = 1e-14


class NodeWeights:
    """P_c dξ of `law` on the nodes of panels."""

    def __init__(self, law: Thresholds) -> None:
        self._law = law
        points = np.append(law.breakpoints, law.support())
        points = np.unique(points[np.isfinite(points) & (points > 0.0)])
        self._poles = points[~np.isfinite(law.pdf(points))]

    def __call__(self, nodes: Array, weights: Array, left: Array, right: Array) -> Array:
        """On panels from `left` to `right`, of shape (n,), with nodes and weights of shape (n, k)."""
        mass = weights * finite_density(self._law, nodes)
        if not self._poles.size:
            return mass
        apart = np.maximum(left[:, None] - self._poles, self._poles - right[:, None])
        near = (apart < _NEAR * self._poles).any(axis=1)
        if near.any():
            left, right = self._snapped(left[near]), self._snapped(right[near])
            below = self._law.cdf(right)
            known = np.where(below < 0.5, below - self._law.cdf(left), self._law.sf(left) - self._law.sf(right))
            for position, weight in zip(*self._law.atoms, strict=True):
                known = known - weight * ((left < position) & (position <= right))
            found = mass[near].sum(axis=1)
            share = np.where(found[:, None] > 0.0, mass[near], weights[near])
            total = share.sum(axis=1)  # nothing where an edge is met by the next
            mass[near] = share * np.divide(known, total, out=np.zeros_like(total), where=total > 0.0)[:, None]
        return mass

    def _snapped(self, ends: Array) -> Array:
        """The ends, those at a point at which P_c diverges but for rounding put there: an ulp may weigh much."""
        for pole in self._poles:
            ends = np.where(np.abs(ends - pole) < _ROUNDED * pole, pole, ends)
        return ends
