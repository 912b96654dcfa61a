"""One law from its log-density: cdf, survival and moments on panels, with relative accuracy in both tails."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, laguerre, legendre

from origins.errors import InputError
from origins.thresholds.density_panels import NODES, PLACES, TO_SERIES, WEIGHTS, Density

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

# Where as much of a moment as _HEAVY comes from thresholds as rare as _RARE, it is infinite.
_RARE, _HEAVY = 1e-100, 1e-9
_DEEP = 1e-280  # survival below which it is an integral along the tail
_TAIL_PLACES, _TAIL_WEIGHTS = laguerre.laggauss(24)
# Matrix from a density at a panel's nodes to the Chebyshev series of its mean between the panel's
# left end and a place on it.
_S = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
_MEANS = legendre.legval(_S, legendre.legint(TO_SERIES, lbnd=-1.0)).T / (1.0 + _S)[:, None]
_TO_MEAN = np.linalg.solve(chebyshev.chebvander(_S, NODES - 1), _MEANS)


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

    Raises InputError for a density that 20,000 panels do not follow, and for one that diverges, but at x = 0 with a
    known power: beside such a place positions are too coarse for a density to tell the weights.
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
        self._origin = origin
        self._density = Density(log_density, lower - origin, upper - origin, power)
        marks = np.append(np.asarray(points, dtype=float) - origin, 0.0)
        if (pole := self._density.pole(marks, origin)) is not None:
            at = pole + origin
            needed = (
                "_cdf and _sf, too: positions are too coarse there"
                if at
                else "its onset_power, too"
            )
            raise InputError(f"thresholds: the density diverges at x = {at:g}; state {needed}")
        panels = self._density.panels(marks)
        self._edges, self._widths = panels.edges, np.diff(panels.edges)
        masses = self._widths * (panels.values @ WEIGHTS)
        # next to the lower end the density is its power
        self._power = power if self._edges[0] == self._density.lower else np.inf
        if np.isfinite(self._power):
            level = float(self._density.log_at(self._edges[1:2])[0])
            masses[0] = np.exp(level - panels.top) * self._widths[0] / (power + 1.0)
        whole = float(masses.sum())
        self.log_whole = panels.top + float(np.log(whole))
        self._masses, values = masses / whole, panels.values / whole
        self._means = values @ _TO_MEAN.T
        self._nodes = self._edges[:-1, None] + self._widths[:, None] * PLACES
        self._node_weights = self._widths[:, None] * values * WEIGHTS
        self._below = np.concatenate([[0.0], np.cumsum(self._masses)])
        self._above = np.concatenate([np.cumsum(self._masses[::-1])[::-1], [0.0]])
        with np.errstate(divide="ignore"):
            upper_half = -np.log(self._above)
        self._hazards = np.where(
            self._below < 0.5, -np.log1p(-np.minimum(self._below, 0.5)), upper_half
        )

    def _before(self, x: Array) -> tuple[Indices, Array]:
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
        return self._density.log_density(x - self._origin) - self.log_whole

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
        """Log survival far out, where the density falls by e over much less than y."""
        start = self._density.log_at(y)
        fall = 1e-3 * (y - self._density.lower)
        # the log-density, too, may be beyond all numbers
        with np.errstate(divide="ignore", invalid="ignore"):
            for _ in range(30):
                drop = start - self._density.log_at(y + fall)
                fall = fall / np.where(
                    np.isfinite(drop) & (drop > 0.0), np.clip(drop, 0.1, 1e3), 1e3
                )
            along = (
                self._density.log_at(y[:, None] + fall[:, None] * _TAIL_PLACES)
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

    def moment(self, n: int, centre: float = 0.0) -> float:
        """<(x - centre)^n>, a length to the power n; inf where the tail is too heavy for it."""
        with np.errstate(over="ignore", invalid="ignore"):
            each = self._node_weights * (self._nodes + (self._origin - centre)) ** n
        parts = np.where(self._node_weights > 0.0, each, 0.0).sum(axis=1)
        total = float(parts.sum())
        far = float(parts[self._above[:-1] < _RARE].sum())
        return np.inf if self._density.upper == np.inf and far > _HEAVY * total else total
