"""What is left of contacts born while the slider stands, by their age alone: read from a table in its logarithm."""

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from master._old.wear import Wear

Array = npt.NDArray[np.float64]

_STEP = 0.08  # in ln t; a rate is felt over a few e-folds
_BEFORE = 40.0  # ln of how much sooner than after the shortest time there is nothing to tell


class Resting:
    """
    again : arrays (n,)
        Stretches of births, and with each its weight over S(|r|).
    longest : float
        The highest age.
    """

    def __init__(self, wear: Wear, again: tuple[Array, Array], longest: float) -> None:
        stretch, share = again
        number = int(np.ceil((_BEFORE + max(np.log(longest / wear.time), 1.0)) / _STEP)) + 1
        at = np.linspace(np.log(wear.time) - _BEFORE, max(np.log(longest), np.log(wear.time) + 1.0), number)
        held, pull = np.zeros(number), np.zeros(number)
        for x, weight in zip(stretch.tolist(), share.tolist(), strict=True):
            place = np.full(number, x)
            worn = wear.fresh(place)
            wear.advance(worn, place, place, np.abs(place), np.exp(at))
            left = wear.left(worn, place, np.abs(place))
            held, pull = held + weight * left.held, pull + weight * x * left.stiff
        self._first, self._table = float(at[0]), CubicSpline(at, np.stack([held, pull], axis=1))

    def young(self, age: Array) -> tuple[Array, Array]:
        """Share that holds at ages, and its force."""
        with np.errstate(divide="ignore"):
            held, pull = self._table(np.maximum(np.log(age), self._first)).T
        return held, pull
