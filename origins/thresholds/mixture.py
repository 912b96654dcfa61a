"""Weighted mixtures of threshold laws, of finitely many or averaged over a continuous parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from origins.errors import between, finite, non_negative, positive_array, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.scipy_laws import as_thresholds

_NODES = (8, 16, 32, 64, 128, 256, 512)  # orders of Gauss's rule over a parameter
_TAILS = 10.0 ** -np.array([8.0, 5.0, 3.0, 2.0, 1.0, 0.6, 0.3])


def mixture(components: Sequence[object], weights: npt.ArrayLike) -> Thresholds:
    """P_c = sum of weights[i] P_c,i.

    components : sequence of Thresholds or frozen scipy.stats distributions, all in one unit of length.
    weights : one number above zero per component, together 1 to within 1e-12.
    Raises InputError otherwise.
    """
    if isinstance(components, Thresholds) or not isinstance(components, Sequence) or not components:
        such = "such as [identical(0.9), identical(1.1)]"
        refuse("components", components, f"must be a list of thresholds, {such}")
    fractions = positive_array("weights", weights)
    if fractions.size != len(components):
        hint = f"must hold one weight for each of the {len(components)} components"
        refuse("weights", weights, hint)
    if abs((whole := float(fractions.sum())) - 1.0) > 1e-12:
        refuse("weights", weights, f"must add up to 1, not {whole:.15g}; divide each by their sum")
    return Mixture([as_thresholds(component) for component in components], fractions / whole)


def continuous_mixture(
    law: Callable[[float], object],
    lower: float,
    upper: float,
    density: Callable[[float], float] | None = None,
    accuracy: float = 1e-10,
) -> ContinuousMixture:
    """P_c(x) = integral of R(phi) P_c(x; phi) dphi from lower to upper (paper, Sec. VI, grains of all orientations).

    Finitely many orientations are a mixture: mixture([law(phi_1), law(phi_2)], [R_1, R_2]).

    law : function of phi, and smooth in it, that returns Thresholds or a frozen scipy.stats distribution. Where a
        misfit multiplies the strength of all grains by s(phi), it is grains(rho, B=B / s(phi)).
    lower, upper : ends of phi, in any unit.
    density : smooth function of phi, R(phi) >= 0, normalised here; left out: all phi equal.
    accuracy : of the survival, absolute, and of <x_s>, relative; at most 1e-8. Gauss's rule takes 8 phi, 16, ... up to
        512, until doubling them changes the sums by less.

    Returns a mixture of the laws at the nodes, with that change as `.quadrature_error`. A tail with a probability
    below it is that of the laws at the nodes.
    Raises InputError for values outside these, and where 512 laws do not reach the accuracy, as where P_c(x; phi) has
    exact values or jumps that move with phi: a finite mixture has them, and another K*, while the average has none.
    """
    lower, upper = finite("lower", lower), finite("upper", upper)
    accuracy = between("accuracy", accuracy, 1e-15, 1e-8, "sums over few laws have another K*")
    if not upper > lower:
        refuse("upper", upper, f"must be above lower = {lower:g}")
    if not callable(law):
        such = "such as lambda phi: origins.grains(2.0, B=1.0 / strength(phi))"
        refuse("law", law, f"must be a function of phi, {such}")
    if density is not None and not callable(density):
        refuse("density", density, "must be a function of phi")
    density_of = density or (lambda phi: 1.0)
    x, before = np.empty(0), np.empty(0)
    for count in _NODES:
        nodes, weights = np.polynomial.legendre.leggauss(count)
        phis = (lower + (upper - lower) * 0.5 * (1.0 + nodes)).tolist()
        weights = weights * [non_negative("density", density_of(phi)) for phi in phis]
        if not weights.sum() > 0.0:
            refuse("density", density, "is zero at all phi asked")
        there = [phi for phi, weight in zip(phis, weights, strict=True) if weight > 0.0]
        laws, weights = [as_thresholds(law(phi)) for phi in there], weights[weights > 0.0]
        if not x.size:
            x = np.unique([x for part in laws for x in (*part.ppf(_TAILS), *part.isf(_TAILS))])
        average = ContinuousMixture(laws, weights / weights.sum())
        sums = np.append(average.sf(x), average.mean())
        if before.size:
            unit = np.append(np.ones(x.size), sums[-1])
            average.quadrature_error = float((np.abs(sums - before) / unit).max())
            if average.quadrature_error <= accuracy:
                return average
        before = sums
    fault = f"{_NODES[-1]} laws reach {average.quadrature_error:.2g} only; ask for less, or smooth the law"
    hint = "values and jumps that move with phi average yourself, as uniform(1.0, 1.0) for identical(1.0 + phi)"
    refuse("accuracy", accuracy, f"{fault}; {hint}")


class Mixture(Thresholds):
    """Sums of the components' functions, all positive, so that no accuracy is lost."""

    def __init__(self, components: Sequence[Thresholds], weights: Array) -> None:
        """Take the support, onset, breakpoints and exact values together; the weights are of sum 1."""
        self.components, self.weights = tuple(components), weights
        # all lengths of a mixture are in one unit, which one component with a known unit tells
        self.in_metres = any(
            part.in_metres or part.interface is not None for part in self.components
        )
        lower, upper = zip(*(part.support() for part in self.components), strict=True)
        self._support = min(lower), max(upper)
        starting = (part for part in self.components if part.support()[0] == min(lower))
        first = min(starting, key=lambda part: part.onset_power)
        self.onset_power, self.onset_power_error = first.onset_power, first.onset_power_error
        self.breakpoints = np.unique(np.concatenate([c.breakpoints for c in self.components]))
        self.cut_weight = float(self.weights @ [part.cut_weight for part in self.components])
        self.asked_itself = all(part.asked_itself for part in self.components)
        atoms = zip(self.components, weights.tolist(), strict=True)
        x, fractions = np.hstack([(c.atoms[0], weight * c.atoms[1]) for c, weight in atoms])
        places, index = np.unique(x, return_inverse=True)
        self.atoms = places, np.bincount(index, fractions, places.size).astype(float)

    def _sum(self, values: list[Array]) -> Array:
        return np.asarray(sum(w * value for w, value in zip(self.weights, values, strict=True)))

    def _log_sum(self, values: list[Array]) -> Array:
        log_weights = np.log(self.weights)
        return np.logaddexp.reduce([w + v for w, v in zip(log_weights, values, strict=True)])

    def _pdf(self, x: Array) -> Array:
        return self._sum([c.pdf(x) for c in self.components])

    def _logpdf(self, x: Array) -> Array:
        return self._log_sum([c.logpdf(x) for c in self.components])

    def _cdf(self, x: Array) -> Array:
        return np.minimum(self._sum([c.cdf(x) for c in self.components]), 1.0)

    def _sf(self, x: Array) -> Array:
        return np.minimum(self._sum([c.sf(x) for c in self.components]), 1.0)

    def _logsf(self, x: Array) -> Array:
        return self._log_sum([c.logsf(x) for c in self.components])

    def _quantiles(self, below: Array, above: Array) -> Array:
        if len(self.components) == 1:  # as of samples, whose own are quicker
            return self.components[0]._quantiles(below, above)
        return super()._quantiles(below, above)

    def _moment(self, n: float, centre: float = 0.0) -> float:
        return float(self.weights @ [c._moment(n, centre) for c in self.components])


class ContinuousMixture(Mixture):
    """The mixture at the nodes; quadrature_error as in continuous_mixture."""

    quadrature_error = np.inf
