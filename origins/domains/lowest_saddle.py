"""The lowest barrier on the way from the lowest minimum of a periodic landscape to a copy of it.

Newton's method finds all points of a cell where the gradient vanishes; on a torus there are as many saddles as minima
and maxima together, which shows whether some are missing. From each saddle the landscape falls to a minimum on both
sides. The minima are then joined over the saddles in order of rising energy, on a torus of twice the period in both
directions: the barrier is the first energy at which the lowest minimum meets one of its copies, as a region that winds
round the first torus holds a loop that winds an odd number of times in one direction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

Whole = npt.NDArray[np.intp]
Complex = npt.NDArray[np.complex128]

_TURN = 2.0 * np.pi
_NOTHING = 1e-13  # of the largest wave: smaller waves count as 0; also the rounding of an energy
_SAME = 1e-4  # radians: critical points of one kind closer than this are one


class LowestBarrier(NamedTuple):
    """Barrier and energy of the lowest minimum, and the places (2,) of minimum and saddle in radians."""

    barrier: float
    depth: float
    minimum: Array
    saddle: Array


def lowest_saddles(indices: npt.ArrayLike, amplitudes: Complex) -> list[LowestBarrier]:
    """The lowest barriers of U(t) = Re sum_n c_n exp(i K_n·t), t in radians, of period 2 pi in both directions.

    K are whole numbers, shape (n, 2); c energies, shape (landscapes, n). Barriers are known to about
    1e-12 of the largest wave where all critical points are found. Some are missing on the finest grid in valleys that
    are flat within rounding.
    """
    waves, sizes = np.asarray(indices, dtype=float), np.abs(amplitudes)
    scale = np.maximum(sizes.max(-1), 1e-300)
    sizes = np.where(sizes > _NOTHING * scale[:, None], sizes / scale[:, None], 0.0)
    curvature = sizes @ (waves**2).sum(-1) / np.maximum(sizes.sum(-1), 1e-300)
    # 16 nodes per oscillation find each critical point from several nodes
    nodes = int(np.clip(np.ceil(16.0 * np.sqrt(curvature.max())), 16, 160))
    landscapes = _Landscapes(waves, sizes, np.angle(amplitudes), scale)
    lowest: dict[int, LowestBarrier] = {}
    complete = np.zeros(len(sizes), dtype=bool)
    for n in (nodes, 2 * nodes, 4 * nodes):
        few = max(1, (1 << 20) // (n * n * len(waves)))  # landscapes at once, to limit memory
        rest = np.flatnonzero(~complete)
        for batch in (rest[first : first + few] for first in range(0, rest.size, few)):
            each, complete[batch] = _on_grid(landscapes.of(batch), n)
            lowest |= zip(batch.tolist(), each, strict=True)
    return [lowest[k] for k in range(len(sizes))]


class _Local(NamedTuple):
    """Slopes and curvatures (m, 2) along the principal directions, rows (m, 2, 2), that of greatest curvature first."""

    slopes: Array
    curvatures: Array
    directions: Array


class _Landscapes(NamedTuple):
    """U(t) = sum_n sizes_n cos(K_n·t + phases_n) in units of `scale`: K of shape (n, 2), sizes and phases (m, n), scale
    (m,); each is asked at one place t of its own, shape (m, 2)."""

    waves: Array
    sizes: Array
    phases: Array
    scale: Array

    def of(self, which: Whole | list[int]) -> _Landscapes:
        """The landscapes of these numbers, in this order."""
        return _Landscapes(self.waves, *(each[which] for each in self[1:]))

    def energy(self, t: Array) -> Array:
        """U, shape (m,)."""
        return (self.sizes * np.cos(t @ self.waves.T + self.phases)).sum(-1)

    def local(self, t: Array) -> _Local:
        """Slopes and curvatures."""
        angle = t @ self.waves.T + self.phases
        cos, sin = self.sizes * np.cos(angle), self.sizes * np.sin(angle)
        k, m = self.waves.T
        turn = 0.5 * np.arctan2(-(cos @ (2.0 * k * m)), -(cos @ (k * k - m * m)))
        x, y = np.cos(turn), np.sin(turn)
        directions = np.moveaxis(np.array([[x, y], [-y, x]]), -1, 0)
        # summed wave by wave, so that small waves keep their digits where the large ones are flat
        along = directions @ self.waves.T
        slopes = -np.einsum("mkn,mn->mk", along, sin)
        curvatures = -np.einsum("mkn,mn->mk", along * along, cos)
        rounding = 4e-15 * np.einsum("mkn,mn->mk", np.abs(along), self.sizes)
        slopes[np.abs(slopes) <= rounding] = 0.0
        return _Local(slopes, np.where(curvatures == 0.0, 1e-15, curvatures), directions)

    def newton_step(self, t: Array, down: bool = False) -> Array:
        """Newton's step from t to a critical point, shape (m, 2), or one that leads `down`; at most half a radian of
        the fastest wave."""
        slopes, curvatures, directions = self.local(t)
        lengths = -slopes / (np.abs(curvatures) if down else curvatures)
        step = np.einsum("mk,mkd->md", lengths, directions)
        fastest = np.abs(step @ self.waves.T).max(-1)
        return step * np.minimum(1.0, 0.5 / np.maximum(fastest, 1e-300))[:, None]

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


def _on_grid(landscapes: _Landscapes, n: int) -> tuple[list[LowestBarrier], npt.NDArray[np.bool_]]:
    """The lowest barrier of each landscape, from critical points near the nodes of a grid of n x n, and whether all of
    these were found."""
    owner, points = _critical_points(landscapes, n)
    local = landscapes.of(owner).local(points)
    saddle = (local.curvatures > 0.0).sum(-1) == 1
    above, tops, downhill = owner[saddle], points[saddle], 1e-3 * local.directions[saddle, 1]
    under = landscapes.of(above)
    feet = np.stack([under.descended(tops + downhill), under.descended(tops - downhill)])
    found = []
    for number in range(len(landscapes.scale)):
        here = above == number
        found.append(_over_saddles(landscapes.of([number]), tops[here], feet[:, here]))
    saddles, all_ = (np.bincount(each, minlength=len(found)) for each in (above, owner))
    return found, 2 * saddles == all_


def _critical_points(landscapes: _Landscapes, n: int) -> tuple[Whole, Array]:
    """Landscape and place of the critical points that Newton's method finds near nodes, each once."""
    spacing, count = _TURN / n, len(landscapes.scale)
    # no node falls on a line of symmetry
    places = spacing * np.indices((n, n)).reshape(2, -1).T + (0.012345, 0.00789)
    which, start = np.repeat(np.arange(count), n * n), np.tile(places, (count, 1))
    close = np.hypot(*landscapes.of(which).newton_step(start).T) < spacing
    which, start = which[close], start[close]
    t, each = start, landscapes.of(which)
    for _ in range(20):
        step = each.newton_step(t)
        t = t + step
    # a last step below this changes energies by at most its square
    near = (np.abs(step) < 1e-6).all(-1) & (np.abs(t - start) < 4.0 * spacing).all(-1)
    which, t = which[near], t[near]
    kind = 3 * which + (landscapes.of(which).local(t).curvatures > 0.0).sum(-1)
    groups = (np.flatnonzero(kind == each) for each in np.unique(kind))
    distinct = np.concatenate([which[:0], *(group[np.unique(_same(t[group]))] for group in groups)])
    return which[distinct], t[distinct]


def _same(points: Array) -> Whole:
    """For each of the points (m, 2) the number of the first that is the same but for whole periods."""
    apart = points[:, None] - points
    near = np.abs(apart - _TURN * np.rint(apart / _TURN)) < _SAME
    return np.asarray(near.all(-1).argmax(1))


def _over_saddles(landscape: _Landscapes, tops: Array, feet: Array) -> LowestBarrier:
    """The lowest barrier of one landscape with saddles (m, 2) that fall to minima (2, m, 2) on their two sides."""
    (sizes,), (scale,) = landscape.sizes, landscape.scale
    # without the waves that are smaller than the largest one there is no barrier
    flat = LowestBarrier(0.0, -sizes.sum() * scale, np.zeros(2), np.zeros(2))
    if not len(tops):
        return flat
    minima = feet.reshape(-1, 2)
    levels, energies = landscape.energy(tops), landscape.energy(minima)
    first = _same(minima)
    copy = np.rint((minima - minima[first]) / _TURN).astype(int) % 2 @ [1, 2]
    distinct, kind = np.unique(first, return_inverse=True)
    (near, far), apart = kind.reshape(2, -1), np.bitwise_xor(*copy.reshape(2, -1))
    # the energy at which two of the minima's four copies are joined, first by one saddle, then over all ways
    count = distinct.size
    joined = np.full((4 * count, 4 * count), np.inf)
    for shift in range(4):
        np.minimum.at(joined, (shift * count + near, (shift ^ apart) * count + far), levels)
    joined = np.minimum(joined, joined.T)
    for through in range(len(joined)):
        joined = np.minimum(joined, np.maximum(joined[:, [through]], joined[through]))
    depth = energies.min()
    lowest = np.flatnonzero(energies[distinct] <= depth + _NOTHING)
    climb = joined[lowest[:, None], lowest[:, None] + count * np.array([1, 2, 3])].min()
    if climb == np.inf:
        return flat
    top, minimum = tops[np.flatnonzero(levels == climb)[0]], minima[energies.argmin()]
    return LowestBarrier(max(climb - depth, 0.0) * scale, depth * scale, minimum, top)
