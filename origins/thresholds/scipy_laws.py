"""Continuous scipy.stats distributions, frozen ones and those of the newer interface, as Thresholds."""

import warnings
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np

from origins.errors import InputError, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.numerical import clipped

_ROUNDING = 1e-15  # weight at or below x = 0, or far out, that may be due to rounding
# Relative change of a density that is finite and above 0 at its onset, up to 2e-6 of the way to the median: far above
# that by any slope, far below that by any power that the fit tells from 0.
_STRAIGHT = 1e-3
# Most edges of a histogram that are told to solvers. Without them averages are halved towards jumps that are not known,
# and K* of 10 bins takes 80 s. With them the march is cut at their sums, 400 at most, each of which looks at all
# edges: K* of 500 bins takes 16 s.
_MOST_EDGES = 501
_FROZEN = ("pdf", "logpdf", "cdf", "sf", "logsf", "ppf", "isf", "moment", "support")
_NEWER = ("pdf", "logpdf", "cdf", "ccdf", "icdf", "iccdf", "mean", "support", "sample")


def as_thresholds(law: object, name: str = "thresholds") -> Thresholds:
    """`law` itself if it is a Thresholds, else the continuous scipy.stats distribution, wrapped.

    A weight of up to 1e-6 at or below x = 0 is cut off: it is stored in `cut_weight`, and solvers report it.
    Raises InputError, which names `name`, for anything else, for more weight there and for an infinite mean.
    """
    if isinstance(law, Thresholds):
        return law
    if (frozen := as_frozen(law)) is None:
        such = "origins.gaussian(mean=1.0, std=0.05), or be a frozen continuous scipy.stats distribution"
        refuse(name, law, f"must come from origins, such as {such}")
    mean = single_mean(name, frozen)
    lower, upper = (float(end) for end in frozen.support())
    below = float(frozen.cdf(0.0)) if lower <= 0.0 else 0.0
    if upper <= 0.0 or below > 1e-6:  # the same limit as for starts
        fault = f"the distribution has weight {below:.3g} at or below x = 0"
        hint = "a threshold is a positive length: cut it there, or use origins.gaussian, which does"
        raise InputError(f"{name}: {fault}; {hint}")
    if not np.isfinite(mean):
        hint = "without a finite mean contacts never reach a steady state"
        raise InputError(f"{name}: the mean is {mean}; {hint}")
    kind = ScipyDensity if below > _ROUNDING or frozen is not law else FrozenThresholds
    return kind(frozen, (max(lower, 0.0), upper), below)


def as_frozen(law: Any) -> Any:
    """`law` with the methods of a frozen continuous scipy.stats distribution, or None; imports nothing."""
    if all(callable(getattr(law, name, None)) for name in _FROZEN):
        return law
    discrete = any(kind.__name__ == "DiscreteDistribution" for kind in type(law).__mro__)
    if discrete or not all(callable(getattr(law, name, None)) for name in _NEWER):
        return None
    same = {name: getattr(law, name) for name in ("pdf", "logpdf", "cdf", "mean", "support")}
    return SimpleNamespace(**same, sf=law.ccdf, ppf=law.icdf, isf=law.iccdf)


def jumps_of(frozen: Any) -> Array:
    """Finite points (lengths), sorted, where the density of a scipy.stats distribution is not smooth: the ends of its
    support, and all edges of the bins of an `rv_histogram`. Those of other distributions are not known."""
    ends = np.array(frozen.support(), dtype=float)
    # scipy has no public name for the bins; without them a histogram is solved as well, but takes long
    bins = getattr(getattr(frozen, "dist", frozen), "_hbins", None)
    if bins is None:
        return ends[np.isfinite(ends)]
    # a frozen histogram may be moved and scaled
    places = (np.asarray(bins, dtype=float) - bins[0]) / (bins[-1] - bins[0])
    return np.asarray(ends[0] + np.ptp(ends) * places)


def single_mean(name: str, frozen: Any) -> float:
    """Mean of a distribution; InputError where its parameters are missing or are arrays."""
    try:
        with warnings.catch_warnings(action="ignore"):  # of integrals: the value is judged
            mean = frozen.mean()
    except TypeError as error:
        hint = "freeze it, as in scipy.stats.gamma(3.0)"
        raise InputError(f"{name}: the distribution lacks its parameters; {hint}") from error
    if np.ndim(mean) > 0:
        raise InputError(f"{name}: the distribution has arrays as parameters; give one law")
    return float(mean)


class ScipyDensity(Thresholds):
    """The density of a distribution where x > 0, normalised; cut_weight lay at or below 0.

    Its onset is fitted. Its breakpoints are the ends of the support, and edges of a histogram of up to 500 bins: the
    march is cut wherever contacts that formed at one edge reach another.
    """

    def __init__(self, distribution: Any, ends: tuple[float, float], below: float) -> None:
        self.distribution, self._support = distribution, ends
        self.cut_weight = below if below > _ROUNDING else 0.0
        # a law that reaches below 0 starts at 0 with a finite density, however small
        self.onset_power = 0.0
        if below == 0.0:
            self._fit_onset()

    @cached_property
    def breakpoints(self) -> Array:
        edges = jumps_of(self.distribution)
        positive = edges[edges > 0.0] if edges.size <= _MOST_EDGES else edges[:0]
        return np.unique(np.append(positive, super().breakpoints))

    def _ask(self, method: str, *x: Array | float) -> Array:
        # warnings inside the distribution are ignored: only its result counts
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
            return np.asarray(getattr(self.distribution, method)(*x))

    def _log_weight(self, x: Array) -> Array:
        return self._ask("logpdf", x)

    def _fit_onset(self) -> None:
        """Set onset_power to the limit of (x - a) P_c / cdf - 1 at the support's lower end a, and its error. It is 0
        where the density begins at a finite value: a fit would miss it by rounding, as some cdf have few digits."""
        lower, self.onset_power = self._support[0], np.inf  # where there is no limit
        halvings = np.array([36.0, 42.0] if lower == 0.0 else [19.0, 22.0])
        x = lower + (float(self.ppf(0.5)) - lower) * 2.0**-halvings
        begin, *near = self._ask("pdf", np.append(lower, x)).tolist()
        if 0.0 < begin < np.inf and np.allclose(near, begin, rtol=_STRAIGHT, atol=0.0):
            self.onset_power = 0.0
            return
        with np.errstate(all="ignore"):
            further, nearer = (x - lower) * self.pdf(x) / self.cdf(x) - 1.0
        if np.isfinite(further) and abs(nearer - further) <= 1e-3 * (1.0 + abs(further)):
            self.onset_power = float(np.round(nearer, 6)) + 0.0
            self.onset_power_error = float(abs(nearer - further)) + 1e-6


class FrozenThresholds(ScipyDensity):
    """Delegates to a frozen distribution on x >= 0, whose own quantiles contradict its cdf in some far tails.

    Far out the survival of some distributions is NaN, or 1. It counts as 0 where it is no number, or above twice
    Markov's bound, <x>/x. Raises InputError where that happens too near.
    """

    def __init__(self, distribution: Any, ends: tuple[float, float], below: float) -> None:
        self.distribution, self._mean = distribution, single_mean("thresholds", distribution)
        median = float(distribution.ppf(0.5))
        x = np.minimum(median * np.append(1.0, 2.0**2.0 ** np.arange(10)), ends[1])
        tail = self._ask("sf", x)
        wrong = int((~(tail * x <= 2.0 * self._mean)).argmax())
        if wrong and not tail[wrong - 1] <= _ROUNDING:
            last = f"{tail[wrong - 1]:.2g} at x = {x[wrong - 1]:g}"
            hint = f"the distribution's sf, {last}, is no survival beyond"
            raise InputError(f"thresholds: {hint}; use another distribution")
        super().__init__(distribution, ends, below)
        # scipy takes 0.2 µs for a survival of gamma and 3 µs for one of beta, so that a table is quicker; but where
        # the density diverges at an end, as of arcsine, a table to rounding would take too many pieces (not at 0, whose
        # neighbourhood it resolves)
        above_0 = np.array([end for end in ends if 0.0 < end < np.inf])
        self.asked_itself = bool(np.isinf(self._ask("pdf", above_0)).any())

    def _logpdf(self, x: Array) -> Array:
        density = self._ask("logpdf", x)
        return np.where(np.isnan(density), -np.inf, density)

    def _cdf(self, x: Array) -> Array:
        below = clipped(self._ask("cdf", x), 0.0, 1.0)
        return np.where((1.0 - below) * x <= 2.0 * self._mean, below, 1.0)

    def _sf(self, x: Array) -> Array:
        above = clipped(self._ask("sf", x), 0.0, 1.0)
        return np.where(above * x <= 2.0 * self._mean, above, 0.0)

    def _logsf(self, x: Array) -> Array:
        above = self._ask("logsf", x)
        return np.where(np.exp(above) * x <= 2.0 * self._mean, above, -np.inf)

    def _quantiles(self, below: Array, above: Array) -> Array:
        """The distribution's own, where its cdf and survival agree with them."""
        x = np.where(below < above, self._ask("ppf", below), self._ask("isf", above))
        off = np.where(below < above, self.cdf(x) / below, self.sf(x) / above) - 1.0
        wrong = ~(np.abs(off) < 1e-11)
        if wrong.any():
            x[wrong] = super()._quantiles(below[wrong], above[wrong])
        return x

    def _moment(self, n: float, centre: float = 0.0) -> float:
        mean = self._mean
        if n == 2 and centre != 0.0:
            return float(self._ask("var")) + (mean - centre) ** 2
        if n != int(n):  # scipy has whole ones only
            return super()._moment(n, centre)
        value = mean if n == 1 else float(self._ask("moment", int(n)))
        # where a moment is infinite some distributions evaluate a formula that is not valid there
        return value if value >= mean**n * (1.0 - 1e-9) else np.inf
