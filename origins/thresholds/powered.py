"""Power laws, also with another exponent beyond a bend, and thresholds that are such a power of another variable."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import finite, positive
from origins.thresholds.law import Array, Thresholds


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
        with np.errstate(over="ignore", invalid="ignore"):  # inf over inf is no number, and no bend
            up_to = super().__call__(np.minimum(y, self.at))
            return np.asarray(up_to * np.fmax(np.divide(y, self.at), 1.0) ** self.above)[()]

    def times(self, coefficient: float, power: float = 1.0, exponent: float = 0.0) -> "Bend":
        """coefficient * y^exponent times this law to a power."""
        front = coefficient * self.coefficient**power
        below, above = (each * power + exponent for each in (self.exponent, self.above))
        return Bend(front, below, above, self.at)

    def slope(self, y: Array) -> Array:
        """The derivative, which jumps at the bend."""
        slopes = np.where(y <= self.at, self.exponent, self.above)
        return self.times(1.0, exponent=-1.0)(y) * slopes

    def inverse(self) -> "Bend":
        """y as a function of this law, which rises."""
        return straight(1.0, 1.0).against(self)

    def against(self, other: "Bend") -> "Bend":
        """This law as a function of another one, which rises with y; if both bend, then at the same y."""
        power, at = self.exponent / other.exponent, min(self.at, other.at)
        coefficient = self.coefficient * other.coefficient**-power
        return Bend(coefficient, power, self.above / other.above, float(other(at)))


def straight(coefficient: float, exponent: float) -> Bend:
    """The power law without a bend."""
    return Bend(coefficient, exponent, exponent, np.inf)


class Powered(Thresholds):
    """The law of power(y), y from `base` (paper, Eqs. fsvsxs and PxPf); `power` rises, and may bend.

    All functions are those of the base at y, and as accurate. At a bend, which needs a base that begins
    at 0, the density jumps by the ratio of the exponents: a breakpoint.
    """

    def __init__(self, base: Thresholds, power: PowerLaw) -> None:
        if not isinstance(power, Bend) or power.above == power.exponent:
            power = straight(power.coefficient, power.exponent)
        self.base, self.power, self._back = base, power, power.inverse()
        lower, upper = power(base.support()).tolist()
        self._support = lower, upper
        self.atoms = power(base.atoms[0]), base.atoms[1]
        marks = np.unique(np.append(power(base.breakpoints), self._back.at))
        self.breakpoints = marks[np.isfinite(marks)]
        self.onset_power = base.onset_power
        if base.support()[0] == 0.0:
            self.onset_power = (base.onset_power + 1.0) / power.exponent - 1.0
        self._at_zero = -np.inf * self.onset_power  # log P_c(0)
        if self.onset_power == 0.0:
            self._at_zero = self._log_finite_density_at_zero()

    def _log_finite_density_at_zero(self) -> float:
        """log P_c(0) where the density begins at a finite value."""
        if self.power.exponent == 1.0:
            slope = self._back.slope(np.zeros(1))
            with np.errstate(divide="ignore"):  # bases that begin above 0 have none there
                return float((self.base.logpdf(np.zeros(1)) + np.log(slope))[0])
        # the density of the base vanishes or diverges there, as the power does: P_c(0) is the cdf divided by x where
        # the cdf is as small as this
        fraction = 1e-30
        return float(np.log(fraction / self.ppf(fraction)))

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = self.base.logpdf(self._back(x)) + np.log(self._back.slope(x))
        return np.where(x == 0.0, self._at_zero, inside)

    def _cdf(self, x: Array) -> Array:
        return self.base.cdf(self._back(x))

    def _sf(self, x: Array) -> Array:
        return self.base.sf(self._back(x))

    def _logsf(self, x: Array) -> Array:
        return self.base.logsf(self._back(x))

    def _log_survival(self, x: Array) -> Array:
        return self._logsf(x)

    def _quantiles(self, below: Array, above: Array) -> Array:
        return self.power(self.base._quantiles(below, above))

    def _moment(self, n: float, centre: float = 0.0) -> float:
        marks = self.base.breakpoints
        if n == 2 and centre != 0.0 and np.isinf(self.base.pdf(marks[marks > 0.0])).any():
            # no NumericalLaw follows peaks
            return self._moment(2) - centre * (2.0 * self._moment(1) - centre)
        if self.power.at < np.inf or centre != 0.0:
            return super()._moment(n, centre)
        return self.power.coefficient**n * self.base._moment(n * self.power.exponent)
