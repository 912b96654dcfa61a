"""What is found for a soft slider as far as it was followed, with which error, and whether that is enough."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from master.outcome import outcome, unconserved
from master.soft.slips import Slips
from master.soft.slips_ahead import SlipsAhead, nothing_ahead_known
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array

# Error of the force, in mean thresholds, from which on its slips are no evidence.
UNRELIABLE = 0.1
# What messages and the regime say then.
NOTHING_KNOWN = "neither force nor slips are known"
# What makes a part of the error smaller. A shorter path takes fewer steps, so that more halvings fit into the work.
SHORTEN = "shorten the path or loosen the tolerance"
LOOSEN = "loosen the tolerance"
LEAVE_OUT = "leave out the heat"
LEAVE_HEAT = f"{LEAVE_OUT} or {LOOSEN}"
ELSEWHERE = "put points of the path and its end farther from slips, or tighten the tolerance"
# An error of both solvers of sliders without steps in time.
OF_UNSURE_SLIP = "a slip that heat, which is left out, may take away or bring about"
GIVE_WIDTH = "give the exact thresholds a width, as in gaussian(mean, std)"


class ErrorPart(NamedTuple):
    """One part of the error of force and load at slips.

    of : its source, in words that follow "the error of"
    size : mean thresholds
    remedy : what the user may do to make it smaller
    """

    of: str
    size: float
    remedy: str = SHORTEN


def total(parts: Iterable[ErrorPart]) -> float:
    """The error that parts add up to, in mean thresholds."""
    return sum((part.size for part in parts), 0.0)


class Followed(NamedTuple):
    """Results for a slider as far as it was followed; lengths, and errors in mean thresholds.

    balance, nodes : see SoftSolution
    force, holding : arrays of shape (k,), at the first k points of the path
    error_of_force_and_load : estimate from above of the error of the force, but at points near slips of a slider with
        mass, and of K X_T at slips
    parts : at least one; that error is their sum, at T = 0 without mass the largest of them
    stopped_because : why the path was not followed to its end, or steps were not halved further
    beside_slips : what the error of the force may be larger at points of the path near slips of a slider with mass,
        whose times are not known so well
    of_holding : the error of the share that holds (its size is a share of the contacts), and its source
    note : what is to be said of how it was followed, "" where nothing is
    steady_from : X_T from which on F is within the tolerance of steady sliding's, where a slider creeps to the end of
        the path; None where it does not, or is not known to
    slips_ahead : finds the slips beyond the path's end
    fractions_broken : array, of the contacts in each slip, nan where unknown; empty where none is known
    """

    balance: float
    force: Array
    holding: Array
    slips: Slips
    error_of_force_and_load: float
    nodes: int
    parts: tuple[ErrorPart, ...]
    stopped_because: str = ""
    of_holding: ErrorPart = ErrorPart("the share that holds", 0.0)
    beside_slips: ErrorPart = ErrorPart("slips nearby", 0.0)
    fractions_broken: Array = np.empty(0)
    note: str = ""
    steady_from: float | None = None
    slips_ahead: Callable[[], SlipsAhead] = nothing_ahead_known

    @property
    def force_error(self) -> float:
        """Estimate from above of the error of the force at all points of the path."""
        return self.error_of_force_and_load + self.beside_slips.size

    @property
    def holding_error(self) -> float:
        """Estimate from above of the error of the share that holds."""
        return self.of_holding.size

    @property
    def largest_error(self) -> float:
        """The error by which the solution is judged."""
        return max(self.force_error, self.holding_error)

    @property
    def _whose(self) -> str:
        """The words that follow "error estimate" where the largest error is not the force's."""
        return " of holding" if self.holding_error > self.force_error else ""

    def why_above(self, tolerance: float) -> str:
        """Why the error is above the tolerance: its largest part, and what makes that smaller."""
        above = f"error estimate {self.largest_error:.1e}{self._whose} is above the tolerance {tolerance:.1e}"
        parts = (*self.parts, self.beside_slips)
        if self.holding_error > self.force_error:
            parts = (self.of_holding,)
        most = max(parts, key=lambda part: part.size)
        if np.isinf(most.size):
            return f"no error is known without that of {most.of}; {most.remedy}"
        why = f"{above}, most of it that of {most.of}; {most.remedy}"
        if self.force_error > tolerance:
            return why
        return f"{why}; the force is known to {self.force_error:.1e} mean thresholds"

    def fault(self, tolerance: float) -> str:
        """The message of a number that is not conserved, else ""."""
        if np.isinf(self.holding_error):
            # fewer than three halvings: steps longer than a delay tell too many births, as no error is known yet
            return ""
        # an error estimate so large judges nothing: the tolerance does
        error = self.holding_error if self.holding_error < UNRELIABLE else 0.0
        return unconserved(self.holding, tolerance, error)

    def outcome(
        self, contacts: Contacts, drive: Drive, tolerance: float, place: str
    ) -> tuple[bool, str]:
        """Success and message; `place` is the symbol of the path's positions."""
        solved = self.force.size
        unknown = "" if self.error_of_force_and_load < UNRELIABLE else f"{NOTHING_KNOWN}: "
        if fault := self.fault(tolerance):
            return False, fault
        if solved == drive.path.size:
            why = self.why_above(tolerance)
            reason = f"{self.stopped_because}; {why}" if self.stopped_because else why
            done = outcome(contacts, self.largest_error, tolerance, unknown + reason, self._whose)
            return done[0], f"{done[1]}; {self.note}" if self.note else done[1]
        last = f"{place} = {drive.path[solved - 1]:.6g}" if solved else "the first point"
        return False, f"{unknown}{self.stopped_because}: the path is cut at {last}"
