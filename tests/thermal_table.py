"""Kinetic forces at a temperature to eleven digits by mpmath, at 100 points; writes thermal_table.csv beside itself.

    python tests/thermal_table.py

Thresholds are Gaussian, mean 1 and width 0.05; temperatures 1e-6 to 1e3, ω/v 1e-12 to 1e12. With E(x) the fraction of
contacts that hold at x, F_k is the integral of x E over that of E. Exact closure: both integrals for one threshold
after the other. Paper's closure: E(x) = S(x) exp[-(1/v) integral of P_c(ξ) A(min(x, ξ); ξ)]. All integrals are Gauss
sums over panels placed by hand where the integrands change; every tenth point is computed again with more nodes, and
the last point is from sixteen of them, as seven tell it to 1.2e-11 only.
"""

import csv
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

import mpmath
import numpy as np

TABLE = Path(__file__).with_name("thermal_table.csv")
STD = mpmath.mpf("0.05")
DIGITS = 20
AROUND = [k * 0.25 for k in range(-20, 13)] + [k * 1.5 for k in range(-27, -3)] + [3.5, 4.5, 6.0, 9.0, 14.0]


def points() -> Iterable[tuple[str, str, float, float]]:
    """Law, closure, temperature and ω/v: spread over all orders of magnitude, corners first."""
    random = np.random.default_rng(1011)
    corners = [(1e-6, 1e-12), (1e-6, 1e12), (1e3, 1e-12), (1e3, 1e12)]
    for closure, count in (("exact", 34), ("paper", 16)):
        for law in ("soft", "stiff"):
            drawn = [(10.0 ** random.uniform(-6, 3), 10.0 ** random.uniform(-12, 12)) for _ in range(count - 4)]
            for temperature, rate in corners + drawn:
                yield law, closure, float(f"{temperature:.4g}"), float(f"{rate:.4g}")


def panels(edges: Iterable, low, high, count: int) -> list[tuple]:
    """Gauss nodes and weights between `low` and `high`, cut at those of the edges inside."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    cuts = sorted({low, high} | {edge for edge in edges if low < edge < high})
    out = []
    for a, b in pairwise(cuts):
        half = (b - a) / 2
        for x, w in zip(nodes, weights, strict=True):
            out.append((a + half * (1 + mpmath.mpf(float(x))), half * mpmath.mpf(float(w))))
    return out


class Contact:
    """A(x; ξ)/v of contacts with one law, temperature and ω/v."""

    def __init__(self, law: str, temperature: float, rate: float) -> None:
        self.soft, self.t, self.rate = law == "soft", mpmath.mpf(temperature), mpmath.mpf(rate)
        self.a = mpmath.sqrt(1 / (2 * self.t))
        self.seen: dict = {}

    def growth(self, x):
        """Soft: e^{-a²x²} times the integral of e^{a²y²} up to x, asked for at the same x again and again."""
        if x not in self.seen:
            z = self.a * x
            self.seen[x] = mpmath.sqrt(mpmath.pi) / 2 * mpmath.erfi(z) * mpmath.exp(-z * z) / self.a
        return self.seen[x]

    def spent(self, x, xi):
        if self.soft:
            return self.rate * mpmath.exp(-((xi - x) * (xi + x)) / (2 * self.t)) * self.growth(x)
        c = xi * xi / (2 * self.t)
        u = mpmath.sqrt(1 - x / xi) ** 3
        return self.rate * 2 * xi / (3 * c) * mpmath.exp(-c * u) * -mpmath.expm1(-c * (1 - u))


def middle(level: Callable, high):
    """Where an increasing function passes 1, its end where it stays below, and the width of a factor e there."""
    low = at = top = high
    if level(high) >= 1:
        low = mpmath.mpf(0)
        for _ in range(70):
            at = (low + top) / 2
            low, top = (at, top) if level(at) < 1 else (low, at)
    step = at / 10**6
    slope = (mpmath.log(level(at)) - mpmath.log(level(at - step))) / step
    return at, min(1 / slope, high / 4) if slope > 0 else high / 4


def cuts_around(level: Callable, high) -> list:
    at, width = middle(level, high)
    return [at + width * k for k in AROUND] + [at * k for k in (0.1, 0.3, 0.6, 0.8, 1.5, 3, 6, 12, 25, 50)]


def one_threshold(contact: Contact, xi, count: int) -> tuple:
    """Integrals of E and x E for contacts of one threshold, in y = (1 - x/ξ)^(1/2), in which a stiff one is smooth."""
    cuts = cuts_around(lambda x: contact.spent(x, xi), xi)
    cuts += [xi * (1 - mpmath.mpf(k) ** 2 / 64) for k in range(1, 8)]
    barrier = xi * xi / (2 * contact.t)
    cuts += [xi * (1 - k / (2 * barrier)) for k in (0.5, 1, 2, 4, 7, 12, 20, 40)]
    roots = [mpmath.sqrt(1 - x / xi) for x in cuts if 0 < x < xi]
    if not contact.soft:
        roots += [k * barrier ** (-mpmath.mpf(1) / 3) for k in (0.5, 1, 1.5, 2, 2.5, 3, 4)]
    length = area = mpmath.mpf(0)
    for y, weight in panels(roots, mpmath.mpf(0), mpmath.mpf(1), count):
        x = xi * (1 - y) * (1 + y)
        held = 2 * xi * y * weight * mpmath.exp(-contact.spent(x, xi))
        length, area = length + held, area + x * held
    return length, area


def density(xi):
    return mpmath.npdf((xi - 1) / STD) / STD


def exact(law: str, temperature: float, rate: float, count: int):
    contact = Contact(law, temperature, rate)
    length = area = mpmath.mpf(0)
    for xi, weight in panels([1 + STD * k for k in (-5, -3, -1, 1, 3, 5)], 1 - 8 * STD, 1 + 8 * STD, count):
        part = one_threshold(contact, xi, count)
        length, area = length + weight * density(xi) * part[0], area + weight * density(xi) * part[1]
    return area / length


def paper(law: str, temperature: float, rate: float, count: int):
    contact = Contact(law, temperature, rate)
    low, high = 1 - 9 * STD, 1 + 9 * STD
    even = [1 + STD * k for k in range(-8, 9)]
    passed: dict = {}

    def whole(a, b):
        """What thresholds between a and b cost in all."""
        return mpmath.fsum(w * density(xi) * contact.spent(xi, xi) for xi, w in panels([], a, b, count))

    before, ends = [mpmath.mpf(0)], [low, *even]
    for a, b in pairwise(ends):
        before.append(before[-1] + whole(a, b))

    def level(x):
        """L(x): thresholds passed have cost all that they could, others what they cost up to x."""
        if x not in passed:
            below = [k for k, end in enumerate(ends) if end < x]
            total = before[below[-1]] + whole(ends[below[-1]], min(x, high)) if below else mpmath.mpf(0)
            least = max(x, low)
            if least < high:
                # a stiff contact's cost has a root in ξ - x
                reach = [mpmath.sqrt(e - least) for e in even if e > least]
                near = [mpmath.sqrt(contact.t / least * mpmath.mpf(2) ** k) for k in range(-3, 6, 2)]
                if not contact.soft:
                    stiff = least * (contact.t / least**2) ** (mpmath.mpf(2) / 3)
                    near += [mpmath.sqrt(stiff * mpmath.mpf(2) ** k) for k in range(-7, 7, 2)]
                for y, weight in panels(reach + near, mpmath.mpf(0), mpmath.sqrt(high - least), count):
                    xi = least + y * y
                    total += 2 * y * weight * density(xi) * contact.spent(x, xi)
            passed[x] = total
        return passed[x]

    cuts = [*cuts_around(level, high), *even, *[mpmath.mpf(k) / 12 for k in range(1, 6)]]
    length = area = mpmath.mpf(0)
    for x, weight in panels(cuts, mpmath.mpf(0), high, count):
        held = weight * mpmath.ncdf((1 - x) / STD) * mpmath.exp(-level(x))
        length, area = length + held, area + x * held
    return area / length


CLOSURES = {"exact": exact, "paper": paper}


def force(law: str, closure: str, temperature: float, rate: float, count: int | None = None):
    """F_k for thresholds of mean 1 and width 0.05; as many nodes to a panel as eleven digits take."""
    count = count or (11 if (law, closure) == ("stiff", "exact") else 7)
    with mpmath.workdps(DIGITS):
        return CLOSURES[closure](law, temperature, rate, count)


def stored() -> list[tuple[str, str, float, float, float]]:
    with TABLE.open(newline="") as file:
        return [(row[0], row[1], float(row[2]), float(row[3]), float(row[4])) for row in list(csv.reader(file))[1:]]


def main() -> None:
    rows = []
    for number, point in enumerate(points()):
        value = force(*point)
        if number % 10 == 0:
            assert abs(value / force(*point, 13) - 1) < 1e-11, point
        rows.append((*point, mpmath.nstr(value, 14)))
        print(*rows[-1], flush=True)
    with TABLE.open("w", newline="") as file:
        head = ("law", "closure", "temperature", "rate_over_speed", "force")
        csv.writer(file, lineterminator="\n").writerows([head, *rows])


if __name__ == "__main__":
    main()
