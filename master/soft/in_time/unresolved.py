"""Unresolved: errors of F that halving the steps may not show, by their kind, and when each was largest.

Changes of the answers from one halving to the next tell the error of steps where it falls with them
(answer/extrapolation.py). What is noted here may be the same, or none, in all three solutions that are compared.
"""

from typing import NamedTuple

import numpy as np

from origins.thresholds.law import Array

# The kinds of such errors, in the words of messages. The births of one step are counted in two cohorts, at its begin
# and at its end.
OF_BIRTHS = "births of one step, of which many break before its end"
OF_SMALL_SLIPS = "slips that are too small to be listed"
OF_BALANCE = "steps at whose ends the forces do not balance"
OF_STEADY_SLIP = "the rest of a long slip, on which F is taken as steady"
OF_DELAY = "a step up to a slip, which is longer than the delay of contacts that break on it"
OF_BEND = "a step or two from where the drive changes its speed to a slip, between whose ends F is not known"
OF_CREEP = "steady creep, at whose begin F was not that of steady sliding at the slider's speed"
OF_QUIET = "inertia of a slider that hardly swings, which is left out"
OF_FLIGHT = "contacts that come back while the slider flies on its spring alone, which are taken to break at once"
OF_RINGING = (
    "contacts that break while the slider swings on those that hold, which are taken to hold"
)
OF_LONG_SLIP = "a long slip, on which F is taken as that of steady sliding at the slider's speed"
# Ratio of the survivals of a step's first and last births below which it is unknown how many in between hold.
UNKNOWN_BELOW = 0.5


class Largest(NamedTuple):
    """An error of F (a length) that was the largest of its kind, and when it was noted (a time on the path)."""

    error: float
    time: float


class Unresolved:
    """The largest error of each kind so far.

    largest : by the kind, one of the constants OF_... above
    """

    def __init__(self) -> None:
        self.largest = dict[str, Largest]()

    def note(self, of: str, error: float, now: float) -> None:
        """An error of F of this kind (a length), which is kept if it is the largest of them."""
        if error > self.error_of(of):
            self.largest[of] = Largest(error, now)

    def error_of(self, of: str) -> float:
        """The largest error of this kind (a length), 0 if none was noted."""
        return self.largest[of].error if of in self.largest else 0.0


def unknown_force_of_births(weight: Array, survival_and_force: Array, count: int) -> float:
    """Bound on the force (a length) of contacts born in steps of which it is unknown how many hold: half of what the
    forces of first and last births differ by, for the geometric mean of the births in both cohorts.

    weight, survival_and_force : of the groups of all cohorts, `count` each, in the order of birth; shape (n,), and
        (2, n) as a memory tells them

    Half of the births count as the first, half as the last. If the force changes one way from first to last, the
    mean over the step lies between the two, and so is off by half of their difference at most.
    """
    survival, force = survival_and_force
    born = np.abs(weight)
    is_unknown = survival[:-count] < UNKNOWN_BELOW * survival[count:]
    differ = 0.5 * np.abs(force[count:] - force[:-count])
    unknown = np.where(is_unknown, differ * np.sqrt(born[count:] * born[:-count]), 0.0)
    return float(unknown.sum())
