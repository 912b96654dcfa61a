"""One step in time of the weights of thresholds in cells, strand by strand: the compiled part.

All code that numba compiles for ageing is in this file, because its cache on disk detects changes
only in a function's own file.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from origins.thresholds.law import Array

# Radau's method of two stages, of third order: its last stage is the end of the step, so that stiff
# components, such as the thin edge of a density at the level, are damped to their final values.
STAGES = np.array([1.0 / 3.0, 1.0])
RADAU = np.array([[5.0, -1.0], [9.0, 3.0]]) / 12.0
# Strands that `step` takes together: so many that the compiler sees them as a loop, of which processors do 2, 4 or 8
# turns at once, five times as fast as one by one; with 32 they no longer fit in the nearest cache, and it is no faster.
LANES = 16


def compiled(function: Callable[..., Any]) -> Any:
    """`function`, compiled when first called; kept on disk where a folder can be written. A division by 0 gives inf, as
    in numpy: a loop that may stop there would not be done several turns at once."""
    try:
        return njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # numba found no folder for its cache
        return njit(error_model="numpy")(function)


class Losses(NamedTuple):
    """What cells lose in a step, at both of its stages.

    leaving, entering : arrays (2, cells, LANES): the flux out of a cell through its lower face, and that into the cell
        below, both per density at the face
    breaking : array (2, cells, LANES), rate at which contacts in a cell break
    early : whether any do; if not, breaking is 0, and entering as leaving
    spread : array (2, LANES), the diffusivity; all but `early` up to here are multiplied by the step
    value, slope : arrays (4, cells + 1), the density and its slope at the lower face of each cell j from the weights of
        the cells j - 2 to j + 1; 0 at the upper face of the last cell, as nothing comes through it
    """

    leaving: Array
    entering: Array
    breaking: Array
    early: bool
    spread: Array
    value: Array
    slope: Array


@compiled
def step(weights: Array, losses: Losses) -> Array:
    """Weights of thresholds in cells at the end of a step, shape (cells, LANES): the last of the two stages w_0, w_1 of

        w_a + sum over stages b of RADAU[a, b] L_b w_b = w at the beginning,

    with L_b w the loss of each cell in the time of the step at the rates of stage b: what leaves through its lower
    face, less what comes through the upper one, and what breaks.

    weights : array (cells, LANES) at its beginning

    Plainly, for one strand, with L[b] the matrix (cells, cells) of stage b:

        rows = np.eye(2 * cells)                                     # unknown 2j + a: cell j at stage a
        for a in range(2):
            for b in range(2):
                rows[a::2, b::2] += RADAU[a, b] * L[b]
        end = np.linalg.solve(rows, np.repeat(weights, 2))[1::2]     # the second stage is the end

    The test test_one_step_of_the_cells_solves_its_equations makes L and does so. Here rows are made one by one and
    never stored whole: the unknowns, both stages of each cell in turn, obey equations whose row i has elements in
    the columns i - 5 to i + 5. Each row is made, and cleared below the diagonal by the five rows above it, by
    Gauss's elimination without pivoting; then the last unknown is known, and so on up. All is done for LANES
    strands at once, lane by lane in the innermost loops, of which a processor does several together.
    """
    cells = weights.shape[0]
    leaving, entering, breaking, _, spread, value, slope = losses
    # of row i at i + 5: 1/diagonal, the elements right of it, and the right side; five rows of 0 above and below
    done = np.empty((2 * cells + 10, 7, LANES))
    done[:5] = 0.0
    done[-5:] = 0.0
    # Rates of a cell, at both stages, per weight of the cells j - 2 to j + 2; and the row i = 2j + stage of the
    # equations, in row[c] its column i - 5 + c. The weight of cell j - 2 + k at stage b is in c = 2k + 1 + b - stage;
    # one of the eleven stays 0, the first of a stage 0 and the last of a stage 1.
    rates, row = np.empty((2, 5, LANES)), np.zeros((11, LANES))
    for j in range(cells):
        # at the lower face of the cell, and at the upper one
        v0, v1, v2, v3 = value[0, j], value[1, j], value[2, j], value[3, j]
        d0, d1, d2, d3 = slope[0, j], slope[1, j], slope[2, j], slope[3, j]
        v4, v5, v6, v7 = value[0, j + 1], value[1, j + 1], value[2, j + 1], value[3, j + 1]
        d4, d5, d6, d7 = slope[0, j + 1], slope[1, j + 1], slope[2, j + 1], slope[3, j + 1]
        above = min(j + 1, cells - 1)
        for stage in range(2):
            for s in range(LANES):
                out, come = leaving[stage, j, s], entering[stage, above, s]
                spreads = spread[stage, s]
                rates[stage, 0, s] = out * v0 + spreads * d0
                rates[stage, 1, s] = (out * v1 + spreads * d1) - (come * v4 + spreads * d4)
                both = (out * v2 + spreads * d2) - (come * v5 + spreads * d5)
                rates[stage, 2, s] = both + breaking[stage, j, s]
                rates[stage, 3, s] = (out * v3 + spreads * d3) - (come * v6 + spreads * d6)
                rates[stage, 4, s] = -(come * v7 + spreads * d7)
        for stage in range(2):
            first, last = RADAU[stage, 0], RADAU[stage, 1]
            row[10 * stage] = 0.0
            for k in range(5):
                at = 1 - stage + 2 * k
                for s in range(LANES):
                    row[at, s] = first * rates[0, k, s]
                    row[at + 1, s] = last * rates[1, k, s]
            i = 2 * j + stage
            for s in range(LANES):
                # plain numbers, as they stay in the processor's registers
                a0, a1, a2, a3, a4 = row[0, s], row[1, s], row[2, s], row[3, s], row[4, s]
                a5, right = 1.0 + row[5, s], weights[j, s]
                a6, a7, a8, a9, a10 = row[6, s], row[7, s], row[8, s], row[9, s], row[10, s]
                factor = a0 * done[i, 0, s]
                a1 -= factor * done[i, 1, s]
                a2 -= factor * done[i, 2, s]
                a3 -= factor * done[i, 3, s]
                a4 -= factor * done[i, 4, s]
                a5 -= factor * done[i, 5, s]
                right -= factor * done[i, 6, s]
                factor = a1 * done[i + 1, 0, s]
                a2 -= factor * done[i + 1, 1, s]
                a3 -= factor * done[i + 1, 2, s]
                a4 -= factor * done[i + 1, 3, s]
                a5 -= factor * done[i + 1, 4, s]
                a6 -= factor * done[i + 1, 5, s]
                right -= factor * done[i + 1, 6, s]
                factor = a2 * done[i + 2, 0, s]
                a3 -= factor * done[i + 2, 1, s]
                a4 -= factor * done[i + 2, 2, s]
                a5 -= factor * done[i + 2, 3, s]
                a6 -= factor * done[i + 2, 4, s]
                a7 -= factor * done[i + 2, 5, s]
                right -= factor * done[i + 2, 6, s]
                factor = a3 * done[i + 3, 0, s]
                a4 -= factor * done[i + 3, 1, s]
                a5 -= factor * done[i + 3, 2, s]
                a6 -= factor * done[i + 3, 3, s]
                a7 -= factor * done[i + 3, 4, s]
                a8 -= factor * done[i + 3, 5, s]
                right -= factor * done[i + 3, 6, s]
                factor = a4 * done[i + 4, 0, s]
                a5 -= factor * done[i + 4, 1, s]
                a6 -= factor * done[i + 4, 2, s]
                a7 -= factor * done[i + 4, 3, s]
                a8 -= factor * done[i + 4, 4, s]
                a9 -= factor * done[i + 4, 5, s]
                right -= factor * done[i + 4, 6, s]
                done[i + 5, 0, s] = 1.0 / a5
                done[i + 5, 1, s], done[i + 5, 2, s], done[i + 5, 3, s] = a6, a7, a8
                done[i + 5, 4, s], done[i + 5, 5, s], done[i + 5, 6, s] = a9, a10, right
    # from the last unknown up: done[i + k, 6] is the unknown k below, already found, done[i, k] its element in row i
    for back in range(2 * cells):
        i = 2 * cells + 4 - back
        for s in range(LANES):
            found = done[i, 6, s]
            found -= done[i, 1, s] * done[i + 1, 6, s]
            found -= done[i, 2, s] * done[i + 2, 6, s]
            found -= done[i, 3, s] * done[i + 3, 6, s]
            found -= done[i, 4, s] * done[i + 4, 6, s]
            found -= done[i, 5, s] * done[i + 5, 6, s]
            done[i, 6, s] = found * done[i, 0, s]
    return _conserved(done, weights, losses)


@compiled
def _conserved(done: Array, weights: Array, losses: Losses) -> Array:
    """The weights at the end of a step, as `step` has found them in `done`, times what makes their sum that at its
    begin less what was lost: by the flux through the lower face of the first cell and, where contacts break `early`, by
    h. On a step so long that thresholds spread over millions of first cells the 1 in a row of `step` is lost in the
    rounding of L, and with it up to 1e-6 of the weights, which came back as births."""
    cells = weights.shape[0]
    leaving, entering, breaking, early, spread, value, slope = losses
    # the second stage is the end of the step
    end = done[6:-5:2, 6].copy()
    before, after, lost = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    for j in range(cells):
        for s in range(LANES):
            before[s] += weights[j, s]
            after[s] += end[j, s]
    for stage in range(2):
        part = RADAU[1, stage]
        for k in range(2):
            for s in range(LANES):
                rate = leaving[stage, 0, s] * value[k + 2, 0] + spread[stage, s] * slope[k + 2, 0]
                lost[s] += part * rate * done[2 * k + stage + 5, 6, s]
        if early:
            for j in range(cells):
                for s in range(LANES):
                    lost[s] += part * breaking[stage, j, s] * done[2 * j + stage + 5, 6, s]
            for j in range(1, cells):
                for k in range(max(j - 2, 0), min(j + 2, cells)):
                    for s in range(LANES):
                        rate = (leaving[stage, j, s] - entering[stage, j, s]) * value[k - j + 2, j]
                        lost[s] += part * rate * done[2 * k + stage + 5, 6, s]
    for s in range(LANES):
        kept = before[s] - lost[s]
        # a strand without weights stays so; one of which next to none are left, in digits that the sum lost, stays, too
        if not (kept > 0.0 and after[s] > 0.0):
            after[s] = kept = 1.0
        lost[s] = kept / after[s]
    return end * lost


@compiled
def flow_to_normal(level: Array, faces: Array, rate: Array, rise: Array) -> Array:
    """rate (level + face) + rise for each of the faces, arrays (cells,), `level` and `rate` of shape (2, LANES), and
    `rise` (LANES,): shape (2, cells, LANES)."""
    flow = np.empty((2, faces.size, LANES))
    for stage in range(2):
        for j in range(faces.size):
            for s in range(LANES):
                flow[stage, j, s] = rate[stage, s] * (level[stage, s] + faces[j]) + rise[s]
    return flow


@compiled
def density_at(weights: Array, edges: Array, edge: int) -> float:
    """The density at an edge, which makes the cubics through the weights below edges monotone: the weighted harmonic
    mean of the mean densities of both cells, 0 where one of them is (Fritsch and Butland 1984); at the first and the
    last edge by a parabola, limited to 3 times the mean density of the cell. `weights`: of one strand, (cells,)."""
    last = weights.size
    inner = min(max(edge, 1), last - 1)
    left, right = edges[inner] - edges[inner - 1], edges[inner + 1] - edges[inner]
    before, after = weights[inner - 1] / left, weights[inner] / right
    if edge in (0, last):
        if edge == last:
            left, right, before, after = right, left, after, before
        found = ((2.0 * left + right) * before - left * after) / (left + right)
        if found * before <= 0.0:
            return 0.0
        return 3.0 * before if before * after <= 0.0 and abs(found) > 3.0 * abs(before) else found
    if before * after <= 0.0:
        return 0.0
    one, two = 2.0 * right + left, right + 2.0 * left
    return (one + two) / (one / before + two / after)


@compiled
def weight_below(weights: Array, edges: Array, cell: int, at: float) -> float:
    """The weight of a cell below a place in it, by the cubic; `weights`: of one strand, (cells,)."""
    width = edges[cell + 1] - edges[cell]
    place = (at - edges[cell]) / width
    rest = 1.0 - place
    slopes = density_at(weights, edges, cell) * rest - density_at(weights, edges, cell + 1) * place
    return weights[cell] * place**2 * (3.0 - 2.0 * place) + width * place * rest * slopes


@compiled
def weight_above(weights: Array, edges: Array, rise: Array) -> Array:
    """Sums of the weights (strands, cells) that remain after the rise of each strand, at least 0; shape (strands,)."""
    out = np.zeros(rise.size)
    for i in range(rise.size):
        if rise[i] < edges[-1]:
            cell = np.searchsorted(edges, rise[i], "right") - 1
            above = weights[i, cell] - weight_below(weights[i], edges, cell, rise[i])
            out[i] = above + weights[i, cell + 1 :].sum()
    return out


@compiled
def shifted(weights: Array, edges: Array, rise: Array) -> Array:
    """Weights (strands, cells) that remain above |x| when it jumps by the rise of each strand, of either sign."""
    strands, cells = weights.shape
    out = np.zeros(weights.shape)
    for i in range(strands):
        # the weight below the cell that is reached, and below the lower edge of the one that is filled
        cell, below, before = 0, 0.0, 0.0
        for j in range(cells + 1):
            at = min(max(edges[j] + rise[i], 0.0), edges[-1])
            while cell < cells - 1 and edges[cell + 1] <= at:
                below += weights[i, cell]
                cell += 1
            now = below + weight_below(weights[i], edges, cell, at)
            if j > 0:
                out[i, j - 1] = now - before
            before = now
    return out
