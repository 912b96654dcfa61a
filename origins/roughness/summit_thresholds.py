"""Thresholds of the summits that a flat touches, whatever power of the compression they are."""

import numpy as np

from origins.roughness.height_integrals import log_touching_integral
from origins.roughness.power_law import Bend
from origins.thresholds.families import Weibull
from origins.thresholds.gaussian import gaussian
from origins.thresholds.powered import Bent


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
        touching = gaussian(mean=-z * std, std=std) if heights == "gaussian" else Weibull(1.0, 1.0 / std, 0.0)
        super().__init__(touching, threshold)
        self.std_of_heights, self.z, self.heights = std, z, heights

    def _moment(self, n: int) -> float:
        power = self.bend.each(lambda law: law.power(n))
        touching = log_touching_integral(0.0, self.z, 0.0, np.inf, self.heights)
        return float(np.exp(log_sum(power, self.std_of_heights, self.z, self.heights) - touching))
