"""The share that holds at step 0, read in each slider as long before or after its own slips.

Contacts break ever faster up to a slip, and form again as fast one delay later: near both the share that holds changes
by the root of the time that is left. A slip that is a little later in one slider than in the next moves all of that. At
one time the two then differ by far more than at one distance from the slip, and not in proportion to it, so that no
extrapolation finds the limit: of three slips on K = 1e-6 in heat, with a delay of 1e3, by 1e-3 where at one distance
they differed by 1e-5.

So each time is mapped on a slider's own time by straight lines between slips, and by a shift behind each slip until
births have repeated it. The limit is taken there. What the share changes by while the slip may be off is an error of
X_T at the slip, as for the force, and none of the share.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from master.soft.in_time.answer.reading import read_holding
from master.soft.in_time.slider import Slider
from origins.thresholds.law import Array

# Part of the last change that is left at step 0, see extrapolation.py.
REST_OF_CHANGE = 1.0 / 3.0
# Delays behind a slip, in which births jump and bend, and part of the way to the next slip that they take at most.
DELAYS, OF_GAP = 3.0, 0.5


class AlignedHolding(NamedTuple):
    """The share that holds at times (n,), and its changes as slips are where they are at step 0, (2, n)."""

    holding: Array
    changes: Array


def aligned_holding(sliders: list[Slider], slips: Array, times: Array) -> AlignedHolding | None:
    """Of three sliders whose slips that are compared begin at times of shape (3, m); None where their order is not
    theirs at step 0, or none slips."""
    last = sliders[-1]
    delay = last.contacts.delay
    if not (delay and slips.size) or last.motion is None:
        return None
    end = float(last.motion.times[-1])
    at_step_0 = slips[2] + REST_OF_CHANGE * (slips[2] - slips[1])
    knots = [_knots(row, end, DELAYS * delay, at_step_0) for row in (*slips, at_step_0)]
    if any((np.diff(each) <= 0.0).any() for each in knots):
        return None

    def at(which: int, on: Array) -> Array:
        own = np.interp(times, on, knots[which])
        return read_holding(sliders[which].sections, own, delay)

    coarse, middle, fine = (at(which, knots[-1]) for which in range(3))
    before, now = middle - coarse, fine - middle
    changes = np.abs([now, now + REST_OF_CHANGE * (now - before)])
    return AlignedHolding(fine + REST_OF_CHANGE * now, changes)


def _knots(slips: Array, end: float, shifted: float, at_step_0: Array) -> Array:
    """Times at which the pieces of a map of times end, of a slider with these slips: the path's begin and end, slips,
    and behind each the end of the shift, which is cut where the next slip, at step 0, leaves less room."""
    knots = [0.0]
    for slip, (now, after) in zip(slips, pairwise(np.append(at_step_0, end)), strict=True):
        knots += [float(slip), float(slip) + min(shifted, OF_GAP * float(after - now))]
    return np.array([*knots, end])
