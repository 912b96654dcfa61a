"""Places where J_1(X) is no smooth function but a power of the distance, and how it is read beside them.

Where P_c ends, begins or diverges as a power |x - place|^(order - 1) above 0, breaks of every generation do so again:
folding adds up places and orders, so all of them are known, though not their factors. Some forty nodes away the
lattice is right to round-off. A polynomial and the powers known (with logarithms where they are whole numbers), fitted
to the nodes from there on, fill the gap between.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from master.law import Law
from origins import Contacts

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]
Fits = dict[int, Function | None]

HOLE, WINDOW = 40.0, 6.0  # nodes to either side of a place that are not trusted; how many times as many are looked at
_GENTLE, _GENTLE_HOLE = 1.45, 24.0  # from this order on fewer
_DEGREE = 8
# orders up to the first count, and others up to the second while they are few; more cannot be told apart
_HIGH, _HIGHEST, _FEW_ORDERS, _MOST_ORDERS = 4.0, 6.0, 7, 13
_SMOOTH = 3.0  # order of a place in P_c from which on a lattice needs no help
_WHOLE, _SAME, _CROWD = 1e-6, 1e-9, 1e-4
_MOST_PLACES = 64
_HALVINGS = 7
_REACH = 0.02
_FITS = 0.1
_FURTHEST_OFF = 300.0
_BEYOND = 1.6  # times the path: how far all else is known


@dataclass(frozen=True)
class Powers:
    """Places (sorted, in units of the law) and the orders of J_1 at each: it holds |x - place|^order and on.

    `width` is that of the law, and `share` says how much of the start makes places at all.
    """

    places: Array
    orders: list[Array]
    width: float
    share: float

    @property
    def widest_step(self) -> float:
        """The coarsest lattice on which the nodes between two places, or one and X = 0, are enough."""
        return float(np.diff(self.places, prepend=0.0).min(initial=np.inf)) / ((WINDOW + 1.0) * HOLE)

    def reach(self, end: float, step: float) -> float:
        """How far a lattice of that step must go so that all up to `end` can be read."""
        last = self.places[self.places < end + HOLE * step]
        return max(end, min(float(last[-1]) + WINDOW * HOLE * step, _BEYOND * end)) if last.size else end

    def put_right(self, x: Array, values: Array, at_nodes: Function, step: float, size: int, fits: Fits) -> Array:
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
        return [HOLE if orders[0] < _GENTLE else _GENTLE_HOLE for orders in self.orders]

    def _fit(self, k: int, at_nodes: Function, step: float, size: int) -> Function | None:
        """What stands for J_1 around one place; None where its neighbours are too close for nodes between."""
        place, orders, holes = float(self.places[k]), self.orders[k], self._holes
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
        rows = _basis((nodes - place) / width, orders)
        scale = np.abs(rows).max(axis=0)
        values = at_nodes(nodes)
        factors = np.linalg.lstsq(rows / scale, values, rcond=1e-15)[0] / scale
        between = np.arange(0.5 - hole, hole)
        changed = np.abs(_basis(between * (step / width), orders) @ factors - at_nodes(place + step * between))
        # where the function changes faster than the nodes outside tell, the lattice itself is the better of the two: it
        # is all but right in the outer half of the hole, and nowhere further off than such a power changes in a step
        doubt = max(np.abs(rows @ factors - values).max(), changed[np.abs(between) > 0.5 * hole].max())
        furthest = _FURTHEST_OFF * self.share * (step / self.width) ** orders[0]
        if doubt > _FITS * changed.max() or changed.max() > furthest:
            return None
        return lambda x: _basis((x - place) / width, orders) @ factors


def _basis(u: Array, orders: Array) -> Array:
    """Polynomials and, on each side of u = 0, powers; shape (len(u), n)."""
    above, apart = u > 0.0, np.abs(u)
    columns = [u**k for k in range(_DEGREE + 1)]
    logarithm = np.log(np.maximum(apart, 1e-300))
    for order in orders:
        power = apart**order
        if order == round(order):
            columns += [power * above, u**order * logarithm]
        else:
            columns += [power * above, power * ~above]
    return np.stack(columns, axis=-1)


def find_powers(contacts: Contacts, law: Law, end: float) -> Powers | None:
    """The places up to about `end`; None where P_c has no such point above 0, where not all of them are known for sure
    or where there are too many."""
    points = law.breakpoints[(law.breakpoints > 0.0) & (law.breakpoints < law.top * (1.0 + _SAME))]
    # panels crowd about a place where P_c diverges
    if not points.size or not _among(law.points, points, _CROWD):
        return None
    own: list[tuple[float, float]] = []
    for point in points:
        for side in (-1.0, 1.0):
            order = _order(law.pdf, float(point), side, law.narrowest)
            if order is None:
                return None
            own += [(float(point), order)] if order else []
    if not any(order < _SMOOTH and order != round(order) for _, order in own):
        return None
    # what floating point cannot tell from a place where P_c diverges stands for it as an atom there
    if not _among(law.atoms, np.array([place for place, order in own if order < 1.0]), _SAME):
        return None
    if law.support[0] == 0.0:
        onset = law.onset_order
        own += [(0.0, _rounded(onset))] if np.isfinite(onset) else []
    first = _of_first_breaks(contacts, law, own)
    if first is None:
        return None
    found = _folded(first, own, end)
    spread = not contacts.start.is_single
    # of a spread start what stands at x_0 = 0, where 1/S(|x_0|) has a cusp
    share = min(1.0, float(contacts.start.pdf(0.0)) * law.unit) if spread else 1.0
    return None if found is None else Powers(*found, law.narrowest, share)


def _of_first_breaks(
    contacts: Contacts, law: Law, own: list[tuple[float, float]]
) -> list[tuple[float, float]] | None:
    """Places and orders in the density of first breaks; None where they are not known."""
    start = contacts.start
    low, high = start.span[0] / law.unit, start.span[1] / law.unit
    if high - low < _SAME:
        held, at = abs(low), low
        later = [(place - at, order) for place, order in own if place > held or held == place == 0.0]
        return later if held <= law.support[0] else [(held - at, 1.0), *later]
    lowest = min(place for place, _ in own if place > 0.0)
    if start.breakpoints.size or max(-low, high) >= lowest:
        return None
    if max(-low, high) <= law.support[0]:
        return []  # a smooth start smooths all
    onset = [order for place, order in own if place == 0.0]
    # from x_0 = 0 on contacts survive as the law begins there
    smoothed = [1.0, *(1.0 + order for order in onset)]
    return [(place, order + more) for place, order in own if place > 0.0 for more in smoothed] + [
        (0.0, order) for order in smoothed
    ]


def _folded(
    first: list[tuple[float, float]], own: list[tuple[float, float]], end: float
) -> tuple[Array, list[Array]] | None:
    """All sums of one of the first and of one or more of the law's own: places and orders; None where they are too
    many."""
    found: dict[float, list[float]] = {}
    pending = first
    while pending:
        following = []
        for place, order in pending:
            for step, more in own:
                at, total = place + step, order + more
                if at > 1.1 * end or total > _HIGHEST:
                    continue
                at = next((known for known in found if abs(known - at) < _SAME * at), at)
                orders = found.setdefault(at, [])
                # a power brings those a whole number higher with it
                if any(_is_whole(total - lower) and total > lower - _WHOLE for lower in orders):
                    continue
                orders.append(total)
                following.append((at, total))
        if len(found) > _MOST_PLACES:
            return None
        pending = following
    places = sorted(place for place in found if place > 0.0)
    return np.array(places), [_all_orders(found[place]) for place in places]


def _all_orders(lowest: list[float]) -> Array:
    """These orders and those that come with them, the lowest of all."""
    orders = np.sort(np.add.outer(lowest, np.arange(_HIGHEST)).ravel())
    orders = orders[np.diff(orders, prepend=-1.0) > _WHOLE]
    count = np.clip(np.searchsorted(orders, _HIGH + _WHOLE), _FEW_ORDERS, _MOST_ORDERS)
    return np.array([_rounded(order) for order in orders[orders < _HIGHEST + _WHOLE][:count]])


def _order(density: Function, point: float, side: float, width: float) -> float | None:
    """Order of a density that is a power of the distance, times a smooth function, on one side of a point; 0 where
    there is nothing, None where it is no power."""
    apart = _REACH * min(point, width) * 0.5 ** np.arange(_HALVINGS)
    values = density(np.asarray(point + side * apart))
    if not values.any():
        return 0.0
    if not (values > 0.0).all():
        return None
    # slopes of the logarithm, extrapolated to no distance
    row = -np.diff(np.log2(values))
    last = np.inf
    for power in range(1, _HALVINGS - 1):
        last, row = float(row[-1]), np.diff(row) / (2.0**power - 1.0) + row[1:]
    return _rounded(float(row[-1]) + 1.0) if abs(float(row[-1]) - last) < _WHOLE else None


def _among(some: Array, places: Array, close: float) -> bool:
    return bool((np.abs(some[:, None] - places) <= close * some[:, None]).any(axis=1).all())


def _is_whole(number: float) -> bool:
    return abs(number - round(number)) < _WHOLE


def _rounded(order: float) -> float:
    return float(round(order)) if _is_whole(order) else order
