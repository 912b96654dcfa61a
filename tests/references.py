"""The threshold families in mpmath: the survival straight from the definition, all else from that by calculus."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mpmath
import numpy as np

import origins

mp = mpmath.MPContext()  # a context of its own: other tests keep their digits
mp.dps = 130  # so that 1 - survival is known where it is 1e-30, and its slope beside
Function = Callable[[mp.mpf], mp.mpf]


@dataclass(frozen=True)
class Reference:
    """A law of origins, and its survival in mpmath."""

    law: origins.Thresholds
    sf: Function

    def __post_init__(self) -> None:
        object.__setattr__(self, "moment", cache(self.moment))
        object.__setattr__(self, "held", cache(self.sf))  # moments take it at the same stretches

    def cdf(self, x: mp.mpf) -> mp.mpf:
        return 1 - self.sf(x)

    def pdf(self, x: mp.mpf) -> mp.mpf:
        return -mp.diff(self.sf, x)

    def moment(self, n: int) -> mp.mpf:
        """<x^n> = n times the integral of x^(n-1) sf, in lengths of the mean, cut at quantiles."""
        law, unit = self.law, mp.mpf(float(self.law.mean()))
        quantiles = [*law.ppf([1e-9, 1e-3, 0.1]), *law.isf(10.0 ** -np.array([0.3, 1, 3, 7, 20]))]
        ends = [0.0, *law.support(), *law.breakpoints, *quantiles]
        marks = {mp.mpf(float(x)) / unit for x in ends}
        with mp.workdps(25):
            return unit**n * mp.quad(
                lambda y: n * y ** (n - 1) * self.held(unit * y), sorted(marks)
            )


def weibull(law: origins.Thresholds, shape: mp.mpf, rate: float) -> Reference:
    return Reference(law, lambda x: mp.exp(-mp.mpf(rate) * x**shape))


def gw_elastic(rate: float) -> Reference:
    return weibull(origins.gw_elastic(rate), mp.mpf(4) / 3, rate)


def gw_plastic(rate: float) -> Reference:
    return weibull(origins.gw_plastic(rate), mp.mpf(2), rate)


def rectangular(lower: float, upper: float) -> Reference:
    a, b = mp.mpf(lower), mp.mpf(upper)
    law = origins.rectangular(lower, upper)
    return Reference(law, lambda x: min(max((b - x) / (b - a), mp.mpf(0)), mp.mpf(1)))


def lubricated(width: float, power: float = 3.0, decay: float = 2.0) -> Reference:
    """P_c ~ x^power exp(-(x/width)^decay)."""
    w, p, a = mp.mpf(width), mp.mpf(decay), (mp.mpf(power) + 1) / mp.mpf(decay)
    law = origins.lubricated(width, power, decay)
    return Reference(law, lambda x: mp.gammainc(a, (x / w) ** p, mp.inf, regularized=True))


def psi(y: mp.mpf) -> mp.mpf:
    """-log of the share of Lifshitz and Slyozov's grains above u = 3 y/2."""
    return mp.mpf(4) / 3 * mp.log1p(y / 2) + mp.mpf(5) / 3 * mp.log1p(-y) + y / (1 - y)


def grains(rho: float, B: float) -> Reference:
    """Exact Jacobian: the survival e^-psi of sizes u = (1 + B x²)^(1/2)/rho, beyond 1/rho."""
    first = 2 / (3 * mp.mpf(rho))

    def sf(x: mp.mpf) -> mp.mpf:
        y = mp.sqrt(1 + mp.mpf(B) * x * x) * first
        return mp.exp(psi(first) - psi(y)) if y < 1 else mp.mpf(0)

    return Reference(origins.grains(rho, B=B), sf)


def persson(centre: float, width: float) -> Reference:
    """As printed: a difference of error functions. centre = 0 is a Weibull law of shape 4."""
    if centre == 0.0:
        return weibull(origins.persson(0.0, width), mp.mpf(4), mp.mpf(width) ** -4)
    w, a = mp.mpf(width), (mp.mpf(centre) / mp.mpf(width)) ** 2
    whole = 2 * mp.erf(a)

    def sf(x: mp.mpf) -> mp.mpf:
        f = (x / w) ** 2
        return (mp.erfc(f - a) - mp.erfc(f + a)) / whole

    return Reference(origins.persson(centre, width), sf)


def tail(z: mp.mpf) -> mp.mpf:
    """Share of a normal law beyond z standard deviations."""
    return mp.erfc(z / mp.sqrt(2)) / 2


def gaussian(mean: float, std: float) -> Reference:
    m, s = mp.mpf(mean), mp.mpf(std)
    whole = tail(-m / s)
    return Reference(origins.gaussian(mean, std), lambda x: tail((x - m) / s) / whole)


def gw_gaussian(
    separation: float, scale: float, law: str, regime: str, index: float | None = None
) -> Reference:
    """Summits: survival Phi_c(z + delta)/Phi_c(z), x = scale delta^b with a bend where contacts turn plastic."""
    z, unit = mp.mpf(separation), mp.mpf(scale)
    elastic, plastic = {"paper": (0.75, 0.5), "amontons": (1.0, 0.5), "strength": (0.5, 0.5)}[law]
    first, last = mp.mpf(plastic if regime == "plastic" else elastic), mp.mpf(plastic)
    at = mp.inf if index is None else (9 * mp.pi / (4 * mp.mpf(index))) ** 2
    mark = unit * at ** (first if at > 1 else last) if index is not None else mp.inf

    def pressed(x: mp.mpf) -> mp.mpf:
        if index is None:
            return (x / unit) ** (1 / first)
        return at * (x / mark) ** (1 / (first if x < mark else last))

    whole = tail(z)
    own = origins.gw_gaussian(separation, scale, law=law, regime=regime, plasticity_index=index)
    return Reference(own, lambda x: tail(z + pressed(x)) / whole)


def chord_gaussian(mean: float, std: float, upper: float) -> Reference:
    """A Gaussian less the chord from 0 to `upper`, where that is positive."""
    m, s, top = mp.mpf(mean), mp.mpf(std), mp.mpf(upper)

    def normal(x: mp.mpf) -> mp.mpf:
        return mp.exp(-(((x - m) / s) ** 2) / 2)

    slope = (normal(top) - normal(mp.mpf(0))) / top

    def height(x: mp.mpf) -> mp.mpf:
        return normal(x) - normal(mp.mpf(0)) - slope * x

    # ends of the positive piece, by halving between the mean and the interval's ends
    ends = []
    for far in (mp.mpf(0), top):
        near, edge = m, far
        inside = far + (m - far) * mp.mpf(10) ** -60
        if height(inside) < 0:
            for _ in range(420):
                middle = (near + edge) / 2
                near, edge = (middle, edge) if height(middle) > 0 else (near, middle)
        ends.append(edge)
    low, high = ends

    def area(a: mp.mpf, b: mp.mpf) -> mp.mpf:
        bell = s * mp.sqrt(2 * mp.pi) * (tail((a - m) / s) - tail((b - m) / s))
        return bell - normal(mp.mpf(0)) * (b - a) - slope * (b * b - a * a) / 2

    own, whole = origins.gaussian(mean, std, form="paper", upper=upper), area(low, high)
    return Reference(own, lambda x: area(min(max(x, low), high), high) / whole)


def mixture(parts: list[Reference], weights: list[float]) -> Reference:
    shares = [mp.mpf(weight) / mp.fsum(map(mp.mpf, weights)) for weight in weights]
    law = origins.mixture([part.law for part in parts], weights)
    return Reference(
        law, lambda x: mp.fsum(w * part.sf(x) for w, part in zip(shares, parts, strict=True))
    )
