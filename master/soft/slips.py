"""What both solvers of soft sliders find: the record of all slips, and forces along the path."""

from dataclasses import dataclass
from typing import NamedTuple

from master.outcome import outcome
from origins import Contacts, Drive
from origins.brief import brief
from origins.thresholds.law import Array

MOST_SLIPS = 20_000  # as many take some 20 s at T = 0


@dataclass(frozen=True)
class Slips:
    """Slips in the order in which they happen; arrays of shape (n,).

    Attributes
    ----------
    drive : array
        X_T (lengths).
    before, after : array
        X at the beginning and at the end (lengths).
    force_before, force_after : array
        F/(N_c <k>) (lengths).
    drive_error : float
        Estimate from above of the error of `drive` (a length). The error of `before` is larger, as F + K X is
        flat where a slip begins.
    """

    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    drive_error: float

    __repr__ = brief

    @property
    def drop(self) -> Array:
        """Drop of the force (lengths), which is K times the slip of X."""
        return self.force_before - self.force_after

    @property
    def period(self) -> float | None:
        """Distance of X_T between the last two slips (a length), with an error of 2 `drive_error`.

        None for fewer than two slips.
        """
        return abs(float(self.drive[-1] - self.drive[-2])) if self.drive.size > 1 else None


class Followed(NamedTuple):
    """Results for a slider as far as it was followed; lengths, and `error` in mean thresholds.

    balance, nodes : see SoftSolution
    position, force, holding : arrays of shape (k,), at the first k points of the path
    error, holding_error : estimates from above, of force and load at slips, and of the share that holds
    stopped_because : why the path was not followed to its end, or steps were not halved further
    """

    balance: float
    position: Array
    force: Array
    holding: Array
    slips: Slips
    error: float
    nodes: int
    holding_error: float = 0.0
    stopped_because: str = ""

    @property
    def largest_error(self) -> float:
        """The error by which the solution is judged."""
        return max(self.error, self.holding_error)

    def outcome(
        self, contacts: Contacts, drive: Drive, tolerance: float, place: str
    ) -> tuple[bool, str]:
        """Success and message; `place` is the symbol of the path's positions."""
        solved = self.force.size
        if solved == drive.path.size:
            error = self.largest_error
            above = f"error estimate {error:.1e} is above the tolerance {tolerance:.1e}"
            reason = self.stopped_because or f"{above}; shorten the path or loosen the tolerance"
            return outcome(contacts, error, tolerance, reason)
        last = f"{place} = {drive.path[solved - 1]:.6g}" if solved else "the first point"
        return False, f"{self.stopped_because}: the path is cut at {last}"
