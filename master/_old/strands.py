"""Cohorts of contacts whose thresholds do not change, as strands: contacts born at one place and one stretch.

A strand remembers where it was born, its largest |x| so far, m, and what its `Wear` keeps. Births at many stretches
are a few strands each, at nodes of R.
"""

from __future__ import annotations

from copy import copy
from typing import Self

import numpy as np
import numpy.typing as npt

from master._old.lives import halves
from master._old.wear import Left, Wear

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]

_DEAD = 1e-19
_ROOM = 64


class CohortLives:
    """`Lives` of such contacts, with a `Wear`.

    start, again : pairs of arrays (n,)
        Stretches of the contacts that hold at X = 0, and of births (lengths); with each its weight over S(|r|).
    """

    def __init__(self, wear: Wear, start: Nodes, again: Nodes) -> None:
        self.length, self.time, self.rate = wear.length, wear.time, wear.rate
        self.work = wear.work * again[0].size
        self.skin = wear.skin
        self.fuzzy = False
        self._wear, self._at, self._again = wear, 0.0, again
        self._start, self._births = Strands(wear, *start), Strands(wear, *again)
        self._start.add(0.0)

    @property
    def error(self) -> float:
        return self._wear.error

    @property
    def held(self) -> Array:
        return np.append(self._start.held, self._births.held)

    @property
    def pull(self) -> Array:
        return np.append(self._start.pull, self._births.pull)

    def born(self) -> None:
        self._births.add(self._at)

    def advance(self, travel: float, duration: float, bend: float = 0.0) -> None:
        before, self._at = self._at, self._at + travel
        for strands in (self._start, self._births):
            strands.advance(before, self._at, duration)

    def spread(self) -> tuple[Array, Array]:
        held, pull = self._births.kinks(self._at)
        return halves(self.held) + held, halves(self.pull) + pull

    def copy(self) -> Self:
        for strands in (self._start, self._births):
            strands.settle(self._at)
        out = copy(self)
        out._start, out._births = self._start.copy(), self._births.copy()
        return out


class Strands:
    """Cohorts of as many strands as `stretch` and `share` have; `count` of them."""

    def __init__(self, wear: Wear, stretch: Array, share: Array) -> None:
        self._wear, self._stretch, self._share = wear, stretch, share
        self.count, room, nodes = 0, _ROOM, stretch.size
        self._place, self._furthest = np.empty((room, nodes)), np.empty((room, nodes))
        # what m came from: the slider's furthest position ahead (1), behind (-1), or the stretch at birth (0)
        self._side = np.empty((room, nodes), dtype=np.int8)
        self._edge, self._edge_stiff = np.zeros((room, nodes)), np.zeros((room, nodes))
        self._held, self._pull = np.empty(room), np.empty(room)
        fresh = wear.fresh(stretch)
        self._worn = np.empty((room, nodes, fresh.shape[1]))
        self._fresh = fresh
        first = wear.left(fresh, stretch, np.abs(stretch))
        held, pull = float((share * first.held).sum()), float((share * first.stiff * stretch).sum())
        self._at_birth = held, pull, first.edge, first.edge_stiff

    @property
    def held(self) -> Array:
        return self._held[: self.count]

    @property
    def pull(self) -> Array:
        return self._pull[: self.count]

    def add(self, at: float) -> None:
        """A cohort born where the slider stands at X = at."""
        if self.count == self._held.size:
            for name, value in vars(self).items():
                if isinstance(value, np.ndarray) and value.shape[:1] == (self.count,) and name not in _FIXED:
                    setattr(self, name, np.concatenate([value, np.zeros_like(value)]))
        k = self.count
        self._place[k], self._furthest[k], self._side[k] = at - self._stretch, np.abs(self._stretch), 0
        self._worn[k] = self._fresh
        self._held[k], self._pull[k], self._edge[k], self._edge_stiff[k] = self._at_birth
        self.count += 1

    def put(self, at: float, worn: Array) -> None:
        """The same with numbers of their own, shape (nodes, width)."""
        self.add(at)
        rows = slice(self.count - 1, self.count)
        self._worn[rows] = worn
        furthest = np.abs(self._stretch)
        self._read(rows, self._stretch, furthest, self._wear.left(worn.copy(), self._stretch, furthest))

    def advance(self, before: float, at: float, duration: float) -> None:
        """All move with the slider from X = before to X = at."""
        rows = self._alive()
        self._held[: rows.start] = self._pull[: rows.start] = 0.0
        self._held[rows.stop : self.count] = self._pull[rows.stop : self.count] = 0.0
        if rows.stop == rows.start:
            return
        place, furthest = self._place[rows].ravel(), self._furthest[rows].ravel()
        worn = self._worn[rows].reshape(place.size, self._fresh.shape[1])
        stretch = at - place
        self._wear.advance(worn, before - place, stretch, furthest, duration)
        further = np.abs(stretch) > furthest
        self._side[rows].reshape(-1)[further] = np.sign(stretch[further])
        furthest = np.maximum(furthest, np.abs(stretch))
        self._furthest[rows] = furthest.reshape(-1, self._stretch.size)
        self._read(rows, stretch, furthest, self._wear.left(worn, stretch, furthest))

    def settle(self, at: float) -> None:
        """Work out what trial steps from here share."""
        rows = self._alive()
        place, furthest = self._place[rows].ravel(), self._furthest[rows].ravel()
        self._wear.settle(self._worn[rows].reshape(place.size, self._fresh.shape[1]), at - place, furthest)

    def _alive(self) -> slice:
        """Cohorts that hold: they die in the order of their births but for turns, and one slice costs no copies."""
        alive = np.flatnonzero(self._held[: self.count] > _DEAD)
        return slice(int(alive[0]), int(alive[-1]) + 1) if alive.size else slice(0, 0)

    def _read(self, rows: slice, stretch: Array, furthest: Array, left: Left) -> None:
        shape = (-1, self._stretch.size)
        self._held[rows] = left.held.reshape(shape) @ self._share
        self._pull[rows] = (left.stiff * stretch).reshape(shape) @ self._share
        self._edge[rows], self._edge_stiff[rows] = left.edge.reshape(shape), left.edge_stiff.reshape(shape)

    def kinks(self, at: float) -> tuple[Array, Array]:
        """What the chord between two births misses of `held` and `pull` where m(birth), a V, has its foot between
        them; shapes (count - 1,)."""
        n = self.count
        side, place, m = self._side[:n], self._place[:n], self._furthest[:n]
        out = np.zeros((2, max(n - 1, 0)))
        row, node = np.nonzero((side[1:] != side[:-1]) & (place[1:] != place[:-1]))
        if not row.size:
            return out[0], out[1]
        ends = [(k, node) for k in (row, row + 1)]
        own = np.abs(self._stretch[node])
        # m = high - place, m = place - low, m = |r|
        high, low, flat = np.full(row.size, np.nan), np.full(row.size, np.nan), np.zeros(row.size, dtype=bool)
        for end in ends:
            ahead, behind = side[end] > 0, side[end] < 0
            high[ahead], low[behind] = (place[end] + m[end])[ahead], (place[end] - m[end])[behind]
            flat |= side[end] == 0
        foot = 0.5 * (high + low)
        least = 0.5 * (high - low)
        foot[flat] = np.where(np.isnan(high), low + own, high - own)[flat]
        least[flat] = own[flat]
        part = (foot - place[ends[0]]) / (place[ends[1]] - place[ends[0]])
        inside = (part > 0.0) & (part < 1.0)
        row, node, part, foot = row[inside], node[inside], part[inside], foot[inside]
        deep = (m[row, node] * (1.0 - part) + m[row + 1, node] * part - least[inside]) * (0.5 * self._share[node])
        for k, edge in enumerate((self._edge, self._edge_stiff)):
            more = deep * 0.5 * (edge[row, node] + edge[row + 1, node]) * (1.0 if k == 0 else at - foot)
            out[k] += np.bincount(row, weights=more, minlength=n - 1)
        return out[0], out[1]

    def copy(self) -> Strands:
        out, alive = copy(self), self._alive()
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray) and name not in (*_FIXED, "_worn"):
                setattr(out, name, value.copy())
        # by far the most, and of the dead nothing is asked
        out._worn = np.empty_like(self._worn)
        out._worn[alive] = self._worn[alive]
        return out


_FIXED = ("_stretch", "_share", "_fresh")
