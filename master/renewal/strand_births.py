"""Births of one finished leg, of contacts that age: strands which follow the slider.

Where contacts age, the survival has no closed form in the slider's displacements. So contacts born at
some moments of the leg (the strands) are followed once along each later leg. The sum over all births
is a weighted sum over strands: on pieces of the time of birth the survival is a polynomial in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.interpolate import BSpline, make_interp_spline

from master.lives.age.ageing import MARGIN, AgeingPath
from master.lives.age.strands import Followed, Strands
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births, Panels
from master.renewal.earlier import moments

Array = npt.NDArray[np.float64]

# Gauss nodes of a piece in the time of birth.
SIZE = 8
# First guess of a piece, in units of the narrowest width of the thresholds; most halvings of a piece.
FIRST, HALVINGS = 4.0, 5

# Allowed error of a piece, in units of that of the leg; it is the largest over all times.
PIECE = 0.1

_NODES = legendre.leggauss(SIZE)[0]
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(_NODES, SIZE - 1)).T


class _Pieces(NamedTuple):
    """Pieces of the times of birth since the leg's beginning, the strands born at their nodes, and
    these strands' weights; arrays of shape (n,), n * SIZE strands, (n, SIZE)."""

    left: Array
    right: Array
    strands: Strands
    weight: Array

    def pick(self, which: npt.NDArray[np.intp]) -> _Pieces:
        rows = (which[:, None] * SIZE + np.arange(SIZE)).ravel()
        strands = self.strands.take(rows)
        return _Pieces(self.left[which], self.right[which], strands, self.weight[which])

    def join(self, other: _Pieces) -> _Pieces:
        left, right, weight = (
            np.concatenate([getattr(self, name), getattr(other, name)])
            for name in ("left", "right", "weight")
        )
        return _Pieces(left, right, self.strands.join(other.strands), weight)


class StrandBirths:
    """The births of one finished leg, for contacts that age; used as EarlierBirths is.

    Attributes
    ----------
    missed : float
        Error of the number, as polynomials in the time of birth approximate the survival.
    """

    def __init__(
        self,
        births: Births,
        leg: int,
        panels: Panels,
        accuracy: float,
        goes_on: Callable[[], bool] = lambda: True,
    ) -> None:
        life = births.life
        assert isinstance(life, AgeingPath)
        self._life, self._births, self._leg, self._seen = life, births, leg, leg
        self._panels, self._accuracy, self._goes_on = panels, PIECE * accuracy, goes_on
        self.missed, self.in_hold = 0.0, False
        self._slopes = panels.breaks @ rule.SLOPES.T
        first, last = float(panels.since[0]), float(panels.since[-1] + panels.width[-1])
        speed, width = abs(float(life.motion.speeds[leg])), FIRST * life.mesh.width
        count = max(1, int(np.ceil((last - first) * speed / width)))
        edges = np.linspace(first, last, count + 1)
        self._pieces = self._born(edges[:-1], edges[1:])
        self._splines: BSpline | None = None

    def seen_from(self, motion: Motion, negligible: float) -> bool:
        """Follow the strands to the end of the present leg, which begins at t = 0 of this motion.

        Returns whether more contacts than is negligible hold at the leg's beginning.
        """
        leg = int(motion.leg(np.finfo(float).tiny))
        while self._seen < leg:
            self._seen += 1
            left = np.abs(self._pieces.weight).ravel() @ self._pieces.strands.left()[0]
            if not left > negligible:
                return False
            self._follow(self._seen)
        return True

    def sums(self, t: Array) -> Array:
        """Number and force at times t, shape (n,), since the leg's beginning; shape (2, n)."""
        if self._splines is None:
            return np.zeros((2, t.size))
        root = np.sqrt(np.minimum(t, self._longest))
        return np.moveaxis(self._splines(root), -1, 0)

    def _follow(self, leg: int) -> None:
        """Make splines of the sums along a leg; pieces that do not resolve them are halved."""
        waiting: _Pieces | None = self._pieces
        done: _Pieces | None = None
        for halving in range(HALVINGS + 1):
            assert waiting is not None
            found = self._life.follow(waiting.strands, leg)
            told = found.left.reshape(*found.left.shape[:-1], -1, SIZE)
            wrong = _missed(told[:, 0], waiting.weight)
            rough = wrong > self._accuracy
            if halving == HALVINGS or not self._goes_on():
                rough[:] = False
            self._series(found, told, waiting.weight, ~rough, first=halving == 0)
            self.missed = max(self.missed, float(wrong[~rough].sum()))
            kept = waiting.pick(np.flatnonzero(~rough))
            done = kept if done is None else done.join(kept)
            if not rough.any():
                break
            left, right = waiting.left[rough], waiting.right[rough]
            middle = 0.5 * (left + right)
            waiting = self._born(np.append(left, middle), np.append(middle, right))
            for earlier in range(self._leg + 1, leg):
                self._life.follow(waiting.strands, earlier)
        assert done is not None
        self._pieces = done

    def _series(
        self, found: Followed, told: Array, weight: Array, kept: npt.NDArray[np.bool_], first: bool
    ) -> None:
        """Add the sums of these pieces to the splines over the root of the time on the leg."""
        sums = np.einsum("jkpi,pi->jk", told[:, :, kept], weight[kept])
        if first:
            self._sums = np.zeros(sums.shape)
        self._sums = self._sums + sums
        self._longest = float(found.times[-1])
        degree = min(5, found.times.size - 1)
        self._splines = make_interp_spline(np.sqrt(found.times), self._sums, k=degree)

    def _born(self, left: Array, right: Array) -> _Pieces:
        """Pieces, with strands that have come to the end of the leg on which they were born."""
        middle, half = 0.5 * (left + right), 0.5 * (right - left)
        nodes = middle[:, None] + half[:, None] * _NODES
        motion = self._life.motion
        duration = motion.times[self._leg + 1] - motion.times[self._leg]
        ages = np.maximum(duration - nodes.ravel(), 0.0)
        strands = self._life.aged(self._births.law, float(motion.speeds[self._leg]), ages)
        return _Pieces(left, right, strands, self._weights(left, right))

    def _weights(self, left: Array, right: Array) -> Array:
        """Weights of the pieces' nodes in a sum over all births, shape (pieces, SIZE)."""
        since, width = self._panels.since, self._panels.width
        ends = np.append(since, since[-1] + width[-1])
        return moments(ends, self._slopes, left, right, SIZE) @ _TO_LEGENDRE.T


def _missed(told: Array, weight: Array) -> Array:
    """Error of the sums over each piece's nodes; told, the survival, has shape (times, pieces, SIZE).

    The coefficients of the survival alone (extrapolated by their decay; at a bend they fall as the
    inverse square of their order) overestimate it up to 1e4 times, as the rate of births is nearly
    constant. The contribution of the last coefficients to the sums underestimates it up to 20
    times. The geometric mean of both is about right.
    """
    series = told @ _TO_LEGENDRE
    size = np.abs(series)
    last, before = size[..., -2:].max(axis=-1), size[..., -4:-2].max(axis=-1)
    fall = np.divide(last, before, out=np.ones_like(last), where=before > last)
    alone = (last * fall**2).max(axis=0) * np.abs(weight).sum(axis=1)
    moments_of_births = weight @ legendre.legvander(_NODES, SIZE - 1)
    changed = (size[..., -2:] * np.abs(moments_of_births[:, -2:])).sum(axis=-1).max(axis=0)
    return np.asarray(MARGIN * np.sqrt(alone * changed))
