"""The density of the thresholds of contacts that age and hold, above a level that moves.

A contact holds while its threshold ξ is above the level ℓ = |x|. With y = ξ - ℓ, D the diffusivity,
U' the drift's potential (P_cf ~ e^-U) and h the rate of breaking early,

    du/dt = d/dy [(D U' + dℓ/dt) u + D du/dy] - h u,        u = 0 at y = 0.

The density u is stored as weights of cells in y, small ones towards y = 0; the flux through their
faces comes from cubics through the four cells around, of fourth order, and weight is conserved. Where
the final law ends at a wall, cells shrink as the level approaches it; where it begins above 0, the
level stays there as a closed wall until |x| reaches it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator
from scipy.special import ndtr

from master.lives.age.grid import (
    FAR,
    FINER,
    LAYER,
    MOST_CELLS,
    THINNEST,
    FinalSlope,
    cell_edges,
    faces_of,
    narrowest,
)
from origins import Contacts
from origins.errors import InputError
from origins.thresholds.gaussian import CutGaussian

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.intp]

# Weight below which a cell counts as empty; most standard deviations that a threshold diffuses in a step.
FAINT, FURTHEST = 1e-18, 8.0
# Strands sleep while |x| is this many standard deviations below the mean of normal thresholds: a
# share below 1e-11 may have met it.
ASLEEP = 7.0
# Cells that a step uses at least: those of one cubic.
LEAST_CELLS = 4


class Move(NamedTuple):
    """One step of strands, arrays (n,): |x| at both ends (lengths), and how long it takes."""

    begin: Array
    end: Array
    duration: Array


class Cells:
    """Cells above the level, and the change of their weights, arrays (strands, cells), in time.

    Parameters
    ----------
    contacts : Contacts
        With `ageing`, closure "exact".
    resolution : int
        Each step up divides the errors of the cells by 8.
    fastest : float
        Largest speed of the slider.

    Attributes
    ----------
    width : float
        The smaller of the narrowest widths of both laws (a length).
    """

    def __init__(self, contacts: Contacts, resolution: int, fastest: float) -> None:
        from master.lives.age import kernel as ageing_kernel

        ageing, law = contacts.ageing, contacts.thresholds
        assert ageing is not None
        if law.atoms[0].size:
            raise InputError(
                f"thresholds: hold the single value {law.atoms[0][0]:g}: contacts that age need a "
                "fresh law with a density here; give it a width"
            )
        self._kernel, self._law, self._thermal = ageing_kernel, law, contacts.thermal
        self._diffusion, self._normal = ageing.rate, ageing.normal
        self.width = min(narrowest(law), narrowest(ageing.final))
        self.floor, self.wall = (0.0, np.inf) if self._normal else ageing.final.support()
        furthest = min(max(float(law.isf(FAR)), float(ageing.final.isf(FAR))), self.wall)
        layer = LAYER * ageing.rate / fastest if fastest > 0.0 else np.inf
        self.edges = cell_edges(
            furthest - self.floor,
            self.width,
            float(np.clip(layer, THINNEST * self.width, 0.1 * self.width)),
            max(float(law.isf(1e-4)), float(ageing.final.isf(1e-4))) - self.floor,
            2.0 ** (-FINER * resolution),
        )
        self._faces = faces_of(self.edges)
        self._slope = None if self._normal else FinalSlope(ageing.final, self.width)
        self._gaussian = self._normal is not None and isinstance(law, CutGaussian)
        self._gaussian &= self._thermal is None

    @property
    def can_be_finer(self) -> bool:
        """Whether the next resolution does not need too many cells."""
        return bool(self.edges.size * 2.0**FINER < MOST_CELLS)

    def level(self, stretch: Array) -> Array:
        """Where thresholds begin for contacts of these stretches."""
        return np.maximum(np.abs(stretch), self.floor)

    def fresh(self, stretch: Array) -> Array:
        """Weights of fresh thresholds above |stretch| (n,), one row of sum 1 for each."""
        level = self.level(stretch)
        at = level[:, None] + self.edges * self._scale(level)[:, None]
        return _between(self._law.cdf(at), self._law.sf(at))

    def far_above(self, stretch: Array, age: Array, deviations: float) -> npt.NDArray[np.bool_]:
        """Whether thresholds of this age are known to be so many standard deviations above |stretch|."""
        if not self._gaussian:
            return np.zeros(np.shape(stretch), dtype=bool)
        mean, std = self._unmet(age)
        return np.asarray(mean - deviations * std > np.abs(stretch))

    def unmet(self, stretch: Array, age: Array) -> Array:
        """Weights of thresholds of this age if none of them has met |x| before."""
        mean, std = self._unmet(age)
        z = (np.abs(stretch)[:, None] + self.edges - mean[:, None]) / std[:, None]
        return _between(ndtr(z), ndtr(-z))

    def _unmet(self, age: Array) -> tuple[Array, Array]:
        """Mean and standard deviation of normal thresholds that were fresh `age` ago."""
        law, normal = self._law, self._normal
        assert isinstance(law, CutGaussian) and normal is not None
        kept = law.parent_std * np.exp(-normal.rate * age)
        return normal.mean_after(law.parent_mean, age), np.hypot(normal.std_after(age), kept)

    def move(self, weights: Array, move: Move) -> Array:
        """Weights after a straight move, in which |x| neither turns nor passes `floor`."""
        begin, end = self.level(move.begin), self.level(move.end)
        gone = end >= self.wall * (1.0 - 1e-12)
        if gone.any():
            out = np.zeros(weights.shape)
            some = Move(*(part[~gone] for part in move))
            out[~gone] = self.move(weights[~gone], some)
            return out
        if not move.duration.any():
            return self._shift(weights, begin, end)
        times = move.duration * np.ones((2, 1))
        stages = self._kernel.STAGES[:, None]
        level = begin + (end - begin) * stages
        scale = self._scale(level)
        faces = self.edges[:-1] * scale[:, :, None]
        # faces of cells that shrink towards a wall come down
        rise = (end - begin)[:, None] * (1.0 - self.edges[:-1] / (self.wall - self.floor))
        flow = self._drift(level[:, :, None] + faces) * times[:, :, None] + rise
        flow /= scale[:, :, None]
        # at least a cell wide: a thinner edge of the density need not be resolved
        spread = np.maximum(self._diffusion * times, self.edges[1] * np.abs(end - begin))
        leaving = entering = flow
        breaking = np.empty((2, begin.size, 0))
        if self._thermal is not None:
            stretch = move.begin + (move.end - move.begin) * stages
            breaking, tilt = self._early(stretch, level, scale, times)
            leaving = flow - tilt
            entering = flow - np.concatenate([tilt[:, :, :1], tilt[:, :, :-1]], axis=2)
        closed = (0.5 * (move.begin + move.end) < self.floor).astype(np.intp)
        used = self._used(weights, flow * scale[:, :, None], move.duration)
        spread = np.ascontiguousarray(spread / scale**2)
        return self._kernel.step(
            weights, used, leaving, entering, breaking, spread, *self._faces, closed
        )

    def _scale(self, level: Array) -> Array:
        """Width of cells above this level over that of cells above the floor."""
        if not np.isfinite(self.wall):
            return np.ones(np.shape(level))
        return np.asarray((self.wall - level) / (self.wall - self.floor))

    def _drift(self, threshold: Array) -> Array:
        """D U' at thresholds above 0."""
        if self._normal is not None:
            return self._diffusion * (threshold - self._normal.mean) / self._normal.std**2
        assert self._slope is not None
        # the slope is 0 at the very end of the final law
        return self._diffusion * self._slope(threshold)

    def _early(
        self, stretch: Array, level: Array, scale: Array, times: Array
    ) -> tuple[Array, Array]:
        """Rates of breaking in the cells, and the weights of the densities at faces due to the rate's slope.

        The mean of a product over a cell of width w is that of h times that of u plus
        (w²/12) h' u', and w u' is the difference of u at its faces.
        """
        thermal = self._thermal
        assert thermal is not None
        ends = level[:, :, None] + self.edges * scale[:, :, None]
        middle = 0.5 * (ends[:, :, :-1] + ends[:, :, 1:])
        at_ends, at_middle = (
            thermal.plain_rate(stretch[:, :, None], np.maximum(at, 1e-300)) * times[:, :, None]
            for at in (ends, middle)
        )
        mean = (at_ends[:, :, :-1] + 4.0 * at_middle + at_ends[:, :, 1:]) / 6.0
        # densities are per length of the cells above the floor
        return mean, np.diff(self.edges) * np.diff(at_ends, axis=2) / 12.0

    def _used(self, weights: Array, flow: Array, duration: Array) -> Whole:
        """Number of cells that contain thresholds now or may do so within the step."""
        if np.isfinite(self.wall):
            return np.full(weights.shape[0], weights.shape[1])
        further = np.maximum(-flow.min(axis=(0, 2)), 0.0)
        further += FURTHEST * np.sqrt(2.0 * self._diffusion * duration)
        last = weights.shape[1] - np.argmax(weights[:, ::-1] > FAINT, axis=1)
        found = np.searchsorted(self.edges, self.edges[last] + further)
        return np.clip(found, LEAST_CELLS, weights.shape[1]).astype(np.intp)

    def _shift(self, weights: Array, begin: Array, end: Array) -> Array:
        """Weights that remain above a level that jumps from begin to end."""
        out = np.empty(weights.shape)
        below = np.concatenate([np.zeros((begin.size, 1)), np.cumsum(weights, axis=1)], axis=1)
        before, after = self._scale(begin), self._scale(end)
        for i, row in enumerate(below):
            at = (end[i] - begin[i] + self.edges * after[i]) / before[i]
            series = PchipInterpolator(self.edges, row)
            out[i] = np.diff(series(np.clip(at, 0.0, self.edges[-1])))
        return out


def _between(cdf: Array, sf: Array) -> Array:
    """Weights between neighbouring places of each row, of sum 1."""
    weights = np.where(cdf[:, :-1] < 0.5, np.diff(cdf), -np.diff(sf))
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))
