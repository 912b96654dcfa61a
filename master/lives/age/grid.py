"""Cells for the thresholds of contacts that age, cubics through them, and the drift of the final law."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from origins import Thresholds
from origins.errors import InputError

Array = npt.NDArray[np.float64]

# The widest cell over the narrowest width of the two laws; errors in space then equal those in time
# for steps of a quarter of that width (some 1e-4 at resolution 0).
CELL = 0.4
# Each resolution divides cells by 2 to this power: errors, of fourth order, fall by 8.
FINER = 0.75
# Growth of a cell per distance from the level, up to the widest cell.
GROWTH = 0.3
# The narrowest cell over the thickness D/v of the density's edge at the level; and its least value
# over the narrowest width, as thinner edges contain too few thresholds to matter.
LAYER, THINNEST = 0.05, 2e-6
# Growth of a cell per distance beyond the bulk of the laws, where their tails are smooth.
FAR_GROWTH = 0.05
# Survival of both laws at which the cells end.
FAR = 1e-16
MOST_CELLS = 4000
# Nodes of the table of the final law's drift; its cubic spline is good to some 1e-11.
TABLE = 4096
# Step of numerical derivatives of ln P_cf, in the logarithm of the distance from its end.
DERIVATIVE_STEP = 2e-3
# Distance from the end of a law, in widths, below which ln P_cf is treated as a power of it.
NEAREST = 1e-8
# Deciles: the narrowest tenth of the weight measures how sharp a law is; for a normal law of standard
# deviation 1 it is 0.25 wide.
DECILES, NORMAL_TENTH = np.linspace(0.1, 0.9, 9), 0.25


class Faces(NamedTuple):
    """Coefficients that give the density and its slope at the lower face f of each cell from the weights
    of the cells f - 2 to f + 1; arrays (2, cells, 4), for an open and for a closed lowest face."""

    value: Array
    slope: Array


class FinalSlope:
    """U' of a final law, P_cf ~ e^-U, by a table of d ln P_cf/dτ.

    τ = ln(ξ - a) above the end a of the law, or ln((ξ - a)/(b - ξ)) where it ends at b as well: in
    τ the slope is smooth and finite also where the law begins or ends as a power.
    """

    def __init__(self, final: Thresholds, width: float) -> None:
        self._low, self._high = final.support()
        self._width, self._walled = width, bool(np.isfinite(self._high))
        furthest = 10.0  # largest τ at a wall: nearer to it distances lose their digits
        if not self._walled:
            furthest = float(np.log(3.0 * (final.isf(FAR) - self._low) / width))
        nearest = min(-furthest, float(np.log(NEAREST)))
        at = np.linspace(nearest, furthest, TABLE)
        logs = [final.logpdf(self._threshold(at + k * DERIVATIVE_STEP)) for k in (-2, -1, 1, 2)]
        slope = (logs[0] - 8.0 * logs[1] + 8.0 * logs[2] - logs[3]) / (12.0 * DERIVATIVE_STEP)
        if not np.isfinite(slope).all():
            raise InputError(
                "ageing: the final law has no finite density where thresholds age to; use a law "
                "without gaps, such as gaussian(mean=1.0, std=0.05)"
            )
        self._table, self._ends = CubicSpline(at, slope), (nearest, furthest)

    def __call__(self, threshold: Array) -> Array:
        """U' at thresholds of any shape, per length; 0 at the very ends of the law."""
        above, below = threshold - self._low, self._high - threshold
        inside = (above > 0.0) & (below > 0.0)
        above = np.where(inside, above, 1.0)
        at, room = np.log(above / self._width), above
        if self._walled:
            below = np.where(inside, below, 1.0)
            at, room = np.log(above / below), above * below / (self._high - self._low)
        return np.where(inside, -self._table(np.clip(at, *self._ends)) / room, 0.0)

    def _threshold(self, at: Array) -> Array:
        if self._walled:
            return self._low + (self._high - self._low) / (1.0 + np.exp(-at))
        return self._low + self._width * np.exp(at)


def narrowest(law: Thresholds) -> float:
    """Standard deviation of a normal law whose narrowest tenth of the weight is as narrow as this law's."""
    spread = np.diff(law.ppf(DECILES))
    return float(spread[spread > 0.0].min(initial=law.mean())) / NORMAL_TENTH


def cell_edges(reach: float, width: float, thinnest: float, bulk: float, share: float) -> Array:
    """Ends of cells from 0 to `reach`: their widths grow from `thinnest` to CELL times `width`, and
    grow further beyond `bulk`; all widths are multiplied by `share`."""
    edges = [0.0]
    while edges[-1] < reach:
        widest = CELL * width + FAR_GROWTH * max(edges[-1] - bulk, 0.0)
        room = 1.0 / (thinnest + GROWTH * edges[-1]) + 1.0 / widest
        edges.append(edges[-1] + share / room)
        if len(edges) > MOST_CELLS:
            raise InputError(
                f"ageing: laws as sharp as {width:.3g} that reach to {reach:.3g} need more than "
                f"{MOST_CELLS} cells of thresholds; use wider laws, or a larger tolerance"
            )
    # scale so that the last cell ends at `reach`
    return np.array(edges) * (reach / edges[-1])


def faces_of(edges: Array) -> Faces:
    """Cubics through the cells around each face, and lower polynomials at both ends."""
    m = edges.size - 1
    value, slope = np.zeros((2, m, 4)), np.zeros((2, m, 4))
    for f in range(m):
        cells = np.arange(max(f - 2, 0), min(f + 2, m))
        scale = edges[cells[-1] + 1] - edges[cells[0]]
        for closed in (0, 1):
            # near an open end, where the density vanishes, powers begin at y; elsewhere at 1
            least, origin = (1, 0.0) if f < 2 and not closed else (0, edges[f])
            powers = least + np.arange(cells.size)
            left, right = ((edges[cells + k, None] - origin) / scale for k in (0, 1))
            weights = (right ** (powers + 1) - left ** (powers + 1)) / (powers + 1) * scale
            at = (edges[f] - origin) / scale
            rows = np.stack([at**powers, powers * at ** np.maximum(powers - 1, 0) / scale])
            found = np.linalg.solve(weights.T, rows.T).T
            value[closed, f, cells - f + 2], slope[closed, f, cells - f + 2] = found
    return Faces(value, slope)
