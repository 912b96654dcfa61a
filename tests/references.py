"""The threshold families in mpmath, straight from their definitions, at as many digits as cancellation asks."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mpmath

import origins

mp = mpmath.MPContext()  # a context of its own: other tests keep their digits
mp.dps = 130
Function = Callable[[mp.mpf], mp.mpf]


@dataclass(frozen=True)
class Reference:
    """A law of origins, and its density, cdf, survival and moments, integrated once each, in mpmath."""

    law: origins.Thresholds
    pdf: Function
    cdf: Function
    sf: Function
    moment: Callable[[int], mp.mpf]

    def __post_init__(self) -> None:
        object.__setattr__(self, "moment", cache(self.moment))


def _number(value: float) -> mp.mpf:
    return mp.mpf(float(value))


def weibull(law: origins.Thresholds, shape: mp.mpf, rate: float) -> Reference:
    rate_ = _number(rate)
    return Reference(
        law,
        lambda x: shape * rate_ * x ** (shape - 1) * mp.exp(-rate_ * x**shape),
        lambda x: -mp.expm1(-rate_ * x**shape),
        lambda x: mp.exp(-rate_ * x**shape),
        lambda n: rate_ ** (-n / shape) * mp.gamma(1 + n / shape),
    )


def gw_elastic(rate: float) -> Reference:
    return weibull(origins.gw_elastic(rate), mp.mpf(4) / 3, rate)


def gw_plastic(rate: float) -> Reference:
    return weibull(origins.gw_plastic(rate), mp.mpf(2), rate)


def rectangular(lower: float, upper: float) -> Reference:
    a, b = _number(lower), _number(upper)
    return Reference(
        origins.rectangular(lower, upper),
        lambda x: 1 / (b - a) if a < x < b else mp.mpf(0),
        lambda x: min(max((x - a) / (b - a), mp.mpf(0)), mp.mpf(1)),
        lambda x: min(max((b - x) / (b - a), mp.mpf(0)), mp.mpf(1)),
        lambda n: (b ** (n + 1) - a ** (n + 1)) / ((n + 1) * (b - a)),
    )


def generalised_gamma(width: float, power: float, decay: float) -> Reference:
    w, p, a = _number(width), _number(decay), (_number(power) + 1) / _number(decay)
    return Reference(
        origins.lubricated(width, power, decay),
        lambda x: p / w / mp.gamma(a) * (x / w) ** _number(power) * mp.exp(-((x / w) ** p)),
        lambda x: mp.gammainc(a, 0, (x / w) ** p, regularized=True),
        lambda x: mp.gammainc(a, (x / w) ** p, mp.inf, regularized=True),
        lambda n: w**n * mp.gamma(a + n / p) / mp.gamma(a),
    )


def grains(rho: float, B: float) -> Reference:
    """Exact Jacobian: Lifshitz and Slyozov's sizes as printed, and their survival e^-psi, beyond u = 1/rho."""
    b, first = _number(B), 1 / _number(rho)
    law = origins.grains(rho, B=B)
    third = mp.mpf(1) / 3

    def psi(u: mp.mpf) -> mp.mpf:
        y = 2 * u / 3
        return 4 * third * mp.log1p(y / 2) + 5 * third * mp.log1p(-y) + y / (1 - y)

    def size(x: mp.mpf) -> mp.mpf:
        return mp.sqrt(1 + b * x * x) * first

    def pdf(x: mp.mpf) -> mp.mpf:
        u = size(x)
        front = 81 * mp.e / 2 ** (5 * third) * u * u * mp.exp(psi(first) - 1 / (1 - 2 * u / 3))
        return (
            front
            / ((u + 3) ** (7 * third) * (mp.mpf(3) / 2 - u) ** (11 * third))
            * b
            * x
            * first
            * first
            / u
        )

    def sf(x: mp.mpf) -> mp.mpf:
        return mp.exp(psi(first) - psi(size(x)))

    def moment(n: int) -> mp.mpf:
        with mp.workdps(30):
            marks = [
                mp.mpf(0),
                *[
                    _number(x)
                    for x in (*law.ppf([1e-6, 0.1]), *law.isf([0.5, 0.1, 1e-3, 1e-7, 1e-16]))
                ],
            ]
            return mp.quad(lambda x: n * x ** (n - 1) * sf(x), marks)

    return Reference(law, pdf, lambda x: -mp.expm1(psi(first) - psi(size(x))), sf, moment)


def lubricated(width: float) -> Reference:
    w = _number(width)
    return Reference(
        origins.lubricated(width),
        lambda x: 2 * x**3 / w**4 * mp.exp(-((x / w) ** 2)),
        lambda x: 1 - (1 + (x / w) ** 2) * mp.exp(-((x / w) ** 2)),
        lambda x: (1 + (x / w) ** 2) * mp.exp(-((x / w) ** 2)),
        lambda n: w**n * mp.gamma(2 + mp.mpf(n) / 2),
    )


def persson(centre: float, width: float) -> Reference:
    """As printed: differences of exponentials and of error functions. centre = 0 is a Weibull law of shape 4."""
    if centre == 0.0:
        return weibull(origins.persson(0.0, width), mp.mpf(4), float(_number(width) ** -4))
    c, w = _number(centre), _number(width)
    a = (c / w) ** 2
    whole = 2 * mp.erf(a)

    def pdf(x: mp.mpf) -> mp.mpf:
        f = (x / w) ** 2
        return (
            4
            * x
            / (w * w * mp.sqrt(mp.pi))
            * (mp.exp(-((f - a) ** 2)) - mp.exp(-((f + a) ** 2)))
            / whole
        )

    def sf(x: mp.mpf) -> mp.mpf:
        f = (x / w) ** 2
        return (mp.erfc(f - a) - mp.erfc(f + a)) / whole

    def cdf(x: mp.mpf) -> mp.mpf:
        f = (x / w) ** 2
        if a > 8:  # by complements, so that nothing as small as erfc(a) is lost beside 1
            return (mp.erfc(a - f) - 2 * mp.erfc(a) + mp.erfc(a + f)) / whole
        return (2 * mp.erf(a) + mp.erf(f - a) - mp.erf(f + a)) / whole

    def moment(n: int) -> mp.mpf:
        # in s = x^2 - c^2 over w^2 the density is a difference of two Gaussians, scaled to where its weight lies
        with mp.workdps(40):
            step = w * w / (c + w)
            marks = [max(c + k * step, mp.mpf(0)) for k in range(-9, 10)]
            marks = sorted({mp.mpf(0), *marks, c + 4 * w})
            return mp.quad(lambda x: x**n * pdf(x), marks)

    return Reference(origins.persson(centre, width), pdf, cdf, sf, moment)


def gaussian(mean: float, std: float) -> Reference:
    m, s = _number(mean), _number(std)
    kept = mp.erfc(-m / s / mp.sqrt(2)) / 2

    def pdf(x: mp.mpf) -> mp.mpf:
        return mp.exp(-(((x - m) / s) ** 2) / 2) / (s * mp.sqrt(2 * mp.pi) * kept)

    def cdf(x: mp.mpf) -> mp.mpf:
        if m < 0:
            return (mp.erfc(-m / s / mp.sqrt(2)) - mp.erfc((x - m) / s / mp.sqrt(2))) / (2 * kept)
        return (mp.erfc((m - x) / s / mp.sqrt(2)) - mp.erfc(m / s / mp.sqrt(2))) / (2 * kept)

    def moment(n: int) -> mp.mpf:
        before, now = mp.mpf(1), m + s * s * pdf(mp.mpf(0))
        for order in range(2, n + 1):
            before, now = now, m * now + (order - 1) * s * s * before
        return now

    return Reference(
        origins.gaussian(mean, std),
        pdf,
        cdf,
        lambda x: mp.erfc((x - m) / s / mp.sqrt(2)) / (2 * kept),
        moment,
    )


def gw_gaussian(
    separation: float, scale: float, law: str, regime: str, index: float | None = None
) -> Reference:
    """Summits: survival Phi_c(z + delta)/Phi_c(z), x = scale delta^b with a bend where contacts turn plastic."""
    z, unit = _number(separation), _number(scale)
    elastic, plastic = {"paper": (0.75, 0.5), "amontons": (1.0, 0.5), "strength": (0.5, 0.5)}[law]
    first, last = _number(plastic if regime == "plastic" else elastic), _number(plastic)
    at = mp.inf if index is None else (9 * mp.pi / (4 * _number(index))) ** 2
    mark = unit * at ** (first if at > 1 else last) if index is not None else mp.inf

    def tail(height: mp.mpf) -> mp.mpf:
        return mp.erfc(height / mp.sqrt(2)) / 2

    def part(x: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        if index is None:
            return (x / unit) ** (1 / first), first
        power = first if x < mark else last
        return at * (x / mark) ** (1 / power), power

    def pdf(x: mp.mpf) -> mp.mpf:
        delta, power = part(x)
        return mp.npdf(z + delta) / tail(z) * delta / (power * x)

    def moment(n: int) -> mp.mpf:
        with mp.workdps(30):
            step, touching = 1 / max(abs(z), mp.mpf(1)), tail(z)
            marks = {mp.mpf(0), *[max(-z, mp.mpf(0)) + k * step for k in (1, 4, 12, 40)]}
            marks |= {at} if index is not None else set()

            def integrand(s: mp.mpf) -> mp.mpf:
                # heights in delta = s^4, where every power of them is smooth
                delta = s**4
                power = first if delta < at else last
                own = unit * delta**power if index is None else mark * (delta / at) ** power
                return 4 * s**3 * own**n * mp.npdf(z + delta) / touching

            return mp.quad(integrand, sorted(mp.root(m, 4) for m in marks))

    return Reference(
        origins.gw_gaussian(separation, scale, law=law, regime=regime, plasticity_index=index),
        pdf,
        lambda x: (tail(z) - tail(z + part(x)[0])) / tail(z),
        lambda x: tail(z + part(x)[0]) / tail(z),
        moment,
    )


def chord_gaussian(mean: float, std: float, upper: float) -> Reference:
    m, s, top = _number(mean), _number(std), _number(upper)

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

    def integral(a: mp.mpf, b: mp.mpf) -> mp.mpf:
        bell = (
            s
            * mp.sqrt(mp.pi / 2)
            * (mp.erfc((a - m) / s / mp.sqrt(2)) - mp.erfc((b - m) / s / mp.sqrt(2)))
        )
        return bell - normal(mp.mpf(0)) * (b - a) - slope * (b * b - a * a) / 2

    whole = integral(low, high)

    def moment(n: int) -> mp.mpf:
        with mp.workdps(40):
            marks = sorted({low, high, *[min(max(m + k * s, low), high) for k in range(-12, 13)]})
            return mp.quad(lambda x: x**n * height(x) / whole, marks)

    return Reference(
        origins.gaussian(mean, std, form="paper", upper=upper),
        lambda x: height(x) / whole if low < x < high else mp.mpf(0),
        lambda x: integral(low, min(max(x, low), high)) / whole,
        lambda x: integral(min(max(x, low), high), high) / whole,
        moment,
    )


def mixture(parts: list[Reference], weights: list[float]) -> Reference:
    shares = [_number(w) / mp.fsum(_number(v) for v in weights) for w in weights]

    def total(name: str) -> Function:
        return lambda x: mp.fsum(
            w * getattr(part, name)(x) for w, part in zip(shares, parts, strict=True)
        )

    return Reference(
        origins.mixture([part.law for part in parts], weights),
        total("pdf"),
        total("cdf"),
        total("sf"),
        lambda n: mp.fsum(w * part.moment(n) for w, part in zip(shares, parts, strict=True)),
    )
