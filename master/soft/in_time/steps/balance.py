"""The balanced step: which part of a step's size is time, so that the forces balance at its end."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.soft.in_time.groups import Trial
from origins.thresholds.law import Array

# Factor on the next move of the secant method where the imbalance falls as the time grows; what no move exceeds.
LONGER_MOVE, LONGEST_MOVE = 4.0, 1e300
# Longest moves that measure the slope near the root, in accuracies of a balance: a ten-thousandth of a step, on which
# the imbalance is straight, and far above the rounding of both.
NEAR = 1e5
# Steps of the secant method after which a bracket is left to brentq, and most where there is none.
SOON, MOST_SECANTS = 12, 40


class TriedStep(NamedTuple):
    """A step of a chosen size, so much of it time, the rest travel.

    time_part : how much of its size is time, in time units, as it was tried: where the section ends before, the step
        is cut there, and its size, `Steps.size`, is less. Below 0, which no step takes, the step of no time is tried,
        and the imbalance is that of a straight line from there, of the slope that is guessed. So each search finds a
        root; one below 0 says that forces balance after no step of this size.
    trial : where it leads to
    imbalance : of the forces at its end, see Steps.imbalance (a length)
    """

    time_part: float
    trial: Trial
    imbalance: float


class Root(NamedTuple):
    """What a search for a balanced step found.

    step : the balanced step, or where it did not converge the last one tried
    slope : there, of the imbalance over the time units (a length), for the next guess
    converged : whether the step's forces balance; if not, SlipBegins counts its imbalance as an error of the force
    """

    step: TriedStep
    slope: float
    converged: bool

    @property
    def has_balance(self) -> bool:
        """Whether there is a balance after a step of this size; else a slip begins within it, or at once."""
        return self.step.time_part > 0.0


def before_exact(
    tried: Callable[[float], TriedStep], time_part: Array, accuracy: float
) -> TriedStep | None:
    """The step of one size to the last balance before exact thresholds break; None where there is none.

    With less time and more travel contacts pull more, until exact thresholds break and F falls. So at the first of
    these parts of its size that are time, from the latest on, at which they pull more than the spring, a balance lies
    between it and the one before; unless they do so at the latest, without travel: then that step is the last one."""
    for high, low in pairwise(time_part.tolist()):
        if tried(low).imbalance < 0.0:
            last = tried(high)
            if last.imbalance <= 0.0:
                return last
            return tried(float(brentq(lambda at: tried(at).imbalance, low, high, xtol=accuracy)))
    return None


def secant(
    tried: Callable[[float], TriedStep],
    first: TriedStep,
    slope: float,
    accuracy: float,
    small: float,
) -> Root:
    """The step at which the imbalance crosses 0, from below to above as the time grows, and the slope there.

    Both are found by the secant method from the `first` step and a guess of the slope. Where the imbalance is not
    `small`, the slope has to be measured near the step before that counts as converged: its guess is that of another
    step, after a slip off by orders of magnitude. Where the imbalance falls as the time grows, as just after a slip,
    moves become longer. A step that leaves the bracket of the root is replaced by bisection. A bracket in which the
    secant method is slow is left to brentq. Of MOST_SECANTS the last has not converged, nor has that before moves so
    long that no imbalance is known."""
    low, high, measured = -np.inf, np.inf, False
    last = step = first
    for count in range(MOST_SECANTS):
        at, value = step.time_part, step.imbalance
        if not abs(value) / LONGEST_MOVE <= abs(slope):  # nor is nan
            return Root(last, slope, converged=False)
        low, high = (at, high) if value < 0.0 else (low, at)
        move = -value / slope
        if abs(move) <= accuracy:
            if measured or abs(value) <= small:
                return Root(step, slope, converged=True)
            move = float(np.copysign(2.0 * accuracy, move))
        bracketed = np.isfinite(high - low)
        if bracketed and count >= SOON:
            given: dict[str, Any] = {"xtol": accuracy, "full_output": True, "disp": False}
            found, how = brentq(lambda at: tried(at).imbalance, low, high, **given)
            return Root(tried(float(found)), slope, converged=bool(how.converged))
        after = at + move
        if bracketed and not low < after < high:
            after = 0.5 * (low + high)
        # the move is below the last digit of the step, and no number lies in a closed bracket
        if after == at:
            closed = high - low <= 2.0 * np.spacing(abs(at))
            return Root(step, slope, converged=measured or bool(closed))
        last, step = step, tried(after)
        rise = (step.imbalance - value) / (after - at)
        slope = rise if rise > 0.0 else slope / LONGER_MOVE
        measured = rise > 0.0 and abs(after - at) <= NEAR * accuracy
    return Root(step, slope, converged=False)
