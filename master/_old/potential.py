"""The drift of thresholds that age: U' = -d ln P_cf/dx of any final law, from a table of ln P_cf."""

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master._old.piecewise import Piecewise, tabulate
from origins import Thresholds

Array = npt.NDArray[np.float64]

_SEEDS = np.array([1e-9, 1e-5, 1e-3, 0.03, 0.25, 0.5])
_APART = 1e-4  # of the range: what lies between is found by bisection if it is there
_ROUND_OFF = 4e-16


class Potential:
    """U'(x) of the final law between the lower end of its support and `upper` (lengths).

    Attributes
    ----------
    final : Thresholds
    is_singular : bool
        Whether P_cf vanishes or diverges at the lower end.
    edges : array (n,)
        Ends of the panels on each of which U' is one series.
    """

    def __init__(self, final: Thresholds, upper: float) -> None:
        self.final, lower = final, final.support()[0]
        self.is_singular = not 0.0 < float(final.pdf(lower)) < np.inf
        corners = final.breakpoints[(final.breakpoints > lower) & (final.breakpoints < upper)]
        ends = np.concatenate([[lower], corners, [upper]])
        for seed in np.concatenate([final.ppf(_SEEDS), final.isf(_SEEDS)]):
            if lower < seed < upper and np.abs(seed - ends).min() > _APART * (upper - lower):
                ends = np.append(ends, seed)

        def log_density(x: Array) -> Array:
            return final.logpdf(x)[None]

        table = tabulate(log_density, np.sort(ends), 1e-15)[0]
        width = np.diff(table.edges)
        # a derivative blows up what rounding left
        size = np.abs(table.coefficients).max(axis=0)
        kept = np.where(np.abs(table.coefficients) > _ROUND_OFF * size, table.coefficients, 0.0)
        slopes = np.zeros_like(kept)
        slopes[:-1] = -legendre.legder(kept) * (2.0 / width)
        self.edges = table.edges
        self._table = Piecewise(table.edges, slopes)

    def slope(self, x: Array) -> Array:
        """U' at x, per length; at the ends of the table where x lies beyond."""
        return self._table(np.clip(x, self._table.edges[0], self._table.edges[-1]))
