"""Closed forms of (Q15): the steady state of normal laws, and the exact propagator of hops between cells."""

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm

from origins.laws.diffusion import Diffusion

Array = npt.NDArray[np.float64]


def gaussian_force(
    fresh_mean: float, fresh_square: float, mean: float, std: float, diffusion: npt.ArrayLike
) -> tuple[Array, Array]:
    """C and F_k/(N_c <k>) (lengths) for a normal final law of `mean` and `std`.

    fresh_mean and fresh_square are <x> and <x²> of P_ci, `diffusion` any D_X >= 0 (lengths), an array; both results
    have its shape. With λ = D_X/std² and resets once in C, <x - mean> decays by 1/(1 + λC) and what <(x - mean)²> has
    beyond std² by 1/(1 + 2λC). The normal law is not cut at 0 and there is no wall: exact where nothing comes near 0.
    """
    rate = np.asarray(diffusion, dtype=float) / std**2
    # λ C² + (1 - λ mean) C - fresh mean = 0, the root that stays for λ = 0, without cancellation
    half = 0.5 * (1.0 - rate * mean)
    root = np.sqrt(half * half + rate * fresh_mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        c = np.where(half > 0.0, fresh_mean / (half + root), (root - half) / rate)
    first, second = 1.0 / (1.0 + rate * c), 1.0 / (1.0 + 2.0 * rate * c)
    square = std**2 + (fresh_square - 2.0 * mean * fresh_mean + mean**2 - std**2) * second
    square = square + mean**2 + 2.0 * mean * (fresh_mean - mean) * first
    return c, 0.5 * square / c


def evolved(hops: Diffusion, weights: Array, amount: float) -> Array:
    """The weights of cells after D t = amount."""
    generator = np.diag(hops.up, -1) + np.diag(hops.down, 1)
    return expm(amount * (generator - np.diag(generator.sum(axis=0)))) @ weights
