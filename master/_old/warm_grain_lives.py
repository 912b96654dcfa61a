"""Cohorts of contacts whose thresholds grow with their age, at a temperature, on any motion.

Each contact keeps its quantile. Of those that pinned together and of one quantile e^-A still hold, A the integral of
the rate over time, its threshold being the present one: one number for each of many quantiles of each cohort.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master._old.grain_lives import GrainLives
from origins import Contacts

Array = npt.NDArray[np.float64]

_CELLS, _TIMES = 16, 400  # on the coarsest steps
_SHORTEST, _LONGEST = 1e-5, 1e7  # of tau_m: earlier thresholds rise as the time, later ones hardly
_GONE = 45.0
_WIDTH = 2.0  # k_BT/<k x>, over which rates change


class WarmGrainLives(GrainLives):
    """`Lives` of such contacts, `level` as make_lives has it: quantiles and steps become finer together, and what
    either leaves falls as the square."""

    def __init__(self, contacts: Contacts, start: tuple[Array, Array], age: float, level: int) -> None:
        super().__init__(contacts, start, age)
        thermal, cells = contacts.thermal, _CELLS * 2**level
        assert thermal is not None
        self._thermal, self._cells = thermal, np.arange(cells)
        self._hazards = -np.log((self._cells + 0.5) / cells)
        self.length = min(self.length, _WIDTH * thermal.temperature / contacts.mean_threshold)
        self.time, self.rate = min(self.time, 1.0 / thermal.attempt_frequency), thermal.attempt_frequency
        self.work = 4 * cells
        self._times = np.linspace(np.log(_SHORTEST), np.log(_LONGEST), _TIMES * 2**level)
        ages = self._first * (1.0 + np.exp(self._times))
        self._table = self._thresholds(self._hazards, ages[:, None])
        self._own = self._begun[:, None] + self._hazards
        self._spent, self._cost = np.zeros(self._own.shape), np.zeros((0, cells))

    def _thresholds(self, hazard: Array, age: Array) -> Array:
        return np.asarray(self._grains.quantile(-np.expm1(-hazard), age))

    def _kept(self, worst: Array, spent: Array) -> Array:
        """Share of contacts whose quantiles are not met yet and that did not break before."""
        open_ = np.clip(np.exp(-worst)[:, None] * self._cells.size - self._cells, 0.0, 1.0)
        return np.asarray((open_ * np.exp(-spent)).sum(axis=1) / self._cells.size)

    @property
    def held(self) -> Array:
        left = float(self._share @ self._kept(self._most - self._begun, self._spent))
        return np.append(left, self._kept(self._worst, self._cost))

    @property
    def pull(self) -> Array:
        left = self._share @ (self._kept(self._most - self._begun, self._spent) * (self._start + self._at))
        return np.append(float(left), self._kept(self._worst, self._cost) * (self._at - self._place))

    def born(self) -> None:
        super().born()
        self._cost = np.append(self._cost, np.zeros((1, self._cells.size)), axis=0)

    def advance(self, travel: float, duration: float, bend: float = 0.0) -> None:
        super().advance(travel, duration, bend)
        if duration == 0.0:
            return
        at, clock = self._at - 0.5 * travel, self._clock - 0.5 * duration
        alive = np.flatnonzero((self._worst < _GONE) & (self._cost[:, 0] < _GONE))
        since = np.log(np.maximum((clock - self._born[alive]) / self._first, 1e-300))
        place = np.clip((since - self._times[0]) / (self._times[1] - self._times[0]), 0.0, self._times.size - 1.001)
        row = place.astype(int)
        part = (place - row)[:, None]
        limit = (1.0 - part) * self._table[row] + part * self._table[row + 1]
        limit *= np.exp(np.minimum(since - self._times[0], 0.0))[:, None]
        cost = self._cost.copy()
        cost[alive] += duration * self._rate(at - self._place[alive], limit)
        self._cost = np.minimum(cost, 2.0 * _GONE)
        limit = self._thresholds(self._own, np.asarray(self._age + clock))
        self._spent = np.minimum(self._spent + duration * self._rate(self._start + at, limit), 2.0 * _GONE)

    def _rate(self, stretch: Array, limit: Array) -> Array:
        return self._thermal.plain_rate(np.minimum(np.abs(stretch)[:, None], limit), limit)
