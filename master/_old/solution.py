"""What `solve` returns, and Q(x;X) read from it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from master._old.distribution import StretchDistribution, distribution_at
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from origins.brief import brief
from origins.errors import finite

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Solution:
    """F(X) of the master equation with the error it is good to.

    Attributes
    ----------
    path : array of shape (n,)
        Slider positions X (lengths).
    force : array of shape (n,)
        F/(N_c <k>), the mean stretch of the contacts (a length).
    force_error : float
        Bound on the largest error of `force` over the path, in units of the mean threshold.
    holding : array of shape (n,)
        Fraction of contacts that hold: 1 but with a delay.
    run_time : float
        Seconds that the solution took.
    nodes : int
        Nodes of the widest lattice; 0 where none was needed.
    success : bool
        Whether force_error is at or below the tolerance asked for.
    message : str
        In words: what was reached, or why not; what was cut off from the start.
    """

    path: Array
    force: Array
    force_error: float
    holding: Array
    run_time: float
    nodes: int
    success: bool
    message: str
    _problem: Problem = field(repr=False)
    _later: LaterReleased | None = field(repr=False)

    __repr__ = brief

    def distribution(self, position: float) -> StretchDistribution:
        """Q(x;X) at X = position, between 0 and the path's end; InputError elsewhere."""
        problem, end, position = self._problem, float(self.path[-1]), finite("position", position)
        settled = problem.end * problem.unit
        if settled < position <= end:  # beyond where contacts have forgotten their start nothing changes
            position = settled
        return distribution_at(problem, self._later, position, end)
