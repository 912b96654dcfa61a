"""Thresholds whose power a positive power of x follows a gamma law: P_c ~ x^m exp(-(x/w)^p)."""

import numpy as np
from scipy.special import gammainc, gammaincc, gammainccinv, gammaincinv, gammaln, poch, xlogy

from origins.thresholds.law import Array, Thresholds

_TAIL_NODES, _TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(40)
_SMALL = 1e-20  # t below which the cdf is its leading power, even where t itself underflows
_FAR = 1e-280  # survival below which it is an integral along the tail
_MOST = 1e300  # t at most, so that its square roots and logarithms stay numbers


class GeneralisedGamma(Thresholds):
    """t = (x/width)^decay follows the gamma law of the order a = (power + 1)/decay; power > -1, decay > 0.

    order : a, where it is known without rounding. At a = 1, a Weibull law, S = e^-t; at a = 2 S = (1 + t) e^-t.
    """

    def __init__(
        self, width: float, power: float, decay: float, order: float | None = None
    ) -> None:
        self.width, self.onset_power, self.decay = width, power, decay
        self._order = (power + 1.0) / decay if order is None else order
        self._log_front = float(np.log(decay / width) - gammaln(self._order))

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _t(self, x: Array) -> Array:
        with np.errstate(over="ignore", under="ignore"):
            return np.minimum((x / self.width) ** self.decay, _MOST)

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            return self._log_front + xlogy(self.onset_power, x / self.width) - self._t(x)

    def _cdf(self, x: Array) -> Array:
        t = self._t(x)
        out = -np.expm1(-t) if self._order == 1.0 else gammainc(self._order, t)
        onset = t < _SMALL
        if onset.any():
            power = (self.onset_power + 1.0) * np.log(x[onset] / self.width)
            out[onset] = np.exp(power - gammaln(1.0 + self._order))
        return out

    def _sf(self, x: Array) -> Array:
        t = self._t(x)
        if self._order == 1.0:
            return np.exp(-t)
        if self._order == 2.0:
            return (1.0 + t) * np.exp(-t)
        out = gammaincc(self._order, t)
        onset = t < _SMALL
        if onset.any():  # t may have underflowed where the cdf has not
            out[onset] = 1.0 - self._cdf(x[onset])
        return out

    def _logsf(self, x: Array) -> Array:
        t = self._t(x)
        if self._order == 1.0:
            return -t
        if self._order == 2.0:
            return self._near_one(x, np.log1p(t) - t)
        with np.errstate(divide="ignore"):
            survival = gammaincc(self._order, t)
            out = self._near_one(x, np.log(survival))
        far = survival < _FAR
        if far.any():
            t = t[far]
            rest = (1.0 + _TAIL_NODES / t[:, None]) ** (self._order - 1.0) @ _TAIL_WEIGHTS
            out[far] = (self._order - 1.0) * np.log(t) - t - gammaln(self._order) + np.log(rest)
        return out

    def _ppf(self, q: Array) -> Array:
        t = -np.log1p(-q) if self._order == 1.0 else gammaincinv(self._order, q)
        onset = np.exp((np.log(q) + gammaln(1.0 + self._order)) / (self.onset_power + 1.0))
        return self.width * np.where(t < _SMALL, onset, t ** (1.0 / self.decay))

    def _isf(self, q: Array) -> Array:
        if self._order == 1.0:
            return self.width * (-np.log(q)) ** (1.0 / self.decay)
        # near 1 q holds no more digits than its complement; and t may underflow where x does not
        t = gammainccinv(self._order, q)
        far = self.width * t ** (1.0 / self.decay)
        near = self._ppf(np.maximum(1.0 - q, np.finfo(float).tiny))
        return np.where((q < 0.5) & (t > _SMALL), far, near)

    def _moment(self, n: int) -> float:
        with np.errstate(over="ignore"):
            return float(np.float64(self.width) ** n * poch(self._order, n / self.decay))
