"""Power laws of one quantity, and pairs of them: one below the bend, the other above it."""

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

    def __mul__(self, other: "PowerLaw") -> "PowerLaw":
        """The product with another law of the same quantity."""
        return PowerLaw(self.coefficient * other.coefficient, self.exponent + other.exponent)

    def __pow__(self, exponent: float) -> "PowerLaw":
        return PowerLaw(self.coefficient**exponent, self.exponent * exponent)

    def of(self, inner: "PowerLaw") -> "PowerLaw":
        """The composition self(inner(y))."""
        return PowerLaw(self.coefficient, 0.0) * inner**self.exponent

    @property
    def inverse(self) -> "PowerLaw":
        """The inverse law, for an exponent other than 0."""
        return PowerLaw(self.coefficient ** (-1.0 / self.exponent), 1.0 / self.exponent)

    @property
    def slope(self) -> "PowerLaw":
        """Its derivative, for an exponent above 0."""
        return PowerLaw(self.coefficient * self.exponent, self.exponent - 1.0)


@dataclass(frozen=True)
class Bend:
    """`below` for y <= at, `above` beyond, equal at `at`, which may be 0 or inf: then one of them is used."""

    below: PowerLaw
    above: PowerLaw
    at: float

    def __call__(self, y: npt.ArrayLike) -> Array:
        y = np.asarray(y, dtype=float)
        if self.at == np.inf:
            return self.below(y)
        return np.asarray(np.where(y <= self.at, self.below(y), self.above(y)))[()]

    def __mul__(self, other: PowerLaw) -> "Bend":
        return Bend(self.below * other, self.above * other, self.at)

    def __pow__(self, exponent: float) -> "Bend":
        return Bend(self.below**exponent, self.above**exponent, self.at)

    def of(self, inner: "Bend") -> "Bend":
        """The composition self(inner(y)); `inner` rises, and its bend must be at the same y."""
        return Bend(self.below.of(inner.below), self.above.of(inner.above), inner.at)

    @property
    def inverse(self) -> "Bend":
        """The inverse law; both parts must rise."""
        at = float(self.below(self.at)) if 0.0 < self.at < np.inf else self.at
        return Bend(self.below.inverse, self.above.inverse, at)

    @property
    def slope(self) -> "Bend":
        """Its derivative, which jumps at the bend."""
        return Bend(self.below.slope, self.above.slope, self.at)
