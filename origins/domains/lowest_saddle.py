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
import scipy

from origins.errors import refuse
from origins.thresholds.law import Array

Complex = npt.NDArray[np.complex128]
Whole = npt.NDArray[np.intp]

_TURN = 2.0 * np.pi
_NOTHING = 1e-13  # of the largest wave: smaller waves count as 0; also the rounding of an energy


class LowestBarriers(NamedTuple):
    """Barriers and energies of the lowest minima (m,), and the places (m, 2) of minima and saddles in radians."""

    barriers: Array
    depths: Array
    minima: Array
    saddles: Array


class _Landscapes(NamedTuple):
    """m landscapes U(t) = Re sum_n c_n exp(i K_n·t), K (n, 2) and c (n, m), each asked at one place t, shape (2, m)."""

    waves: Array
    amplitudes: Complex

    def of(self, which: Whole) -> _Landscapes:
        """The landscapes of these numbers, in this order."""
        return _Landscapes(self.waves, self.amplitudes[:, which])

    def energy(self, t: Array) -> Array:
        """U, shape (m,)."""
        return np.asarray((self.amplitudes * np.exp(1j * (self.waves @ t))).real.sum(0))

    def curvatures(self, t: Array) -> tuple[Array, Array]:
        """Principal curvatures (m, 2) of U, the least first, and their directions (m, 2, 2), as columns."""
        waves = (self.amplitudes * np.exp(1j * (self.waves @ t))).real
        return np.linalg.eigh(-np.einsum("nm,nk,nl->mkl", waves, self.waves, self.waves))

    def newton_step(self, t: Array, down: bool = False) -> Array:
        """Newton's step to a critical point, or one that leads `down`; at most half a radian of the fastest wave."""
        waves = (self.amplitudes * np.exp(1j * (self.waves @ t))).imag
        bends, directions = self.curvatures(t)
        slopes = -np.einsum("nm,nk,mkd->md", waves, self.waves, directions)
        bends = np.where(bends == 0.0, 1e-15, np.abs(bends) if down else bends)
        step = np.einsum("mkd,md->km", directions, -slopes / bends)
        fastest = np.abs(self.waves @ step).max(0)
        return np.asarray(step * np.minimum(1.0, 0.5 / np.maximum(fastest, 1e-300)))

    def settled(self, t: Array, down: bool = False) -> tuple[Array, Array]:
        """Where Newton's steps from t end, and the last ones; `down`: at minima, as steps uphill are shortened."""
        t, last, trust = t.copy(), np.zeros(t.shape), np.ones(t.shape[1])
        moving = np.arange(trust.size)
        for _ in range(400 if down else 20):
            part, here = self.of(moving), t[:, moving]
            step = trust[moving] * part.newton_step(here, down)
            up = down and part.energy(here + step) > part.energy(here) + 1e-15
            t[:, moving] += np.where(up, 0.0, step)
            trust[moving] = np.where(up, 0.25 * trust[moving], np.minimum(2.0 * trust[moving], 1.0))
            last[:, moving] = step
            moving = moving[(np.abs(step) >= 1e-9).any(0)]
            if not moving.size:
                break
        return t, last

    def critical_points(self, n: int) -> tuple[Whole, Array]:
        """Landscapes and places (2, m) of critical points that Newton's method finds from a grid n x n, each once."""
        spacing, (k, m) = _TURN / n, self.waves.T
        # no node falls on a line of symmetry
        nodes = spacing * np.indices((n, n)).reshape(2, -1) + [[0.012345], [0.00789]]
        table = np.exp(1j * (self.waves @ nodes))

        def derivative(of_wave: Array) -> Array:
            return np.asarray(((of_wave * self.amplitudes.T) @ table).real)

        x, y = derivative(1j * k), derivative(1j * m)
        xx, xy, yy = derivative(-k * k), derivative(-k * m), derivative(-m * m)
        # nodes from which Newton's step is shorter than the spacing
        near = np.hypot(yy * x - xy * y, xx * y - xy * x) < spacing * np.abs(xx * yy - xy * xy)
        which, node = np.nonzero(near)
        t, step = self.of(which).settled(nodes[:, node])
        # a last step below this changes energies by at most its square
        good = (np.abs(step) < 1e-6) & (np.abs(t - nodes[:, node]) < 4.0 * spacing)
        which, t = which[good.all(0)], t[:, good.all(0)]
        kind = np.sign(self.of(which).curvatures(t)[0]).sum(1)  # minimum, saddle or maximum
        each = np.unique(_same(np.vstack([which, kind]), t))
        return which[each], t[:, each]

    def over_saddles(self, which: Whole, tops: Array) -> LowestBarriers:
        """The lowest barriers over saddles at `tops` (2, m) of landscapes `which`, sorted; inf where none is found."""
        levels, count = self.of(which).energy(tops), self.amplitudes.shape[1]
        order, owner = np.lexsort([levels, which]), np.tile(which, 2)
        tops, levels = tops[:, order], levels[order]
        downhill = 1e-3 * self.of(which).curvatures(tops)[1][..., 0].T
        feet, _ = self.of(owner).settled(np.hstack([tops + downhill, tops - downhill]), down=True)
        energies = self.of(owner).energy(feet)
        barriers, depths = np.full((2, count), np.inf)
        minima, saddles = np.zeros((2, 2, count))
        order = np.argsort(-energies)  # the lowest minimum is written last
        depths[owner[order]], minima[:, owner[order]] = energies[order], feet[:, order]
        lowest = energies <= depths[owner] + _NOTHING
        # A way round the torus that does not cross itself turns an odd number of times in one direction at least. On
        # a torus of twice the size each minimum, named by its first foot, is there four times; such a way joins two.
        minimum, cells = _same(owner, feet), np.arange(4)[:, None]
        turns = np.rint((feet - feet[:, minimum]) / _TURN).astype(int) % 2
        cell = 2 * turns[0] + turns[1]
        near, far = np.split(4 * minimum + (cells ^ cell), 2, axis=1)
        rank = np.arange(which.size) - np.searchsorted(which, which)
        for k in range(rank.max(initial=-1) + 1):  # with the next saddle of each landscape
            ends = near[:, rank <= k].ravel(), far[:, rank <= k].ravel()
            graph = scipy.sparse.coo_array((np.ones(ends[0].size), ends), (4 * minimum.size,) * 2)
            pools = scipy.sparse.csgraph.connected_components(graph, False)[1].reshape(-1, 4)
            winds = (pools[minimum, 1:] == pools[minimum, :1]).any(1)
            over = np.unique(owner[lowest & winds])
            over = over[np.isinf(barriers[over])]
            top = np.searchsorted(which, over) + k
            barriers[over], saddles[:, over] = levels[top] - depths[over], tops[:, top]
        return LowestBarriers(np.maximum(barriers, 0.0), depths, minima.T, saddles.T)


def _same(groups: npt.ArrayLike, points: Array) -> Whole:
    """For each of the points (2, m) the number of the first of its group that is the same but for whole periods."""
    on_torus = np.vstack([groups, np.cos(points), np.sin(points)]).T
    pairs = scipy.spatial.cKDTree(on_torus).query_pairs(1e-4, output_type="ndarray")  # radians
    first = np.arange(len(on_torus))
    np.minimum.at(first, pairs[:, 1], pairs[:, 0])
    return first


def lowest_saddles(indices: npt.ArrayLike, amplitudes: Complex) -> LowestBarriers:
    """The lowest barriers of U(t) = Re sum_n c_n exp(i K_n·t), t in radians, of period 2 pi in both directions.

    K are whole numbers, shape (n, 2); c energies, shape (landscapes, n). Barriers are known to about 1e-12 of the
    largest wave where all critical points are found. In valleys flat within rounding some are not.
    """
    waves, scale = np.asarray(indices, dtype=float), np.abs(amplitudes).max(-1, initial=1e-300)
    relative = amplitudes / scale[:, None]
    relative[np.abs(relative) <= _NOTHING] = 0.0
    sizes, places = np.abs(relative), np.zeros((2, scale.size, 2))
    found = LowestBarriers(np.zeros(scale.size), -sizes.sum(-1), *places)
    # there is no barrier across waves that are all parallel
    missed = np.linalg.matrix_rank((sizes > 0.0)[..., None] * waves) == 2
    # 16 nodes per oscillation find each critical point from several nodes
    curvature = sizes @ (waves**2).sum(-1) / np.maximum(sizes.sum(-1), 1.0)
    nodes = int(np.clip(np.ceil(16.0 * np.sqrt(curvature.max())), 16, 160))
    for n in (nodes, 2 * nodes, 4 * nodes):
        todo = np.flatnonzero(missed)
        few = max(1, (1 << 17) // (n * n))  # landscapes at once, to limit memory
        for batch in (todo[at : at + few] for at in range(0, todo.size, few)):
            landscapes = _Landscapes(waves, relative[batch].T)
            which, points = landscapes.critical_points(n)
            saddle = landscapes.of(which).curvatures(points)[0].prod(1) < 0.0
            of_batch = landscapes.over_saddles(which[saddle], points[:, saddle])
            for all_, some in zip(found, of_batch, strict=True):
                all_[batch] = some
            missed[batch] = np.bincount(which, 1.0 - 2.0 * saddle, batch.size) != 0.0
    if np.isinf(found.barriers).any():
        refuse("wavevectors", waves, "no way over saddles is found; leave small waves out")
    return found._replace(barriers=found.barriers * scale, depths=found.depths * scale)
