"""The lowest barrier on the way from the lowest minimum of a periodic landscape to a copy of it.

A triangulated grid shows all minima, and all saddles with the minima on their two sides. Newton's method moves both to
where the gradient vanishes. The minima are then joined over the saddles in order of rising energy, on a torus of twice
the period in both directions: the barrier is the first energy at which the lowest minimum meets one of its copies, as
a region that winds round the first torus holds a loop that winds an odd number of times in one direction.
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
_PER_WAVE = 16  # grid nodes per oscillation: enough to separate neighbouring basins
_MOST_NODES = 160  # along each direction of the first grid
_FINER = (1, 2, 4)  # grids tried until Newton's method finds the saddle beside its node
_ORIGIN = (0.012345, 0.00789)  # radians: no node falls on a line of symmetry
_TOGETHER = 64  # landscapes computed at once, to stay in the cache
_NOTHING = 1e-13  # of the largest wave: smaller waves count as 0; also the rounding of an energy
# the neighbours of a node on a triangulated grid, in order around it
_RING = ((1, 0), (1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1))


class Climbs(NamedTuple):
    """Barriers, their errors, and the energies of the lowest minima, shape (landscapes,);
    positions of minimum and saddle, shape (landscapes, 2), radians."""

    barriers: Array
    errors: Array
    depths: Array
    minima: Array
    saddles: Array


def lowest_saddles(indices: npt.ArrayLike, amplitudes: Complex) -> Climbs:
    """Barriers of U(t) = Re sum_n c_n exp(i K_n·t), t in radians, of period 2 pi in both directions.

    K are whole numbers, shape (n, 2); c energies, shape (landscapes, n). Barriers are known to about
    1e-13 of the largest wave where Newton's method finds the saddle and all minima below it. Where it
    finds none near a node of the finest grid, as in narrow valleys or valleys that are flat within
    rounding, `errors` holds the error of the grid.
    """
    waves, sizes = np.asarray(indices, dtype=float), np.abs(amplitudes)
    scale = sizes.max(-1)
    sizes = sizes / np.where(scale > 0.0, scale, 1.0)[:, None]
    sizes[sizes <= _NOTHING] = 0.0
    # mirror landscapes so that the grid's diagonals run along the valleys of the largest oblique wave
    oblique = waves[:, 0] * waves[:, 1]
    turned = oblique[(sizes * (oblique != 0.0)).argmax(-1)] > 0.0
    out = np.empty((len(sizes), 7))
    for mirror, own in ((1.0, np.flatnonzero(~turned)), (-1.0, np.flatnonzero(turned))):
        land = _Landscapes(waves * [1.0, mirror], sizes, np.angle(amplitudes))
        for first in range(0, own.size, _TOGETHER):
            some = own[first : first + _TOGETHER]
            out[some] = _searched(land.only(some))
        out[own, 4::2] *= mirror
    out[:, 1] += 2.0 * _NOTHING * len(waves)
    out[:, :3] *= scale[:, None]
    return Climbs(out[:, 0], out[:, 1], out[:, 2], out[:, 3:5], out[:, 5:])


@dataclass(frozen=True)
class _Landscapes:
    """U(t) = sum_n sizes_n cos(K_n·t + phases_n): K of shape (n, 2), the others (landscapes, n)."""

    waves: Array
    sizes: Array
    phases: Array

    def only(self, some: Whole) -> _Landscapes:
        return _Landscapes(self.waves, self.sizes[some], self.phases[some])

    def energy(self, which: Whole, t: Array) -> Array:
        """U of the landscapes `which` (m,) at t (m, 2)."""
        return (self.sizes[which] * np.cos(t @ self.waves.T + self.phases[which])).sum(-1)

    def newton_step(self, which: Whole, t: Array, to_saddle: bool) -> Array:
        """The step from t towards the nearest minimum, or the nearest saddle, shape (m, 2).

        Curvatures are replaced by their absolute values, so that the step leads down; towards a saddle it
        leads up along the direction of least curvature.
        """
        angle, size = t @ self.waves.T + self.phases[which], self.sizes[which]
        cos, sin = size * np.cos(angle), size * np.sin(angle)
        k, m = self.waves.T
        turn = 0.5 * np.arctan2(-(cos @ (2.0 * k * m)), -(cos @ (k * k - m * m)))
        # the direction of greatest curvature comes first
        first = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        directions = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=-1)], axis=1)
        # summed wave by wave, so that small waves keep their digits where the large ones are flat
        along = directions @ self.waves.T
        slopes = -np.einsum("mkn,mn->mk", along, sin)
        curvatures = -np.einsum("mkn,mn->mk", along * along, cos)
        rounding = 4e-15 * np.einsum("mkn,mn->mk", np.abs(along), size)
        slopes[np.abs(slopes) <= rounding] = 0.0
        lengths = -slopes / np.maximum(np.abs(curvatures), 1e-15)
        if to_saddle:
            lengths[:, 1] *= -1.0
        step = np.einsum("mk,mkd->md", lengths, directions)
        # at most half a radian of the fastest wave
        fastest = np.abs(step @ self.waves.T).max(-1)
        return step * np.minimum(1.0, 0.5 / np.maximum(fastest, 1e-300))[:, None]


def _searched(land: _Landscapes) -> Array:
    """Rows of barrier, error, depth, minimum and saddle; grids are refined until Newton's method succeeds."""
    strength = land.sizes @ (land.waves**2).sum(-1)
    total = np.maximum(land.sizes.sum(-1), 1e-300)
    nodes = int(np.clip(np.ceil(_PER_WAVE * np.sqrt((strength / total).max())), 16, _MOST_NODES))
    out, left = np.empty((len(total), 7)), np.arange(len(total))
    for n in (finer * nodes for finer in _FINER):
        out[left] = _on_grid(land.only(left), n, 2.0 * _TURN / nodes)
        # the saddle is within half a diagonal of its node: U changes at most by this
        off = out[left, 1] > 0.0
        out[left, 1] = off * 0.25 * strength[left] * (_TURN / n) ** 2 + 4.0 * _NOTHING * total[left]
        left = left[off]
        if not left.size:
            break
    return out


def _on_grid(land: _Landscapes, n: int, astray: float) -> Array:
    """The rows of _searched from a grid of n x n nodes, with error 0 where Newton's method succeeded, else 1.

    A point farther than `astray` (radians) from its node is another one and is not accepted.
    """
    count, node = len(land.sizes), np.arange(n * n)
    i, j = np.divmod(node, n)
    places = _TURN / n * np.stack([i, j], axis=-1) + _ORIGIN
    heights = np.exp(1j * (places @ land.waves.T)) @ (land.sizes * np.exp(1j * land.phases)).T
    # ranks in place of heights: no two nodes have equal ranks
    order = np.argsort(heights.real.T, axis=-1, kind="stable")
    ranks = np.argsort(order, axis=-1)
    # of each neighbour: its number, whether periods are crossed on the way (bits of i and j), whether it is lower
    to = np.array([(i + di) % n * n + (j + dj) % n for di, dj in _RING])
    crossed = np.array([(i + di) // n % 2 + (j + dj) // n % 2 * 2 for di, dj in _RING])
    beside = ranks[:, to]
    lower = beside < ranks[:, None]
    # the minimum below each node by steepest descent, and the periods crossed on the way
    steepest, falls = beside.argmin(1), lower.any(1)
    target = np.where(falls, to[steepest, node], node)
    copy = np.where(falls, crossed[steepest, node], 0)
    while True:
        further = np.take_along_axis(target, target, 1)
        if (further == target).all():
            break
        copy, target = copy ^ np.take_along_axis(copy, target, 1), further
    # below a saddle the ring of neighbours falls into two parts or more
    parts = (lower & ~np.roll(lower, 1, axis=1)).transpose(0, 2, 1)
    which, top, way = np.nonzero(parts & (parts.sum(-1) > 1)[..., None])
    foot = to[way, top]
    basin, side = target[which, foot], crossed[way, top] ^ copy[which, foot]
    pair = np.flatnonzero((which[1:] == which[:-1]) & (top[1:] == top[:-1]))
    one, other, apart = basin[pair], basin[pair + 1], side[pair] ^ side[pair + 1]
    owner, ground = np.nonzero(target == node)
    low = _polished(land, owner, places[ground], astray, to_saddle=False)
    peak = _polished(land, which[pair], places[top[pair]], astray, to_saddle=True)
    # a minimum that only the grid shows, in a narrow oblique valley, may appear to lie above a saddle
    certain = np.full(target.shape, -np.inf)
    certain[owner, ground] = np.where(low.found, low.energies, -np.inf)
    over = which[pair]
    levels = np.maximum(peak.energies, np.maximum(certain[over, one], certain[over, other]))
    out = np.empty((count, 7))
    for number in range(count):
        mine, ways = np.flatnonzero(owner == number), np.flatnonzero(over == number)
        energies = low.energies[mine]
        lowest = mine[energies.argmin()]
        starts = ground[mine[energies <= energies.min() + _NOTHING]].tolist()
        ways = ways[np.argsort(levels[ways], kind="stable")]
        first = _first_loop(starts, np.stack([one, other, apart], axis=-1)[ways].tolist())
        deciding = ways[first]
        # minima that only the grid shows indicate valleys too narrow for it
        narrow = ~low.found[mine] & (energies < levels[deciding])
        depth = low.energies[lowest]
        climb = max(levels[deciding] - depth, 0.0)
        error = float(narrow.any() or not peak.found[deciding])
        out[number] = climb, error, depth, *low.places[lowest], *peak.places[deciding]
    return out


class _Points(NamedTuple):
    """Minima or saddles: energies, places, and whether Newton's method found them."""

    energies: Array
    places: Array
    found: npt.NDArray[np.bool_]


def _polished(
    land: _Landscapes, which: Whole, start: Array, astray: float, to_saddle: bool
) -> _Points:
    """The critical points of the landscapes `which` near `start`, or `start` itself where there is none."""
    t, active = start.copy(), np.arange(which.size)
    found = np.zeros(which.size, dtype=bool)
    for _ in range(80):  # at a quartic minimum each step reduces the distance by a third
        step = land.newton_step(which[active], t[active], to_saddle)
        t[active] += step
        # a last step below this changes energies by at most its square
        found[active] = (np.abs(step) < 1e-6).all(-1)
        moving = (np.abs(step) > 1e-14).any(-1)
        active = active[moving & (np.abs(t[active] - start[active]) <= astray).all(-1)]
        if not active.size:
            break
    found &= (np.abs(t - start) <= astray).all(-1)
    t = np.where(found[:, None], t, start)
    return _Points(land.energy(which, t), t, found)


def _first_loop(starts: list[int], ways: list[list[int]]) -> int:
    """The first of the ways (one minimum, another, periods crossed between) after which one of `starts` meets a copy.

    Minima have four copies on the torus of twice the period, 0 to 3.
    """
    parent: dict[tuple[int, int], tuple[int, int]] = {}

    def root(point: tuple[int, int]) -> tuple[int, int]:
        while point in parent:
            point = parent[point]
        return point

    for number, (one, other, apart) in enumerate(ways):
        for copy in range(4):
            a, b = root((one, copy)), root((other, copy ^ apart))
            if a != b:
                parent[b] = a
        if any(root((start, 0)) == root((start, copy)) for start in starts for copy in (1, 2, 3)):
            return number
    raise RuntimeError("no path leads round a landscape: a defect of this program")
