"""Optional compiled functions of a RateLaw, for one contact at a time."""

from collections.abc import Callable
from functools import cache
from math import exp
from typing import Any, NamedTuple


class CompiledRates(NamedTuple):
    """Plain functions of numbers that numba can compile; functions that they call must be compiled already.

    law : a NamedTuple of numbers and arrays, of a class that no other law has; it is the first argument of all
        functions, lengths and times in it those of the RateLaw.
    log_rate(law, x, threshold, stiffness),
    passed(law, far, threshold, stiffness), the integral of h from 0 to far,
    reached(law, log_amount, threshold, stiffness) : as the methods of RateLaw, for near = 0.
    most(law, least_x, largest_x, least_y, largest_y, stiffness) : an upper bound of h for stretches x and thresholds y
        between these; a tighter bound is faster.
    falls : whether h nowhere rises with the threshold, so that a contact whose threshold grows draws fewer breaks.
    """

    law: Any
    log_rate: Callable[..., float]
    passed: Callable[..., float]
    reached: Callable[..., float]
    most: Callable[..., float]
    falls: bool = False


def inlined(function: Callable[..., Any]) -> Any:
    """`function` compiled as a part of those that call it, for use in the functions of CompiledRates."""
    from numba import njit

    jit: Any = njit  # its type hints do not know all of its options
    options = {"nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True}
    # nobody else calls it, and each wrapper takes the compiler longer than a short function
    return jit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(function)


@cache
def called(rates: Any) -> CompiledRates:
    """For a RateLaw without compiled functions: calls of its methods, some microseconds each; its scale is `most`."""
    from ctypes import CFUNCTYPE, c_double
    from warnings import filterwarnings

    # callbacks have another address in each process, so that no kernel with them is kept on disk
    filterwarnings("ignore", "Cannot cache compiled function")

    # a separate class for each law, so that no two laws share compiled code
    class Called(NamedTuple):
        scale: float

    def number(method: Callable[..., Any], count: int) -> Callable[..., float]:
        callback = CFUNCTYPE(c_double, *[c_double] * count)(lambda *given: float(method(*given)))
        return lambda law, *given: callback(*given)

    # kernels cannot pass on errors of the methods, so they show here
    rates.log_rate(0.0, 1.0, 1.0)
    rates.reached(rates.log_passed(0.0, 0.5, 1.0, 1.0), 0.0, 1.0, 1.0)
    passed = number(lambda *given: exp(min(rates.log_passed(0.0, *given), 700.0)), 3)  # finite
    reached = number(lambda log_amount, *rest: rates.reached(log_amount, 0.0, *rest), 3)
    law = Called(float(rates.scale))
    return CompiledRates(law, number(rates.log_rate, 3), passed, reached, lambda law, *_: law.scale)
