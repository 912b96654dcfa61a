"""What the distribution of contacts does: the master equation, solved as a renewal equation, or in steps of time."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from master.solution import Solution
from master.solve import solve

if TYPE_CHECKING:
    from master.paper.critical_velocity import CriticalVelocity, critical_velocity
    from master.paper.explicit import explicit
    from master.paper.q15_transient import paper_transient
    from master.rate_state.estimate import rate_state
    from master.rate_state.result import RateState
    from master.steady.kinetic import KineticCurve, kinetic_curve
    from master.steady.steady import SteadyState, steady_state
    from master.stick_slip.propensity import PhaseLine, Propensity, phase_line, propensity
    from master.stick_slip.spectrum import DecoherenceSpectrum, decoherence_spectrum
else:
    # the package is imported now, as later it would take the place of the function of its name
    from master import rate_state

    del rate_state

__all__ = ["CriticalVelocity", "DecoherenceSpectrum", "KineticCurve", "PhaseLine", "Propensity"]
__all__ += ["RateState", "rate_state"]
__all__ += ["Solution", "SteadyState", "critical_velocity", "decoherence_spectrum"]
__all__ += ["kinetic_curve", "phase_line", "propensity", "solve", "steady_state"]
__all__ += ["explicit", "paper_transient"]  # the paper's own schemes, step by step

# The modules of the names that are imported on first use: `solve` needs none of them.
_HOMES = {"CriticalVelocity": "paper.critical_velocity", "RateState": "rate_state.result"}
_HOMES |= {"critical_velocity": "paper.critical_velocity", "rate_state": "rate_state.estimate"}
_HOMES |= {"explicit": "paper.explicit", "paper_transient": "paper.q15_transient"}
_HOMES |= dict.fromkeys(["KineticCurve", "kinetic_curve"], "steady.kinetic")
_HOMES |= dict.fromkeys(["SteadyState", "steady_state"], "steady.steady")
_HOMES |= dict.fromkeys(["PhaseLine", "Propensity"], "stick_slip.propensity")
_HOMES |= dict.fromkeys(["phase_line", "propensity"], "stick_slip.propensity")
_HOMES |= dict.fromkeys(["DecoherenceSpectrum", "decoherence_spectrum"], "stick_slip.spectrum")


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'master' has no attribute {name!r}")
    return getattr(import_module(f"master.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    # for completion, which does not ask __getattr__
    return sorted(__all__)
