"""Thresholds whose power a positive power of x follows a gamma law: P_c ~ x^m exp(-(x/w)^p)."""

import numpy as np
from scipy.special import gammainc, gammaincc, gammainccinv, gammaincinv, gammaln, poch, xlogy

from origins.thresholds.law import Array, Thresholds

_NODES, _WEIGHTS = np.polynomial.laguerre.laggauss(40)
_SMALL = 1e-20  # t below which the cdf is its leading power, even where t itself underflows
_FAR = 1e-280
_MOST = 1e300


class GeneralisedGamma(Thresholds):
    """t = (x/width)^decay follows the gamma law of shape a = (power + 1)/decay; power > -1, decay > 0."""

    def __init__(self, width: float, power: float, decay: float) -> None:
        self.width, self.onset_power, self.decay = width, power, decay
        self._shape = (power + 1.0) / decay
        self._log_front = float(np.log(decay / width) - gammaln(self._shape))

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
        out = gammainc(self._shape, t)
        onset = t < _SMALL
        power = (self.onset_power + 1.0) * np.log(x[onset] / self.width)
        out[onset] = np.exp(power - gammaln(1.0 + self._shape))
        return out

    def _sf(self, x: Array) -> Array:
        t = self._t(x)
        out = gammaincc(self._shape, t)
        onset = t < _SMALL
        # t may have underflowed where the cdf has not
        out[onset] = 1.0 - self._cdf(x[onset])
        return out

    def _logsf(self, x: Array) -> Array:
        t = self._t(x)
        survival = gammaincc(self._shape, t)
        with np.errstate(divide="ignore"):
            out = np.log(survival)
        near, far = survival > 0.6, survival < _FAR
        out[near] = np.log1p(-self._cdf(x[near]))
        if far.any():
            t = t[far]
            rest = (1.0 + _NODES / t[:, None]) ** (self._shape - 1.0) @ _WEIGHTS
            out[far] = (self._shape - 1.0) * np.log(t) - t - gammaln(self._shape) + np.log(rest)
        return out

    def _ppf(self, q: Array) -> Array:
        t = gammaincinv(self._shape, q)
        onset = np.exp((np.log(q) + gammaln(1.0 + self._shape)) / (self.onset_power + 1.0))
        return self.width * np.where(t < _SMALL, onset, t ** (1.0 / self.decay))

    def _isf(self, q: Array) -> Array:
        # near 1 q holds no more digits than its complement; and t may underflow where x does not
        t = gammainccinv(self._shape, q)
        far = self.width * t ** (1.0 / self.decay)
        near = self._ppf(np.maximum(1.0 - q, np.finfo(float).tiny))
        return np.where((q < 0.5) & (t > _SMALL), far, near)

    def _moment(self, n: int) -> float:
        return self.width**n * float(poch(self._shape, n / self.decay))
