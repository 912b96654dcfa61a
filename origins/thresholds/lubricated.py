"""Thresholds of a thin lubricant film, fitted to molecular dynamics (paper, Eq. Pcrotate)."""

import numpy as np
from scipy.special import gamma, gammainc, gammaincinv, lambertw

from origins.errors import finite, positive, refuse
from origins.thresholds.generalised_gamma import GeneralisedGamma
from origins.thresholds.law import Array, Thresholds

_STEEPEST = 100.0
_SLOWEST = 0.1


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
    return Lubricated(width) if (power, decay) == (3.0, 2.0) else GeneralisedGamma(width, power, decay)


class Lubricated(Thresholds):
    """t = (x / width)^2 follows the gamma law of shape 2: S = (1 + t) e^-t."""

    onset_power = 3.0

    def __init__(self, width: float) -> None:
        self.width = width

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _t(self, x: Array) -> Array:
        with np.errstate(over="ignore", under="ignore"):
            return np.minimum((x / self.width) ** 2, 1e300)

    def _pdf(self, x: Array) -> Array:
        t = self._t(x)
        return 2.0 / self.width * (x / self.width) * (t * np.exp(-t))

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            return np.log(2.0 / self.width) + 3.0 * np.log(x / self.width) - self._t(x)

    def _cdf(self, x: Array) -> Array:
        return gammainc(2.0, self._t(x))

    def _sf(self, x: Array) -> Array:
        t = self._t(x)
        return (1.0 + t) * np.exp(-t)

    def _logsf(self, x: Array) -> Array:
        t = self._t(x)
        near = t < 0.5
        with np.errstate(divide="ignore"):
            return np.where(near, np.log1p(-gammainc(2.0, np.where(near, t, 0.0))), np.log1p(t) - t)

    def _ppf(self, q: Array) -> Array:
        return self.width * np.sqrt(gammaincinv(2.0, q))

    def _isf(self, q: Array) -> Array:
        # (1 + t) e^-t = q is Lambert's equation; near t = 0 its branch point eats half the digits
        far = q < 0.5
        t = -1.0 - lambertw(-np.where(far, q, 0.5) / np.e, -1).real
        return self.width * np.sqrt(np.where(far, t, gammaincinv(2.0, 1.0 - q)))

    def _moment(self, n: int) -> float:
        return self.width**n * float(gamma(2.0 + n / 2.0))
