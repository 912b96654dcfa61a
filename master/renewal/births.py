"""Births: what is born along a motion, and integrals over births on pieces of it.

A contact that breaks at s is out until s + delay, where it is born again at a stretch r. As long as
it is out it counts among the contacts, but carries no force. So with E and K of its life the kernels
of number and force are

    number: 1 for t < s + delay, E(t, s + delay) after,      force: 0, then K(t, s + delay).

Both are integrated against the derivative of the number of breaks, a polynomial on each panel
(kernels: births on the present leg; past: births on the legs before).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.lives.life import Life
from master.motion.motion import Motion
from master.renewal import rule
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# The smallest normal number: it keeps quotients by widths that are 0 by rounding finite.
TINY = float(np.finfo(float).tiny)
# Two places of birth nearer than this share of the whole range count as equal.
CLOSE = 1e-13
# Most pairs of pieces and panels that are summed at once: some 100 MB of arrays.
CHUNK = 100_000
# Most pieces of births that are integrated, if quickly, before halving of panels ends: some 30 s.
MOST_WORK = 15_000_000


def reforming_law(contacts: Contacts) -> Start:
    """The law of the stretches at which broken contacts form again."""
    return SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law


@dataclass
class Births:
    """Births at stretches of one law along one motion.

    Attributes
    ----------
    life : Life
        Survival and force of contacts after their birth.
    law : Start
        The stretches at which broken contacts form again.
    motion : Motion
    delay : float
        Time for which a broken contact is out, in the unit of the motion's times.
    accuracy : float
        Aimed-at error of the number that the births on one leg contribute.
    work : int
        Pieces of births integrated so far, times their cost; it may be limited.
    """

    life: Life
    law: Start
    motion: Motion
    delay: float = 0.0
    accuracy: float = 1e-15
    work: int = 0

    @property
    def dear(self) -> int:
        """Cost of a piece: its survivals may be averages over stretches, and no mere look-ups."""
        look_ups = 1 if self.life.quick else 18 * self.life.pair_work
        return look_ups if self.law.is_single else 40 * look_ups


class Panels(NamedTuple):
    """Solved panels, in the order of time.

    begin, since, width : arrays of shape (n,); begin is a time, since is counted from the beginning
        of a leg
    breaks : array of shape (n, DEGREE + 1), values at 0 and the nodes
    """

    begin: Array
    since: Array
    width: Array
    breaks: Array

    def middle_of_births(self, delay: float) -> Array:
        """Times in the middle of the births, one delay after the breaks."""
        return self.begin + 0.5 * self.width + delay


class Pieces(NamedTuple):
    """Pieces of the places of birth, as seen from targets; arrays of shape (pieces,).

    A place is a coordinate, such as the time, that increases with the birth.
    """

    target: Rows
    left: Array
    right: Array

    @classmethod
    def of(cls, edges: Array) -> Pieces:
        """From edges of shape (targets, n), in any order."""
        edges = np.sort(edges, axis=1)
        close = CLOSE * (edges[:, -1:] - edges[:, :1])
        target, piece = np.nonzero(np.diff(edges, axis=1) > close)
        return cls(target, edges[target, piece], edges[target, piece + 1])

    def pick(self, which: npt.NDArray[np.bool_]) -> Pieces:
        return Pieces(self.target[which], self.left[which], self.right[which])

    def halves(self, knots: Array) -> Pieces:
        """Each cut in two at the knot nearest to its middle, or at the middle if it has none."""
        at = 0.5 * (self.left + self.right)
        after = np.clip(np.searchsorted(knots, at), 1, knots.size - 1)
        before = knots[after - 1]
        knot = np.where(at - before < knots[after] - at, before, knots[after])
        small = CLOSE * (self.right - self.left)
        at = np.where((knot > self.left + small) & (knot < self.right - small), knot, at)
        return Pieces(np.tile(self.target, 2), np.append(self.left, at), np.append(at, self.right))


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
    begin, width = ends[panel], np.maximum(np.diff(ends)[panel], TINY)
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
