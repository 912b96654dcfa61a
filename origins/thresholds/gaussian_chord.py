"""The paper's corrected Gaussian: the normal density less its chord over (0, upper) (paper, after Eq. Q14e)."""

from collections.abc import Callable

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, Thresholds

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
_REACH = 38.6  # standard deviations beyond which the normal density underflows


class ChordGaussian(Thresholds):
    """P_c ~ h(x) = G(x) - G(0) - (x/upper) [G(upper) - G(0)] where that is positive; 0 < parent_mean < upper.

    h is positive on one interval. It ends at 0 and at upper, or before, where the chord lies above the density.
    """

    onset_power = 1.0

    def __init__(self, parent_mean: float, parent_std: float, upper: float) -> None:
        self.parent_mean = parent_mean
        self.parent_std = parent_std
        self.upper = upper
        first = _zero_beyond(upper - parent_mean, parent_std, upper)
        self._ends = upper - first, _zero_beyond(parent_mean, parent_std, upper)
        low = max(self._ends[0], parent_mean - _REACH * parent_std)
        high = min(self._ends[1], parent_mean + _REACH * parent_std)
        self._edges = np.linspace(low, high, int(np.ceil(2.0 * (high - low) / parent_std)) + 1)
        self._nodes, weights = _gauss(self._edges[:-1], self._edges[1:])
        self._weights = weights * np.exp(self._log_height(self._nodes))
        mass = self._weights.sum(-1)
        self._log_whole = float(np.log(mass.sum()))
        self._weights /= mass.sum()
        # summed from either end: all terms are positive, so both tails keep their digits
        self._below = np.concatenate([[0.0], np.cumsum(mass)]) / mass.sum()
        self._above = np.concatenate([np.cumsum(mass[::-1])[::-1], [0.0]]) / mass.sum()

    def support(self) -> tuple[float, float]:
        return self._ends

    def _log_height(self, x: Array) -> Array:
        """log of h(x) / G(mean), from the zero of h that lies closer, so that nothing cancels there."""
        low, high = self._ends
        anchor = np.where(x - low < high - x, low, high)
        with np.errstate(over="ignore", divide="ignore"):
            share = -np.expm1(self._log_ratio(anchor, x)) - self._rise(x) * (x - anchor) / self.upper
            return -0.5 * ((x - self.parent_mean) / self.parent_std) ** 2 + np.log(np.maximum(share, 0.0))

    def _rise(self, x: Array) -> Array:
        """[G(upper) - G(0)] / G(x)."""
        rise = self._log_ratio(self.upper, np.zeros(()))
        if rise < 0.0:
            return np.exp(self._log_ratio(0.0, x)) * np.expm1(rise)
        return -np.exp(self._log_ratio(self.upper, x)) * np.expm1(-rise)

    def _log_ratio(self, at: Array | float, x: Array) -> Array:
        """log of G(at) / G(x)."""
        return (at - x) / self.parent_std * ((self.parent_mean - 0.5 * (at + x)) / self.parent_std)

    def _logpdf(self, x: Array) -> Array:
        return self._log_height(x) - self._log_whole

    def _pdf(self, x: Array) -> Array:
        return np.exp(self._logpdf(x))

    def _cdf(self, x: Array) -> Array:
        cell = self._cell(x)
        return np.minimum(self._below[cell] + self._integral(self._edges[cell], x), 1.0)

    def _sf(self, x: Array) -> Array:
        cell = self._cell(x)
        return np.minimum(self._above[cell + 1] + self._integral(x, self._edges[cell + 1]), 1.0)

    def _cell(self, x: Array) -> Array:
        return np.clip(np.searchsorted(self._edges, x, side="right") - 1, 0, self._edges.size - 2)

    def _integral(self, left: Array, right: Array) -> Array:
        inside = np.clip(left, self._edges[0], self._edges[-1]), np.clip(right, self._edges[0], self._edges[-1])
        nodes, weights = _gauss(*inside)
        return (weights * self._pdf(nodes)).sum(-1)

    def _logsf(self, x: Array) -> Array:
        out = super()._logsf(x)
        # past the reach of the sums the chord has long been below what floating point resolves
        deep = ~(out > -700.0)
        if deep.any():
            normal = np.log(np.sqrt(2.0 * np.pi) * self.parent_std) - self._log_whole
            out[deep] = log_ndtr((self.parent_mean - x[deep]) / self.parent_std) + normal
        return out

    def _from_hazard(self, hazard: Array) -> Array:
        flat = hazard.ravel()
        low, high = np.full(flat.shape, self._ends[0]), np.full(flat.shape, self._ends[1])
        guess = self.parent_mean - self.parent_std * ndtri_exp(-flat)
        return invert_hazard(self, flat, low, high, np.clip(guess, low, high)).reshape(hazard.shape)

    def _moment(self, n: int) -> float:
        return float((self._weights * self._nodes**n).sum())

    def _variance(self) -> float:
        return float((self._weights * (self._nodes - self.mean()) ** 2).sum())


def _zero_beyond(mean: float, std: float, upper: float) -> float:
    """The zero of h on (mean, upper): upper itself, unless h is negative just below it."""
    drop = upper * (2.0 * mean - upper) / (2.0 * std * std)  # log of G(upper) / G(0)
    if drop >= 0.0:
        return upper
    rise = np.expm1(drop)
    if np.exp(drop) * (mean - upper) / std**2 <= rise / upper:
        return upper

    def height(x: float) -> float:
        return float(np.expm1(x * (2.0 * mean - x) / (2.0 * std * std)) - x / upper * rise)

    return _bisect(height, 2.0 * mean, upper)


def _bisect(function: Callable[[float], float], low: float, high: float) -> float:
    """The point where function, positive at low, turns negative."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)
    return low


def _gauss(left: Array, right: Array) -> tuple[Array, Array]:
    width = (right - left)[..., None]
    return left[..., None] + width * _NODES, width * _WEIGHTS
