"""One law from its log-density: cdf, survival and moments on panels, with relative accuracy in both tails."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, legendre

from origins.errors import InputError

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

_NODES = 12  # of Gauss and Legendre on each panel
_SPREAD = 1.6  # change of the log-density over a panel: its interpolant then errs by 1e-14
_NOTHING = 745.0  # log of the mass beside the highest one: exp(-745) is the least number there is
_HALVINGS = (
    110  # panels halve towards each end of the support and each point, to 1e-33 of the whole
)
_ACCURACY = 1e-13  # of the interpolant, relative to the largest density on its panel
_NOISE = 1e-8  # of the same, the largest that the rounding of a density may leave
_POLE = (
    0.1  # m of a density x^-m, from where on the place of a pole needs more digits than there are
)
_RARE, _HEAVY = (
    1e-100,
    1e-9,
)  # where so much of a moment comes from so rare thresholds, it is infinite
_EPSILON = float(np.finfo(float).eps)
_MOST = 20_000  # panels; smooth densities take some 500
_STEPS = np.geomspace(
    1e-130, 1e130, 2601
)  # distances at which a density is looked for, in any unit of length

_S, _WEIGHTS = legendre.leggauss(_NODES)
_T, _WEIGHTS = 0.5 * (_S + 1.0), 0.5 * _WEIGHTS  # on (0, 1)
_TAIL_T, _TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(24)
# density at the nodes -> its Legendre series; -> its values at the nodes of the two halves
_SERIES = (np.arange(_NODES) + 0.5)[:, None] * 2.0 * _WEIGHTS * legendre.legvander(_S, _NODES - 1).T
_HALF_S = np.concatenate([0.5 * (_S - 1.0), 0.5 * (_S + 1.0)])
_AT_HALVES = legendre.legvander(_HALF_S, _NODES - 1) @ _SERIES
# density at the nodes -> Chebyshev series of its mean from the panel's left end to a place
_PLACES = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
_MEANS = legendre.legval(_PLACES, legendre.legint(_SERIES, lbnd=-1.0)).T / (1.0 + _PLACES)[:, None]
_TO_MEAN = np.linalg.solve(chebyshev.chebvander(_PLACES, _NODES - 1), _MEANS)


class NumericalLaw:
    """The normalised law of a density that is smooth between given points.

    The panels halve until a polynomial of degree 11 follows the density on each, and the weights of all panels are
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
        Where a density far narrower than its place is written as a function of the distance from that place, so that
        no digits are lost.

    Attributes
    ----------
    log_whole : float
        Log of the integral of exp(log_density).

    Raises InputError for a density that 20,000 panels do not follow.
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
        self._log_density, self._origin, self._power = log_density, origin, power
        self._lower, self._upper = lower - origin, upper - origin
        marks = np.concatenate(
            [np.asarray(points, dtype=float) - origin, [0.0, self._lower, self._upper]]
        )
        edges, self._top = self._first_edges(marks)
        self._check_poles(marks)
        self._edges, values = self._resolved(edges)
        self._widths = np.diff(self._edges)
        masses = self._widths * (values @ _WEIGHTS)
        if np.isfinite(power):
            first = self._scaled(self._edges[1:2]) * self._widths[0] / (power + 1.0)
            masses[0] = first[0] if self._edges[0] == self._lower else masses[0]
        whole = float(masses.sum())
        self.log_whole = self._top + float(np.log(whole))
        self._masses = masses / whole
        self._means = (values / whole) @ _TO_MEAN.T
        self._nodes = self._edges[:-1, None] + self._widths[:, None] * _T
        self._node_weights = self._widths[:, None] * values * (_WEIGHTS / whole)
        self._below = np.concatenate([[0.0], np.cumsum(self._masses)])
        self._above = np.concatenate([np.cumsum(self._masses[::-1])[::-1], [0.0]])
        with np.errstate(divide="ignore"):
            self._hazards = np.where(
                self._below < 0.5, -np.log1p(-np.minimum(self._below, 0.5)), -np.log(self._above)
            )

    def _first_edges(self, marks: Array) -> tuple[Array, float]:
        """Edges that halve towards the ends and where most weight is, and the log of the density there."""
        seen = self._around(marks, _STEPS)
        density = self._log_at(seen)
        for _ in range(60):  # a peak may be far narrower than the steps
            at = int((density + np.log(seen - self._lower)).argmax())
            before, highest = density[at], seen[at]
            finer = np.linspace(seen[max(at - 1, 0)], seen[min(at + 1, seen.size - 1)], 17)
            seen = np.concatenate([seen, finer[(finer > self._lower) & (finer < self._upper)]])
            density = np.concatenate([density, self._log_at(seen[density.size :])])
            order = np.argsort(seen)
            seen, density = seen[order], density[order]
            if density.max() < before + 0.1:
                break
        beside = self._around(np.array([highest]), _STEPS)
        seen, density = np.append(seen, beside), np.append(density, self._log_at(beside))
        live = seen[
            density + np.log(seen - self._lower) > before + np.log(highest - self._lower) - _NOTHING
        ]
        start = seen.max(where=seen < live.min(), initial=self._lower)
        end = seen.min(where=seen > live.max(), initial=min(self._upper, 2.0 * float(seen.max())))
        away = np.abs(seen - highest)
        width = away.min(where=density < before - 1.0, initial=end - start)
        halved = (end - start) * 0.5 ** np.arange(
            np.log2((end - start) / (highest - self._lower)) + _HALVINGS
        )
        if start - self._lower < halved[-1]:
            start = self._lower
        edges = np.concatenate(
            [
                [start, end, highest],
                marks,
                self._around(marks[-2:], halved),
                self._around(np.array([highest]), halved[halved > 0.25 * width]),
            ]
        )
        return np.unique(edges[(edges >= start) & (edges <= end)]), float(before)

    def _check_poles(self, marks: Array) -> None:
        """InputError where the density diverges, but for a known power at 0: next to such a place lie weights that
        positions, rounded as they are, do not resolve."""
        if np.isfinite(self._power):
            marks = marks[(marks != self._lower) | (marks + self._origin != 0.0)]
        marks = np.unique(
            marks[np.isfinite(marks) & (marks >= self._lower) & (marks <= self._upper)]
        )
        step = 8.0 * np.maximum(
            np.spacing(np.abs(marks)), 1e-40 * np.abs(self._lower + marks).max(initial=1e-200)
        )
        for side in (-1.0, 1.0):
            near, far = (self._log_at(marks + side * step * further) for further in (1.0, 1024.0))
            with np.errstate(invalid="ignore"):
                poles = marks[near - far > _POLE * np.log(1024.0)]
            if poles.size:
                at = float(poles[0] + self._origin)
                rule = (
                    "its onset_power, too"
                    if at == 0.0
                    else "_cdf and _sf, too: positions are too coarse there"
                )
                raise InputError(f"thresholds: the density diverges at x = {at:g}; state {rule}")

    def _around(self, marks: Array, steps: Array) -> Array:
        """Places at these distances to either side of the finite marks, inside the support."""
        marks = marks[np.isfinite(marks)][:, None]
        places = np.unique(np.concatenate([marks - steps, marks + steps]))
        return places[(places > self._lower) & (places < self._upper)]

    def _log_at(self, y: Array) -> Array:
        with np.errstate(all="ignore"):
            value = self._log_density(y)
        return np.where(np.isfinite(value), value, -np.inf)

    def _scaled(self, y: Array) -> Array:
        return np.exp(self._log_at(y) - self._top)

    def _resolved(self, edges: Array) -> tuple[Array, Array]:
        """Edges of panels that the density's interpolant follows, and the density there, over that at the top."""
        left, right = edges[:-1], edges[1:]
        log = self._log_at(left[:, None] + (right - left)[:, None] * _T) - self._top
        done_left, done_values, count = [], [], left.size
        parent: Array = np.full(left.shape, np.inf)
        while left.size and count < _MOST:
            middle = 0.5 * (left + right)
            halves = np.stack([left, middle, middle, right], axis=-1).reshape(-1, 2, 2)
            finer = (
                self._log_at((halves[..., :1] + np.diff(halves) * _T).reshape(left.size, -1))
                - self._top
            )
            highest, lowest = finer.max(axis=1), finer.min(axis=1)
            spread = highest - lowest
            values = np.exp(log)
            with np.errstate(all="ignore"):  # where the density is zero
                rounding = np.abs(highest) + spread * np.maximum(np.abs(left), np.abs(right)) / (
                    right - left
                )
                own, halved = np.exp(log - highest[:, None]), np.exp(finer - highest[:, None])
                missed = np.abs(own @ _AT_HALVES.T - halved).max(axis=1)
                rough = (spread > _SPREAD) | (missed > _ACCURACY + 16.0 * _EPSILON * rounding)
            # what halving does not mend, and is small, is the rounding of the density itself
            rough &= (spread > _SPREAD) | (missed < 0.7 * parent) | (missed > _NOISE)
            rough &= (highest > -_NOTHING - 20.0) & (left > self._lower) & (right < self._upper)
            rough &= (right - left) > 64.0 * _EPSILON * np.maximum(np.abs(left), np.abs(right))
            done_left.append(left[~rough])
            done_values.append(values[~rough])
            parent = np.repeat(missed[rough], 2)
            log = finer[rough].reshape(-1, _NODES)
            left = np.stack([left[rough], middle[rough]], axis=-1).ravel()
            right = np.stack([middle[rough], right[rough]], axis=-1).ravel()
            count += left.size // 2
        if left.size:
            raise InputError(
                f"thresholds: the density is too rough: {_MOST} panels do not follow it; smooth it"
            )
        lefts = np.concatenate(done_left)
        order = np.argsort(lefts)
        return np.append(lefts[order], edges[-1]), np.concatenate(done_values)[order]

    def _before(self, x: Array) -> tuple[Places, Array]:
        """The panels that x lie in, and the weight there to the left of x."""
        y = np.clip(x - self._origin, self._edges[0], self._edges[-1])
        panel = np.clip(np.searchsorted(self._edges, y, side="right") - 1, 0, self._widths.size - 1)
        away = y - self._edges[panel]
        place = 2.0 * (away / self._widths[panel]) - 1.0
        # Clenshaw's sum of the Chebyshev series
        later, last = np.zeros(y.shape), np.zeros(y.shape)
        for row in self._means.T[:0:-1]:
            later, last = row[panel] + 2.0 * place * later - last, later
        weight = away * (self._means[panel, 0] + place * later - last)
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
        near, deep = survival > 0.6, ~(survival > 1e-280)
        out[near] = np.log1p(-np.minimum(self._below[panel[near]] + weight[near], 1.0))
        if deep.any():
            out[deep] = self._log_tail(x[deep] - self._origin)
        return out

    def _log_tail(self, y: Array) -> Array:
        """Log survival far out, where the density falls by e over much less than y."""
        start = self._log_at(y)
        fall = 1e-3 * (y - self._lower)
        with np.errstate(
            divide="ignore", invalid="ignore"
        ):  # where the log-density, too, is beyond all numbers
            for _ in range(30):
                drop = start - self._log_at(y + fall)
                fall = fall / np.where(
                    np.isfinite(drop) & (drop > 0.0), np.clip(drop, 0.1, 1e3), 1e3
                )
            along = self._log_at(y[:, None] + fall[:, None] * _TAIL_T) - start[:, None] + _TAIL_T
            out = start - self.log_whole + np.log(fall * (np.exp(along) @ _TAIL_WEIGHTS))
        return np.where(np.isneginf(start), -np.inf, out)

    def bracket(self, hazard: Array) -> tuple[Array, Array]:
        """Lengths x between which -log of the survival reaches `hazard`."""
        panel = np.searchsorted(self._hazards, hazard)
        low, high = np.maximum(panel - 2, 0), np.minimum(panel + 1, self._edges.size - 1)
        return self._edges[low] + self._origin, self._edges[high] + self._origin

    def moment(self, n: int, centre: float = 0.0) -> float:
        """<(x - centre)^n>, a length to the power n; inf where the tail is too heavy for it."""
        with np.errstate(over="ignore", invalid="ignore"):
            each = self._node_weights * (self._nodes + (self._origin - centre)) ** n
        parts = np.where(self._node_weights > 0.0, each, 0.0).sum(axis=1)
        total = float(parts.sum())
        far = float(parts[self._above[:-1] < _RARE].sum())
        return np.inf if self._upper == np.inf and far > _HEAVY * total else total
