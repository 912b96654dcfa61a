"""Thresholds of the grains that span a film, their sizes Lifshitz and Slyozov's (paper, Eq. LS2, exact Jacobian)."""

from fractions import Fraction

import numpy as np

from origins.grains.lifshitz_slyozov import closed_hazard, hazard_beyond, invert_beyond
from origins.thresholds.law import Array, Thresholds


class Film(Thresholds):
    """Stretches at which grains break; `excess` = 3 rho/2 - 1 > 0, whose float may be as small as floats are."""

    def __init__(self, excess: Fraction, B: float) -> None:
        self.excess, self.B = float(excess), B
        self._root_b = float(np.sqrt(B))
        self._m0 = 1.0 + self.excess
        self._y0, self._e0 = 1.0 / self._m0, self.excess / self._m0
        square = excess * (excess + 2) / Fraction(B)
        self._upper = float(np.sqrt(float(square)))
        # beside the end a distance is a difference: what the float lacks is kept
        self._upper_rest = float((square - Fraction(self._upper) ** 2) / (2 * Fraction(self._upper)))

    def support(self) -> tuple[float, float]:
        return 0.0, self._upper

    def _stretch(self, x: Array) -> tuple[Array, Array, Array]:
        """k, (k - 1) and (m0 - k)."""
        s = self._root_b * x
        k = np.hypot(1.0, s)
        left = self._root_b * ((self._upper - x) + self._upper_rest)
        return k, s * (s / (1.0 + k)), left * (self._root_b * (self._upper + x) / (self._m0 + k))


class PinningGrains(Film):
    """Exact Jacobian: the survival is that of the sizes, S = S_LS(u(x))/S_LS(1/rho)."""

    onset_power = 1.0

    def _beyond(self, x: Array) -> Array:
        """q, how far the grain lies towards the largest."""
        _, gap, left = self._stretch(x)
        with np.errstate(divide="ignore"):
            return gap / (self._e0 * left)

    def _hazard(self, x: Array) -> Array:
        return hazard_beyond(self._beyond(x), self._y0, self._e0)

    def _logpdf(self, x: Array) -> Array:
        out = np.full(x.shape, -np.inf)
        k, gap, left = self._stretch(x)
        inner = (x > 0.0) & (left > 0.0)
        k, left, x = k[inner], left[inner], x[inner]
        slope = np.log(3.0 * self._root_b / (2.0 * self._m0 + k)) + np.log(self._root_b * x) + np.log(k)
        out[inner] = slope - 2.0 * np.log(left) - closed_hazard(gap[inner] / (self._e0 * left), self._y0, self._e0)
        return out

    def _pdf(self, x: Array) -> Array:
        return np.exp(self._logpdf(x))

    def _cdf(self, x: Array) -> Array:
        return -np.expm1(-self._hazard(x))

    def _sf(self, x: Array) -> Array:
        return np.exp(-closed_hazard(self._beyond(x), self._y0, self._e0))

    def _logsf(self, x: Array) -> Array:
        return -self._hazard(x)

    def _from_hazard(self, hazard: Array) -> Array:
        q = invert_beyond(hazard, self._y0, self._e0)
        gap = self._m0 * self._e0 * (q * self._e0 / (1.0 + q * self._e0))
        return np.minimum(np.sqrt(gap) * np.sqrt(gap + 2.0) / self._root_b, self._upper)
