"""Summits of exponential heights and lubricant films: P_c ~ x^m exp(-(x/w)^p) (paper, Eqs. GW3, GW4, Pcrotate)."""

import numpy as np
from scipy.special import gamma, poch, xlogy

from origins.errors import finite, positive, refuse
from origins.thresholds.law import Array, Thresholds

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
    """P_c ~ x^power exp(-(x/width)^decay), power > -1, decay > 0, from its density and its moments."""

    def __init__(self, width: float, power: float, decay: float) -> None:
        self.width, self.onset_power, self.decay = width, power, decay

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _log_weight(self, x: Array) -> Array:
        with np.errstate(divide="ignore", over="ignore"):
            return xlogy(self.onset_power, x / self.width) - (x / self.width) ** self.decay

    def _moment(self, n: int) -> float:
        order = (self.onset_power + 1.0) / self.decay
        with np.errstate(over="ignore"):
            return float(np.float64(self.width) ** n * poch(order, n / self.decay))


class Weibull(Thresholds):
    """S(x) = exp(-rate x^shape); power = shape - 1 is the onset."""

    def __init__(self, shape: float, rate: float, power: float) -> None:
        self._shape, self._width, self.onset_power = shape, rate ** (-1.0 / shape), power
        self._log_front = float(np.log(shape / self._width))

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            return self._log_front + xlogy(self.onset_power, x / self._width) + self._logsf(x)

    def _logsf(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            return -((x / self._width) ** self._shape)

    def _sf(self, x: Array) -> Array:
        return np.exp(self._logsf(x))

    def _cdf(self, x: Array) -> Array:
        return -np.expm1(self._logsf(x))

    def _from_hazard(self, hazard: Array) -> Array:
        return self._width * hazard ** (1.0 / self._shape)

    def _moment(self, n: int) -> float:
        with np.errstate(over="ignore"):
            return float(np.float64(self._width) ** n * gamma(1.0 + n / self._shape))
