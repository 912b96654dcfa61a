"""Growing grains under a spring: each contact keeps its quantile for life (paper, Sec. VI).

Of contacts that pinned together the share e^-(H - H_0) has not reached its threshold yet, H being
the largest hazard of their law at their stretch and age so far (master.lives.grains). With heat they
also break earlier, see Memory: here the cells are those of the quantile.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from master.lives.grains import GrainLife, grown_threshold, pinned_hazard
from master.soft.in_time.memory import Leg, Memory
from origins import Contacts

Array = npt.NDArray[np.float64]

# Longest age of grains, in pinning times: they hardly grow beyond.
LONGEST = 1e7
# Columns of a strand's numbers: largest hazard, hazard at birth, time since pinning, and from there A.
WORST, FIRST, SINCE, SPENT = range(4)
# Range (in pinning times) and size of the logarithmic grid in the time since pinning, for thresholds.
EARLIEST, LATEST, TIMES = 1e-5, 1e7, 400


class GrainMemory(Memory):
    """Keeps the largest hazard, that at birth, the time since pinning, and with heat A."""

    error, own = 1e-13, SPENT

    def __init__(self, contacts: Contacts, level: int) -> None:
        """Choose the moments at which grains pin in the start, and how far births are apart."""
        super().__init__(contacts, level)
        grains = contacts.grains
        assert grains is not None and grains.age is not None
        self._grains, self._first = grains, grains.growth.first_pinning_time
        life = GrainLife(contacts, LONGEST * self._first)
        self._start_since, self.reach = life.start_since, life.birth_reach
        self.starts = 24 + 8 * level
        # births change over a length of some 2 narrowest widths of the laws of thresholds; the first
        # step of a hold is 0.05 pinning times
        length, time = 2.0 * min(self.scales.length, grains.quick_width), 0.05 * self._first
        self.scales = self.scales._replace(length=length, time=min(time, self.scales.time))
        # places of the edges are roots of hazards, as small thresholds are proportional to these;
        # quantiles of 3e-14 end them
        self._set_cells(np.linspace(0.0, 5.6, 48 * 2 ** (level // 2) + 1))
        self._hazards = self._edges**2
        self._beyond = np.exp(-self._hazards)
        if contacts.thermal is not None:
            # the rate by which fresh contacts break is that of contacts without thresholds
            self.scales = self.scales._replace(rate=contacts.thermal.rates.scale, thin=False)
            # thresholds of fresh contacts as functions of the logarithm of the time since pinning
            times = np.linspace(np.log(EARLIEST), np.log(LATEST), TIMES * 2**level)
            since = self._first * np.exp(times)[:, None]
            self._fresh = make_interp_spline(
                times, grown_threshold(grains, self._hazards, since), k=1
            )

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
        """See Memory; the rate is that of thresholds in the middle of the move."""
        out = kept.copy()
        out[:, SINCE] += leg.duration
        now = pinned_hazard(self._grains, leg.end, out[:, SINCE])
        out[:, WORST] = np.maximum(out[:, WORST], now)
        if self._hot and leg.duration:
            since = kept[:, SINCE] + 0.5 * leg.duration
            log_since, fresh = np.log(since / self._first), kept[:, FIRST] == 0.0
            early, late = np.log(EARLIEST), np.log(LATEST)
            limit = self._fresh(np.clip(log_since, early, late))
            # right after pinning, thresholds are proportional to the time
            limit *= np.exp(np.minimum(log_since - early, 0.0))[:, None]
            own = kept[~fresh, FIRST, None] + self._hazards
            limit[~fresh] = grown_threshold(self._grains, own, since[~fresh, None])
            moved = np.maximum(np.abs(leg.begin), np.abs(leg.end))
            out[:, SPENT:] += self._spent(leg._replace(furthest=moved), limit)
        return out

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        passed = np.maximum(kept[:, WORST] - kept[:, FIRST], 0.0)
        return self._summed(kept[:, SPENT:], stretch, np.sqrt(passed), np.exp(-passed))
