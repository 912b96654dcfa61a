"""The lowest barrier on the way from the lowest minimum of a periodic landscape to a copy of it.

Newton's method finds all points of a cell where the gradient vanishes; on a torus there are as many saddles as minima
and maxima together, which shows whether some are missing. From each saddle the landscape falls to a minimum on both
sides. The minima are then joined over the saddles in order of rising energy, on a torus of twice the period in both
directions: the barrier is the first energy at which the lowest minimum meets one of its copies, as a region that winds
round the first torus holds a loop that winds an odd number of times in one direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

Whole = npt.NDArray[np.intp]
Complex = npt.NDArray[np.complex128]

_TURN = 2.0 * np.pi
_PER_WAVE = 16  # grid nodes per oscillation: enough to find each critical point from several nodes
_MOST_NODES = 160  # along each direction of the first grid
_ORIGIN = (0.012345, 0.00789)  # radians: no node falls on a line of symmetry
_AT_ONCE = 1 << 20  # nodes times waves of the landscapes computed at once, to limit memory
_NOTHING = 1e-13  # of the largest wave: smaller waves count as 0; also the rounding of an energy
_SAME = 1e-4  # radians: critical points of one kind closer than this are one
_UNSURE = 1e-3  # of the largest wave: the error where critical points may be missing


class Climb(NamedTuple):
    """Barriers, their errors and the energies of the lowest minima, shape (landscapes,), and the places of minimum and
    saddle, shape (landscapes, 2), radians; of one landscape without the first axis."""

    barrier: Array
    error: Array
    depth: Array
    minimum: Array
    saddle: Array


def lowest_saddles(indices: npt.ArrayLike, amplitudes: Complex) -> Climb:
    """Barriers of U(t) = Re sum_n c_n exp(i K_n·t), t in radians, of period 2 pi in both directions.

    K are whole numbers, shape (n, 2); c energies, shape (landscapes, n). Barriers are known to about
    1e-12 of the largest wave where all critical points are found. Where some are missing on the finest grid, as in
    valleys that are flat within rounding, `error` is 1e-3 of it, or the sum of all smaller waves.
    """
    waves, sizes = np.asarray(indices, dtype=float), np.abs(amplitudes)
    scale = sizes.max(-1)
    sizes = sizes / np.where(scale > 0.0, scale, 1.0)[:, None]
    sizes[sizes <= _NOTHING] = 0.0
    phases = np.angle(amplitudes)
    curvature = sizes @ (waves**2).sum(-1) / np.maximum(sizes.sum(-1), 1e-300)
    nodes = int(np.clip(np.ceil(_PER_WAVE * np.sqrt(curvature.max())), 16, _MOST_NODES))
    found: dict[int, Climb] = {}
    for n in (nodes, 2 * nodes, 4 * nodes):
        few = max(1, _AT_ONCE // (n * n * len(waves)))
        rest = [k for k in range(len(sizes)) if k not in found or found[k].error > 0.0]
        for some in (rest[first : first + few] for first in range(0, len(rest), few)):
            land = _Landscapes(waves, sizes[some], phases[some])
            found |= zip(some, _on_grid(land, n), strict=True)
    columns = zip(*(found[k] for k in range(len(sizes))), strict=True)
    barrier, error, depth, minimum, saddle = (np.array(column) for column in columns)
    error += 6.0 * _NOTHING * len(waves)
    return Climb(barrier * scale, error * scale, depth * scale, minimum, saddle)


class _Local(NamedTuple):
    """Slopes and curvatures (m, 2) along the principal directions, rows (m, 2, 2), that of greatest curvature first."""

    slopes: Array
    curvatures: Array
    directions: Array


@dataclass(frozen=True)
class _Landscapes:
    """U(t) = sum_n sizes_n cos(K_n·t + phases_n): K of shape (n, 2), the others (landscapes, n)."""

    waves: Array
    sizes: Array
    phases: Array

    def energy(self, which: Whole, t: Array) -> Array:
        """U of the landscapes `which` (m,) at t (m, 2)."""
        return (self.sizes[which] * np.cos(t @ self.waves.T + self.phases[which])).sum(-1)

    def local(self, which: Whole, t: Array) -> _Local:
        """Slopes and curvatures of the landscapes `which` (m,) at t (m, 2)."""
        angle, size = t @ self.waves.T + self.phases[which], self.sizes[which]
        cos, sin = size * np.cos(angle), size * np.sin(angle)
        k, m = self.waves.T
        turn = 0.5 * np.arctan2(-(cos @ (2.0 * k * m)), -(cos @ (k * k - m * m)))
        first = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        directions = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=-1)], axis=1)
        # summed wave by wave, so that small waves keep their digits where the large ones are flat
        along = directions @ self.waves.T
        slopes = -np.einsum("mkn,mn->mk", along, sin)
        curvatures = -np.einsum("mkn,mn->mk", along * along, cos)
        rounding = 4e-15 * np.einsum("mkn,mn->mk", np.abs(along), size)
        slopes[np.abs(slopes) <= rounding] = 0.0
        return _Local(slopes, np.where(curvatures == 0.0, 1e-15, curvatures), directions)

    def newton_step(self, which: Whole, t: Array, down: bool = False) -> Array:
        """Newton's step from t to a critical point, shape (m, 2), or one that leads `down`; at most half a radian of
        the fastest wave."""
        slopes, curvatures, directions = self.local(which, t)
        lengths = -slopes / (np.abs(curvatures) if down else curvatures)
        step = np.einsum("mk,mkd->md", lengths, directions)
        fastest = np.abs(step @ self.waves.T).max(-1)
        return step * np.minimum(1.0, 0.5 / np.maximum(fastest, 1e-300))[:, None]


def _on_grid(land: _Landscapes, n: int) -> list[Climb]:
    """The climb of each landscape, from critical points near the nodes of a grid of n x n; the error is 0 where all
    of these are found."""
    owner, points = _critical_points(land, n)
    _, curvatures, directions = land.local(owner, points)
    saddle = (curvatures > 0.0).sum(-1) == 1
    tops, downhill = points[saddle], 1e-3 * directions[saddle, 1]
    sides = np.concatenate([tops + downhill, tops - downhill])
    feet = _descended(land, np.tile(owner[saddle], 2), sides).reshape(2, -1, 2)
    levels = land.energy(owner[saddle], tops)
    energies = land.energy(np.tile(owner[saddle], 2), feet.reshape(-1, 2)).reshape(2, -1)
    out = []
    for number, sizes in enumerate(land.sizes):
        own, smaller = owner[saddle] == number, sizes.sum() - sizes.max()
        # without the waves that are smaller than the largest one there is no barrier
        climb = Climb(np.zeros(()), 2.0 * smaller, -sizes.sum(), *np.zeros((2, 2)))
        if own.any():
            climb = _lowest_way(tops[own], levels[own], feet[:, own], energies[:, own]) or climb
        if 2 * np.count_nonzero(own) != np.count_nonzero(owner == number):
            unsure = np.minimum(_UNSURE, 2.0 * smaller)
            climb = climb._replace(error=np.maximum(climb.error, unsure))
        out.append(climb)
    return out


def _critical_points(land: _Landscapes, n: int) -> tuple[Whole, Array]:
    """Landscape and place of the critical points that Newton's method finds near nodes, each once."""
    spacing = _TURN / n
    places = spacing * np.stack(np.divmod(np.arange(n * n), n), axis=-1) + _ORIGIN
    which = np.repeat(np.arange(len(land.sizes)), n * n)
    start = np.tile(places, (len(land.sizes), 1))
    close = np.hypot(*land.newton_step(which, start).T) < spacing
    which, start = which[close], start[close]
    t = start
    for _ in range(20):
        step = land.newton_step(which, t)
        t = t + step
    # a last step below this changes energies by at most its square
    found = (np.abs(step) < 1e-6).all(-1) & (np.abs(t - start) < 4.0 * spacing).all(-1)
    which, t = which[found], t[found]
    kind = 3 * which + (land.local(which, t).curvatures > 0.0).sum(-1)
    groups = (np.flatnonzero(kind == each) for each in np.unique(kind))
    distinct = np.concatenate([which[:0], *(own[np.unique(_same(t[own]))] for own in groups)])
    return which[distinct], t[distinct]


def _same(points: Array) -> npt.NDArray[np.intp]:
    """For each of the points (m, 2) the number of the first that is the same but for whole periods."""
    apart = points[:, None] - points
    near = np.abs(apart - _TURN * np.rint(apart / _TURN)) < _SAME
    return np.asarray(near.all(-1).argmax(1))


def _descended(land: _Landscapes, which: Whole, t: Array) -> Array:
    """The minima to which the landscapes `which` fall from t; steps that would lead up are shortened."""
    trust, energy = np.ones((which.size, 1)), land.energy(which, t)
    for _ in range(400):
        step = trust * land.newton_step(which, t, down=True)
        level = land.energy(which, t + step)
        lower = (level <= energy + 1e-15)[:, None]
        t, energy = np.where(lower, t + step, t), np.where(lower[:, 0], level, energy)
        trust = np.where(lower, np.minimum(2.0 * trust, 1.0), 0.25 * trust)
        if (np.abs(step) < 1e-9).all():
            break
    return t


def _lowest_way(tops: Array, levels: Array, feet: Array, energies: Array) -> Climb | None:
    """The climb of one landscape over saddles (m, 2) of energies (m,) that fall to minima (2, m, 2) of energies (2, m)
    on their two sides; None where they lead to no copy of the lowest."""
    minima, energies = feet.reshape(-1, 2), energies.ravel()
    first = _same(minima)
    copy = np.rint((minima - minima[first]) / _TURN).astype(int) % 2 @ [1, 2]
    distinct, kind = np.unique(first, return_inverse=True)
    (one, other), apart = kind.reshape(2, -1), np.bitwise_xor(*copy.reshape(2, -1))
    # the energy at which two of the minima's four copies are joined, first by one saddle, then over all ways
    count = distinct.size
    joined = np.full((4 * count, 4 * count), np.inf)
    for shift in range(4):
        np.minimum.at(joined, (shift * count + one, (shift ^ apart) * count + other), levels)
    joined = np.minimum(joined, joined.T)
    for through in range(len(joined)):
        joined = np.minimum(joined, np.maximum(joined[:, [through]], joined[through]))
    depth = energies.min()
    lowest = np.flatnonzero(energies[distinct] <= depth + _NOTHING)
    level = joined[lowest[:, None], lowest[:, None] + count * np.array([1, 2, 3])].min()
    if level == np.inf:
        return None
    height, top = np.maximum(level - depth, 0.0), np.flatnonzero(levels == level)[0]
    return Climb(height, np.zeros(()), depth, minima[energies.argmin()], tops[top])
