"""Families of thresholds: one value, rectangles, exponential summits, lubricant films, Persson's stresses."""

import numpy as np
import scipy

from origins.errors import between, finite, non_negative, positive, refuse
from origins.thresholds.law import Array, Thresholds

_STEEPEST, _SLOWEST = 100.0, 0.1  # limits of powers and decays, for quantiles in floats


def identical(value: float) -> Thresholds:
    """P_c(x) = delta(x - value); value is a length above zero, else InputError (paper, App. E)."""
    return Identical(positive("value", value))


def rectangular(lower: float, upper: float) -> Thresholds:
    """P_c constant on (lower, upper), lengths with 0 <= lower < upper, else InputError (paper, Eq. Q22a)."""
    lower, upper = non_negative("lower", lower), positive("upper", upper)
    if not upper > lower:
        value = f"for one value take identical, value = {lower:g}"
        refuse("upper", upper, f"must lie above lower = {lower:g}; {value}")
    return Rectangular(lower, upper)


class Rectangular(Thresholds):
    """The uniform law on (lower, upper)."""

    onset_power = 0.0

    def __init__(self, lower: float, upper: float) -> None:
        self._lower, self._upper = self._support = lower, upper
        self._width = upper - lower

    def _pdf(self, x: Array) -> Array:
        return np.full(x.shape, 1.0 / self._width)

    def _cdf(self, x: Array) -> Array:
        return (x - self._lower) / self._width

    def _sf(self, x: Array) -> Array:
        return (self._upper - x) / self._width

    def _quantiles(self, below: Array, above: Array) -> Array:
        from_lower = self._lower + self._width * below
        return np.where(below < above, from_lower, self._upper - self._width * above)


class Identical(Thresholds):
    """All weight in one atom; the density is zero everywhere."""

    def __init__(self, value: float) -> None:
        self._value, self._support = value, (value, value)
        self.breakpoints, self.atoms = np.array([value]), (np.array([value]), np.ones(1))

    def _pdf(self, x: Array) -> Array:
        return np.zeros(x.shape)

    def _quantiles(self, below: Array, above: Array) -> Array:
        return np.full(below.shape, self._value)

    def _moment(self, n: float, centre: float = 0.0) -> float:
        return (self._value - centre) ** n


def gw_elastic(B: float) -> Thresholds:
    """Elastic contacts, P_c ~ x^(1/3) exp(-B x^(4/3)) (paper, Eq. GW3).

    B is in length^(-4/3); InputError unless it is finite and above zero.
    """
    return Weibull(4.0 / 3.0, positive("B", B))


def gw_plastic(B: float) -> Thresholds:
    """Plastic contacts, P_c ~ x exp(-B x^2) (paper, Eq. GW4).

    B is in length^-2; InputError unless it is finite and above zero.
    """
    return Weibull(2.0, positive("B", B))


def lubricated(width: float, power: float = 3.0, decay: float = 2.0) -> Thresholds:
    """P_c ~ x^power exp(-(x/width)^decay), a generalised gamma law; left out, the fit (paper, Eq. Pcrotate).

    width is a length above zero, power a number above -1 and up to 100, decay one from 0.1 to 100; else InputError.
    Forces distributed as f^a exp(-f/f0) with f_s = c x_s² give power = 2a + 1, decay = 2 and width = (f0/c)^(1/2).
    """
    width, power = positive("width", width), finite("power", power)
    if not -1.0 < power <= _STEEPEST:
        refuse("power", power, f"must be above -1, or P_c has no norm, and at most {_STEEPEST:g}")
    return GeneralisedGamma(width, power, between("decay", decay, _SLOWEST, _STEEPEST, "take 2"))


class GeneralisedGamma(Thresholds):
    """P_c ~ x^power exp(-(x/width)^decay), power > -1, decay > 0, given by its density and its moments."""

    def __init__(self, width: float, power: float, decay: float) -> None:
        self._width, self.onset_power, self._decay = width, power, decay
        self._order = (power + 1.0) / decay
        self._log_front = float(np.log(decay / width) - scipy.special.gammaln(self._order))

    def _logpdf(self, x: Array) -> Array:
        u = x / self._width
        with np.errstate(divide="ignore", over="ignore"):
            return self._log_front + scipy.special.xlogy(self.onset_power, u) - u**self._decay

    def _moment(self, n: float, centre: float = 0.0) -> float:
        if centre != 0.0:
            return super()._moment(n, centre)
        with np.errstate(over="ignore"):
            at_width_one = scipy.special.poch(self._order, n / self._decay)
            return float(np.float64(self._width) ** n * at_width_one)


class Weibull(GeneralisedGamma):
    """S(x) = exp(-rate x^shape), whose density rises as x^(shape - 1)."""

    def __init__(self, shape: float, rate: float) -> None:
        super().__init__(rate ** (-1.0 / shape), shape - 1.0, shape)

    def _logsf(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            return -((x / self._width) ** self._decay)

    def _sf(self, x: Array) -> Array:
        return np.exp(self._logsf(x))

    def _cdf(self, x: Array) -> Array:
        return -np.expm1(self._logsf(x))

    def _quantiles(self, below: Array, above: Array) -> Array:
        log_survival = np.where(below < above, np.log1p(-np.minimum(below, 0.5)), np.log(above))
        return self._width * (-log_survival) ** (1.0 / self._decay)


def persson(centre: float, width: float) -> Thresholds:
    """P_c ~ x {exp[-((x^2 - c^2)/w^2)^2] - exp[-((x^2 + c^2)/w^2)^2]} (paper, Eq. PcPersson3).

    c = centre >= 0 and w = width > 0 are lengths, else InputError. centre = 0 is the limit of light load,
    P_c ~ x^3 exp(-(x/w)^4). Heavy load tends to a normal law of standard deviation w²/(2^(3/2) c); centre/width above
    100, where it differs from that by 1e-4, is refused.
    """
    centre, width = non_negative("centre", centre), positive("width", width)
    if centre > 100.0 * width:
        std = width / centre * width / np.sqrt(8.0)
        hint = "is more than 100 widths, a normal law to 1e-4: take gaussian"
        refuse("centre", centre, f"{hint}, mean = {centre:g}, std = {std:.9g}")
    return Persson(centre, width)


class Persson(Thresholds):
    """Written in f = (x/w)^2 and a = (c/w)^2, where P_c dx ~ {exp[-(f - a)^2] - exp[-(f + a)^2]} df."""

    onset_power = 3.0

    def __init__(self, centre: float, width: float) -> None:
        self._centre, self._width, self._a = centre, width, (centre / width) ** 2
        # (2a/sqrt(pi)) / erf(a), 1 at a = 0
        erf = float(scipy.special.erf(self._a))
        kappa = 2.0 * self._a / np.sqrt(np.pi) / erf if self._a > 0.0 else 1.0
        self._log_front = float(np.log(4.0 * kappa / width))

    def _logpdf(self, x: Array) -> Array:
        u = x / self._width
        with np.errstate(divide="ignore", over="ignore"):
            # f - a, without the cancellation
            off = (x - self._centre) / self._width * ((x + self._centre) / self._width)
            peaks = np.log(scipy.special.exprel(-4.0 * self._a * u * u)) - off * off
            return self._log_front + 3.0 * np.log(u) + peaks
