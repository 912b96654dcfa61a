"""Slips: where a slider lets go, where it is caught again, and what is told of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.soft.curve import Curve
from master.soft.pull import Pull
from origins.brief import brief

Array = npt.NDArray[np.float64]


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
        Bound on the error of `drive` (a length). X where a slip begins, where F + K X is flat, is
        not known as well.
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
        """How far the force falls (lengths), which is K times the slip."""
        return self.force_before - self.force_after

    @property
    def period(self) -> float | None:
        """X_T from the last slip but one to the last (a length), to twice `drive_error`.

        None for fewer than two.
        """
        return abs(float(self.drive[-1] - self.drive[-2])) if self.drive.size > 1 else None


class Followed(NamedTuple):
    """What was found of a slider as far as it was followed; lengths, and `error` in mean thresholds.

    balance, force_error, drive_error, nodes : see SoftSolution and Slips
    position, force, holding : arrays of shape (k,), at the first k points of the path
    slips : array of shape (5, m), X_T, X before and after, F before and after
    reason : why the error is no smaller
    over : what ended it, where that is before the path's end
    """

    balance: float
    position: Array
    force: Array
    holding: Array
    slips: Array
    drive_error: float
    error: float
    nodes: int
    reason: str
    over: str


class LettingGo(NamedTuple):
    """Where a slider lets go on a move.

    curve : Curve
        The load, as far as it is solved.
    travel, level : float
        Travel and load; inf where it does not let go.
    dropped : bool
        Whether contacts at one exact threshold break there.
    """

    curve: Curve
    travel: float = np.inf
    level: float = np.inf
    dropped: bool = False

    @property
    def slips(self) -> bool:
        return bool(np.isfinite(self.travel))

    @property
    def error(self) -> float:
        """Bound on the error of the level (a length)."""
        return float(self.curve.error[self.curve.panel(np.array([self.travel]))[0]])

    @property
    def misplaced(self) -> float:
        """How far off the travel may be, as far as F' is (a length)."""
        if self.dropped:
            return 0.0
        bend = float(self.curve.bend(np.array([self.travel]))[0])
        return self.curve.slope_error(self.travel) / bend

    @property
    def beside(self) -> float:
        """Travel beyond which the load is seen to fall; 0 where it falls at once."""
        # ten errors beyond a load that begins to fall is sure to be seen to fall, and a slip takes a
        # share of 1e-4 of the travel at least
        return 0.0 if self.dropped else min(10.0 * self.misplaced, 1e-4 * self.curve.end)


def letting_go(pull: Pull, spring: float, after: float, target: float) -> LettingGo:
    """Where the slider lets go first beyond a travel, before its load comes to the target."""
    travel = after
    while True:
        pull.reach(travel)
        curve = pull.curve(spring)
        y = curve.lets_go(after)
        last = min(y, curve.end)
        level = curve.force_at(last) + spring * last
        if level >= target:
            return LettingGo(curve)
        if np.isfinite(y):
            return LettingGo(curve, y, level, bool((curve.drops == y).any()))
        travel = curve.end + pull.matter.life.grain


def landing(
    pull: Pull, spring: float, after: float, level: float, beside: float
) -> tuple[Curve, float]:
    """The load, and the travel at which the slider is caught that let go of a level after a travel.

    beside : travel beyond which the load is seen to fall; 0 where it fell at once
    """
    travel = after
    while True:
        pull.reach(travel)
        curve = pull.curve(spring)
        y = curve.catches(after, level, beside)
        if np.isfinite(y):
            return curve, y
        travel = curve.end + pull.matter.life.grain
