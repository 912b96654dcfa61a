"""What the distribution of contacts does: the master equation, solved as a renewal equation."""

from master.solution import Solution
from master.solve import solve

__all__ = ["Solution", "solve"]
