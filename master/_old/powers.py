"""Places where J_1(X) is no smooth function but a sum of powers of the distance, and how it is read beside them.

Where P_c ends, begins or diverges as a power of the distance times a smooth function, breaks of every generation do so
again: folding adds up places and orders, and multiplies the factors, all of which are known. Some forty nodes away the
lattice is right to round-off. What J_1 there has beyond the powers is smooth: a polynomial fills the gap between.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

from master._old.germs import HIGHEST, Germ, Sum, gathered, renewed, single
from master._old.law import Law
from origins import Contacts

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]
Fits = dict[int, Function | None]

HOLE, WINDOW = 36.0, 3.0  # nodes to either side of a place that are not trusted; how many times as many are looked at
_GENTLE, _GENTLE_HOLE = 0.75, 24.0  # from this order on fewer
_DEGREE = 12
_SMOOTH = 3.0  # order of a place in P_c from which on a lattice needs no help
_WHOLE, _SAME, _CROWD = 1e-6, 1e-9, 1e-4
_MOST_PLACES, _MOST_POINTS = 64, 8
_NODES, _DEGREE_BESIDE = 24, 14
_REACH = 0.4
_SMALLEST = 1e-280
_SHARPER = 4
_POWER = 1e-11
_FITS = 0.3
_RADIUS, _WIDEST = 0.15, 0.02
_HIGHEST_AT_0 = 12.0
_BEYOND = 1.6  # times the path: how far all else is known
# T_k(2 u - 1) -> coefficients of powers of u
_TAYLOR = np.zeros((_DEGREE_BESIDE + 1, _DEGREE_BESIDE + 1))
for _k in range(_DEGREE_BESIDE + 1):
    _shifted = np.polynomial.Polynomial(chebyshev.cheb2poly(np.eye(_DEGREE_BESIDE + 1)[_k]))(
        np.polynomial.Polynomial([-1.0, 2.0])
    )
    _TAYLOR[: _k + 1, _k] = _shifted.coef[: _k + 1]


@dataclass(frozen=True)
class Powers:
    """Places (sorted, in units of the law), and what J_1 has of powers at each.

    `begun` is all of J_1 just above X = 0, where that is known; less than `tiny` of J_1 does not matter.
    """

    places: Array
    released: list[Sum]
    begun: Sum | None
    tiny: float

    def on(self, step: float) -> "Powers":
        """Those that a lattice of that step smears by more than `tiny`."""
        sizes = [part.sizes for part in self.released]
        matter = np.array([(size * step**order).max(initial=0.0) > self.tiny for size, order in sizes], dtype=bool)
        return replace(self, places=self.places[matter], released=[self.released[k] for k in np.flatnonzero(matter)])

    def knows(self, x: float) -> bool:
        """Whether `begun` holds up to X = x: what comes after its last powers does not matter."""
        return self.begun is not None and self.begun.neglected(x) < self.tiny

    @property
    def widest_step(self) -> float:
        """The coarsest lattice on which a polynomial fits what is between two places, or one and X = 0."""
        step, widest = np.inf, _WIDEST
        while step > widest:
            step, some = widest, self.on(widest)
            spacing = float(np.diff(some.places, prepend=0.0).min(initial=np.inf))
            widest = min(_RADIUS * spacing / (WINDOW * max(some._holes, default=HOLE)), step)
        return step

    def reach(self, end: float, step: float) -> float:
        """How far a lattice of that step must go so that all up to `end` can be read."""
        last = self.places[self.places < end + HOLE * step]
        return max(end, min(float(last[-1]) + WINDOW * HOLE * step, _BEYOND * end)) if last.size else end

    def put_right(
        self, x: Array, values: Array, at_nodes: Function, step: float, size: int, fits: Fits
    ) -> Array:
        """`values` read at x from a lattice of `size` nodes, those beside a place anew; at_nodes gives them at any
        node, and `fits` keeps what was found for the next time."""
        for k, place in enumerate(self.places):
            near = np.abs(x - place) < self._holes[k] * step
            if near.any():
                if k not in fits:
                    fits[k] = self._fit(k, at_nodes, step, size)
                fitted = fits[k]
                if fitted is not None:
                    values[near] = fitted(x[near])
        return values

    @cached_property
    def _holes(self) -> list[float]:
        """Nodes to either side of each place that are not trusted."""
        lowest = [min(germ.order for germ in part.germs) - 1.0 for part in self.released]
        return [HOLE if order < _GENTLE else _GENTLE_HOLE for order in lowest]

    def _fit(self, k: int, at_nodes: Function, step: float, size: int) -> Function | None:
        """What stands for J_1 around one place; None where its neighbours are too close for nodes between."""
        place, powers, holes = float(self.places[k]), self.released[k], self._holes
        hole, window = holes[k], WINDOW * holes[k]
        before, beside = (float(self.places[k - 1]), holes[k - 1]) if k else (0.0, HOLE)
        low = max(place - window * step, before + beside * step)
        high = min(place + window * step, (size - 9) * step)
        if k + 1 < self.places.size:
            high = min(high, float(self.places[k + 1]) - holes[k + 1] * step)
        if min(place - low, high - place) < 0.5 * window * step:
            return None
        nodes = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1.0)
        nodes = nodes[np.abs(nodes - place) >= hole * step]
        width = max(place - low, high - place)
        values = at_nodes(nodes)
        factors = chebyshev.chebfit((nodes - place) / width, values - powers(nodes - place), _DEGREE)

        def fitted(x: Array) -> Array:
            return np.asarray(chebyshev.chebval((x - place) / width, factors) + powers(x - place))

        between = np.arange(0.5 - hole, hole)
        changed = np.abs(fitted(place + step * between) - at_nodes(place + step * between))
        # where the function changes faster than the nodes outside tell, the lattice itself is the better of the two: it
        # is all but right in the outer half of the hole
        doubt = max(np.abs(fitted(nodes) - values).max(), changed[np.abs(between) > 0.5 * hole].max())
        return None if doubt > _FITS * changed.max() else fitted


def find_powers(contacts: Contacts, law: Law, end: float, tiny: float, stiffness: float = 0.0) -> Powers | None:
    """The places up to about `end`; None where P_c has no such point above 0, where not all of them are known for sure
    or where there are too many. What J_1 would feel by less than `tiny` is left alone; stiffness: k of a contact per
    length of its threshold, or 0."""
    points = law.breakpoints[(law.breakpoints > 0.0) & (law.breakpoints < law.top * (1.0 + _SAME))]
    # panels crowd about a place where P_c diverges
    if not 0 < points.size <= _MOST_POINTS or not _among(law.points, points, _CROWD):
        return None
    if law.support[0] == 0.0:
        points = np.append(0.0, points)
    own: list[Germ] = []
    onset: Germ | None = None  # at 0
    for point in points:
        for side in (-1.0, 1.0) if point else (1.0,):
            germ = _beside(law, float(point), side, points, HIGHEST if point else _HIGHEST_AT_0)
            if germ is None:
                return None
            if not point:
                onset = germ
            own += [germ.cut(HIGHEST)] if germ.terms.size else []
    if not any(germ.order < _SMOOTH and germ.order != round(germ.order) for germ in own):
        return None
    # what floating point cannot tell from a place where P_c diverges stands for it as an atom there
    if not _among(law.atoms, np.array([germ.place for germ in own if germ.order < 1.0]), _SAME):
        return None
    first = _of_first_breaks(contacts, law, own)
    if first is None:
        return None
    found = _of_later_breaks(own, first, 1.1 * end, stiffness)
    if found is None or np.count_nonzero(found[0] > 0.0) > _MOST_PLACES:
        return None
    places, released = found
    begun: Sum | None = None
    if contacts.start.span == (0.0, 0.0) and onset is not None and onset.terms.size:
        alone = _of_later_breaks([onset], [onset], np.inf, stiffness)
        begun = None if alone is None or not alone[1] else alone[1][0]
    kept = np.flatnonzero(places > 0.0)
    return Powers(places[kept], [released[k] for k in kept], begun, tiny)


def _of_later_breaks(
    own: list[Germ], first: list[Germ], end: float, stiffness: float
) -> tuple[Array, list[Sum]] | None:
    """Of J_1: places up to X = end, and the germs at each; None where they are too many."""
    again = renewed(own, end)
    if again is None:
        return None
    flux = _with_all_later(_released(own, stiffness), again)
    places, released = gathered([germ.integral().folded(one) for germ in flux for one in first])
    inside = np.flatnonzero(places < end)
    return places[inside], [released[k] for k in inside]


def _released(own: list[Germ], stiffness: float) -> list[Germ]:
    """What the force loses by a break: x P_c, or where stiffnesses differ what follows from k = stiffness times x_s."""
    stretch = [germ.times_x() for germ in own]
    if not stiffness:
        return stretch
    softer = [germ.times(stiffness).integral() for germ in stretch] + [germ.times(-1.0).integral() for germ in own]
    return [germ.times_x().times(stiffness) for germ in stretch] + softer


def _with_all_later(germs: list[Germ], again: list[Germ]) -> list[Germ]:
    """These folded with births of every generation."""
    found = gathered(germs + [one.folded(more) for one in germs for more in again])[1]
    return [germ for part in found for germ in part.germs]


def _of_first_breaks(contacts: Contacts, law: Law, own: list[Germ]) -> list[Germ] | None:
    """Of the density of first breaks; None where they are not known."""
    start = contacts.start
    low, high = start.span[0] / law.unit, start.span[1] / law.unit
    if high - low < _SAME:
        held, at = abs(low), low
        later = [germ for germ in own if germ.place > held or (germ.place == held and germ.above > 0.0)]
        if held > law.support[0]:
            begun = _beside(law, held, 1.0, np.array([germ.place for germ in own]))
            if begun is None:
                return None
            later.append(begun)
        survival = float(law.sf(np.array([held]))[0])
        return [Germ(germ.place - at, germ.above, germ.below, germ.terms / survival) for germ in later]
    if start.breakpoints.size or max(-low, high) > law.support[0]:
        return None
    return []  # a smooth start smooths all


def _beside(law: Law, point: float, side: float, points: Array, highest: float = HIGHEST) -> Germ | None:
    """P_c on one side of a point as a power of the distance times a smooth function; without terms where there is
    nothing, None where it is no power."""
    others = points[points != point]
    radius = float(np.abs(others - point).min(initial=point if point else law.narrowest))
    places = 0.5 * (1.0 - np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES))
    for halvings in range(_SHARPER):
        width = _REACH * radius * 0.5**halvings
        if width**_DEGREE_BESIDE < _SMALLEST:  # too near another singular point for its powers to be numbers
            return None
        x = point + side * width * places
        apart = np.abs(x - point)
        values = law.pdf(x)
        if not values.any():
            return Germ(point, 0.0, 1.0, np.empty(0))
        if not (values > 0.0).all():
            return None
        rows = chebyshev.chebvander(2.0 * apart / width - 1.0, _DEGREE_BESIDE)
        logarithm = np.log(values)
        whole = np.column_stack([np.log(apart), rows])
        found = np.linalg.lstsq(whole, logarithm, rcond=None)[0]
        if np.abs(whole @ found - logarithm).max() < _POWER:
            order = _rounded(float(found[0]) + 1.0)
            smooth = np.linalg.lstsq(rows, values * apart ** (1.0 - order), rcond=None)[0]
            return single(point, side, order, (_TAYLOR @ smooth) / width ** np.arange(smooth.size), highest)
    return None


def _among(some: Array, places: Array, close: float) -> bool:
    return bool((np.abs(some[:, None] - places) <= close * some[:, None]).any(axis=1).all())


def _rounded(order: float) -> float:
    """To a few digits, where they are all that rounding left."""
    near = round(order, 6)
    return near if abs(order - near) < _SAME else order
