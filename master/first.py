"""First breaks of the contacts that hold at X = 0: exact at every X, whatever start and thresholds look like.

A contact that starts at x with a threshold xi > |x| (P_c conditional on it) breaks at X = xi - x, where it releases
the stretch xi. With q(x) = Q_ini(x) / S(|x|):

    b_0(X) = integral of q(x) P_c(x + X) over x + X > |x|,       J_0(X) = integral_0^X of the same, times (x + X).
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.law import Law
from master.piecewise import Piecewise, tabulate
from origins import Contacts
from origins.quadrature import gauss

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]

_CHUNK = 200_000
_NEGLIGIBLE = 1e-19
_SPAN = 16.6  # standard deviations of a Gaussian start that are followed
_PLAIN = 20  # panels that a law without an onset or corners needs
_NARROW = 1e-9  # of the mean threshold: below, all start from one stretch


class FirstBreaks:
    """Density and atoms of the first breaks over X (in units of the mean threshold), up to X = `end`,
    each panel of their tables good to `accuracy`.

    Attributes
    ----------
    density : Piecewise
        b_0(X), the continuous part.
    atoms, atom_weights, atom_released : arrays of shape (n,)
        Positions of breaks of finite weight, that weight, and weight times released stretch.
    jumps, jump_sizes : arrays of shape (m,)
        Where the density b_0 jumps, X = 0 included, and by how much.
    single : bool
        Whether all contacts start from one stretch, or as good as.
    has_corners : bool
        Whether b_0 may jump or bend above X = 0 where the law does not.
    mean_start : float
        <x_ini>.
    """

    def __init__(self, contacts: Contacts, law: Law, end: float, accuracy: float) -> None:
        self.end = end
        self._accuracy = max(accuracy, 2e-15)
        self._defect = 0.0
        self._law = law
        span = np.asarray(contacts.start.span) / law.unit
        self.single = bool(span[1] - span[0] < _NARROW)
        if self.single:
            self._from_single(contacts.start.mean() / law.unit)
            self._defect = float(span[1] - span[0]) / min(law.narrowest, 1.0)
        else:
            self._from_distribution(contacts)
        self._order = np.argsort(self.atoms, kind="stable")
        self._atom_sums = np.concatenate([[0.0], np.cumsum(self.atom_released[self._order])])

    @property
    def error(self) -> float:
        """Error of `released`, and of the later breaks that follow from `density`: as tables and conservation tell."""
        return self._released.error + (1.0 + self.end) * (self.density.total_error + self._defect)

    def released(self, x: Array) -> Array:
        """J_0: stretch released per contact by first breaks up to X = x; a break at x itself counts."""
        count = np.searchsorted(self.atoms[self._order], x * (1.0 + 1e-13), side="right")
        return self._released.integral(x) + self._atom_sums[count]

    def rate(self, x: Array) -> Array:
        """dJ_0/dX, atoms left out."""
        return self._released(x)

    def _from_single(self, start: float) -> None:
        law = self._law
        least = abs(start)
        survival = float(law.sf(np.array([least]))[0])
        self.mean_start = start
        keep = law.atoms > least
        self.atoms = law.atoms[keep] - start
        self.atom_weights = law.atom_weights[keep] / survival
        self.atom_released = self.atom_weights * law.atoms[keep]
        onset = max(0.0, least - start)
        edges = _clip(law.edges - start, onset, self.end)
        at_onset = float(law.pdf(np.array([max(least, 1.0) * 1e-12 + least]))[0])
        at_onset = at_onset if at_onset < 1e3 else 0.0  # a density that diverges there has no height
        self.has_corners = start < 0.0
        later = law.jumps > least * (1.0 + 1e-9)
        self.jumps = np.append(law.jumps[later] - start, onset)
        self.jump_sizes = np.append(law.jump_sizes[later], at_onset) / survival

        def rows(x: Array) -> Array:
            density = law.pdf(x + start) / survival
            return np.stack([density, density * (x + start)])

        self.density, self._released = _tabulate_pair(rows, edges, self._accuracy)

    def _from_distribution(self, contacts: Contacts) -> None:
        law, start, unit = self._law, contacts.start, self._law.unit
        reach = law.support[1]
        low, high = max(start.span[0] / unit, -reach), min(start.span[1] / unit, reach)
        inner = start.breakpoints / unit
        inner = inner[(inner > low) & (inner < high)]
        whole = kept = 1.0 - contacts.cut_weight

        conditional = float(law.cdf(np.array([max(-low, high)]))[0]) > 1e-17

        def weighted(x: Array) -> Array:
            density = _finite(start.pdf(x * unit) * (unit / whole))
            if not conditional:
                return density
            survival = law.sf(np.abs(x))
            return np.where(survival > 0.0, density / np.where(survival > 0.0, survival, 1.0), 0.0)

        def both(x: Array) -> Array:
            plain = _finite(start.pdf(x * unit) * (unit / kept))
            return np.stack([plain, weighted(x)] if conditional else [plain])

        # 1/S(|x|) has a cusp at 0 and kinks at the law's own: panels follow it as well as the start
        marks = np.concatenate([law.breakpoints, law.atoms])
        seeds = np.concatenate([np.linspace(low, high, 5), inner, marks, -marks, [0.0]])
        table = tabulate(both, np.unique(seeds[(seeds >= low) & (seeds <= high)]), 1e-13)[0]
        self.mean_start = contacts.start.mean() / unit if contacts.cut_weight == 0.0 else _mean(table) / table.total
        start_edges = table.edges
        # beside a start much narrower than its mean, positions are rounded: the weights' sum need not be
        nodes, weights = gauss(start_edges[:-1], start_edges[1:])
        mass = float((weights * _finite(start.pdf(nodes * unit)) * unit).sum()) / kept
        whole = kept * mass

        self.atoms, self.atom_weights, self.atom_released = np.empty(0), np.empty(0), np.empty(0)
        marks = np.sort(np.concatenate([law.edges, law.atoms]))
        middle = np.clip(self.mean_start, low, high)
        # b_0 is nothing but around the law less the start, and bends where the breakpoints of both meet
        outer = np.concatenate([marks[[0, -1]], law.atoms])
        rough = start.breakpoints / unit
        rough = rough[(rough >= low) & (rough <= high)]
        corners = [np.append(law.breakpoints, outer) - point for point in rough]
        around = [_thin(marks, 0.5 * (high - low)) - middle, outer - low, outer - high, law.breakpoints - middle]
        seeds = np.concatenate([*around, *corners, -2.0 * rough, [0.0, -2.0 * low]])
        edges = _clip(np.unique(seeds), 0.0, min(self.end, marks.max() - low))

        inner_edges = _coarsest(law, weighted, start_edges, edges)

        def rows(x: Array) -> Array:
            flat = x.ravel()
            chunk = max(1, _CHUNK // (8 * (start_edges.size + inner_edges.size + 1)))
            parts = [
                _convolve_start(law, weighted, start_edges, inner_edges, flat[i : i + chunk])
                for i in range(0, flat.size, chunk)
            ]
            return np.concatenate(parts, axis=1).reshape(2, *x.shape)

        self.density, self._released = _tabulate_pair(rows, edges, self._accuracy)
        self.has_corners = rough.size > 0
        self.jumps, self.jump_sizes = np.zeros(1), self.density(np.zeros(1))
        self._defect = abs(_broken(law, weighted, start_edges, edges[-1]) - self.density.total) if edges.size else 0.0


def _coarsest(law: Law, weighted: Function, start_edges: Array, positions: Array) -> Array:
    """The law's edges that the integral over the start must respect: its breakpoints alone where those do."""
    width = (start_edges[-1] - start_edges[0]) / _SPAN
    plain = law.knows_breakpoints and law.edges.size <= _PLAIN and law.narrowest > 1.5 * width
    if positions.size < 2 or plain:
        return law.breakpoints
    # even spacing, and close to the seams, where an onset or an end of the law meets the start's
    step = np.diff(positions)[:, None] * np.array([1e-3, 0.03, 0.5, 0.97, 0.999])
    probes = np.unique(np.append(positions[:-1, None] + step, np.linspace(positions[0], positions[-1], 35)))
    few = _convolve_start(law, weighted, start_edges, law.breakpoints, probes)
    all_ = _convolve_start(law, weighted, start_edges, law.edges, probes)
    return law.breakpoints if np.abs(few - all_).max() <= 1e-14 * np.abs(all_).max() else law.edges


def _convolve_start(law: Law, weighted: Function, start_edges: Array, law_edges: Array, x: Array) -> Array:
    """b_0 and its stretch-weighted twin at positions x, shape (2, n), as integrals over the start."""
    low, high = start_edges[0], start_edges[-1]
    shifted = law_edges - x[:, None]
    reached = law.cdf(x + high) > _NEGLIGIBLE
    apart = (x >= -2.0 * low) & ~((shifted > low) & (shifted < high)).any(axis=1)
    out = np.zeros((2, x.size))
    split = reached & ~apart
    apart &= reached
    if apart.any():
        nodes, weights = (array.ravel() for array in gauss(start_edges[:-1], start_edges[1:]))
        stretch = nodes + x[apart, None]
        density = weights * weighted(nodes) * law.pdf(stretch)
        out[0, apart] = density.sum(-1)
        out[1, apart] = (density * stretch).sum(-1)
    if split.any():
        out[:, split] = _split(law, weighted, start_edges, shifted[split], x[split])
    for atom, weight in zip(law.atoms, law.atom_weights, strict=True):
        at = atom - x
        share = weight * np.where((np.abs(at) < atom) & (at >= low) & (at <= high), weighted(at), 0.0)
        out += np.stack([share, atom * share])
    return out


def _broken(law: Law, weighted: Function, start_edges: Array, x: float) -> float:
    """Fraction broken by X = x, from survival alone: no peak of b_0 that a table missed is missed here."""
    low, high = start_edges[0], start_edges[-1]
    inner = np.concatenate([law.edges - x, law.atoms - x, law.edges, -law.edges, [-0.5 * x]])
    edges = np.unique(np.concatenate([start_edges, inner[(inner > low) & (inner < high)]]))
    nodes, weights = gauss(edges[:-1], edges[1:])
    size = np.abs(nodes)
    return float((weights * weighted(nodes) * (law.sf(size) - law.sf(np.maximum(size, nodes + x)))).sum())


def _split(law: Law, weighted: Function, start_edges: Array, shifted: Array, x: Array) -> Array:
    """The same where edges of the law, or the condition x_0 + X > |x_0|, cut the range of the start."""
    low, high = start_edges[0], start_edges[-1]
    edges = np.concatenate([np.broadcast_to(start_edges, (x.size, start_edges.size)), shifted], axis=1)
    edges = np.sort(np.clip(edges, np.clip(-0.5 * x, low, high)[:, None], high), axis=1)
    left, right = edges[:, :-1], edges[:, 1:]
    wide = right - left > 1e-15 * (high - low)
    out = np.zeros((2, x.size))
    if wide.any():
        row = np.nonzero(wide)[0]
        nodes, weights = gauss(left[wide], right[wide])
        stretch = nodes + x[row, None]
        density = weights * weighted(nodes) * law.pdf(stretch)
        out[0] = np.bincount(row, weights=density.sum(-1), minlength=x.size)
        out[1] = np.bincount(row, weights=(density * stretch).sum(-1), minlength=x.size)
    return out


def _tabulate_pair(rows: Function, edges: Array, accuracy: float) -> tuple[Piecewise, Piecewise]:
    if edges.size < 2:
        nothing = Piecewise(np.zeros(1), np.empty((16, 0)))
        return nothing, nothing
    density, released = tabulate(rows, edges, accuracy)
    return density, released


def _mean(table: Piecewise) -> float:
    nodes, weights = gauss(table.edges[:-1], table.edges[1:])
    return float((weights * nodes * table(nodes)).sum())


def _finite(density: Array) -> Array:
    """The density, but 0 where it diverges: at an end, where no weight sits."""
    return np.where(np.isfinite(density), density, 0.0)


def _thin(points: Array, spacing: float) -> Array:
    """Points at least `spacing` apart: what the start smooths over needs no edge of its own."""
    return points[np.unique(np.floor((points - points[0]) / spacing), return_index=True)[1]]


def _clip(edges: Array, low: float, high: float) -> Array:
    if high <= low or not edges.size:
        return np.empty(0)
    return np.unique(np.clip(edges, low, high))
