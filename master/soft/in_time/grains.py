"""Growing grains under a spring: each contact keeps its quantile for life (paper, Sec. VI).

Of contacts that pinned together the share e^-(H - H_0) has not reached its threshold yet, H being
the largest hazard of their law at their stretch and age so far (master.lives.grains). With heat they
also break earlier: A, the integral of the rate over time, is kept for many quantiles.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from master.lives.grains import GrainLife, pinned_hazard
from master.lives.warm_grains import GrowingThresholds
from master.soft.in_time.memory import FEW_STARTS, MORE_STARTS, Leg, Memory, Scales, width_of
from origins import Contacts

Array = npt.NDArray[np.float64]

# Longest age of grains, in pinning times: they hardly grow beyond.
LONGEST = 1e7
# Columns of a strand's numbers: largest hazard, hazard at birth, time since pinning, and from there A.
WORST, FIRST, SINCE, SPENT = range(4)
# Quantiles on the coarsest steps; change of ln h over a step; A beyond which no contact holds.
CELLS, CHANGE, GONE = 16, 2.0, 90.0
# Range (in pinning times) and size of the logarithmic grid in the time since pinning, for thresholds.
EARLIEST, LATEST, TIMES = 1e-5, 1e7, 400


class GrainMemory(Memory):
    """Growing grains without heat: keeps the largest hazard, that at birth, and the time since pinning."""

    width, error = 3, 1e-13

    def __init__(self, contacts: Contacts, level: int) -> None:
        grains = contacts.grains
        assert grains is not None and grains.age is not None
        self._grains, self._first = grains, grains.growth.first_pinning_time
        life = GrainLife(contacts, LONGEST * self._first)
        self._start_since, self.reach = life.start_since, life.start_reach
        self.starts = FEW_STARTS + MORE_STARTS * level
        # births change over a length of some 2 narrowest widths of the laws of thresholds
        length = 2.0 * min(width_of(contacts), grains.quick_width)
        # first step of a hold: 0.05 pinning times
        self.scales = Scales(length, 0.05 * self._first)

    def start(self, stretch: Array) -> Array:
        """See Memory."""
        kept = np.zeros((stretch.size, self.width))
        kept[:, SINCE] = self._start_since
        kept[:, FIRST] = pinned_hazard(self._grains, stretch, kept[:, SINCE])
        kept[:, WORST] = kept[:, FIRST]
        return kept

    def fresh(self, stretch: Array, speed: float) -> Array:
        """See Memory; contacts that are stretched faster than their thresholds grow never hold."""
        kept = np.zeros((stretch.size, self.width))
        kept[:, WORST] = self._grains.lost_hazard(speed)
        return kept

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        out = kept.copy()
        out[:, SINCE] += leg.duration
        now = pinned_hazard(self._grains, leg.end, out[:, SINCE])
        out[:, WORST] = np.maximum(out[:, WORST], now)
        return out

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        held = self._held(kept)
        return np.stack([held, stretch * held])

    def _held(self, kept: Array) -> Array:
        return np.exp(kept[:, FIRST] - kept[:, WORST])


class WarmGrainMemory(GrainMemory):
    """Growing grains with heat: keeps also A at the middles of cells of the quantile.

    Both cells and steps are halved with each level; the errors of both are of second order.
    """

    def __init__(self, contacts: Contacts, level: int) -> None:
        super().__init__(contacts, level)
        thermal, cells = contacts.thermal, CELLS * 2**level
        assert thermal is not None
        self._thermal, self._cells = thermal, np.arange(cells)
        self.width = SPENT + cells
        self._hazards = -np.log((self._cells + 0.5) / cells)
        length = min(self.scales.length, CHANGE * thermal.temperature / contacts.mean_threshold)
        rate = thermal.rates.scale
        self.scales = Scales(length, min(self.scales.time, 1.0 / rate), rate)
        self._thresholds = GrowingThresholds(self._grains, LONGEST * self._first)
        # thresholds of fresh contacts as functions of the logarithm of the time since pinning
        times = np.linspace(np.log(EARLIEST), np.log(LATEST), TIMES * 2**level)
        since = self._first * np.exp(times)[:, None]
        self._fresh = make_interp_spline(times, self._thresholds.at(self._hazards, since), k=1)

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        out = super().advance(kept, leg)
        if not leg.duration:
            return out
        since = kept[:, SINCE] + 0.5 * leg.duration
        middle = np.abs(0.5 * (leg.begin + leg.end))[:, None]
        log_since, fresh = np.log(since / self._first), kept[:, FIRST] == 0.0
        early, late = np.log(EARLIEST), np.log(LATEST)
        limit = self._fresh(np.clip(log_since, early, late))
        # right after pinning, thresholds are proportional to the time
        limit *= np.exp(np.minimum(log_since - early, 0.0))[:, None]
        own = kept[~fresh, FIRST, None] + self._hazards
        limit[~fresh] = self._thresholds.at(own, since[~fresh, None])
        spent = leg.duration * self._thermal.plain_rate(np.minimum(middle, limit), limit)
        out[:, SPENT:] = np.minimum(out[:, SPENT:] + spent, GONE)
        return out

    def _held(self, kept: Array) -> Array:
        met = np.exp(kept[:, FIRST] - kept[:, WORST])[:, None]
        still = np.clip(met * self._cells.size - self._cells, 0.0, 1.0)
        return np.asarray((still * np.exp(-kept[:, SPENT:])).sum(axis=1) / self._cells.size)
