"""Thresholds that are a power of another law's variable: x = scale * y^exponent."""

import numpy as np

from origins.thresholds.law import Array, Thresholds


class Powered(Thresholds):
    """The law of scale * y**exponent, y from `base` (paper, Eqs. fsvsxs and PxPf); both above zero.

    Everything is the base's, taken where y stands, so that nothing of its accuracy is lost.
    """

    def __init__(self, base: Thresholds, scale: float, exponent: float) -> None:
        self.base = base
        self.scale = scale
        self.exponent = exponent
        self.onset_power = (
            (base.onset_power + 1.0) / exponent - 1.0
            if base.support()[0] == 0.0
            else base.onset_power
        )

    def _forward(self, y: Array) -> Array:
        return self.scale * np.asarray(y, dtype=float) ** self.exponent

    def _back(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            return (x / self.scale) ** (1.0 / self.exponent)

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
        return (1.0 / self.exponent - 1.0) * np.log(x / self.scale) - np.log(
            self.exponent * self.scale
        )

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
        order = n * self.exponent
        if order == round(order):
            return self.scale**n * self.base.moment(round(order))
        return super()._moment(n)
