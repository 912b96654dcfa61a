"""X(t): the slider's motion as straight legs, and the displacements of a contact since its birth."""

from collections.abc import Iterator
from copy import copy
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.outcome import FaultError
from origins import Drive
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# By how much rounding may put an edge of panels beside the end of a leg: parts of the time to the next edge, and of the
# time on the path. Edges that are nearer than 1e-12 of the time are one (master/renewal/edges.py).
SAME_PLACE, ROUNDED_TIME = 1e-6, 1e-11


class Legs(NamedTuple):
    """The straight legs between the births of contacts and a later instant; those before a birth have no duration.

    displacement : array of shape (..., k + 1), the slider's displacement since the birth, at the
        beginning of the first leg and at the end of each
    duration : array of shape (..., k), the time that the contact spent on each leg
    speed : array of shape (k,), dX/dt on each leg, of either sign
    """

    displacement: Array
    duration: Array
    speed: Array


class Motion:
    """X(t), straight between knots; t is a time, or the distance travelled where contacts do not depend on time.

    times, positions : arrays of shape (n + 1,), knots of X(t); times increase. Knots at which the
        speed stays the same are dropped, and knots that share a time are merged
    speeds : array of shape (n,), dX/dt on each leg, 0 in a hold
    """

    def __init__(self, times: Array, positions: Array) -> None:
        """Through these knots, times in order; FaultError where all share one time."""
        later = np.append(True, np.diff(times) > 0.0)
        times, positions = times[later], positions[later]
        if times.size < 2:
            raise FaultError(
                f"all knots of a motion are at t = {times[0]:.6g}, a fault of the program"
            )
        # most motions have one leg, of which nothing can be dropped
        kept = _turns(times, positions) if times.size > 2 else slice(None)
        self.times: Array = times[kept]
        self.positions: Array = positions[kept]
        self.speeds: Array = np.diff(self.positions) / np.diff(self.times)

    @classmethod
    def along(cls, positions: Array) -> "Motion":
        """The motion through these positions from the first, t being the distance travelled."""
        return cls(np.append(0.0, np.cumsum(np.abs(np.diff(positions)))), positions)

    def counted_from(self, leg: int) -> "Motion":
        """The same motion, its times and positions counted from the beginning of a leg to keep their digits there."""
        other = copy(self)
        other.times = self.times - self.times[leg]
        other.positions = self.positions - self.positions[leg]
        return other

    @property
    def one_leg(self) -> bool:
        """Whether the slider keeps one speed throughout."""
        return self.speeds.size == 1

    def leg(self, t: Array | float) -> npt.NDArray[np.intp]:
        """Index of the leg on which t lies; a knot belongs to the leg that it ends."""
        return clipped(np.searchsorted(self.times, t) - 1, 0, self.speeds.size - 1)

    def legs_between(self, edges: Array, slack: float) -> npt.NDArray[np.intp]:
        """Index of the leg between each two of these sorted times. FaultError where that is on two legs, by more than
        the time `slack` and rounding: what breaks there would be counted as if the slider had not turned."""
        legs = self.leg(0.5 * (edges[:-1] + edges[1:]))
        rounding = slack + SAME_PLACE * np.diff(edges) + ROUNDED_TIME * np.abs(edges[1:])
        early, late = self.times[legs] - edges[:-1], edges[1:] - self.times[legs + 1]
        beyond = np.flatnonzero(np.maximum(early, late) > rounding)
        if beyond.size:
            one = int(beyond[0])
            raise FaultError(
                f"panels are on two legs: no edge is between t = {edges[one]:.9g} and {edges[one + 1]:.9g}, but leg "
                f"{legs[one]} (from 0) is from {self.times[legs[one]]:.9g} to {self.times[legs[one] + 1]:.9g}, a fault "
                "of the program"
            )
        return legs

    def leg_of_all(self, t: Array) -> int:
        """Index of the leg on which all t lie; the smallest t may be the leg's first knot."""
        return int(self.leg(0.5 * (float(t.min()) + float(t.max()))))

    def duration(self, length: float, leg: int) -> float:
        """The time that the slider takes for a length at its speed on this leg; inf in a hold."""
        speed = float(self.speeds[leg])
        return length / abs(speed) if speed else np.inf

    def at(self, t: Array) -> Array:
        """X(t), same shape as t."""
        return np.interp(t, self.times, self.positions)

    def knots_between(self, last: int, first: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """Highest and lowest knot between each leg `first` and the leg `last`; -inf and inf for none."""
        later = self.positions[last:0:-1]
        high = np.append(np.maximum.accumulate(later)[::-1], -np.inf)
        return high[first], np.append(np.minimum.accumulate(later)[::-1], np.inf)[first]

    def history(self, t: Array, s: Array) -> "History":
        """The displacements from s to t of contacts born at s; all t lie on one leg, and so do the s of a row."""
        return History(self, t, s)


def _turns(times: Array, positions: Array) -> npt.NDArray[np.intp]:
    """Indices of the first knot, of those at which the speed changes, and of the last."""
    steps = np.diff(times)
    speeds = np.diff(positions) / steps
    # speeds that differ by 1e-9 count as equal: quotients of positions and times are rounded, to 1e-13 where a path
    # has thousands of points; rounding of times and positions changes the speeds of short steps most, and of steps
    # late or far from 0
    late, far = times[1:], np.maximum(*np.abs([positions[1:], positions[:-1]]))
    rounded = 1e-9 + _rounded(late, steps) + _rounded(far, np.abs(np.diff(positions)))
    larger, rounding = (np.maximum(a[1:], a[:-1]) for a in (np.abs(speeds), rounded))
    turns = np.flatnonzero(np.abs(np.diff(speeds)) > rounding * larger) + 1
    return np.concatenate([[0], turns, [times.size - 1]])


def _rounded(ends: Array, steps: Array) -> Array:
    """By which part of itself each step (n,) between rounded numbers may be off, that of the larger one; 1/2 at most,
    as a hold is told from a move."""
    off = 4.0 * np.finfo(float).eps * ends
    return np.asarray(off / np.maximum(steps, 2.0 * off, out=np.ones(off.shape), where=off > 0.0))


def drive_motion(drive: Drive, balance: float) -> Motion | None:
    """X_T(t) of the drive of a spring that is balanced at t = 0; None where the path is the balance alone."""
    times = np.append(0.0, drive.arrival_times(balance))
    return Motion(times, np.append(balance, drive.path)) if times[-1] > 0.0 else None


def middle_of(rows: Array) -> Array:
    """The middle between the least and the largest of each row, shape (rows, 1). Where a row lies within one piece of a
    range, so does this, and well inside it: it tells on which side of the piece's ends the row is."""
    count, width = rows.shape
    if width == 1:
        return rows
    if count < width:
        return 0.5 * (rows.min(axis=1, keepdims=True) + rows.max(axis=1, keepdims=True))
    # along the short rows themselves numpy takes five times as long
    columns = np.ascontiguousarray(rows.T)
    return 0.5 * (columns.min(axis=0) + columns.max(axis=0))[:, None]


class History:
    """The slider's displacement X(t) - X(s) since contacts were born at s, and in between.

    Every row lies within one smooth piece, which ends where a contact's largest |x| meets an exact threshold, or where
    another leg begins. A row may begin or end just there, where rounding tells no side: `middle_of` tells it for all
    of the row. The caller has to see to that: a row that crosses such a point gives a wrong survival, which nothing
    here notices. So at a jump a row that ends there has the limit from the left, and one that begins there that from
    the right. In master/renewal the side is told by the middle in five places: of births and of times here, of lags in
    `Straight.look_up`, of times in `sums_of_lumps`, and of pieces' places for legs in `EarlierLegs`; and
    `Past._inside_panels` moves times off a jump that a hold would meet.

    t, s : instants and births, which broadcast to shape (rows, columns)
    now, high, low : arrays of shape (rows, columns), the displacement at t, its largest (at least 0)
        and its smallest (at most 0) value since s
    """

    def __init__(self, motion: Motion, t: Array, s: Array) -> None:
        """Find the moves between s and t."""
        self.motion, self.t, self.s = motion, t, s
        last = motion.leg_of_all(t)
        rows = np.broadcast_shapes(t.shape, s.shape)[0]
        first = np.broadcast_to(np.minimum(motion.leg(middle_of(s)), last)[:, 0], rows)
        self._first, self._last = int(first.min(initial=last)), last
        self.now: Array = motion.speeds[last] * (t - s)
        highest = lowest = self.now
        if self._first < last:
            # on one leg the difference of two positions far from 0 would lose digits
            at_birth, (highest, lowest) = motion.at(s), motion.knots_between(last, first)
            self.now = np.where(np.equal(first, last)[:, None], self.now, motion.at(t) - at_birth)
            highest, lowest = highest[:, None] - at_birth, lowest[:, None] - at_birth
        self.high = np.maximum(np.maximum(self.now, highest), 0.0)
        self.low = np.minimum(np.minimum(self.now, lowest), 0.0)

    @classmethod
    def straight(cls, moved: Array) -> "History":
        """Moves on one leg, of shape (n,), by so much either way; they have no times, which a timeless life does not
        ask for."""
        moves = cls.__new__(cls)
        moves.now, moves.high, moves.low = moved, np.maximum(moved, 0.0), np.minimum(moved, 0.0)
        return moves

    def pick(self, which: slice | npt.NDArray[np.intp]) -> "History":
        """Moves of n contacts: all arrays have the shape (n,); `which` counts row after row."""
        other, shape = copy(self), self.now.shape
        for name in ("t", "s", "now", "high", "low"):
            value = getattr(self, name)
            value = value if value.shape == shape else np.broadcast_to(value, shape)
            setattr(other, name, value.ravel()[which])
        return other

    def largest(self, born: Array) -> Array:
        """Largest |x| of contacts with these moves, born at stretches of the same shape."""
        return np.maximum(np.abs(born), np.maximum(born + self.high, -(born + self.low)))

    def by_birth(self) -> Iterator[tuple[npt.NDArray[np.intp], "History"]]:
        """Indices of some of the n contacts at a time, born at like times, so that `legs` has few, and their moves."""
        order, together = np.argsort(self.s), 1000  # their legs stay in the processor's cache
        for some in (order[begin : begin + together] for begin in range(0, order.size, together)):
            yield some, self.pick(some)

    def legs(self) -> Legs:
        """The moves leg by leg, for contacts whose rate of breaking depends on each."""
        first = int(np.clip(self.motion.leg(self.s.min(initial=np.inf)), self._first, self._last))
        motion, knots = self.motion, self.motion.times[first : self._last + 2]
        ends = np.clip(knots, self.s[..., None], np.maximum(self.t, self.s)[..., None])
        if first == self._last:
            # the difference of two positions far from 0 would lose digits
            displacement = np.stack([np.zeros_like(self.now), self.now], axis=-1)
        else:
            displacement = motion.at(ends) - motion.at(self.s)[..., None]
        return Legs(displacement, np.diff(ends, axis=-1), motion.speeds[first : self._last + 1])
