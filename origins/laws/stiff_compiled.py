"""The rate of stiff contacts for compiled loops; stiff.py is the same for arrays."""

from typing import NamedTuple

import numpy as np

from origins.laws.compiled import CompiledRates, inlined
from origins.laws.stiff_barrier import fall, remaining, stretch


class StiffLaw(NamedTuple):
    """k/2k_BT of mean stiffness, per length squared; ω."""

    spring: float
    omega: float
    log_share: float  # ln (3 k/4 k_BT ω)


def stiff_compiled(temperature: float, omega: float) -> CompiledRates:
    """Of StiffRates."""
    law = StiffLaw(0.5 / temperature, omega, float(np.log(0.75 / (temperature * omega))))
    return CompiledRates(law, _rate, _passed, _reached, _most)


_remaining, _fall, _stretch = inlined(remaining), inlined(fall), inlined(stretch)


def _rate(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
    c, s = law.spring * stiffness * threshold * threshold, max((threshold - x) / threshold, 0.0)
    return law.omega * np.sqrt(s) * np.exp(-c * s * np.sqrt(s))


def _passed(law, near, far, threshold, stiffness):  # type: ignore[no-untyped-def]
    if far <= near:
        return 0.0
    c, gone = law.spring * stiffness * threshold * threshold, _fall(near, far, threshold)
    lost = -np.expm1(-c * gone) / c if c * gone > 1e-300 else gone
    return law.omega * 2.0 / 3.0 * threshold * lost * np.exp(-c * _remaining(far, threshold))


def _reached(law, log_amount, near, threshold, stiffness):  # type: ignore[no-untyped-def]
    c, part = law.spring * stiffness * threshold * threshold, log_amount + law.log_share
    start, part = c * _remaining(near, threshold), part + np.log(threshold * stiffness)
    # c u at the end is -ln(e^part + e^-start), and by so much less than at `near`
    more = np.log1p(np.exp(-abs(part + start)))
    left, gone = start - more, more
    if part + start > 0.0:
        left, gone = -part - more, part + start + more
    if near > 0.0:
        gone += c * _fall(0.0, near, threshold)
    x = _stretch(max(left, 0.0) / c, min(gone / c, 1.0), threshold)
    return min(max(x, near), threshold)


def _most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
    front = max((largest_y - least_x) / largest_y, 0.0) if largest_y > 0.0 else 1.0
    s = max((least_y - largest_x) / least_y, 0.0) if least_y > 0.0 else 0.0
    barrier = law.spring * stiffness * least_y * least_y * s * np.sqrt(s)
    return law.omega * np.sqrt(front) * np.exp(-barrier)
