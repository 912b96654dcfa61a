"""Optional compiled functions of a law, for one contact at a time."""

from collections.abc import Callable
from typing import Any, NamedTuple


class CompiledRates(NamedTuple):
    """Plain functions of numbers that numba can compile; functions that they call must be compiled already.

    law : a NamedTuple of numbers and arrays, whose class has a name that no other law's has; it is the first argument
        of all functions, lengths and times in it those of the RateLaw.
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


class CompiledFactor(NamedTuple):
    """As CompiledRates, of a ProportionalGrowth; ages are numbers in units of its `time_unit`.

    law : as there, and the first argument of both functions.
    factor(law, age) : g, as its method of this name.
    slope(law, age) : dg/d(age), which falls with the age, as g is concave.
    """

    law: Any
    factor: Callable[..., float]
    slope: Callable[..., float]


def is_shipped(function: Callable[..., Any]) -> bool:
    """Whether a function of a law stands in this package. Kernels that are kept on disk are told apart by the sources
    of the package alone: one with another's function in it would stay there as that is changed, or serve in its place.
    """
    return function.__module__.startswith("origins.")


def compiled_rates(rates: Any) -> CompiledRates | None:
    """What `compiled` of a RateLaw gives; None of a law without it, and where it is not `is_shipped`."""
    found: CompiledRates | None = rates.compiled() if hasattr(rates, "compiled") else None
    return found if found is not None and is_shipped(found.log_rate) else None


def inlined(function: Callable[..., Any]) -> Any:
    """`function` compiled as a part of those that call it, for use in the functions of CompiledRates."""
    from numba import njit

    jit: Any = njit  # its type hints do not know all of its options
    options = {"nogil": True, "error_model": "numpy", "_nrt": False, "forceinline": True}
    # nobody else calls it, and each wrapper takes the compiler longer than a short function
    return jit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(function)
