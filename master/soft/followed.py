"""What is found for a soft slider as far as it was followed, with which error, and whether that is enough."""

from typing import NamedTuple

import numpy as np

from master.outcome import outcome, unconserved
from master.soft.slips import Slips
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array

# Error of the force, in mean thresholds, from which on its slips are no evidence.
UNRELIABLE = 0.1


class Followed(NamedTuple):
    """Results for a slider as far as it was followed; lengths, and `error` in mean thresholds.

    balance, nodes : see SoftSolution
    force, holding : arrays of shape (k,), at the first k points of the path
    error, holding_error : estimates from above, of force and load at slips, and of the share that holds
    stopped_because : why the path was not followed to its end, or steps were not halved further
    shares : array, the share of the contacts that break in each slip, nan where unknown; empty where none is known
    """

    balance: float
    force: Array
    holding: Array
    slips: Slips
    error: float
    nodes: int
    holding_error: float = 0.0
    stopped_because: str = ""
    shares: Array = np.empty(0)

    @property
    def largest_error(self) -> float:
        """The error by which the solution is judged."""
        return max(self.error, self.holding_error)

    def fault(self, tolerance: float) -> str:
        """The message of a number that is not conserved, else ""."""
        # an error estimate so large judges nothing: the tolerance does
        error = self.holding_error if self.holding_error < UNRELIABLE else 0.0
        return unconserved(self.holding, tolerance, error)

    def outcome(
        self, contacts: Contacts, drive: Drive, tolerance: float, place: str
    ) -> tuple[bool, str]:
        """Success and message; `place` is the symbol of the path's positions."""
        solved = self.force.size
        if fault := self.fault(tolerance):
            return False, fault
        if solved == drive.path.size:
            error = self.largest_error
            what = " of holding" if self.holding_error > self.error else ""
            above = f"error estimate {error:.1e}{what} is above the tolerance {tolerance:.1e}"
            reason = self.stopped_because or f"{above}; shorten the path or loosen the tolerance"
            return outcome(contacts, error, tolerance, reason, what)
        last = f"{place} = {drive.path[solved - 1]:.6g}" if solved else "the first point"
        return False, f"{self.stopped_because}: the path is cut at {last}"
