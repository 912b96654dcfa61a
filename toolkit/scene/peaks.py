"""What islands at all angles do to stick-slip: the peaks of their P_c, and slips of springs at the strongest."""

import numpy as np

from origins.samples.from_samples import Sampled
from origins.thresholds.law import Thresholds

SPRINGS = (1.0, 10.0, 100.0)  # K/(N<k>)
_NEAREST, _PLACES = 1e-14, 6000  # of a peak's place; places on either side of a peak


def of_islands(law: Thresholds) -> list[str]:
    """What to tell of thresholds from islands: that K* is infinite and what springs do, or hangs on smoothing."""
    if law.domains is None or law.atoms[0].size:
        return []
    if isinstance(law, Sampled):
        if np.unique(law.domains.angles).size < law.domains.angles.size / 2:
            return []  # few angles, in turn
        return [
            "P_c of islands at all angles peaks where a barrier stands still in the angle, and samples smooth "
            "that away: K* hangs on the smoothing, and is no number of the islands"
        ]
    with np.errstate(divide="ignore"):
        peaks = law.breakpoints[np.isinf(law.pdf(law.breakpoints))]
    if not peaks.size:
        return []
    mean, told = law.mean(), []
    for spring in SPRINGS:
        slip = longest_slip(law, peaks, spring) / mean
        told.append(
            f"{spring * slip:.2g} <x_s> in a slip of {slip:.2g} <x_s> at K = {spring:g} N<k>"
        )
    return [
        "K* is infinite: P_c peaks as an inverse square root where a barrier stands still in the angle; as relaxed "
        f"contacts break for the first time, F/(N<k>) drops at most by about {', '.join(told)}"
    ]


def longest_slip(law: Thresholds, peaks: np.ndarray, spring: float) -> float:
    """The longest slip (a length) of relaxed contacts under a spring of K/(N<k>), at T = 0.

    F(X) = X - int_0^X x P_c dx until contacts break for the second time; a slip leads from where F + K X stops
    rising to where it is as high again.
    """
    lower, upper = law.support()
    away = np.geomspace(_NEAREST, 1.0, _PLACES)
    x = np.concatenate([peaks, *(peak * (1.0 + s * away) for peak in peaks for s in (-1, 1))])
    x = np.unique(np.append(x[(x > lower) & (x < 2.0 * upper)], [lower, upper]))
    below, above = law.cdf(x), law.sf(x)
    share = np.where(below[1:] < 0.5, np.diff(below), -np.diff(above))
    rise = np.diff(x) * (1.0 + spring) - 0.5 * (x[1:] + x[:-1]) * share
    height = np.concatenate([[0.0], np.cumsum(rise)])
    top = np.maximum.accumulate(height)
    last = np.maximum.accumulate(np.where(height >= top, np.arange(x.size), 0))
    return float((x - x[last]).max())
