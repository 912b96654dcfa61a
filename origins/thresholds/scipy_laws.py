"""Continuous scipy.stats distributions, frozen ones and those of the newer interface, as Thresholds."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.numerical import NumericalLaw

_BELOW_ZERO = 1e-15  # weight at or below x = 0 that rounding alone leaves
_CUT_LIMIT = 1e-6  # weight there that may be cut off, as of starts beyond every threshold
_LOOSE = 1e-9  # relative error of a distribution's own quantiles, from where on they are found anew
_FROZEN = ("pdf", "logpdf", "cdf", "sf", "logsf", "ppf", "isf", "moment", "support")
_NEWER = ("pdf", "logpdf", "cdf", "ccdf", "icdf", "iccdf", "mean", "support", "sample")


def as_thresholds(law: object, name: str = "thresholds") -> Thresholds:
    """`law` itself if it is a Thresholds, else the continuous scipy.stats distribution, wrapped.

    A weight of up to 1e-6 at or below x = 0 is cut off: it stands in `cut_weight`, and solvers tell it.
    Raises InputError, which says `name`, for anything else, for more weight there and for an infinite mean.
    """
    if isinstance(law, Thresholds):
        return law
    frozen = as_frozen(law)
    if frozen is None:
        refuse(
            name,
            law,
            "must come from origins, such as origins.gaussian(mean=1.0, std=0.05), or be a frozen continuous "
            "scipy.stats distribution",
        )
    mean = single_mean(name, frozen)
    lower, upper = (float(end) for end in frozen.support())
    if not (np.isfinite(lower) or lower == -np.inf) or np.isnan(upper) or upper <= lower:
        raise InputError(
            f"{name}: the frozen distribution has no valid support; check its parameters"
        )
    below = float(frozen.cdf(0.0)) if lower <= 0.0 else 0.0
    if upper <= 0.0 or below > _CUT_LIMIT:
        raise InputError(
            f"{name}: the distribution has weight {below:.3g} at or below x = 0; a threshold is a positive "
            "length, so cut it there, or use origins.gaussian, which does"
        )
    if not np.isfinite(mean):
        raise InputError(
            f"{name}: the mean is {mean}; with an infinite mean contacts never reach a steady state"
        )
    if below > _BELOW_ZERO or isinstance(frozen, NewerDistribution):
        return ScipyDensity(frozen, upper, below)
    return FrozenThresholds(frozen, name)


def as_frozen(law: object) -> Any:
    """`law` with the methods of a frozen continuous scipy.stats distribution, or None; imports nothing."""
    if all(callable(getattr(law, name, None)) for name in _FROZEN):
        return law
    discrete = any(kind.__name__ == "DiscreteDistribution" for kind in type(law).__mro__)
    newer = all(callable(getattr(law, name, None)) for name in _NEWER)
    return NewerDistribution(law) if newer and not discrete else None


def single_mean(name: str, frozen: Any) -> float:
    """Mean of a distribution; InputError where its parameters are missing or are arrays."""
    try:
        mean = frozen.mean()
    except TypeError as error:
        raise InputError(
            f"{name}: the distribution lacks its parameters; freeze it, as in scipy.stats.gamma(3.0)"
        ) from error
    if np.ndim(mean) > 0:
        raise InputError(f"{name}: the distribution has arrays as parameters; give one law")
    return float(mean)


def fitted_onset(law: Thresholds, halvings: Array) -> tuple[float, float]:
    """Limit of (x - a) P_c / cdf at the support's lower end a, less one, and its error; inf where it has none.

    halvings : three depths, between the lower end and the median, at which that quotient is taken.
    """
    lower = law.support()[0]
    x = lower + (float(law.ppf(0.5)) - lower) * 2.0**-halvings
    with np.errstate(all="ignore"):
        power = (x - lower) * law.pdf(x) / law.cdf(x) - 1.0
    if not np.isfinite(power).all() or abs(power[2] - power[1]) > 1e-3 * (1.0 + abs(power[1])):
        return np.inf, 0.0
    # the rest falls as a power of the distance: one step of Aitken
    bend = power[2] - 2.0 * power[1] + power[0]
    limit = power[2] if bend == 0.0 else power[2] - (power[2] - power[1]) ** 2 / bend
    return float(np.round(limit, 6)) + 0.0, float(abs(limit - power[2])) + 1e-6


class NewerDistribution:
    """A distribution of scipy's newer interface under the names of a frozen one."""

    def __init__(self, law: Any) -> None:
        self.law = law
        self.pdf, self.logpdf, self.cdf, self.sf = law.pdf, law.logpdf, law.cdf, law.ccdf
        self.ppf, self.isf, self.mean, self.support = law.icdf, law.iccdf, law.mean, law.support

    def __repr__(self) -> str:
        return repr(self.law)


class ForeignThresholds(Thresholds):
    """A law that tells its support's ends, and no other breakpoints; its onset is fitted."""

    knows_breakpoints = False
    _support: tuple[float, float]
    _reaches_below: bool  # so that it starts at 0 with a finite density, however small

    def support(self) -> tuple[float, float]:
        return self._support

    @cached_property
    def onset_power(self) -> float:  # type: ignore[override]
        return self._onset[0]

    @cached_property
    def onset_power_error(self) -> float:  # type: ignore[override]
        return self._onset[1]

    @cached_property
    def _onset(self) -> tuple[float, float]:
        if self._reaches_below:
            return 0.0, 0.0
        near = self._support[0] == 0.0
        return fitted_onset(self, np.array([30.0, 36.0, 42.0] if near else [16.0, 19.0, 22.0]))


class ScipyDensity(ForeignThresholds):
    """The density of a distribution where x > 0, normalised; cut_weight lay at or below 0."""

    def __init__(self, distribution: Any, upper: float, cut_weight: float) -> None:
        lower = max(float(distribution.support()[0]), 0.0)
        self._support, self._reaches_below = (lower, upper), cut_weight > 0.0
        self.cut_weight = cut_weight if cut_weight > _BELOW_ZERO else 0.0
        self._distribution = distribution
        self._numerical = NumericalLaw(self._log_weight, lower, upper, self.breakpoints)

    def _log_weight(self, x: Array) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(self._distribution.logpdf(x))


class FrozenThresholds(ForeignThresholds):
    """Delegates to a frozen distribution on x >= 0."""

    def __init__(self, frozen: Any, name: str = "thresholds") -> None:
        self.frozen, self._name = frozen, name
        self._mean = float(frozen.mean())
        lower, upper = (float(end) for end in frozen.support())
        self._support = max(lower, 0.0), upper
        self._reaches_below = lower <= 0.0 and float(frozen.cdf(0.0)) > 0.0

    def _ask(self, method: str, x: Array) -> Array:
        # what overflows on the way is the distribution's own affair: its answer counts
        with np.errstate(all="ignore"):
            try:
                return getattr(self.frozen, method)(x)
            except OverflowError as error:
                own = f"the distribution's own {method} overflows"
                raise InputError(f"{self._name}: {own}; use milder parameters") from error

    def _pdf(self, x: Array) -> Array:
        return self._ask("pdf", x)

    def _logpdf(self, x: Array) -> Array:
        return self._ask("logpdf", x)

    def _cdf(self, x: Array) -> Array:
        return self._ask("cdf", x)

    def _sf(self, x: Array) -> Array:
        return self._ask("sf", x)

    def _logsf(self, x: Array) -> Array:
        return self._near_one(x, self._ask("logsf", x))

    def _ppf(self, q: Array) -> Array:
        x = np.maximum(self._ask("ppf", q), self._support[0])
        return self._mend(x, np.abs(self._cdf(x) - q) > _LOOSE * q, q, super()._ppf)

    def _isf(self, q: Array) -> Array:
        x = np.maximum(self._ask("isf", q), self._support[0])
        return self._mend(x, np.abs(self._sf(x) - q) > _LOOSE * q, q, super()._isf)

    def rough_quantiles(self, below: Array, above: Array) -> tuple[Array, Array]:
        low, high = self._ask("ppf", below), self._ask("isf", above)
        return np.maximum(low, self._support[0]), np.maximum(high, self._support[0])

    def _mend(
        self, x: Array, bad: npt.NDArray[np.bool_], q: Array, invert: Callable[[Array], Array]
    ) -> Array:
        """Quantiles that do not fit the distribution's own cdf, as in many a far tail, found from it instead."""
        bad = bad | ~np.isfinite(x)
        if bad.any():
            x[bad] = invert(q[bad])
        return x

    def _moment(self, n: int) -> float:
        if n == 1:
            return self._mean
        value = float(self.frozen.moment(n))
        # where a moment is infinite some distributions return what their formula gives beyond its range
        beyond = not value >= self._mean**n * (1.0 - 1e-9)
        return np.inf if beyond or np.isnan(value) else value

    def _variance(self) -> float:
        return float(self.frozen.var())
