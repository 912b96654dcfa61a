"""Soft contacts: h = ω exp[-k_i (x_s² - x²) / 2k_BT] (paper, Eqs. temper5 and temper8).

With b = k_i/2k_BT and Dawson's integral D the integral of h from 0 to x is h(x) D(b^(1/2) x) / b^(1/2).
"""

from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from origins.laws.compiled import CompiledRates, inlined
from origins.laws.rate_law import ActivatedRates, Array, Numbers, quiet
from origins.thresholds.quadrature import GAUSS_NODES, GAUSS_WEIGHTS


@dataclass(frozen=True)
class SoftRates(ActivatedRates):
    """Rate of soft contacts, whose barrier is b (x_s² - x²) (paper, Eq. temper8).

    Attributes and errors are those of ActivatedRates. The formulas continue beyond the threshold.
    """

    name: ClassVar[Literal["soft"]] = "soft"
    separable: ClassVar[bool] = True

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers) -> Array:
        """ln h."""
        barrier: Any = self.spring * stiffness * (threshold - x) * (threshold + x)
        return self.log_scale - barrier

    @quiet
    def log_passed(
        self, near: Numbers, far: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """ln of the integral of h from near to far; -inf where they are equal."""
        spring, across = self.spring * np.asarray(stiffness), np.asarray(far - near)
        root, rise = np.sqrt(spring), spring * across * (far + near)
        # the integral divided by h(far), a length
        lower, upper = (scipy.special.dawsn(root * end) for end in (near, far))
        length = (upper - np.exp(-rise) * lower) / root
        flat = (rise < 1.0) & np.greater(near, 0.0)
        if np.any(flat):
            # the difference of two integrals would lose digits; a sum over Gauss nodes back from `far` does not
            back = np.multiply.outer(GAUSS_NODES, across)
            total = np.tensordot(GAUSS_WEIGHTS, np.exp(-spring * back * (2.0 * far - back)), 1)
            length = np.where(flat, across * total, length)
        return np.log(length) + self.log_rate(far, threshold, stiffness)

    @quiet
    def reached(
        self, log_amount: Numbers, near: Numbers, threshold: Numbers, stiffness: Numbers
    ) -> Array:
        """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
        spring = self.spring * np.asarray(stiffness)
        log_growth = (
            log_amount - self.log_scale + 0.5 * np.log(spring) + spring * threshold * threshold
        )
        if np.any(near):
            y = np.sqrt(spring) * near
            log_growth = np.logaddexp(log_growth, y * y + np.log(scipy.special.dawsn(y)))
        x = inverse_log_growth(log_growth) / np.sqrt(spring)
        return np.minimum(np.maximum(x, near), threshold)

    def compiled(self) -> CompiledRates:
        """The same for compiled loops, from tables."""
        return _formulas()._replace(law=SoftLaw(self.spring, self.log_scale, *_tables()))


@quiet
def inverse_log_growth(log_growth: npt.ArrayLike) -> Array:
    """The y >= 0 at which the integral of exp(t²) from 0 to y is e^log_growth, to a relative 1e-14; same shape.

    By Halley's steps in ln y for the logarithm of the integral, y² + ln D(y), whose slope there is y/D(y).
    """
    log_growth = np.asarray(log_growth, dtype=float)
    # below exp(-667), where the square of y underflows, the integral is y to the last bit
    goal = np.clip(log_growth, -667.0, 1e300)
    # the integral is above y, and above exp(y²)/(2y + 1)
    rough = np.sqrt(np.maximum(goal, 0.0) + 1.0)
    y = np.minimum(np.exp(goal), np.sqrt(np.maximum(goal, 0.0) + np.log(2.0 * rough + 3.0)))
    for _ in range(3):  # from within 1.3 of y; each step cubes the error
        slope = y / scipy.special.dawsn(y)
        newton = (y * y + np.log(y / slope) - goal) / slope
        bend = np.clip(1.0 + 2.0 * y * y - slope, 0.0, 3.0)  # where y is large it is 2 and cancels
        y = y * np.exp(-newton / (1.0 - 0.5 * bend * newton))
    return np.where(log_growth == goal, y, np.exp(log_growth))[()]


class SoftLaw(NamedTuple):
    """b = k/2k_BT at mean stiffness, per length squared; ln of ω, per time; tables of D(y) and of the inverse of
    y² + ln D(y), values and slopes per step, shapes (n, 2)."""

    spring: float
    log_scale: float
    dawson: Array
    inverse: Array


# Cells of the table of D along 1/(1 + y): cubics are exact to a relative 1e-9. That of the inverse goes along the
# log, y² + ln D(y), from _LOW, below which y is its exponential to 1e-11, to _HIGH: cubics are exact to 2e-10.
_CELLS = 2048.0
_LOW, _HIGH, _STEP = -12.0, 64.0, 1.0 / 64.0


@cache
def _tables() -> tuple[Array, Array]:
    part = np.arange(1.0, _CELLS + 1.0) / _CELLS
    y = 1.0 / part - 1.0
    values = np.append(0.0, scipy.special.dawsn(y))
    slopes = np.append(0.5, (2.0 * y * scipy.special.dawsn(y) - 1.0) / part**2)
    inverse = inverse_log_growth(np.arange(_LOW, _HIGH + _STEP, _STEP))
    tables = [values, slopes / _CELLS], [inverse, _STEP * scipy.special.dawsn(inverse)]
    return np.transpose(tables[0]).copy(), np.transpose(tables[1]).copy()


@cache
def _formulas() -> CompiledRates:
    """The formulas, yet without the numbers of a law."""
    log_rate = inlined(SoftRates.log_rate)

    @inlined
    def cubic(place, table):  # type: ignore[no-untyped-def]
        k = min(max(int(place), 0), table.shape[0] - 2)
        t, rise = place - k, table[k + 1, 0] - table[k, 0]
        p, q = table[k, 1] - rise, table[k + 1, 1] - rise
        return table[k, 0] + t * (rise + (1.0 - t) * (p - t * (p + q)))

    @inlined
    def dawson(y, law):  # type: ignore[no-untyped-def]
        return cubic(_CELLS / (1.0 + y), law.dawson)

    @inlined
    def inverse(log_growth, law):  # type: ignore[no-untyped-def]
        if log_growth < _LOW:
            return np.exp(log_growth)
        if log_growth < _HIGH:
            return cubic((log_growth - _LOW) / _STEP, law.inverse)
        # a step of Newton's from y² of D(y) = 1/2y, to a relative 5e-9
        square = log_growth + 0.5 * np.log(4.0 * log_growth)
        slope = dawson(np.sqrt(square), law)
        return np.sqrt(square) - (square + np.log(slope) - log_growth) * slope

    def passed(law, far, threshold, stiffness):  # type: ignore[no-untyped-def]
        root = np.sqrt(law.spring * stiffness)
        return np.exp(log_rate(law, far, threshold, stiffness)) * dawson(root * far, law) / root

    def reached(law, log_amount, threshold, stiffness):  # type: ignore[no-untyped-def]
        spring = law.spring * stiffness
        log_growth = (
            log_amount + (0.5 * np.log(spring) - law.log_scale) + spring * threshold * threshold
        )
        return min(inverse(log_growth, law) / np.sqrt(spring), threshold)

    def most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
        return np.exp(log_rate(law, min(largest_x, least_y), least_y, stiffness))

    rate: Any = SoftRates.log_rate  # of scalars in compiled loops
    return CompiledRates(None, rate, passed, reached, most, falls=True)
