"""One exact threshold for all contacts: the paper's singular case (App. E)."""

import numpy as np

from origins.errors import positive
from origins.thresholds.law import Array, Thresholds


def identical(value: float) -> Thresholds:
    """P_c(x) = delta(x - value); value is a length above zero, else InputError."""
    return Identical(positive("value", value))


class Identical(Thresholds):
    """All weight in one atom; pdf is zero everywhere."""

    def __init__(self, value: float) -> None:
        self.value = value

    def support(self) -> tuple[float, float]:
        return self.value, self.value

    @property
    def breakpoints(self) -> Array:
        return np.array([self.value])

    @property
    def atoms(self) -> tuple[Array, Array]:
        return np.array([self.value]), np.array([1.0])

    def _pdf(self, x: Array) -> Array:
        return np.zeros(x.shape)

    def _ppf(self, q: Array) -> Array:
        return np.full(q.shape, self.value)

    def _isf(self, q: Array) -> Array:
        return np.full(q.shape, self.value)

    def _variance(self) -> float:
        return 0.0

    def _moment(self, n: float) -> float:
        return self.value**n
