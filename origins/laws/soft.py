"""Soft contacts: h = ω exp[-k_i (x_s² - x²) / 2k_BT] (paper, Eqs. temper5 and temper8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from scipy.special import dawsn

from origins.laws.compiled import CompiledRates
from origins.laws.dawson import inverse_log_growth, log_growth
from origins.laws.rate_law import ActivatedRates, Array, Numbers, quiet
from origins.thresholds.quadrature import GAUSS_NODES, GAUSS_WEIGHTS


@dataclass(frozen=True)
class SoftRates(ActivatedRates):
    """Rate of soft contacts: barrier b (x_s² - x²), b = k_i/2k_BT per length² (paper, Eq. temper8).

    With Dawson's integral D the integral of h from 0 to x is h(x) D(b^(1/2) x) / b^(1/2). Attributes and errors
    are those of ActivatedRates. The formulas continue beyond the threshold.
    """

    name: ClassVar[Literal["soft"]] = "soft"
    vanishes_at_threshold: ClassVar[bool] = False
    separable: ClassVar[bool] = True

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h."""
        barrier = self.spring * stiffness * (threshold - x) * (threshold + x)
        return np.asarray(np.log(self.scale) - barrier)

    @quiet
    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are equal."""
        spring = self.spring * np.asarray(stiffness)
        length = _length(np.asarray(near), np.asarray(far), spring)
        return np.log(length) + self.log_rate(far, threshold, stiffness)

    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
        spring = self.spring * np.asarray(stiffness)
        level = log_amount - np.log(self.scale) + 0.5 * np.log(spring)
        level = level + spring * threshold * threshold
        if np.any(near):
            level = np.logaddexp(level, log_growth(np.sqrt(spring) * near))
        x = inverse_log_growth(level) / np.sqrt(spring)
        return np.minimum(np.maximum(x, near), threshold)

    def compiled(self) -> CompiledRates:
        """The same for compiled loops."""
        from origins.laws.soft_compiled import soft_compiled

        return soft_compiled(self.spring, self.scale)


def _length(near: Array, far: Array, spring: Array) -> Array:
    """Integral of h from near to far over h(far), a length."""
    root, rise = np.sqrt(spring), spring * (far - near) * (far + near)
    steep = (dawsn(root * far) - np.exp(-rise) * dawsn(root * near)) / root
    flat = (rise < 1.0) & (near > 0.0)
    if not np.any(flat):
        return np.asarray(steep)
    # the difference of two integrals would lose digits; a sum over Gauss nodes back from `far` does not
    across = far - near
    back = np.multiply.outer(GAUSS_NODES, across)
    total = np.tensordot(GAUSS_WEIGHTS, np.exp(-spring * back * (2.0 * far - back)), 1)
    return np.where(flat, across * total, steep)
