"""A frozen scipy.stats distribution as Thresholds."""

import numpy as np

from origins.errors import InputError, refuse
from origins.thresholds import Array, Thresholds

_BELOW_ZERO = 1e-15


def as_thresholds(law: object) -> Thresholds:
    """`law` itself if it is a Thresholds, else the frozen continuous scipy.stats distribution, wrapped.

    Raises InputError for anything else, for weight below x = 0 and for an infinite mean.
    """
    if isinstance(law, Thresholds):
        return law
    if not is_frozen_continuous(law):
        refuse(
            "thresholds",
            law,
            "must come from origins, such as origins.gaussian(mean=1.0, std=0.05), or be a frozen continuous "
            "scipy.stats distribution",
        )
    return FrozenThresholds(law)


def is_frozen_continuous(law: object) -> bool:
    """Whether `law` quacks like a frozen continuous scipy.stats distribution; imports nothing."""
    methods = ("pdf", "logpdf", "cdf", "sf", "logsf", "ppf", "isf", "moment", "support")
    return all(callable(getattr(law, name, None)) for name in methods)


class FrozenThresholds(Thresholds):
    """Delegates to the frozen distribution; its support's ends are the only breakpoints known."""

    def __init__(self, frozen) -> None:  # type: ignore[no-untyped-def]
        self.frozen = frozen
        lower, upper = (float(end) for end in frozen.support())
        if not (np.isfinite(lower) or lower == -np.inf) or np.isnan(upper) or upper <= lower:
            raise InputError("thresholds: the frozen distribution has no valid support; check its parameters")
        if upper <= 0.0 or float(frozen.cdf(0.0)) > _BELOW_ZERO:
            raise InputError(
                f"thresholds: the distribution has weight {float(frozen.cdf(0.0)):.3g} at or below x = 0; a threshold is a "
                "positive length, so cut it there, or use origins.gaussian, which does"
            )
        self._support = (max(lower, 0.0), upper)
        mean = float(frozen.mean())
        if not np.isfinite(mean):
            raise InputError(f"thresholds: the mean is {mean}; with an infinite mean contacts never reach a steady state")
        self.onset_power = self._fit_onset()

    def _fit_onset(self) -> float:
        """Exponent of the cdf at the support's lower end, less one; inf where no power holds."""
        lower = self._support[0]
        q = np.array([1e-6, 1e-8, 1e-10])
        distance = np.log(np.maximum(np.asarray(self.frozen.ppf(q), dtype=float) - lower, 1e-300))
        slopes = np.diff(np.log(q)) / np.where(np.diff(distance) == 0.0, np.nan, np.diff(distance))
        if np.isfinite(slopes).all() and abs(slopes[1] - slopes[0]) < 1e-3 * abs(slopes[1]):
            return float(slopes[1] - 1.0)
        return np.inf

    def support(self) -> tuple[float, float]:
        return self._support

    def _pdf(self, x: Array) -> Array:
        return self.frozen.pdf(x)

    def _logpdf(self, x: Array) -> Array:
        return self.frozen.logpdf(x)

    def _cdf(self, x: Array) -> Array:
        return self.frozen.cdf(x)

    def _sf(self, x: Array) -> Array:
        return self.frozen.sf(x)

    def _logsf(self, x: Array) -> Array:
        return self.frozen.logsf(x)

    def _ppf(self, q: Array) -> Array:
        return np.maximum(self.frozen.ppf(q), self._support[0])

    def _isf(self, q: Array) -> Array:
        return np.maximum(self.frozen.isf(q), self._support[0])

    def _moment(self, n: int) -> float:
        return float(self.frozen.moment(n))
