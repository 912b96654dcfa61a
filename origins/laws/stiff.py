"""Stiff contacts: h = ω s^(1/2) exp[-k_i x_s² s^(3/2) / 2k_BT] with s = 1 - x/x_s (paper, Eqs. temper9, temper10).

c = k_i x_s²/2k_BT is the barrier at x = 0, and u = s^(3/2) falls from 1 to 0 on the way to the threshold. The
integral of h is (2 ω x_s/3c) (e^(-c u_far) - e^(-c u_near)).
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from origins.laws.compiled import CompiledRates
from origins.laws.rate_law import ActivatedRates, Array, Numbers, quiet


class StiffLaw(NamedTuple):
    """k/2k_BT at mean stiffness, per length squared; ln of ω, per time."""

    spring: float
    log_scale: float


@dataclass(frozen=True)
class StiffRates(ActivatedRates):
    """Rate whose barrier vanishes as s^(3/2) (paper, Eqs. temper9 and temper10); attributes as ActivatedRates."""

    name: ClassVar[Literal["stiff"]] = "stiff"

    @quiet
    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h; -inf at the threshold."""
        s = np.maximum((threshold - x) / threshold, 0.0)
        barrier = self.spring * stiffness * threshold * threshold * (s * np.sqrt(s))
        return self.log_scale + (0.5 * np.log(s) - barrier)

    @quiet
    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are equal."""
        c = self.spring * stiffness * threshold * threshold
        first = np.sqrt(np.maximum((threshold - near) / threshold, 0.0))
        last = np.sqrt(np.maximum((threshold - far) / threshold, 0.0))
        # u(near) - u(far), without cancellation
        fall = (far - near) / threshold * (first * first + first * last + last * last)
        fall = fall / np.maximum(first + last, 1e-300)
        log_length = np.log(2.0 / 3.0 * threshold * (-np.expm1(-c * fall) / c))
        return self.log_scale + (log_length - c * last * last * last)

    @quiet
    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
        c = self.spring * stiffness * threshold * threshold
        log_part = log_amount - self.log_scale + np.log(1.5 * c / threshold)
        begin = c * np.maximum((threshold - near) / threshold, 0.0) ** 1.5
        # c u at the end is -ln(e^log_part + e^(-c u_near)), less than `begin` by `lost`
        more = log_part + begin
        lost = np.logaddexp(0.0, more)
        u = np.maximum(np.minimum(-log_part, begin) - np.log1p(np.exp(-np.abs(more))), 0.0) / c
        part = np.minimum(lost, 0.5 * begin) / np.maximum(begin, 1e-300)
        short = near - (threshold - near) * np.expm1(np.log1p(-part) / 1.5)  # to all digits
        x = np.where(lost < 0.5 * begin, short, threshold * (1.0 - np.cbrt(u) ** 2))
        return np.minimum(np.maximum(x, near), threshold)

    def compiled(self) -> CompiledRates:
        """The same formulas for compiled loops."""
        log_rate: Any = StiffRates.log_rate
        law = StiffLaw(self.spring, self.log_scale)
        return CompiledRates(law, log_rate.__wrapped__, _passed, _reached, _most)


def _passed(law, far, threshold, stiffness):  # type: ignore[no-untyped-def]
    c, s = law.spring * stiffness * threshold * threshold, max((threshold - far) / threshold, 0.0)
    fall = np.exp(law.log_scale - c * (s * np.sqrt(s))) - np.exp(law.log_scale - c)
    return fall * threshold / (1.5 * c)


def _reached(law, log_amount, threshold, stiffness):  # type: ignore[no-untyped-def]
    each = law.spring * stiffness * threshold
    # e^(-c u) = e^-c + amount (3c/2 ω x_s), which gives u to 1e-16/c; most contacts meet the threshold, u = 0, first
    survival = np.exp(log_amount - law.log_scale) * (1.5 * each)
    if survival >= 1.0:
        return threshold
    survival += np.exp(-each * threshold)
    u = -np.log(max(survival, 1e-300)) / max(each * threshold, 1e-300)
    return threshold * (1.0 - np.exp(2.0 / 3.0 * np.log(min(max(u, 1e-30), 1.0))))


def _most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
    front = max((largest_y - least_x) / largest_y, 0.0) if largest_y > 0.0 else 1.0
    s = max((least_y - largest_x) / least_y, 0.0) if least_y > 0.0 else 0.0
    barrier = law.spring * stiffness * least_y * least_y * s * np.sqrt(s)
    return np.sqrt(front) * np.exp(law.log_scale - barrier)
