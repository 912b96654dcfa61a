"""Gaussian thresholds, the parent normal cut at x = 0 and normalised."""

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri, ndtri_exp

from origins.errors import finite, positive
from origins.quadrature import gauss
from origins.thresholds import Array, Thresholds

_LOG_ROOT_TWO_PI = 0.5 * np.log(2.0 * np.pi)


def gaussian(mean: float, std: float) -> Thresholds:
    """Thresholds from the normal law of `mean` and `std` (lengths), cut at 0 (paper, Eq. Q14e).

    Raises InputError unless mean is finite and std is finite and above zero; for one value, use identical().
    """
    return CutGaussian(finite("mean", mean), positive("std", std))


class CutGaussian(Thresholds):
    """The normal law with parent mean and width, conditional on x > 0."""

    onset_power = 0.0

    def __init__(self, parent_mean: float, parent_std: float) -> None:
        self.parent_mean = parent_mean
        self.parent_std = parent_std
        self._z0 = -parent_mean / parent_std
        self._log_kept = float(log_ndtr(-self._z0))
        self._kept = float(ndtr(-self._z0))

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _z(self, x: Array) -> Array:
        return (x - self.parent_mean) / self.parent_std

    def _logpdf(self, x: Array) -> Array:
        return -0.5 * self._z(x) ** 2 - _LOG_ROOT_TWO_PI - np.log(self.parent_std) - self._log_kept

    def _pdf(self, x: Array) -> Array:
        return np.exp(self._logpdf(x))

    def _logsf(self, x: Array) -> Array:
        return np.minimum(log_ndtr(-self._z(x)) - self._log_kept, 0.0)

    def _sf(self, x: Array) -> Array:
        if self._z0 < -1.0:
            return np.minimum(ndtr(-self._z(x)) / self._kept, 1.0)
        return np.exp(self._logsf(x))

    def _cdf(self, x: Array) -> Array:
        z = self._z(x)
        if self._z0 > 5.0:
            rest = -np.expm1(self._logsf(x))
        elif self._z0 > 0.0:
            rest = (ndtr(-self._z0) - ndtr(-z)) / self._kept
        else:
            rest = (ndtr(z) - ndtr(self._z0)) / self._kept
        # just above 0 the difference cancels: integrate the density instead
        near = x * max(1.0, abs(self._z0)) < 0.3 * self.parent_std
        if near.any():
            nodes, weights = gauss(np.zeros(int(near.sum())), x[near])
            rest[near] = (weights * self._pdf(nodes)).sum(-1)
        return np.minimum(rest, 1.0)

    def _isf(self, q: Array) -> Array:
        return self._polish(self.parent_mean - self.parent_std * ndtri_exp(np.log(q) + self._log_kept), q, self._sf, 1.0)

    def _ppf(self, q: Array) -> Array:
        if self._z0 < 0.0:
            x = self.parent_mean + self.parent_std * ndtri(ndtr(self._z0) + q * self._kept)
        else:
            x = self.parent_mean - self.parent_std * ndtri_exp(np.log1p(-q) + self._log_kept)
        return self._polish(x, q, self._cdf, -1.0)

    def _polish(self, x: Array, q: Array, function, sign: float) -> Array:  # type: ignore[no-untyped-def]
        """Two Newton steps, for the digits lost where x is small beside the parent mean."""
        for _ in range(2):
            x = np.maximum(x, 0.0)
            density = self._pdf(x)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = sign * (function(x) - q) / density
            x = x + np.where(np.isfinite(step) & (np.abs(step) < 0.1 * self.parent_std), step, 0.0)
        return np.maximum(x, 0.0)

    def _moment(self, n: int) -> float:
        if self.parent_mean < 0.0:
            return super()._moment(n)
        at_zero = float(self._pdf(np.zeros(1))[0])
        variance = self.parent_std**2
        lower, moment = 1.0, self.parent_mean + variance * at_zero
        for order in range(2, n + 1):
            lower, moment = moment, self.parent_mean * moment + (order - 1) * variance * lower
        return moment
