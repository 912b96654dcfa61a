"""The rate of stiff contacts for compiled loops, by the formulas of stiff_formulas.py."""

import numpy as np

from origins.laws import stiff_formulas
from origins.laws.compiled import CompiledRates, inlined

_log_rate, _log_passed = inlined(stiff_formulas.log_rate), inlined(stiff_formulas.log_passed)
_reached_from = inlined(stiff_formulas.reached)


def stiff_compiled(law: stiff_formulas.StiffLaw) -> CompiledRates:
    """The compiled functions of StiffRates."""
    return CompiledRates(law, _rate, _passed, _reached, _most)


def _rate(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
    return np.exp(_log_rate(law, x, threshold, stiffness))


def _passed(law, x, threshold, stiffness):  # type: ignore[no-untyped-def]
    return np.exp(_log_passed(law, 0.0, x, threshold, stiffness))


def _reached(law, log_amount, threshold, stiffness):  # type: ignore[no-untyped-def]
    return _reached_from(law, log_amount, 0.0, threshold, stiffness)


def _most(law, least_x, largest_x, least_y, largest_y, stiffness):  # type: ignore[no-untyped-def]
    front = max((largest_y - least_x) / largest_y, 0.0) if largest_y > 0.0 else 1.0
    s = max((least_y - largest_x) / least_y, 0.0) if least_y > 0.0 else 0.0
    barrier = law.spring * stiffness * least_y * least_y * s * np.sqrt(s)
    return law.omega * np.sqrt(front) * np.exp(-barrier)
