"""A(x_s): the breaking rate of contacts, integrated over all their moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.motion.motion import Legs
from origins.laws.rate_law import LARGEST_EXPONENT, RateLaw

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# ln A in place of -inf, where A = 0 or underflows.
_NOTHING = -740.0
# A move's share of the integral from 0 below which a difference of integrals would lose 3 digits.
_SHORT = 1e-3


class Replay:
    """The rate of n contacts, integrated leg by leg: closed integrals on moves, h times the time in holds.

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
    least : array of shape (n,)
        Largest |x| of each contact: its threshold lies above.
    """

    def __init__(
        self,
        rates: RateLaw,
        stiffness: Callable[[Array], Array] | None,
        born: Array,
        legs: Legs,
    ) -> None:
        self._rates, self._stiffness = rates, stiffness
        used = np.flatnonzero((legs.duration > 0.0).any(axis=0))
        self._near = born[:, None] + legs.displacement[:, used]
        self._far = born[:, None] + legs.displacement[:, used + 1]
        self._duration, self._speed = legs.duration[:, used], legs.speed[used]
        # on the leg of birth speed times time is more accurate than the difference of two positions
        first = legs.displacement[:, used] == 0.0
        since = born[:, None] + self._speed * self._duration
        self._far = np.where(first & (self._speed != 0.0), since, self._far)
        self._joined = np.append(False, np.diff(used) == 1)
        ends = np.abs(np.concatenate([born[:, None], self._near, self._far], axis=1))
        self.least: Array = ends.max(axis=1)
        self._in_proportion: tuple[Array, Array] | None = None
        if rates.separable and stiffness is None:
            # A at one threshold gives A at all others
            with np.errstate(divide="ignore"):
                log_spent = np.log(self.spent(np.arange(born.size), self.least[:, None])[:, 0])
            log_rate = rates.log_rate(0.0, self.least, 1.0)
            self._in_proportion = np.maximum(log_spent, _NOTHING), log_rate

    @classmethod
    def known(cls, rates: RateLaw, least: Array, log_spent: Array) -> Replay:
        """A Replay from known largest |x| and ln A at that threshold, shapes (n,); for a separable law."""
        out = cls.__new__(cls)  # there are no legs
        out._rates, out._stiffness = rates, None
        out.least = least
        out._in_proportion = log_spent, rates.log_rate(0.0, least, 1.0)
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

    def spent_at(self, threshold: float) -> Array:
        """A of all contacts at one threshold, which |x| has exceeded at most by rounding; shape (n,)."""
        near, far = self._near, self._far
        self._near, self._far = (np.clip(part, -threshold, threshold) for part in (near, far))
        every = np.arange(self.least.size)
        spent = self.spent(every, np.full((every.size, 1), threshold))[:, 0]
        self._near, self._far = near, far
        return spent

    def spent(self, row: Rows, threshold: Array) -> Array:
        """A of the contacts `row`, shape (n,), at thresholds of shape (n, k)."""
        stiffness = 1.0 if self._stiffness is None else self._stiffness(threshold)
        spent = np.zeros(threshold.shape)
        passed: Array | None = None
        for leg, speed in enumerate(self._speed):
            near = self._near[row, leg][:, None]
            if speed == 0.0:
                duration = self._duration[row, leg][:, None]
                spent += self._rates.rate(np.abs(near), threshold, stiffness) * duration
                passed = None
                continue
            if passed is None or not self._joined[leg]:
                passed = self._passed(near, threshold, stiffness)
            far = self._far[row, leg][:, None]
            before, passed = passed, self._passed(far, threshold, stiffness)
            gone = np.abs(passed - before)
            short = gone < _SHORT * np.abs(passed)
            if short.any():
                way = np.abs(speed) * self._duration[row, leg][:, None]
                arrays = np.broadcast_arrays(near, far, way, threshold, stiffness)
                gone[short] = self._short_way(*(array[short] for array in arrays))
            spent += gone / np.abs(speed)
        return spent

    def _passed(self, x: Array, threshold: Array, stiffness: Array | float) -> Array:
        """Integral of h from 0 to x; x of shape (n, 1)."""
        if not x.any():
            return np.zeros(threshold.shape)
        far = np.minimum(np.abs(x), threshold)
        log_passed = self._rates.log_passed(0.0, far, threshold, stiffness)
        return np.sign(x) * np.exp(np.minimum(log_passed, LARGEST_EXPONENT))

    def _short_way(
        self, near: Array, far: Array, way: Array, threshold: Array, stiffness: Array
    ) -> Array:
        """The integral of h over a way much shorter than the stretch; all of shape (n,).

        `way` is its length, more accurate than the difference of the rounded ends.
        """
        near, far = np.minimum(np.abs(near), threshold), np.minimum(np.abs(far), threshold)
        near, far = np.minimum(near, far), np.maximum(near, far)
        apart = far - near
        at_rest = apart == 0.0
        log_passed = self._rates.log_passed(near, far, threshold, stiffness)
        mean_rate = np.exp(log_passed) / np.where(at_rest, 1.0, apart)
        if at_rest.any():
            some = near[at_rest], threshold[at_rest], stiffness[at_rest]
            mean_rate[at_rest] = self._rates.rate(*some)
        return mean_rate * way
