"""First breaks of the contacts that hold at X = 0: exact at every X, whatever start and thresholds look like.

A contact that starts at x with a threshold xi > |x| (P_c conditional on it) breaks at X = xi - x, where it releases
the stretch xi. With q(x) = Q_ini(x) / S(|x|):

    b_0(X) = integral of q(x) P_c(x + X) over x + X > |x|,       J_0(X) = integral_0^X of the same, times (x + X).
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np
import numpy.typing as npt

from master._old.corners import bends
from master._old.law import Law
from master._old.piecewise import Piecewise, tabulate
from master._old.poles import Poles
from master._old.starting import NARROW, StartSum, thin
from master._old.tally import Tally
from origins import Contacts

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]

_ACROSS = 1e-12  # to either side of a point where the density may jump
_SAME = 1e-14
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
    bends, bend_sizes : arrays of shape (k,)
        Where its slope does; looked for where a law has atoms.
    onsets, onset_heights : arrays of shape (0,) or (1,)
        Where b_0 begins as the law does, as a power that is neither jump nor bend, and the factor before it.
    single : bool
        Whether all contacts start from one stretch, or as good as.
    has_corners : bool
        Whether b_0 may jump or bend above X = 0 where the law does not.
    stiffness : Piecewise or None
        Stiffness that breaks release, where contacts are not equally stiff; `atom_stiffness` that of the atoms.
    mean_start : float
        <x_ini>.
    rounding : float
        Weight that is not known, as stretches are rounded, where contacts break within little of where they stood.
    """

    stiffness: Piecewise | None = None
    rounding = 0.0
    _furthest_start = 0.0
    _poles: Poles | None = None

    def __init__(self, contacts: Contacts, law: Law, end: float, accuracy: float) -> None:
        self.end = end
        self._accuracy = max(accuracy, 2e-15)
        self._defect = 0.0
        self._law = law
        self._factor = law.unit / contacts.mean_threshold if contacts.stiffness == "linked" else 0.0
        self.bends, self.bend_sizes = np.empty(0), np.empty(0)
        self.onsets, self.onset_heights = np.empty(0), np.empty(0)
        span = np.asarray(contacts.start.span) / law.unit
        self.single = bool(span[1] - span[0] < _NARROW)
        self._plain = contacts.delay is None and contacts.reforming is None
        if self.single:
            self._from_single(contacts.start.mean() / law.unit)
            self._defect += float(span[1] - span[0]) / min(law.narrowest, 1.0)
        else:
            self._from_distribution(contacts)

    @cached_property
    def _atom_stretch(self) -> Array:
        """Stretches at which those of finite weight break."""
        stiffness = self.atom_weights if self.stiffness is None else self.atom_stiffness
        return np.divide(self.atom_released, stiffness, out=np.zeros(stiffness.size), where=stiffness > 0.0)

    @cached_property
    def _lumps(self) -> Tally:
        """What breaks of finite weight release."""
        return Tally(None, self.atoms, self.atom_released, self._atom_stretch)

    @cached_property
    def count(self) -> Tally:
        """How many break."""
        return Tally(self.density, self.atoms, self.atom_weights, self._atom_stretch)

    @cached_property
    def softened(self) -> Tally:
        """Stiffness that breaks release; as `count` where all are equally stiff."""
        if self.stiffness is None and np.array_equal(self.atom_stiffness, self.atom_weights):
            return self.count
        return Tally(self.stiffness, self.atoms, self.atom_stiffness, self._atom_stretch)

    @property
    def error(self) -> float:
        """Error of `released`, and of the later breaks that follow from `density`: as tables and conservation tell."""
        # what the tables do not see breaks at any of these stretches
        unseen = (1.0 + self.end + self._furthest_start) * self._defect
        return self._released.error + (1.0 + self.end) * self.density.total_error + unseen

    def released(self, x: Array) -> Array:
        """J_0: stretch released per contact by first breaks up to X = x; a break at x itself counts."""
        released = self._released.integral(x) + self._lumps.once(x)
        return released if self._poles is None else self._poles.put_right(x, released)

    def rate(self, x: Array) -> Array:
        """dJ_0/dX, atoms left out."""
        return self._released(x)

    def rate_error(self, x: Array) -> Array:
        """Error of the same, as tables tell: where panels are narrow it is far above that of what they add up to."""
        return self._released.error_at(x)

    def edges_for(self, step: float) -> Array:
        """Edges of `density` that sums over cells of width `step` must respect: those of narrow panels where it is
        smooth."""
        edges = self.density.edges
        if self.has_corners or self._law.rough or edges.size < 3:
            return edges if edges.size > 1 else np.empty(0)
        width = np.diff(edges)
        narrow = np.minimum(width[1:], width[:-1]) < 4.0 * step
        return np.concatenate([edges[:1], edges[1:-1][narrow], edges[-1:]])

    def _from_single(self, start: float) -> None:
        law = self._law
        least = abs(start)
        survival = float(law.sf(np.array([least]))[0])
        self.mean_start = start
        if law.declares_poles and self._plain:
            self._poles = Poles(law, start, survival, self._factor)
        keep = law.atoms > least
        if self._poles is not None:
            keep &= ~self._poles.among(law.atoms)
        self.atoms = law.atoms[keep] - start
        self.atom_weights = law.atom_weights[keep] / survival
        self.atom_stiffness = self.atom_weights * (law.atoms[keep] * self._factor if self._factor else 1.0)
        self.atom_released = self.atom_stiffness * law.atoms[keep]
        onset = max(0.0, least - start)
        edges = law.edges if self._poles is None else self._poles.outside(law.edges)
        edges = _clip(edges - start, onset, self.end)
        at_onset = float(law.pdf(np.array([max(least, 1.0) * 1e-12 + least]))[0])
        at_onset = at_onset if at_onset < 1e3 else 0.0  # a density that diverges there has no height
        self.has_corners = start < 0.0
        later = law.jumps > least * (1.0 + 1e-9)
        self.jumps = np.append(law.jumps[later] - start, onset)
        self.jump_sizes = np.append(law.jump_sizes[later], at_onset) / survival
        later = law.bends > least * (1.0 + 1e-9)
        self.bends, self.bend_sizes = law.bends[later] - start, law.bend_sizes[later] / survival
        if law.onset is not None and law.onset[0] and least <= law.support[0]:
            self.onsets = np.array([law.support[0] - start])
            self.onset_heights = np.array([law.onset[1] / survival])

        def rows(x: Array) -> Array:
            density = law.pdf(x + start) / survival
            if self._factor:
                stiff = density * (self._factor * (x + start))
                return np.stack([density, stiff * (x + start), stiff])
            return np.stack([density, density * (x + start)])

        self.density, self._released, self.stiffness = tabulate_rows(rows, edges, self._accuracy, self._poles)
        if edges.size > 1:
            last = start + edges[-1]
            if self.atoms.size:  # just short of it: rounding must not put an atom there on either side at once
                last *= 1.0 - 2e-15
            reached = law.atoms[keep] <= last
            held = float(law.weight_between(np.array([last]), np.array([np.inf]))[0])
            held += float(law.atom_weights[keep][reached].sum())
            self._defect = abs(1.0 - held / survival - self.density.total)

    def _from_distribution(self, contacts: Contacts) -> None:
        law, start = self._law, StartSum(contacts, self._law)
        low, high = start.low, start.high
        self.mean_start = start.mean
        self.atoms, self.atom_weights, self.atom_released = np.empty(0), np.empty(0), np.empty(0)
        self.atom_stiffness = np.empty(0)
        marks = np.sort(np.concatenate([law.edges, law.atoms]))
        if not marks.size:  # all thresholds lie beyond the path
            marks = np.array([self.end + high])
        middle = np.clip(self.mean_start, low, high)
        # b_0 is nothing but around the law less the start, and bends where the breakpoints of both meet
        outer = np.concatenate([marks[[0, -1]], law.atoms])
        rough = contacts.start.breakpoints / law.unit
        rough = rough[(rough >= low) & (rough <= high)]
        corners = [np.append(law.breakpoints, outer) - point for point in rough]
        stepped = [law.atoms - point for point in rough] + [2.0 * law.atoms[law.atoms <= -low]]
        # an atom reads 1/S(|x_0|) point by point, jumps and bends of the survival included
        held = np.concatenate([law.breakpoints, law.atoms]) if law.atoms.size else np.empty(0)
        held = np.concatenate([held, -held])
        held = held[(held >= low) & (held <= high)]
        stepped += [law.atoms - point for point in held]
        around = [thin(marks, 0.25 * (high - low)) - middle, outer - low, outer - high, law.breakpoints - middle]
        # from x_0 < 0 contacts break at X = -2 x_0 at the earliest: a narrow law turns that on and off at 2 x_s
        both_ways = 2.0 * thin(law.edges[law.edges <= -low], (high - low) / NARROW)
        seeds = np.concatenate([*around, *corners, *stepped, both_ways, -2.0 * rough, -2.0 * held, [0.0, -2.0 * low]])
        begins = law.begins if not law.atoms.size else min(law.begins, float(law.atoms.min()))
        edges = _clip(_distinct(seeds), max(begins - high, 0.0), min(self.end, marks.max() - low))
        self.density, self._released, self.stiffness = tabulate_rows(start.rows, edges, self._accuracy)
        self.has_corners = rough.size + held.size > 0
        self.jumps, self.jump_sizes = self._find_jumps(np.concatenate(stepped))
        if law.atoms.size and edges.size:
            at = _distinct(np.concatenate([*corners, *stepped]))
            width = min(law.narrowest, high - low)
            self.bends, self.bend_sizes = bends(self.density, at[(at > _SAME) & (at < edges[-1])], width)
        self._defect = abs(start.broken(edges[-1]) - self.density.total) if edges.size else 0.0


    def _find_jumps(self, candidates: Array) -> tuple[Array, Array]:
        """X = 0 and those of the candidates where the density jumps, and by how much."""
        at = _distinct(candidates[(candidates > _SAME) & (candidates < self.end)])
        around = at * (1.0 + _ACROSS * np.array([[-99.0], [-1.0], [1.0], [99.0]]))
        below_far, below, above, above_far = self.density(around)
        size = np.maximum(above, below)
        # a start that diverges makes no jump: it still changes from one distance to the other
        steady = np.maximum(np.abs(above - above_far), np.abs(below - below_far)) < 1e-6 * size
        sharp = steady & (np.abs(above - below) > 1e-7 * size)
        return np.append(0.0, at[sharp]), np.append(self.density(np.zeros(1)), (above - below)[sharp])


def tabulate_rows(
    rows: Function, edges: Array, accuracy: float, poles: Poles | None = None, offset: float = 0.0
) -> tuple[Piecewise, Piecewise, Piecewise | None]:
    """Tables of two rows, or three; `offset` as of `tabulate`."""
    if edges.size < 2:
        nothing = Piecewise(np.zeros(1), np.empty((16, 0)))
        return nothing, nothing, None
    if poles is None:
        density, released, *rest = tabulate(rows, edges, accuracy, offset=offset)
    else:
        density, released, *rest = poles.filled(tabulate(rows, edges, accuracy, poles.beside))
    return density, released, rest[0] if rest else None


def _distinct(points: Array) -> Array:
    """Sorted points, those apart by rounding alone as one."""
    points = np.sort(points)
    return points[np.diff(points, prepend=-np.inf) > _SAME]


def _clip(edges: Array, low: float, high: float) -> Array:
    if high <= low or not edges.size:
        return np.empty(0)
    return np.unique(np.clip(edges, low, high))
