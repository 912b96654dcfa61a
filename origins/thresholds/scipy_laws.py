"""A frozen scipy.stats distribution as Thresholds."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, refuse
from origins.thresholds.law import Array, Thresholds

_BELOW_ZERO = 1e-15
_LOOSE = 1e-9


def as_thresholds(law: object, name: str = "thresholds") -> Thresholds:
    """`law` itself if it is a Thresholds, else the frozen continuous scipy.stats distribution, wrapped.

    Raises InputError, which says `name`, for anything else, for weight below x = 0 and for an infinite mean.
    """
    if isinstance(law, Thresholds):
        return law
    if not is_frozen_continuous(law):
        refuse(
            name,
            law,
            "must come from origins, such as origins.gaussian(mean=1.0, std=0.05), or be a frozen continuous "
            "scipy.stats distribution",
        )
    return FrozenThresholds(law, name)


def is_frozen_continuous(law: object) -> bool:
    """Whether `law` quacks like a frozen continuous scipy.stats distribution; imports nothing."""
    methods = ("pdf", "logpdf", "cdf", "sf", "logsf", "ppf", "isf", "moment", "support")
    return all(callable(getattr(law, name, None)) for name in methods)


def single_mean(name: str, frozen) -> float:  # type: ignore[no-untyped-def]
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


class FrozenThresholds(Thresholds):
    """Delegates to the frozen distribution; its support's ends are the only breakpoints known."""

    knows_breakpoints = False

    def __init__(self, frozen, name: str = "thresholds") -> None:  # type: ignore[no-untyped-def]
        self.frozen, self._name = frozen, name
        self._mean = single_mean(name, frozen)
        lower, upper = (float(end) for end in frozen.support())
        if not (np.isfinite(lower) or lower == -np.inf) or np.isnan(upper) or upper <= lower:
            raise InputError(f"{name}: the frozen distribution has no valid support; check its parameters")
        below = float(frozen.cdf(0.0)) if lower <= 0.0 else 0.0
        if upper <= 0.0 or below > _BELOW_ZERO:
            raise InputError(
                f"{name}: the distribution has weight {below:.3g} at or below x = 0; a threshold is a positive "
                "length, so cut it there, or use origins.gaussian, which does"
            )
        self._support = (max(lower, 0.0), upper)
        if not np.isfinite(self._mean):
            raise InputError(
                f"{name}: the mean is {self._mean}; with an infinite mean contacts never reach a steady state"
            )
        self._cut = below > 0.0

    @cached_property
    def onset_power(self) -> float:  # type: ignore[override]
        return self._onset[0]

    @cached_property
    def onset_power_error(self) -> float:  # type: ignore[override]
        return self._onset[1]

    @cached_property
    def _onset(self) -> tuple[float, float]:
        """Limit of (x - a) P_c / cdf at the support's lower end a, less one, and its error; inf where it has none."""
        if self._cut:
            return 0.0, 0.0  # a law cut at 0 starts there at a finite density, however small
        lower = self._support[0]
        halvings = np.array([30.0, 36.0, 42.0]) if lower == 0.0 else np.array([16.0, 19.0, 22.0])
        x = lower + (float(self.frozen.median()) - lower) * 2.0**-halvings
        with np.errstate(all="ignore"):
            power = (x - lower) * self.frozen.pdf(x) / self.frozen.cdf(x) - 1.0
        if not np.isfinite(power).all() or abs(power[2] - power[1]) > 1e-3 * (1.0 + abs(power[1])):
            return np.inf, 0.0
        # the rest falls as a power of the distance: one step of Aitken
        bend = power[2] - 2.0 * power[1] + power[0]
        limit = power[2] if bend == 0.0 else power[2] - (power[2] - power[1]) ** 2 / bend
        return float(np.round(limit, 6)) + 0.0, float(abs(limit - power[2])) + 1e-6

    def support(self) -> tuple[float, float]:
        return self._support

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
        out = self._ask("logsf", x)
        near = out > -0.5
        if near.any():
            out[near] = np.log1p(-self._cdf(x[near]))
        return out

    def _ppf(self, q: Array) -> Array:
        x = np.maximum(self._ask("ppf", q), self._support[0])
        return self._mend(x, np.abs(self._cdf(x) - q) > _LOOSE * q, q, super()._ppf)

    def _isf(self, q: Array) -> Array:
        x = np.maximum(self._ask("isf", q), self._support[0])
        return self._mend(x, np.abs(self._sf(x) - q) > _LOOSE * q, q, super()._isf)

    def rough_quantiles(self, below: Array, above: Array) -> tuple[Array, Array]:
        low, high = self._ask("ppf", below), self._ask("isf", above)
        return np.maximum(low, self._support[0]), np.maximum(high, self._support[0])

    def _mend(self, x: Array, bad: npt.NDArray[np.bool_], q: Array, invert: Callable[[Array], Array]) -> Array:
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
