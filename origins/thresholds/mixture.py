"""A weighted mixture of threshold laws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from origins.errors import finite_array, positive, refuse
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, RandomState, Thresholds
from origins.thresholds.scipy_laws import as_thresholds

_ROUNDING = 16.0 * np.finfo(float).eps  # relative error within which hazards count as equal


def mixture(components: Sequence[object], weights: npt.ArrayLike) -> Thresholds:
    """P_c = sum of weights[i] P_c,i.

    components : sequence of Thresholds or frozen scipy.stats distributions, all in one unit of length.
    weights : one number above zero per component, together 1 to within 1e-12.
    Raises InputError otherwise.
    """
    if isinstance(components, Thresholds) or not isinstance(components, Sequence) or not components:
        such = "such as [identical(0.9), identical(1.1)]"
        refuse("components", components, f"must be a list of thresholds, {such}")
    shares = finite_array("weights", weights)
    if shares.size != len(components):
        rule = f"must hold one weight for each of the {len(components)} components"
        refuse("weights", weights, rule)
    for i, share in enumerate(shares):
        positive(f"weights[{i}]", share)
    if abs((whole := float(shares.sum())) - 1.0) > 1e-12:
        refuse("weights", weights, f"must add up to 1, not {whole:.15g}; divide each by their sum")
    return Mixture([as_thresholds(component) for component in components], shares / whole)


class Mixture(Thresholds):
    """Sums of the components' functions, all positive, so that no accuracy is lost.

    Mixtures among the components are taken apart, so that none lies within another.

    parts : pairs of weight and law, the laws as they were given: those from samples are whole there, while
        `components` are what they are made of.
    """

    def __init__(self, components: Sequence[Thresholds], weights: Array) -> None:
        self.parts: tuple[tuple[float, Thresholds], ...] = ()
        self.components: tuple[Thresholds, ...] = ()
        self.weights = np.empty(0)
        for law, share in zip(components, weights.tolist(), strict=True):
            inner = law if isinstance(law, Mixture) else None
            self.parts += tuple(
                (share * w, part) for w, part in (inner.parts if inner else [(1.0, law)])
            )
            self.components += inner.components if inner else (law,)
            self.weights = np.append(self.weights, share * inner.weights if inner else share)
        ends = [component.support() for component in self.components]
        self._support = min(end[0] for end in ends), max(end[1] for end in ends)
        self.onset_power = min(
            c.onset_power for c in self.components if c.support()[0] == self._support[0]
        )
        self._breakpoints = np.unique(np.concatenate([c.breakpoints for c in self.components]))
        self.knows_breakpoints = all(component.knows_breakpoints for component in self.components)
        self.cut_weight = float(
            self.weights @ [component.cut_weight for component in self.components]
        )
        positions = np.concatenate([c.atoms[0] for c in self.components])
        shares = np.concatenate(
            [w * c.atoms[1] for c, w in zip(self.components, self.weights, strict=True)]
        )
        atoms, place = np.unique(positions, return_inverse=True)
        self._atoms = atoms, np.bincount(place, shares, atoms.size).astype(float)
        if self._support[0] < self._support[1]:
            self._lowest_atom = float(self._atoms[1][atoms == self._support[0]].sum())

    def support(self) -> tuple[float, float]:
        return self._support

    @property
    def breakpoints(self) -> Array:
        return self._breakpoints

    @property
    def atoms(self) -> tuple[Array, Array]:
        return self._atoms

    def _sum(self, values: list[Array]) -> Array:
        return np.asarray(sum(w * value for w, value in zip(self.weights, values, strict=True)))

    def _log_sum(self, values: list[Array]) -> Array:
        highest = np.maximum.reduce(values)
        level = np.where(np.isfinite(highest), highest, 0.0)
        with np.errstate(divide="ignore"):
            return level + np.log(self._sum([np.exp(value - level) for value in values]))

    def _pdf(self, x: Array) -> Array:
        return self._sum([c.pdf(x) for c in self.components])

    def _logpdf(self, x: Array) -> Array:
        return self._log_sum([c.logpdf(x) for c in self.components])

    def _cdf(self, x: Array) -> Array:
        return np.minimum(self._sum([c.cdf(x) for c in self.components]), 1.0)

    def _sf(self, x: Array) -> Array:
        return np.minimum(self._sum([c.sf(x) for c in self.components]), 1.0)

    def _logsf(self, x: Array) -> Array:
        return self._near_one(x, self._log_sum([c.logsf(x) for c in self.components]))

    def _ppf(self, q: Array) -> Array:
        return self._between([c.ppf(q) for c in self.components], -np.log1p(-q))

    def _isf(self, q: Array) -> Array:
        return self._between([c.isf(q) for c in self.components], -np.log(q))

    def _between(self, quantiles: list[Array], hazard: Array) -> Array:
        """Thresholds at which -log of the survival is `hazard`, among the components' own quantiles."""
        goal = hazard.ravel()
        # quantiles within an atom's weight are its value, and those at a gap the gap's left end
        marks = self.breakpoints
        before, after = (-self.logsf(x) for x in (np.nextafter(marks, 0.0), marks))
        first = np.minimum(np.searchsorted(after, goal * (1.0 - _ROUNDING)), marks.size - 1)
        here = (goal >= before[first] * (1.0 - _ROUNDING)) & (
            goal <= after[first] * (1.0 + _ROUNDING)
        )
        out, left = marks[first], ~here
        # the components' quantiles are good to their last bits only
        low = np.minimum.reduce(quantiles).ravel()[left] * (1.0 - 1e-14)
        high = np.maximum.reduce(quantiles).ravel()[left] * (1.0 + 1e-14)
        out[left] = invert_hazard(self, goal[left], low, high, 0.5 * (low + high))
        return out.reshape(hazard.shape)

    def _moment(self, n: float) -> float:
        return float(self.weights @ [c._moment(n) for c in self.components])

    def _variance(self) -> float:
        mean = self.mean()
        return float(
            self.weights @ [c._variance() + (c.mean() - mean) ** 2 for c in self.components]
        )

    def rvs(
        self, size: int | tuple[int, ...] | None = None, random_state: RandomState = None
    ) -> Array:
        """Independent thresholds, each from a component drawn by weight."""
        generator = np.random.default_rng(random_state)
        out = np.empty(() if size is None else size)
        chosen = generator.choice(self.weights.size, size=out.shape, p=self.weights)
        for i, component in enumerate(self.components):
            here = chosen == i
            out[here] = component.rvs(int(here.sum()), generator)
        return out[()]
