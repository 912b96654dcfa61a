"""The integrated rate: A, the integral over time of the rate at which heat breaks a contact, over any motion."""

import numpy as np

from master.motion import Legs
from master.numerics.polynomials import Rows
from master.survival.life import SMALLEST
from origins import Contacts
from origins.laws.rate_law import LARGEST_EXPONENT
from origins.thresholds.law import Array

# ln A where A is 0 or underflows.
LEAST_LOG = -740.0
# Rates evaluated together, as many as stay in the processor's cache.
TOGETHER = 4096


def has_relaxed_time(contacts: Contacts) -> bool:
    """Whether one time at x = 0 gives a contact the A of its history, at each threshold that it has not met: where the
    rate of heat is separable. By a rate that is 0 at x = 0 no time there gives what has passed elsewhere."""
    if contacts.thermal is None or contacts.stiffness == "linked":
        return False
    rates = contacts.thermal.rates
    rate_at_0 = rates.log_rate(0.0, contacts.mean_threshold, 1.0)
    return bool(rates.separable and np.isfinite(rate_at_0))


class IntegratedRate:
    """A, the rate of n contacts integrated over time, for contacts born at stretches of shape (n,): leg by leg, the
    mean rate times the duration.

    furthest : the largest |x| of each contact, shape (n,), below its threshold
    """

    def __init__(self, contacts: Contacts, born: Array, legs: Legs) -> None:
        assert contacts.thermal is not None
        self._rates = contacts.thermal.rates
        self._stiffness = contacts.relative_stiffness
        self._stretch = born[:, None] + legs.displacement
        self._duration = legs.duration
        self.furthest: Array = np.abs(self._stretch).max(axis=1)
        self._log_relaxed_time: Array | None = None  # where the rate is separable
        if has_relaxed_time(contacts):
            self._log_relaxed_time = self._log_relaxed_times(born)

    @property
    def log_relaxed_time(self) -> Array | None:
        """Logarithm of the time at x = 0 that gives each contact the same A, whatever its threshold, shape (n, 1); None
        where rates are not separable."""
        return self._log_relaxed_time

    def _log_relaxed_times(self, born: Array) -> Array:
        """Logarithm of the relaxed time of each contact, shape (n, 1): the time at x = 0 that gives it the same A.

        For a rate h = f(x) g(x_s) the relaxed time is the integral of f(x)/f(0) over time, the same for all thresholds:
        one of them gives A at every other. Contacts born together, neighbours here, move together on all legs but the
        last, so that the relaxed time of these legs is computed once for each birth.
        """
        if self._duration.shape[1] == 1:
            return self._log_relaxed_time_on(np.arange(born.size), np.ones(1))
        births = np.stack([born, self._duration[:, :-1].sum(axis=1)])  # stretch, and time since
        is_first = np.append(True, (births[:, 1:] != births[:, :-1]).any(axis=0))[: born.size]
        birth_of_each = np.cumsum(is_first) - 1
        on_last = np.zeros(self._duration.shape[1])
        on_last[-1] = 1.0
        of_births = self._log_relaxed_time_on(np.flatnonzero(is_first), 1.0 - on_last)
        of_last = self._log_relaxed_time_on(np.arange(born.size), on_last)
        return np.logaddexp(of_births[birth_of_each], of_last)

    def _log_relaxed_time_on(self, contact: Rows, on: Array) -> Array:
        """Logarithm of the relaxed time of these contacts, shape (n, 1), on the legs where `on` is 1 and not 0."""
        is_end = np.maximum(np.append(on, 0.0), np.append(0.0, on))  # of a leg that counts
        ends = np.abs(self._stretch[contact]) * is_end
        # the least threshold that the contact has not met there; any other gives the same
        threshold = ends.max(axis=1, keepdims=True, initial=SMALLEST)
        rate_at_0 = self._rates.log_rate(0.0, threshold, 1.0)
        return self.log(contact, threshold, on) - rate_at_0

    def log(self, contact: Rows, threshold: Array, on: Array | float = 1.0) -> Array:
        """ln A of the contacts, shape (n,), on all legs or those where `on` is 1, at thresholds of shape (n, k), which
        |x| has exceeded there at most by rounding; finite."""
        if self._log_relaxed_time is not None:
            rate_at_0 = self._rates.log_rate(0.0, threshold, 1.0)
            return np.maximum(rate_at_0 + self._log_relaxed_time[contact], LEAST_LOG)
        return np.log(np.maximum(self._summed(contact, threshold, on), np.exp(LEAST_LOG)))

    def on_one_leg(self, threshold: Array) -> Array:
        """A of all contacts where there is one leg, at thresholds of shape (n, k), as in `log`: no leg is looked for,
        and no logarithm is taken."""
        contact = np.arange(threshold.shape[0])
        if self._log_relaxed_time is not None:
            return np.asarray(np.exp(self.log(contact, threshold)))
        together = max(TOGETHER // max(threshold.shape[1], 1), 1)
        total = np.empty(threshold.shape)
        for begin in range(0, contact.size, together):
            some = slice(begin, begin + together)
            ends = self._stretch[some, :1], self._stretch[some, 1:]
            total[some] = self._mean_rate(*ends, threshold[some]) * self._duration[some]
        return total

    def _summed(self, contact: Rows, threshold: Array, on: Array | float) -> Array:
        """A, as in `log`, leg by leg."""
        total = np.zeros(threshold.shape)
        row, leg = np.nonzero(self._duration[contact] * on)
        together = max(TOGETHER // max(threshold.shape[1], 1), 1)
        for begin in range(0, row.size, together):
            some = row[begin : begin + together]
            which = leg[begin : begin + together, None]
            own = contact[some, None]
            ends = self._stretch[own, which], self._stretch[own, which + 1]
            on_leg = self._mean_rate(*ends, threshold[some]) * self._duration[own, which]
            first = np.flatnonzero(np.append(True, some[1:] != some[:-1]))
            total[some[first]] += np.add.reduceat(on_leg, first, axis=0)
        return total

    def _mean_rate(self, begin: Array, end: Array, threshold: Array) -> Array:
        """Mean of h over straight moves, at thresholds of shape (n, k); ends of shape (n, 1)."""
        stiffness = self._stiffness(threshold)
        first = np.minimum(np.abs(begin), threshold)
        last = np.minimum(np.abs(end), threshold)
        low = np.minimum(first, last)
        high = np.maximum(first, last)
        crosses_0 = begin * end < 0.0
        from_0 = np.where(crosses_0, 0.0, low)
        integral = self._integral(from_0, high, threshold, stiffness)
        distance = high - from_0
        if crosses_0.any():  # |x| falls to 0 and rises again
            some = np.flatnonzero(crosses_0)
            to_0 = low[some]
            distance[some] = to_0 + high[some]
            integral[some] += self._integral(0.0 * to_0, to_0, threshold[some], stiffness[some])
        # rounding of the ends hardly matters for this mean, unlike for the integral
        mean = integral if distance.all() else self._rates.rate(high, threshold, stiffness)
        return np.divide(integral, distance, out=mean, where=distance > 0.0)

    def _integral(self, low: Array, high: Array, threshold: Array, stiffness: Array) -> Array:
        """Integral of h over stretches from low to high; all of one shape."""
        log_integral = self._rates.log_passed(low, high, threshold, stiffness)
        return np.exp(np.minimum(log_integral, LARGEST_EXPONENT))
