"""The lowest barrier on the way from the lowest minimum of a periodic landscape to a copy of it.

Newton's method finds all points of a cell where the gradient vanishes; on a torus there are as many saddles as minima
and maxima together, which shows whether some are missing. From each saddle the landscape falls to a minimum on both
sides. As water that rises, the minima are then joined to pools over the saddles in order of rising energy: the barrier
is the first energy at which the pool of the lowest minimum meets a copy of itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.errors import refuse
from origins.thresholds.law import Array

Complex = npt.NDArray[np.complex128]

_TURN = 2.0 * np.pi
_NOTHING = 1e-13  # of the largest wave: smaller waves count as 0; also the rounding of an energy


class LowestBarrier(NamedTuple):
    """Barrier and energy of the lowest minimum, and the places (2,) of minimum and saddle in radians."""

    barrier: float
    depth: float
    minimum: Array
    saddle: Array


class _Local(NamedTuple):
    """Slopes and curvatures (m, 2) along the principal directions, rows (m, 2, 2), that of greatest curvature first."""

    slopes: Array
    curvatures: Array
    directions: Array


class _Landscape(NamedTuple):
    """U(t) = sum_n sizes_n cos(K_n·t + phases_n), K of shape (n, 2), asked at places t of shape (m, 2)."""

    waves: Array
    sizes: Array
    phases: Array

    def energy(self, t: Array) -> Array:
        """U, shape (m,)."""
        return np.asarray(np.cos(t @ self.waves.T + self.phases) @ self.sizes)

    def local(self, t: Array) -> _Local:
        """Slopes and curvatures."""
        angle = t @ self.waves.T + self.phases
        cos, sin = self.sizes * np.cos(angle), self.sizes * np.sin(angle)
        k, m = self.waves.T
        turn = 0.5 * np.arctan2(-(cos @ (2.0 * k * m)), -(cos @ (k * k - m * m)))
        x, y = np.cos(turn), np.sin(turn)
        directions = np.array([x, y, -y, x]).T.reshape(-1, 2, 2)
        # summed wave by wave, so that small waves keep their digits where the large ones are flat
        along = directions @ self.waves.T
        slopes = -np.einsum("mkn,mn->mk", along, sin)
        curvatures = -np.einsum("mkn,mn->mk", along * along, cos)
        slopes[np.abs(slopes) <= 4e-15 * np.abs(along) @ self.sizes] = 0.0  # rounding
        return _Local(slopes, np.where(curvatures == 0.0, 1e-15, curvatures), directions)

    def newton_step(self, t: Array, down: bool = False) -> Array:
        """Newton's step from t to a critical point, shape (m, 2), or one that leads `down`; at most half a radian of
        the fastest wave."""
        slopes, curvatures, directions = self.local(t)
        lengths = -slopes / (np.abs(curvatures) if down else curvatures)
        step = np.einsum("mk,mkd->md", lengths, directions)
        fastest = np.abs(step @ self.waves.T).max(-1)
        return step * np.minimum(1.0, 0.5 / np.maximum(fastest, 1e-300))[:, None]

    def critical_points(self, n: int) -> tuple[Array, Array]:
        """Places (m, 2) where Newton's method finds a critical point near nodes of a grid of n x n, each once, and how
        many curvatures are above zero there: 0 at maxima, 1 at saddles, 2 at minima."""
        spacing = _TURN / n
        # no node falls on a line of symmetry
        start = spacing * np.indices((n, n), dtype=float).reshape(2, -1).T + (0.012345, 0.00789)
        t = start = start[np.hypot(*self.newton_step(start).T) < spacing]
        for _ in range(20):
            step = self.newton_step(t)
            t = t + step
            if (np.abs(step) < 1e-9).all():
                break
        # a last step below this changes energies by at most its square
        t = t[(np.abs(step) < 1e-6).all(-1) & (np.abs(t - start) < 4.0 * spacing).all(-1)]
        kind = (self.local(t).curvatures > 0.0).sum(-1)
        each = np.unique(_same(np.column_stack([t, kind])))
        return t[each], kind[each]

    def descended(self, t: Array) -> Array:
        """The minima to which U falls from t; steps that would lead up are shortened."""
        trust, energy = np.ones((len(t), 1)), self.energy(t)
        for _ in range(400):
            step = trust * self.newton_step(t, down=True)
            level = self.energy(t + step)
            lower = level <= energy + 1e-15
            t, energy = np.where(lower[:, None], t + step, t), np.where(lower, level, energy)
            trust = np.where(lower[:, None], np.minimum(2.0 * trust, 1.0), 0.25 * trust)
            if (np.abs(step) < 1e-9).all():
                break
        return t


def lowest_saddle(indices: npt.ArrayLike, amplitudes: Complex) -> LowestBarrier:
    """The lowest barrier of U(t) = Re sum_n c_n exp(i K_n·t), t in radians, of period 2 pi in both directions.

    K are whole numbers, shape (n, 2); c energies, shape (n,). The barrier is known to about 1e-12 of the largest wave
    where all critical points are found. Some are missing on the finest grid in valleys that are flat within rounding.
    """
    sizes = np.abs(amplitudes)
    scale = float(sizes.max(initial=0.0))
    kept = sizes > _NOTHING * scale
    waves, sizes = np.asarray(indices, dtype=float)[kept], sizes[kept] / scale
    if not kept.any() or np.linalg.matrix_rank(waves) < 2:  # there is no barrier across them
        return LowestBarrier(0.0, -float(sizes.sum()) * scale, np.zeros(2), np.zeros(2))
    landscape = _Landscape(waves, sizes, np.angle(amplitudes[kept]))
    # 16 nodes per oscillation find each critical point from several nodes
    curvature = np.average((waves**2).sum(-1), weights=sizes)
    nodes = int(np.clip(np.ceil(16.0 * np.sqrt(curvature)), 16, 160))
    for n in (nodes, 2 * nodes, 4 * nodes):
        points, kind = landscape.critical_points(n)
        if 2 * np.count_nonzero(kind == 1) == kind.size:
            break
    found = _over_saddles(landscape, points[kind == 1])
    return found._replace(barrier=found.barrier * scale, depth=found.depth * scale)


def _same(points: Array) -> npt.NDArray[np.intp]:
    """For each of the points (m, ...) the number of the first that is the same but for whole periods."""
    apart = points[:, None] - points
    near = np.abs(apart - _TURN * np.rint(apart / _TURN)) < 1e-4  # radians
    return np.asarray(near.all(-1).argmax(1) if len(points) else np.empty(0, int))


def _over_saddles(landscape: _Landscape, tops: Array) -> LowestBarrier:
    """The lowest barrier over saddles at `tops` (m, 2), in units of the landscape; InputError where none is found."""
    downhill = 1e-3 * landscape.local(tops).directions[:, 1]
    feet = landscape.descended(np.concatenate([tops + downhill, tops - downhill]))
    levels, energies = landscape.energy(tops), landscape.energy(feet)
    distinct, number = np.unique(_same(feet), return_inverse=True)
    depth = float(energies.min(initial=np.inf))
    lowest = energies[distinct] <= depth + _NOTHING
    # of each minimum: the place of the copy in its pool, the number of the pool; of a pool: whether it meets a copy
    places, pool = feet[distinct], np.arange(distinct.size)
    winds = np.zeros(distinct.size, dtype=bool)
    for top in np.argsort(levels):
        side = top + len(tops)
        near, far = number[top], number[side]
        apart = np.rint((places[near] - feet[top] + feet[side] - places[far]) / _TURN)
        if pool[near] == pool[far]:
            winds[pool[near]] |= apart.any()
        else:
            winds[pool[near]] |= winds[pool[far]]
            joining = pool == pool[far]
            places[joining] += _TURN * apart
            pool[joining] = pool[near]
        if winds[pool[lowest]].any():
            barrier = max(float(levels[top]) - depth, 0.0)
            return LowestBarrier(barrier, depth, feet[energies.argmin()], tops[top])
    refuse("wavevectors", landscape.waves, "no way over saddles is found; leave small waves out")
