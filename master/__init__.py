"""What the distribution of contacts does: the master equation, solved as a renewal equation."""

from master.decoherence_spectrum import DecoherenceSpectrum, decoherence_spectrum
from master.kinetic import KineticCurve, kinetic_curve
from master.paper.critical_velocity import CriticalVelocity, critical_velocity
from master.phase_line import PhaseLine, phase_line
from master.propensity import Propensity, propensity
from master.solution import Solution
from master.solve import solve
from master.steady import SteadyState, steady_state

__all__ = [
    "CriticalVelocity",
    "DecoherenceSpectrum",
    "KineticCurve",
    "PhaseLine",
    "Propensity",
    "Solution",
    "SteadyState",
    "critical_velocity",
    "decoherence_spectrum",
    "kinetic_curve",
    "phase_line",
    "propensity",
    "solve",
    "steady_state",
]
