"""Births of one leg that is over: what they add to number and force on a later leg.

Where the life is not quick, every value of a survival costs microseconds. So as a function of the
time of birth the survival is followed by polynomials on wide pieces, cut where it bends, whatever
the panels of the breaks are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Gauss nodes of a piece in the time of birth.
SIZE = 16
# Halvings of a piece: rounding of times ends it before.
DEPTH = 60
# Two times nearer than this share of their leg are one.
CLOSE = 1e-13
# Rounding of a time, relatively.
ROUNDING = 1e-14
# Pairs of pieces and panels that are summed at once: some 100 MB of arrays.
CHUNK = 100_000

_NODES, _ = legendre.leggauss(SIZE)
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(_NODES, SIZE - 1)).T
# The nodes and both ends of a piece, as shares of it: at an end a short life is seen.
_SHARES: Array = 0.5 * (1.0 + np.concatenate([[-1.0], _NODES, [1.0]]))
_AT_ENDS: Array = legendre.legvander(np.array([-1.0, 1.0]), SIZE - 1).T
# What a polynomial may miss at the ends of a piece, in units of its accuracy: beside a root of the
# survival it misses more there than in between.
_END = 100.0


class Panels(NamedTuple):
    """Solved panels, in the order of time.

    begin, since, width : arrays of shape (m,); begin is a time, since is counted from the beginning
        of a leg
    breaks : array of shape (m, DEGREE + 1), values at 0 and the nodes
    """

    begin: Array
    since: Array
    width: Array
    breaks: Array


class _Pieces(NamedTuple):
    """Pieces of the times of birth, as seen from targets; arrays of shape (pieces,)."""

    target: Rows
    left: Array
    right: Array

    def pick(self, which: npt.NDArray[np.bool_] | slice) -> _Pieces:
        return _Pieces(self.target[which], self.left[which], self.right[which])

    def halved(self) -> _Pieces:
        middle = 0.5 * (self.left + self.right)
        return _Pieces(
            np.tile(self.target, 2), np.append(self.left, middle), np.append(middle, self.right)
        )


class LegBirths:
    """The births of one leg that is over.

    Parameters
    ----------
    births : Births
        Of all legs; its work is counted on.
    leg : int
    panels : Panels
        Those whose births lie on the leg; `since` tells when, counted from its beginning.
    accuracy : float
        Of the number and, over the reach, the force that the births add.
    goes_on : callable
        Whether there is time for pieces to be halved.

    Attributes
    ----------
    missed : float
        What no polynomial followed when halving ended, of the number of contacts.
    """

    def __init__(
        self,
        births: Births,
        leg: int,
        panels: Panels,
        accuracy: float,
        goes_on: Callable[[], bool] = lambda: True,
    ) -> None:
        self._births, self._leg, self._accuracy = births, leg, accuracy
        self._goes_on, self.missed = goes_on, 0.0
        self._begin, self._width = panels.since, panels.width
        self._last = float(self._begin[-1] + self._width[-1])
        self._slopes = panels.breaks @ rule.SLOPES.T
        self._at_gauss = panels.breaks @ rule.SLOPES_AT_GAUSS.T
        most = np.abs(panels.breaks).max(axis=1)
        self._most = np.append(0.0, np.cumsum(most))
        self.seen_from(births.motion)

    def seen_from(self, motion: Motion) -> None:
        """Count times from now on as this motion does: from the beginning of a later leg."""
        self._motion, self._offset = motion, float(motion.times[self._leg])
        self._ends = np.append(self._begin, self._last) + self._offset

    def sums(self, t: Array) -> Array:
        """Number and force at times t, shape (n,), all on one later leg; shape (2, n)."""
        out, births = np.zeros((2, t.size)), self._births
        pieces = self._cut(t)
        for halving in range(DEPTH):
            if not pieces.left.size:
                break
            length = (pieces.right - pieces.left)[:, None]
            s = pieces.left[:, None] + length * _SHARES
            births.work += births.dear * s.size
            found = births.life.left(births.law, self._motion.history(t[pieces.target, None], s))
            series = found[..., 1:-1] @ _TO_LEGENDRE
            rough = self._rough(pieces, found[0], series)
            if halving == DEPTH - 1 or not self._goes_on():
                rough[:] = False
            self._add(out, pieces.pick(~rough), series[:, ~rough])
            pieces = pieces.pick(rough).halved()
        return out

    def _rough(self, pieces: _Pieces, held: Array, series: Array) -> npt.NDArray[np.bool_]:
        """Pieces on which no polynomial follows what is left, as far as births feel it."""
        first = np.searchsorted(self._ends, pieces.left, "right") - 1
        last = np.searchsorted(self._ends, pieces.right, "left")
        last = np.clip(last, 0, self._most.size - 1)
        born = self._most[last] - self._most[np.clip(first, 0, last)]
        tail = np.abs(series[..., -2:]).max(axis=-1)
        tail = np.maximum(tail[0], tail[1] / self._births.life.reach)
        missed = np.abs(series[0] @ _AT_ENDS - held[:, [0, -1]]).max(axis=-1)
        wrong = np.maximum(tail, missed / _END)
        wide = pieces.right - pieces.left > CLOSE * (self._ends[-1] - self._ends[0])
        wide &= pieces.right - pieces.left > ROUNDING * np.abs(pieces.right)
        rough = wrong * born > self._accuracy
        if rough.any() and not self._goes_on():
            self.missed = max(self.missed, float((wrong * born)[rough].sum()))
        return np.asarray(rough & wide)

    def _cut(self, t: Array) -> _Pieces:
        """The leg's births in pieces, for each target, between which what is left bends."""
        motion, leg, law = self._motion, self._leg, self._births.law
        r = law.mean() if law.is_single else 0.0
        high, low = motion.extremes(t, np.array([leg]))
        marks, now = self._births.life.bends, motion.at(t)[:, None]
        goals = [high + r - marks, low + r + marks, 0.5 * (high + low) + r, now + r, high + r]
        goal = np.concatenate([*goals, low + r], axis=1)
        speed, first, last = float(motion.speeds[leg]), self._ends[0], self._ends[-1]
        if speed and law.is_single:
            cuts = motion.times[leg] + (goal - motion.positions[leg]) / speed
        else:
            cuts = np.full((t.size, 0), first)
        edges = np.concatenate([np.full((t.size, 1), first), cuts, np.full((t.size, 1), last)], 1)
        edges = np.sort(np.clip(edges, first, last), axis=1)
        target, piece = np.nonzero(np.diff(edges, axis=1) > CLOSE * (last - first))
        return _Pieces(target, edges[target, piece], edges[target, piece + 1])

    def _add(self, out: Array, pieces: _Pieces, series: Array) -> None:
        """Add the sums over the panels that lie in resolved pieces, whole or in part."""
        first = np.clip(np.searchsorted(self._ends, pieces.left, "right") - 1, 0, None)
        last = np.minimum(np.searchsorted(self._ends, pieces.right, "left"), self._ends.size - 1)
        count = np.maximum(last - first, 0)
        ends, begin = np.cumsum(count), 0
        while begin < count.size:
            until = int(np.searchsorted(ends, (ends[begin - 1] if begin else 0) + CHUNK, "right"))
            some = slice(begin, max(until, begin + 1))
            self._add_some(out, pieces.pick(some), series[:, some], first[some], count[some])
            begin = some.stop

    def _add_some(
        self, out: Array, pieces: _Pieces, series: Array, first: Rows, count: Rows
    ) -> None:
        piece = np.repeat(np.arange(count.size), count)
        panel = np.arange(piece.size) - np.repeat(np.cumsum(count) - count, count) + first[piece]
        begin, width = self._ends[panel], self._width[panel]
        low = np.clip((pieces.left[piece] - begin) / width, 0.0, 1.0)
        high = np.clip((pieces.right[piece] - begin) / width, 0.0, 1.0)
        share = low[:, None] + (high - low)[:, None] * rule.GAUSS_NODES
        born = np.empty(share.shape)
        whole = (low == 0.0) & (high == 1.0)
        born[whole] = self._at_gauss[panel[whole]]
        cut = ~whole
        born[cut] = rule.legendre_sum(self._slopes[panel[cut]], 2.0 * share[cut] - 1.0)
        born *= (high - low)[:, None] * rule.GAUSS_WEIGHTS
        s = begin[:, None] + width[:, None] * share
        left, right = pieces.left[piece, None], pieces.right[piece, None]
        z = np.clip((2.0 * s - left - right) / (right - left), -1.0, 1.0)
        for kind in (0, 1):
            values = (rule.legendre_sum(series[kind][piece], z) * born).sum(axis=1)
            out[kind] += np.bincount(pieces.target[piece], values, out.shape[1])
