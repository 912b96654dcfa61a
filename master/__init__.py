"""What the distribution of contacts does: the master equation, solved as a renewal equation."""

from master.paper.critical_velocity import CriticalVelocity, critical_velocity
from master.rate_state.estimate import rate_state
from master.rate_state.result import RateState
from master.solution import Solution
from master.solve import solve
from master.steady.kinetic import KineticCurve, kinetic_curve
from master.steady.steady import SteadyState, steady_state
from master.stick_slip.propensity import PhaseLine, Propensity, phase_line, propensity
from master.stick_slip.spectrum import DecoherenceSpectrum, decoherence_spectrum

__all__ = ["CriticalVelocity", "DecoherenceSpectrum", "KineticCurve", "PhaseLine", "Propensity"]
__all__ += ["RateState", "rate_state"]
__all__ += ["Solution", "SteadyState", "critical_velocity", "decoherence_spectrum"]
__all__ += ["kinetic_curve", "phase_line", "propensity", "solve", "steady_state"]
