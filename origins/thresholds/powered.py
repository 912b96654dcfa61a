"""Thresholds that are a power of another law's variable, or one power below a point and another one above."""

import numpy as np

from origins.roughness.power_law import Bend, PowerLaw, straight
from origins.thresholds.law import Array, Thresholds


class Powered(Thresholds):
    """The law of power(y), y from `base` (paper, Eqs. fsvsxs and PxPf); `power` rises, and may bend.

    All functions are those of the base at y, and as accurate. At a bend, which needs a base that begins
    at 0, the density jumps by the ratio of the exponents: a breakpoint.
    """

    def __init__(self, base: Thresholds, power: PowerLaw) -> None:
        if not isinstance(power, Bend) or power.above == power.exponent:
            power = straight(power.coefficient, power.exponent)
        self.base, self.power, self._back = base, power, straight(1.0, 1.0).against(power)
        marks, self.atoms = power(base.breakpoints), (power(base.atoms[0]), base.atoms[1])
        bent = [] if power.at == np.inf else [self._back.at]
        self.breakpoints = np.unique(np.append(marks, bent))
        self._at_zero = -np.inf  # log P_c(0)
        self.onset_power = base.onset_power
        if base.support()[0] == 0.0:
            self.onset_power = (base.onset_power + 1.0) / power.exponent - 1.0
        if self.onset_power < 0.0:
            self._at_zero = np.inf
        elif self.onset_power == 0.0:
            # a density that begins at a finite value: cdf = density * x
            self._at_zero = float(np.log(1e-30 / self.ppf(1e-30)))

    def support(self) -> tuple[float, float]:
        lower, upper = self.power(np.array(self.base.support()))
        return float(lower), float(upper)

    def _y(self, x: Array) -> Array:
        """The base's variable at the threshold x."""
        with np.errstate(over="ignore"):
            return np.asarray(self._back(x))

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            inside = self.base.logpdf(self._y(x)) + np.log(self._back.slope(x))
        return np.where(x == 0.0, self._at_zero, inside)

    def _cdf(self, x: Array) -> Array:
        return self.base.cdf(self._y(x))

    def _sf(self, x: Array) -> Array:
        return self.base.sf(self._y(x))

    def _logsf(self, x: Array) -> Array:
        return self.base.logsf(self._y(x))

    def _ppf(self, q: Array) -> Array:
        return self.power(self.base.ppf(q))

    def _isf(self, q: Array) -> Array:
        return self.power(self.base.isf(q))

    def _moment(self, n: float) -> float:
        if self.power.at < np.inf:
            return super()._moment(n)
        return self.power.coefficient**n * self.base._moment(n * self.power.exponent)
