"""Summits of exponential heights and lubricant films: P_c ~ x^m exp(-(x/w)^p) (paper, Eqs. GW3, GW4, Pcrotate)."""

import numpy as np
from scipy.special import gammainc, gammaincc, gammainccinv, gammaincinv, gammaln, poch, xlogy

from origins.errors import finite, positive, refuse
from origins.thresholds.law import Array, Thresholds

_TAIL_NODES, _TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(40)
_SMALL = 1e-20  # t below which the cdf is its leading power, even where t itself underflows
_FAR = 1e-280  # survival below which it is an integral along the tail
_MOST = 1e300  # t at most, so that its square roots and logarithms stay numbers
_STEEPEST, _SLOWEST = 100.0, 0.1  # powers and decays whose quantiles floats still tell apart


def gw_elastic(B: float) -> Thresholds:
    """Elastic contacts, P_c ~ x^(1/3) exp(-B x^(4/3)) (paper, Eq. GW3).

    B is in length^(-4/3); InputError unless it is finite and above zero.
    """
    return Weibull(4.0 / 3.0, positive("B", B), 1.0 / 3.0)


def gw_plastic(B: float) -> Thresholds:
    """Plastic contacts, P_c ~ x exp(-B x^2) (paper, Eq. GW4).

    B is in length^-2; InputError unless it is finite and above zero.
    """
    return Weibull(2.0, positive("B", B), 1.0)


def lubricated(width: float, power: float = 3.0, decay: float = 2.0) -> Thresholds:
    """P_c ~ x^power exp(-(x/width)^decay), a generalised gamma law; left out, the fit (paper, Eq. Pcrotate).

    width is a length above zero, power a number above -1 and up to 100, decay one from 0.1 to 100; else InputError.
    Forces distributed as f^a exp(-f/f0) with f_s = c x_s² give power = 2a + 1, decay = 2 and width = (f0/c)^(1/2).
    """
    width, power, decay = positive("width", width), finite("power", power), finite("decay", decay)
    if not -1.0 < power <= _STEEPEST:
        refuse("power", power, f"must be above -1, or P_c has no norm, and at most {_STEEPEST:g}")
    if not _SLOWEST <= decay <= _STEEPEST:
        refuse("decay", decay, f"must lie between {_SLOWEST:g} and {_STEEPEST:g}")
    return GeneralisedGamma(width, power, decay)


class GeneralisedGamma(Thresholds):
    """t = (x/width)^decay follows the gamma law of the order a = (power + 1)/decay; power > -1, decay > 0.

    order : a, where it is known without rounding. At a = 1, a Weibull law, S = e^-t.
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
        out = gammaincc(self._order, t)
        onset = t < _SMALL
        if onset.any():  # t may have underflowed where the cdf has not
            out[onset] = 1.0 - self._cdf(x[onset])
        return out

    def _logsf(self, x: Array) -> Array:
        t = self._t(x)
        if self._order == 1.0:
            return -t
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


class Weibull(GeneralisedGamma):
    """S(x) = exp(-rate x^shape); power = shape - 1 is the onset."""

    def __init__(self, shape: float, rate: float, power: float) -> None:
        super().__init__(rate ** (-1.0 / shape), power, shape, order=1.0)
