"""Families of thresholds: one value, rectangles, exponential summits, lubricant films, Persson's stresses."""

import numpy as np
from scipy.special import erf, exprel, gamma, log_ndtr, ndtr, poch, xlogy

from origins.errors import finite, non_negative, positive, refuse
from origins.thresholds.law import Array, Thresholds

_STEEPEST, _SLOWEST = 100.0, 0.1  # limits of powers and decays, for quantiles in floats
_FURTHEST = 1e6  # largest centre over width of Persson's law
_HEAVY = 40.0  # (centre/width)^2 above which the weight near x = 0 is below the smallest float


def identical(value: float) -> Thresholds:
    """P_c(x) = delta(x - value); value is a length above zero, else InputError (paper, App. E)."""
    return Identical(positive("value", value))


def rectangular(lower: float, upper: float) -> Thresholds:
    """P_c constant on (lower, upper), lengths with 0 <= lower < upper, else InputError (paper, Eq. Q22a)."""
    lower, upper = non_negative("lower", lower), positive("upper", upper)
    if not upper > lower:
        one = f"for one value take identical, value = {lower:g}"
        refuse("upper", upper, f"must lie above lower = {lower:g}; {one}")
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

    def _ppf(self, q: Array) -> Array:
        return self.lower + self._width * q

    def _isf(self, q: Array) -> Array:
        return self.upper - self._width * q

    def _variance(self) -> float:
        return self._width**2 / 12.0


class Identical(Rectangular):
    """A rectangle of no width, all weight in one atom; pdf is zero everywhere."""

    onset_power = np.inf

    def __init__(self, value: float) -> None:
        super().__init__(value, value)

    @property
    def breakpoints(self) -> Array:
        return np.array([self.lower])

    @property
    def atoms(self) -> tuple[Array, Array]:
        return np.array([self.lower]), np.array([1.0])

    def _pdf(self, x: Array) -> Array:
        return np.zeros(x.shape)

    def _moment(self, n: float) -> float:
        return self.lower**n


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
    """P_c ~ x^power exp(-(x/width)^decay), power > -1, decay > 0, given by its density and its moments."""

    def __init__(self, width: float, power: float, decay: float) -> None:
        self.width, self.onset_power, self.decay = width, power, decay

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _log_weight(self, x: Array) -> Array:
        with np.errstate(divide="ignore", over="ignore"):
            return xlogy(self.onset_power, x / self.width) - (x / self.width) ** self.decay

    def _moment(self, n: float) -> float:
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

    def _ppf(self, q: Array) -> Array:
        return self._width * (-np.log1p(-q)) ** (1.0 / self._shape)

    def _isf(self, q: Array) -> Array:
        return self._width * (-np.log(q)) ** (1.0 / self._shape)

    def _moment(self, n: float) -> float:
        with np.errstate(over="ignore"):
            return float(np.float64(self._width) ** n * gamma(1.0 + n / self._shape))


def persson(centre: float, width: float) -> Thresholds:
    """P_c ~ x {exp[-((x^2 - c^2)/w^2)^2] - exp[-((x^2 + c^2)/w^2)^2]} (paper, Eq. PcPersson3).

    c = centre >= 0 and w = width > 0 are lengths, else InputError. centre = 0 is the limit of light load,
    P_c ~ x^3 exp(-(x/w)^4). Heavy load tends to a normal law of standard deviation w²/(2^(3/2) c); centre/width above
    1e6, where that nears the round-off of x, is refused.
    """
    centre, width = non_negative("centre", centre), positive("width", width)
    if centre > _FURTHEST * width:
        one = f"take identical, value = {centre:g}"
        rule = f"is more than {_FURTHEST:g} widths: one value to round-off; {one}"
        refuse("centre", centre, rule)
    return (HeavyPersson if (centre / width) ** 2 > _HEAVY else Persson)(centre, width)


class Persson(Thresholds):
    """Written in f = (x/w)^2 and a = (c/w)^2, where P_c dx ~ {exp[-(f - a)^2] - exp[-(f + a)^2]} df."""

    onset_power = 3.0

    def __init__(self, centre: float, width: float) -> None:
        self.centre, self.width = centre, width
        self._a = (centre / width) ** 2
        # (2a/sqrt(pi)) / erf(a), 1 at a = 0
        kappa = 2.0 * self._a / np.sqrt(np.pi) / float(erf(self._a)) if self._a > 0.0 else 1.0
        self._log_front = float(np.log(4.0 * kappa / width))

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _off(self, x: Array) -> Array:
        """f - a, without the cancellation."""
        with np.errstate(over="ignore"):
            return (x - self.centre) / self.width * ((x + self.centre) / self.width)

    def _logpdf(self, x: Array) -> Array:
        u = x / self.width
        with np.errstate(divide="ignore", over="ignore"):
            peaks = np.log(exprel(-4.0 * self._a * u * u)) - self._off(x) ** 2
            return self._log_front + 3.0 * np.log(u) + peaks


class HeavyPersson(Persson):
    """Under a heavy load f - a is normal, of variance 1/2; in closed form, as x may be all but one value."""

    def _cdf(self, x: Array) -> Array:
        return ndtr(np.sqrt(2.0) * self._off(x))

    def _sf(self, x: Array) -> Array:
        return ndtr(-np.sqrt(2.0) * self._off(x))

    def _logsf(self, x: Array) -> Array:
        return self._near_one(x, log_ndtr(-np.sqrt(2.0) * self._off(x)))

    def _rises(self) -> tuple[Array, Array]:
        """x/c - 1 at nodes of Gauss and Hermite, and their weights."""
        nodes, weights = np.polynomial.hermite.hermgauss(40)
        return np.expm1(0.5 * np.log1p(nodes / self._a)), weights / weights.sum()

    def _moment(self, n: float) -> float:
        rises, weights = self._rises()
        return float(self.centre**n * (weights @ (1.0 + rises) ** n))

    def _variance(self) -> float:
        rises, weights = self._rises()
        return float(self.centre**2 * (weights @ (rises - weights @ rises) ** 2))
