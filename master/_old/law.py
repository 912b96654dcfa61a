"""Thresholds in units of their mean, so that everything beyond is free of scale."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from master._old.corners import bends, onset
from origins import Contacts, InputError, Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_LEAST = 1e-290  # of the mean: below it a density nears the largest numbers there are
_LOST = 1e-12  # weight that may lie there
_ULP = 1e-15
_SIGHT = 2.0  # width of the narrowest Gaussian that eight nodes see through, in panels
_SOME = 1e-3
_SAME = 1e-13
_DECILES = np.linspace(0.05, 0.95, 10)


class Law:
    """P_c(x) for x in units of <x_s>, up to stretch `top`: density, survival, panels, atoms.

    Or another law of `thresholds`, in units of `unit` (a length), such as that of the stretches at which contacts break
    at a temperature.

    `held` is the survival at the far end of the start; panels reach to 1e-18 of that, and `begins` is below all weight
    but 1e-19. `narrowest` is the width of a Gaussian as sharp as the sharpest tenth of the weight, `finest` that of
    one as sharp as any detail that the law's own panels tell, if they do, but at least half as wide; `jumps` and
    `jump_sizes` say where the density jumps and by how much, `poles` where above 0 it diverges.

    Raises InputError where the law has weight so near to 0 that floating point cannot hold its density.
    """

    def __init__(
        self, contacts: Contacts, top: float, thresholds: Thresholds | None = None, unit: float | None = None
    ) -> None:
        self.unit = contacts.mean_threshold if unit is None else unit
        own = thresholds is None or thresholds is contacts.thresholds
        self._thresholds = thresholds = contacts.thresholds if thresholds is None else thresholds
        self.knows_breakpoints = thresholds.knows_breakpoints
        lower, upper = thresholds.support()
        self.support = (lower / self.unit, upper / self.unit)
        furthest = max(-contacts.start.span[0], contacts.start.span[1])
        self.held = float(thresholds.sf(furthest)) if own and furthest > lower else 1.0
        self.top = min(top, self.support[1])
        self.breakpoints = thresholds.breakpoints / self.unit
        positions, self.atom_weights = thresholds.atoms
        self.atoms = positions / self.unit
        self.atomic = float(self.atom_weights.sum()) > 1.0 - 1e-14
        # those that never hold have no density
        lost = float(self.cdf(np.array([_LEAST]))[0] - self.atom_weights[self.atoms <= 0.0].sum())
        if lost > _LOST:
            raise InputError(
                f"thresholds: a weight of {lost:.2g} lies below {_LEAST:g} of the mean, where numbers end, as "
                f"P_c ~ x^{contacts.thresholds.onset_power:.3g}: no F(X), K*, F_s/F_k or X* is given; they are "
                "for an onset power of -0.95 or above"
            )
        self._scale = 1.0
        self.edges, self._hard = np.empty(0), np.empty(0, dtype=bool)
        self.narrowest = self.finest = 1.0
        self.jumps, self.jump_sizes, self.poles = np.empty(0), np.empty(0), np.empty(0)
        self.bends, self.bend_sizes = np.empty(0), np.empty(0)
        self.onset: tuple[float, float] | None = None
        self.begins, self._below = self.support[0], np.zeros(1)
        if not self.atomic:
            tail = max(1e-18 * (self.held or 1.0), 1e-300)
            self.edges = panel_edges(thresholds, self.top * self.unit, tail=tail) / self.unit
        if self.edges.size > 1:
            self._look_closely()
            points = self.points
            self.jumps, self.jump_sizes, self.poles = self._find_jumps(points)
            if self.declares_poles:
                self._scale = 1.0  # what the panels beside a pole lack is lacking there, not everywhere
            if self.atoms.size:  # bends and the onset matter where they fold with these
                self.bends, self.bend_sizes = bends(self.pdf, points, self.narrowest)
                self.onset = onset(self.pdf, self.support[0], self.narrowest)
                if self.onset and self.support[0] > 0.0 and self.onset[0] in (0, 1):
                    self.onset = None  # a jump or a bend

    @property
    def rough(self) -> bool:
        """Whether the density jumps, bends or diverges anywhere above 0."""
        return bool((self.breakpoints > 0.0).any() or self._hard.any())

    def what_helps(self, step: float) -> str:
        """What to do where lattices of this step, in units of `unit`, are the finest and do not answer."""
        spread = float(self._thresholds.std())
        if spread < step * self.unit:
            told = f"thresholds have a standard deviation of {spread:.1e}, too narrow to follow"
            return f"{told}: take identical, value = {float(self._thresholds.mean()):g}"
        short = "shorten the path or loosen the tolerance"
        if self.narrowest < step:
            width = self.narrowest * self.unit
            return f"many thresholds lie within {width:.1e}, too narrow to follow: take identical for these, {short}"
        return short

    def inner_edges(self, width: float) -> Array:
        """Edges between panels that sums over pieces as wide as `width` must respect: where the density bends, and
        those of narrower panels."""
        if self.edges.size < 3:
            return np.empty(0)
        panels = np.diff(self.edges)
        return self.edges[1:-1][(np.minimum(panels[1:], panels[:-1]) < width) | self._hard]

    def edges_for(self, step: float) -> Array:
        """Edges that sums over cells of width `step` must respect."""
        return np.concatenate([self.edges[:1], self.inner_edges(4.0 * step), self.edges[-1:]])

    def _look_closely(self) -> None:
        """What a few nodes on every panel and across every inner edge tell, all asked for at once."""
        inner, width = self.edges[1:-1], np.diff(self.edges)
        half = 0.5 * np.minimum(width[1:], width[:-1])
        # lopsided: symmetric nodes integrate a step in the middle exactly
        ends = inner + half * np.array([[-1.0], [0.0], [0.61]])
        if self.knows_breakpoints:
            ends = ends[:, :0]
        left, right = np.append(self.edges[:-1], ends[[0, 1, 0]]), np.append(self.edges[1:], ends[[1, 2, 2]])
        nodes, weights = gauss(left, right)
        masses = weights * self.pdf(nodes)
        weight = masses[: width.size].sum(axis=1)
        self._below = np.append(0.0, weight.cumsum())
        self._keep_all_weight(weight)
        # below the node before, thresholds weigh less than 1e-19
        first = int(np.searchsorted(np.cumsum(masses[: width.size]), 1e-19))
        self.begins = float(nodes[: width.size].ravel()[first - 1]) if first > 0 else float(self.edges[0])
        self.finest = self.narrowest = self._find_narrowest(nodes[: width.size].ravel(), masses[: width.size].ravel())
        if self._thresholds.panels is not None:
            detail = _SIGHT * float(width[weight > _SOME].min(initial=np.inf))
            self.finest = min(max(detail, 0.5 * self.narrowest), self.narrowest)
        declared = (np.abs(inner[:, None] - self.breakpoints) <= 4e-16 * self.breakpoints).any(axis=1)
        first, second, across = masses[width.size :].sum(axis=1).reshape(3, -1)
        bent = np.abs(first + second - across) > 1e-13 * across + 1e-15
        self._hard = np.asarray(declared if self.knows_breakpoints else declared | bent, dtype=bool)

    def _keep_all_weight(self, mass: Array) -> None:
        """Weight that floating point cannot tell from a point where the density diverges becomes an atom there; what
        little the rest lacks is made up, since a lost part in 1e16 grows with the square of the path."""
        left, right = self.edges[:-1], self.edges[1:]
        tight = right - left < 1e-10 * right
        found, whole = float(mass.sum()), 1.0 - float(self.atom_weights.sum())
        if self.support[1] > self.edges[-1] >= self.top * (1.0 - 1e-12):
            beyond = self.atom_weights[self.atoms > self.edges[-1]].sum()
            whole -= float(self.sf(self.edges[-1:])[0] - beyond)
        if tight.any():
            # an edge at an exact value is just below it: its weight is in the panel that begins there
            ends = self.edges
            for atom in self.atoms:
                ends = np.where(np.abs(ends - atom) < _SAME * atom, atom * (1.0 - _SAME), ends)
            lower, upper = self.cdf(ends), self.sf(ends)
            known = np.where(lower[:-1] < 0.5, np.diff(lower), -np.diff(upper))
            for atom, weight in zip(self.atoms, self.atom_weights, strict=True):
                known = known - weight * ((ends[:-1] < atom) & (atom <= ends[1:]))
            lost = (known - mass > 1e-10) & tight
            self.atoms = np.append(self.atoms, 0.5 * (left + right)[lost])
            self.atom_weights = np.append(self.atom_weights, (known - mass)[lost])
            whole = float(known[~lost].sum() + mass[lost].sum())
        if found > 0.0 and abs(whole / found - 1.0) < 1e-6:
            self._scale = whole / found

    def _find_narrowest(self, nodes: Array, masses: Array) -> float:
        """Width of a Gaussian as sharp as the sharpest of the tenths of the weight that the panels reach."""
        below = np.cumsum(masses) - 0.5 * masses
        within: list[tuple[float, float, float]] = []
        if self.atoms.size:  # a step where each sits
            order = np.argsort(self.atoms)
            atoms, steps = self.atoms[order], np.cumsum(self.atom_weights[order])
            beside = np.interp(atoms, nodes, below) + steps
            below = below + np.append(0.0, steps)[np.searchsorted(atoms, nodes)]
            below = np.concatenate([below, beside - self.atom_weights[order], beside])
            within = list(zip(atoms, beside - self.atom_weights[order], beside, strict=True))
            order = np.argsort(below, kind="stable")
            nodes, below = np.concatenate([nodes, atoms, atoms])[order], below[order]
        deciles = _DECILES[below[-1] >= _DECILES]
        found = np.interp(deciles, below, nodes)
        for atom, start, end in within:
            # the node beside it is not where its own weight begins
            found[(deciles > start - _ULP) & (deciles < end + _ULP)] = atom
        spread = np.diff(found)
        spread = spread[spread > 0.0]
        return float(spread.min()) / 0.25 if spread.size else 1.0

    @cached_property
    def points(self) -> Array:
        """Where above 0 the density may jump, bend or diverge."""
        points = self.breakpoints
        if not self.knows_breakpoints:
            points = np.concatenate([points, self._pinned()])
        return points[(points > 0.0) & (points < self.top * (1.0 + 1e-9))]

    @property
    def diverges(self) -> bool:
        """Whether the density does at any point above 0."""
        return bool(self.poles.size)

    @property
    def declares_poles(self) -> bool:
        """Whether the density diverges above 0, and at declared breakpoints alone."""
        return self.diverges and bool(np.isin(self.poles, self.breakpoints).all())

    @property
    def onset_order(self) -> float:
        """m + 1 where P_c begins as (x - a)^m; inf where it is flatter than any power."""
        return self._thresholds.onset_power + 1.0

    def _find_jumps(self, points: Array) -> tuple[Array, Array, Array]:
        """Those of the points where the density jumps by a finite amount, by how much, and those where it diverges."""
        if not points.size:
            return np.empty(0), np.empty(0), np.empty(0)
        # a point that only the panels know is known to the width of the narrowest
        near, far = (1e-12, 1e-10) if self.knows_breakpoints else (3e-9, 9e-9)
        offsets = points[:, None] * (1.0 + np.array([-far, -near, near, far]))
        below_far, below, above, above_far = self.pdf(offsets).T
        # a power onset or a diverging density is no jump: it still changes from one distance to the other
        size = np.maximum(np.maximum(below, above), 1e-300)
        steady = (np.abs(above - above_far) < 1e-6 * size) & (np.abs(below - below_far) < 1e-6 * size)
        sharp = steady & (np.abs(above - below) > 1e-7 * size)
        grows = np.maximum(above / 1.02 - above_far, below / 1.02 - below_far) > 0.0
        poles = points[~steady & grows & (size > 1e-3)]
        # panels crowd about a pole that the law declares, and are none themselves
        known = (np.abs(poles[:, None] - self.breakpoints) == 0.0).any(axis=1)
        return points[sharp], (above - below)[sharp], poles[known] if known.any() else poles

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
        return density if np.isfinite(density.sum()) else np.where(np.isfinite(density), density, 0.0)

    def weight_below(self, x: float, enough: float) -> float:
        """cdf(x), or what the panels alone tell: a bound at or below `enough`, or half of all weight or more."""
        if not self.atoms.size:
            panel = int(np.searchsorted(self.edges, x))
            if panel and self._below[panel - 1] > 0.5:
                return 0.5
            if panel < self.edges.size and self._below[panel] <= enough:
                return float(self._below[panel])
        return float(self.cdf(np.array([x]))[0])

    def weight_between(self, left: Array, right: Array) -> Array:
        """Weight from `left` to `right`, from the side that knows it better."""
        # an end of the support, rounded, is not to lie inside it, where an ulp may weigh much
        lower, upper = self.support[0] * (1.0 + _ULP), self.support[1] * (1.0 - _ULP)
        left, right = (np.where(x >= upper, np.inf, np.where(x <= lower, -np.inf, x)) for x in (left, right))
        below = self.cdf(right)
        return np.where(below < 0.5, below - self.cdf(left), self.sf(left) - self.sf(right))

    def sf(self, x: Array) -> Array:
        """Survival."""
        return self._thresholds.sf(x * self.unit)

    def cdf(self, x: Array) -> Array:
        """Probability of a threshold of at most x."""
        return self._thresholds.cdf(x * self.unit)
