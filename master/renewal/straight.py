"""Straight: contacts that have moved at one speed since their birth, so that only the lag since then counts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.lives.life import NONE_LEFT, Life
from master.motion.motion import Motion
from master.renewal.table import Table, beside
from origins.errors import refuse
from origins.start import Start

Array = npt.NDArray[np.float64]

# Width of the narrowest panel, in units of the typical lag from a birth to the break.
SHORTEST = 1e-13
# Allowed error of a panel's polynomial at its ends, in units of the accuracy: beside a root of the
# survival it is larger there than inside.
ENDS = 10.0
# Ratio of the lags at which the survival is sampled to find where contacts break; and how many lags
# are sampled together, from the longest down.
RATIO, TOGETHER = 4.0, 6
# Shares of contacts: UNBROKEN broken ones count as none; NONE is negligible in integrals.
UNBROKEN, NONE = 1e-3, 1e-17


class Straight:
    """E and K over the lag since birth: a time, or the slider's way.

    Parameters
    ----------
    life, born : Life, Start
        Theirs, and the stretches at which they are born.
    speed : float
        dX/dt, of either sign, or 0.
    longest : float
        The longest lag.
    accuracy : float
        Last coefficients of E, and of K over `scale`, below which a panel of the table is not halved;
        0: no table, for lives that are as quick.
    steady : bool
        Whether lags are ways instead of times, and followed beyond the longest until hardly any
        contact holds.

    Attributes
    ----------
    longest : float
        The longest lag, or an earlier one after which no contact holds.
    edges : array of shape (n,)
        Lags between which E and K are polynomials, or nearly so.
    table : Table or None
        E and K/`scale` over the lag.
    typical : float
        The lag after which about half of the contacts have broken.
    scale : float
        A length: of the stretches at a break.
    error : float
        Of the share that holds, as the table gives it; in addition to the life's own error.

    Raises InputError where contacts break within lags that underflow.
    """

    table: Table

    def __init__(
        self,
        life: Life,
        born: Start,
        speed: float,
        longest: float,
        accuracy: float,
        steady: bool = False,
    ) -> None:
        """Find the lags between which E and K are smooth, and tabulate both."""
        self.life, self.born, self.longest, self.error = life, born, longest, 0.0
        self._speed, self._per_time = speed, speed if steady else 1.0
        bends = self._bends(np.append(life.bends, life.reach))
        self._read: Callable[[Array], Array] = self.scaled
        if not accuracy:
            self.scale = life.reach
            self._bounds = _edges(longest, bends)
            self.edges = np.union1d(self._bounds, _edges(longest, self._bends(life.marks)))
            return
        lags, held = self._ladder(longest, steady)
        self.longest = float(lags[-1])
        self.typical = float(lags[np.flatnonzero(held > 0.5 * held.max())[-1]])
        way = self.typical * abs(speed) / self._per_time
        self.scale = max(way, *(abs(end) for end in born.span)) or life.reach
        first = max(int(np.argmax(held < 1.0 - UNBROKEN)) - 1, 0)
        self._bounds = _edges(self.longest, bends)
        edges = _edges(self.longest, np.append(lags[first:], bends))
        shortest = SHORTEST * min(self.typical, float(edges[1]))
        self.table = Table(self.scaled, edges, accuracy, shortest, ends=ENDS)
        self._read = self.table
        self.edges, self.error = self.table.edges, self.table.error

    def left(self, lag: Array) -> Array:
        """E and K after lags of shape (rows, columns), from the life itself; shape (2, *lag.shape)."""
        if not lag.size:
            return np.zeros((2, *lag.shape))
        far = max(float(lag.max()), self.longest) / self._per_time
        motion = Motion(np.array([0.0, far]), np.array([0.0, far * self._speed]))
        return self.life.left(self.born, motion.history(lag / self._per_time, np.zeros((1, 1))))

    def scaled(self, lag: Array) -> Array:
        """E and K over `scale` after lags of shape (rows, columns), from the life itself."""
        found = self.left(lag)
        found[1] /= self.scale
        return found

    def look_up(self, lag: Array) -> Array:
        """E and K after lags of shape (rows, columns), from the table if there is one.

        The middle column decides on which side of an exact threshold a row is.
        """
        found = self._read(beside(lag, self._bounds))
        found[1] *= self.scale
        return found

    def _bends(self, marks: Array) -> Array:
        """Lags at which contacts reach the lengths |x| of the marks; none where the slider rests."""
        sign, speed, born = np.sign(self._speed), abs(self._speed), self.born
        ends = np.unique(sign * np.array([*born.span, *born.breakpoints]))
        # a contact born at r < 0 comes back to its largest |x| after a way of -2 r
        ways = np.append(np.subtract.outer(marks, ends), -2.0 * ends)
        return np.unique(ways[ways > 0.0]) * (self._per_time / speed) if speed else np.empty(0)

    def _held(self, lag: Array) -> Array:
        """E after lags of shape (n,)."""
        return np.asarray(self.left(lag[:, None])[0, :, 0])

    def _ladder(self, longest: float, steady: bool) -> tuple[Array, Array]:
        """Lags from where nearly all contacts hold to where hardly any do, or to the longest; and E."""
        lags = np.array([longest])
        held = self._held(lags)
        while held[0] < 1.0 - UNBROKEN and lags[0] > NONE * float(held[1:] @ np.diff(lags)):
            if lags[0] < 1e-150 * longest:
                told = "contacts break before they have moved a length that is a number"
                refuse("velocity", abs(self._speed), f"{told}; slide faster")
            lower = lags[0] * RATIO ** -np.arange(TOGETHER, 0.0, -1.0)
            lags, held = np.append(lower, lags), np.append(self._held(lower), held)
        typical = lags[np.flatnonzero(held > 0.5 * held.max())[-1]]
        # not even the heaviest tail is followed beyond 1e120 times the reach
        while steady and held[-1] * (lags[-1] / typical) ** 2 > NONE and lags[-1] < 1e120 * longest:
            lags = np.append(lags, 2.0 * lags[-1])
            held = np.append(held, self._held(lags[-1:]))
        over = held < NONE_LEFT
        count = lags.size if steady or not over.any() else int(np.argmax(over)) + 1
        return lags[:count], held[:count]


def _edges(longest: float, lags: Array) -> Array:
    """Sorted edges from 0 to the longest lag, without those that are equal apart from rounding."""
    edges = np.unique(np.concatenate([[0.0], lags[(lags > 0.0) & (lags < longest)], [longest]]))
    return np.append(edges[:-1][np.diff(edges) > 1e-14 * edges[1:]], longest)
