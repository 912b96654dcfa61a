"""Power laws of one quantity, and two of them that meet: below the bend one holds, above it the other."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import finite, positive

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PowerLaw:
    """coefficient * y^exponent for y >= 0, in SI units.

    Raises InputError unless the coefficient is above zero and both are finite.
    """

    coefficient: float
    exponent: float

    def __post_init__(self) -> None:
        positive("coefficient", self.coefficient)
        finite("exponent", self.exponent)

    def __call__(self, y: npt.ArrayLike) -> Array:
        return np.asarray(self.coefficient * np.asarray(y, dtype=float) ** self.exponent)[()]

    def times(self, factor: "PowerLaw | float") -> "PowerLaw":
        """The product with another law of the same quantity, or with a number."""
        if isinstance(factor, PowerLaw):
            return PowerLaw(self.coefficient * factor.coefficient, self.exponent + factor.exponent)
        return PowerLaw(self.coefficient * factor, self.exponent)

    def power(self, exponent: float) -> "PowerLaw":
        """The law raised to a power."""
        return PowerLaw(self.coefficient**exponent, self.exponent * exponent)

    def after(self, inner: "PowerLaw") -> "PowerLaw":
        """self(inner(y))."""
        return PowerLaw(self.coefficient * inner.coefficient**self.exponent, self.exponent * inner.exponent)

    @property
    def inverse(self) -> "PowerLaw":
        """The law that undoes this one, for an exponent other than 0."""
        return PowerLaw(self.coefficient ** (-1.0 / self.exponent), 1.0 / self.exponent)


@dataclass(frozen=True)
class Bend:
    """`below` for y <= at, `above` beyond; the two meet there. `at` may be 0 or inf: then one of them is all."""

    below: PowerLaw
    above: PowerLaw
    at: float

    def __call__(self, y: npt.ArrayLike) -> Array:
        y = np.asarray(y, dtype=float)
        return np.asarray(np.where(y <= self.at, self.below(y), self.above(y)))[()]

    def each(self, change: Callable[[PowerLaw], PowerLaw]) -> "Bend":
        """The same change of either part."""
        return Bend(change(self.below), change(self.above), self.at)

    def over(self, other: "Bend") -> "Bend":
        """The quotient of two that bend at one point."""
        return Bend(
            self.below.times(other.below.power(-1.0)), self.above.times(other.above.power(-1.0)), self.at
        )

    def seen_from(self, other: "Bend") -> "Bend":
        """This quantity as a function of `other`, which rises and bends at the same point."""
        at = float(other.below(self.at)) if 0.0 < self.at < np.inf else self.at
        return Bend(self.below.after(other.below.inverse), self.above.after(other.above.inverse), at)

    @property
    def pieces(self) -> tuple[tuple[PowerLaw, float, float], ...]:
        """(law, from, to) of each part that holds somewhere."""
        if self.at == np.inf or self.below == self.above:
            return ((self.below, 0.0, np.inf),)
        if self.at == 0.0:
            return ((self.above, 0.0, np.inf),)
        return (self.below, 0.0, self.at), (self.above, self.at, np.inf)
