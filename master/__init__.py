"""What the distribution of contacts does: the master equation, solved as a renewal equation."""

from master.propensity import Propensity, propensity
from master.solution import Solution
from master.solve import solve
from master.steady import SteadyState, steady_state

__all__ = ["Propensity", "Solution", "SteadyState", "propensity", "solve", "steady_state"]
