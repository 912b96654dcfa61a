"""Thresholds of pinning grains with the Jacobian the paper prints: P_c proportional to P_LS(u(x)) (paper, Eq. LS2)."""

from fractions import Fraction

import numpy as np
import numpy.typing as npt

from origins.grains.pinning import PinningGrains
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, Thresholds

# cells end at these integrated hazards of the exact law; what lies beyond the last is an integral of e^-w, w the hazard
# that is left, with a smooth factor
_HAZARDS: Array = np.linspace(0.0, 5.5, 23) ** 2
_TAIL_NODES, _TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(16)
_CELL_NODES, _CELL_WEIGHTS = np.polynomial.legendre.leggauss(12)
_CELL_NODES, _CELL_WEIGHTS = 0.5 * (_CELL_NODES + 1.0), 0.5 * _CELL_WEIGHTS
_ORDER = 15
_PLACES = np.cos(np.pi * (np.arange(_ORDER) + 0.5) / _ORDER)  # Chebyshev's, on (-1, 1)
_TO_SERIES = np.linalg.inv(np.polynomial.chebyshev.chebvander(_PLACES, _ORDER - 1))
_ROWS = 1 << 15


class PrintedGrains(PinningGrains):
    """P_LS(u(x)), normalised.

    In each cell the mean of the density from the cell's left end to x is a Chebyshev series, so that the cdf keeps its
    digits down to x = 0; survivals add up from the right.
    """

    onset_power = 0.0

    def __init__(self, excess: Fraction, B: float) -> None:
        super().__init__(excess, B)
        ends = self._where(_HAZARDS)
        # sizes bend where x is near B^(-1/2), however far the law reaches
        near = 0.5 * 2.0 ** np.arange(np.log2(max(self._m0, 2.0))) / self._root_b
        self._edges = np.concatenate([[0.0], near[near < 0.7 * ends[1]], ends[1:]])
        self._widths = np.diff(self._edges)
        parts = (0.5 * (1.0 + np.append(_PLACES, 1.0)))[None, :, None] * _CELL_NODES
        x = self._edges[:-1, None, None] + self._widths[:, None, None] * parts
        means = np.exp(self._log_weight(x)) @ _CELL_WEIGHTS
        self._series = means[:, :-1] @ _TO_SERIES.T
        masses = means[:, -1] * self._widths
        self._whole = 1.0
        last = np.exp(self._log_tail(self._edges[-1:]))
        self._above = np.cumsum(np.concatenate([last, masses[::-1]]))[::-1]
        self._below = np.concatenate([[0.0], np.cumsum(masses)])
        self._masses = masses
        self._whole = float(self._above[0])

    def _log_weight(self, x: Array) -> Array:
        """log of P_LS(u(x))/P_LS(1/rho)."""
        k, gap, left = self._stretch(x)
        q = gap / (self._e0 * left)
        size = 2.0 * np.log(k) - 7.0 / 3.0 * np.log1p(gap / (2.0 * self._m0 + 1.0))
        return size + 11.0 / 3.0 * np.log1p(q * self._e0) - q

    def _log_tail(self, x: Array) -> Array:
        """log survival at x, of shape (n,), far out: with H the exact integrated hazard, that of e^-H dx/dy over H."""
        hazard = self._hazard(x)
        further = self._where(hazard[:, None] + _TAIL_NODES)
        stretch = np.hypot(1.0, self._root_b * further) / (self._root_b * further)
        scale = (2.0 + self._y0) * (self._e0 * self._m0) ** 2 * self._m0 / (3.0 * self._root_b)
        return np.log(scale / self._whole) + np.log(stretch @ _TAIL_WEIGHTS) - hazard

    def _from_left(self, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        """The cells that x, of shape (n,), lie in, and the weight there to the left of x."""
        cell = np.searchsorted(self._edges, x, side="right") - 1
        weight: Array = np.empty(x.shape)
        for i in range(0, x.size, _ROWS):
            rows = cell[i : i + _ROWS]
            start = x[i : i + _ROWS] - self._edges[rows]
            place = 2.0 * start / self._widths[rows] - 1.0
            weight[i : i + _ROWS] = start * np.polynomial.chebyshev.chebval(place, self._series[rows].T, tensor=False)
        return cell, weight

    def _logpdf(self, x: Array) -> Array:
        out = np.full(x.shape, -np.inf)
        inner = self._stretch(x)[2] > 0.0
        out[inner] = self._log_weight(x[inner]) - np.log(self._whole)
        return out

    def _cdf(self, x: Array) -> Array:
        out, inner = np.empty(x.shape), x < self._edges[-1]
        cell, weight = self._from_left(x[inner])
        out[inner] = (self._below[cell] + weight) / self._whole
        out[~inner] = -np.expm1(self._log_tail(x[~inner]))
        return np.minimum(out, 1.0)

    def _sf(self, x: Array) -> Array:
        out, inner = np.empty(x.shape), x < self._edges[-1]
        cell, weight = self._from_left(x[inner])
        out[inner] = (self._above[cell + 1] + (self._masses[cell] - weight)) / self._whole
        out[~inner] = np.exp(self._log_tail(x[~inner]))
        return np.minimum(out, 1.0)

    def _logsf(self, x: Array) -> Array:
        out, inner = np.empty(x.shape), x < self._edges[-1]
        out[inner] = Thresholds._logsf(self, x[inner])
        out[~inner] = self._log_tail(x[~inner])
        return out

    def _from_hazard(self, hazard: Array) -> Array:
        flat = hazard.ravel()
        ends = np.zeros(flat.shape), np.full(flat.shape, self._upper)
        return invert_hazard(self, flat, *ends, self._where(flat)).reshape(hazard.shape)
