"""Persson's thresholds: local normal stress turned into stretch (paper, Eq. PcPersson3)."""

import numpy as np
from scipy.special import erf, erfc, erfcinv, erfcx, exprel, gamma

from origins.errors import non_negative, positive, refuse
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, Thresholds

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
_FURTHEST = 1e6  # centre over width
_HEAVY = 40.0  # a above which the second Gaussian is nothing, and x is smooth over the first
_DEVIATIONS, _BELL = np.polynomial.hermite.hermgauss(64)
_BELL = _BELL / _BELL.sum()


def persson(centre: float, width: float) -> Thresholds:
    """P_c ~ x {exp[-((x^2 - c^2)/w^2)^2] - exp[-((x^2 + c^2)/w^2)^2]} (paper, Eq. PcPersson3).

    c = centre >= 0 and w = width > 0 are lengths, else InputError. centre = 0 is the limit of light load,
    P_c ~ x^3 exp(-(x/w)^4). Heavy load tends to a normal law of standard deviation w²/(2^(3/2) c); centre/width above
    1e6, where that nears the round-off of x, is refused.
    """
    centre, width = non_negative("centre", centre), positive("width", width)
    if centre > _FURTHEST * width:
        one = f"take identical, value = {centre:g}"
        refuse("centre", centre, f"is more than {_FURTHEST:g} widths: one value to round-off; {one}")
    return Persson(centre, width)


class Persson(Thresholds):
    """Written in f = (x/w)^2 and a = (c/w)^2, where S = [erfc(f - a) - erfc(f + a)] / (2 erf a)."""

    onset_power = 3.0

    def __init__(self, centre: float, width: float) -> None:
        self.centre, self.width = centre, width
        self._a = (centre / width) ** 2
        # (2a/sqrt(pi)) / erf(a), 1 at a = 0
        self._kappa = 2.0 * self._a / np.sqrt(np.pi) / float(erf(self._a)) if self._a > 0.0 else 1.0

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _f(self, x: Array) -> tuple[Array, Array]:
        """f and f - a, the latter without cancellation near x = c."""
        x = np.minimum(x, 1e75 * self.width)
        u = x / self.width
        # the difference of the lengths themselves is exact
        return u * u, (x - self.centre) / self.width * ((x + self.centre) / self.width)

    def _pdf(self, x: Array) -> Array:
        f, away = self._f(x)
        rise = 4.0 * self._kappa / self.width * (x / self.width) * exprel(-4.0 * self._a * f)
        return rise * (f * np.exp(-away * away))

    def _logpdf(self, x: Array) -> Array:
        f, away = self._f(x)
        with np.errstate(divide="ignore"):
            rise = 3.0 * np.log(x / self.width) + np.log(exprel(-4.0 * self._a * f))
        return np.log(4.0 * self._kappa / self.width) + rise - away * away

    def _series(self, f: Array) -> Array:
        """Integral of cosh(2 a f s) exp(-(a s)^2) over s in (0, 1), for a < 1/2 and 4 a f < 1."""
        s = self._a * _NODES
        return (np.cosh(2.0 * f[..., None] * s) * (np.exp(-s * s) * _WEIGHTS)).sum(-1)

    def _tail(self, x: Array) -> tuple[Array, Array]:
        """S as factor times exp(-power), without cancellation for any a; for x where S is not near 1."""
        f, away = self._f(x)
        a = self._a
        scaled = erfcx(np.maximum(away, 0.0)) - erfcx(f + a) * np.exp(-4.0 * a * f)
        factor, power = 0.5 * scaled / max(float(erf(a)), 1e-300), away * away
        left = away < 0.0
        if left.any():
            factor[left] = 0.5 * (erfc(away[left]) - erfc(f[left] + a)) / max(float(erf(a)), 1e-300)
            power[left] = 0.0
        close = (4.0 * a * f < 1.0) if a < 0.5 else np.zeros(f.shape, dtype=bool)
        if close.any():
            factor[close] = self._kappa * self._series(f[close])
            power[close] = f[close] ** 2
        return factor, power

    def _sf(self, x: Array) -> Array:
        factor, power = self._tail(x)
        return np.minimum(factor * np.exp(-power), 1.0)

    def _cdf(self, x: Array) -> Array:
        f, away = self._f(x)
        a = self._a
        out = 1.0 - self._sf(x)
        # near the onset the cdf is a second difference of erf: integrate f exp(-f^2) sinh(2 a f) instead
        onset = (f < 1.0) & (2.0 * a * f < 4.0)
        if onset.any():
            t = f[onset][..., None] * _NODES
            shape = t * np.exp(-t * t) * (exprel(4.0 * a * t) * np.exp(-2.0 * a * t))
            out[onset] = 2.0 * self._kappa * np.exp(-a * a) * f[onset] * (shape * _WEIGHTS).sum(-1)
        rising = ~onset & (away < 0.0)
        if rising.any():
            out[rising] = 0.5 * (erfc(-away[rising]) - 2.0 * erfc(a) + erfc(f[rising] + a)) / erf(a)
        return out

    def _logsf(self, x: Array) -> Array:
        factor, power = self._tail(x)
        with np.errstate(divide="ignore"):
            out = np.log(factor) - power
        near = out > -0.5
        if near.any():
            out[near] = np.log1p(-self._cdf(x[near]))
        return out

    def _from_hazard(self, hazard: Array) -> Array:
        a, flat = self._a, hazard.ravel()
        right = a + np.sqrt(flat) + 1.0  # S there is below exp(-hazard) for every a
        survival = np.exp(-flat)
        with np.errstate(divide="ignore", over="ignore"):
            beside = np.where(survival > 1e-300, a + erfcinv(2.0 * survival), a + np.sqrt(flat))
            onset = np.sqrt(np.minimum(flat, 1.0) / self._kappa) * np.exp(min(0.5 * a * a, 300.0))
        guess = np.where(beside * max(a, 1.0) > 1.0, beside, onset) if a > 1.0 else np.sqrt(flat) + 0.5 * a
        lengths = (self.width * np.sqrt(np.maximum(f, 0.0)) for f in (np.zeros(flat.shape), right, guess))
        return invert_hazard(self, flat, *lengths).reshape(hazard.shape)

    def _ppf(self, q: Array) -> Array:
        return self._from_hazard(-np.log1p(-q))

    def _isf(self, q: Array) -> Array:
        return self._from_hazard(-np.log(q))

    def _moment(self, n: int) -> float:
        if self._a == 0.0:
            return self.width**n * float(gamma(1.0 + n / 4.0))
        if self._a > _HEAVY:
            return self.centre**n * float((_BELL * (1.0 + self._offset()) ** n).sum())
        return super()._moment(n)

    def _variance(self) -> float:
        if self._a > _HEAVY:
            offset = self._offset()
            return self.centre**2 * float((_BELL * (offset - float((_BELL * offset).sum())) ** 2).sum())
        return super()._variance()

    def _offset(self) -> Array:
        """x/c - 1 where f - a stands at the nodes of a normal law, which f - a follows at heavy load."""
        return np.expm1(0.5 * np.log1p(_DEVIATIONS / self._a))
