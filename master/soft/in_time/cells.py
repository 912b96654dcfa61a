"""The density of the thresholds of contacts that age and hold, above a level that moves.

A contact holds while its threshold ξ is above |x|. With y = ξ - |x| (a length), D the diffusivity (length²/time), U'
the slope of the drift's potential (P_cf ~ e^-U; 1/length) and h the rate of breaking early (1/time),

    du/dt = d/dy [(D U' + d|x|/dt) u + D du/dy] - h u,        u = 0 at y = 0.

In, for each step: the stretches at its begin and end (lengths), its duration, and weights at its begin. Out: the
weights at its end. A weight is the integral of u over a cell, the share of the contacts born together whose y is there:
without unit. Their sum is the share that still holds: 1 at birth (`fresh`), and less by what has left through y = 0 or
by h. Cells are small towards y = 0; the flux through their faces comes from cubics through the four cells around, of
fourth order, and weight is conserved. Weights are followed for many groups of contacts of a memory side by side: a
group is a strand here, and a lane of the kernel.

An example: three cells that end at y = 0.1, 0.2 and 0.3, of the weights 0.2, 0.5 and 0.3, while |x| = 1: a half of the
contacts have thresholds between 1.1 and 1.2. If |x| jumps to 1.1, those of the first cell break, and `shifted` leaves
0.5, 0.3 and 0.

One step in time is implicit, Radau's of two stages (`cells_kernel.step`). Each term of the equation, times the step's
duration, is an array; of its names the first is that here, the second that there:

    D U' + d|x|/dt   `flow`, at lower faces; there, and here with heat, `leaving` and `entering`, which add that h
                     varies on a cell (the tilt, see `_early`)
    D                `spread`, never so small that the first cell is wider than the layer at |x|
    h                `breaking`, of cells
    u, du/dy         `face_density` and `face_slope`, `value` and `slope`: what the weights of four cells count for them
                     at a face

Tests by themselves: those of test_plain_in_time.py with cells in their names, and the two of thresholds that age after
these, for motion and heat without ageing, ageing without a level, and strands beside each other.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from master.survival.age.extent import highest, narrowest
from origins import Ageing, Contacts
from origins.errors import InputError
from origins.thresholds.law import Array


class CellControl(NamedTuple):
    """Numbers of the choice of cells; none has a unit.

    finer : 0.75: the next resolution halves the steps in time, whose error is of third order and falls by 8, and
        divides the cells by 2^0.75, as their error, of fourth order, then falls by (2^0.75)^4 = 8, too
    far : fraction of thresholds beyond the last cell: as small as rounding
    most : cells; a step of one strand then takes some milliseconds
    of_layer : width of the first cell, in thicknesses D/v of the layer at |x| in which the density falls to 0: right
        after a birth it is thinner
    least_first, most_first : that width is between these, in narrowest widths of the laws. With first cells of 0.1
        widths 1e-3 of the contacts were missed; a layer far thinner than the least contains too few to matter
    thinnest : least thickness of the layer at |x|, in narrowest widths of the laws, on the coarsest cells, which are
        those of the resolution -1. In a thinner layer, as of contacts that hardly age or of fast sliders, errors of
        the cells grow as |x| rises
    thinner : by how many times it may be thinner on the cells of each next resolution
    growth : of the width of cells with the distance from y = 0
    widest : cell up to where the bulk of the thresholds ends, in narrowest widths; errors in space then equal those in
        time for steps of a quarter of such a width
    of_widest, near_level : part of the widest cell that cells are up to so many narrowest widths from y = 0. A slider
        that creeps ages its contacts: |x| then lies up to some six widths below the thresholds that they age to, where
        the density rises by e^2 and more on the widest cell, and its slope at |x| says when the slider slips
    beyond_bulk : fraction of thresholds beyond the bulk, where tails are smooth
    growth_beyond : of the width of the widest cell with the distance from there
    quantiles : of fresh thresholds, over which the rate of breaking by heat is averaged
    """

    finer: float = 0.75
    far: float = 1e-16
    most: int = 4000
    of_layer: float = 0.05
    least_first: float = 2e-6
    most_first: float = 2e-5
    thinnest: float = 1e-3
    thinner: float = 8.0
    growth: float = 0.3
    widest: float = 0.4
    of_widest: float = 0.25
    near_level: float = 8.0
    beyond_bulk: float = 1e-4
    growth_beyond: float = 0.05
    quantiles: int = 200


CELLS = CellControl()
# Nodes of the table of a drift that is not normal, and step of its differences, in ln x_s: errors some 1e-11 of it.
NODES, STEP = 4096, 2e-3
# Thresholds, in narrowest widths, below which the density of such a law is taken as a power.
POWER_BELOW = 1e-8
# Least threshold (a length) at which a rate or a logarithm is evaluated: neither is defined at 0.
SMALLEST = 1e-300


class Cells:
    """Cells above |x|, and the change of their weights, arrays (strands, cells), in time.

    contacts : with `ageing`, closure "exact"
    resolution : a whole number from -1 on; the next one has an eighth of the errors
    fastest : largest speed of the slider
    width : the smaller of the narrowest widths of both laws (a length)
    heat_rate : mean rate at which fresh relaxed contacts break by heat (per time)
    edges : array of shape (cells + 1,), of the cells, from 0 on (lengths)

    Raises InputError for exact thresholds, and for laws so sharp that they need too many cells.
    """

    def __init__(self, contacts: Contacts, resolution: int, fastest: float) -> None:
        """Choose the cells; InputError for laws whose thresholds they cannot follow."""
        from master.soft.in_time import cells_kernel

        ageing, law = contacts.ageing, contacts.thresholds
        assert ageing is not None
        if law.atoms[0].size:
            hint = "contacts that age need a fresh law with a density here; give it a width"
            raise InputError(f"thresholds: hold the single value {law.atoms[0][0]:g}: {hint}")
        self._kernel, self._law, self._thermal = cells_kernel, law, contacts.thermal
        self._diffusion = ageing.rate
        self.width, self.heat_rate = min(narrowest(law), narrowest(ageing.final)), 0.0
        if self._thermal is not None:
            fraction = (np.arange(CELLS.quantiles) + 0.5) / CELLS.quantiles
            thresholds = np.asarray(law.ppf(fraction))
            self.heat_rate = float(self._thermal.rates.rate(0.0, thresholds, 1.0).mean())
        layer = CELLS.of_layer * ageing.rate / fastest if fastest > 0.0 else np.inf
        least, most = CELLS.least_first * self.width, CELLS.most_first * self.width
        first_cell = float(np.clip(layer, least, most))
        self._thinnest = CELLS.thinnest * self.width * CELLS.thinner ** (-resolution - 1)
        far, bulk = (
            highest(law, ageing.final, fraction) for fraction in (CELLS.far, CELLS.beyond_bulk)
        )
        factor = 2.0 ** (-CELLS.finer * resolution)
        self.edges = _cell_edges(far, self.width, first_cell, bulk, factor)
        self._face_density, self._face_slope = _at_faces(self.edges)
        self._normal = ageing.normal
        if self._normal is None:
            self._drift = _drift(ageing, self.width, 2.0 * far)
        self._no_breaking = np.zeros((2, self.edges.size - 1, cells_kernel.LANES))

    def fresh(self, stretch: Array) -> Array:
        """Weights of fresh thresholds above |stretch| (n,), one row of sum 1 for each."""
        at = np.abs(stretch)[:, None] + self.edges
        cdf, sf = self._law.cdf(at), self._law.sf(at)
        weights = np.where(cdf[:, :-1] < 0.5, np.diff(cdf), -np.diff(sf))
        return np.asarray(weights / weights.sum(axis=1, keepdims=True))

    def stepped(self, weights: Array, begin: Array, end: Array, duration: float) -> Array:
        """Weights after one step from the stretches `begin` straight to `end`, arrays (n,), in this duration."""
        # where x changes its sign |x| falls to 0, in the first part of the step, and rises in the rest of it
        crosses = begin * end < 0.0
        first_part = np.where(crosses, begin / np.where(crosses, begin - end, 1.0), 1.0)
        first_end = np.where(crosses, 0.0, np.abs(end))
        weights = self._moved(weights, np.abs(begin), first_end, duration * first_part)
        if crosses.any():
            rest = duration * (1.0 - first_part[crosses])
            at_0, end_of_rest = first_end[crosses], np.abs(end[crosses])
            weights[crosses] = self._moved(weights[crosses], at_0, end_of_rest, rest)
        return weights

    def _moved(self, weights: Array, begin: Array, end: Array, durations: Array) -> Array:
        """Weights after |x| has moved from `begin` to `end` >= 0 within these times, arrays (n,)."""
        if not durations.any():
            return self.shifted(weights, end - begin)
        lanes = self._kernel.LANES
        out = np.empty(weights.shape)
        for first in range(0, begin.size, lanes):
            some = slice(first, min(first + lanes, begin.size))
            out[some] = self._moved_together(weights[some], begin[some], end[some], durations[some])
        return out

    def _moved_together(self, weights: Array, begin: Array, end: Array, durations: Array) -> Array:
        """The same for at most LANES strands, which the kernel wants as the last axis of arrays of just so many."""
        count, of_lanes = begin.size, np.zeros((3, self._kernel.LANES))
        of_lanes[:, :count] = begin, end - begin, durations
        level_at_begin, rise, durations = of_lanes
        weights_at_begin = np.zeros((self.edges.size - 1, rise.size))
        weights_at_begin[:, :count] = weights.T
        # The terms of the table at the head: flow, leaving, entering and breaking of shape (2, cells, lanes), by stage
        # of Radau's step and cell; times, spread and level, which is |x|, (2, lanes).
        times = durations * np.ones((2, 1))
        level = level_at_begin + rise * self._kernel.STAGES[:, None]
        flow = self._flow(level, times, rise)
        # so large that the layer at |x|, as thick as spread/rise, is at least as wide as the first cell, which ends at
        # edges[1], and as the thinnest in which weights do not grow: a thinner one need not be resolved
        spread = np.maximum(
            self._diffusion * times, max(self.edges[1], self._thinnest) * np.abs(rise)
        )
        # Fluxes per density at a lower face: what leaves the cell enters the cell below. With heat the tilt of each
        # cell (see `_early`) is counted with the flux that leaves it, and with that which enters it from above.
        leaving = entering = flow
        breaking = self._no_breaking
        if self._thermal is not None:
            breaking, tilt = self._early(level, times)
            leaving = flow - tilt
            entering = flow - np.concatenate([tilt[:, :1], tilt[:, :-1]], axis=1)
        early = self._thermal is not None
        at_faces = self._face_density, self._face_slope
        losses = self._kernel.Losses(leaving, entering, breaking, early, spread, *at_faces)
        return np.asarray(self._kernel.step(weights_at_begin, losses)[:, :count].T)

    def _flow(self, level: Array, times: Array, rise: Array) -> Array:
        """See the table at the head. The drift to a normal law is a straight line, whose slope is `rate`, D/std²."""
        faces, normal = self.edges[:-1], self._normal
        if normal is not None:
            below, rate = level - normal.mean, normal.rate * times
            return np.asarray(self._kernel.flow_to_normal(below, faces, rate, rise))
        return np.asarray(self._drift(level[:, None] + faces[:, None]) * times[:, None] + rise)

    def _early(self, level: Array, times: Array) -> tuple[Array, Array]:
        """Of each cell the rate of breaking, and its tilt due to the rate's slope, both times the duration: heat takes
        rate · weight + tilt · (u at the upper face - u at the lower) from a cell. For on a cell of the width w the mean
        of h u is that of h times that of u plus (w²/12) h' u', and w h' and w u' are differences between its faces.

        An example: w = 0.1, h rises from 1 to 2 and u from 3 to 4. The weight is 0.35, rate · weight = 1.5 · 0.35 =
        0.525, the tilt 0.1 · 1/12 = 0.00833: in all 0.5333, the integral of (1 + 10 z)(3 + 10 z) from 0 to 0.1."""
        thermal = self._thermal
        assert thermal is not None
        ends = level[:, None] + self.edges[:, None]
        middle = 0.5 * (ends[:, :-1] + ends[:, 1:])
        at_ends, at_middle = (
            thermal.rates.rate(level[:, None], np.maximum(at, SMALLEST), 1.0) * times[:, None]
            for at in (ends, middle)
        )
        mean = (at_ends[:, :-1] + 4.0 * at_middle + at_ends[:, 1:]) / 6.0
        return mean, np.diff(self.edges)[:, None] * np.diff(at_ends, axis=1) / 12.0

    def shifted(self, weights: Array, rise: Array) -> Array:
        """Weights that remain above |x| when it jumps by these rises (n,), of either sign, and thresholds stay."""
        return np.asarray(self._kernel.shifted(np.ascontiguousarray(weights), self.edges, rise))

    def weight_above(self, weights: Array, rise: Array) -> Array:
        """The sums of the weights that `shifted` would leave after these rises (n,) >= 0; at least 0."""
        return np.asarray(self._kernel.weight_above(weights, self.edges, rise))


def _cell_edges(
    largest: float, width: float, first_cell: float, bulk: float, factor: float
) -> Array:
    """Ends of cells from 0 to `largest`: their widths grow from `first_cell` with the distance to 0 until they are the
    widest, and grow further beyond `bulk` (see CellControl); all are multiplied by `factor`. For the narrowest width
    0.05, say, the first cell is 1e-6 at most, and those at y = 0.01, 0.1 and 0.5 are 0.002, 0.011 and 0.017."""
    edges = [0.0]
    while edges[-1] < largest:
        widest = CELLS.widest * width + CELLS.growth_beyond * max(edges[-1] - bulk, 0.0)
        widest *= CELLS.of_widest if edges[-1] < CELLS.near_level * width else 1.0
        near = first_cell + CELLS.growth * edges[-1]
        # about the smaller of both
        edges.append(edges[-1] + factor / (1.0 / near + 1.0 / widest))
        if len(edges) > CELLS.most:
            hint = f"need more than {CELLS.most} cells; use wider laws, or a larger tolerance"
            raise InputError(
                f"ageing: laws as sharp as {width:.3g} that reach {largest:.3g} {hint}"
            )
    # scale so that the last cell ends at `largest`
    return np.array(edges) * (largest / edges[-1])


def _at_faces(edges: Array) -> Array:
    """Coefficients that give the density, and its slope, at the lower face f of each cell from the weights
    of the cells f - 2 to f + 1, by cubics, at both ends by lower polynomials; and at the upper face of the last
    cell, 0. Shape (2, 4, cells + 1): out[0, k, f] is what the weight of the cell f - 2 + k counts for the density."""
    m = edges.size - 1
    out = np.zeros((2, 4, m + 1))
    for f in range(m):
        cells = np.arange(max(f - 2, 0), min(f + 2, m))
        scale = edges[cells[-1] + 1] - edges[cells[0]]
        # near y = 0, where the density vanishes, powers begin at y; elsewhere at 1
        least, origin = (1, 0.0) if f < 2 else (0, edges[f])
        powers = least + np.arange(cells.size)
        left, right = ((edges[cells + k, None] - origin) / scale for k in (0, 1))
        weights = (right ** (powers + 1) - left ** (powers + 1)) / (powers + 1) * scale
        at = (edges[f] - origin) / scale
        rows = np.stack([at**powers, powers * at ** np.maximum(powers - 1, 0) / scale])
        out[:, cells - f + 2, f] = np.linalg.solve(weights.T, rows.T).T
    return out


def _drift(ageing: Ageing, width: float, far: float) -> Callable[[Array], Array]:
    """D U' at thresholds from 0 to `far`, P_cf ~ e^-U, of a final law that is not normal, to some 1e-11 of it."""
    final = ageing.final
    furthest = float(np.log(far / width))
    # over ln(x_s/width) x_s U' is smooth and finite also where the law begins as a power
    at = np.linspace(min(-furthest, float(np.log(POWER_BELOW))), furthest, NODES)
    # d ln P_cf/d ln x_s = -x_s U' by the central difference of five points, of fourth order in STEP; the middle one has
    # the weight 0
    weights = np.array([1, -8, 8, -1]) / 12.0
    logs = np.array([final.logpdf(width * np.exp(at + k * STEP)) for k in (-2, -1, 1, 2)])
    slope = weights @ logs / STEP
    if not np.isfinite(slope).all():
        fault = "the final law has no finite density where thresholds age to"
        raise InputError(f"ageing: {fault}; use a law without gaps, such as gaussian")
    spline = CubicSpline(at, -ageing.rate * slope)

    def drift(threshold: Array) -> Array:
        log = np.clip(np.log(np.maximum(threshold, SMALLEST) / width), at[0], at[-1])
        # no threshold is at 0
        return np.asarray(spline(log) / np.where(threshold > 0.0, threshold, np.inf))

    return drift
