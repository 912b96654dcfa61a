"""One exact threshold for all contacts: the paper's singular case (App. E)."""

import numpy as np

from origins.errors import positive
from origins.thresholds.families import Rectangular
from origins.thresholds.law import Array, Thresholds


def identical(value: float) -> Thresholds:
    """P_c(x) = delta(x - value); value is a length above zero, else InputError."""
    return Identical(positive("value", value))


class Identical(Rectangular):
    """A rectangle of no width, all weight in one atom; pdf is zero everywhere."""

    onset_power = np.inf

    def __init__(self, value: float) -> None:
        super().__init__(value, value)

    @property
    def breakpoints(self) -> Array:
        return np.array([self.lower])

    @property
    def atoms(self) -> tuple[Array, Array]:
        return np.array([self.lower]), np.array([1.0])

    def _pdf(self, x: Array) -> Array:
        return np.zeros(x.shape)

    def _moment(self, n: float) -> float:
        return self.lower**n
