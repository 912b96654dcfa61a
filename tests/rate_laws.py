"""A rate law of the tests' own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from origins import RateLaw


@dataclass(frozen=True)
class Tilted(RateLaw):
    """h = ω exp[-(1 - x/x_s)/α]: F_k falls by α F_k(∞) for each e-fold of a low speed."""

    alpha: float = 0.1
    omega: float = 1.0
    name = "tilted"

    @property
    def scale(self) -> float:
        return self.omega

    def log_rate(self, x, threshold, stiffness):
        return np.log(self.omega) - (1.0 - x / threshold) / self.alpha

    def log_passed(self, near, far, threshold, stiffness):
        length = self.alpha * threshold
        with np.errstate(divide="ignore"):
            rise = np.log(length * -np.expm1((near - far) / length))
        return self.log_rate(far, threshold, stiffness) + rise

    def reached(self, log_amount, near, threshold, stiffness):
        length = self.alpha * threshold
        log_share = log_amount - np.log(length) - self.log_rate(near, threshold, stiffness)
        return np.minimum(near + length * np.logaddexp(0.0, log_share), threshold)
