"""How far and how finely thresholds that age are spread: the furthest at any age, and the narrowest width."""

import numpy as np

from origins import Thresholds


def highest(fresh: Thresholds, final: Thresholds, fraction: float) -> float:
    """Threshold (a length) that at most this fraction exceeds at any age: fresh thresholds above the final mean spread
    upwards at first."""
    beyond_mean = float(final.isf(fraction)) - final.mean()
    return max(float(fresh.isf(fraction)), final.mean()) + beyond_mean


def narrowest(law: Thresholds) -> float:
    """Standard deviation of a normal law whose narrowest tenth of the weight is as narrow as this law's."""
    spread = np.diff(law.ppf(np.linspace(0.1, 0.9, 9)))  # tenths but for the tails, which are wider
    # the narrowest tenth of a normal law of standard deviation 1 is 0.25 wide
    return float(spread[spread > 0.0].min(initial=law.mean())) / 0.25
