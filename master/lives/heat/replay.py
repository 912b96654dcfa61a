"""A(x_s): the breaking rate of contacts, integrated over all their moves."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.motion.motion import Legs
from origins import Contacts
from origins.laws.rate_law import LARGEST_EXPONENT, RateLaw

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# ln A in place of -inf, where A = 0 or underflows.
_NOTHING = -740.0


class Replay:
    """The rate of n contacts, integrated leg by leg: the mean rate on each leg times the time there.

    Parameters
    ----------
    contacts : Contacts
        With thermal, of whose rates A is the integral.
    born : array of shape (n,)
        Stretch of each contact at its birth.
    legs : Legs
        Of the n contacts.

    Attributes
    ----------
    furthest : array of shape (n,)
        Largest |x| of each contact: its threshold lies above.
    """

    def __init__(self, contacts: Contacts, born: Array, legs: Legs) -> None:
        self._rates, self._stiffness = rates_of(contacts), contacts.relative_stiffness
        self._stretch = born[:, None] + legs.displacement
        self._duration = legs.duration
        self.furthest: Array = np.abs(self._stretch).max(axis=1)
        self._offset: Array | None = None
        if self._rates.separable and contacts.stiffness != "linked":
            # A at one threshold gives A at all others
            furthest, every = self.furthest[:, None], np.arange(born.size)
            log_rate = self._rates.log_rate(0.0, furthest, 1.0)
            self._offset = self.log_spent(every, furthest) - log_rate

    def log_spent(self, row: Rows, threshold: Array) -> Array:
        """ln A of the contacts `row`, shape (n,), at thresholds of shape (n, k); finite."""
        if self._offset is not None:
            level = self._rates.log_rate(0.0, threshold, 1.0) + self._offset[row]
        else:
            with np.errstate(divide="ignore"):
                level = np.log(self.spent(row, threshold))
        return np.maximum(level, _NOTHING)

    def spent(self, row: Rows, threshold: Array) -> Array:
        """A of the contacts `row`, shape (n,), at thresholds of shape (n, k), which |x| has exceeded at
        most by rounding."""
        spent = np.zeros(threshold.shape)
        for leg in range(self._duration.shape[1]):
            some = np.flatnonzero(self._duration[row, leg] > 0.0)
            if some.size:
                own = row[some]
                ends = self._stretch[own, leg : leg + 2, None]
                mean = self._mean_rate(ends[:, 0], ends[:, 1], threshold[some])
                spent[some] += mean * self._duration[own, leg, None]
        return spent

    def _mean_rate(self, near: Array, far: Array, threshold: Array) -> Array:
        """Mean of h over straight moves, at thresholds of shape (n, k); ends of shape (n, 1)."""
        stiffness, across = self._stiffness(threshold), near * far < 0.0
        first, last = (np.minimum(np.abs(end), threshold) for end in (near, far))
        low, high = np.minimum(first, last), np.maximum(first, last)
        begin = np.where(across, 0.0, low)
        passed, way = self._passed(begin, high, threshold, stiffness), high - begin
        if across.any():
            passed += across * self._passed(0.0 * low, low, threshold, stiffness)
            way += across * low
        # this mean hardly suffers from the rounding of the way's ends, unlike the integral
        mean = np.divide(passed, way, out=np.zeros(way.shape), where=way > 0.0)
        if not way.all():
            mean = np.where(way > 0.0, mean, self._rates.rate(high, threshold, stiffness))
        return mean

    def _passed(self, low: Array, high: Array, threshold: Array, stiffness: Array) -> Array:
        """Integral of h over stretches from low to high; all of one shape."""
        log_passed = self._rates.log_passed(low, high, threshold, stiffness)
        return np.exp(np.minimum(log_passed, LARGEST_EXPONENT))


def rates_of(contacts: Contacts) -> RateLaw:
    """The law by which contacts break below their thresholds."""
    assert contacts.thermal is not None
    return contacts.thermal.rates
