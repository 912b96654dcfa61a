"""The rate of soft contacts for compiled loops; soft.py is the same for arrays."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

from origins.laws.compiled import CompiledRates, inlined
from origins.laws.rate_law import Array

_STEP = 1.0 / 128.0  # of the tables: cubics are then exact to 1e-9 of D and to 1e-11 of a stretch
_LAST = 12.0  # above which Dawson's integral is a series
_LOW, _HIGH = -4.0, 36.0  # levels y² + ln D(y) between which the inverse is tabulated


class SoftLaw(NamedTuple):
    """b = k/2k_BT at mean stiffness, per length squared; ω; tables of D(y) and of the inverse of y² + ln D(y)."""

    spring: float
    log_share: float  # ln (b^(1/2)/ω)
    omega: float
    dawson: Array
    dawson_slopes: Array
    inverse: Array
    inverse_slopes: Array


@cache
def _tables(inverse_of: Callable[[npt.ArrayLike], Array]) -> list[Array]:
    """The four tables of SoftLaw; slopes are per step."""
    y = _STEP * np.arange(int(_LAST / _STEP) + 1)
    inverse = inverse_of(_LOW + _STEP * np.arange(int((_HIGH - _LOW) / _STEP) + 1))
    return [dawsn(y), _STEP * (1.0 - 2.0 * y * dawsn(y)), inverse, _STEP * dawsn(inverse)]


def soft_compiled(
    spring: float, omega: float, inverse_of: Callable[[npt.ArrayLike], Array]
) -> CompiledRates:
    """The compiled functions of SoftRates with this k/2k_BT and ω; inverse_of is the inverse of y² + ln D(y)."""
    law = SoftLaw(spring, float(0.5 * np.log(spring) - np.log(omega)), omega, *_tables(inverse_of))
    return CompiledRates(law, _rate, _passed, _reached, _most)


@inlined
def _hermite(place, values, slopes):  # type: ignore[no-untyped-def]
    k = min(max(int(place), 0), values.size - 2)
    t = place - k
    rise = values[k + 1] - values[k]
    p, q = slopes[k] - rise, slopes[k + 1] - rise
    return values[k] + t * (rise + (1.0 - t) * (p - t * (p + q)))


@inlined
def _dawson(y, law):  # type: ignore[no-untyped-def]
    """Dawson's integral for y >= 0."""
    if y < 0.02:
        return y * (1.0 - y * y * (2.0 / 3.0 - y * y * (4.0 / 15.0)))
    if y < _LAST:
        return _hermite(y / _STEP, law.dawson, law.dawson_slopes)
    s = 0.5 / (y * y)
    series = 15.0 + s * (105.0 + s * (945.0 + s * 10395.0))
    return (1.0 + s * (1.0 + s * (3.0 + s * series))) / (2.0 * y)


@inlined
def _inverse_log_growth(level, law):  # type: ignore[no-untyped-def]
    """The y at which y² + ln D(y) = level, to a relative 1e-8 above the table."""
    if level < _LOW:
        y = np.exp(level)
        return y * (1.0 - y * y * (1.0 / 3.0 - y * y * (7.0 / 30.0)))
    if level < _HIGH:
        return _hermite((level - _LOW) / _STEP, law.inverse, law.inverse_slopes)
    square = level + 0.5 * np.log(4.0 * level)
    for _ in range(5):
        s = 0.5 / square
        growth = np.log1p(s * (1.0 + s * (3.0 + s * (15.0 + s * 105.0))))
        square = level + 0.5 * np.log(4.0 * square) - growth
    return np.sqrt(square)


def _rate(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
    return law.omega * np.exp(-law.spring * stiffness * (threshold - x) * (threshold + x))


def _passed(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
    spring = law.spring * stiffness
    root, hazard = np.sqrt(spring), law.omega * np.exp(-spring * (threshold - x) * (threshold + x))
    return hazard * _dawson(root * x, law) / root


def _reached(law, log_amount, threshold, stiffness):  # type: ignore[no-untyped-def]
    spring = law.spring * stiffness
    level = log_amount + law.log_share + 0.5 * np.log(stiffness) + spring * threshold * threshold
    return min(_inverse_log_growth(level, law) / np.sqrt(spring), threshold)


def _most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
    apart = (least_y - largest_x) * (least_y + largest_x)
    return law.omega * np.exp(min(-law.spring * stiffness * apart, 0.0))
