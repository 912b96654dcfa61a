"""Power laws of one quantity, and their continuation with another exponent beyond a bend."""

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


@dataclass(frozen=True)
class Bend(PowerLaw):
    """The power law up to y = at, and beyond it, without a jump, with the exponent `above`."""

    above: float
    at: float

    def __call__(self, y: npt.ArrayLike) -> Array:
        y = np.asarray(y, dtype=float)
        up_to = super().__call__(np.minimum(y, self.at))
        if self.at == np.inf:
            return up_to
        return np.asarray(up_to * np.maximum(y / self.at, 1.0) ** self.above)[()]

    def times(self, coefficient: float, exponent: float = 0.0) -> "Bend":
        """The product with a power law of the same y."""
        above = self.above + exponent
        return Bend(self.coefficient * coefficient, self.exponent + exponent, above, self.at)

    def raised(self, power: float) -> "Bend":
        """This law to a power."""
        exponents = self.exponent * power, self.above * power
        return Bend(self.coefficient**power, *exponents, self.at)

    def slope(self, y: Array) -> Array:
        """The derivative, which jumps at the bend."""
        return self.times(1.0, -1.0)(y) * np.where(y <= self.at, self.exponent, self.above)

    def against(self, other: "Bend") -> "Bend":
        """This law as a function of another one, which rises with y; if both bend, then at the same y."""
        power, at = self.exponent / other.exponent, min(self.at, other.at)
        coefficient = self.coefficient * other.coefficient**-power
        at = float(other(at)) if at < np.inf else at
        return Bend(coefficient, power, self.above / other.above, at)


def straight(coefficient: float, exponent: float) -> Bend:
    """The power law without a bend."""
    return Bend(coefficient, exponent, exponent, np.inf)
