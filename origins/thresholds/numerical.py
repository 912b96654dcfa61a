"""A law computed from its log-density: cdf, survival and moments on panels, with relative accuracy in both tails."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, laguerre, legendre

from origins.errors import InputError

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]

_NODES = 12  # of Gauss and Legendre on each panel
_ACCURACY = 1e-13  # of the polynomial, relative to the largest density on its panel
_NOISE = 1e-8  # an error below it that halving does not reduce may be rounding of the density
_NOTHING = 708.0  # minus the log of the smallest relative weight: smaller floats have fewer digits
_STEPS = 2.0 ** np.arange(-432.0, 433.0)  # distances at which panels end, in any unit of length
_EPSILON = float(np.finfo(float).eps)

_S, _W = legendre.leggauss(_NODES)
_PLACES, _WEIGHTS = 0.5 * (_S + 1.0), 0.5 * _W  # on (0, 1)
_HALVED = np.concatenate([0.5 * _PLACES, 0.5 + 0.5 * _PLACES])
# Matrices from the density at the nodes to its Chebyshev series, to its values at the nodes of the
# two halves, and to the series of its mean between the left end and a place.
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(_S, _NODES - 1))
_TO_HALVES = chebyshev.chebvander(2.0 * _HALVED - 1.0, _NODES - 1) @ _TO_SERIES
_INTEGRALS = chebyshev.chebval(_S, chebyshev.chebint(_TO_SERIES, lbnd=-1.0)).T
_TO_MEAN = _TO_SERIES @ (_INTEGRALS / (1.0 + _S)[:, None])
_TAIL_PLACES, _TAIL_WEIGHTS = laguerre.laggauss(24)


def clipped(x: Any, low: Any, high: Any) -> Any:
    """x, from `low` to `high`: np.clip, whose checks take ten times as long as the work on a few numbers."""
    return np.minimum(np.maximum(x, low), high)


class NumericalLaw:
    """The normalised law of a density that is smooth between given points.

    Panels are halved until a polynomial of degree 11 fits the density on each, and the weights of all panels are
    added from both ends: cdf and survival keep a relative 1e-12 of an exact log-density, down to 1e-300 (in lengths of
    1e±s down to 10^(s - 300)) or, of a tail x^-b, whose density underflows before its survival, to 10^(-300 b/(b+1)).

    log_density : function of arrays x (lengths), the log of the density, which need not be normalised.
    lower, upper : ends of the support (lengths); upper may be inf.
    points : array of the places where the density or one of its derivatives jumps.
    power : m of a density (x - lower)^m at the lower end; inf if it is no power, or not known.
    log_whole : log of the integral of the density as given.

    Raises InputError where the density is zero at all places looked at, and where panels do not follow it: it is too
    rough, or diverges elsewhere than at a lower end x = 0 with a known power.
    """

    def __init__(
        self, log_density: Function, lower: float, upper: float, points: Array, power: float
    ) -> None:
        """Halve panels of the density until its integral is resolved, and sum it up from both ends."""
        self._log_density, self._lower, self._upper = log_density, lower, upper
        self._power, self._top, log_onset = power, -np.inf, -np.inf
        values, missed = self._halve(self._first_edges(points))
        self._widths = np.diff(self._edges)
        # on the first panel the density is its power; the nodes get its mean
        if np.isfinite(self._power):
            log_onset = float(self._log_at(self._edges[1:2])[0])
            values[0], missed[0] = np.exp(log_onset - self._top) / (power + 1.0), 0.0
        masses = self._widths * (values @ _WEIGHTS)
        whole = float(masses.sum())
        errors = np.where(missed > _NOISE, missed * masses, 0.0)
        if not errors.sum() < 1e-10 * whole:  # beside a pole panels cannot be halved enough
            at = f"at x = {self._edges[errors.argmax()]:g}; state _cdf, _sf and _moment, too"
            raise InputError(f"thresholds: the density diverges, or is too rough, {at}")
        self.log_whole = self._top + float(np.log(whole))
        self._masses, values = masses / whole, values / whole
        self._means, self._densities = _TO_MEAN @ values.T, _TO_SERIES @ values.T
        self._nodes = self._edges[:-1, None] + self._widths[:, None] * _PLACES
        self._node_weights = self._widths[:, None] * values * _WEIGHTS
        self._below = np.append(0.0, np.cumsum(self._masses))
        self._above = np.append(np.cumsum(self._masses[::-1])[::-1], 0.0)

    def _log_at(self, x: Array) -> Array:
        """The log-density, -inf where the density is zero or not finite."""
        with np.errstate(all="ignore"):
            value = self._log_density(x)
        return np.where(np.isfinite(value), value, -np.inf)

    def _around(self, *places: float) -> Array:
        """The points at all distances on either side of the finite places, inside the support."""
        finite = [place for place in places if np.isfinite(place)]
        points = np.unique([place + side * _STEPS for place in finite for side in (-1, 1)])
        return points[(points > self._lower) & (points < self._upper)]

    def _first_edges(self, points: Array) -> Array:
        """Edges that halve towards the ends and where most weight is; the first is the onset's power, if it is one.
        Keeps the log of the largest density seen, and drops a power that the density does not follow."""
        places, most = self._around(*points, self._lower, self._upper), -np.inf
        while True:  # a peak may be far narrower than the steps
            density = self._log_at(places)
            weight = density + np.log(places - self._lower)
            highest, self._top = float(places[weight.argmax()]), float(density[weight.argmax()])
            if not weight.max() > most + 0.1:
                break
            most = weight.max()
            places = np.union1d(places, self._around(highest))
        if np.isneginf(self._top):
            raise InputError("thresholds: the density is zero, or no number, at all places tried")
        inside = points[(points > self._lower) & (points < self._upper)]
        edges = np.union1d(self._around(self._lower, self._upper, highest), [*inside, highest])
        log, log_away = self._log_at(edges), np.log(edges - self._lower)
        counted = np.flatnonzero(log + log_away >= weight.max() - _NOTHING)
        first, from_lower = max(counted[0] - 1, 0), bool(counted[0] == 0)
        if from_lower and np.isfinite(self._power):
            with np.errstate(invalid="ignore"):
                deviation = np.abs(np.diff(log) - self._power * np.diff(log_away))
            # the log-density deviates from its power, from one edge to the next
            first = int((~(deviation < 1e-12 + 4.0 * _EPSILON * np.abs(log[1:]))).argmax())
            # moments take the first panel as if its weight were spread evenly: it must be short
            short = self._lower + 1e-18 * (highest - self._lower)
            first = min(first, int(np.searchsorted(edges, short)))
        if not from_lower or log[first] == -np.inf:
            self._power = np.inf
        ends = [self._lower] if from_lower else [], [self._upper]
        edges = np.concatenate([ends[0], edges[first : counted[-1] + 2], ends[1]])
        return edges[np.isfinite(edges)]

    def _halve(self, edges: Array) -> tuple[Array, Array]:
        """Keep edges of n panels on which polynomials follow the density. Returns its values at their nodes, relative
        to the largest, shape (n, 12), and the polynomials' errors, relative to the largest on a panel, shape (n,)."""
        left, right = edges[:-1], edges[1:]
        log = self._log_at(left[:, None] + (right - left)[:, None] * _PLACES) - self._top
        before: Array = np.full(left.shape, np.inf)
        done, count = [], left.size
        while left.size:
            if count > 20_000:  # smooth densities take some 300
                fault = f"{count} panels do not follow it; smooth it"
                raise InputError(f"thresholds: the density is too rough: {fault}")
            width, place = right - left, np.maximum(np.abs(left), np.abs(right))
            finer = self._log_at(left[:, None] + width[:, None] * _HALVED) - self._top
            highest = finer.max(axis=1)
            with np.errstate(all="ignore"):  # where the density is zero
                spread, beside = highest - finer.min(axis=1), highest[:, None]
                fitted = np.exp(log - beside) @ _TO_HALVES.T
                missed = np.abs(fitted - np.exp(finer - beside)).max(axis=1)
                rounding = 16.0 * _EPSILON * (np.abs(highest) + spread * place / width)
            rough = (missed > _ACCURACY + rounding) & ((missed < 0.7 * before) | (missed > _NOISE))
            # the log-density changes little over a panel, so that small densities are as accurate
            rough |= spread > 2.1
            rough &= (highest > -_NOTHING) & (width > 64.0 * _EPSILON * place)
            rough &= (left > self._lower) & (right < self._upper)
            done.append(np.column_stack([left, missed, np.exp(log)])[~rough])
            left, right, before = left[rough], right[rough], np.tile(missed[rough], 2)
            log = np.concatenate([finer[rough, :_NODES], finer[rough, _NODES:]])
            middle = 0.5 * (left + right)
            left, right = np.append(left, middle), np.append(middle, right)
            count += middle.size
        panels = np.concatenate(done)
        panels = panels[panels[:, 0].argsort()]
        self._edges = np.append(panels[:, 0], edges[-1])
        return panels[:, 2:], np.nan_to_num(panels[:, 1])

    def _sides(self, x: Array) -> tuple[Array, Array]:
        """The weights below and above x, each to its own accuracy."""
        y = clipped(x, self._edges[0], self._edges[-1])
        panel = clipped(np.searchsorted(self._edges, y, side="right") - 1, 0, self._widths.size - 1)
        away = y - self._edges[panel]
        place = 2.0 * (away / self._widths[panel]) - 1.0
        mean, after = np.zeros((2, *place.shape))
        for each in self._means[:0:-1]:  # Clenshaw's recurrence, which takes far longer in chebval
            mean, after = each[panel] + 2.0 * place * mean - after, mean
        weight = away * (self._means[0][panel] + place * mean - after)
        if np.isfinite(self._power):
            first = panel == 0
            fraction = away[first] / self._widths[0]
            weight[first] = self._masses[0] * fraction ** (self._power + 1.0)
        above = self._above[panel + 1] + (self._masses[panel] - weight)
        return self._below[panel] + weight, np.maximum(above, 0.0)

    def quantiles(self, below: Array, above: Array) -> Array:
        """The places with these weights below and above them, the smaller of which is exact, by Newton's steps."""
        rising, falling = self._below[1:-1], -self._above[1:-1]
        low = below < above
        panel = np.where(low, rising.searchsorted(below), falling.searchsorted(-above))
        mass, width = self._masses[panel], self._widths[panel]
        weight = np.where(low, below - self._below[panel], mass - (above - self._above[panel + 1]))
        means, densities = self._means.take(panel, axis=1), self._densities.take(panel, axis=1)
        with np.errstate(all="ignore"):  # where a panel has no weight
            fraction = start = clipped(np.nan_to_num(weight / mass), 0.0, 1.0)
            for _ in range(6):  # four are enough, as the density varies little over a panel
                place = 2.0 * fraction - 1.0
                missing = weight / width - fraction * chebyshev.chebval(place, means, tensor=False)
                step = missing / chebyshev.chebval(place, densities, tensor=False)
                fraction = clipped(fraction + np.nan_to_num(step), 0.0, 1.0)
        if np.isfinite(self._power):
            fraction = np.where(panel == 0, start ** (1.0 / (self._power + 1.0)), fraction)
        return self._edges[panel] + width * fraction

    def logpdf(self, x: Array) -> Array:
        """Log of the normalised density at x (lengths)."""
        return self._log_density(x) - self.log_whole

    def cdf(self, x: Array) -> Array:
        """Probability of at most x."""
        below, above = self._sides(x)
        return np.where(below < 0.5, below, 1.0 - above)

    def sf(self, x: Array) -> Array:
        """Probability of more than x."""
        below, above = self._sides(x)
        return np.where(below < 0.5, 1.0 - below, above)

    def logsf(self, x: Array) -> Array:
        """Log of the survival, near 0 from the weight below x; where the survival underflows, by Laguerre's nodes along
        the tail."""
        below, above = self._sides(x)
        low = below < 0.5
        with np.errstate(divide="ignore"):
            log_survival = np.where(low, np.log1p(-np.where(low, below, 0.0)), np.log(above))
        deep = above < 1e-280
        if deep.any():
            log_survival[deep] = self._log_tail(x[deep])
        return log_survival

    def _log_tail(self, x: Array) -> Array:
        """Log survival far out, where the density falls by a factor e over much less than x."""
        start, step = self._log_at(x), 1e-7 * np.minimum(x - self._lower, self._upper - x)
        # the log-density may overflow, too
        with np.errstate(all="ignore"):
            fall = (step / (start - self._log_at(x + step)))[:, None]
            along = self._log_at(x[:, None] + fall * _TAIL_PLACES) - start[:, None] + _TAIL_PLACES
            along[np.abs(start) > 1e13] = 0.0  # only rounding is left of it
            out = start - self.log_whole + np.log(fall[:, 0] * (np.exp(along) @ _TAIL_WEIGHTS))
        return np.where(np.isneginf(start), -np.inf, out)

    def moment(self, n: float, centre: float = 0.0) -> float:
        """<(x - centre)^n>, a length to the power n; inf where the tail is too heavy for it."""
        with np.errstate(over="ignore", invalid="ignore"):
            each = self._node_weights * (self._nodes - centre) ** n
        parts = np.where(self._node_weights > 0.0, each, 0.0).sum(axis=1)
        # infinite if more than 1e-9 of it comes from a survival below 1e-100
        total, far = float(parts.sum()), float(parts[self._above[:-1] < 1e-100].sum())
        return np.inf if self._upper == np.inf and far > 1e-9 * total else total
