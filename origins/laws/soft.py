"""Soft contacts: h = ω exp[-k_i (x_s² - x²) / 2k_BT] (paper, Eqs. temper5 and temper8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

from origins.errors import TEMPERATURE, positive
from origins.laws.compiled import CompiledRates
from origins.laws.dawson import inverse_log_growth, log_growth
from origins.laws.rate_law import Numbers, RateLaw
from origins.thresholds.quadrature import GAUSS_NODES, GAUSS_WEIGHTS

Array = npt.NDArray[np.float64]

_FLAT = 1.0  # change of ln h over a way below which eight Gauss nodes are exact


@dataclass(frozen=True)
class SoftRates(RateLaw):
    """Rate of soft contacts: barrier b (x_s² - x²), b = k_i/2k_BT per length² (paper, Eq. temper8).

    With Dawson's integral D the integral of h from 0 to x is h(x) D(b^(1/2) x) / b^(1/2).

    Attributes
    ----------
    temperature : float
        T = k_BT/<k>, a length squared, so that b = stiffness/2T.
    attempt_frequency : float
        ω, per time.

    Raises InputError unless both are finite and above zero. The formulas continue beyond the
    threshold.
    """

    temperature: float
    attempt_frequency: float = 1.0
    name: ClassVar[Literal["soft"]] = "soft"
    vanishes_at_threshold: ClassVar[bool] = False
    separable: ClassVar[bool] = True

    def __post_init__(self) -> None:
        positive("temperature", self.temperature, TEMPERATURE)
        positive("attempt_frequency", self.attempt_frequency)

    @property
    def scale(self) -> float:
        """ω, the rate at the threshold."""
        return self.attempt_frequency

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h."""
        x, threshold = np.asarray(x), np.asarray(threshold)
        barrier = self._spring(stiffness) * (threshold - x) * (threshold + x)
        return np.log(self.attempt_frequency) - barrier

    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are equal."""
        near, far, threshold = np.asarray(near), np.asarray(far), np.asarray(threshold)
        spring = self._spring(stiffness)
        rise = np.asarray(spring * (far - near) * (far + near))
        length = _length(rise, near, far, spring)
        with np.errstate(divide="ignore", over="ignore"):
            passed = np.log(length) - spring * (threshold - far) * (threshold + far)
        return np.log(self.attempt_frequency) + passed

    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
        spring, threshold = self._spring(stiffness), np.asarray(threshold)
        root = np.sqrt(spring)
        log_share = log_amount - np.log(self.attempt_frequency)
        level = log_share + (0.5 * np.log(spring) + spring * threshold * threshold)
        if np.any(near):
            level = np.logaddexp(level, log_growth(root * near))
        return np.minimum(np.maximum(inverse_log_growth(level) / root, near), threshold)

    def compiled(self) -> CompiledRates:
        """The same for compiled loops."""
        from origins.laws.soft_compiled import soft_compiled

        return soft_compiled(self.temperature, self.attempt_frequency)

    def _spring(self, stiffness: Numbers) -> Array:
        """b = k_i/2k_BT, per length squared."""
        return np.asarray(stiffness) / (2.0 * self.temperature)


def _length(rise: Array, near: Array, far: Array, spring: Array) -> Array:
    """Integral of h from near to far over h(far), a length; h rises by e^rise. Shape as rise."""
    root = np.sqrt(spring)
    steep = (dawsn(root * far) - np.exp(-rise) * dawsn(root * near)) / root
    flat = (rise < _FLAT) & (near > 0.0)
    if not flat.any():
        return np.asarray(steep)
    # the difference of two integrals would lose digits; a sum over Gauss nodes back from `far` does not
    across = far - near
    back = np.multiply.outer(GAUSS_NODES, across)
    total = np.tensordot(GAUSS_WEIGHTS, np.exp(-spring * back * (2.0 * far - back)), 1)
    return np.where(flat, across * total, steep)
