"""The paper's corrected Gaussian: the normal density less its chord over (0, upper) (paper, after Eq. Q14e)."""

import numpy as np

from origins.thresholds.law import Array, Thresholds
from origins.thresholds.numerical import NumericalLaw


class ChordGaussian(Thresholds):
    """P_c ~ h(x) = G(x) - G(0) - (x/upper) [G(upper) - G(0)] where that is positive; 0 < parent_mean < upper.

    h is positive on one interval within (0, upper), where the normal density G is above the chord.
    """

    onset_power = 1.0

    def __init__(self, parent_mean: float, parent_std: float, upper: float) -> None:
        self.parent_mean, self.parent_std, self.upper = parent_mean, parent_std, upper
        first = _zero_beyond(upper - parent_mean, parent_std, upper)
        self._ends = upper - first, _zero_beyond(parent_mean, parent_std, upper)
        self._numerical = NumericalLaw(
            self._log_weight, *self._ends, [parent_mean], self.onset_power
        )

    def support(self) -> tuple[float, float]:
        return self._ends

    def _log_weight(self, x: Array) -> Array:
        """log of h(x) / G(mean), written relative to the nearer zero of h, to avoid cancellation there."""
        low, high = self._ends
        anchor = np.where(x - low < high - x, low, high)
        with np.errstate(over="ignore", divide="ignore"):
            share = (
                -np.expm1(self._log_ratio(anchor, x)) - self._rise(x) * (x - anchor) / self.upper
            )
            return -0.5 * ((x - self.parent_mean) / self.parent_std) ** 2 + np.log(
                np.maximum(share, 0.0)
            )

    def _rise(self, x: Array) -> Array:
        """[G(upper) - G(0)] / G(x)."""
        rise = self._log_ratio(self.upper, np.zeros(()))
        if rise < 0.0:
            return np.exp(self._log_ratio(0.0, x)) * np.expm1(rise)
        return -np.exp(self._log_ratio(self.upper, x)) * np.expm1(-rise)

    def _log_ratio(self, at: Array | float, x: Array) -> Array:
        """log of G(at) / G(x)."""
        return (at - x) / self.parent_std * ((self.parent_mean - 0.5 * (at + x)) / self.parent_std)


def _zero_beyond(mean: float, std: float, upper: float) -> float:
    """The zero of h on (mean, upper): upper itself, unless h is negative just below it."""
    drop = upper * (2.0 * mean - upper) / (2.0 * std * std)  # log of G(upper) / G(0)
    if drop >= 0.0:
        return upper
    rise = np.expm1(drop)
    if np.exp(drop) * (mean - upper) / std**2 <= rise / upper:
        return upper
    low, high = 2.0 * mean, upper
    while low < (middle := 0.5 * (low + high)) < high:
        positive = (
            np.expm1(middle * (2.0 * mean - middle) / (2.0 * std * std)) - middle / upper * rise
            > 0.0
        )
        low, high = (middle, high) if positive else (low, middle)
    return low
