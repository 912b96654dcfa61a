"""Thresholds from your own values, from molecular dynamics or from an experiment, and their sampling errors."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, positive, positive_array, refuse, whole
from origins.samples.log_polynomial import smooth
from origins.thresholds.families import identical
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import ContinuousMixture, Mixture


def from_samples(
    x_s: npt.ArrayLike | None = None,
    *,
    f_s: npt.ArrayLike | None = None,
    coefficient: float | None = None,
    stiffness: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
) -> Thresholds:
    """A smooth P_c through threshold values of your own; one value, or all equal to within 1e-9, gives identical().

    Values that repeat, to within 1e-12, are exact, atoms of the law, where rounding to a grid does not explain it:
    where one occurs at least 10 times more often than 5 times the second largest count among the two values on either
    side of it; and where there are at most 8 values, each 10 times or more, that are not equally spaced, or at most 3.

    x_s : array of shape (n,), lengths from 1e-100 to 1e100; or instead of it
    f_s : array of shape (n,), forces above zero, turned into lengths in one of two ways:
    coefficient : c of the paper's quadratic law f_s = c x_s^2 (Eq. PxPf), so x_s = (f_s/c)^(1/2); force per length^2.
    stiffness : k of x_s = f_s/k, one for all contacts or an array of shape (n,), force per length, above zero.
    weights : array of shape (n,), above zero, on any scale: weight of each sample; equal when left out. The lightest,
        which together weigh less than a millionth of one effective sample, are left out; a heavy sample is not exact.

    The result has its sampling error as `n_samples`, `effective_samples`, `cdf_error`, `cdf_misfit`, `beyond` (see
    Sampled), and `origins.bootstrap` gives that of any number derived from it.
    Raises InputError for values that are missing, not finite or not above zero, for arrays of different lengths,
    unless exactly one of x_s and f_s, and for f_s exactly one of coefficient and stiffness, is given, and for samples
    a tenth of which a smooth law misplaces, beyond what sampling explains: give each peak or group apart, in a mixture.
    """
    if (x_s is None) == (f_s is None):
        hint = "give either x_s, the thresholds as lengths, or f_s, as forces, and not both"
        raise InputError(f"from_samples: {hint}")
    name, values = ("x_s", x_s) if f_s is None else ("f_s", f_s)
    lengths = given = positive_array(name, values)
    if f_s is not None:
        lengths = _lengths(given, coefficient, stiffness)
    elif coefficient is not None or stiffness is not None:
        hint = "coefficient and stiffness turn forces f_s into lengths; leave them out with x_s"
        raise InputError(f"from_samples: {hint}")
    for bad in np.flatnonzero((lengths < 1e-100) | (lengths > 1e100)):
        hint = "must lie between 1e-100 and 1e+100, as a length; choose another unit"
        refuse(f"{name}[{bad}]", given[bad], hint)
    counts = np.ones(lengths.size) if weights is None else positive_array("weights", weights)
    if counts.size != lengths.size:
        refuse("weights", counts, f"must hold one value for each of the {lengths.size} samples")
    order = np.argsort(lengths, kind="stable")
    lengths, fractions = lengths[order], counts[order] / counts.max()
    fractions /= fractions.sum()
    # by the Cauchy-Schwarz inequality those left out change the mean by less than a thousandth of its error
    heavy = fractions * fractions.size > 1e-6 * float(fractions @ fractions)
    lengths, fractions = lengths[heavy], fractions[heavy] / fractions[heavy].sum()
    if lengths[-1] - lengths[0] <= 1e-9 * lengths[-1]:
        return identical(float(fractions @ lengths))
    return Sampled(lengths, fractions, counts.size, float(1.0 / (fractions @ fractions)))


def _lengths(forces: Array, coefficient: object, stiffness: npt.ArrayLike | None) -> Array:
    """Forces as lengths, by the paper's quadratic law or by a stiffness."""
    if (coefficient is None) == (stiffness is None):
        hint = "coefficient, for f_s = coefficient * x_s^2, or stiffness, for x_s = f_s / stiffness"
        raise InputError(f"from_samples: with f_s give either {hint}, and not both")
    if stiffness is None:
        return np.sqrt(forces / positive("coefficient", coefficient))
    each = positive_array("stiffness", stiffness)
    if np.ndim(stiffness) and each.size != forces.size:
        refuse("stiffness", each, f"must hold one value for each of the {forces.size} samples")
    return forces / each


def _exact(values: Array, counts: Array) -> npt.NDArray[np.bool_]:
    """Which of the values (sorted, each occurring `counts` times) are exact, by the rule that from_samples states."""
    if 1 < values.size <= 8 and counts.min() >= 10:
        # lengths from rounded forces may have equally spaced squares
        steps = [np.diff(y) for y in (values, values * values)]
        on_a_grid = any(np.ptp(step) < 1e-3 * step.min() for step in steps)
        return np.full(values.size, values.size <= 3 or not on_a_grid)
    beside = np.sort([np.roll(np.pad(counts, 2), shift)[2:-2] for shift in (-2, -1, 1, 2)], axis=0)
    # the second largest: another exact value may be next to it, and a rounded density may be steep
    return counts >= 10 + 5 * beside[-2]


class Sampled(Mixture):
    """A smooth law through samples, with their exact values as atoms.

    log P_c is m log x + a polynomial, of largest penalised likelihood (origins/samples/log_polynomial.py), which also
    determines whether it begins as a power x^m, at a finite value at 0 or with an edge at the smallest sample, and
    whether it ends as an exponential or with an edge at the largest. Beyond the extreme samples there is about one
    sample's weight. <x_s> is that of the samples.

    n_samples, effective_samples : their number, and (sum of the weights)^2 / sum of their squares, used in the errors.
    cdf_error : the cdf of the law the samples came from lies within this of their empirical cdf, everywhere at once,
        with 95 % confidence (Dvoretzky, Kiefer, Wolfowitz), by the effective samples.
    cdf_misfit : largest distance of this smooth cdf from the empirical one.
    beyond : weights below the smallest sample and above the largest.
    samples, fractions : arrays of shape (n,), the different values, sorted, and their weights, of sum 1.
    smooth_part : the law without its atoms, or None.
    onset_power, onset_power_error : m and its error. Where P_c begins at a finite value, m = 0, and the error is the
        size of a fitted power plus its own error; inf where the samples do not determine m.
    """

    def __init__(
        self, x: Array, fractions: Array, n_samples: int, size: float, atoms: Array | None = None
    ) -> None:
        """x : values, sorted, at least two of them different; fractions : their weights, of sum 1; size : the effective
        number; atoms : the exact values, if they are given."""
        self.n_samples, self.effective_samples = n_samples, size
        self.cdf_error = float(np.sqrt(np.log(2.0 / 0.05) / (2.0 * size)))
        first = np.append(0, np.flatnonzero(np.diff(x) > 1e-12 * x[1:]) + 1)
        values, fractions = x[first], np.add.reduceat(fractions, first)
        counts = np.diff(first, append=x.size)
        atom = _exact(values, counts) if atoms is None else np.isin(values, atoms)
        if (~atom).sum() == 1:  # its width cannot be estimated
            atom[:] = True
        laws: list[Thresholds] = [identical(float(value)) for value in values[atom]]
        weights = fractions[atom]
        self.smooth_part: Thresholds | None = None
        if not atom.all():
            weight = float(fractions[~atom].sum())
            part = smooth(values[~atom], fractions[~atom] / weight, size * weight)
            laws, weights, self.smooth_part = [*laws, part], np.append(weights, weight), part
        super().__init__(laws, weights / weights.sum())
        self.samples, self.fractions = values, fractions
        up_to, steps = self.cdf(values), np.cumsum(fractions)
        below = up_to.copy()
        below[atom] -= self.atoms[1]
        self.cdf_misfit = float(max((steps - up_to).max(), (below - steps + fractions).max()))
        self.beyond = float(below[0]), float(self.sf(values[-1]))
        # the integrals of the likelihood may miss a peak between far samples, or no polynomial follows a peak
        mean = float(fractions @ values)
        off = abs(self.mean() - mean) / float(np.sqrt(fractions @ (values - mean) ** 2 / size))
        if off > 0.1 or self.cdf_misfit > self.cdf_error + 0.1:
            hint = "peaks that one smooth density does not follow; give each apart, in a mixture"
            among = f"among the samples from {values[0]:g} to {values[-1]:g}"
            raise InputError(f"from_samples: {among} are groups or {hint}")


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
    values = [np.asarray(statistic(law), dtype=float) for law in (thresholds, *laws)]
    for value in values:
        if value.shape != values[0].shape or not np.isfinite(value).all():
            refuse("statistic", value, "must be finite, and of one shape, for all laws")
    resampled = np.stack(values[1:])
    scatter, bias = resampled.std(axis=0, ddof=1), resampled.mean(axis=0) - values[0]
    return Bootstrapped(values[0], scatter, bias, resampled)


def bootstrap_laws(
    thresholds: Thresholds, resamples: int = 100, seed: int = 0
) -> Iterator[Thresholds]:
    """Laws that other samples would have given: as many as the effective ones, drawn from the smooth law `thresholds`
    itself and smoothed in the same way (smoothed bootstrap, Silverman and Young, Biometrika 74, 469, 1987).

    Exact values keep their places and vary in weight. Structure that the law itself has missed cannot show. In a
    mixture each part from samples is drawn again; its weight and all other parts stay.

    Raises InputError for thresholds without samples of at least two values, and for a continuous_mixture, whose laws
    may all come from the same samples.
    """
    if not sampled_parts(thresholds) or isinstance(thresholds, ContinuousMixture):
        hint = "must come from at least two different values in from_samples, or be a finite mixture with such a law"
        refuse("thresholds", thresholds, hint)
    count, seed = whole("resamples", resamples, 1), whole("seed", seed, 0)
    return (bootstrap_law(thresholds, replica, seed) for replica in range(count))


def bootstrap_law(thresholds: Thresholds, replica: int, seed: int = 0) -> Thresholds:
    """One of the laws of `bootstrap_laws`, counted from 0."""
    return _anew(thresholds, np.random.default_rng([seed, replica]))


def sampled_parts(thresholds: Thresholds) -> list[Sampled]:
    """The laws from samples that `thresholds` is, or is a mixture of."""
    if isinstance(thresholds, Sampled):
        return [thresholds]
    components = thresholds.components if isinstance(thresholds, Mixture) else ()
    return [part for law in components for part in sampled_parts(law)]


def _anew(law: Thresholds, generator: np.random.Generator) -> Thresholds:
    """The law that other samples would have given, in a mixture of each part."""
    if isinstance(law, Mixture) and not isinstance(law, Sampled):
        return Mixture([_anew(part, generator) for part in law.components], law.weights)
    if not isinstance(law, Sampled):
        return law
    size = max(round(law.effective_samples), 2)
    x = law.rvs(size, generator)
    return Sampled(np.sort(x), np.full(size, 1.0 / size), size, float(size), atoms=law.atoms[0])
