"""Past: number and force, on the present leg, of the births on all legs before and of all lumps.

Lumps are contacts that are born together, the start among them (G_0 and M_0 of the equation).

Where the slider has turned round, rested or changed its speed since a birth, the survival depends on
the moves since. As a function of the place of birth it is nearly smooth where the speed changed, and
bends where the largest |x| of a contact changes sides or meets a bend of the law.

Times are counted from the beginning of the present leg, so that they keep their digits late on.
"""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master.lives.averages import Pieces
from master.motion.motion import History
from master.renewal import rule
from master.renewal.births import (
    CLOSE,
    MOST_WORK,
    TINY,
    Births,
    Lump,
    Panels,
    Rows,
    moments,
    pieces_between,
)
from master.renewal.table import basis_of

if TYPE_CHECKING:
    from master.renewal.strand_births import StrandBirths

Array = npt.NDArray[np.float64]

# Gauss nodes of a piece, and most halvings of it; rounding of times ends them before.
SIZE, DEPTH = 16, 60
# Allowed error of a polynomial at the ends of a piece, in units of its accuracy: beside a root of the
# survival the error is larger there than in between. (A life shorter than the piece shows there.)
END = 100.0
# The survival jumps at exact thresholds: it is evaluated this share of a piece inside its ends, and on
# panels that begin or end there, this share of the panel inside.
INSIDE = 1e-9


class Past:
    """Births on the legs before one leg of the motion.

    Parameters
    ----------
    births : Births
    until : float
        Reading of time.monotonic() after which no piece is halved.

    Attributes
    ----------
    leg, first : int
        The leg, and the first panel whose births are on the present leg.
    began : float
        When the leg begins.
    error : float
        Bound on the error of the number, the largest of all legs so far.
    """

    def __init__(self, births: Births, until: float) -> None:
        self._births, self._life, self._until = births, births.life, until
        # sums of survivals that take long to compute are less accurate
        self._accuracy = births.accuracy * (1.0 if births.life.quick else 30.0)
        # many legs may be dropped: each is this much smaller
        self._negligible = max(1e-3 * self._accuracy, 1e-18)
        self.leg, self.first, self.error = -1, 0, 0.0
        self._over: set[int] = set()  # legs of whose births hardly any hold
        self._strands: list[StrandBirths] = []
        self._first = self._last = np.empty(0, dtype=int)
        self._rested = False

    def enter(self, leg: int, panels: Panels) -> None:
        """Find the births on all legs before one, and count their times from its beginning."""
        whole, before, delay = self._births.motion, self.leg, self._births.delay
        self.leg, self.began = leg, float(whole.times[leg])
        self._motion = whole.counted_from(leg)
        born = panels.middle_of_births(delay)
        self.first = int(np.searchsorted(born, self.began))
        legs = whole.leg(born[: self.first])
        panels = Panels(*(part[: self.first] for part in panels))
        if delay > 0.0:
            since = np.maximum(panels.begin + delay - whole.times[legs], 0.0)
            panels = panels._replace(since=since)
        if self._life.has_strands:
            self._follow(range(max(before, 0), leg), panels, legs)
        else:
            self._place(panels, legs)

    def at(self, x: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force at times x, in rows, of births on the legs before, and of all lumps.

        Each row lies within one panel of the leg. Returns an array of shape (2, *x.shape).
        """
        return self.sums(x) + self._of_lumps(lumps, x)

    def _of_lumps(self, lumps: Sequence[Lump], grid: Array) -> Array:
        """Number and force of lumps at times of shape (rows, columns), (2, rows, columns).

        The middle column decides on which side of an exact threshold a row lies.
        """
        births, middle = self._births, grid[:, grid.shape[1] // 2]
        out, first = np.zeros((2, *grid.shape)), grid.min(keepdims=True)
        for lump in (lump for lump in lumps if lump.holds):
            s, (low, high) = np.full((1, 1), lump.time - self.began), lump.law.span
            if s < first:
                moved = self._motion.history(first, s)
                least = max(low + moved.high[0, 0], -(high + moved.low[0, 0]))
                lump.holds = bool(least <= self._life.reach)
            early = middle < s[0, 0]  # still out
            out[0, early] += lump.weight
            if lump.holds and not early.all():
                births.count(grid.shape[0])
                history = self._motion.history(grid[~early], s)
                out[:, ~early] += lump.weight * self._life.left(lump.law, history)
        return out

    def _follow(self, legs_before: range, panels: Panels, legs: Rows) -> None:
        """Make strands of the births on some legs, and follow all strands to the present leg."""
        from master.renewal.strand_births import StrandBirths

        for leg in legs_before:
            _, since, width, breaks = (part[legs == leg] for part in panels)
            if np.abs(breaks).max(axis=1).sum() > self._negligible:
                self._strands.append(StrandBirths(self._births, leg, since, width, breaks))
        alive = [each.seen_from(self._motion, self._negligible) for each in self._strands]
        self._strands = [each for each, holds in zip(self._strands, alive, strict=True) if holds]
        self.error = max(self.error, sum(each.missed for each in self._strands))

    def _place(self, panels: Panels, legs: Rows) -> None:
        """Give births their places: minus the way to the present leg, where a hold counts as a grain."""
        _, since, width, breaks = panels
        ways = np.abs(np.diff(self._motion.positions[: self.leg + 1]))
        ways = np.where(ways > 0.0, ways, self._life.grain)
        self._knots = -np.append(np.cumsum(ways[::-1])[::-1], 0.0)
        speeds = (ways / np.diff(self._motion.times[: self.leg + 1]))[legs]
        begin = self._knots[legs] + speeds * since
        self._ends = np.append(begin, begin[-1:] + speeds[-1:] * width[-1:])
        self._slopes = breaks @ rule.SLOPES.T
        self._most = np.append(0.0, np.cumsum(np.abs(self._slopes).sum(axis=1)))
        most = np.bincount(legs, np.abs(breaks).max(axis=1), self.leg)
        found = np.array([leg for leg in np.unique(legs) if leg not in self._over], dtype=int)
        self._first = self._last = found
        if found.size:
            felt = self._holding(found) * most[found] > self._negligible
            self._over.update(found[~felt].tolist())
            # runs of legs that go one way, or single holds
            found = found[felt]
            sign = np.sign(self._motion.speeds[found])
            apart = (np.diff(found) > 1) | (np.diff(sign) != 0.0) | (sign[1:] == 0.0)
            self._first = found[np.append(True, apart)[: found.size]]
            self._last = found[np.append(apart, True)[: found.size]]
            self._rested = bool((sign == 0.0).any())

    def _holding(self, legs: Rows) -> Array:
        """About the largest share of the contacts born anywhere on each leg that holds now."""
        motion, births = self._motion, self._births
        begin, end, speed = motion.times[legs], motion.times[legs + 1], motion.speeds[legs]
        # the births whose largest |x| is the least
        highest, lowest = motion.knots_between(self.leg, legs)
        way = (
            0.5 * (np.maximum(highest, 0.0) + np.minimum(lowest, 0.0))
            + births.law.mean()
            - motion.positions[legs]
        )
        least = begin + np.divide(way, speed, out=np.zeros(way.size), where=speed != 0.0)
        least = np.clip(least, begin, end)
        s = np.stack([begin, least, 0.5 * (least + end), end], axis=1).reshape(-1, 1)
        held = births.life.left(births.law, motion.history(np.full(s.shape, TINY), s))[0]
        return np.asarray(held.reshape(-1, 4).max(axis=1))

    def sums(self, grid: Array) -> Array:
        """Number and force at times, in rows, on the leg; shape (2, *grid.shape).

        Each row lies within one panel. The survival is a polynomial in the place of birth on pieces
        that are halved until it is.
        """
        t = grid
        if self._rested and self._life.atoms.size:
            # at an edge the births of a hold may meet an exact threshold, all at once
            first, last = (end(axis=1, keepdims=True) for end in (grid.min, grid.max))
            inside = INSIDE * (last - first)
            t = np.clip(grid, first + inside, last - inside)
        t = np.maximum(t, TINY).ravel()  # t = 0 itself would count as a moment of the leg before
        out = np.zeros((2, t.size))
        if self._strands:
            out = sum((each.sums(t) for each in self._strands), out)
        if not self._first.size:
            return out.reshape(2, *grid.shape)
        pieces, basis = self._pieces(t), basis_of(SIZE)
        narrow = CLOSE * (pieces.high.max(initial=0.0) - pieces.low.min(initial=0.0))
        # between exact thresholds a piece is looked at just inside its ends
        inside = INSIDE if self._life.atoms.size else 0.0
        shares = np.concatenate([[inside], basis.nodes, [1.0 - inside]])
        for _ in range(DEPTH):
            if not pieces.owner.size:
                break
            owner, low, high = pieces
            place = low[:, None] + (high - low)[:, None] * shares
            self._births.count(owner.size)
            held = self._life.left(self._births.law, self._history(t[owner], place))
            held = held.reshape(2, *place.shape)
            series = held[..., 1:-1] @ basis.to_legendre
            off = np.abs(series[0] @ basis.at_ends - held[0][:, [0, -1]]).max(axis=-1) / END
            tail = np.abs(series[..., -2:]).max(axis=-1)
            born = np.subtract(*(np.interp(end, self._ends, self._most) for end in (high, low)))
            wrong = born * np.maximum.reduce([tail[0], tail[1] / self._life.reach, off])
            rough = (wrong > self._accuracy) & (
                high - low > np.maximum(1e-14 * np.abs(high), narrow)
            )
            if self._births.work > MOST_WORK or clock.monotonic() > self._until:
                self.error = max(self.error, float(wrong[rough].sum()))
                rough[:] = False
            weights = moments(self._ends, self._slopes, low[~rough], high[~rough], SIZE)
            for sums, added in zip(out, (series[:, ~rough] * weights).sum(axis=-1), strict=True):
                sums += np.bincount(owner[~rough], added, t.size)
            pieces = _halves(pieces.pick(rough), self._knots)
        return out.reshape(2, *grid.shape)

    def _history(self, t: Array, place: Array) -> History:
        """Moves from births at places (n, columns) to times (n,), each by itself: a piece may hold
        births of several legs."""
        s = np.interp(place.ravel(), self._knots, self._motion.times[: self._knots.size])
        return self._motion.history(np.repeat(t, place.shape[1])[:, None], s[:, None])

    def _pieces(self, t: Array) -> Pieces:
        """Pieces of the births, for each target, with ends where the survival bends."""
        motion, law, life = self._motion, self._births.law, self._life
        first, last = np.clip(
            [self._knots[self._first], self._knots[self._last + 1]], self._ends[0], self._ends[-1]
        )[:, None, :, None]
        cuts = [np.broadcast_to(end, (t.size, *end.shape[1:])) for end in (first, last)]
        if law.is_single:
            r, now = law.mean(), motion.at(t)[:, None, None]
            tops, bottoms = motion.knots_between(self.leg, self._last)
            high, low = np.maximum(now, tops[:, None]), np.minimum(now, bottoms[:, None])
            marks = np.append(life.bends, [abs(r), life.reach])
            middle = 0.5 * (high + low) + r
            now = now + np.zeros_like(middle) + r
            goals = [high + r - marks, low + r + marks, middle, now, high + r, low + r]
            sign = np.sign(motion.speeds[self._last])[None, :, None]
            turned = motion.positions[self._last + 1][None, :, None]
            at = self._knots[self._last + 1][None, :, None]
            at = at + sign * (np.concatenate(goals, axis=2) - turned)
            cuts.append(np.where(sign == 0.0, last, np.clip(at, first, last)))
        pieces = pieces_between(np.concatenate(cuts, axis=2).reshape(t.size, -1))
        # gaps between runs are no pieces
        middle = 0.5 * (pieces.low + pieces.high)
        run = np.minimum(np.searchsorted(last.ravel(), middle), self._last.size - 1)
        pieces = pieces.pick(middle > first.ravel()[run])
        if not pieces.owner.size:
            return pieces
        shares = np.array([0.5]) if law.is_single else np.array([0.0, 0.5, 1.0])
        place = pieces.low[:, None] + (pieces.high - pieces.low)[:, None] * shares
        history, (lowest, highest) = self._history(t[pieces.owner], place), law.span
        high, low = (part.reshape(place.shape) for part in (history.high, history.low))
        least = np.maximum(lowest + high.min(axis=1), -(highest + low.max(axis=1)))
        return pieces.pick(least < life.reach)


def _halves(pieces: Pieces, knots: Array) -> Pieces:
    """Each cut in two at the knot nearest to its middle, or at the middle if none is inside."""
    owner, low, high = pieces
    middle, small = 0.5 * (low + high), CLOSE * (high - low)
    after = np.clip(np.searchsorted(knots, middle), 1, knots.size - 1)
    knot = np.where(2.0 * middle < knots[after - 1] + knots[after], knots[after - 1], knots[after])
    at = np.where((knot > low + small) & (knot < high - small), knot, middle)
    return Pieces(np.tile(owner, 2), np.append(low, at), np.append(at, high))
