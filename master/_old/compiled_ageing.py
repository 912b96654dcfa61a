"""One step of the thresholds' densities of contacts that age, strand by strand, compiled.

All that is compiled for it stands in this one file, because numba's cache on disk notices changes in a function's own
file only.
"""


import numpy as np
import numpy.typing as npt

from master._old.compiling import compiled

Array = npt.NDArray[np.float64]


@compiled
def _solve(band: Array, found: Array) -> None:
    """In place, the solution of a system; band[i, 5 + j] stands in row i and column i + j, |j| <= 5."""
    n = found.size
    for i in range(n):
        pivot = 1.0 / band[i, 5]
        for k in range(1, min(5, n - 1 - i) + 1):
            factor = band[i + k, 5 - k] * pivot
            if factor != 0.0:
                for j in range(1, 6):
                    band[i + k, 5 - k + j] -= factor * band[i, 5 + j]
                found[i + k] -= factor * found[i]
    for i in range(n - 1, -1, -1):
        value = found[i]
        for j in range(1, min(5, n - 1 - i) + 1):
            value -= band[i, 5 + j] * found[i + j]
        found[i] = value / band[i, 5]


@compiled
def step(
    weights: Array,
    cells: npt.NDArray[np.intp],
    flow: Array,
    early: Array,
    spread: Array,
    value: Array,
    slope: Array,
    matrix: Array,
) -> Array:
    """Weights at the end of a step, shape (strands, cells), of which strand i needs the first cells[i].

    flow : of the density through the cells' lower faces at both stages, per density, shape (2, strands, cells)
    early : rate of breaking in the cells, of the same shape or of no cells
    spread : D, shape (2, strands); all three are times the step
    value, slope : of the density at these faces from the weights of four cells, shape (cells, 4)
    matrix : of the two stages
    """
    out = np.zeros(weights.shape)
    most = weights.shape[1]
    band, found = np.zeros((2 * most, 11)), np.zeros(2 * most)
    for i in range(weights.shape[0]):
        m = cells[i]
        for row in range(2 * m):
            found[row] = weights[i, row // 2]
            for k in range(11):
                band[row, k] = 0.0
            band[row, 5] = 1.0
        for stage in range(2):
            first, last = matrix[0, stage], matrix[1, stage]
            for j in range(m):
                # through the face below cell j flows what cells j - 2 to j + 1 make flow: out of j, into j - 1
                for k in range(4):
                    if 0 <= j - 2 + k < m:
                        flux = flow[stage, i, j] * value[j, k] + spread[stage, i] * slope[j, k]
                        at = 5 + 2 * (k - 2) + stage
                        band[2 * j, at] += first * flux
                        band[2 * j + 1, at - 1] += last * flux
                        if j > 0:
                            band[2 * j - 2, at + 2] -= first * flux
                            band[2 * j - 1, at + 1] -= last * flux
                if early.shape[2] > 0:
                    band[2 * j, 5 + stage] += first * early[stage, i, j]
                    band[2 * j + 1, 4 + stage] += last * early[stage, i, j]
        _solve(band[: 2 * m], found[: 2 * m])
        for j in range(m):
            out[i, j] = found[2 * j + 1]
    return out
