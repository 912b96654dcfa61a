"""The lowest barrier on the way from the lowest minimum of a periodic landscape to a copy of it.

A triangulated grid shows all minima, and all saddles with the minima on their two sides. Newton's
method moves both to where the gradient vanishes. The minima are then joined over the saddles in order
of rising energy: the barrier is the first energy at which the region around the lowest minimum winds
round the torus.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

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
_NEWTON_STEPS = 80  # at a quartic minimum each reduces the distance by a third
_LONGEST = 0.5  # longest Newton step, radians of the fastest wave
_ARRIVED = 1e-6  # radians: a last step below this changes energies by at most its square
_TOGETHER = 64  # landscapes computed at once, to stay in the cache
_NOTHING = 1e-13  # of the largest wave: smaller waves count as 0; also the rounding of an energy
_NOISE = 4e-15  # rounding of a slope, relative to the sum of the waves in it
# the neighbours of a node on a triangulated grid, in order around it
_RING = ((1, 0), (1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1))


@dataclass(frozen=True)
class Climbs:
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
        for some in np.split(own, range(_TOGETHER, own.size, _TOGETHER)):
            if some.size:
                phases = np.angle(amplitudes[some])
                out[some] = _searched(_Landscapes(waves * [1.0, mirror], sizes[some], phases))
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
        slopes[np.abs(slopes) <= _NOISE * np.einsum("mkn,mn->mk", np.abs(along), size)] = 0.0
        lengths = -slopes / np.maximum(np.abs(curvatures), 1e-15)
        if to_saddle:
            lengths[:, 1] *= -1.0
        step = np.einsum("mk,mkd->md", lengths, directions)
        fastest = np.abs(step @ self.waves.T).max(-1)
        return step * np.minimum(1.0, _LONGEST / np.maximum(fastest, 1e-300))[:, None]


@dataclass(frozen=True)
class _Points:
    """Minima or saddles of all landscapes: energies, places, and whether Newton's method found them."""

    energies: Array
    places: Array
    found: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class _Ways:
    """Ways over the saddle node `top`: from minimum `one` to the copy of `other`, `shift` periods away."""

    one: Whole
    other: Whole
    shift: Whole
    top: Whole


def _searched(land: _Landscapes) -> Array:
    """Rows of barrier, error, depth, minimum and saddle; grids are refined until Newton's method succeeds."""
    strength = land.sizes @ (land.waves**2).sum(-1)
    total = np.maximum(land.sizes.sum(-1), 1e-300)
    nodes = int(np.clip(np.ceil(_PER_WAVE * np.sqrt((strength / total).max())), 16, _MOST_NODES))
    out, left = np.empty((len(total), 7)), np.arange(len(total))
    for n in (finer * nodes for finer in _FINER):
        some = _Landscapes(land.waves, land.sizes[left], land.phases[left])
        out[left] = _on_grid(some, n, 2.0 * _TURN / nodes)
        # the saddle is within half a diagonal of its node: U changes at most by this
        off = out[left, 1] > 0.0
        out[left, 1] = off * 0.25 * strength[left] * (_TURN / n) ** 2 + 4.0 * _NOTHING * total[left]
        left = left[off]
        if not left.size:
            break
    # where all waves are parallel the barrier along the valleys is 0
    first = land.waves[land.sizes.argmax(-1)]
    across = first[:, :1] * land.waves[:, 1] - first[:, 1:] * land.waves[:, 0]
    level = ~((across != 0.0) & (land.sizes > 0.0)).any(-1)
    out[level, :2], out[level, 5:] = 0.0, out[level, 3:5]
    return out


def _on_grid(land: _Landscapes, n: int, astray: float) -> Array:
    """The rows of _searched from a grid of n x n nodes, with error 0 where Newton's method succeeded, else 1.

    A point farther than `astray` (radians) from its node is another one and is not accepted.
    """
    count = len(land.sizes)
    axes = [_TURN * np.arange(n) / n + start for start in _ORIGIN]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    waves = np.exp(1j * (nodes @ land.waves.T))
    heights = (waves @ (land.sizes * np.exp(1j * land.phases)).T).real.T
    # ranks in place of heights: no two nodes have equal ranks
    ranks = np.argsort(np.argsort(heights, axis=-1, kind="stable"), axis=-1).reshape(count, n, n)
    minima, ways = _ways(ranks)
    low = _polished(land, nodes, heights, minima, astray, to_saddle=False)
    top = _polished(land, nodes, heights, ways.top, astray, to_saddle=True)
    # a minimum that only the grid shows, in a narrow oblique valley, may appear to lie above a saddle
    certain = np.where(low.found, low.energies, -np.inf)
    levels = np.maximum(top.energies, np.maximum(certain[ways.one], certain[ways.other]))
    out = []
    # both are sorted by landscape
    firsts = np.searchsorted(minima // (n * n), np.arange(count + 1))
    bounds = np.searchsorted(ways.top // (n * n), np.arange(count + 1))
    for _k, (mine, over) in enumerate(zip(pairwise(firsts), pairwise(bounds), strict=True)):
        energies = low.energies[slice(*mine)]
        lowest = mine[0] + int(energies.argmin())
        ground = mine[0] + np.flatnonzero(energies <= energies.min() + _NOTHING)
        order = over[0] + np.argsort(levels[slice(*over)], kind="stable")
        deciding = _first_loop(ways, order, ground.tolist())
        # minima that only the grid shows indicate valleys too narrow for it
        narrow = ~low.found[slice(*mine)] & (energies < levels[deciding])
        error, depth = float(narrow.any() or not top.found[deciding]), low.energies[lowest]
        climb = max(levels[deciding] - depth, 0.0)
        out.append([climb, error, depth, *low.places[lowest], *top.places[deciding]])
    return np.array(out)


def _ways(ranks: Whole) -> tuple[Whole, _Ways]:
    """The nodes (numbers in the flat array) that are minima, and the ways over all saddle nodes.

    ranks has shape (m, n, n). Below a saddle the ring of neighbours falls into two parts or more.
    """
    n = ranks.shape[-1]
    flat = np.arange(ranks.size).reshape(ranks.shape)
    beside = np.stack([_moved(ranks, step) for step in _RING])
    to = np.stack([_moved(flat, step) for step in _RING])
    crossed = np.stack([_crossed(n, step) for step in _RING])
    # the minimum below each node by steepest descent, and the periods crossed on the way
    steepest = beside.argmin(0)[None]
    down = np.take_along_axis(beside, steepest, 0)[0] < ranks
    target = np.where(down, np.take_along_axis(to, steepest, 0)[0], flat).ravel()
    i, j = np.indices(ranks.shape[1:])
    shift = (crossed[steepest[0], i, j] * down[..., None]).reshape(-1, 2)
    while True:
        further = target[target]
        if (further == target).all():
            break
        shift, target = shift + shift[target], further
    minima, number = np.unique(target, return_inverse=True)
    lower = beside < ranks
    begins = (lower & ~np.roll(lower, 1, axis=0)).reshape(len(_RING), -1)
    top, way = np.nonzero(begins.T & (begins.sum(0) > 1)[:, None])
    foot = to.reshape(len(_RING), -1)[way, top]
    periods = crossed.reshape(len(_RING), -1, 2)[way, top % (n * n)] + shift[foot]
    # pairs of neighbouring parts of the same saddle's ring
    pair = np.flatnonzero(top[1:] == top[:-1])
    basin = number.ravel()[foot]
    return minima, _Ways(basin[pair], basin[pair + 1], periods[pair + 1] - periods[pair], top[pair])


def _moved(grid: Whole, step: tuple[int, int]) -> Whole:
    """At each node the value `step` nodes further on."""
    return np.roll(grid, (-step[0], -step[1]), axis=(1, 2))


def _crossed(n: int, step: tuple[int, int]) -> Whole:
    """Periods that a step from each node of the grid crosses, shape (n, n, 2)."""
    along, across = ((np.arange(n) + s) // n for s in step)
    return np.stack(np.broadcast_arrays(along[:, None], across[None, :]), axis=-1)


def _polished(
    land: _Landscapes, nodes: Array, heights: Array, flat: Whole, astray: float, to_saddle: bool
) -> _Points:
    """The critical points beside nodes, or the nodes themselves where there is none."""
    which, node = np.divmod(flat, len(nodes))
    start = nodes[node]
    t, active = start.copy(), np.arange(flat.size)
    found = np.zeros(flat.size, dtype=bool)
    for _ in range(_NEWTON_STEPS):
        step = land.newton_step(which[active], t[active], to_saddle)
        t[active] += step
        found[active] = (np.abs(step) < _ARRIVED).all(-1)
        moving = (np.abs(step) > 1e-14).any(-1)
        active = active[moving & (np.abs(t[active] - start[active]) <= astray).all(-1)]
        if not active.size:
            break
    found &= (np.abs(t - start) <= astray).all(-1)
    t = np.where(found[:, None], t, start)
    return _Points(np.where(found, land.energy(which, t), heights.ravel()[flat]), t, found)


def _first_loop(ways: _Ways, order: Whole, ground: list[int]) -> int:
    """Number of the first way, in `order`, that makes the region around a minimum in `ground` wind round the torus."""
    parent: dict[int, int] = {}
    offset: dict[int, tuple[int, int]] = {}  # periods from a minimum to its parent's copy
    winding: set[int] = set()

    def root(i: int) -> tuple[int, int, int]:
        x = y = 0
        while i in parent:
            x, y = x + offset[i][0], y + offset[i][1]
            i = parent[i]
        return i, x, y

    for number in order.tolist():
        a, ax, ay = root(int(ways.one[number]))
        b, bx, by = root(int(ways.other[number]))
        along, across = ways.shift[number].tolist()
        # periods from the root of `one`, over this way, to the root of `other`
        x, y = along + bx - ax, across + by - ay
        if a != b:
            parent[b], offset[b] = a, (-x, -y)
            if b in winding:
                winding.add(a)
        elif x or y:
            winding.add(a)
        if winding and any(root(g)[0] in winding for g in ground):
            return number
    raise RuntimeError("no path leads round a landscape: a defect of this program")
