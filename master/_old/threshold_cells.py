"""The density of the thresholds of contacts that age, above a stretch that moves.

With y = ξ - |x| the distance of a threshold from the stretch, which moves by σ = d|x|/dt, and h the rate of breaking
at a temperature,

    ∂u/∂t = ∂/∂y [(D U' + σ) u + D ∂u/∂y] - h u,     u = 0 at y = 0, where contacts break.

Weights of cells in y, small ones towards y = 0, fluxes between them from cubics through the four cells around: of
fourth order, no weight lost. In time by Radau's method of two stages, of third order, which damps what is stiff: the
density's edge at y = 0, as thin as D over the speed, is at the end of a step what it is at the speed there.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator
from scipy.special import ndtr

from master._old.diffusion_passage import narrowest
from master._old.potential import Potential
from origins import Contacts, InputError
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]

_CELL = 0.4  # of the narrowest width, the widest cells
_FINEST = 2e-6  # of the same, the narrowest
_GROWTH = 0.3
_FAR = 1e-16
_ASLEEP = 6.5  # standard deviations that thresholds keep from the stretch
_FAINT = 1e-18
_FAR_SQUARE = 2.0 * 8.0**2
_TABLE = 16_384
_LEAST = 4
_NONE = 1e-300
# Radau's stages, of which the last is the end: where the edge of a density changes within a step it is right there
_AT, _RADAU = np.array([1.0 / 3.0, 1.0]), np.array([[5.0, -1.0], [9.0, 3.0]]) / 12.0


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
        from master._old import compiled_ageing

        law, ageing = contacts.thresholds, contacts.ageing
        assert ageing is not None
        self.compiled = compiled_ageing
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
        self.edges = _edges(self.width, top, 2.0 ** (-0.5 * level))
        self._widths = np.diff(self.edges)
        self.value, self.slope = _fluxes(self.edges)
        self._normal = ageing.normal
        if self._normal is None:
            # x U'(x), which is finite at 0
            at = np.linspace(0.0, 2.0 * top, _TABLE)
            self._table = at, at * Potential(ageing.final, top).slope(at)
        # contacts that break below their thresholds do so from the first
        self._gaussian = self._normal is not None and isinstance(law, CutGaussian) and self._thermal is None
        self.rate = 0.0
        if self._thermal is not None:
            ends = panel_edges(law)
            nodes, weights = gauss(ends[:-1], ends[1:])
            self.rate = float((weights * law.pdf(nodes) * self._thermal.rate(0.0, nodes)).sum())

    def fresh(self, stretch: Array) -> Array:
        """Weights of fresh thresholds above |stretch|, one row for each."""
        at = np.abs(stretch)[:, None] + self.edges
        return _between(self._law.cdf(at), self._law.sf(at))

    def untouched(self, stretch: Array, age: Array) -> npt.NDArray[np.bool_]:
        """Whether thresholds of this age are known to be far above |stretch|, and so never yet met it."""
        if not self._gaussian:
            return np.zeros(stretch.shape, dtype=bool)
        mean, std = self._normal_at(age)
        return np.asarray(mean - _ASLEEP * std > np.abs(stretch))

    def aged(self, stretch: Array, age: Array) -> Array:
        """Weights of thresholds of this age, none of which has been met."""
        mean, std = self._normal_at(age)
        z = (np.abs(stretch)[:, None] + self.edges - mean[:, None]) / std[:, None]
        return _between(ndtr(z), ndtr(-z))

    def _normal_at(self, age: Array) -> Nodes:
        law, normal = self._law, self._normal
        assert isinstance(law, CutGaussian) and normal is not None
        spread = law.parent_std * np.exp(-normal.rate * age)
        return normal.mean_after(law.parent_mean, age), np.hypot(normal.std_after(age), spread)

    def move(
        self, weights: Array, begin: Array, end: Array, duration: float | Array, bend: float = 0.0
    ) -> Array:
        """Weights after |x| went straight from `begin` to `end` within `duration`, all of shape (strands,); `bend` as
        master.lives.Lives has it."""
        duration = np.ascontiguousarray(np.broadcast_to(duration, begin.shape))
        if not begin.size or not duration.any():
            return self._shift(weights, end - begin)
        flow, early, spread = self.stages(begin, end, duration, bend)
        # no thresholds are where they cannot come to from the last cell in which there are any
        further = np.maximum(-flow.min(axis=(0, 2)), 0.0) + np.sqrt(_FAR_SQUARE * self._diffusion * duration)
        last = weights.shape[1] - np.argmax(weights[:, ::-1] > _FAINT, axis=1)
        needed = np.searchsorted(self.edges, self.edges[last] + further).clip(_LEAST, self._widths.size)
        return self.compiled.step(weights, needed, flow, early, spread, self.value, self.slope, _RADAU)

    def stages(self, begin: Array, end: Array, duration: Array, bend: float) -> tuple[Array, Array, Array]:
        """Flow through the lower faces of the cells per density, rates of breaking in the cells or nothing, and D, all
        times the step and at both stages: shapes (2, strands, cells) and (2, strands)."""
        times = duration * (1.0 + bend * (2.0 * _AT[:, None] - 1.0))
        stretch = begin + (end - begin) * _AT[:, None]
        drift = self._drift_at(stretch[:, :, None] + self.edges[:-1])
        flow = drift * times[:, :, None] + (end - begin)[:, None]
        early = np.empty((2, begin.size, 0))
        if self._thermal is not None:
            middle = 0.5 * (self.edges[:-1] + self.edges[1:])
            early = self._thermal.rate(stretch[:, :, None], stretch[:, :, None] + middle) * times[:, :, None]
        # an edge thinner than the cells tell is not resolved, and need not be
        spread = np.maximum(self._diffusion * times, self.edges[1] * np.abs(end - begin))
        return flow, np.asarray(early), spread

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


def _between(cdf: Array, sf: Array) -> Array:
    """Weights between neighbouring places of a row, of sum 1."""
    weights = np.where(cdf[:, :-1] < 0.5, np.diff(cdf), -np.diff(sf))
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


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
