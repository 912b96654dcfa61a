"""First passage at one speed: survival of contacts whose thresholds age towards a normal law.

A contact has the stretch `start` at t = 0 and a fresh threshold; its stretch grows at one speed, and it breaks where
|stretch| first meets its threshold. If thresholds went on ageing when they are met, all that are below |stretch| at t
would have been met at some moment before: with b the breaks per unit of the way t,

    P(below at t | fresh) = integral_0^t b(τ) P(below at t | met at τ) dτ,       E(t) = 1 - integral_0^t b dτ.

That is number conservation again, and both probabilities are known in closed form, as free
thresholds are an Ornstein-Uhlenbeck process. It is solved panel by panel; on each 2 s b is a Legendre
series in s = t^(1/2), in which b is smooth from the start. A stretch that begins below 0 turns at 0,
where a panel ends. (The probabilities above |stretch| obey the same equation, but they are nearly 1
where thresholds move away from |stretch|, and b would be lost in their rounding.)
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.special import ndtr

from master.renewal import rule
from master.renewal.rule import Rows
from master.renewal.table import Table
from origins import Ageing, Thresholds
from origins.errors import InputError, refuse
from origins.thresholds.law import Array
from origins.thresholds.quadrature import finite_density, panel_edges

# Nodes and weights on (0, 1), of the integral over earlier breaks between two of its cuts.
_INNER, _INNER_WEIGHTS = rule.gauss(12).nodes, rule.gauss(12).series[:, 0]
_SIZE = rule.DEGREE


class _Earlier(NamedTuple):
    """Nodes s of integrals over earlier breaks, a row for each part between two cuts, and their
    weights times the share that is below now; `row` (n,) is the number of the integral."""

    row: Rows
    node: Array
    weight: Array


class Passage:
    """E(lag) of contacts born together whose thresholds age towards a Gaussian final law.

    fresh : P_ci, conditional on being above |start|; exact values allowed
    ageing : with an uncut Gaussian final law (`normal` is not None)
    velocity : v > 0, a length per time
    start : stretch at the birth (a length); a negative one first rises to 0
    accuracy : largest error of the survival from one panel
    error : estimate of the largest error of the survival, without that by rounding

    Raises InputError where no threshold lies above |start|.
    """

    def __init__(
        self, fresh: Thresholds, ageing: Ageing, velocity: float, start: float, accuracy: float
    ) -> None:
        """Tabulate the breaks along the way; InputError for a start beyond every threshold."""
        normal = ageing.normal
        assert normal is not None and velocity > 0.0
        least = abs(start)
        if not float(fresh.sf(least)) > 0.0:
            refuse("start", start, "lies beyond every threshold; contacts there hold nothing")
        # less ageing has no effect in floating point
        diffusion = max(ageing.rate / velocity, 1e-28 * fresh.mean())
        self._mean, self._std, self._rate = normal.mean, normal.std, diffusion / normal.std**2
        self._velocity, self._start, self._accuracy = velocity, start, accuracy
        self._turn = max(-start, 0.0)  # way after which |stretch| turns at 0
        # the fresh thresholds of contacts that hold at first: exact values, and edges of the others
        self._fresh, self._held, above = fresh, float(fresh.sf(least)), fresh.atoms[0] > least
        self._values, self._weights = (part[above] for part in fresh.atoms)
        self._pieces = np.unique(np.maximum(np.append(panel_edges(fresh), least), least))
        # least way over which the share that is below now changes
        self._finest = 0.5 * min(4.0 * diffusion, 1.0 / self._rate)
        self._first = 0.1 * float(np.sqrt(min(diffusion, 1.0 / self._rate, 0.1 * normal.std)))
        # ends of the panels in s, and Legendre coefficients of 2 s b
        self._edges, self._series = [0.0], list[Array]()
        self._left, self.error = 1.0, 0.0
        # the march ends at the latest where no threshold has ever been
        furthest = max(float(fresh.isf(1e-16)), normal.mean) + 12.0 * normal.std
        for way in (self._turn, furthest - start):
            self._march(way)
        self.error += max(self._left, 0.0)
        given = lambda s: self._density(s)[None], np.array(self._edges), np.inf, 0.0
        self._broken = Table(*given, size=_SIZE)

    def survival(self, lag: Array) -> Array:
        """E at times `lag` >= 0 since the birth, same shape."""
        s = np.sqrt(lag * self._velocity)
        return np.clip(1.0 - self._broken.before(s), 0.0, 1.0) * (s < self._edges[-1])

    def _march(self, way: float) -> None:
        """Add panels up to this way, or until hardly any contact holds."""
        last, left, width = float(np.sqrt(way)), self._edges[-1], self._first
        while left < last and self._left > 1e-14:  # the size of rounding
            step = min(width, last - left)
            series = self._panel(left, step)
            # the last coefficients, in the integral of the density
            early, tail = (np.abs(series[-k:]).max() * step / (2.0 * _SIZE) for k in (6, 2))
            if tail > self._accuracy and step > 1e-9 * (left + step):
                width = 0.5 * step
                continue
            left += step
            self._edges.append(left)
            self._series.append(series)
            self._left -= float(series[0]) * step  # the first coefficient is the mean
            self.error += float(tail)
            width = step * (2.0 if early < self._accuracy else 1.0)
            if len(self._series) > 4000:  # a smooth law takes some 50
                told = "needs more than 4000 panels; use a smoother law of fresh thresholds"
                raise InputError(f"ageing: the first passage {told}")

    def _density(self, s: Array) -> Array:
        """2 s b at points of finished panels, each row within one; same shape."""
        edges, middle = np.array(self._edges), s[:, s.shape[1] // 2]
        panel = np.clip(np.searchsorted(edges, middle, side="right") - 1, 0, edges.size - 2)
        low, high = edges[panel, None], edges[panel + 1, None]
        z = (2.0 * s - low - high) / (high - low)
        return rule.legendre_sum(np.array(self._series)[panel], z)

    def _panel(self, left: float, width: float) -> Array:
        """Legendre coefficients of 2 s b on a panel, from the shares below the level at its nodes."""
        s, matrix = left + width * rule.NODES, np.zeros((_SIZE, _SIZE))
        level = np.abs(self._start + s * s)
        below = self._below_from_fresh(s * s, level)
        row, node, weight = self._earlier(s, level)
        own = node[:, 0] > left
        if not own.all():
            met = (weight[~own] * self._density(node[~own])).sum(axis=-1)
            below -= np.bincount(row[~own], weights=met, minlength=_SIZE)
        basis = legendre.legvander((2.0 / width) * (node[own] - left) - 1.0, _SIZE - 1)
        np.add.at(matrix, row[own], np.einsum("nq,nqk->nk", weight[own], basis))
        return np.asarray(np.linalg.solve(matrix, below), dtype=float)

    def _earlier(self, s: Array, level: Array) -> _Earlier:
        """Nodes for the breaks up to s (n,), where the level is now. Parts end at the panels' edges and get finer
        towards s; nodes are even in the root of the distance from s, in which the singular integrand is smooth."""
        # 40 doublings: from D/v up to any length
        doubled = np.sqrt(self._finest / (2.0 * s))[:, None] * 2.0 ** np.arange(40)
        fixed = np.tile(self._edges, (s.size, 1))
        ends = np.concatenate([fixed, s[:, None] - doubled**2, s[:, None]], axis=1)
        ends = np.sort(np.clip(ends, 0.0, s[:, None]), axis=1)
        row, column = np.nonzero(ends[:, 1:] > ends[:, :-1])
        top = s[row, None]
        far, near = (np.sqrt(top - ends[row, column + k, None]) for k in (0, 1))
        root = near + (far - near) * _INNER
        elapsed = root * root * (2.0 * top - root * root)
        rise = np.minimum(elapsed, 2.0 * np.maximum(top * top - self._turn, 0.0) - elapsed)
        # shares now below the level of the thresholds that were at the level of then, `rise` lower
        decay, lost = np.exp(-self._rate * elapsed), -np.expm1(-self._rate * elapsed)
        distance = (level[row, None] - self._mean) * lost + rise * decay
        below = ndtr(distance / (self._std * np.sqrt(lost * (1.0 + decay))))
        weight = (far - near) * _INNER_WEIGHTS * 2.0 * root * below
        return _Earlier(row, top - root * root, weight)

    def _below_from_fresh(self, time: Array, level: Array) -> Array:
        """Share below `level` of the thresholds that were fresh a way `time` > 0 ago, all of shape (n,)."""
        decay, lost = np.exp(-self._rate * time)[:, None], -np.expm1(-self._rate * time)[:, None]
        offset, std = (level - self._mean)[:, None], self._std * np.sqrt(lost * (1.0 + decay))

        def below(values: Array, row: Rows | slice) -> Array:
            return np.asarray(ndtr((offset[row] - (values - self._mean) * decay[row]) / std[row]))

        # from one to the next of these fresh thresholds, what `ndtr` takes changes by 1
        steep = self._mean + (offset + std * np.arange(-9.0, 9.5)) / np.maximum(decay, 1e-150)
        steep = np.clip(steep, self._pieces[0], self._pieces[-1])
        ends = np.concatenate([np.tile(self._pieces, (time.size, 1)), steep], axis=1)
        row, low, high = rule.Pieces.between(ends)
        values = low[:, None] + (high - low)[:, None] * _INNER
        each = finite_density(self._fresh, values) * below(values, row) @ _INNER_WEIGHTS
        spread = np.bincount(row, each * (high - low), time.size)
        return (spread + below(self._values, slice(None)) @ self._weights) / self._held
