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
