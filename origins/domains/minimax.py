"""How high a periodic landscape must be climbed to leave its lowest minimum for a copy of it.

The barrier is the lowest level at which the part of the torus below it, followed from the lowest minimum, winds
round the torus. Descending paths from every saddle tell which minima it joins, and over how many periods; taken by
rising level, the first joint that closes a loop round the torus is the saddle sought.
"""

import numpy as np

from origins.domains.critical_points import CriticalPoints, Landscapes, Whole, critical_points
from origins.thresholds.law import Array

_SAME = 1e-7  # regular points nearer than this are one,
_SAME_FLAT = 1e-4  # and points without curvature
_LEVEL = 1e-13  # rounding of an energy
_MARGIN = 1e-11  # by which a path down may rise above its saddle
_DIRECTIONS = 16  # tried from a point without curvature,
_AROUND = 3e-4  # from this far
_NEAR, _NEAR_FLAT = 1e-5, 3e-3  # how far from a point a descent to it may end
_LONGEST = 0.5  # step of a descent, in radians of the fastest wave
_SAMPLES = 4
_MOST_STEPS = 5000
_FLATTEST = 1e-15
_NOISE = 4e-15  # rounding of a gradient, of the waves that have a part in it
_TURN = 2.0 * np.pi

Joint = tuple[float, int, int, tuple[int, int]]


def lowest_saddles(land: Landscapes) -> tuple[Array, Array]:
    """(barrier, energy of the lowest minimum) of every landscape, shape (landscapes,).

    The largest wave of each landscape has about the size 1, and its waves span both directions.
    """
    points = _once(land, critical_points(land))
    which, t, count = points.which, points.t, len(land.sizes)
    frame = land.frame(which, t)
    energy = land.energy(which, t)
    unclear = points.radius > 0.0
    signs = np.where(unclear, 0.0, np.sign(frame.curvatures).prod(-1))
    unbalanced = (np.bincount(which, signs, count) != 0.0) & (np.bincount(which, unclear, count) == 0.0)
    if unbalanced.any():
        raise RuntimeError("minima, saddles and maxima of a landscape do not balance: a defect of this program")
    source, start = _ways_down(land, points, frame.directions, frame.curvatures, energy)
    end = _descend(land, which[source], start, energy[source] + _MARGIN)
    first = np.searchsorted(which, np.arange(count + 1))
    target, shift = _nearest(points, first, which[source], end)
    joints: list[list[Joint]] = [[] for _ in range(count)]
    for s, m, (along, across) in zip(source.tolist(), target.tolist(), shift.tolist(), strict=True):
        joints[which[s]].append((max(energy[s], energy[m]), s, m, (along, across)))
    barriers, lowest = np.empty(count), np.empty(count)
    for number, own in enumerate(joints):
        here = energy[first[number] : first[number + 1]]
        lowest[number] = here.min()
        ground = first[number] + np.flatnonzero(here <= lowest[number] + _LEVEL)
        barriers[number] = _first_loop(sorted(own), ground.tolist()) - lowest[number]
    return np.maximum(barriers, 0.0), lowest


def _once(land: Landscapes, points: CriticalPoints) -> CriticalPoints:
    """Sorted by landscape, each point once; of boxes side by side without curvature the one with the least gradient."""
    gradient = np.abs(land.frame(points.which, points.t).slopes).max(-1)
    order = np.lexsort((gradient, points.which))
    which, t, radius = points.which[order], points.t[order], points.radius[order]
    again = np.zeros(which.size, dtype=bool)
    # a landscape has few points: compare each with those a few places further on
    for ahead in range(1, int(np.bincount(which).max(initial=1))):
        apart = np.abs(_wrapped(t[ahead:] - t[:-ahead])).max(-1)
        same = np.where((radius[ahead:] > 0.0) & (radius[:-ahead] > 0.0), _SAME_FLAT, _SAME)
        again[ahead:] |= (which[ahead:] == which[:-ahead]) & (apart < same)
    return CriticalPoints(which[~again], t[~again], radius[~again])


def _wrapped(t: Array) -> Array:
    return t - _TURN * np.rint(t / _TURN)


def _ways_down(
    land: Landscapes, points: CriticalPoints, directions: Array, curvatures: Array, energy: Array
) -> tuple[Whole, Array]:
    """Points (by number) and where to start a descent beside them: both sides of a saddle, all round where unclear."""
    which, t = points.which, points.t
    saddle = np.flatnonzero((points.radius == 0.0) & (curvatures.prod(-1) < 0.0))
    down = curvatures[saddle].argmin(-1)
    direction = directions[saddle, down]
    third = (land.sizes[which[saddle]] * np.abs(direction @ land.waves.T) ** 3).sum(-1)
    # short enough for the curvature to rule the whole of it
    step = (0.3 * np.abs(curvatures[saddle, down]) / third)[:, None] * direction
    source, start = [saddle, saddle], [t[saddle] - step, t[saddle] + step]
    unclear = np.flatnonzero(points.radius > 0.0)
    for angle in _TURN * np.arange(_DIRECTIONS) / _DIRECTIONS:
        way = t[unclear] + _AROUND * (np.array([np.cos(angle), np.sin(angle)]) @ directions[unclear])
        below = land.energy(which[unclear], way) < energy[unclear]
        source.append(unclear[below])
        start.append(way[below])
    return np.concatenate(source), np.concatenate(start)


def _descend(land: Landscapes, which: Whole, start: Array, level: Array) -> Array:
    """Where paths that never rise above `level` come to rest, shape (m, 2), not wrapped."""
    end = np.empty_like(start)
    active, t = np.arange(which.size), start
    for _ in range(_MOST_STEPS):
        if not active.size:
            return end
        frame = land.frame(which[active], t)
        # Newton's step with every curvature counted upwards leads down and away from saddles
        noise = _NOISE * np.einsum("mkn,mn->mk", frame.along, frame.sizes)
        slopes = np.where(np.abs(frame.slopes) > noise, frame.slopes, 0.0)
        lengths = -slopes / np.maximum(np.abs(frame.curvatures), _FLATTEST)
        step = np.einsum("mk,mkd->md", lengths, frame.directions)
        fastest = np.abs(step @ land.waves.T).max(-1)
        step *= np.minimum(1.0, _LONGEST / np.maximum(fastest, 1e-300))[:, None]
        step = _kept_below(land, which[active], t, step, level[active])
        t = t + step
        rest = np.abs(step).max(-1) < 1e-9
        end[active[rest]] = t[rest]
        active, t = active[~rest], t[~rest]
    raise RuntimeError("a descent in a landscape found no end: a defect of this program")


def _kept_below(land: Landscapes, which: Whole, t: Array, step: Array, level: Array) -> Array:
    """Steps shortened until U surely stays below `level` on all of each, and ends no higher than it began."""
    cosines = land.sizes[which] * np.cos(t @ land.waves.T + land.phases[which])
    before = cosines.sum(-1)
    step = step.copy()
    todo = np.arange(which.size)
    for _ in range(60):
        own, part = which[todo], step[todo]
        along = part @ land.waves.T
        # between two samples U rises above both by at most this: its second derivative, and what the third adds
        concave = (cosines[todo] * along**2).sum(-1) + (land.sizes[own] * np.abs(along) ** 3).sum(-1)
        bend = np.maximum(concave, 0.0) / (8.0 * _SAMPLES**2)
        height = [land.energy(own, t[todo] + part * (k / _SAMPLES)) for k in range(1, _SAMPLES + 1)]
        highest = np.maximum(np.max(height, axis=0), before[todo])
        bad = (highest + bend > level[todo]) | (height[-1] > before[todo] + 0.1 * _LEVEL)
        todo = todo[bad]
        if not todo.size:
            break
        step[todo] *= 0.5
    return step


def _nearest(points: CriticalPoints, first: Whole, which: Whole, end: Array) -> tuple[Whole, Whole]:
    """The critical point that each path came to, and by how many periods it was carried beyond the listed one."""
    target = np.empty(which.size, dtype=np.intp)
    size = first[which + 1] - first[which]
    batch = max(1, (1 << 20) // int(size.max(initial=1)))
    for begin in range(0, which.size, batch):
        part = slice(begin, begin + batch)
        place = np.minimum(np.arange(size[part].max()), size[part, None] - 1) + first[which[part]][:, None]
        apart = np.abs(_wrapped(end[part, None] - points.t[place])).max(-1)
        target[part] = place[np.arange(len(place)), apart.argmin(-1)]
    beyond = end - points.t[target]
    near = np.where(points.radius[target] > 0.0, _NEAR_FLAT, _NEAR)
    if (np.abs(_wrapped(beyond)).max(-1) > near).any():
        raise RuntimeError("a descent in a landscape ended at no critical point: a defect of this program")
    return target, np.rint(beyond / _TURN).astype(np.intp)


def _first_loop(joints: list[Joint], ground: list[int]) -> float:
    """Level at which the region around one of the points `ground` winds; joints by rising level.

    A joint (level, i, j, shift) says that a path leads from i to the copy of j that is `shift` periods away.
    """
    parent: dict[int, int] = {}
    offset: dict[int, tuple[int, int]] = {}  # periods from a point to the copy of its parent it hangs on
    winding: set[int] = set()

    def root(i: int) -> tuple[int, int, int]:
        x = y = 0
        while i in parent:
            x, y = x + offset[i][0], y + offset[i][1]
            i = parent[i]
        return i, x, y

    for level, i, j, (along, across) in joints:
        a, ax, ay = root(i)
        b, bx, by = root(j)
        # from the root of i through i and j to the root of j
        x, y = along + bx - ax, across + by - ay
        if a != b:
            parent[b], offset[b] = a, (-x, -y)
            if b in winding:
                winding.add(a)
        elif x or y:
            winding.add(a)
        if winding and any(root(g)[0] in winding for g in ground):
            return level
    raise RuntimeError("no path leads round a landscape: a defect of this program")
