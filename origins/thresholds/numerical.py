"""A law computed from its log-density: cdf, survival and moments on panels, with relative accuracy in both tails."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, laguerre, legendre

from origins.errors import InputError

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

_NODES = 12  # of Gauss and Legendre on each panel
# Largest change of the log-density over a panel: the polynomial's error is then 1e-14.
_SPREAD = 1.6
# Error of the polynomial, relative to the largest density on its panel; and the error below which it
# may come from rounding of the density, which halving does not reduce.
_ACCURACY, _NOISE = 1e-13, 1e-8
# Minus the log of the smallest relative weight: exp(-745) is the smallest float.
_NOTHING = 745.0
# Panels halve towards the ends of the support, to 1e-33 of the place where most weight is.
_HALVINGS = 110
# Largest deviation of the log-density from that of its power, over a factor of 2.
_ONSET = 1e-12
# Distances at which the density is searched for, in any unit of length.
_STEPS = np.geomspace(1e-130, 1e130, 2601)
# m of a density x^-m above which positions near a pole are too coarse to determine weights.
_POLE, _WIDER = 0.1, 1024.0
_MOST = 20_000  # panels; smooth densities take some 500
_EPSILON = float(np.finfo(float).eps)

_S, _W = legendre.leggauss(_NODES)
_PLACES, _WEIGHTS = 0.5 * (_S + 1.0), 0.5 * _W  # on (0, 1)
# Matrices from the density at the nodes to its Legendre series, to its values at the nodes of the
# two halves, and to the Chebyshev series of its mean between the left end and a place.
_TO_SERIES = (np.arange(_NODES) + 0.5)[:, None] * _W * legendre.legvander(_S, _NODES - 1).T
_HALVES = np.concatenate([0.5 * (_S - 1.0), 0.5 * (_S + 1.0)])
_TO_HALVES = legendre.legvander(_HALVES, _NODES - 1) @ _TO_SERIES
_C = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
_MEANS = legendre.legval(_C, legendre.legint(_TO_SERIES, lbnd=-1.0)).T / (1.0 + _C)[:, None]
_TO_MEAN = np.linalg.solve(chebyshev.chebvander(_C, _NODES - 1), _MEANS)
# A moment is infinite if a share above _HEAVY of it comes from a survival below _RARE.
_RARE, _HEAVY = 1e-100, 1e-9
_DEEP = 1e-280  # survivals below this are integrated along the tail
_TAIL_PLACES, _TAIL_WEIGHTS = laguerre.laggauss(24)


class NumericalLaw:
    """The normalised law of a density that is smooth between given points.

    Panels are halved until a polynomial of degree 11 fits the density on each, and the weights of all panels are
    added from both ends: cdf and survival keep a relative 1e-12 down to 1e-300 where the log-density is exact.

    Parameters
    ----------
    log_density : function of arrays
        Log of the density, which need not be normalised, at the distance y = x - origin.
    lower, upper : float
        Ends of the support in x (lengths); upper may be inf.
    points : array
        Lengths x between which the density is smooth; a peak may be among them.
    power : float
        m of the onset y^m at the lower end; inf where it is not known.
    origin : float
        A density far narrower than its mean is written as a function of the distance from this x, so that no digits
        are lost.

    Attributes
    ----------
    log_whole : float
        Log of the integral of exp(log_density).

    Raises InputError for a density that 20,000 panels do not resolve, and for one that diverges, except at x = 0 with a
    known power: near such a place positions are too coarse to determine weights from the density.
    """

    def __init__(
        self,
        log_density: Callable[[Array], Array],
        lower: float,
        upper: float,
        points: npt.ArrayLike = (),
        power: float = np.inf,
        origin: float = 0.0,
    ) -> None:
        self._origin, self._log_density = origin, log_density
        self._lower, self._upper, self._power = lower - origin, upper - origin, power
        marks = np.append(np.asarray(points, dtype=float) - origin, 0.0)
        self._check_poles(marks, power)
        values, top = self._panels(marks)
        self._widths = np.diff(self._edges)
        masses = self._widths * (values @ _WEIGHTS)
        # next to the lower end the density is its power
        if self._edges[0] != self._lower:
            self._power = np.inf
        if np.isfinite(self._power):
            level = float(self._log_at(self._edges[1:2])[0])
            masses[0] = np.exp(level - top) * self._widths[0] / (power + 1.0)
        whole = float(masses.sum())
        self.log_whole = top + float(np.log(whole))
        self._masses, values = masses / whole, values / whole
        self._means = _TO_MEAN @ values.T
        self._nodes = self._edges[:-1, None] + self._widths[:, None] * _PLACES
        self._node_weights = self._widths[:, None] * values * _WEIGHTS
        self._below = np.concatenate([[0.0], np.cumsum(self._masses)])
        self._above = np.concatenate([np.cumsum(self._masses[::-1])[::-1], [0.0]])
        with np.errstate(divide="ignore"):
            upper_half = -np.log(self._above)
        lower_half = -np.log1p(-np.minimum(self._below, 0.5))
        self._hazards = np.where(self._below < 0.5, lower_half, upper_half)

    def _log_at(self, y: Array) -> Array:
        """The log-density, -inf where the density is zero or not finite."""
        with np.errstate(all="ignore"):
            value = self._log_density(y)
        return np.where(np.isfinite(value), value, -np.inf)

    def _check_poles(self, marks: Array, power: float) -> None:
        """InputError where the density diverges, except at a lower end x = 0 with a known power."""
        places = np.unique(np.concatenate([marks, [self._lower, self._upper]]))
        places = places[(places >= self._lower) & (places <= self._upper) & np.isfinite(places)]
        if np.isfinite(power):
            places = places[(places != self._lower) | (places + self._origin != 0.0)]
        least = 1e-40 * float(np.abs(places).max(initial=1e-160))
        step = 8.0 * np.maximum(np.spacing(np.abs(places)), least)
        for side in (-step, step):
            with np.errstate(invalid="ignore"):
                rise = self._log_at(places + side) - self._log_at(places + _WIDER * side)
            for at in places[rise > _POLE * np.log(_WIDER)] + self._origin:
                needed = (
                    "_cdf and _sf, too: positions are too coarse there"
                    if at
                    else "its onset_power, too"
                )
                raise InputError(f"thresholds: the density diverges at x = {at:g}; state {needed}")

    def _panels(self, points: Array) -> tuple[Array, float]:
        """Set the panels' edges, shape (n + 1,), down to weights of exp(-745); exp(log density - top) at the nodes,
        shape (n, 12), and top. InputError where 20,000 panels do not resolve the density."""
        edges, top = self._first_edges(points)
        left, right = edges[:-1], edges[1:]
        log = self._log_at(left[:, None] + (right - left)[:, None] * _PLACES) - top
        before: Array = np.full(left.shape, np.inf)
        done_left, done_values, count = [], [], left.size
        while left.size:
            if count > _MOST:
                rule = f"{_MOST} panels do not follow it; smooth it"
                raise InputError(f"thresholds: the density is too rough: {rule}")
            width, middle = right - left, 0.5 * (left + right)
            halves = (
                np.stack([left, middle], axis=-1)[..., None] + 0.5 * width[:, None, None] * _PLACES
            )
            finer = self._log_at(halves.reshape(left.size, -1)) - top
            highest = finer.max(axis=1)
            place = np.maximum(np.abs(left), np.abs(right))
            with np.errstate(all="ignore"):  # where the density is zero
                spread = highest - finer.min(axis=1)
                beside = highest[:, None]
                missed = np.abs(np.exp(log - beside) @ _TO_HALVES.T - np.exp(finer - beside)).max(
                    axis=1
                )
                rounding = 16.0 * _EPSILON * (np.abs(highest) + spread * place / width)
            rough = (missed > _ACCURACY + rounding) & ((missed < 0.7 * before) | (missed > _NOISE))
            rough |= spread > _SPREAD
            rough &= (highest > -_NOTHING - 20.0) & (width > 64.0 * _EPSILON * place)
            rough &= (left > self._lower) & (right < self._upper)
            done_left.append(left[~rough])
            done_values.append(np.exp(log[~rough]))
            before, log = np.repeat(missed[rough], 2), finer[rough].reshape(-1, _NODES)
            left = np.stack([left[rough], middle[rough]], axis=-1).ravel()
            right = np.stack([middle[rough], right[rough]], axis=-1).ravel()
            count += left.size // 2
        lefts = np.concatenate(done_left)
        order = np.argsort(lefts)
        self._edges = np.append(lefts[order], edges[-1])
        return np.concatenate(done_values)[order], top

    def _first_edges(self, points: Array) -> tuple[Array, float]:
        """Edges that halve towards the ends and where most weight is, and the log of the density there."""
        ends = np.array([self._lower, self._upper])
        seen, most = self._around(np.concatenate([points, ends]), _STEPS), -np.inf
        while True:  # a peak may be far narrower than the steps
            density = self._log_at(seen)
            weight = density + np.log(seen - self._lower)
            at = int(weight.argmax())
            top, highest = density[at], seen[at]
            if not weight[at] > most + 0.1:
                break
            most = weight[at]
            seen = np.union1d(seen, self._around(np.array([highest]), _STEPS))
        if np.isneginf(top):
            raise InputError(
                "thresholds: the density is zero, or no number, wherever it was looked at"
            )
        live = seen[weight > weight[at] - _NOTHING]
        start = seen.max(where=seen < live.min(), initial=self._lower)
        end = seen.min(where=seen > live.max(), initial=min(self._upper, 2.0 * float(seen.max())))
        width = np.abs(seen - highest).min(where=density < top - 1.0, initial=end - start)
        halvings = _HALVINGS + np.log2((end - start) / (highest - self._lower))
        # more halvings where the density near the lower end is not yet its power
        least = max(1e-290, 64.0 * _EPSILON * abs(self._lower))
        while np.isfinite(self._power) and (y := (end - start) * 0.5**halvings) > least:
            log = self._log_at(self._lower + y * np.array([0.5, 1.0]))
            if not np.isfinite(log).all() or (
                abs(log[1] - log[0] - self._power * np.log(2.0)) < _ONSET
            ):
                break
            halvings += 40.0
        halved = (end - start) * 0.5 ** np.arange(halvings)
        if start - self._lower < halved[-1]:
            start = self._lower
        near = self._around(np.array([highest]), halved[halved > 0.25 * width])
        parts = [points, np.array([start, end, highest]), self._around(ends, halved), near]
        edges = np.unique(np.concatenate(parts))
        return edges[(edges >= start) & (edges <= end)], float(top)

    def _around(self, places: Array, steps: Array) -> Array:
        """The points at these distances on either side of the finite places, inside the support."""
        places = places[np.isfinite(places)][:, None]
        found = np.unique(np.concatenate([places - steps, places + steps]))
        return found[(found > self._lower) & (found < self._upper)]

    def _before(self, x: Array) -> tuple[Indices, Array]:
        """The panels in which x lie, and the weight of the panel to the left of x."""
        y = np.clip(x - self._origin, self._edges[0], self._edges[-1])
        panel = np.clip(np.searchsorted(self._edges, y, side="right") - 1, 0, self._widths.size - 1)
        away = y - self._edges[panel]
        place = 2.0 * (away / self._widths[panel]) - 1.0
        # Clenshaw's sum of the Chebyshev series
        later, last, twice = np.zeros(y.shape), np.zeros(y.shape), 2.0 * place
        for row in self._means[:0:-1]:
            later, last = row.take(panel) + twice * later - last, later
        weight = away * (self._means[0].take(panel) + place * later - last)
        first = panel == 0
        if first.any() and np.isfinite(self._power):
            share = away[first] / self._widths[0]
            weight[first] = self._masses[0] * share ** (self._power + 1.0)
        return panel, weight

    def logpdf(self, x: Array) -> Array:
        """Log of the normalised density at x (lengths)."""
        return self._log_density(x - self._origin) - self.log_whole

    def cdf(self, x: Array) -> Array:
        """Probability of at most x."""
        panel, weight = self._before(x)
        return np.where(
            x - self._origin < self._edges[-1], np.minimum(self._below[panel] + weight, 1.0), 1.0
        )

    def sf(self, x: Array) -> Array:
        """Probability of more than x."""
        panel, weight = self._before(x)
        return np.clip(self._above[panel + 1] + (self._masses[panel] - weight), 0.0, 1.0)

    def logsf(self, x: Array) -> Array:
        """Log of the survival; where that underflows, by Laguerre's nodes along the tail."""
        panel, weight = self._before(x)
        survival = self._above[panel + 1] + (self._masses[panel] - weight)
        with np.errstate(divide="ignore", invalid="ignore"):
            out = np.log(survival)
        near, deep = survival > 0.6, ~(survival > _DEEP)
        out[near] = np.log1p(-np.minimum(self._below[panel[near]] + weight[near], 1.0))
        if deep.any():
            out[deep] = self._log_tail(x[deep] - self._origin)
        return out

    def _log_tail(self, y: Array) -> Array:
        """Log survival far out, where the density falls by a factor e over much less than y."""
        start = self._log_at(y)
        fall = 1e-3 * (y - self._lower)
        # the log-density may overflow, too
        with np.errstate(divide="ignore", invalid="ignore"):
            for _ in range(30):
                drop = start - self._log_at(y + fall)
                fall = fall / np.where(
                    np.isfinite(drop) & (drop > 0.0), np.clip(drop, 0.1, 1e3), 1e3
                )
            along = (
                self._log_at(y[:, None] + fall[:, None] * _TAIL_PLACES)
                - start[:, None]
                + _TAIL_PLACES
            )
            out = start - self.log_whole + np.log(fall * (np.exp(along) @ _TAIL_WEIGHTS))
        return np.where(np.isneginf(start), -np.inf, out)

    def bracket(self, hazard: Array) -> tuple[Array, Array]:
        """Lengths x between which -log of the survival reaches `hazard`."""
        panel = np.searchsorted(self._hazards, hazard)
        low, high = np.maximum(panel - 2, 0), np.minimum(panel + 1, self._edges.size - 1)
        return self._edges[low] + self._origin, self._edges[high] + self._origin

    def moment(self, n: float, centre: float = 0.0) -> float:
        """<(x - centre)^n>, a length to the power n; inf where the tail is too heavy for it."""
        with np.errstate(over="ignore", invalid="ignore"):
            each = self._node_weights * (self._nodes + (self._origin - centre)) ** n
        parts = np.where(self._node_weights > 0.0, each, 0.0).sum(axis=1)
        total, far = float(parts.sum()), float(parts[self._above[:-1] < _RARE].sum())
        return np.inf if self._upper == np.inf and far > _HEAVY * total else total
