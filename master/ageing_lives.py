"""Cohorts of contacts that age, on any motion: each strand of them carries the density of its thresholds.

With y = ξ - |x| the distance of a threshold from the stretch, which moves by σ = d|x|/dt, and h the rate of breaking
at a temperature,

    ∂u/∂t = ∂/∂y [(D U' + σ) u + D ∂u/∂y] - h u,     u = 0 at y = 0, where contacts break.

Weights of cells in y, small ones towards y = 0, fluxes between them from cubics through the four cells around: of
fourth order, no weight lost. In time by exp(z) ≈ (1 + z/4)/(1 - 3z/4 + z²/4 - z³/24), z being the step times the
operator in its middle: what is stiff is damped. All strands make one banded system.
"""

from __future__ import annotations

from copy import copy
from typing import Self

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator
from scipy.linalg.lapack import dgbsv, zgbsv

from master.diffusion_passage import narrowest
from master.lives import halves
from master.potential import Potential
from origins import Contacts, InputError
from origins.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]

_STEPS = 2.0  # narrowest widths, the length over which births change
_CELL = 0.4  # of the narrowest width, the widest cells
_FINEST = 2e-6  # of the same, the narrowest
_GROWTH = 0.3
_FAR = 1e-16
_DEAD = 1e-13
_GROUPS = 6
_TABLE = 16_384
_AT_ONCE = 1e-3  # of the time in which thresholds spread by the narrowest width
_BANDS = 2
_REAL = 1e-9
_NONE = 1e-300
_POLES = np.roots([-1.0 / 24.0, 0.25, -0.75, 1.0])
_SHARES = (1.0 + 0.25 * _POLES) / np.polyval(np.polyder([-1.0 / 24.0, 0.25, -0.75, 1.0]), _POLES)


class AgeingLives:
    """`Lives` of contacts with ageing, closure "exact".

    Parameters
    ----------
    contacts : Contacts
    level : int
        The cells' errors fall by 4 with each.
    start, again : pairs of arrays (n,)
        Stretches of the contacts that hold at X = 0, and of births (lengths), and weights of sum 1.

    Raises InputError for a final law that ends: thresholds would pile up before a wall, which stretches move along.
    """

    def __init__(self, contacts: Contacts, level: int, start: Nodes, again: Nodes) -> None:
        assert contacts.ageing is not None
        self._cells = Cells(contacts, level)
        self.length = _STEPS * self._cells.width
        self.time = _AT_ONCE * self._cells.width**2 / contacts.ageing.rate
        self.rate, self.error = self._cells.rate, 0.0
        self.work = 4 * self._cells.edges.size * again[0].size
        self._again = again
        self._count = 1
        self._stretch, self._share = start
        self._cohort = np.zeros(start[0].size, dtype=np.intp)
        self._weights = self._cells.fresh(start[0])
        self._born = self._cells.fresh(again[0])
        self._held, self._pull = self._read()

    @property
    def held(self) -> Array:
        return self._held

    @property
    def pull(self) -> Array:
        return self._pull

    def born(self) -> None:
        stretch, share = self._again
        self._stretch, self._share = np.append(self._stretch, stretch), np.append(self._share, share)
        self._cohort = np.append(self._cohort, np.full(stretch.size, self._count))
        self._weights = np.concatenate([self._weights, self._born])
        self._count += 1
        holds = share * self._born.sum(axis=1)
        self._held, self._pull = np.append(self._held, holds.sum()), np.append(self._pull, holds @ stretch)

    def advance(self, travel: float, duration: float) -> None:
        alive = self._weights.sum(axis=1) > _DEAD
        self._stretch, self._share = self._stretch[alive], self._share[alive]
        self._cohort, self._weights = self._cohort[alive], self._weights[alive]
        begin, self._stretch = self._stretch, self._stretch + travel
        turns = begin * self._stretch < 0.0
        # a stretch that passes 0 comes down and goes up again: one move each
        first = np.where(turns, np.abs(begin / travel) if travel else 1.0, 1.0)
        middle = np.where(turns, 0.0, self._stretch)
        self._weights = self._cells.move(self._weights, np.abs(begin), np.abs(middle), first * duration)
        if turns.any():
            rest = (1.0 - first[turns]) * duration
            onward = np.abs(self._stretch[turns])
            self._weights[turns] = self._cells.move(self._weights[turns], np.zeros(rest.size), onward, rest)
        self._held, self._pull = self._read()

    def spread(self) -> tuple[Array, Array]:
        return halves(self._held), halves(self._pull)

    def copy(self) -> Self:
        # arrays are replaced, never written to
        return copy(self)

    def _read(self) -> tuple[Array, Array]:
        holds = self._share * self._weights.sum(axis=1)
        parts = (np.bincount(self._cohort, part, minlength=self._count) for part in (holds, holds * self._stretch))
        held, pull = (part.astype(float) for part in parts)
        return held, pull


class Cells:
    """Cells in y and how their weights, shape (strands, cells), change.

    Attributes
    ----------
    width : float
        The narrowest of both laws (a length).
    rate : float
        At which fresh relaxed contacts break (per time).
    """

    def __init__(self, contacts: Contacts, level: int) -> None:
        law, ageing = contacts.thresholds, contacts.ageing
        assert ageing is not None
        self._law, self._thermal, self._diffusion = law, contacts.thermal, ageing.rate
        low, high = ageing.final.support()
        if law.atoms[0].size:
            raise InputError(
                f"thresholds: hold the single value {law.atoms[0][0]:g}: on a path in time contacts that age need a "
                "fresh law with a density"
            )
        if ageing.normal is None and (low > 0.0 or np.isfinite(high)):
            raise InputError(
                f"ageing: the final law ends at {high if np.isfinite(high) else low:g}: on a path in time thresholds "
                "age towards a law from 0 on without an upper end, such as gaussian(mean=1.0, std=0.05)"
            )
        self.width = min(narrowest(law), narrowest(ageing.final))
        top = max(float(law.isf(_FAR)), float(ageing.final.isf(_FAR)))
        self.edges, self._top = _edges(self.width, top, 2.0 ** (-0.5 * level)), top
        self._widths = np.diff(self.edges)
        self._value, self._slope = _fluxes(self.edges)
        self._normal = ageing.normal
        if self._normal is None:
            # x U'(x), which is finite at 0
            at = np.linspace(0.0, 2.0 * top, _TABLE)
            self._table = at, at * Potential(ageing.final, top).slope(at)
        self.rate = 0.0
        if self._thermal is not None:
            ends = panel_edges(law)
            nodes, weights = gauss(ends[:-1], ends[1:])
            self.rate = float((weights * law.pdf(nodes) * self._thermal.rate(0.0, nodes)).sum())

    def fresh(self, stretch: Array) -> Array:
        """Weights of fresh thresholds above |stretch|, one row for each."""
        at = np.abs(stretch)[:, None] + self.edges
        cdf, sf = self._law.cdf(at), self._law.sf(at)
        weights = np.where(cdf[:, :-1] < 0.5, np.diff(cdf), -np.diff(sf))
        return np.asarray(weights / weights.sum(axis=1, keepdims=True))

    def move(self, weights: Array, begin: Array, end: Array, duration: float | Array) -> Array:
        """Weights after |x| went straight from `begin` to `end` within `duration`, all of shape (strands,)."""
        duration = np.broadcast_to(duration, begin.shape)
        if not duration.any():
            return self._shift(weights, end - begin)
        out = np.zeros(weights.shape)
        # far above a stretched contact there are no thresholds: it needs the fewer cells
        needed = np.searchsorted(self.edges, self._top - np.minimum(begin, end)).clip(2 * _BANDS, self._widths.size)
        for some in np.array_split(np.argsort(needed), min(_GROUPS, begin.size)):
            if some.size:
                m = int(needed[some[-1]])
                out[some, :m] = self._step(weights[some, :m], begin[some], end[some], duration[some])
        return out

    def _step(self, weights: Array, begin: Array, end: Array, duration: Array) -> Array:
        """The same over the first of the cells alone."""
        band = self._operator(0.5 * (begin + end), (end - begin) / duration, weights.shape[1])
        band *= duration[:, None, None]
        band = band.reshape(weights.size, -1)
        out = np.zeros(weights.size)
        for pole, share in zip(_POLES, _SHARES, strict=True):
            if pole.imag < 0.0:
                continue
            real = abs(pole.imag) < _REAL
            storage = band.copy() if real else band.astype(complex)
            storage[:, 2 * _BANDS] -= pole.real if real else pole
            solve, factor = (dgbsv, share.real) if real else (zgbsv, 2.0 * share)
            found = solve(_BANDS, _BANDS, storage.T, weights.ravel(), overwrite_ab=True)[2]
            out += np.real(factor * found)
        return out.reshape(weights.shape)

    def _operator(self, stretch: Array, speed: Array, m: int) -> Array:
        """Its five bands for |x| of shape (strands,) and d|x|/dt, over m cells: [strand, j, 4 + i - j], as LAPACK has
        them beside two more."""
        drift = self._drift_at(stretch[:, None] + self.edges[:m]) + speed[:, None]
        band = np.zeros((stretch.size, m, 3 * _BANDS + 1))
        for k in range(2 * _BANDS):
            # through face f flows what its k-th cell, f - 2 + k, makes flow: into cell f - 1, out of f
            first, last = max(_BANDS - k, 0), min(m, m + _BANDS - k)
            flux = drift[:, first:last] * self._value[first:last, k] + self._diffusion * self._slope[first:last, k]
            cells = slice(first - _BANDS + k, last - _BANDS + k)
            band[:, cells, 3 * _BANDS - k] -= flux
            inside = flux[:, 1:] if first == 0 else flux
            band[:, cells.stop - inside.shape[1] : cells.stop, 3 * _BANDS - k - 1] += inside
        if self._thermal is not None:
            middle = 0.5 * (self.edges[:m] + self.edges[1 : m + 1])
            band[:, :, 2 * _BANDS] -= self._thermal.rate(stretch[:, None], stretch[:, None] + middle)
        return band

    def _drift_at(self, threshold: Array) -> Array:
        """D U'."""
        if self._normal is not None:
            return self._diffusion * (threshold - self._normal.mean) / self._normal.std**2
        # nothing flows through the face at y = 0 by drift
        return self._diffusion * np.interp(threshold, *self._table) / np.maximum(threshold, _NONE)

    def _shift(self, weights: Array, by: Array) -> Array:
        """What the level's motion leaves where thresholds have no time to change."""
        below = np.concatenate([np.zeros((by.size, 1)), np.cumsum(weights, axis=1)], axis=1)
        series = PchipInterpolator(self.edges, below, axis=1).c
        at = np.clip(self.edges + by[:, None], 0.0, self.edges[-1])
        cell = np.clip(np.searchsorted(self.edges, at, side="right") - 1, 0, self._widths.size - 1)
        within, strand = at - self.edges[cell], np.arange(by.size)[:, None]
        found = series[0, cell, strand]
        for row in series[1:]:
            found = found * within + row[cell, strand]
        return np.diff(found, axis=1)


def _edges(width: float, top: float, share: float) -> Array:
    """Ends of cells from 0 to `top`: from the finest they grow by a factor each, up to the widest."""
    edges = [0.0]
    while edges[-1] < top:
        room = 1.0 / (_FINEST * width + _GROWTH * edges[-1]) + 1.0 / (_CELL * width)
        edges.append(edges[-1] + share / room)
    return np.array(edges)


def _fluxes(edges: Array) -> tuple[Array, Array]:
    """Value and slope of the density at face f from the weights of the cells f - 2 to f + 1, shape (cells, 4): by the
    cubic through all four, or fewer at the ends; it vanishes at y = 0."""
    m = edges.size - 1
    value, slope = np.zeros((m, 4)), np.zeros((m, 4))
    for f in range(m):
        cells = np.arange(max(f - 2, 0), min(f + 2, m))
        scale = edges[cells[-1] + 1] - edges[cells[0]]
        # near y = 0 powers from y on, elsewhere from 1 on
        least, origin = (1, 0.0) if f < 2 else (0, edges[f])
        powers = least + np.arange(cells.size)
        left, right = (edges[cells, None] - origin) / scale, (edges[cells + 1, None] - origin) / scale
        weights = (right ** (powers + 1) - left ** (powers + 1)) / (powers + 1) * scale
        at = (edges[f] - origin) / scale
        rows = np.stack([at**powers, powers * at ** np.maximum(powers - 1, 0) / scale])
        found = np.linalg.solve(weights.T, rows.T).T
        value[f, cells - f + 2], slope[f, cells - f + 2] = found
    return value, slope
