"""Thresholds of pinning grains with the Jacobian the paper prints: P_c proportional to P_LS(u(x)) (paper, Eq. LS2)."""

import numpy as np

from origins.grains.pinning import Film
from origins.thresholds.law import Array


class PrintedGrains(Film):
    """P_LS(u(x)), normalised."""

    onset_power = 0.0

    def _log_weight(self, x: Array) -> Array:
        k, gap, left = self._stretch(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            q = gap / (self._e0 * left)
            size = 2.0 * np.log(k) - 7.0 / 3.0 * np.log1p(gap / (2.0 * self._m0 + 1.0))
            return np.where(left > 0.0, size + 11.0 / 3.0 * np.log1p(q * self._e0) - q, -np.inf)
