"""The tail of a law of thresholds: how fast its survival falls far out."""

import numpy as np

from origins.thresholds.law import ThresholdLaw


def tail_rate(law: ThresholdLaw) -> tuple[float, float]:
    """Rate at which ln S falls in the tail, and its error (per length); inf if it falls faster than linearly, 0 if
    slower. With heat, too: the stronger a contact, the less likely it breaks before its threshold."""
    if np.isfinite(law.support()[1]):
        return np.inf, 0.0
    # the survival is sampled outwards down to 1e-290, since many distributions cannot compute far quantiles
    x = law.mean() * 2.0 ** np.arange(0.0, 400.0, 0.25)
    with np.errstate(over="ignore"):
        last = x[np.flatnonzero(law.logsf(x) > np.log(1e-290))[-1]]
    ends = last * np.array([0.125, 0.25, 0.5, 1.0])
    # where ln S = a - rate x + power ln x, each doubling of x halves the slopes' distance to -rate
    slopes = -np.diff(law.logsf(ends)) / np.diff(ends)
    change, rounded = np.diff(slopes), 1e-9 * slopes[-1]
    level = abs(slopes[-1] - slopes[0]) < 0.25 * slopes[-1]
    if level and abs(change[1]) < max(0.6 * abs(change[0]), rounded):
        return slopes[-1] + change[1], abs(2.0 * change[1] - change[0]) + rounded
    return np.inf if slopes[-1] > slopes[0] else 0.0, 0.0
