"""The cumulative hazard of Lifshitz and Slyozov's law of grain sizes under coalescence (paper, Eq. LS1).

Sizes are written y = r/(3<r>/2), relative to the largest grain. The density is then the derivative of

    psi(y) = (4/3) ln(1 + y/2) + (5/3) ln(1 - y) + y/(1 - y),      survival = e^-psi,

since the shape of the law stays the same while grains grow and vanish. With q = 1/(1 - y) - 1/(1 - y0),
psi(y) - psi(y0) is convex in q, and q goes to infinity at the largest grain, which removes the singularity.
"""

import numpy as np

from origins.thresholds.law import Array
from origins.thresholds.quadrature import gauss


def hazard_beyond(q: Array, excess: Array | float = 1e300) -> Array:
    """psi(y) - psi(y0) for finite q >= 0: e^-psi is the survival of the sizes (paper, Eq. LS1).

    It has the relative accuracy of floating point, however small it is. y0 = 1/(1 + excess), so that neither end loses
    digits; shapes broadcast. When left out, y0 is 0.
    """
    y0, room = 1.0 / (1.0 + excess), excess / (1.0 + excess)
    gap = room * (q * room / (1.0 + q * room))
    out = q - 5.0 / 3.0 * np.log1p(q * room) + 4.0 / 3.0 * np.log1p(gap / (2.0 + y0))
    # small grains: the three terms cancel to the third order, their derivative does not
    small = y0 + gap < 0.4
    if small.any():
        nodes, weights = gauss(np.zeros(int(small.sum())), gap[small])
        y = np.broadcast_to(y0, small.shape)[small][:, None] + nodes
        out[small] = (weights * (3.0 * y * y / ((2.0 + y) * (1.0 - y) ** 2))).sum(-1)
    return out


def invert_beyond(hazard: Array, excess: Array) -> Array:
    """q >= 0 with psi(y) - psi(y0) = hazard, finite and >= 0, by Newton's steps from above, as psi is convex in q."""
    goal, y0, room = np.maximum(hazard, 1e-300), 1.0 / (1.0 + excess), excess / (1.0 + excess)
    with np.errstate(over="ignore"):
        straight = goal * (2.0 + y0) / (3.0 * np.square(y0))
    q = np.minimum(straight, np.cbrt(2.0 * goal) + goal + 5.0 / 3.0 * np.log1p(goal))
    for _ in range(60):
        y = y0 + q * room * (room / (1.0 + q * room))
        step = (hazard_beyond(q, excess) - goal) * (2.0 + y) / (3.0 * y * y)
        q = np.maximum(q - step, 0.125 * q)
        if (np.abs(step) <= 1e-7 * q).all():  # the error that a step leaves is quadratic
            break
    return np.where(hazard > 0.0, q, 0.0)
