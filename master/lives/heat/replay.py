"""A(x_s): the breaking rate of contacts, integrated over all their moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.motion.motion import Legs
from origins import Contacts
from origins.laws.rate_law import LARGEST_EXPONENT, RateLaw

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Stiffness = Callable[[Array], Array]

# ln A in place of -inf, where A = 0 or underflows.
_NOTHING = -740.0


class Replay:
    """The rate of n contacts, integrated leg by leg: the mean rate on each leg times the time there.

    Parameters
    ----------
    rates : RateLaw
    stiffness : callable
        k_i/<k> at thresholds; None where it is 1 for all.
    born : array of shape (n,)
        Stretch of each contact at its birth.
    legs : Legs
        Of the n contacts; legs on which none of them spends time are left out.

    Attributes
    ----------
    furthest : array of shape (n,)
        Largest |x| of each contact: its threshold lies above.
    """

    def __init__(
        self, rates: RateLaw, stiffness: Stiffness | None, born: Array, legs: Legs
    ) -> None:
        self._rates, self._stiffness = rates, stiffness
        used = np.flatnonzero((legs.duration > 0.0).any(axis=0))
        self._near = born[:, None] + legs.displacement[:, used]
        self._far = born[:, None] + legs.displacement[:, used + 1]
        self._duration, self._speed = legs.duration[:, used], legs.speed[used]
        ends = np.abs(np.concatenate([born[:, None], self._near, self._far], axis=1))
        self.furthest: Array = ends.max(axis=1)
        self._in_proportion: tuple[Array, Array] | None = None
        if rates.separable and stiffness is None:
            # A at one threshold gives A at all others
            log_spent = self.log_spent(np.arange(born.size), self.furthest[:, None])[:, 0]
            self._in_proportion = log_spent, rates.log_rate(0.0, self.furthest, 1.0)

    @classmethod
    def known(cls, rates: RateLaw, furthest: Array, log_spent: Array) -> Replay:
        """A Replay from known largest |x| and ln A at that threshold, shapes (n,); for a separable law."""
        out = cls.__new__(cls)  # there are no legs
        out._rates, out._stiffness = rates, None
        out.furthest = furthest
        out._in_proportion = log_spent, rates.log_rate(0.0, furthest, 1.0)
        return out

    def log_spent(self, row: Rows, threshold: Array) -> Array:
        """ln A of the contacts `row`, shape (n,), at thresholds of shape (n, k); finite."""
        if self._in_proportion is not None:
            log_spent, log_rate = self._in_proportion
            level = self._rates.log_rate(0.0, threshold, 1.0) + (log_spent - log_rate)[row, None]
        else:
            with np.errstate(divide="ignore"):
                level = np.log(self.spent(row, threshold))
        return np.maximum(level, _NOTHING)

    def spent(self, row: Rows, threshold: Array) -> Array:
        """A of the contacts `row`, shape (n,), at thresholds of shape (n, k), which |x| has exceeded at
        most by rounding."""
        stiffness = 1.0 if self._stiffness is None else self._stiffness(threshold)
        spent = np.zeros(threshold.shape)
        for leg, speed in enumerate(self._speed):
            near, far = self._near[row, leg][:, None], self._far[row, leg][:, None]
            first, last = (np.minimum(np.abs(end), threshold) for end in (near, far))
            low, high = np.minimum(first, last), np.maximum(first, last)
            if speed == 0.0:
                mean = self._rates.rate(high, threshold, stiffness)
            else:
                across = near * far < 0.0
                begin = np.where(across, 0.0, low)
                passed, way = self._passed(begin, high, threshold, stiffness), high - begin
                if across.any():
                    passed += across * self._passed(0.0 * low, low, threshold, stiffness)
                    way += across * low
                # this mean hardly suffers from the rounding of the way's ends, unlike the integral
                mean = np.divide(passed, way, out=np.zeros(way.shape), where=way > 0.0)
                if not way.all():
                    mean = np.where(way > 0.0, mean, self._rates.rate(high, threshold, stiffness))
            spent += mean * self._duration[row, leg][:, None]
        return spent

    def _passed(self, low: Array, high: Array, threshold: Array, stiffness: Array | float) -> Array:
        """Integral of h over stretches from low to high; all of one shape."""
        log_passed = self._rates.log_passed(low, high, threshold, stiffness)
        return np.exp(np.minimum(log_passed, LARGEST_EXPONENT))


def rates_of(contacts: Contacts) -> RateLaw:
    """The law by which contacts break below their thresholds."""
    assert contacts.thermal is not None
    return contacts.thermal.rates
