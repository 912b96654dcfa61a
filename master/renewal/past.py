"""Past: what all that was born before the present leg adds to number and force on it.

Where the life is not quick, every value of a survival costs microseconds, and births of earlier legs
meet moments of the present one in pairs. Two things spare most of them. As a function of the birth
the survival is followed by polynomials on wide pieces, cut where it bends, whatever the panels of
the breaks are; as a function of the moment the sum over all births is kept in a table.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.table import Table
from origins.start import Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Gauss nodes of a piece in the time of birth.
SIZE = 12
# Halvings of a piece: rounding of times ends it before.
DEPTH = 60
# Two times nearer than this share of their leg are one.
CLOSE = 1e-13
# Share of a segment below which its table is not halved.
SHORTEST = 1e-14
# Share of each length of a ladder of the next one, and how often it may go down.
_RUNG, _MOST_RUNGS = 1.0 / 16.0, 20
# Pairs of pieces and panels that are summed at once: some 100 MB of arrays.
CHUNK = 100_000

_NODES, _ = legendre.leggauss(SIZE)
_TO_LEGENDRE: Array = np.linalg.inv(legendre.legvander(_NODES, SIZE - 1)).T
# The nodes and both ends of a piece, as shares of it: at an end a short life is seen.
_SHARES: Array = 0.5 * (1.0 + np.concatenate([[-1.0], _NODES, [1.0]]))
_AT_ENDS: Array = legendre.legvander(np.array([-1.0, 1.0]), SIZE - 1).T
# What a polynomial may miss at the ends of a piece, in units of its accuracy: beside a root of the
# survival it misses more there than in between.
_END = 100.0


@dataclass
class Lump:
    """Contacts that were born, or stood at t = 0, at one moment.

    time : of the birth; weight : share of all contacts; law : of the stretches at birth
    holds : whether any of them is left
    """

    time: float
    weight: float
    law: Start
    holds: bool = True


class Panels(NamedTuple):
    """Solved panels whose births lie on one leg, in the order of time.

    begin, width : arrays of shape (m,), of the births
    breaks : array of shape (m, DEGREE + 1), values at 0 and the nodes
    """

    begin: Array
    width: Array
    breaks: Array


class _Pieces(NamedTuple):
    """Pieces of the times of birth, as seen from targets; arrays of shape (pieces,)."""

    target: Rows
    left: Array
    right: Array

    def pick(self, which: npt.NDArray[np.bool_]) -> _Pieces:
        return _Pieces(self.target[which], self.left[which], self.right[which])

    def halved(self) -> _Pieces:
        middle = 0.5 * (self.left + self.right)
        return _Pieces(
            np.tile(self.target, 2), np.append(self.left, middle), np.append(middle, self.right)
        )


class LegBirths:
    """The births of one leg that is over, as seen later on.

    Parameters
    ----------
    accuracy : float
        Of the number and, over the reach, the force that the births add.
    """

    def __init__(
        self, life: Life, law: Start, motion: Motion, leg: int, panels: Panels, accuracy: float
    ) -> None:
        self._life, self._law, self._motion, self._leg = life, law, motion, leg
        self._panels, self._accuracy = panels, accuracy
        self._ends = np.append(panels.begin, panels.begin[-1] + panels.width[-1])
        most = np.abs(panels.breaks).max(axis=1)
        self._most = np.append(0.0, np.cumsum(most))
        self._slopes = panels.breaks @ rule.SLOPES.T
        self._at_gauss = panels.breaks @ rule.SLOPES_AT_GAUSS.T

    def sums(self, t: Array) -> Array:
        """Number and force at times t, shape (n,), all on one later leg; shape (2, n)."""
        out = np.zeros((2, t.size))
        pieces = self._cut(t)
        for halving in range(DEPTH):
            if not pieces.left.size:
                break
            length = (pieces.right - pieces.left)[:, None]
            s = pieces.left[:, None] + length * _SHARES
            found = self._life.left(self._law, self._motion.history(t[pieces.target, None], s))
            series = found[..., 1:-1] @ _TO_LEGENDRE
            rough = self._rough(pieces, found[0], series) & (halving < DEPTH - 1)
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
        tail = np.maximum(tail[0], tail[1] / self._life.reach)
        missed = np.abs(series[0] @ _AT_ENDS - held[:, [0, -1]]).max(axis=-1)
        wrong = np.maximum(tail, missed / _END)
        wide = pieces.right - pieces.left > CLOSE * (self._ends[-1] - self._ends[0])
        wide &= pieces.right - pieces.left > 1e-14 * pieces.right
        return np.asarray((wrong * born > self._accuracy) & wide)

    def _cut(self, t: Array) -> _Pieces:
        """The leg's births in pieces, for each target, between which what is left bends."""
        motion, life, leg = self._motion, self._life, self._leg
        r = self._law.mean() if self._law.is_single else 0.0
        high, low = motion.extremes(t, np.array([leg]))
        marks = life.bends
        now = motion.at(t)[:, None]
        goals = [high + r - marks, low + r + marks, 0.5 * (high + low) + r, now + r, high + r]
        goal = np.concatenate([*goals, low + r], axis=1)
        speed, first, last = float(motion.speeds[leg]), self._ends[0], self._ends[-1]
        if speed and self._law.is_single:
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
        ends = np.cumsum(count)
        begin = 0
        while begin < count.size:
            until = int(np.searchsorted(ends, (ends[begin - 1] if begin else 0) + CHUNK, "right"))
            some = slice(begin, max(until, begin + 1))
            part = _Pieces(*(array[some] for array in pieces))
            self._add_some(out, part, series[:, some], first[some], count[some])
            begin = some.stop

    def _add_some(
        self, out: Array, pieces: _Pieces, series: Array, first: Rows, count: Rows
    ) -> None:
        piece = np.repeat(np.arange(count.size), count)
        panel = np.arange(piece.size) - np.repeat(np.cumsum(count) - count, count) + first[piece]
        begin, width = self._panels.begin[panel], self._panels.width[panel]
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


class Past:
    """All that was born before the present leg, and all lumps: number and force on one segment.

    Parameters
    ----------
    life, law, motion, delay : as of births
    accuracy : float
        Of what is added to the number, and to the force over the reach.
    """

    def __init__(
        self, life: Life, law: Start, motion: Motion, delay: float, accuracy: float
    ) -> None:
        self._life, self._law, self._motion = life, law, motion
        self._delay, self._accuracy = delay, accuracy
        self._legs: list[LegBirths] = []
        self._known = 0  # legs whose births are in the list
        self._table: Table | None = None
        self.error = 0.0

    def close(self, leg: int, begin: Array, width: Array, breaks: Array) -> None:
        """Take over the births on all legs before this one, from all panels so far."""
        if not begin.size:
            return
        born = begin + self._delay
        on = self._motion.leg(born + 0.5 * width)
        for earlier in range(self._known, leg):
            own = np.flatnonzero(on == earlier)
            if own.size and np.abs(breaks[own]).max() > self._negligible:
                panels = Panels(born[own], width[own], breaks[own])
                given = self._life, self._law, self._motion, earlier, panels, self._accuracy
                self._legs.append(LegBirths(*given))
        self._known = leg

    @property
    def _negligible(self) -> float:
        """Contacts that a leg or a lump may have left to be let go: many such are felt."""
        return max(1e-3 * self._accuracy, 1e-18)

    def enter(self, leg: int, begin: float, end: float, lumps: list[Lump]) -> None:
        """Make the table for the segment from begin to end, times since the leg's beginning."""
        since = float(self._motion.times[leg])
        first = np.array([since + begin])
        self._legs = [
            births for births in self._legs if abs(births.sums(first)[0, 0]) > self._negligible
        ]
        holding = []
        for lump in lumps:
            if lump.holds and lump.time <= first[0]:
                held = self._of_lump(lump, first[None])[0].max()
                lump.holds = bool(held > 1e-18)
            if lump.holds:
                holding.append(lump)
        scale = np.array([1.0, 1.0 / self._life.reach])[:, None, None]

        def found(x: Array) -> Array:
            # the moment at which the leg begins would count as one of the leg before
            t = np.maximum(since + x, np.nextafter(since, np.inf))
            out = np.zeros((2, *t.shape))
            for lump in holding:
                if lump.time > since + 0.5 * (begin + end):
                    out[0] += lump.weight
                else:
                    out += self._of_lump(lump, t)
            for births in self._legs:
                out += births.sums(t.ravel()).reshape(out.shape)
            return out * scale

        self._begin, self._table = begin, None
        if holding or self._legs:
            edges = self._rungs(lambda x: float(found(np.array([[begin + x]]))[0, 0, 0]), end - begin)
            shortest = SHORTEST * edges[-1]
            self._table = Table(lambda x: found(begin + x), edges, self._accuracy, shortest, True)
            self.error = max(self.error, self._table.error)

    def _rungs(self, number: Callable[[float], float], length: float) -> Array:
        """Times since a segment's beginning, first 0, between which a table may look for its panels.

        They get denser towards 0 until half of all contacts hold, as nodes far apart see none of a
        short life, and end where next to none is left.
        """
        begin, rungs = number(0.0), [length]
        for _ in range(_MOST_RUNGS):
            left = number(rungs[0])
            if left < self._negligible:
                rungs = rungs[:1]
            elif left >= 0.5 * begin:
                break
            rungs.insert(0, _RUNG * rungs[0])
        return np.array([0.0, *rungs])

    def _of_lump(self, lump: Lump, t: Array) -> Array:
        history = self._motion.history(t, np.full((1, 1), lump.time))
        return lump.weight * self._life.left(lump.law, history)

    def at(self, x: Array) -> Array:
        """Number and force at times x since the leg's beginning, shape (2, *x.shape)."""
        if self._table is None:
            return np.zeros((2, *x.shape))
        x = x - self._begin
        last = self._table.end[-1]
        # the segment's end belongs to the table
        inside = np.where(x <= last * (1.0 + 1e-9), np.minimum(x, np.nextafter(last, 0.0)), x)
        found = self._table(x, np.maximum(inside, 0.0))
        found[1] *= self._life.reach
        return found
