"""One step in time of the weights of thresholds in cells, strand by strand: the compiled part.

All code that numba compiles for ageing is in this file, because its cache on disk detects changes
only in a function's own file.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from origins.thresholds.law import Array

# Radau's method of two stages, of third order: its last stage is the end of the step, so that stiff
# components, such as the thin edge of a density at the level, are damped to their final values.
STAGES = np.array([1.0 / 3.0, 1.0])
RADAU = np.array([[5.0, -1.0], [9.0, 3.0]]) / 12.0


def compiled(function: Callable[..., Any]) -> Any:
    """`function`, compiled when first called; kept on disk where a folder can be written."""
    try:
        return njit(cache=True)(function)
    except RuntimeError:  # numba found no folder for its cache
        return njit(function)


@compiled
def solve_band(band: Array, right: Array) -> None:
    """Solve a system in place; band[i, 5 + j] is the element in row i and column i + j, |j| <= 5."""
    n = right.size
    for i in range(n):
        pivot = 1.0 / band[i, 5]
        for k in range(1, min(5, n - 1 - i) + 1):
            factor = band[i + k, 5 - k] * pivot
            if factor != 0.0:
                for j in range(1, 6):
                    band[i + k, 5 - k + j] -= factor * band[i, 5 + j]
                right[i + k] -= factor * right[i]
    for i in range(n - 1, -1, -1):
        value = right[i]
        for j in range(1, min(5, n - 1 - i) + 1):
            value -= band[i, 5 + j] * right[i + j]
        right[i] = value / band[i, 5]


@compiled
def step(
    weights: Array,
    leaving: Array,
    entering: Array,
    breaking: Array,
    spread: Array,
    value: Array,
    slope: Array,
) -> Array:
    """Weights of thresholds in cells at the end of a step, shape (strands, cells).

    weights : array (strands, cells) at its beginning
    leaving, entering : arrays (2, strands, cells), at both stages: the flux out of a cell through its
        lower face, and that into the cell below, both per density at the face
    breaking : array (2, strands, cells), rate at which contacts in a cell break
    spread : array (2, strands), the diffusivity; the last four are multiplied by the step
    value, slope : arrays (4, cells), the density and its slope at the lower face of each cell j from
        the weights of the cells j - 2 to j + 1
    """
    strands, cells = weights.shape
    out, found, band = np.empty(weights.shape), np.empty(2 * cells), np.empty((2 * cells, 11))
    for i in range(strands):
        # rows and columns: both stages of each cell in turn
        band[:] = 0.0
        for j in range(cells):
            found[2 * j : 2 * j + 2] = weights[i, j]
            for row in range(2):
                band[2 * j + row, 5] += 1.0
                for stage in range(2):
                    part, shift = RADAU[row, stage], 5 + stage - row
                    band[2 * j + row, shift] += part * breaking[stage, i, j]
                    for k in range(4):
                        at, diffused = shift + 2 * (k - 2), spread[stage, i] * slope[k, j]
                        lost = leaving[stage, i, j] * value[k, j] + diffused
                        band[2 * j + row, at] += part * lost
                        if j > 0:
                            come = entering[stage, i, j] * value[k, j] + diffused
                            band[2 * j - 2 + row, at + 2] -= part * come
        solve_band(band, found)
        out[i] = found[1::2]
    return out


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
def held_above(weights: Array, edges: Array, level: Array) -> Array:
    """Sums of the weights (strands, cells) above a level in y of each strand, at least 0; shape (strands,)."""
    out = np.zeros(level.size)
    for i in range(level.size):
        if level[i] < edges[-1]:
            cell = np.searchsorted(edges, level[i], "right") - 1
            held = weights[i, cell] - weight_below(weights[i], edges, cell, level[i])
            out[i] = held + weights[i, cell + 1 :].sum()
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
