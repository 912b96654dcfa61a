"""A weighted mixture of threshold laws."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.special import logsumexp

from origins.errors import finite_array, positive, refuse
from origins.frozen import as_thresholds
from origins.inversion import invert_hazard
from origins.thresholds import Array, RandomState, Thresholds


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
    return Mixture([as_thresholds(component) for component in components], shares / shares.sum())


class Mixture(Thresholds):
    """Sums of the components' functions, all positive, so that no accuracy is lost."""

    def __init__(self, components: Sequence[Thresholds], weights: Array) -> None:
        self.components = tuple(components)
        self.weights = weights
        ends = [component.support() for component in self.components]
        self._support = min(end[0] for end in ends), max(end[1] for end in ends)
        self.onset_power = min(c.onset_power for c in self.components if c.support()[0] == self._support[0])
        self._breakpoints = np.unique(np.concatenate([c.breakpoints for c in self.components]))
        self._atoms = self._collect_atoms()
        if self._support[0] < self._support[1]:
            self._lowest_atom = float(self._atoms[1][self._atoms[0] == self._support[0]].sum())

    def _collect_atoms(self) -> tuple[Array, Array]:
        pairs = [(c.atoms[0], w * c.atoms[1]) for c, w in zip(self.components, self.weights, strict=True)]
        positions, place = np.unique(np.concatenate([p for p, _ in pairs]), return_inverse=True)
        shares = np.concatenate([w for _, w in pairs])
        return positions, np.bincount(place, weights=shares, minlength=positions.size)

    def support(self) -> tuple[float, float]:
        return self._support

    @property
    def breakpoints(self) -> Array:
        return self._breakpoints

    @property
    def atoms(self) -> tuple[Array, Array]:
        return self._atoms

    def _sum(self, values: list[Array]) -> Array:
        return np.tensordot(self.weights, np.stack(values), axes=1)

    def _log_sum(self, values: list[Array]) -> Array:
        shares = np.log(self.weights).reshape((-1,) + (1,) * values[0].ndim)
        with np.errstate(divide="ignore", invalid="ignore"):
            return logsumexp(np.stack(values) + shares, axis=0)

    def _pdf(self, x: Array) -> Array:
        return self._sum([c.pdf(x) for c in self.components])

    def _logpdf(self, x: Array) -> Array:
        return self._log_sum([c.logpdf(x) for c in self.components])

    def _cdf(self, x: Array) -> Array:
        return self._sum([c.cdf(x) for c in self.components])

    def _sf(self, x: Array) -> Array:
        return self._sum([c.sf(x) for c in self.components])

    def _logsf(self, x: Array) -> Array:
        out = self._log_sum([c.logsf(x) for c in self.components])
        near = out > -0.5
        if near.any():
            out[near] = np.log1p(-self._cdf(x[near]))
        return out

    def _ppf(self, q: Array) -> Array:
        own = np.stack([c.ppf(q) for c in self.components])
        # at x the component alone holds weight * cdf <= q, so x is at most its quantile of q / weight
        scaled = np.stack([c.ppf(np.minimum(q / w, 1.0)) for c, w in zip(self.components, self.weights, strict=True)])
        left, right = own.min(axis=0), np.minimum(own.max(axis=0), scaled.min(axis=0))
        return self._solve(-np.log1p(-q), left, right, right)

    def _isf(self, q: Array) -> Array:
        own = np.stack([c.isf(q) for c in self.components])
        scaled = np.stack([c.isf(np.minimum(q / w, 1.0)) for c, w in zip(self.components, self.weights, strict=True)])
        left, right = np.maximum(own.min(axis=0), scaled.max(axis=0)), own.max(axis=0)
        return self._solve(-np.log(q), left, right, left)

    def _solve(self, hazard: Array, left: Array, right: Array, guess: Array) -> Array:
        # the component's quantiles are good to their last bits only
        left, right = left * (1.0 - 1e-14), right * (1.0 + 1e-14)
        flat = [a.ravel() for a in (hazard, left, right, guess)]
        return invert_hazard(self, *flat).reshape(hazard.shape)

    def _moment(self, n: int) -> float:
        return float(self.weights @ [c.moment(n) for c in self.components])

    def rvs(self, size: int | tuple[int, ...] | None = None, random_state: RandomState = None) -> Array:
        """Independent thresholds, each from a component drawn by weight."""
        generator = np.random.default_rng(random_state)
        out = np.empty(() if size is None else size)
        chosen = generator.choice(self.weights.size, size=out.shape, p=self.weights)
        for i, component in enumerate(self.components):
            here = chosen == i
            out[here] = component.rvs(int(here.sum()), generator)
        return out[()]
