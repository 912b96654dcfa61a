"""Births: the contributions of a panel's births to the number and the force at later times.

A contact that breaks at s is out until s + delay, where it is born again at a stretch r. As long as
it is out it counts among the contacts, but carries no force. So with E and K of its life the kernels
of number and force are

    number: 1 for t < s + delay, E(t, s + delay) after,      force: 0, then K(t, s + delay).

Both are integrated against the derivative of the number of breaks, a polynomial on each panel.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal import rule
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Two shares of a panel nearer than this count as equal: the breaks between them are negligible.
CLOSE = 1e-13
# Relative rounding of a time: where the survival is steep, nodes differ by hardly more than this.
ROUNDING = 8.0 * float(np.finfo(float).eps)
# Most targets times panels that are integrated at once: some 100 MB of arrays.
CHUNK = 40_000
# Cost of a survival averaged over the stretches at birth, in units of that from a single stretch.
SPREAD_WORK = 40
# Most pieces of integrals, counted per target, before halving of panels ends: some 30 s.
MOST_WORK = 15_000_000
# Most halvings of a piece on which no polynomial resolves the survival.
DEPTH = 40


class Moments(NamedTuple):
    """Integrals over pieces of panels of the kernels times Legendre polynomials of the share.

    target, panel : indices of each piece, shape (pieces,)
    values : array of shape (2, pieces, DEGREE + 1), for number and force
    """

    target: Rows
    panel: Rows
    values: Array


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

    def pick(self, which: Rows | npt.NDArray[np.bool_]) -> Panels:
        """The panels with these indices, or where the mask is true."""
        return Panels(*(part[which] for part in self))


class Added(NamedTuple):
    """The contributions of panels.

    sums : array of shape (2, *grid.shape), number and force
    gone : array of shape (panels,), whether all births of a panel have broken
    """

    sums: Array
    gone: npt.NDArray[np.bool_]


def _share(t: Array, begin: Array | float, width: Array | float) -> Array:
    """The share of a panel that lies before t."""
    return np.asarray(np.clip((t - begin) / width, 0.0, 1.0))


def births_of(contacts: Contacts) -> Start:
    """The law of the stretches at which broken contacts form again."""
    return SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law


class Births:
    """Births at stretches of one law along one motion.

    Parameters
    ----------
    life : Life
        Survival and force of contacts after their birth.
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
        Cost of one survival after moves over several legs, in such pieces.
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
        for found in self._moments(t, np.array([begin]), np.array([width])):
            for kind in (0, 1):
                np.add.at(out[kind], found.target, found.values[kind])
        out = out @ rule.SLOPES
        out[0] += self._out(t, np.array([begin]), np.array([width]))[:, 0]
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
        out, slopes = np.zeros((2, t.size)), breaks @ rule.SLOPES.T
        for found in self._moments(t, begin, width):
            added = np.einsum("kpd,pd->kp", found.values, slopes[found.panel])
            for kind in (0, 1):
                out[kind] += np.bincount(found.target, added[kind], t.size)
        if self.delay > 0.0:
            out[0] += np.einsum("tmd,md->t", self._out(t, begin, width), breaks)
        return out

    def added(self, grid: Array, panels: Panels) -> Added:
        """Contributions of the births of solved panels at later times, all on one leg.

        grid : array of shape (rows, columns)
        """
        out, t = np.zeros((2, grid.size)), float(grid[0, 0])
        s = panels.begin[:, None] + panels.width[:, None] * np.array([0.0, 0.5, 1.0]) + self.delay
        # contacts that are out do not count as gone
        gone = (s.max(axis=1) < t) & ~self.felt(np.array([[t]]), np.minimum(s, t), self.law)
        some = panels.pick(~gone)
        if some.begin.size:
            out = self.sums(grid.ravel(), some.begin, some.width, some.breaks)
        return Added(out.reshape(2, *grid.shape), gone)

    def felt(self, t: Array, s: Array, law: Start) -> npt.NDArray[np.bool_]:
        """Whether some contacts born at s, shape (n, columns), are within the life's reach at t."""
        history = self.motion.history(t, s)
        first, last = law.span
        least = np.maximum(first + history.high.min(axis=1), -(last + history.low.max(axis=1)))
        return np.asarray(least < self.life.reach)

    def _out(self, t: Array, begin: Array, width: Array) -> Array:
        """Contacts that are out, per value of the breaks: shape (n, m, DEGREE + 1)."""
        if not self.delay > 0.0:
            return np.zeros((t.size, begin.size, rule.DEGREE + 1))
        shares = (_share(at[:, None], begin, width) for at in (t, t - self.delay))
        broken, born = (rule.values(share) for share in shares)
        return np.asarray(broken - born)

    def _moments(self, t: Array, begin: Array, width: Array) -> Iterator[Moments]:
        """Moments over pieces of the panels, halved until a polynomial resolves the survival."""
        born = _share(t[:, None] - self.delay, begin, width)
        row, left, right = self._pieces(t, begin, width, born)
        target, panel = row // begin.size, row % begin.size
        if row.size:
            shares = np.stack([left, 0.5 * (left + right), right], axis=1)
            s = begin[panel, None] + width[panel, None] * shares + self.delay
            felt = self.felt(t[target, None], np.minimum(s, t[target, None]), self.law)
            row, left, right = row[felt], left[felt], right[felt]
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
            whole = (left == 0.0) & (right == 1.0) & ~rough
            cut = ~whole & ~rough
            weights = kernels * (length * rule.GAUSS_WEIGHTS)
            yield Moments(target[whole], panel[whole], weights[:, whole] @ rule.AT_GAUSS)
            basis = rule.legendre_values(share[cut])
            values = weights[:, cut].transpose(1, 0, 2) @ basis
            yield Moments(target[cut], panel[cut], values.transpose(1, 0, 2))
            middle = 0.5 * (left + right)[rough]
            row, left, right = (
                np.tile(row[rough], 2),
                np.append(left[rough], middle),
                np.append(middle, right[rough]),
            )

    def _rough(self, held: Array, t: Array, length: Array, width: Array) -> npt.NDArray[np.bool_]:
        """Pieces on which no polynomial resolves the survival, apart from the rounding of times."""
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
        """Shares of the panels at which the survival at t bends: rows, as in `_pieces`, and shares.

        That is where the largest |x| of a contact changes sides, where it meets a bend of the
        survival, and where it meets an edge of the survival's own panels, if these are finer.
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
    """Where a length that changes linearly along each panel meets marks: rows, and shares of panels.

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
