"""Sums over the possible thresholds of a contact: those above the largest |x| of its life."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.lives.averages import Integrals, Pieces, integrals
from master.lives.life import SMALLEST, LawLife
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Last coefficients below which pieces are not halved; the error of sums is about their square. With a
# larger value, tables of these sums would be refined to resolve that error.
RESOLVED = 2e-12


def over_thresholds(
    life: LawLife,
    least: Array,
    felt: npt.NDArray[np.bool_],
    summand: Callable[[Rows, Array], Array],
    accuracy: Array | float = RESOLVED,
) -> Integrals:
    """Integrals of P_c times summands over the thresholds x_s above `least`, without exact ones.

    The panels of the law are halved. Where a rate vanishes at the threshold, its integral is a
    series in (x_s - least)^(1/2), which is the variable of integration for all.

    least : array of shape (n,), lengths
    felt : of shape (n, panels), which panels of the law count
    summand : takes contacts (n,) and thresholds (n, k), and gives an array (functions, n, k)
    """
    least = np.maximum(least, SMALLEST)
    ends = np.sqrt(np.maximum(life.panels, least[:, None]) - least[:, None])
    row, panel = np.nonzero(felt & (np.diff(ends, axis=1) > 0.0))

    def integrand(row: Rows, root: Array) -> Array:
        threshold = least[row, None] + root * root
        values = 2.0 * summand(row, threshold) * finite_density(life.law, threshold)
        # the weight is 0 at `least`; halving is decided by the first function without it
        whole = root.max(axis=1, keepdims=True) * values[:1]
        return np.concatenate([whole, root * values])

    pieces = Pieces(row, ends[row, panel], ends[row, panel + 1])
    found = integrals(integrand, pieces, least.size, accuracy)
    return found._replace(value=found.value[1:], missed=found.missed[1:])
