"""What is not smooth about a density around one place, as a sum of powers, and the algebra of such sums.

A power t^(a-1) above a place has the transform Gamma(a) s^-a about it, and |t|^(b-1) below it Gamma(b) (-s)^-b. Smooth
functions fall faster than any power as s -> i infinity, so what these series say of a density is all of it but a
smooth function; where densities fold, series multiply and places add up.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial, prod

import numpy as np
import numpy.typing as npt
from scipy.special import gamma

Array = npt.NDArray[np.float64]

HIGHEST = 8.0  # order up to which powers are kept, unless said otherwise
MOST = 400  # germs
_SAME = 1e-9
_TINY = 1e-300


@dataclass(frozen=True)
class Germ:
    """A density with the transform sum_k terms[k] s^-(above + k) (-s)^-below about its place; smooth parts left out."""

    place: float
    above: float
    below: float
    terms: Array
    highest: float = HIGHEST

    @property
    def order(self) -> float:
        """Of its lowest power: |t|^(order - 1)."""
        return self.above + self.below

    def times(self, factor: float) -> "Germ":
        return replace(self, terms=factor * self.terms)

    def cut(self, highest: float) -> "Germ":
        """The same with fewer powers."""
        return replace(self, terms=self.terms[: _kept(self.order, highest)], highest=highest)

    def folded(self, other: "Germ") -> "Germ":
        above, below = self.above + other.above, self.below + other.below
        kept = _kept(above + below, self.highest) if self.terms.size and other.terms.size else 0
        terms = np.convolve(self.terms, other.terms)[:kept] if kept else np.empty(0)
        return Germ(self.place + other.place, above, below, terms, self.highest)

    def times_x(self) -> "Germ":
        """x times the density: -d/ds of the transform about 0."""
        steps = np.arange(self.terms.size)
        terms = self.place * np.append(self.terms, 0.0)
        terms[1:] += (self.order + steps) * self.terms
        return replace(self, terms=terms[: _kept(self.order, self.highest)])

    def integral(self) -> "Germ":
        kept = _kept(self.order + 1.0, self.highest)
        return replace(self, above=self.above + 1.0, terms=self.terms[:kept])


class Sum:
    """Germs of one place, added up."""

    def __init__(self, germs: list[Germ]) -> None:
        self.germs = germs
        order = np.array([germ.order for germ in germs])
        # near a whole order a power differs from a polynomial by little more than a logarithm
        whole = np.maximum(np.round(order), 1.0)
        self._beyond = beyond = order - whole
        turn = -0.5 * np.pi * (np.array([germ.above - germ.below for germ in germs]) - whole)
        self._right = np.cos(turn) / np.cos(0.5 * np.pi * beyond)
        slope = np.pi * np.sinc(0.5 * beyond)
        self._both = -(np.sin(turn) + self._right * np.sin(0.5 * np.pi * beyond)) / slope
        shift = whole.astype(int) - 1
        self._factors = np.zeros((order.size, max(k + germ.terms.size for k, germ in zip(shift, germs, strict=True))))
        for row, k, germ in zip(self._factors, shift, germs, strict=True):
            row[k : k + germ.terms.size] = germ.terms / gamma(germ.order + np.arange(germ.terms.size))

    def __call__(self, t: Array) -> Array:
        """The density at distances t from the place, but for a polynomial."""
        size = np.log(np.maximum(np.abs(t), _TINY))
        beyond = self._beyond[:, None]
        power = np.expm1(beyond * size)
        power /= np.where(beyond == 0.0, 1.0, beyond)
        power[self._beyond == 0.0] = size
        polynomials = self._factors @ np.vander(t, self._factors.shape[1], increasing=True).T
        above = self._right @ ((1.0 + beyond * power) * polynomials)
        return np.asarray(self._both @ (power * polynomials) + np.where(t > 0.0, above, 0.0))

    @cached_property
    def sizes(self) -> tuple[Array, Array]:
        """Factors and exponents of all powers, lowest first in each germ."""
        steps = [germ.order + np.arange(germ.terms.size) for germ in self.germs]
        orders = np.concatenate(steps)
        return np.abs(np.concatenate([germ.terms for germ in self.germs])) / gamma(orders), orders - 1.0

    def neglected(self, t: float) -> float:
        """The last powers kept at a distance t: what comes after them is less."""
        factors, exponents = zip(
            *[(germ.terms[-2:], germ.order + np.arange(germ.terms.size)[-2:] - 1.0) for germ in self.germs], strict=True
        )
        last, power = np.concatenate(factors), np.concatenate(exponents)
        return float((np.abs(last) / gamma(power + 1.0) * t**power).sum())


def single(place: float, side: float, order: float, factors: Array, highest: float = HIGHEST) -> Germ:
    """Of the density sum_k factors[k] u^(order - 1 + k) at distances u to one side of a place, 1 above it, -1 below."""
    count = min(factors.size, _kept(order, highest))
    steps = np.arange(count)
    terms = factors[:count] * gamma(order + steps)
    if side > 0.0:
        return Germ(place, order, 0.0, terms, highest)
    return Germ(place, 0.0, order, terms * (-1.0) ** steps, highest)


def _kept(order: float, highest: float) -> int:
    """Terms of a germ up to the highest order."""
    return max(int(np.ceil(highest - order)), 0)


def renewed(own: list[Germ], end: float) -> list[Germ] | None:
    """Of the sum of all powers p^n, n >= 1, of a density folded with itself, up to X = end.

    Of k_i factors each from germ i, in whatever order, there are (sum k_i)! / prod k_i!. None where they are too many.
    """
    unit = Germ(0.0, 0.0, 0.0, np.ones(1), own[0].highest if own else HIGHEST)
    found: list[tuple[tuple[int, ...], Germ]] = [((), unit)]
    for germ in own:
        following = []
        for counts, product in found:
            for count in range(10_000):
                following.append(((*counts, count), product))
                product = product.folded(germ)
                if product.place > end or not product.terms.size:
                    break
        found = following
        if len(found) > MOST:
            return None
    return [
        germ.times(factorial(sum(counts)) / prod(factorial(count) for count in counts))
        for counts, germ in found
        if sum(counts)
    ]


def gathered(germs: list[Germ]) -> tuple[Array, list[Sum]]:
    """Places, sorted, and the germs at each: those whose powers are whole steps apart are one."""
    places: list[float] = []
    groups: list[list[Germ]] = []
    for germ in sorted(germs, key=lambda germ: (germ.place, germ.order)):
        if not germ.terms.size:
            continue
        if not places or germ.place - places[-1] > _SAME * germ.place:
            places.append(germ.place)
            groups.append([])
        for k, other in enumerate(groups[-1]):
            above, below = germ.above - other.above, germ.below - other.below
            if abs(above - round(above)) < _SAME > abs(below - round(below)) and above + below > -_SAME:
                groups[-1][k] = _sum(other, germ, round(above + below), -1.0 if round(below) % 2 else 1.0)
                break
        else:
            groups[-1].append(germ)
    return np.array(places), [Sum(group) for group in groups]


def _sum(germ: Germ, other: Germ, steps: int, sign: float) -> Germ:
    """One germ and `sign` times another, which begins some steps later."""
    terms = np.zeros(max(germ.terms.size, steps + other.terms.size))
    terms[: germ.terms.size] = germ.terms
    terms[steps : steps + other.terms.size] += sign * other.terms
    return replace(germ, terms=terms)
