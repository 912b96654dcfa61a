"""Ageing over many equal steps, for any number of cells: the exponential of hops by a rational function of them.

    exp(z) ≈ 1/(1 - z + z²/2) = Re (1 - i)/(1 - (1 + i) z/2)

is of second order and forgets what is fast. One tridiagonal solution a step.
"""

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import zgttrf, zgttrs

from origins.diffusion import Diffusion

Array = npt.NDArray[np.float64]


class AgeingPropagator:
    """exp(amount × hops): weights of P_c (n,) before and after, their sum kept; amount = D t, a length squared, taken
    in `parts` steps."""

    def __init__(self, diffusion: Diffusion, amount: float, parts: int = 1) -> None:
        up, down = amount / parts * diffusion.up, amount / parts * diffusion.down
        leaving = np.append(up, 0.0) + np.append(0.0, down)
        pole = 0.5 + 0.5j
        self._factors = zgttrf(-pole * up, 1.0 + pole * leaving, -pole * down)[:5]
        self._parts, self._rest = parts, diffusion.stationary

    def __call__(self, weights: Array) -> Array:
        for _ in range(self._parts):
            after = ((1.0 - 1.0j) * zgttrs(*self._factors, weights.astype(complex))[0]).real
            # where amount × hops is large, the sum is known to so many roundings only
            weights = after + (weights.sum() - after.sum()) * self._rest
        return weights
