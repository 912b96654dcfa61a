"""Stiff contacts: h = ω s^(1/2) exp[-k_i x_s² s^(3/2) / 2k_BT] with s = 1 - x/x_s (paper, Eqs. temper9, temper10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from origins.errors import TEMPERATURE, positive
from origins.laws.compiled import CompiledRates
from origins.laws.rate_law import Numbers, RateLaw
from origins.laws.stiff_formulas import StiffLaw, log_passed, log_rate, reached

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class StiffRates(RateLaw):
    """Rate of stiff contacts, whose barrier vanishes as s^(3/2) (paper, Eqs. temper9 and temper10).

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
        return self._of(log_rate, x, threshold, stiffness)

    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are equal."""
        return self._of(log_passed, near, far, threshold, stiffness)

    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
        return self._of(reached, log_amount, near, threshold, stiffness)

    def compiled(self) -> CompiledRates:
        """The same for compiled loops."""
        from origins.laws.stiff_compiled import stiff_compiled

        return stiff_compiled(self._law)

    @property
    def _law(self) -> StiffLaw:
        return StiffLaw(0.5 / self.temperature, self.attempt_frequency)

    def _of(self, formula: Any, *given: Numbers) -> Array:
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(formula(self._law, *(np.asarray(each) for each in given)))
