"""A map of a periodic energy over one cell, the lowest way in it from a point to a copy of that point.

The way is where a search with atoms starts from; no number is read off the map.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import refuse
from origins.thresholds.law import Array

Mask = npt.NDArray[np.bool_]
Node = tuple[int, int]

SIZES = (16, 32, 64, 128)  # nodes along each period
_FINE = 64
_CURVED = 0.01  # how far the energy may be from its tangents, as a share of the height of the way
_LINES = ((0, 1), (1, 0), (1, 1), (1, -1))
_NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]


@dataclass(frozen=True)
class Way:
    """Nodes of a map from one to its copy, shape (m, 2), whole numbers that are not wrapped, and the highest energy."""

    nodes: npt.NDArray[np.intp]
    level: float


@dataclass(frozen=True)
class EnergyMap:
    """Energies at displacements (i/n) periods[0] + (j/n) periods[1], shape (n, n); the strongest force on the map."""

    periods: Array
    energies: Array
    noise: float
    steepest: float

    def displacements(self, nodes: npt.ArrayLike) -> Array:
        """Displacements of nodes of shape (..., 2), which may be fractions."""
        return np.asarray(nodes, dtype=float) / len(self.energies) @ self.periods

    def nearest(self, displacement: Array) -> Node:
        """The node nearest to a displacement, not wrapped."""
        i, j = np.rint(displacement @ np.linalg.inv(self.periods) * len(self.energies)).astype(int)
        return int(i), int(j)

    @property
    def margin(self) -> float:
        """How much higher than the energy itself the way over its nodes may lead."""
        low = self.energies <= np.median(self.energies)
        return float(0.5 * self._bends().max(axis=0)[low].max()) + self.noise

    @property
    def radian(self) -> float:
        """Over what length forces change by as much as the strongest is: for one wave its length over 2 pi."""
        steps = np.linalg.norm(self.displacements(_LINES), axis=-1)
        curvature = (self._bends().max(axis=(1, 2)) / steps**2).max()
        radian = np.linalg.norm(self.periods, axis=1).min() / (2.0 * np.pi)
        return float(radian if self.steepest * radian <= self.noise else min(radian, self.steepest / curvature))

    def _bends(self) -> Array:
        """Second differences of the energy along four directions, shape (4, n, n)."""
        e = self.energies
        pairs = [np.roll(e, (i, j), (0, 1)) + np.roll(e, (-i, -j), (0, 1)) for i, j in _LINES]
        return np.abs(np.array(pairs) - 2.0 * e)

    def valleys(self) -> list[Node]:
        """Nodes with no lower neighbour that may be next to the lowest minimum, the lowest first."""
        around = np.min([np.roll(self.energies, step, (0, 1)) for step in _NEIGHBOURS], axis=0)
        low = self.energies <= min(self.energies.min() + self.margin, np.median(self.energies))
        nodes = np.argwhere((self.energies <= around) & low)
        order = np.argsort(self.energies[tuple(nodes.T)], kind="stable")
        return [(int(i), int(j)) for i, j in nodes[order]]

    def disc(self, centre: Array, radius: float) -> Mask:
        """Nodes within `radius` (in steps of the map) of a displacement or a copy of it."""
        n = len(self.energies)
        offset = np.indices((n, n)).transpose(1, 2, 0) - centre @ np.linalg.inv(self.periods) * n
        offset -= n * np.rint(offset / n)
        step = np.linalg.norm(self.periods, axis=1).max() / n
        return np.linalg.norm(self.displacements(offset), axis=-1) <= radius * step

    def lowest_way(self, start: Node, blocked: Mask | None = None) -> Way | None:
        """The way from `start` to a copy of it whose highest node is lowest; None where `blocked` nodes close all."""
        n = len(self.energies)
        closed = np.zeros((n, n), dtype=bool) if blocked is None else blocked
        if closed[start[0] % n, start[1] % n]:
            return None
        energies = self.energies.tolist()
        steps = {step: float(np.linalg.norm(self.displacements(step))) for step in _NEIGHBOURS}
        heap: list[tuple[float, float, Node, Node]] = [(energies[start[0] % n][start[1] % n], 0.0, start, start)]
        came_from: dict[Node, Node] = {}
        while heap:
            level, length, node, before = heapq.heappop(heap)
            if node in came_from:
                continue
            came_from[node] = before
            i, j = node
            away = i - start[0], j - start[1]
            if away != (0, 0) and away[0] % n == 0 and away[1] % n == 0:
                nodes = [node]
                while nodes[-1] != start:
                    nodes.append(came_from[nodes[-1]])
                return Way(np.array(nodes[::-1]), level)
            for step, more in steps.items():
                k, m = i + step[0], j + step[1]
                if (k, m) in came_from or closed[k % n, m % n]:
                    continue
                heapq.heappush(heap, (max(level, energies[k % n][m % n]), length + more, (k, m), node))
        return None


def energy_map(
    periods: Array, evaluate: Callable[[Array], tuple[float, Array]], noise: float, least: int = SIZES[0]
) -> EnergyMap:
    """The map of an energy that `evaluate` tells, with the force, at a displacement; fine enough for its lowest way.

    It has at least `least` nodes along each period, one of SIZES.

    Raises InputError where the finest map does not follow the energy: it varies too fast, or its forces belong to
    another energy.
    """
    before = np.inf
    for n in SIZES[SIZES.index(least) :]:
        energies, forces = np.empty((n, n)), np.empty((n, n, 2))
        for i in range(n):
            for j in range(n):
                energies[i, j], forces[i, j] = evaluate(np.array([i, j]) / n @ periods)
        found = EnergyMap(periods, energies, noise, float(np.linalg.norm(forces, axis=-1).max()))
        lowest = np.unravel_index(energies.argmin(), energies.shape)
        way = found.lowest_way((int(lowest[0]), int(lowest[1])))
        assert way is not None  # nothing is blocked
        height = way.level - energies.min()
        off = 0.0
        for axis, step in enumerate(periods / n):
            ahead = np.roll(energies, -1, axis) - energies
            slope = -(forces + np.roll(forces, -1, axis)) @ step / 2.0
            low = np.maximum(energies, np.roll(energies, -1, axis)) <= way.level
            off = max(off, float(np.abs(ahead - slope)[low].max(initial=0.0)))
        if off <= _CURVED * height + noise:
            return found
        if n >= _FINE and off > 0.5 * before:
            break  # where it was smooth, half the step would leave an eighth
        before = off
    refuse(
        "calculator",
        f"energy that changes by {off:.3g} beside its forces",
        f"must vary smoothly over 1/{n} of a period, and its forces must be those of its energy",
    )
