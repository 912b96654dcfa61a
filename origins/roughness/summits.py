"""Summits that a flat touches: means over the law of their heights, and their thresholds.

Lengths are in units of sigma_h, the standard deviation of the heights; the flat is at z, a summit of height z + t is
compressed by t.
"""

import numpy as np

from origins.roughness.power_law import Bend
from origins.thresholds.families import Weibull
from origins.thresholds.gaussian import gaussian
from origins.thresholds.powered import Bent

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(200)
_FALL = 60.0  # the integrand is left where the density has fallen by e^-60
_LOG_ROOT_TWO_PI = 0.5 * np.log(2.0 * np.pi)


def log_touching_integral(
    order: float, z: float, lower: float, upper: float, heights: str
) -> float:
    """log of the integral over lower < t < upper of t^order times the density of heights at z + t, over the common one.

    With log_common_density added, Greenwood and Williamson's F_n(z) for a flat at z, lengths in units of the heights'
    standard deviation; order >= 0. Gaussian heights have the standard normal density, exponential ones e^-h above
    h = 0, where z >= 0. Nothing under- or overflows, whether the load is light (z >> 1) or heavy (z < 0), and
    quotients of two orders lose no digits.
    """
    slope, curvature = (1.0, 0.0) if heights == "exponential" else (z, 1.0)
    # where the density is largest in between, and how far on either side it counts
    peak = min(max(lower, -slope * curvature), upper)
    tilt = slope + curvature * peak
    reach = 2.0 * _FALL / (abs(tilt) + np.sqrt(tilt * tilt + 2.0 * _FALL * curvature))
    near, far = max(lower, peak - reach), min(upper, peak + reach)
    # t = s^4 makes every quarter order smooth at 0, and other orders smooth enough
    low, high = near**0.25, far**0.25
    s = low + 0.5 * (high - low) * (_NODES + 1.0)
    away = s**4 - peak
    logs = np.log(4.0) + (4.0 * order + 3.0) * np.log(s) - away * (tilt + 0.5 * curvature * away)
    top = float(logs.max())
    inner = 0.5 * (high - low) * float((_WEIGHTS * np.exp(logs - top)).sum())
    if inner == 0.0:  # far out nothing lies between the limits any more
        return -np.inf
    at_peak = 0.5 * tilt * tilt if slope < 0.0 else peak * (slope + 0.5 * curvature * peak)
    return top + float(np.log(inner)) - at_peak


def log_common_density(z: float, heights: str) -> float:
    """log of the density of heights where the flat is, or at its peak where the flat lies below that."""
    if heights == "exponential":
        return -z
    return -0.5 * max(z, 0.0) ** 2 - _LOG_ROOT_TWO_PI


def log_sum(quantity: Bend, std: float, z: float, heights: str) -> float:
    """log of the integral of quantity(delta) over the summits that touch, over the common density of heights."""
    parts = [
        np.log(law.coefficient)
        + law.exponent * np.log(std)
        + log_touching_integral(law.exponent, z, low / std, high / std, heights)
        for law, low, high in quantity.pieces
    ]
    return float(np.logaddexp.reduce(parts))


class SummitThresholds(Bent):
    """Thresholds of summits: S(x) = Phi_c[(h0 + delta(x))/sigma_h]/Phi_c[h0/sigma_h] for Gaussian heights.

    Parameters
    ----------
    threshold : Bend
        x_s as a function of the compression delta, rising from 0; both are lengths.
    std : float
        sigma_h, a length.
    z : float
        h0/sigma_h, from the summits' mean plane.
    heights : "gaussian" or "exponential"
    """

    def __init__(self, threshold: Bend, std: float, z: float, heights: str = "gaussian") -> None:
        # the compressions of those that touch: a normal law cut at 0, or again the exponential
        touching = (
            gaussian(mean=-z * std, std=std)
            if heights == "gaussian"
            else Weibull(1.0, 1.0 / std, 0.0)
        )
        super().__init__(touching, threshold)
        self.std_of_heights, self.z, self.heights = std, z, heights

    def _moment(self, n: int) -> float:
        power = self.bend.each(lambda law: law.power(n))
        touching = log_touching_integral(0.0, self.z, 0.0, np.inf, self.heights)
        return float(np.exp(log_sum(power, self.std_of_heights, self.z, self.heights) - touching))
