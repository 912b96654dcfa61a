"""Thresholds in units of their mean, so that everything beyond is free of scale."""

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_DECILES = np.linspace(0.05, 0.95, 10)


class Law:
    """P_c(x) for x in units of <x_s>, up to stretch `top`: density, survival, panels, atoms.

    Panels reach to survival 1e-18 of `deepest`. `narrowest` is the width of a Gaussian as sharp as the sharpest tenth
    of the weight; `jumps` and `jump_sizes` say where the density jumps and by how much, `diverges` whether it does at
    any point above 0.
    """

    def __init__(self, contacts: Contacts, top: float, deepest: float = 1.0) -> None:
        self.unit = contacts.mean_threshold
        self._thresholds = contacts.thresholds
        self.knows_breakpoints = contacts.thresholds.knows_breakpoints
        lower, upper = contacts.thresholds.support()
        self.support = (lower / self.unit, upper / self.unit)
        self.top = min(top, self.support[1])
        self.breakpoints = contacts.thresholds.breakpoints / self.unit
        positions, self.atom_weights = contacts.thresholds.atoms
        self.atoms = positions / self.unit
        self.atomic = float(self.atom_weights.sum()) > 1.0 - 1e-14
        self._scale = 1.0
        self.edges, self.narrowest, self._hard = np.empty(0), 1.0, np.empty(0, dtype=bool)
        self.jumps, self.jump_sizes, self.diverges = np.empty(0), np.empty(0), False
        if not self.atomic:
            tail = max(1e-18 * deepest, 1e-300)
            self.edges = panel_edges(contacts.thresholds, self.top * self.unit, tail=tail) / self.unit
            spread = np.diff(contacts.thresholds.ppf(_DECILES)) / self.unit
            spread = spread[spread > 0.0]
            self.narrowest = float(spread.min()) / 0.25 if spread.size else 1.0
        if self.edges.size > 1:
            self._keep_all_weight()
            self._hard = self._find_hard()
            self.jumps, self.jump_sizes, self.diverges = self._find_jumps()

    @property
    def rough(self) -> bool:
        """Whether the density jumps, bends or diverges anywhere above 0."""
        return bool((self.breakpoints > 0.0).any() or self._hard.any())

    def edges_for(self, step: float) -> Array:
        """Edges that sums over cells of width `step` must respect: a smooth stretch of wide panels needs none."""
        if self.edges.size < 3:
            return self.edges
        width = np.diff(self.edges)
        narrow = np.minimum(width[1:], width[:-1]) < 4.0 * step
        return np.concatenate([self.edges[:1], self.edges[1:-1][narrow | self._hard], self.edges[-1:]])

    def _keep_all_weight(self) -> None:
        """Weight that floating point cannot tell from a point where the density diverges becomes an atom there; what
        little the rest lacks is made up, since a lost part in 1e16 grows with the square of the path."""
        left, right = self.edges[:-1], self.edges[1:]
        nodes, weights = gauss(left, right)
        mass = (weights * self.pdf(nodes)).sum(axis=1)
        lower, upper = self.cdf(self.edges), self.sf(self.edges)
        known = np.where(lower[:-1] < 0.5, np.diff(lower), -np.diff(upper))
        for atom, weight in zip(self.atoms, self.atom_weights, strict=True):
            known = known - weight * ((left < atom) & (atom <= right))
        lost = (known - mass > 1e-10) & (right - left < 1e-10 * right)
        if lost.any():
            self.atoms = np.append(self.atoms, 0.5 * (left + right)[lost])
            self.atom_weights = np.append(self.atom_weights, (known - mass)[lost])
        whole, found = float(known[~lost].sum() + mass[lost].sum()), float(mass.sum())
        if found > 0.0 and abs(whole / found - 1.0) < 1e-6:
            self._scale = whole / found

    def _find_hard(self) -> npt.NDArray[np.bool_]:
        """Which inner edges the density bends or jumps at, shape (n - 2,): 8 nodes across them miss something."""
        inner, width = self.edges[1:-1], np.diff(self.edges)
        declared = (np.abs(inner[:, None] - self.breakpoints) <= 4e-16 * self.breakpoints).any(axis=1)
        if self.knows_breakpoints:
            return np.asarray(declared, dtype=bool)
        half = 0.5 * np.minimum(width[1:], width[:-1])
        # lopsided: symmetric nodes integrate a step in the middle exactly
        ends = inner + half * np.array([[-1.0], [0.0], [0.61]])
        nodes, weights = gauss(ends[[0, 1, 0]], ends[[1, 2, 2]])
        first, second, across = (weights * self.pdf(nodes)).sum(axis=-1)
        bent = np.abs(first + second - across) > 1e-13 * across + 1e-15
        return np.asarray(declared | bent, dtype=bool)

    def _find_jumps(self) -> tuple[Array, Array, bool]:
        """Points above 0 where the density jumps by a finite amount, by how much, and whether it diverges at one."""
        points = self.breakpoints
        if not self.knows_breakpoints:
            points = np.concatenate([points, self._pinned()])
        points = points[(points > 0.0) & (points < self.top * (1.0 + 1e-9))]
        if not points.size:
            return np.empty(0), np.empty(0), False
        # a point that only the panels know is known to the width of the narrowest
        near, far = (1e-12, 1e-10) if self.knows_breakpoints else (3e-9, 9e-9)
        offsets = points[:, None] * (1.0 + np.array([-far, -near, near, far]))
        below_far, below, above, above_far = self.pdf(offsets).T
        # a power onset or a diverging density is no jump: it still changes from one distance to the other
        size = np.maximum(np.maximum(below, above), 1e-300)
        steady = (np.abs(above - above_far) < 1e-6 * size) & (np.abs(below - below_far) < 1e-6 * size)
        sharp = steady & (np.abs(above - below) > 1e-7 * size)
        grows = np.maximum(above / 1.02 - above_far, below / 1.02 - below_far) > 0.0
        diverges = (~steady & grows & (size > 1e-3)).any()
        return points[sharp], (above - below)[sharp], bool(diverges)

    def _pinned(self) -> Array:
        """Points that panels close in on or meet at, and that the law does not declare."""
        width = np.diff(self.edges)
        close = np.flatnonzero((width < 1e-8) & (self.edges[:-1] > 1e-3))
        middle = 0.5 * (self.edges[:-1] + self.edges[1:])
        # of the panels around one point the narrowest holds it
        groups = np.split(close, np.flatnonzero(np.diff(middle[close]) > 1e-6) + 1) if close.size else []
        found = [middle[group[width[group].argmin()]] for group in groups]
        candidates = np.concatenate([self.edges[1:-1][self._hard], found])
        candidates = np.sort(candidates)
        candidates = candidates[np.diff(candidates, prepend=-1.0) > 1e-7]
        return candidates[(np.abs(candidates[:, None] - self.breakpoints) > 1e-7).all(axis=1)]

    def pdf(self, x: Array) -> Array:
        """Density of the continuous part."""
        density = self._thresholds.pdf(x * self.unit) * (self.unit * self._scale)
        # the density may diverge at an end of the support, where no weight sits
        return np.where(np.isfinite(density), density, 0.0)

    def sf(self, x: Array) -> Array:
        """Survival."""
        return self._thresholds.sf(x * self.unit)

    def cdf(self, x: Array) -> Array:
        """Probability of a threshold of at most x."""
        return self._thresholds.cdf(x * self.unit)
