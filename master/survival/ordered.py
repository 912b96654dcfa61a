"""Contacts whose thresholds change with age and distance and keep their order, by a law of one's own.

Of the contacts that were born together those are broken whose thresholds at birth are up to the largest that
birth_threshold(|x|, age, travelled) has been since: E = S(that)/S(|r|). On a leg of one speed it is largest at an end,
or between, where |x| and the law go different ways: there it is looked for.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from master.motion import History, Motion
from master.survival.changing import ChangingLife
from master.survival.life import Survivors
from origins import Contacts
from origins.laws.ordered import OrderedThresholds, Trend
from origins.thresholds.law import Array

# Places on a leg between which the largest value is looked for, and golden sections of the interval that has it: a
# place known to 1e-8 of the leg gives the value, which is flat there, to rounding.
PLACES, SECTIONS, GOLDEN = np.linspace(0.0, 1.0, 9)[:, None], 36, 0.5 * (5.0**0.5 - 1.0)


class OrderedLife(ChangingLife):
    """Life (see master.survival.life) of contacts with OrderedThresholds."""

    trend: Trend

    @classmethod
    def made(cls, contacts: Contacts, tolerance: float, motion: Motion, until: float) -> Self:
        """See ChangingLife."""
        life = cls(contacts, float(motion.times[-1]))
        furthest = float(np.abs(np.diff(motion.positions)).sum())
        life.trend = life._law.trend(float(motion.times[-1]), furthest)
        life.check_survivors(motion)
        return life

    @property
    def _law(self) -> OrderedThresholds:
        law = self.contacts.changing
        assert isinstance(law, OrderedThresholds)
        return law

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        displacement, duration, speed = history.legs()
        x = born[:, None] + displacement
        age = np.cumsum(np.insert(duration, 0, 0.0, axis=1), axis=1)
        travelled = np.cumsum(np.insert(np.abs(np.diff(x)), 0, 0.0, axis=1), axis=1)
        with np.errstate(over="ignore"):  # inf where none holds
            worst = self._law.birth_threshold(np.abs(x), age, travelled).max(axis=1)
            at_0 = np.divide(-x[:, :-1], speed, out=np.zeros_like(duration), where=speed != 0.0)
            at_0 = np.clip(at_0, 0.0, duration)  # the time on a leg at which x = 0
            moves = speed != 0.0
            trend = self.trend
            inward = trend.weakens_with_age or trend.weakens_with_travel
            outward = trend.strengthens_with_age or trend.strengthens_with_travel
            for first, last, is_sought in (
                (np.zeros_like(at_0), at_0, inward),
                (at_0, duration, outward),
            ):
                rows, legs = np.nonzero((last > first) & moves & is_sought)
                if rows.size:
                    begins = x[rows, legs], speed[legs], age[rows, legs], travelled[rows, legs]
                    found = self._largest(*begins, first[rows, legs], last[rows, legs])
                    np.maximum.at(worst, rows, found)
        thresholds = self._law.at_start
        survival = thresholds.sf(worst) / thresholds.sf(np.abs(born))
        return Survivors(survival, survival * x[:, -1], self.error)

    def _largest(
        self, x: Array, speed: Array, age: Array, travelled: Array, first: Array, last: Array
    ) -> Array:
        """The largest birth_threshold of contacts between two times on a leg that begins with these; all (n,)."""

        def value(time: Array) -> Array:
            stretch, distance = np.abs(x + speed * time), travelled + np.abs(speed) * time
            found: Array = self._law.birth_threshold(stretch, age + time, distance)
            return found

        values = value(first + (last - first) * PLACES)
        best, largest = values.argmax(axis=0), values.max(axis=0)
        low = first + (last - first) * PLACES[np.maximum(best - 1, 0), 0]
        high = first + (last - first) * PLACES[np.minimum(best + 1, PLACES.size - 1), 0]
        for _ in range(SECTIONS):
            left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            at_left, at_right = value(left), value(right)
            rises = at_left < at_right
            low, high = np.where(rises, left, low), np.where(rises, high, right)
            largest = np.maximum(largest, np.maximum(at_left, at_right))
        return largest
