"""Sampling error of quantities derived from thresholds that come from samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import refuse, whole
from origins.samples.from_samples import Sampled
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import ContinuousMixture, Mixture

# of equal weight: of more samples than these only the number in each cell is drawn
_CELLS = 1 << 12


@dataclass(frozen=True)
class Bootstrapped:
    """Statistics of a law from samples and their sampling errors, arrays of the statistics' shape.

    value : the statistic of the law itself.
    standard_error : scatter over the resampled laws.
    bias : their mean minus `value`: the effect of smoothing.
    resampled : array of shape (resamples, ...), the statistic of each resampled law.
    """

    value: Array
    standard_error: Array
    bias: Array
    resampled: Array

    @property
    def error(self) -> Array:
        """(standard_error^2 + bias^2)^(1/2), the error to state with `value`."""
        return np.hypot(self.standard_error, self.bias)

    @property
    def interval(self) -> tuple[Array, Array]:
        """Ends of the 95 % confidence interval, 1.96 errors to either side of `value`."""
        return self.value - 1.96 * self.error, self.value + 1.96 * self.error


def bootstrap(
    thresholds: Thresholds,
    statistic: Callable[[Thresholds], npt.ArrayLike],
    resamples: int = 100,
    seed: int = 0,
) -> Bootstrapped:
    """Sampling error of `statistic(thresholds)` for thresholds that come from from_samples.

    statistic : function of a law that returns a number or an array of fixed shape, such as law.pdf(x), or numbers
        read off the results of master.propensity and master.steady_state.
    resamples : number of laws, at least 2; the relative error of standard_error is about 1/(2 resamples)^(1/2).
    seed : whole number; the same seed gives the same resamples.

    Raises InputError for thresholds that are not from samples, and for a statistic that is not finite or changes shape.
    """
    laws = bootstrap_laws(thresholds, whole("resamples", resamples, 2), seed)
    found = [np.asarray(statistic(law), dtype=float) for law in (thresholds, *laws)]
    for one in found:
        if one.shape != found[0].shape or not np.isfinite(one).all():
            refuse("statistic", one, "must be finite, and of one shape, for all laws")
    value, resampled = found[0], np.stack(found[1:])
    return Bootstrapped(
        value, resampled.std(axis=0, ddof=1), resampled.mean(axis=0) - value, resampled
    )


def bootstrap_laws(
    thresholds: Thresholds, resamples: int = 100, seed: int = 0
) -> Iterator[Thresholds]:
    """Laws that other samples would have given: as many as the effective ones, drawn from the smooth law `thresholds`
    itself and smoothed in the same way (smoothed bootstrap, Silverman and Young, Biometrika 74, 469, 1987).

    Drawing from the law, not from the samples, gives no ties except its exact values, which keep their places and vary
    in weight, and shows the effect of smoothing on a statistic. It cannot show structure that the law itself has
    missed. In a mixture each part from samples is drawn again; its weight and all other parts stay.

    Raises InputError for thresholds without samples of at least two values, and for a continuous_mixture, whose laws
    may all come from the same samples.
    """
    if not sampled_parts(thresholds):
        rule = "must come from from_samples, or be a mixture with such a law, with at least two different values"
        refuse("thresholds", thresholds, rule)
    if isinstance(thresholds, ContinuousMixture):
        rule = "must not be a continuous mixture: its laws may all be of the same samples"
        refuse("thresholds", thresholds, rule)
    count, seed = whole("resamples", resamples, 1), whole("seed", seed, 0)
    return (_anew(thresholds, np.random.default_rng([seed, replica])) for replica in range(count))


def sampled_parts(thresholds: Thresholds) -> list[Sampled]:
    """The laws from samples that `thresholds` is, or is a mixture of."""
    if isinstance(thresholds, Sampled):
        return [thresholds]
    given = thresholds.given if isinstance(thresholds, Mixture) else ()
    return [part for _, law in given for part in sampled_parts(law)]


def _anew(law: Thresholds, generator: np.random.Generator) -> Thresholds:
    """The law that other samples would have given, in a mixture of each part."""
    if isinstance(law, Mixture) and not isinstance(law, Sampled):
        weights = np.array([weight for weight, _ in law.given])
        return Mixture([_anew(part, generator) for _, part in law.given], weights)
    if not isinstance(law, Sampled):
        return law
    size = max(round(law.effective_samples), 2)
    positions, weights = law.atoms
    hits = generator.multinomial(size, np.append(weights, max(1.0 - weights.sum(), 0.0)))
    x, counts = positions[hits[:-1] > 0], hits[:-1][hits[:-1] > 0].astype(float)
    if law.smooth_part is not None:
        drawn, each = _drawn(law.smooth_part, int(hits[-1]), generator)
        x, counts = np.append(x, drawn), np.append(counts, each)
    order = np.argsort(x, kind="stable")
    return Sampled(x[order], counts[order] / size, size, float(size), known=positions)


def _drawn(law: Thresholds, size: int, generator: np.random.Generator) -> tuple[Array, Array]:
    """`size` samples of a law, some merged: values, and the number of samples that each represents."""
    if size <= _CELLS:
        return law.rvs(size, generator), np.ones(size)
    # samples are replaced by the medians of their cells, but for those in the two outermost cells
    counts = generator.multinomial(size, np.full(_CELLS, 1.0 / _CELLS))
    inner = np.flatnonzero(counts[1:-1]) + 1
    low = law.ppf(generator.random(counts[0]) / _CELLS)
    high = law.isf(generator.random(counts[-1]) / _CELLS)
    x = np.concatenate([low, law.ppf((inner + 0.5) / _CELLS), high])
    return x, np.concatenate([np.ones(low.size), counts[inner], np.ones(high.size)])
