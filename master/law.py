"""Thresholds in units of their mean, so that everything beyond is free of scale."""

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.quadrature import panel_edges

Array = npt.NDArray[np.float64]

_DECILES = np.linspace(0.05, 0.95, 10)


class Law:
    """P_c(x) for x in units of <x_s>, up to stretch `top`: density, survival, panels, atoms.

    `narrowest` is the width of a Gaussian as sharp as the sharpest tenth of the weight.
    """

    def __init__(self, contacts: Contacts, top: float) -> None:
        self.unit = contacts.mean_threshold
        self._thresholds = contacts.thresholds
        lower, upper = contacts.thresholds.support()
        self.support = (lower / self.unit, upper / self.unit)
        self.top = min(top, self.support[1])
        self.breakpoints = contacts.thresholds.breakpoints / self.unit
        positions, weights = contacts.thresholds.atoms
        self.atoms = positions / self.unit
        self.atom_weights = weights
        self.atomic = float(weights.sum()) > 1.0 - 1e-14
        if self.atomic:
            self.edges = np.empty(0)
            self.narrowest = 1.0
        else:
            self.edges = panel_edges(contacts.thresholds, self.top * self.unit) / self.unit
            spread = np.diff(contacts.thresholds.ppf(_DECILES)) / self.unit
            spread = spread[spread > 0.0]
            self.narrowest = float(spread.min()) / 0.25 if spread.size else 1.0

        self.jumps, self.jump_sizes = self._find_jumps()

    def edges_for(self, step: float) -> Array:
        """Edges that sums over cells of width `step` must respect: a smooth stretch of wide panels needs none."""
        if self.edges.size < 3:
            return self.edges
        width = np.diff(self.edges)
        narrow = np.minimum(width[1:], width[:-1]) < 4.0 * step
        inner = self.edges[1:-1]
        hard = (np.abs(inner[:, None] - self.breakpoints) < 1e-12).any(axis=1)
        return np.concatenate([self.edges[:1], inner[narrow | hard], self.edges[-1:]])

    def _find_jumps(self) -> tuple[Array, Array]:
        """Points above 0 where the density jumps by a finite amount, and by how much."""
        points = self.breakpoints[(self.breakpoints > 0.0) & (self.breakpoints < self.top * (1.0 + 1e-9))]
        if self.atomic or not points.size:
            return np.empty(0), np.empty(0)
        near, far = 1e-12, 1e-10
        offsets = points[:, None] * (1.0 + np.array([-far, -near, near, far]))
        below_far, below, above, above_far = self.pdf(offsets).T
        # a power onset or a diverging density is no jump: it still changes from one distance to the other
        size = np.maximum(np.maximum(below, above), 1e-300)
        steady = (np.abs(above - above_far) < 1e-6 * size) & (np.abs(below - below_far) < 1e-6 * size)
        sharp = steady & (np.abs(above - below) > 1e-7 * size)
        return points[sharp], (above - below)[sharp]

    def pdf(self, x: Array) -> Array:
        """Density of the continuous part."""
        density = self._thresholds.pdf(x * self.unit) * self.unit
        # the density may diverge at an end of the support, where no weight sits
        return np.where(np.isfinite(density), density, 0.0)

    def sf(self, x: Array) -> Array:
        """Survival."""
        return self._thresholds.sf(x * self.unit)

    def cdf(self, x: Array) -> Array:
        """Probability of a threshold of at most x."""
        return self._thresholds.cdf(x * self.unit)
