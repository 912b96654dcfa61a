"""Optional compiled functions of a RateLaw: its rate, integral and inverse, for one contact at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple


class CompiledRates(NamedTuple):
    """Plain functions of numbers that numba can compile; functions that they call must be compiled already.

    Their arguments must have the names given here.

    law : a NamedTuple of numbers and arrays, of a class that no other law has; it is the first
        argument of all functions, lengths and times in it those of the RateLaw.
    rate(law, x, threshold, stiffness) : h at 0 <= x <= threshold, not its logarithm.
    passed(law, x, threshold, stiffness) : the integral of h over the stretches from 0 to x; 0 where
        it underflows.
    reached(law, log_amount, threshold, stiffness) : as RateLaw.reached, from stretch 0.
    most(law, least_x, largest_x, least_y, largest_y, stiffness) : an upper bound of h for stretches x
        and thresholds y between these; a tighter bound is faster.
    """

    law: Any
    rate: Callable[..., float]
    passed: Callable[..., float]
    reached: Callable[..., float]
    most: Callable[..., float]


def inlined(function: Callable[..., Any]) -> Any:
    """`function` compiled as a part of those that call it, for use in the functions of CompiledRates."""
    from numba import njit

    jit: Any = njit  # its type hints do not know all of its options
    return jit(nogil=True, error_model="numpy", _nrt=False, forceinline=True)(function)


@cache
def of_logarithms(*methods: Callable[..., Any]) -> tuple[Any, Any, Any]:
    """rate, passed and reached of CompiledRates from a RateLaw's log_rate, log_passed and reached, as functions of
    `law` and numbers."""
    log_rate, log_passed, reached_from = map(inlined, methods)

    def rate(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
        return math.exp(log_rate(law, x, threshold, stiffness))

    def passed(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
        return math.exp(log_passed(law, 0.0, x, threshold, stiffness))

    def reached(law, log_amount, threshold, stiffness):  # type: ignore[no-untyped-def]
        return reached_from(law, log_amount, 0.0, threshold, stiffness)

    return rate, passed, reached


@cache
def called(rates: Any) -> CompiledRates:
    """For a RateLaw without compiled functions: calls of its methods, some microseconds each; its scale is `most`."""
    from ctypes import CFUNCTYPE, c_double

    # a separate class for each law, so that no two laws share compiled code
    class Called(NamedTuple):
        scale: float

    def number(method: Callable[..., Any], count: int) -> Callable[..., float]:
        callback = CFUNCTYPE(c_double, *[c_double] * count)(lambda *given: float(method(*given)))
        return lambda law, *given: callback(*given)

    def most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
        return law.scale

    # kernels cannot pass on errors of the methods, so they show here
    rates.log_rate(0.0, 1.0, 1.0)
    rates.reached(rates.log_passed(0.0, 0.5, 1.0, 1.0), 0.0, 1.0, 1.0)
    methods = number(rates.log_rate, 3), number(rates.log_passed, 4), number(rates.reached, 4)
    return CompiledRates(Called(float(rates.scale)), *of_logarithms(*methods), most)
