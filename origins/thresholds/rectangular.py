"""Rectangular thresholds: every value between two ends equally likely (paper, Fig. A02d)."""

import numpy as np

from origins.errors import non_negative, positive, refuse
from origins.thresholds.law import Array, Thresholds


def rectangular(lower: float, upper: float) -> Thresholds:
    """P_c constant on (lower, upper), lengths with 0 <= lower < upper, else InputError (paper, Eq. Q22a)."""
    lower, upper = non_negative("lower", lower), positive("upper", upper)
    if not upper > lower:
        refuse(
            "upper",
            upper,
            f"must lie above lower = {lower:g}; for one value take identical, value = {lower:g}",
        )
    return Rectangular(lower, upper)


class Rectangular(Thresholds):
    """The uniform law on (lower, upper)."""

    onset_power = 0.0

    def __init__(self, lower: float, upper: float) -> None:
        self.lower, self.upper = lower, upper
        self._width = upper - lower

    def support(self) -> tuple[float, float]:
        return self.lower, self.upper

    def _pdf(self, x: Array) -> Array:
        return np.full(x.shape, 1.0 / self._width)

    def _cdf(self, x: Array) -> Array:
        return (x - self.lower) / self._width

    def _sf(self, x: Array) -> Array:
        return (self.upper - x) / self._width

    def _logsf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            return np.where(self._cdf(x) < 0.5, np.log1p(-self._cdf(x)), np.log(self._sf(x)))

    def _ppf(self, q: Array) -> Array:
        return self.lower + self._width * q

    def _isf(self, q: Array) -> Array:
        return self.upper - self._width * q

    def _moment(self, n: int) -> float:
        # (u^(n+1) - l^(n+1)) / (n+1)(u - l) without the cancellation
        powers = self.upper ** np.arange(n + 1.0) * self.lower ** np.arange(n, -1.0, -1.0)
        return float(powers.sum()) / (n + 1)

    def _variance(self) -> float:
        return self._width**2 / 12.0
