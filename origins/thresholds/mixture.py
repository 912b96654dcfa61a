"""A weighted mixture of threshold laws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from origins.errors import finite_array, positive, refuse
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, RandomState, Thresholds
from origins.thresholds.scipy_laws import as_thresholds

_ROUNDING = 4.0 * np.finfo(float).eps


def mixture(components: Sequence[object], weights: npt.ArrayLike) -> Thresholds:
    """P_c = sum of weights[i] P_c,i.

    components : sequence of Thresholds or frozen scipy.stats distributions, all in one unit of length.
    weights : one number above zero per component, together 1 to within 1e-12.
    Raises InputError otherwise.
    """
    if isinstance(components, Thresholds) or not isinstance(components, Sequence) or len(components) == 0:
        refuse("components", components, "must be a list of thresholds, such as [identical(0.9), identical(1.1)]")
    shares = finite_array("weights", weights)
    if shares.size != len(components):
        refuse("weights", weights, f"must hold one weight for each of the {len(components)} components")
    for i, share in enumerate(shares):
        positive(f"weights[{i}]", share)
    if abs(float(shares.sum()) - 1.0) > 1e-12:
        refuse("weights", weights, f"must add up to 1, not {float(shares.sum()):.15g}; divide each by their sum")
    laws: list[Thresholds] = []
    inner: list[float] = []
    parts: list[tuple[float, Thresholds]] = []
    for component, share in zip(components, shares / shares.sum(), strict=True):
        law = as_thresholds(component)
        laws += law.components if isinstance(law, Mixture) else [law]
        inner += list(share * law.weights) if isinstance(law, Mixture) else [share]
        parts += [(share * one, part) for one, part in law.parts] if isinstance(law, Mixture) else [(share, law)]
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
        self.parts: tuple[tuple[float, Thresholds], ...] = tuple(zip(weights.tolist(), self.components, strict=True))
        ends = [component.support() for component in self.components]
        self._support = min(end[0] for end in ends), max(end[1] for end in ends)
        self.onset_power = min(c.onset_power for c in self.components if c.support()[0] == self._support[0])
        self._breakpoints = np.unique(np.concatenate([c.breakpoints for c in self.components]))
        self.knows_breakpoints = all(component.knows_breakpoints for component in self.components)
        self.cut_weight = float(weights @ [component.cut_weight for component in self.components])
        self._atoms = self._collect_atoms()
        if self._support[0] < self._support[1]:
            self._lowest_atom = float(self._atoms[1][self._atoms[0] == self._support[0]].sum())
        self._steps = self._find_steps()
        self._order = np.argsort([float(component.ppf(0.5)) for component in self.components])

    def _collect_atoms(self) -> tuple[Array, Array]:
        pairs = [(c.atoms[0], w * c.atoms[1]) for c, w in zip(self.components, self.weights, strict=True)]
        positions, place = np.unique(np.concatenate([p for p, _ in pairs]), return_inverse=True)
        shares = np.concatenate([w for _, w in pairs])
        weights = np.zeros(positions.size)
        np.add.at(weights, place, shares)
        return positions, weights

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
        out = self._log_sum([c.logsf(x) for c in self.components])
        near = out > -0.5
        if near.any():
            out[near] = np.log1p(-self._cdf(x[near]))
        return out

    def _ppf(self, q: Array) -> Array:
        own = np.stack([c.ppf(q) for c in self.components])
        left, right = own.min(axis=0), own.max(axis=0)
        # a component alone holds weight * cdf <= q at the quantile, which bounds it from above
        for c, w in zip(self.components, self.weights, strict=True):
            right = np.where(q < w, np.minimum(right, c.ppf(np.minimum(q / w, 1.0))), right)
        return self._solve(q, -np.log1p(-q), left, right, self._side_by_side(q, self._order, False), 1)

    def _isf(self, q: Array) -> Array:
        own = np.stack([c.isf(q) for c in self.components])
        left, right = own.min(axis=0), own.max(axis=0)
        for c, w in zip(self.components, self.weights, strict=True):
            left = np.where(q < w, np.maximum(left, c.isf(np.minimum(q / w, 1.0))), left)
        return self._solve(q, -np.log(q), left, right, self._side_by_side(q, self._order[::-1], True), 2)

    def _side_by_side(self, q: Array, order: npt.NDArray[np.intp], from_above: bool) -> Array:
        """Quantiles as if no component reached into the next: a guess, the better the further apart they are."""
        ends = np.cumsum(self.weights[order])
        turn = np.minimum(np.searchsorted(ends, q), ends.size - 1)
        out = np.empty(q.shape)
        for k, index in enumerate(order):
            here, component, weight = turn == k, self.components[index], self.weights[index]
            near = np.clip((q[here] - (ends[k] - weight)) / weight, 0.0, 1.0)
            far = np.clip((ends[k] - q[here]) / weight, 0.0, 1.0)
            first, second = (component.isf, component.ppf) if from_above else (component.ppf, component.isf)
            out[here] = np.where(near < far, first(near), second(far))
        return out

    def _solve(self, q: Array, hazard: Array, left: Array, right: Array, guess: Array, column: int) -> Array:
        out, known = np.empty(q.shape), np.zeros(q.shape, dtype=bool)
        # whole intervals of q belong to one value at an atom, one q to the left end of a gap
        for row in self._steps:
            here = (q >= row[column] * (1.0 - _ROUNDING)) & (q <= (row[column] + row[3]) * (1.0 + _ROUNDING))
            out[here] = row[0]
            known |= here
        open_ = ~known
        # the components' quantiles are good to their last bits only
        ends = left[open_] * (1.0 - 1e-14), right[open_] * (1.0 + 1e-14)
        out[open_] = invert_hazard(self, hazard[open_], *ends, guess[open_])
        return out

    def _find_steps(self) -> list[tuple[float, float, float, float]]:
        """(position, cdf before, survival after, weight) of each atom, then of each gap, its weight 0."""
        steps = []
        for position, weight in zip(*self._atoms, strict=True):
            before = self._sum([c.cdf(position) - c.atoms[1][c.atoms[0] == position].sum() for c in self.components])
            steps.append((position, before, self._sum([c.sf(position) for c in self.components]), weight))
        reach = self._support[0]
        for low, high in sorted(c.support() for c in self.components):
            if low > reach:
                here = self._sum([c.cdf(reach) for c in self.components])
                steps.append((reach, here, self._sum([c.sf(reach) for c in self.components]), 0.0))
            reach = max(reach, high)
        return [(float(a), float(b), float(c), float(d)) for a, b, c, d in steps]

    def _moment(self, n: int) -> float:
        return float(self.weights @ [c.moment(n) for c in self.components])

    def _variance(self) -> float:
        mean = self.mean()
        return float(self.weights @ [c._variance() + (c.mean() - mean) ** 2 for c in self.components])

    def rvs(self, size: int | tuple[int, ...] | None = None, random_state: RandomState = None) -> Array:
        """Independent thresholds, each from a component drawn by weight."""
        generator = np.random.default_rng(random_state)
        out = np.empty(() if size is None else size)
        chosen = generator.choice(self.weights.size, size=out.shape, p=self.weights)
        for i, component in enumerate(self.components):
            here = chosen == i
            out[here] = component.rvs(int(here.sum()), generator)
        return out[()]
