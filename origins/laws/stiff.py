"""Stiff contacts: h = ω s^(1/2) exp[-k_i x_s² s^(3/2) / 2k_BT] with s = 1 - x/x_s (paper, Eqs. temper9, temper10).

c = k_i x_s²/2k_BT is the barrier at x = 0, and u = s^(3/2) falls from 1 to 0 on the way to the threshold. The
integral of h is (2 ω x_s/3c) (e^(-c u_far) - e^(-c u_near)). The functions are of numbers and of arrays
alike, as compiled loops over single contacts call them too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.errors import TEMPERATURE, positive
from origins.laws.compiled import CompiledRates
from origins.laws.rate_law import Numbers, RateLaw

Array = npt.NDArray[np.float64]


class StiffLaw(NamedTuple):
    """k/2k_BT of mean stiffness, per length squared; ω, per time."""

    spring: float
    omega: float


def log_rate(law: StiffLaw, x: Any, threshold: Any, stiffness: Any) -> Any:
    """ln h; -inf at the threshold."""
    s = np.maximum((threshold - x) / threshold, 0.0)
    barrier = law.spring * stiffness * threshold * threshold * (s * np.sqrt(s))
    return np.log(law.omega) + (0.5 * np.log(s) - barrier)


def log_passed(law: StiffLaw, near: Any, far: Any, threshold: Any, stiffness: Any) -> Any:
    """ln of the integral of h from near to far; -inf where they are one."""
    c = law.spring * stiffness * threshold * threshold
    first = np.sqrt(np.maximum((threshold - near) / threshold, 0.0))
    last = np.sqrt(np.maximum((threshold - far) / threshold, 0.0))
    # u(near) - u(far), without cancellation
    lost = (far - near) / threshold * (first * first + first * last + last * last)
    lost = lost / np.maximum(first + last, 1e-300)
    length = 2.0 / 3.0 * threshold * (-np.expm1(-c * lost) / c)
    return np.log(law.omega) + (np.log(length) - c * last * last * last)


def reached(law: StiffLaw, log_amount: Any, near: Any, threshold: Any, stiffness: Any) -> Any:
    """Stretch up to which the integral of h from near on is e^log_amount, or the threshold."""
    c = law.spring * stiffness * threshold * threshold
    log_part = log_amount - np.log(law.omega) + np.log(1.5 * c / threshold)
    root = np.sqrt(np.maximum((threshold - near) / threshold, 0.0))
    level = log_part + c * root * root * root
    # c u at the end is -ln(e^part + e^-start), and by so much less than at `near`
    more = np.log1p(np.exp(-np.abs(level)))
    u = np.maximum(np.minimum(-log_part, c * root * root * root) - more, 0.0) / c
    gone = near / threshold * (1.0 + root + root * root) / (1.0 + root)
    gone = gone + (np.maximum(level, 0.0) + more) / c
    # x from u, and from gone = 1 - u, by whichever is the smaller and has kept its digits
    late = 1.0 - np.cbrt(u * u)
    early = -np.expm1(2.0 / 3.0 * np.log1p(-np.minimum(gone, 0.75)))
    is_late = u < 0.5
    x = threshold * (is_late * late + (1.0 - is_late) * early)
    return np.minimum(np.maximum(x, near), threshold)


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
        """ln of the integral of h from near to far; -inf where they are one."""
        return self._of(log_passed, near, far, threshold, stiffness)

    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch up to which the integral of h from near on is e^log_amount, or the threshold."""
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
