"""The exact propagator of hops between cells."""

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm

from origins.laws.diffusion import Diffusion

Array = npt.NDArray[np.float64]


def evolved(hops: Diffusion, weights: Array, amount: float) -> Array:
    """The weights of cells after D t = amount."""
    generator = np.diag(hops.up, -1) + np.diag(hops.down, 1)
    return expm(amount * (generator - np.diag(generator.sum(axis=0)))) @ weights
