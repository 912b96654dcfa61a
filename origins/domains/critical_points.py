"""All points where a periodic landscape is level, found by exclusion, each to the last bit.

A landscape is U(t) = sum_n a_n cos(K_n·t + p_n) on the torus 0 <= t_1, t_2 < 2 pi, K_n whole numbers. Its
derivatives are bounded by sums of a_n |K_n|^m, so a box is dropped where its gradient cannot vanish, handed to
Newton's method where it holds one root at most, and quartered otherwise. Many landscapes are worked on at once.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import InputError
from origins.thresholds.law import Array

Whole = npt.NDArray[np.intp]

_ORIGIN = (0.1234567, 0.3456789)  # off the points where symmetric landscapes have their extrema
_FIRST_BOXES = 8  # along each axis and for each oscillation
_SMALLEST = 2e-5
_MOST_BOXES = 20_000  # of one landscape, for each oscillation
_BATCH = 1 << 15
_CERTAIN = 0.25  # how far the gradient may be from linear in a box of one root at most
_NEWTON_STEPS = 12


@dataclass(frozen=True)
class Landscapes:
    """U_l(t) = sum_n a_ln cos(K_n·t + p_ln): waves K of shape (n, 2), a and p of shape (landscapes, n)."""

    waves: Array
    sizes: Array
    phases: Array

    def energy(self, which: Whole, t: Array) -> Array:
        """U of landscape which[m] at t[m]; t of shape (m, 2)."""
        return (self.sizes[which] * np.cos(t @ self.waves.T + self.phases[which])).sum(-1)

    def frame(self, which: Whole, t: Array) -> "Frame":
        """Gradient and curvatures at t along the principal directions."""
        angle = t @ self.waves.T + self.phases[which]
        size = self.sizes[which]
        cos, sin = size * np.cos(angle), size * np.sin(angle)
        k, m = self.waves.T
        turn = 0.5 * np.arctan2(-(cos @ (2.0 * k * m)), -(cos @ (k * k - m * m)))
        first = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        directions = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=-1)], axis=1)
        # wave by wave: a direction in which the large waves are flat keeps the digits of the small ones
        along = directions @ self.waves.T
        slopes = -np.einsum("mkn,mn->mk", along, sin)
        curvatures = -np.einsum("mkn,mn->mk", along * along, cos)
        return Frame(directions, np.abs(along), slopes, curvatures, size)


@dataclass(frozen=True)
class Frame:
    """At m points: directions (m, 2, 2), |K·direction| (m, 2, n), slopes and curvatures (m, 2), sizes (m, n)."""

    directions: Array
    along: Array
    slopes: Array
    curvatures: Array
    sizes: Array

    def newton_step(self) -> Array:
        """To where the gradient would vanish, shape (m, 2); nothing along a direction without curvature."""
        flat = self.curvatures == 0.0
        step = -np.where(flat, 0.0, self.slopes) / np.where(flat, 1.0, self.curvatures)
        return np.einsum("mk,mkd->md", step, self.directions)


@dataclass(frozen=True)
class CriticalPoints:
    """Points of all landscapes, shape (m,) but for t (m, 2) and curvatures (m, 2).

    radius is 0 for a regular point. Otherwise the point stands for a box of that half-width in which the gradient
    vanishes, or nearly so, and with it the curvature in one direction or both.
    """

    which: Whole
    t: Array
    radius: Array


def critical_points(land: Landscapes) -> CriticalPoints:
    """Every point with grad U = 0; one may be listed more than once where it lies between two boxes.

    Raises InputError where U is level along lines.
    """
    oscillations = int(np.abs(land.waves).max())
    count = _FIRST_BOXES * oscillations
    radius = np.pi / count
    axis = (2.0 * np.arange(count) + 1.0) * radius
    grid = np.stack(np.meshgrid(axis + _ORIGIN[0], axis + _ORIGIN[1]), axis=-1).reshape(-1, 2)
    which = np.repeat(np.arange(len(land.sizes)), len(grid))
    t = np.tile(grid, (len(land.sizes), 1))
    most = max(_MOST_BOXES * oscillations, 4 * len(grid))
    found = [(which[:0], t[:0], 0.0)]
    while which.size:
        roots, unclear = [], []
        for first in range(0, which.size, _BATCH):
            part = slice(first, first + _BATCH)
            some_roots, some_unclear = _sort_out(land, which[part], t[part], radius)
            roots.append(some_roots)
            unclear.append(some_unclear)
        found += [(*root, 0.0) for root in roots]
        which = np.concatenate([part[0] for part in unclear])
        t = np.concatenate([part[1] for part in unclear])
        if np.bincount(which).max(initial=0) > most:
            raise InputError(
                "substrate: the energy of this island is level along whole lines, not at points, where no saddle can "
                "be told; change an amplitude or the angle a little"
            )
        if radius < _SMALLEST:
            found.append((which, _onto_the_flat(land, which, t, radius), radius))
            break
        radius *= 0.5
        corners = radius * np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
        which, t = np.repeat(which, 4), (t[:, None] + corners).reshape(-1, 2)
    return CriticalPoints(
        np.concatenate([part[0] for part in found]),
        np.concatenate([part[1] for part in found]) % (2.0 * np.pi),
        np.concatenate([np.full(len(part[0]), part[2]) for part in found]),
    )


def _sort_out(
    land: Landscapes, which: Whole, t: Array, radius: float
) -> tuple[tuple[Whole, Array], tuple[Whole, Array]]:
    """Roots in boxes that hold one at most, and the boxes that may hold more."""
    frame = land.frame(which, t)
    reach = np.abs(land.waves).sum(-1)  # |K·s| <= reach * radius for all s in a box
    bend = np.einsum("mkn,mn->mk", frame.along, frame.sizes * reach * reach)
    width = np.abs(frame.directions).sum(-1)
    most = np.abs(frame.curvatures) * width * radius + 0.5 * bend * radius * radius
    kept = (np.abs(frame.slopes) <= most).all(-1)
    # by how much the gradient, divided by the curvatures, may stray from a straight line within the box
    twist = np.einsum("mkn,mn->mk", frame.along, frame.sizes * reach * frame.along.sum(1))
    single = kept & (twist * radius <= _CERTAIN * np.abs(frame.curvatures)).all(-1)
    unclear = kept & ~single
    return _newton(land, which[single], t[single], radius), (which[unclear], t[unclear])


def _newton(land: Landscapes, which: Whole, start: Array, radius: float) -> tuple[Whole, Array]:
    """The roots that lie in the boxes they are sought in."""
    t = start
    for _ in range(_NEWTON_STEPS):
        step = land.frame(which, t).newton_step()
        t = t + step
        near = (np.abs(t - start) <= 3.0 * radius).all(-1)
        if not near.all():
            which, start, t, step = which[near], start[near], t[near], step[near]
        if np.abs(step).max(initial=0.0) < 1e-15:
            break
    inside = (np.abs(t - start) <= radius * (1.0 + 1e-6)).all(-1) & (np.abs(step) < 1e-9).all(-1)
    return which[inside], t[inside]


def _onto_the_flat(land: Landscapes, which: Whole, start: Array, radius: float) -> Array:
    """Centres of boxes without curvature in one direction, moved to where the gradient vanishes in the other."""
    t = start
    for _ in range(_NEWTON_STEPS):
        frame = land.frame(which, t)
        curved = np.abs(frame.curvatures) > 20.0 * radius
        step = -np.where(curved, frame.slopes, 0.0) / np.where(curved, frame.curvatures, 1.0)
        t = t + np.einsum("mk,mkd->md", step, frame.directions)
    near = np.abs(t - start).max(-1, keepdims=True) <= 3.0 * radius
    return np.where(near, t, start)
