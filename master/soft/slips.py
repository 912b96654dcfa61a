"""Slips: where a slider begins to slip, where it stops, and the record of all slips."""

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
        Bound on the error of `drive` (a length). The error of `before` is larger, as F + K X is
        flat where a slip begins.
    """

    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    drive_error: float

    __repr__ = brief

    @classmethod
    def of(cls, rows: list[Array], drive_error: float) -> Slips:
        """The slips of these rows, shape (5,): X_T, X before and after, F before and after."""
        drive, before, after, above, below = np.array(rows).reshape(-1, 5).T
        return cls(drive, before, after, above, below, drive_error)

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
    over : why the solution ended, if before the path's end
    reason : the message if the error is above the tolerance
    """

    balance: float
    position: Array
    force: Array
    holding: Array
    slips: Slips
    error: float
    nodes: int
    over: str
    reason: str = ""


class LettingGo(NamedTuple):
    """The beginning of a slip on a move.

    curve : Curve
        The load, as far as it is solved.
    travel, level : float
        Travel and load at the slip; inf if there is none.
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
        """Error of the travel due to that of F' (a length)."""
        if self.dropped:
            return 0.0
        bend = float(self.curve.bend(np.array([self.travel]))[0])
        return self.curve.slope_error(self.travel) / bend

    @property
    def beside(self) -> float:
        """Distance after which the computed load surely falls; 0 where it drops at once."""
        # ten errors of the place suffice; and a slip is at least 1e-4 of the travel long
        return 0.0 if self.dropped else min(10.0 * self.misplaced, 1e-4 * self.curve.end)


def letting_go(pull: Pull, spring: float, after: float, target: float) -> LettingGo:
    """The first slip after a travel, if it begins before the load reaches the target."""
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
    """The load, and the travel at which a slip ends that begins after a travel with load `level`.

    beside : distance after which the computed load surely falls; 0 where it drops at once
    """
    travel = after
    while True:
        pull.reach(travel)
        curve = pull.curve(spring)
        y = curve.catches(after, level, beside)
        if np.isfinite(y):
            return curve, y
        travel = curve.end + pull.matter.life.grain
