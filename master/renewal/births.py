"""Births: what the births of a panel add to the contacts and to the force, later on.

A contact that breaks at s is out until s + delay, where it is born again at a stretch r. As long as
it is out it counts among the contacts, but bears nothing. So with E and K of its life the kernels of
number and force are

    number: 1 for t < s + delay, E(t, s + delay) after,      force: 0, then K(t, s + delay).

`blocks` integrates both against the derivatives of the polynomials that stand for the number of
breaks on each panel.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal import rule
from origins.start import Start

Array = npt.NDArray[np.float64]

# Two shares of a panel nearer than this are one: 1e-13 of a panel breaks next to nothing.
CLOSE = 1e-13
# Rounding of a time, relatively: where the survival is steep it is all that the nodes differ by.
ROUNDING = 8.0 * float(np.finfo(float).eps)
# Targets times panels that are integrated at once: some 100 MB of arrays.
CHUNK = 40_000
# What a survival averaged over the stretches at birth costs, in such from one stretch.
SPREAD_WORK = 40
# Pieces, as seen from later targets, that are integrated one by one before halving ends: some 30 s.
MOST_WORK = 15_000_000
# Halvings of a piece whose survival no polynomial follows.
DEPTH = 40


class Pieces(NamedTuple):
    """Pieces of panels, as seen from targets.

    target, panel : indices, shape (pieces,)
    share : where on the panel the Gauss nodes lie, shape (pieces, GAUSS)
    weights : kernels of number and force times the weights of the nodes, shape (2, pieces, GAUSS)
    whole : whether the piece is the whole panel, shape (pieces,)
    """

    target: npt.NDArray[np.intp]
    panel: npt.NDArray[np.intp]
    share: Array
    weights: Array
    whole: npt.NDArray[np.bool_]


def _share(t: Array, begin: Array | float, width: Array | float) -> Array:
    """Which share of a panel has gone by at t."""
    return np.asarray(np.clip((t - begin) / width, 0.0, 1.0))


class Births:
    """Births at stretches of one law along one motion.

    Parameters
    ----------
    life : Life
        What is left of contacts later on.
    law : Start
        The stretches at which broken contacts form again.
    delay : float
        Time for which a broken contact is out, in the unit of the motion's times.
    accuracy : float
        Pieces of the integrals are halved until the survival is resolved to this.

    Attributes
    ----------
    work : int
        Pieces that were integrated so far.
    dear : int
        What one survival after moves of several legs costs, in such pieces.
    """

    def __init__(
        self, life: Life, law: Start, motion: Motion, delay: float = 0.0, accuracy: float = 1e-14
    ) -> None:
        self.life, self.law, self.motion, self.delay = life, law, motion, delay
        self.accuracy, self.work = accuracy, 0
        self.dear = life.pair_work if law.is_single else life.pair_work * SPREAD_WORK

    def blocks(self, t: Array, begin: float, width: float) -> Array:
        """Number and force at times t per value of the breaks at the nodes of one panel.

        t : array of shape (n,), at or after the panel's beginning, all on one leg of the motion

        Returns an array of shape (2, n, DEGREE + 1).
        """
        out = np.zeros((2, t.size, rule.DEGREE + 1))
        for piece in self._integrals(t, np.array([begin]), np.array([width])):
            slopes = np.moveaxis(rule.legendre_slopes(piece.share), 0, -1)
            added = (piece.weights[..., None, :] @ slopes)[..., 0, :] @ rule.TO_LEGENDRE
            for kind in (0, 1):
                np.add.at(out[kind], piece.target, added[kind])
        if self.delay > 0.0:
            out[0] += rule.values(_share(t, begin, width))
            out[0] -= rule.values(_share(t - self.delay, begin, width))
        return out

    def sums(self, t: Array, begin: Array, width: Array, breaks: Array) -> Array:
        """Number and force at times t of the births of solved panels.

        t : array of shape (n,), all on one leg of the motion
        begin, width : arrays of shape (m,), of panels that begin at or before t
        breaks : array of shape (m, DEGREE + 1), values at 0 and the nodes

        Returns an array of shape (2, n).
        """
        if t.size * begin.size > CHUNK and t.size > 1:
            half = t.size // 2
            parts = (self.sums(part, begin, width, breaks) for part in (t[:half], t[half:]))
            return np.concatenate(list(parts), axis=1)
        out = np.zeros((2, t.size))
        slopes = breaks @ rule.SLOPES.T  # Legendre coefficients of the derivative by the share
        at_gauss = breaks @ rule.SLOPES_AT_GAUSS.T
        for piece in self._integrals(t, begin, width):
            born = np.empty(piece.share.shape)
            born[piece.whole] = at_gauss[piece.panel[piece.whole]]
            cut = ~piece.whole
            z = 2.0 * piece.share[cut] - 1.0
            born[cut] = rule.legendre_sum(slopes[piece.panel[cut]], z)
            added = (piece.weights * born).sum(axis=-1)
            for kind in (0, 1):
                out[kind] += np.bincount(piece.target, added[kind], t.size)
        if self.delay > 0.0:
            share = _share(t[:, None], begin, width), _share(t[:, None] - self.delay, begin, width)
            still_out = rule.values(share[0]) - rule.values(share[1])
            out[0] += np.einsum("tmn,mn->t", still_out, breaks)
        return out

    def still_whole(self, t: Array, begin: Array, width: Array) -> npt.NDArray[np.bool_]:
        """Panels all of whose births hold at all times t: none is stretched enough to break."""
        if not self.life.quiet > 0.0 or not begin.size:
            return np.zeros(begin.size, dtype=bool)
        s = np.stack([begin, begin + 0.5 * width, begin + width], axis=1) + self.delay
        last_t = float(t.max())
        history = self.motion.history(np.full((1, 1), last_t), np.minimum(s, last_t))
        first, last = self.law.span
        furthest = np.maximum(last + history.high.max(axis=1), -(first + history.low.min(axis=1)))
        return np.asarray((furthest <= self.life.quiet) & (s.max(axis=1) <= float(t.min())))

    def whole_sums(self, t: Array, begin: Array, width: Array, breaks: Array) -> Array:
        """The same as `sums`, where all births hold: they count by their number and mean place."""
        born = breaks[:, -1]
        # integral of the share of the panel over the births, by parts
        shares = born - breaks @ rule.TO_LEGENDRE[0]
        first = self.motion.at(begin + self.delay)
        places = first * born + (self.motion.at(begin + width + self.delay) - first) * shares
        now = self.motion.at(t) + float(self.law.mean())
        total = float(born.sum())
        return np.stack([np.full(t.size, total), now * total - float(places.sum())])

    def _integrals(self, t: Array, begin: Array, width: Array) -> Iterator[Pieces]:
        """Pieces of the panels on which a polynomial follows the survival, with the kernels there."""
        born = _share(t[:, None] - self.delay, begin, width)
        row, left, right = self._pieces(t, begin, width, born)
        for _ in range(DEPTH):
            if not row.size:
                return
            target, panel = row // begin.size, row % begin.size
            length = (right - left)[:, None]
            share = left[:, None] + length * rule.GAUSS_NODES
            s = begin[panel, None] + width[panel, None] * share + self.delay
            self.work += row.size
            kernels = self.life.left(self.law, self.motion.history(t[target, None], s))
            rough = self._rough(kernels[0], t[target], length[:, 0], width[panel])
            done = ~rough
            whole = (left == 0.0) & (right == 1.0)
            weights = kernels[:, done] * (length[done] * rule.GAUSS_WEIGHTS)
            yield Pieces(target[done], panel[done], share[done], weights, whole[done])
            middle = 0.5 * (left + right)[rough]
            row, left, right = (
                np.tile(row[rough], 2),
                np.append(left[rough], middle),
                np.append(middle, right[rough]),
            )

    def _rough(self, held: Array, t: Array, length: Array, width: Array) -> npt.NDArray[np.bool_]:
        """Pieces on which no polynomial follows the survival, but for the rounding of times."""
        tail = np.abs(held @ rule.GAUSS_TO_LEGENDRE[-2:].T).max(axis=-1)
        steepness = np.abs(held[:, 0] - held[:, -1]) / (length * width)
        rounding = ROUNDING * t * steepness
        return np.asarray((tail * length > self.accuracy + rounding * length) & (length > CLOSE))

    def _pieces(
        self, t: Array, begin: Array, width: Array, born: Array
    ) -> tuple[npt.NDArray[np.intp], Array, Array]:
        """Pieces of the panels, in shares, on which the survival seen at t is smooth.

        Returns for each piece its row (target times the number of panels, plus the panel) and its
        ends.
        """
        row, cut = self._cuts(t, begin, width, born)
        rows = np.arange(born.size)
        rows_of = np.concatenate([rows, rows, row])
        shares = np.concatenate([np.zeros(born.size), born.ravel(), cut])
        order = np.lexsort([shares, rows_of])
        rows_of, shares = rows_of[order], shares[order]
        piece = np.flatnonzero((rows_of[1:] == rows_of[:-1]) & (shares[1:] > shares[:-1]))
        return rows_of[piece], shares[piece], shares[piece + 1]

    def _cuts(
        self, t: Array, begin: Array, width: Array, born: Array
    ) -> tuple[npt.NDArray[np.intp], Array]:
        """Shares of the panels at which what is left at t bends: rows, as in `_pieces`, and shares.

        That is where the largest |x| of a contact changes sides, and where it meets a bend of the
        survival, or one of the edges of the survival's own panels where these are finer.
        """
        motion, life = self.motion, self.life
        r = self.law.mean() if self.law.is_single else 0.0
        leg = np.atleast_1d(motion.leg(begin + 0.5 * width + self.delay))
        speed = motion.speeds[leg]
        moved = speed * width
        first = motion.positions[leg] + speed * (begin + self.delay - motion.times[leg])
        high, low = motion.extremes(t, leg)
        marks = life.marks(0.6 * float(np.abs(moved).max()))
        # births at the position p have a largest |x| of high + r - p, or of p - low - r
        found = [
            _between(marks, high + r - first, -moved, born),
            _between(marks, first - low - r, moved, born),
            _between(np.zeros(1), 0.5 * (high + low) + r - first, -moved, born),
        ]
        row = np.concatenate([rows for rows, _ in found])
        return row, np.concatenate([shares for _, shares in found])


def _between(
    marks: Array, at_first: Array, change: Array, born: Array
) -> tuple[npt.NDArray[np.intp], Array]:
    """Where a length that changes evenly along each panel meets marks: rows, and shares of panels.

    marks : array of shape (k,), sorted
    at_first : array of shape (n, m), the length at the panels' beginnings, as seen from n targets
    change : array of shape (m,), from there to the panels' ends
    born : array of shape (n, m), the share of each panel that counts
    """
    near, far = at_first + CLOSE * change, at_first + (born - CLOSE) * change
    before = np.searchsorted(marks, np.minimum(near, far), "right").ravel()
    until = np.searchsorted(marks, np.maximum(near, far), "left").ravel()
    count = np.where((born.ravel() > 0.0) & (until > before), until - before, 0)
    row = np.repeat(np.arange(count.size), count)
    mark = np.arange(row.size) - np.repeat(np.cumsum(count) - count, count) + before[row]
    share = (marks[mark] - at_first.ravel()[row]) / change[row % change.size]
    return row, share
