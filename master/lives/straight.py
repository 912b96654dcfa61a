"""Survival of contacts that have moved straight, at one speed, since their birth, in one table."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import NONE_LEFT
from master.lives.life import Life
from master.motion.motion import History, Motion
from master.renewal.table import Table
from origins.start import Start

Array = npt.NDArray[np.float64]

# Error of the survival, and of the force over the reach, to which the table is refined.
ACCURACY = 1e-13
# Relative distance within which a time counts as that at which an exact threshold is reached.
_TIE = 1e-11


class StraightLife(Life):
    """A Life, tabulated over the time since birth, of contacts born on the present leg.

    While the slider keeps its speed, the survival depends only on the time since birth. A table of it
    takes some hundred evaluations, where number conservation needs many thousand.

    Parameters
    ----------
    life : Life
    born : Start
        The stretches at birth; `left` may be called for these only.
    speed : float
        dX/dt of the leg.
    longest : float
        The longest time since birth: that of the leg, or one after which no contact holds.
    accuracy : float
        Of the share that holds, and of the force over the reach.

    Attributes as in Life, and

    asked : float
        The longest time as given.
    longest, reach : float
        The same, or an earlier time after which heat has broken all contacts.
    """

    def __init__(
        self, life: Life, born: Start, speed: float, longest: float, accuracy: float = ACCURACY
    ) -> None:
        self.life, self.atoms, self.grain, self.quick = life, life.atoms, life.grain, True
        motion = Motion(np.array([0.0, longest]), np.array([0.0, longest * speed]))
        scale = np.array([1.0, 1.0 / life.reach])[:, None, None]

        def found(lag: Array) -> Array:
            return life.left(born, motion.history(lag, np.zeros((1, 1)))) * scale

        self.asked, ladder = longest, np.empty(0)
        if not life.quick:
            # halvings of the longest time resolve lives that are much shorter
            ladder = longest * 0.5 ** np.arange(64.0, -1.0, -1.0)
            left = found(ladder[:, None])[0, :, 0]
            ladder, left = ladder[1.0 - left > accuracy], left[1.0 - left > accuracy]
            dead = np.flatnonzero(left < NONE_LEFT)
            if dead.size:
                longest, ladder = float(ladder[dead[0]]), ladder[: dead[0]]
        self.longest = self.reach = longest
        moving = bends_of(life, born, speed)
        # at the longest time an exact threshold may break all remaining contacts
        self.bends: Array = np.append(moving[moving < longest * (1.0 - _TIE)], longest)
        edges = np.unique(np.concatenate([[0.0], self.bends, ladder, [longest]]))
        # with heat lives may be far shorter than the table, and have roots at their beginning, near
        # which polynomials are less accurate than inside
        narrow, ends = (1e-12, 0.0) if life.quick else (1e-20, 100.0)
        self.table = Table(found, edges, accuracy, narrow * longest, ends=ends)
        self.error = life.error + self.table.error
        ways = bends_of(life, born, speed, life.atoms) if self.atoms.size else np.empty(0)
        self._jumps = ways[ways < longest]

    def marks(self, width: float) -> Array:
        """Times since birth between which the table is smooth enough for panels of a width."""
        return np.union1d(self.bends, self.table.fine(width))

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life; born is the law that the table was made for, and the history is along `clock`."""
        lag, last = history.now, self.table.end[-1]
        if not self.life.quick:  # the longest time, at which a leg may end, belongs to the table
            lag = np.where(
                lag <= last * (1.0 + _TIE), np.minimum(lag, np.nextafter(last, 0.0)), lag
            )
        for jump in self._jumps:
            middle = lag[:, lag.shape[1] // 2, None]
            beside = np.nextafter(jump, np.where(middle < jump, 0.0, np.inf))
            lag = np.where(np.abs(lag - jump) <= _TIE * (jump + history.t), beside, lag)
        # a time since birth may be rounded below 0, where a narrow first panel extrapolates wildly
        found = self.table(np.maximum(lag, 0.0))
        found[1] *= self.life.reach
        return found


def bends_of(life: Life, born: Start, speed: float, marks: Array | None = None) -> Array:
    """Times since birth at which the survival has a bend; sorted, none where the slider rests.

    marks : lengths |x| of the bends; None: all bends of the life, and its reach
    """
    marks = np.append(life.bends, life.reach) if marks is None else marks
    first, last = sorted(np.sign(speed) * np.array(born.span))
    ends = {first, last, *(np.sign(speed) * born.breakpoints)}
    # a contact born at r < 0 comes back to its largest |x| after a way of -2 r
    ways = [mark - end for mark in marks for end in ends]
    ways += [-2.0 * end for end in ends]
    return np.unique([way / abs(speed) for way in ways if way > 0.0 and speed])


def clock(duration: float) -> Motion:
    """The motion along which a StraightLife is read: its way is the time since birth."""
    return Motion(np.array([0.0, duration]), np.array([0.0, duration]))
