"""Eyring's rate: h = ω exp[-(1 - |x|/x_s)/α], whose barrier falls in proportion to the shear stress in a contact.

A junction yields by rearrangements of an activation volume V* of some nm³ under the shear stress τ_s |x|/x_s, τ_s at
the threshold: α = k_BT/(τ_s V*), the same for contacts of every size (Baumberger and Caroli,
Adv. Phys. 55, 279, 2006). The integral of h from 0 to x is ω α x_s [e^(-(1 - x/x_s)/α) - e^(-1/α)].
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from origins.errors import positive, refuse
from origins.laws.compiled import CompiledRates, inlined
from origins.laws.rate_law import Array, Numbers, RateLaw, quiet

# of α: below, contacts break within 1e-6 of their thresholds, as at T = 0
_LEAST = 1e-6


class EyringLaw(NamedTuple):
    """α, no unit; ln of ω, per time."""

    width: float
    log_scale: float


@dataclass(frozen=True)
class EyringRates(RateLaw):
    """Rate whose barrier is 1/α for a relaxed contact of any threshold, and falls in proportion to |x|/x_s.

    width : α = k_BT/(τ_s V*), no unit: the share of its threshold over which h grows by a factor e.
    attempt_frequency : ω, per time, the rate at the threshold, which none exceeds.

    Raises InputError unless width is 1e-6 to 1 and the attempt frequency finite and above zero. The formulas continue
    beyond the threshold; the contact's stiffness does not enter.
    """

    width: float
    attempt_frequency: float = 1.0

    name: ClassVar[Literal["eyring"]] = "eyring"

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive("attempt_frequency", self.attempt_frequency)
        if not _LEAST <= positive("width", self.width) <= 1.0:
            hint = "must be 1e-6 to 1, a number without unit, k_BT/(shear strength x activation volume)"
            refuse("width", self.width, f"{hint}; such as 0.03")

    @property
    def scale(self) -> float:
        """ω, which no rate exceeds."""
        return self.attempt_frequency

    @property
    def log_scale(self) -> float:
        """ln ω."""
        return float(np.log(self.attempt_frequency))

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h."""
        barrier: Any = (threshold - x) / (self.width * threshold)
        return self.log_scale - barrier

    @quiet
    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are equal."""
        length = self.width * threshold
        log_length = np.log(-length * np.expm1((near - far) / length))
        return self.log_rate(far, threshold, stiffness) + log_length

    @quiet
    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
        length = self.width * threshold
        log_ratio = log_amount - np.log(length) - self.log_rate(near, threshold, stiffness)
        return np.minimum(near + length * np.logaddexp(0.0, log_ratio), threshold)

    def compiled(self) -> CompiledRates:
        """The same formulas for compiled loops."""
        return _formulas()._replace(law=EyringLaw(self.width, self.log_scale))


def _formulas() -> CompiledRates:
    """The formulas, yet without the numbers of a law."""
    log_rate = inlined(EyringRates.log_rate)

    def passed(law, far, threshold, stiffness):  # type: ignore[no-untyped-def]
        length = law.width * threshold
        return -np.exp(log_rate(law, far, threshold, stiffness)) * length * np.expm1(-far / length)

    def reached(law, log_amount, threshold, stiffness):  # type: ignore[no-untyped-def]
        length = law.width * threshold
        log_ratio = log_amount - np.log(length) - law.log_scale + 1.0 / law.width
        # of 1 + e^share
        log_sum = max(log_ratio, 0.0) + np.log1p(np.exp(-abs(log_ratio)))
        return min(length * log_sum, threshold)

    def most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
        nearest = min(largest_x, least_y)
        if least_y <= 0.0:
            return np.exp(law.log_scale)
        return np.exp(log_rate(law, nearest, least_y, stiffness))

    rate: Any = EyringRates.log_rate  # of scalars in compiled loops
    return CompiledRates(None, rate, passed, reached, most, falls=True)
