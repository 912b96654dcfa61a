"""Lifshitz and Slyozov's law of grain sizes under coalescence (paper, Eq. LS1), and its integrated hazard.

Sizes are written y = r/(3<r>/2), relative to the largest grain. The density is then the derivative of

    psi(y) = (4/3) ln(1 + y/2) + (5/3) ln(1 - y) + y/(1 - y),      survival = e^-psi,

since the shape of the law stays the same while grains grow and vanish. With q = 1/(1 - y) - 1/(1 - y0),
psi(y) - psi(y0) is convex in q, and q goes to infinity at the largest grain, which removes the singularity.
"""

import numpy as np

from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss


def hazard_beyond(q: Array, y0: Array | float, e0: Array | float) -> Array:
    """psi(y) - psi(y0) for finite q >= 0, to the relative accuracy of floating point, however small it is.

    y0 in [0, 1) and e0 = 1 - y0 are both given, so that neither end loses digits; shapes broadcast.
    """
    gap = e0 * (q * e0 / (1.0 + q * e0))
    out = q - 5.0 / 3.0 * np.log1p(q * e0) + 4.0 / 3.0 * np.log1p(gap / (2.0 + y0))
    # small grains: the three terms cancel to the third order, their derivative does not
    small = y0 + gap < 0.4
    if small.any():
        nodes, weights = gauss(np.zeros(int(small.sum())), gap[small])
        y = np.broadcast_to(y0, small.shape)[small][:, None] + nodes
        out[small] = (weights * (3.0 * y * y / ((2.0 + y) * (1.0 - y) ** 2))).sum(-1)
    return out


def invert_beyond(hazard: Array, y0: Array | float, e0: Array | float) -> Array:
    """q >= 0 with psi(y) - psi(y0) = hazard >= 0, finite; shapes broadcast to that of hazard.

    Halley's steps approach the root from above from the first guess, since the hazard is convex in q.
    """
    goal = np.maximum(hazard, 1e-300)
    with np.errstate(divide="ignore", over="ignore"):
        straight = goal * (2.0 + y0) / (3.0 * np.square(y0))
    q = np.minimum(straight, np.cbrt(2.0 * goal) + goal + 5.0 / 3.0 * np.log1p(goal))
    for _ in range(60):
        left = e0 / (1.0 + q * e0)
        y = y0 + q * e0 * left
        step = (hazard_beyond(q, y0, e0) - goal) * (2.0 + y) / (3.0 * y * y)
        step /= 1.0 - 0.5 * step * left * left * (4.0 + y) / (y * (2.0 + y))
        q = np.maximum(q - step, 0.125 * q)
        if (np.abs(step) <= 1e-5 * q).all():  # the error that a step leaves is cubic
            break
    return np.where(hazard > 0.0, q, 0.0)


class LifshitzSlyozov(Thresholds):
    """Law of u = r/<r> on (0, 3/2), normalised: constant 3^4 e/2^(5/3), mean 1 (paper, Eq. LS1).

    u is a number, not a stretch; the methods are those of every law.
    """

    onset_power = 2.0

    def support(self) -> tuple[float, float]:
        return 0.0, 1.5

    def _hazard(self, u: Array) -> Array:
        return hazard_beyond(u / (1.5 - u), 0.0, 1.0)

    def _cdf(self, u: Array) -> Array:
        return -np.expm1(-self._hazard(u))

    def _sf(self, u: Array) -> Array:
        return np.exp(-self._hazard(u))

    def _logsf(self, u: Array) -> Array:
        return -self._hazard(u)

    def _logpdf(self, u: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            log = np.log(3.0 * u * u / ((u + 3.0) * (1.5 - u) ** 2)) - self._hazard(u)
        return np.where((u > 0.0) & (u < 1.5), log, -np.inf)

    def _moment(self, n: float) -> float:
        return 1.0 if n == 1 else super()._moment(n)
