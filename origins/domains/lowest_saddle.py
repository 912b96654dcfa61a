"""How high a periodic landscape must be climbed to leave its lowest minimum for a copy of it.

A grid shows the basins of all minima and, between each two of them, where their common edge is lowest.
Newton's method moves minima and saddles from there to where the gradient vanishes. The minima are then
joined over their saddles by rising level (union-find with windings): the barrier is the first level
at which the region around the lowest minimum winds round the torus.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from origins.domains.landscapes import Landscapes, Whole
from origins.thresholds.law import Array

_TURN = 2.0 * np.pi
_PER_WAVE = 16  # grid nodes on an oscillation: they must tell each basin from the next
_MOST_NODES = 160  # along each direction of the first grid
_FINER = (1, 2, 4)  # grids tried until Newton's method finds the saddle beside its node
_ORIGIN = (0.012345, 0.00789)  # radians: no node falls on a line of symmetry
_NEWTON_STEPS = 80  # at a quartic minimum each takes a third of the distance
_APART = 4  # grid steps between two passes that lead the same way
_ARRIVED = 1e-6  # radians: a last step so short changes energies by its square, or less
_ASTRAY = 2.0  # steps of the first grid: Newton's method has found another point beyond
_TOGETHER = 64  # landscapes worked on at once, to stay in the cache
_SAME_LEVEL = 1e-13  # of the largest wave: rounding of an energy
_NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1), (-1, 0), (0, -1), (-1, -1), (-1, 1))


@dataclass(frozen=True)
class Climbs:
    """Barriers, how far each may be off, and the energies of the lowest minima, shape (landscapes,);
    where minimum and saddle are, shape (landscapes, 2), radians."""

    barriers: Array
    errors: Array
    depths: Array
    minima: Array
    saddles: Array


_NAMES = tuple(field.name for field in fields(Climbs))


@dataclass(frozen=True)
class _Points:
    """Minima or saddles of all landscapes: their energies, places, and whether Newton found them."""

    energies: Array
    places: Array
    found: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class _Passes:
    """Ways from minimum `one` to the copy of minimum `other` that is `shift` periods away."""

    one: Whole
    other: Whole
    shift: Whole
    top: Whole  # the highest node of the way


def lowest_saddles(land: Landscapes) -> Climbs:
    """The barriers of all landscapes.

    They are known to about 1e-13 of the largest wave where Newton's method finds the saddle. Where it
    finds none beside a node of the finest grid, as in valleys that are level within rounding, the level
    of the node is the answer, and `errors` holds what a grid may be off.
    """
    count = len(land.sizes)
    if count > _TOGETHER:
        parts = [
            lowest_saddles(Landscapes(land.waves, land.sizes[first:last], land.phases[first:last]))
            for first, last in pairwise([*range(0, count, _TOGETHER), count])
        ]
        return Climbs(*(np.concatenate([getattr(part, name) for part in parts]) for name in _NAMES))
    strength = land.sizes @ (land.waves**2).sum(-1)
    fastest = np.sqrt((strength / land.sizes.sum(-1)).max())
    nodes = int(np.clip(np.ceil(_PER_WAVE * fastest), _PER_WAVE, _MOST_NODES))
    rounding = 4.0 * _SAME_LEVEL * land.sizes.sum(-1)
    out = Climbs(*np.empty((3, count)), *np.empty((2, count, 2)))
    left = np.arange(count)
    for finer in _FINER:
        n = finer * nodes
        some = Landscapes(land.waves, land.sizes[left], land.phases[left])
        found = np.zeros(left.size, dtype=bool)
        part = _on_grid(some, n, _ASTRAY * _TURN / nodes, found)
        # half a diagonal from the saddle U may have risen by this
        part.errors[:] = rounding[left] + np.where(
            found, 0.0, 0.25 * strength[left] * (_TURN / n) ** 2
        )
        for name in _NAMES:
            getattr(out, name)[left] = getattr(part, name)
        left = left[~found]
        if not left.size:
            break
    return out


def lowest_of_parallel(land: Landscapes) -> Climbs:
    """The same where all waves are parallel: along the valleys there is nothing to climb."""
    which = np.arange(len(land.sizes))
    step = land.waves[0] / np.abs(land.waves[0]).max()
    line = (
        np.linspace(0.0, _TURN, 1 + round(4 * _PER_WAVE * np.abs(land.waves).max()))[:, None] * step
    )
    heights = np.stack([land.energy(which, np.broadcast_to(t, (which.size, 2))) for t in line])
    t = line[heights.argmin(0)]
    for _ in range(_NEWTON_STEPS):
        t = t + land.newton_step(which, t, to_saddle=False)
    zeros = np.zeros(which.size)
    return Climbs(zeros, zeros, land.energy(which, t), t, t)


def _on_grid(land: Landscapes, n: int, astray: float, found: npt.NDArray[np.bool_]) -> Climbs:
    """The barriers by a grid of n x n nodes; `found` becomes True where Newton's method made them exact."""
    count = len(land.sizes)
    axes = [_TURN * np.arange(n) / n + start for start in _ORIGIN]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    waves = np.exp(1j * (nodes @ land.waves.T))
    heights = (waves @ (land.sizes * np.exp(1j * land.phases)).T).real.T.reshape(count, n, n)
    basin, shift = _basins(heights)
    minima, number = np.unique(basin, return_inverse=True)
    ways = _passes(heights, number.reshape(basin.shape), shift)
    low = _polished(land, nodes, heights, minima, astray, to_saddle=False)
    top = _polished(land, nodes, heights, ways.top, astray, to_saddle=True)
    # a minimum that only the grid shows, in a narrow oblique valley, may seem to lie above a saddle
    certain = np.where(low.found, low.energies, -np.inf)
    levels = np.maximum(top.energies, np.maximum(certain[ways.one], certain[ways.other]))
    order = np.argsort(levels, kind="stable")
    # minima come sorted by landscape; so must the passes, by rising level in each
    owner = minima // (n * n)
    order = order[np.argsort(owner[ways.one[order]], kind="stable")]
    bounds = np.searchsorted(owner[ways.one[order]], np.arange(count + 1))
    firsts = np.searchsorted(owner, np.arange(count + 1))
    out = Climbs(*np.empty((3, count)), *np.empty((2, count, 2)))
    for k in range(count):
        mine = slice(firsts[k], firsts[k + 1])
        lowest = mine.start + int(low.energies[mine].argmin())
        ground = mine.start + np.flatnonzero(
            low.energies[mine] <= low.energies[lowest] + _SAME_LEVEL
        )
        deciding = _first_loop(ways, order[bounds[k] : bounds[k + 1]], ground.tolist())
        out.depths[k] = low.energies[lowest]
        out.barriers[k] = max(levels[deciding] - low.energies[lowest], 0.0)
        out.minima[k], out.saddles[k] = low.places[lowest], top.places[deciding]
        found[k] = bool(top.found[deciding] and low.found[lowest])
    return out


def _basins(heights: Array) -> tuple[Whole, Whole]:
    """The minimum each node leads down to: its number in the flat array, and the periods in between.

    heights has shape (m, n, n); the results (m, n, n) and (m, n, n, 2).
    """
    n = heights.shape[1]
    lowest = heights.copy()
    flat = np.arange(heights.size).reshape(heights.shape)
    leads, crossed = flat.copy(), np.zeros((*heights.shape, 2), dtype=np.intp)
    for step in _NEIGHBOURS:
        beside = _moved(heights, step)
        lower = beside < lowest
        lowest = np.where(lower, beside, lowest)
        leads = np.where(lower, _moved(flat, step), leads)
        crossed = np.where(lower[..., None], _crossed(n, step), crossed)
    target, shift = leads.reshape(-1), crossed.reshape(-1, 2)
    while True:
        further = target[target]
        if (further == target).all():
            return target.reshape(heights.shape), shift.reshape(*heights.shape, 2)
        shift = shift + shift[target]
        target = further


def _moved(grid: npt.NDArray, step: tuple[int, int]) -> npt.NDArray:
    """At each node what stands `step` nodes further on."""
    return np.roll(grid, (-step[0], -step[1]), axis=(1, 2))


def _crossed(n: int, step: tuple[int, int]) -> Whole:
    """Periods that a step from each node of the grid crosses, shape (n, n, 2)."""
    along, across = ((np.arange(n) + s) // n for s in step)
    return np.stack(np.broadcast_arrays(along[:, None], across[None, :]), axis=-1)


def _passes(heights: Array, basin: Whole, shift: Whole) -> _Passes:
    """The lowest way between each two basins, and the lowest one that lies apart from it."""
    n = heights.shape[1]
    flat = np.arange(heights.size).reshape(heights.shape)
    rows, tops, levels = [], [], []
    for step in _NEIGHBOURS[:4]:
        other = _moved(basin, step)
        periods = _crossed(n, step) + np.roll(shift, (-step[0], -step[1]), axis=(1, 2)) - shift
        edge = (other != basin) | periods.any(-1)
        # each way is listed in one direction: from the lower number, or towards the greater shift
        swap = (other < basin) | ((other == basin) & ((periods * [4 * n, 1]).sum(-1) < 0))
        periods = np.where(swap[..., None], -periods, periods)[edge]
        ends = np.where(swap, other, basin)[edge], np.where(swap, basin, other)[edge]
        rows.append(np.column_stack([*ends, periods]))
        beside = _moved(heights, step)
        tops.append(np.where(beside > heights, _moved(flat, step), flat)[edge])
        levels.append(np.maximum(beside, heights)[edge])
    ways, top = np.concatenate(rows), np.concatenate(tops)
    order = np.argsort(np.concatenate(levels), kind="stable")
    ways, top = ways[order], top[order]
    _, first, kind = np.unique(ways, axis=0, return_index=True, return_inverse=True)
    kind = kind.ravel()
    # a peak may stand between two passes that lead from one basin to the same other one
    apart = np.array(np.unravel_index(top, heights.shape)[1:]) - np.array(
        np.unravel_index(top[first[kind]], heights.shape)[1:]
    )
    away = np.flatnonzero((np.abs((apart + n // 2) % n - n // 2) > _APART).any(0))
    _, second = np.unique(kind[away], return_index=True)
    chosen = np.concatenate([first, away[second]])
    return _Passes(ways[chosen, 0], ways[chosen, 1], ways[chosen, 2:], top[chosen])


def _polished(
    land: Landscapes, nodes: Array, heights: Array, flat: Whole, astray: float, to_saddle: bool
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


def _first_loop(ways: _Passes, order: Whole, ground: list[int]) -> int:
    """The pass over which the region around one of the minima `ground` first winds round the torus."""
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
        # from the root of one through both to the root of the other
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
