"""A rate law of one's own in the ensemble: calls of its methods in plain Python, some microseconds each.

Kernels know the law by addresses of functions alone, so that one compiled kernel, which is kept on disk, serves all
laws, as for growing thresholds in own.py.
"""

from functools import cache
from math import exp
from typing import Any, NamedTuple

from eq_model.compiling import real
from eq_model.laws.own import Address
from origins.laws.compiled import CompiledRates


class CalledRates(NamedTuple):
    """Methods of a RateLaw for near = 0, as in CompiledRates, and its scale, which is the largest rate."""

    scale: float
    log_rate: Any  # (x, threshold, stiffness)
    passed: Any  # (far, threshold, stiffness)
    reached: Any  # (log_amount, threshold, stiffness)


@cache
def called(rates: Any) -> CompiledRates:
    """For a RateLaw without compiled functions; its scale is `most`."""

    def passed(*given: float) -> float:
        return exp(min(rates.log_passed(0.0, *given), 700.0))  # finite

    def reached(log_amount: float, *rest: float) -> float:
        return float(rates.reached(log_amount, 0.0, *rest))

    # kernels cannot pass on errors of the methods, so they show here
    rates.log_rate(0.0, 1.0, 1.0)
    rates.reached(rates.log_passed(0.0, 0.5, 1.0, 1.0), 0.0, 1.0, 1.0)
    functions = Address(rates.log_rate, 3), Address(passed, 3), Address(reached, 3)
    return CompiledRates(CalledRates(float(rates.scale), *functions), *_FUNCTIONS)


_FUNCTIONS = (
    lambda law, x, threshold, stiffness: law.log_rate(real(x), real(threshold), real(stiffness)),
    lambda law, far, threshold, stiffness: law.passed(real(far), real(threshold), real(stiffness)),
    lambda law, log_amount, threshold, stiffness: law.reached(
        real(log_amount), real(threshold), real(stiffness)
    ),
    lambda law, *_: law.scale,
)
