"""A weighted mixture of threshold laws."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from origins.errors import finite_array, positive, refuse
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, RandomState, Thresholds
from origins.thresholds.scipy_laws import as_thresholds

_ROUNDING = 16.0 * np.finfo(float).eps  # of a hazard that is met to its last bits


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
    # mixtures are taken apart, so that none lies within another
    laws: list[Thresholds] = []
    inner: list[float] = []
    parts: list[tuple[float, Thresholds]] = []
    for component, share in zip(components, shares / whole, strict=True):
        law = as_thresholds(component)
        flat = law if isinstance(law, Mixture) else Mixture([law], np.ones(1))
        laws += flat.components
        inner += list(share * flat.weights)
        parts += [(share * one, part) for one, part in flat.parts]
    found = Mixture(laws, np.array(inner))
    found.parts = tuple(parts)
    return found


class Mixture(Thresholds):
    """Sums of the components' functions, all positive, so that no accuracy is lost.

    parts : pairs of weight and law, the laws as they were given: those from samples are whole there, while
        `components` are what they are made of.
    """

    def __init__(self, components: Sequence[Thresholds], weights: Array) -> None:
        self.components = tuple(components)
        self.weights = weights
        self.parts: tuple[tuple[float, Thresholds], ...] = tuple(
            zip(weights.tolist(), self.components, strict=True)
        )
        ends = [component.support() for component in self.components]
        self._support = min(end[0] for end in ends), max(end[1] for end in ends)
        self.onset_power = min(
            c.onset_power for c in self.components if c.support()[0] == self._support[0]
        )
        self._breakpoints = np.unique(np.concatenate([c.breakpoints for c in self.components]))
        self.knows_breakpoints = all(component.knows_breakpoints for component in self.components)
        self.cut_weight = float(weights @ [component.cut_weight for component in self.components])
        positions = np.concatenate([c.atoms[0] for c in self.components])
        shares = np.concatenate(
            [w * c.atoms[1] for c, w in zip(self.components, weights, strict=True)]
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
        total = self.weights[0] * values[0]
        for share, value in zip(self.weights[1:], values[1:], strict=True):
            total += share * value
        return total

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

    @cached_property
    def _steps(self) -> list[tuple[float, float, float]]:
        """(position, hazard before, hazard after) of each atom and of each end of a component, where a gap may begin:
        there a whole interval of q, or one q to its last bits, belongs to one threshold."""
        ends = np.array([end for c in self.components for end in c.support() if np.isfinite(end)])
        x = np.unique(np.concatenate([ends, self._atoms[0]]))
        weight = np.array([self._atoms[1][self._atoms[0] == position].sum() for position in x])
        cdf = np.maximum(self.cdf(x) - weight, 0.0)
        with np.errstate(divide="ignore"):
            before = np.where(
                cdf < 0.5, -np.log1p(-np.minimum(cdf, 0.5)), -np.log(self.sf(x) + weight)
            )
        return list(
            zip(x.tolist(), before.tolist(), (-np.asarray(self.logsf(x))).tolist(), strict=True)
        )

    def _ppf(self, q: Array) -> Array:
        return self._between([c.ppf(q) for c in self.components], -np.log1p(-q))

    def _isf(self, q: Array) -> Array:
        return self._between([c.isf(q) for c in self.components], -np.log(q))

    def _between(self, quantiles: list[Array], hazard: Array) -> Array:
        """Thresholds at which -log of the survival is `hazard`, among the components' own quantiles."""
        goal = hazard.ravel()
        # the components' quantiles are good to their last bits only
        low = np.minimum.reduce(quantiles).ravel() * (1.0 - 1e-14)
        high = np.maximum.reduce(quantiles).ravel() * (1.0 + 1e-14)
        out = np.empty(goal.shape)
        open_ = np.ones(goal.shape, dtype=bool)
        # the left end of a gap is the threshold of its q
        for position, before, after in reversed(self._steps):
            here = (goal >= before * (1.0 - _ROUNDING)) & (goal <= after * (1.0 + _ROUNDING))
            out[here], open_[here] = position, False
        low, high = low[open_], high[open_]
        out[open_] = invert_hazard(self, goal[open_], low, high, 0.5 * (low + high))
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
