"""Births of earlier legs: their contributions to number and force on a later one.

Where the life is not quick, every value of a survival costs microseconds. So the survival, as a
function of the birth, is represented by polynomials on wide pieces that end where it bends, whatever
the panels of the breaks are. Consecutive legs in one direction share pieces: as a function of the
place of birth the survival is nearly smooth where the speed changed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births, Panels
from master.renewal.table import basis_of

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Gauss nodes of a piece; fewer where pieces end wherever the speed changed, as they do when there are
# at least MANY_LEGS legs, shorter than the share SHORT of the life's grain.
SIZE, SIZE_OF_MANY, MANY_LEGS, SHORT = 16, 4, 8, 0.1
# Most halvings of a piece; rounding of times ends them before.
DEPTH = 60
# Two places nearer than this share of the whole range count as equal.
CLOSE = 1e-13
# Relative rounding of a place.
ROUNDING = 1e-14
# Most pairs of pieces and panels that are summed at once: some 100 MB of arrays.
CHUNK = 100_000

# Where the survival jumps at exact thresholds, it is evaluated this share of a piece inside its ends;
# else at the ends themselves, where a life shorter than the piece shows.
_INSIDE = 1e-9
# Allowed error of a polynomial at the ends of a piece, in units of its accuracy: beside a root of the
# survival the error is larger there than in between.
_END = 100.0


class _Pieces(NamedTuple):
    """Pieces of the places of birth, as seen from targets; arrays of shape (pieces,)."""

    target: Rows
    left: Array
    right: Array

    def pick(self, which: npt.NDArray[np.bool_] | slice) -> _Pieces:
        return _Pieces(self.target[which], self.left[which], self.right[which])

    def cut(self, knots: Array) -> _Pieces:
        """Each piece cut in two at the knot nearest to its middle, or at the middle if it has none."""
        at = 0.5 * (self.left + self.right)
        after = np.clip(np.searchsorted(knots, at), 1, knots.size - 1)
        before = knots[after - 1]
        knot = np.where(at - before < knots[after] - at, before, knots[after])
        small = CLOSE * (self.right - self.left)
        at = np.where((knot > self.left + small) & (knot < self.right - small), knot, at)
        return _Pieces(np.tile(self.target, 2), np.append(self.left, at), np.append(at, self.right))


class EarlierBirths:
    """Births of consecutive legs that go one way, or of one hold.

    The place of a birth is X, counted forward along the legs; in a hold it is the time.

    Parameters
    ----------
    births : Births
        Of all legs; its `work` is increased.
    accuracy : float
        Allowed error of the births' contribution to the number, and to the force over the reach.
    goes_on : callable
        Whether there is time left to halve pieces.

    Attributes
    ----------
    missed : float
        Error of the number from pieces that were not resolved when halving ended.
    """

    def __init__(
        self, births: Births, accuracy: float, goes_on: Callable[[], bool] = lambda: True
    ) -> None:
        self._births, self._accuracy = births, accuracy
        self._goes_on, self.missed = goes_on, 0.0
        self._legs: list[int] = []
        self._panels: list[Panels] = []

    def add(self, leg: int, panels: Panels) -> None:
        """Add the births on a leg; `since` of the panels is counted from the leg's beginning."""
        self._legs.append(leg)
        self._panels.append(panels)

    def follows(self, leg: int) -> bool:
        """Whether a leg directly follows these in the same direction."""
        speeds, last = self._births.motion.speeds, self._legs[-1]
        return bool(leg == last + 1 and speeds[leg] * speeds[last] > 0.0)

    @property
    def in_hold(self) -> bool:
        """Whether these are the births of a hold, which share one stretch."""
        return bool(self._births.motion.speeds[self._legs[-1]] == 0.0)

    @property
    def _many_short(self) -> bool:
        """Whether the speed changed so often that pieces between the changes are short."""
        short = np.median(np.diff(self._knots)) < SHORT * self._births.life.grain
        return len(self._legs) >= MANY_LEGS and bool(short)

    def seen_from(self, motion: Motion, negligible: float) -> bool:
        """Count times from now on as this motion does, in which a later leg begins at t = 0.

        Drops legs whose births contribute less than `negligible`. Returns whether any leg remains.
        """
        self._motion, births = motion, self._births
        now, legs = np.full(1, np.finfo(float).tiny), np.array(self._legs)
        speed = motion.speeds[legs]
        begin = motion.times[legs] + np.array([panels.since[0] for panels in self._panels])
        end = [panels.since[-1] + panels.width[-1] for panels in self._panels]
        last = motion.times[legs] + np.array(end)
        # the births whose largest |x| is the least
        middle = 0.5 * sum(part[0] for part in motion.extremes(now, legs)) + births.law.mean()
        way = np.where(speed == 0.0, 0.0, middle - motion.positions[legs])
        least = motion.times[legs] + way / np.where(speed == 0.0, 1.0, speed)
        least = np.clip(least, begin, last)
        s = np.stack([begin, least, 0.5 * (least + last), last], axis=1).reshape(-1, 1)
        history = motion.history(np.broadcast_to(now, s.shape), s)
        most = np.array([np.abs(panels.breaks).max(axis=1).sum() for panels in self._panels])
        left = births.life.left(births.law, history)[0].reshape(-1, 4).max(axis=1) * most
        felt = np.flatnonzero(left > negligible)
        if not felt.size:
            return False
        self._legs, self._panels = self._legs[felt[0] :], self._panels[felt[0] :]
        self._place()
        return True

    def _place(self) -> None:
        """Join the panels of all legs into one sequence in the place of birth."""
        motion, legs = self._motion, np.array(self._legs)
        counts = [panels.width.size for panels in self._panels]
        of_leg = np.repeat(legs, counts)
        begin = np.concatenate([panels.since for panels in self._panels])
        width = np.concatenate([panels.width for panels in self._panels])
        breaks = np.concatenate([panels.breaks for panels in self._panels])
        self._speed = float(motion.speeds[legs[-1]])
        self._knots_t = np.append(motion.times[legs], motion.times[legs[-1] + 1])
        self._knots = self._knots_t
        if self._speed:
            sign = np.sign(self._speed)
            places = np.append(motion.positions[legs], motion.positions[legs[-1] + 1])
            speeds = np.abs(motion.speeds[of_leg])
            self._knots = sign * places
            begin = sign * motion.positions[of_leg] + speeds * begin
            width = speeds * width
        else:
            begin = motion.times[of_leg] + begin
        self._ends = np.append(begin, begin[-1] + width[-1])
        self._slopes = breaks @ rule.SLOPES.T
        self._most = np.append(0.0, np.cumsum(np.abs(breaks).max(axis=1)))

    def sums(self, t: Array) -> Array:
        """Number and force at times t, shape (n,), all on the later leg; shape (2, n)."""
        out, births = np.zeros((2, t.size)), self._births
        pieces = self._cut(t)
        basis = basis_of(SIZE_OF_MANY if self._many_short else SIZE)
        inside = _INSIDE if births.life.atoms.size else 0.0
        shares = np.concatenate([[inside], basis.nodes, [1.0 - inside]])
        for halving in range(DEPTH):
            if not pieces.left.size:
                break
            place = pieces.left[:, None] + (pieces.right - pieces.left)[:, None] * shares
            s = np.interp(place, self._knots, self._knots_t) if self._speed else place
            births.work += births.dear * s.size
            at = np.repeat(t[pieces.target], shares.size)[:, None]
            history = self._motion.history(at, s.reshape(-1, 1))
            found = births.life.left(births.law, history).reshape(2, *s.shape)
            series = found[..., 1:-1] @ basis.to_legendre
            missed = np.abs(series[0] @ basis.at_ends - found[0][:, [0, -1]]).max(axis=-1)
            rough = self._rough(pieces, missed / _END, series)
            if halving == DEPTH - 1 or not self._goes_on():
                rough[:] = False
            done = pieces.pick(~rough)
            given = self._ends, self._slopes, done.left, done.right, basis.nodes.size
            added = (series[:, ~rough] * moments(*given)).sum(axis=-1)
            for kind in (0, 1):
                out[kind] += np.bincount(done.target, added[kind], t.size)
            pieces = pieces.pick(rough).cut(self._knots)
        return out

    def _rough(self, pieces: _Pieces, missed: Array, series: Array) -> npt.NDArray[np.bool_]:
        """Pieces whose polynomials miss the survival by more than the accuracy, times the births."""
        first = np.searchsorted(self._ends, pieces.left, "right") - 1
        last = np.searchsorted(self._ends, pieces.right, "left")
        last = np.clip(last, 0, self._most.size - 1)
        born = self._most[last] - self._most[np.clip(first, 0, last)]
        tail = np.abs(series[..., -2:]).max(axis=-1)
        wrong = np.maximum(np.maximum(tail[0], tail[1] / self._births.life.reach), missed)
        wide = pieces.right - pieces.left > CLOSE * (self._ends[-1] - self._ends[0])
        wide &= pieces.right - pieces.left > ROUNDING * np.abs(pieces.right)
        rough = wrong * born > self._accuracy
        if rough.any() and not self._goes_on():
            self.missed = max(self.missed, float((wrong * born)[rough].sum()))
        return np.asarray(rough & wide)

    def _cut(self, t: Array) -> _Pieces:
        """Pieces of the births, for each target, with ends where the survival bends."""
        motion, law = self._motion, self._births.law
        first, last = self._ends[0], self._ends[-1]
        cuts = np.full((t.size, 0), first)
        if self._speed and law.is_single:
            r = law.mean()
            high, low = motion.extremes(t, np.array(self._legs[-1:]))
            marks, now = self._births.life.bends, motion.at(t)[:, None]
            goals = [high + r - marks, low + r + marks, 0.5 * (high + low) + r]
            goals += [now + r, high + r, low + r]
            cuts = np.sign(self._speed) * np.concatenate(goals, axis=1)
        fixed = np.array([first, last])
        if self._many_short:
            fixed = np.concatenate([fixed, self._knots])
        edges = np.concatenate([np.tile(fixed, (t.size, 1)), cuts], axis=1)
        edges = np.sort(np.clip(edges, first, last), axis=1)
        target, piece = np.nonzero(np.diff(edges, axis=1) > CLOSE * (last - first))
        return _Pieces(target, edges[target, piece], edges[target, piece + 1])


def moments(ends: Array, slopes: Array, left: Array, right: Array, size: int) -> Array:
    """Births on pieces, weighted by each piece's own Legendre polynomials: shape (pieces, size).

    ends : array of shape (panels + 1,), ends of the panels, as places
    slopes : array of shape (panels, DEGREE + 1), Legendre coefficients of the breaks' derivative
    left, right : arrays of shape (pieces,), places
    """
    first = np.clip(np.searchsorted(ends, left, "right") - 1, 0, None)
    last = np.minimum(np.searchsorted(ends, right, "left"), ends.size - 1)
    count = np.maximum(last - first, 0)
    if count.sum() > CHUNK and count.size > 1:
        half = count.size // 2
        parts = (slice(None, half), slice(half, None))
        return np.concatenate([moments(ends, slopes, left[i], right[i], size) for i in parts])
    piece = np.repeat(np.arange(count.size), count)
    panel = np.arange(piece.size) - np.repeat(np.cumsum(count) - count, count) + first[piece]
    begin, width = ends[panel], np.diff(ends)[panel]
    low = np.clip((left[piece] - begin) / width, 0.0, 1.0)[:, None]
    high = np.clip((right[piece] - begin) / width, 0.0, 1.0)[:, None]
    share = low + (high - low) * rule.GAUSS_NODES
    born = rule.legendre_sum(slopes[panel], 2.0 * share - 1.0) * (high - low) * rule.GAUSS_WEIGHTS
    place = begin[:, None] + width[:, None] * share
    z = (2.0 * place - (left + right)[piece, None]) / (right - left)[piece, None]
    basis = legendre.legvander(np.clip(z, -1.0, 1.0), size - 1)
    out = np.zeros((count.size, size))
    np.add.at(out, piece, (born[:, None] @ basis)[:, 0])
    return out
