"""Thresholds that are a power of another law's variable, or one power of it below a point and another beyond."""

import numpy as np
import numpy.typing as npt

from origins.roughness.power_law import Bend
from origins.thresholds.law import Array, Thresholds


class Powered(Thresholds):
    """The law of scale * y**exponent, y from `base` (paper, Eqs. fsvsxs and PxPf); both above zero.

    Everything is the base's, taken where y stands, so that nothing of its accuracy is lost.
    """

    _bend = _bend_base = np.inf  # lengths x and y beyond which another power holds

    def __init__(self, base: Thresholds, scale: float, exponent: float) -> None:
        self.base, self._scale, self._exponent = base, scale, exponent
        self.onset_power = base.onset_power
        if base.support()[0] == 0.0:
            self.onset_power = (base.onset_power + 1.0) / exponent - 1.0

    def _power(self, beyond: npt.NDArray[np.bool_]) -> tuple[Array | float, Array | float]:
        """Scale and exponent of each threshold; `beyond` says which lie above a bend."""
        return self._scale, self._exponent

    def _forward(self, y: Array) -> Array:
        scale, exponent = self._power(y > self._bend_base)
        return scale * y**exponent

    def _back(self, x: Array) -> Array:
        scale, exponent = self._power(x > self._bend)
        with np.errstate(over="ignore"):
            return np.asarray((x / scale) ** (1.0 / exponent))

    def support(self) -> tuple[float, float]:
        lower, upper = self._forward(np.array(self.base.support()))
        return float(lower), float(upper)

    @property
    def breakpoints(self) -> Array:
        return self._forward(self.base.breakpoints)

    @property
    def atoms(self) -> tuple[Array, Array]:
        positions, weights = self.base.atoms
        return self._forward(positions), weights

    def _pdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            density = self.base.pdf(self._back(x)) * np.exp(self._log_slope(x))
        return np.where(x == 0.0, self._at_zero(), density)

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(
                x == 0.0,
                np.log(self._at_zero()),
                self.base.logpdf(self._back(x)) + self._log_slope(x),
            )

    def _log_slope(self, x: Array) -> Array:
        """log dy/dx."""
        scale, exponent = self._power(x > self._bend)
        return (1.0 / exponent - 1.0) * np.log(x / scale) - np.log(exponent * scale)

    def _at_zero(self) -> float:
        if self.support()[0] > 0.0 or self.onset_power > 0.0:
            return 0.0
        # a density that begins at a finite value: cdf = density * x
        return 1e-30 / float(self.ppf(1e-30)) if self.onset_power == 0.0 else np.inf

    def _cdf(self, x: Array) -> Array:
        return self.base.cdf(self._back(x))

    def _sf(self, x: Array) -> Array:
        return self.base.sf(self._back(x))

    def _logsf(self, x: Array) -> Array:
        return self.base.logsf(self._back(x))

    def _ppf(self, q: Array) -> Array:
        return self._forward(self.base.ppf(q))

    def _isf(self, q: Array) -> Array:
        return self._forward(self.base.isf(q))

    def _moment(self, n: int) -> float:
        order = n * self._exponent
        if order == round(order):
            return self._scale**n * self.base.moment(round(order))
        return super()._moment(n)


class Bent(Powered):
    """The law of bend(y), y from `base`, whose support begins at 0; both parts of the bend rise and meet.

    The density jumps where they meet, by the quotient of the two exponents: that is a breakpoint. Where only one
    part holds there is none.
    """

    def __init__(self, base: Thresholds, bend: Bend) -> None:
        (first, _, at), *_ = bend.pieces
        super().__init__(base, first.coefficient, first.exponent)
        self.bend, self._bend_base = bend, at
        self._bend = float(first(at)) if at < np.inf else np.inf

    def _power(self, beyond: npt.NDArray[np.bool_]) -> tuple[Array | float, Array | float]:
        if not beyond.any():
            return self._scale, self._exponent
        above = self.bend.above
        scale = np.where(beyond, above.coefficient, self._scale)
        return scale, np.where(beyond, above.exponent, self._exponent)

    @property
    def breakpoints(self) -> Array:
        marks = super().breakpoints
        return marks if self._bend == np.inf else np.unique(np.append(marks, self._bend))
