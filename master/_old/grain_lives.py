"""Cohorts of contacts whose thresholds grow with their age, on any motion: coalescing grains (paper, Sec. VI).

Each contact keeps its quantile for life, so that of those that pinned together the fraction exp(-H) still holds, H the
most that the hazard of their law was at their stretch and age so far: one number for each cohort.
"""

from __future__ import annotations

from copy import copy
from typing import Self

import numpy as np
import numpy.typing as npt

from master._old.diffusion_passage import narrowest
from master._old.lives import halves
from origins import Contacts

Array = npt.NDArray[np.float64]

_GONE = 45.0
_STEPS = 2.0  # narrowest widths, the length over which births change
_LEAST = 0.05
_SHORT = 0.05  # of tau_m, the first step of a hold


class GrainLives:
    """`Lives` of such contacts.

    start : pair of arrays (n,)
        Stretches of the contacts that hold at X = 0 (lengths), and weights of sum 1.
    age : float
        Theirs.
    """

    rate, error, fuzzy, skin, work = 0.0, 1e-15, False, 0.0, 20

    def __init__(self, contacts: Contacts, start: tuple[Array, Array], age: float) -> None:
        grains = contacts.grains
        assert grains is not None
        self._grains, self._first = grains, grains.growth.first_pinning_time
        # as fast as that, few hold and at small stretches
        quick = grains.breaking(1.0 / (np.sqrt(grains.growth.B) * self._first))
        self.length, self.time = _STEPS * min(narrowest(contacts.thresholds), narrowest(quick)), _SHORT * self._first
        self._age, self._at, self._clock, self._velocity = age, 0.0, 0.0, 0.0
        self._start, self._share = start
        self._begun = np.asarray(grains.hazard(np.abs(self._start), age))
        self._most = self._begun
        # where, when and after how much hazard those born since still hold
        self._place, self._born, self._worst = np.empty(0), np.empty(0), np.empty(0)

    @property
    def held(self) -> Array:
        left = float((self._share * np.exp(self._begun - self._most)).sum())
        return np.append(left, np.exp(-self._worst))

    @property
    def pull(self) -> Array:
        left = float((self._share * np.exp(self._begun - self._most) * (self._start + self._at)).sum())
        return np.append(left, np.exp(-self._worst) * (self._at - self._place))

    def born(self) -> None:
        self._place, self._born = np.append(self._place, self._at), np.append(self._born, self._clock)
        # some are stretched faster than their thresholds grow, and never hold
        self._worst = np.append(self._worst, self._grains.lost_hazard(self._velocity))

    def advance(self, travel: float, duration: float, bend: float = 0.0) -> None:
        self._at, self._clock = self._at + travel, self._clock + duration
        # at the end of the step, where the next are born
        self._velocity = abs(travel) / (duration * max(1.0 + bend, _LEAST)) if duration > 0.0 else np.inf
        now = self._grains.hazard(np.abs(self._start + self._at), self._age + self._clock)
        self._most = np.maximum(self._most, now)
        alive = np.flatnonzero(self._worst < _GONE)
        stretch, since = np.abs(self._at - self._place[alive]), self._clock - self._born[alive]
        worst = self._worst.copy()
        worst[alive] = np.maximum(worst[alive], self._grains.hazard(stretch, self._first + since))
        self._worst = worst

    def spread(self) -> tuple[Array, Array]:
        return halves(self.held), halves(self.pull)

    def copy(self) -> Self:
        # arrays are replaced, never written to
        return copy(self)
