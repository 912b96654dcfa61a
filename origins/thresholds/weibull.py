"""Greenwood-Williamson thresholds for exponential heights: Weibull laws (paper, Eqs. GW3, GW4)."""

import numpy as np
from scipy.special import gamma

from origins.errors import positive
from origins.thresholds.law import Array, Thresholds


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


class Weibull(Thresholds):
    """S(x) = exp(-B x^shape); power = shape - 1 is the onset."""

    def __init__(self, shape: float, rate: float, power: float) -> None:
        self.shape = shape
        self.scale = rate ** (-1.0 / shape)
        self.onset_power = power

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _hazard(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            return (x / self.scale) ** self.shape

    def _pdf(self, x: Array) -> Array:
        return self.shape / self.scale * (x / self.scale) ** self.onset_power * np.exp(-self._hazard(x))

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            rise = self.onset_power * np.log(x / self.scale)
        return np.log(self.shape / self.scale) + rise - self._hazard(x)

    def _cdf(self, x: Array) -> Array:
        return -np.expm1(-self._hazard(x))

    def _sf(self, x: Array) -> Array:
        return np.exp(-self._hazard(x))

    def _logsf(self, x: Array) -> Array:
        return -self._hazard(x)

    def _ppf(self, q: Array) -> Array:
        return self.scale * (-np.log1p(-q)) ** (1.0 / self.shape)

    def _isf(self, q: Array) -> Array:
        return self.scale * (-np.log(q)) ** (1.0 / self.shape)

    def _moment(self, n: int) -> float:
        with np.errstate(over="ignore"):
            return float(np.float64(self.scale) ** n * gamma(1.0 + n / self.shape))
