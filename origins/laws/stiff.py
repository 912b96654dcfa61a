"""Stiff contacts: h = ω s^(1/2) exp[-k_i x_s² s^(3/2) / 2k_BT] with s = 1 - x/x_s.

Paper, Eqs. temper9 and temper10.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt
from scipy.special import exprel

from origins.errors import TEMPERATURE, positive
from origins.laws.compiled import CompiledRates
from origins.laws.rate_law import Numbers, RateLaw
from origins.laws.stiff_barrier import fall, remaining, stretch

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StiffRates(RateLaw):
    """Rate of stiff contacts, whose barrier vanishes as s^(3/2) (paper, Eqs. temper9 and temper10).

    c = k_i x_s²/2k_BT is the barrier at x = 0, and u falls from 1 to 0 on the way to the threshold.
    The integral of h is (2 ω x_s/3c) (e^(-c u_far) - e^(-c u_near)).

    Attributes
    ----------
    temperature : float
        T = k_BT/<k>, a length squared, so that c = stiffness x_s²/2T.
    attempt_frequency : float
        ω, per time.

    Raises InputError unless both are finite and above zero.
    """

    temperature: float
    attempt_frequency: float = 1.0
    name: ClassVar[Literal["stiff"]] = "stiff"
    vanishes_at_threshold: ClassVar[bool] = True
    separable: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive("temperature", self.temperature, TEMPERATURE)
        positive("attempt_frequency", self.attempt_frequency)

    @property
    def scale(self) -> float:
        """ω, which no rate exceeds."""
        return self.attempt_frequency

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h; -inf at the threshold."""
        x, threshold = np.asarray(x), np.asarray(threshold)
        s = (threshold - x) / threshold
        barrier = self._spring(stiffness) * threshold * threshold * (s * np.sqrt(s))
        with np.errstate(divide="ignore", over="ignore"):
            return np.log(self.attempt_frequency) + (0.5 * np.log(s) - barrier)

    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are one."""
        near, far, threshold = np.asarray(near), np.asarray(far), np.asarray(threshold)
        c, lost = self._spring(stiffness) * threshold * threshold, fall(near, far, threshold)
        with np.errstate(divide="ignore", over="ignore"):
            log_length = np.log(2.0 / 3.0 * threshold * lost * exprel(-c * lost))
        return np.log(self.attempt_frequency) + (log_length - c * remaining(far, threshold))

    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch up to which the integral of h from near on is e^log_amount, or the threshold."""
        near, threshold = np.asarray(near), np.asarray(threshold)
        c = self._spring(stiffness) * threshold * threshold
        log_part = log_amount - np.log(self.attempt_frequency) + np.log(1.5 * c / threshold)
        start = c * remaining(near, threshold)
        level = log_part + start
        # c u at the end is -ln(e^part + e^-start), and by so much less than at `near`
        more = np.log1p(np.exp(-np.abs(level)))
        left = np.maximum(np.minimum(-log_part, start) - more, 0.0) / c
        gone = fall(0.0, near, threshold) + (np.maximum(level, 0.0) + more) / c
        return np.clip(stretch(left, gone, threshold), near, threshold)

    def compiled(self) -> CompiledRates:
        """The same for compiled loops."""
        from origins.laws.stiff_compiled import stiff_compiled

        return stiff_compiled(self.temperature, self.attempt_frequency)

    def _spring(self, stiffness: Numbers) -> Array:
        """k_i/2k_BT, per length squared."""
        return np.asarray(stiffness) / (2.0 * self.temperature)
