"""What old cohorts break while the slider moves straight on from a turning point.

With y the travel since then and w = x d the stretch along the direction d of motion at its beginning, a contact of a
cohort stretches to w + y. It breaks only beyond all it has been through: once the slider has passed the furthest it
had been ahead, y > `ahead`, and once w + y > `behind` - w, the stretch it had when furthest behind. So

    f(y) = sum over cohorts, y > ahead, of the integral of B(w) P_c(w + y) over w > (behind - y)/2,

and the released stretch is the same with w + y under the integral. Forward motion from X = 0 is the simplest case.
"""

import numpy as np
import numpy.typing as npt

from master._old.bunches import Level, bunched
from master._old.cohort import SLACK, Cohort
from master._old.corners import bends
from master._old.first import FirstBreaks
from master._old.law import Law
from master._old.piecewise import Piecewise, tabulate

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.intp]

_X, _W = np.polynomial.legendre.leggauss(16)
_X, _W = 0.5 * (_X + 1.0), 0.5 * _W
_NEGLIGIBLE = 1e-19
_CLOSER = 0.5 ** np.arange(40.0)
_SMALL = 0.1  # of what series are good to: births that may be left out
_LOST = 5e-14  # births in all that rounding of a lattice leaves where there are none
_CHUNK = 400_000
_MOST_SEEDS = 400
_JUMP = 1e-11
_OVERLOOKED = 1e-3  # of all contacts: less than this is told by lattices


class Standing:
    """A cohort as a leg finds it: stretches w along the leg, counted from the leg's beginning.

    Its smallest births, up to `lost` in all, are left out; `self.lost` says how many were.
    """

    def __init__(self, cohort: Cohort, turn: float, direction: int, law: Law, lost: float) -> None:
        back = cohort.low if direction > 0 else cohort.high
        self.ahead = _ahead(cohort, turn, direction)
        self.behind = max(direction * (turn - back), 0.0)
        by = direction * turn
        self.table = cohort.table.seen(-direction, by)
        self.corners = by - direction * cohort.corners
        self.positions, self.weights = by - direction * cohort.positions, cohort.weights
        self.reached = cohort.furthest(cohort.positions)
        self._law = law
        left, right = self.table.edges[:-1], self.table.edges[1:]
        width = right - left
        size = np.abs(self.table.coefficients).sum(axis=0) * width
        order = np.argsort(size)
        added = np.cumsum(size[order])
        nothing = order[added <= max(_LOST, lost)]
        self.lost = float(size[nothing].sum())
        born = np.isin(np.arange(size.size), nothing, invert=True) & (size > _NEGLIGIBLE)
        left, right, width = left[born], right[born], width[born]
        nodes = left[:, None] + width[:, None] * _X
        self._levels: list[Level] = []
        if left.size and law.edges.size:
            mass = self.table.within(np.flatnonzero(born), nodes) * (width[:, None] * _W)
            self._levels = bunched(law, left, right, nodes, mass)
            edges = self._levels[0].edges
            below, above = np.flatnonzero(law.cdf(edges) <= _NEGLIGIBLE), np.flatnonzero(law.sf(edges) <= _NEGLIGIBLE)
            self._edges = edges = edges[below[-1] if below.size else 0 : above[0] + 1 if above.size else None]
            # the first panel of a narrow law is as wide as all that lies below it
            closer = edges[1] - (edges[1] - edges[0]) * _CLOSER if edges.size > 1 else edges[:1]
            self._begins = float(closer[law.cdf(closer) <= _NEGLIGIBLE].max(initial=edges[0]))

    def flux(self, y: Array) -> Array:
        """f at travels y > 0, and the same weighted by the released stretch; shape (2, n)."""
        out = np.zeros((2, y.size))
        on = y > self.ahead
        if self._levels:
            rows = max(1, _CHUNK // self._levels[-1].nodes.size)
            at = np.flatnonzero(on)
            for part in np.array_split(at, 1 + at.size // rows):
                if part.size:
                    out[:, part] = self._spread(y[part])
        law = self._law
        if self.table.edges.size > 1:
            for atom, weight in zip(law.atoms, law.atom_weights, strict=True):
                birth = atom - y
                share = np.where(on & (atom > self.behind - birth), weight * self.table(birth), 0.0)
                out += np.stack([share, share * atom])
        if self.positions.size:
            for w, weight in zip(self.positions, self.weights, strict=True):
                stretch = w + y
                share = np.where(on & (stretch > self.behind - w), weight * law.pdf(stretch), 0.0)
                out += np.stack([share, share * stretch])
        return out

    def _spread(self, y: Array) -> Array:
        """Births spread over w, thresholds spread over x: by 16 nodes on every interval, the widest that do."""
        edges, law = self._edges, self._law
        low, high = np.maximum(0.5 * (self.behind - y), self._begins - y), edges[-1] - y
        out = np.zeros((2, y.size))
        row, at = self._levels[-1].between(low, high)
        for depth in range(len(self._levels) - 1, -1, -1):
            level = self._levels[depth]
            left, right, shift = level.left[at], level.right[at], y[row]
            live = (right > low[row]) & (left < high[row])
            row, at, left, right, shift = row[live], at[live], left[live], right[live], shift[live]
            before = np.searchsorted(level.edges, left + shift, side="right")
            whole = np.searchsorted(level.edges, right + shift, side="left") <= before
            whole &= (left >= low[row]) & (right <= high[row])
            if whole.any():
                here = at[whole]
                stretch = level.nodes[here] + shift[whole, None]
                out += _sums(row[whole], level.mass[here] * law.pdf(stretch), stretch, y.size)
            row, at = row[~whole], at[~whole]
            if depth:
                row, at = level.split(row, at)
        if row.size:
            out += self._cut(y, row, at, low, high)
        return out

    def _cut(self, y: Array, row: Whole, panel: Whole, low: Array, high: Array) -> Array:
        """The same of pairs of travels y[row] and panels, each cut where anything bends."""
        edges, finest = self._edges, self._levels[0]
        left = np.maximum(finest.left[panel], low[row])
        right = np.minimum(finest.right[panel], high[row])
        live = right - left > 1e-15 * (1.0 + np.abs(left))
        row, left, right = row[live], left[live], right[live]
        first = np.searchsorted(edges, left + y[row], side="right")
        count = np.maximum(np.searchsorted(edges, right + y[row], side="left") - first, 0) + 1
        pair = np.repeat(np.arange(row.size), count)
        place = np.arange(pair.size) - np.repeat(np.cumsum(count) - count, count)
        row, next_edge = row[pair], first[pair] + place
        begin = np.where(place == 0, left[pair], edges[np.minimum(next_edge - 1, edges.size - 1)] - y[row])
        end = np.where(place == count[pair] - 1, right[pair], edges[np.minimum(next_edge, edges.size - 1)] - y[row])
        width = np.maximum(end - begin, 0.0)[:, None]
        nodes = begin[:, None] + width * _X
        stretch = nodes + y[row, None]
        density = width * _W * self.table(nodes) * self._law.pdf(stretch)
        return _sums(row, density, stretch, y.size)

    def seeds(self, end: float) -> Array:
        """Travels up to `end` at which f may not be smooth."""
        law = self._law
        marks = np.concatenate([law.breakpoints, law.jumps, law.atoms])
        sums = [np.array([self.ahead]), 2.0 * marks - self.behind]
        if self.table.edges.size > 1:
            sums += [self.behind - 2.0 * self.corners, (marks[:, None] - self.corners).ravel()]
        if self.positions.size:
            w = self.positions[:_MOST_SEEDS]
            sums += [self.behind - 2.0 * w, (np.append(law.edges, marks)[:, None] - w).ravel()]
        at = np.concatenate(sums)
        return at[(at >= self.ahead) & (at <= end)]

    def atoms(self) -> tuple[Array, Array, Array]:
        """Travels of breaks of finite weight, their weights, and weight times released stretch."""
        law = self._law
        atom, w = np.broadcast_arrays(law.atoms[:, None], self.positions)
        left = (atom > self.reached * (1.0 + SLACK)) & (self.positions.size > 0)
        weight = (law.atom_weights[:, None] * self.weights)[left]
        return (atom - w)[left], weight, weight * atom[left]


class CohortBreaks(FirstBreaks):
    """Breaks of old cohorts over the travel y of one leg, up to y = `end`; the same face as the breaks of a start.

    `step` is the lattice on which the cohorts were born: nothing finer is looked for in between the seeds; 0 where
    they are known exactly.
    """

    def __init__(
        self, law: Law, cohorts: list[Cohort], turn: float, direction: int, end: float, accuracy: float, step: float
    ) -> None:
        self.end = end
        self._accuracy = max(accuracy, 2e-15)
        self._law = law
        # those that have been further ahead than this leg goes do not break on it
        breaking = [cohort for cohort in cohorts if _ahead(cohort, turn, direction) < end]
        lost = _SMALL * self._accuracy / max(len(breaking), 1)
        self._standing = [Standing(cohort, turn, direction, law, lost) for cohort in breaking]
        self.lost = sum(standing.lost for standing in self._standing)
        self.mean_start = direction * sum(cohort.held(law, turn)[1] for cohort in cohorts)
        atoms = [(np.empty(0),) * 3, *(standing.atoms() for standing in self._standing)]
        self.atoms, self.atom_weights, self.atom_released = (np.concatenate(part) for part in zip(*atoms, strict=True))
        self._atom_stretch = np.zeros(self.atoms.size)  # travels beside a drop are told from it by themselves
        seeds = np.unique(np.concatenate([[0.0], *[standing.seeds(end) for standing in self._standing]]))
        self.seeds = seeds[np.append(True, np.diff(seeds) > 1e-13)]
        self.density, self._released = self._tables(step)
        self.missed = self._defect = self._missed(breaking, turn, direction)
        self.single = self.density.edges.size < 2
        self.jumps, self.jump_sizes = self._jumps_of_table()
        self.bends, self.bend_sizes = np.empty(0), np.empty(0)
        if law.atoms.size:
            at = self.seeds[(self.seeds > 0.0) & (self.seeds < end)]
            self.bends, self.bend_sizes = bends(self.density, at, law.narrowest)
        self.onsets, self.onset_heights = np.empty(0), np.empty(0)
        self.has_corners = bool((np.abs(self.jump_sizes[self.jumps > 0.0]) > _JUMP).any())

    def edges_for(self, step: float) -> Array:
        """All edges: f bends where older cohorts begin to break, even where nothing jumps."""
        edges = self.density.edges
        return edges if edges.size > 1 else np.empty(0)

    def changes_within(self, width: float) -> bool:
        """Whether the series of the density has panels below `width`, but for those towards y = 0, where it changes."""
        edges, rest = self.density.edges, np.abs(self.density.coefficients[1:]).sum(axis=0)
        apart = np.diff(edges)
        return bool(((apart < width) & (edges[:-1] > 4.0 * apart) & (edges[:-1] < self.end) & (rest > _JUMP)).any())

    def flux(self, y: Array) -> Array:
        """Density of breaks at travels y > 0, and the same weighted by the released stretch; shape (2, n)."""
        total = np.zeros((2, y.size))
        for standing in self._standing:
            total += standing.flux(y)
        return total

    def _tables(self, step: float) -> tuple[Piecewise, Piecewise]:
        law = self._law
        nothing = Piecewise(np.zeros(1), np.empty((16, 0)))
        spread = any(s.table.edges.size > 1 for s in self._standing) or (law.edges.size > 1 and self._standing)
        if not spread:
            return nothing, nothing
        even = np.linspace(0.0, self.end, 2 + int(min(self.end / (4.0 * law.narrowest), _MOST_SEEDS)))
        seeds = np.append(self.seeds, self.end)
        edges = np.unique(np.concatenate([seeds, even[1:-1]]))
        edges = edges[np.append(np.diff(edges) > 1e-13, True)]
        if edges.size < 2:
            return nothing, nothing

        def rows(y: Array) -> Array:
            return self.flux(y.ravel()).reshape(2, *y.shape)

        def narrow(left: Array, right: Array) -> npt.NDArray[np.bool_]:
            middle, width = 0.5 * (left + right), right - left
            near = np.clip(np.searchsorted(seeds, middle), 1, seeds.size - 1)
            away = np.minimum(np.abs(middle - seeds[near - 1]), np.abs(seeds[near] - middle))
            return (width < 2.0 * step) & (away > 2.0 * width)

        density, released = tabulate(rows, edges, self._accuracy, narrow if step > 0.0 else None)
        return density, released

    def _missed(self, breaking: list[Cohort], turn: float, direction: int) -> float:
        """How far what is seen to break is from what the cohorts lose: breaks within less than the seeds are apart may
        be overlooked as a whole."""
        far = turn + direction * self.end
        gone = sum(cohort.held(self._law, turn)[0] - cohort.visited(far).held(self._law, far)[0] for cohort in breaking)
        seen = self.density.total + float(self.atom_weights[self.atoms <= self.end * (1.0 + SLACK)].sum())
        off = abs(gone - seen)
        return off if off > _OVERLOOKED else 0.0

    def _jumps_of_table(self) -> tuple[Array, Array]:
        table = self.density
        if table.edges.size < 2:
            return np.zeros(1), np.zeros(1)
        size = table.jumps
        known = np.isin(table.edges[:-1], self.seeds) & (np.abs(size) > _JUMP)
        known[0] = True
        return table.edges[:-1][known], size[known]


def _ahead(cohort: Cohort, turn: float, direction: int) -> float:
    """How far ahead of a turning point the slider has been since the births."""
    front = cohort.high if direction > 0 else cohort.low
    return max(direction * (front - turn), 0.0)


def _sums(row: npt.NDArray[np.intp], density: Array, stretch: Array, size: int) -> Array:
    """Sums over the nodes, and over all pairs of one row, of the density and of it times the stretch."""
    plain = np.bincount(row, weights=density.sum(-1), minlength=size)
    return np.stack([plain, np.bincount(row, weights=(density * stretch).sum(-1), minlength=size)])
