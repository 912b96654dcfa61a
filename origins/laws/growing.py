"""Thresholds that grow with the age of their contact, each keeping its quantile for life: what solvers ask of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from origins.laws.timed_law import EXACT, MEAN_RATE, ChangingThresholds
from origins.thresholds.law import Array, Thresholds


class GrowingThresholds(ChangingThresholds, ABC):
    """Contacts whose thresholds grow with their age; each keeps its quantile in the law of thresholds for life.

    A contact's quantile is told by its hazard η = -ln of the share of contacts whose thresholds are larger. η is
    exponentially distributed with mean 1, and the contact breaks where hazard_at(|x|, age) first reaches it. Contacts
    that are born relaxed together hold with the probability exp(-max hazard_at), and with one more at X = 0 of contacts
    that are stretched then, exp(hazard_at(|x_ini|, start_pinned_for) - max hazard_at).

    Ages count from the instant at which a contact first holds, here "since pinning"; it is out for
    `first_pinning_time` before. While |x| changes at one speed, the hazard at the contact's stretch first falls and
    then rises, or only one of the two, so that the largest is that at one end of the leg.

    age : of all contacts at X = 0, since their last break, a time; None: not given, which origins.Contacts refuses
    interface : the rough surface behind them, or None
    time_unit : a time, over which fresh thresholds grow
    begins_at_0 : whether all thresholds are 0 as contacts pin
    quick_width : a length over which breaks of contacts just pinned change, inf where the law at X = 0 says it
    bends : sorted finite hazards above 0 at which thresholds are no smooth function of the hazard; thresholds there, at
        an age, are threshold_at(bends, age)
    """

    age: float | None
    interface: Any = None
    time_unit: float
    quick_width: float = np.inf
    begins_at_0 = False
    bends: Array = np.empty(0)

    @property
    @abstractmethod
    def at_start(self) -> Thresholds:
        """P_c of all contacts at X = 0, of the age `age`. InputError where that is not given."""

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw."""
        averages = 'thermal: closure = "paper" averages over one P_c, and each age has another'
        of_their_own = "ageing: thresholds that grow with their age do age, by a law of their own"
        return {MEAN_RATE: f"{averages}; {EXACT}", "ageing": f"{of_their_own}; leave one out"}

    def __str__(self) -> str:
        """The law in words."""
        return f"thresholds that grow from the age {self.age:.4g} on"

    @property
    def start_pinned_for(self) -> float:
        """Age since pinning of all contacts at X = 0, a time."""
        assert self.age is not None  # origins.Contacts has asked at_start, which refuses that
        return self.age - self.first_pinning_time

    @abstractmethod
    def hazard_at(self, x: Array | float, pinned_for: Array | float) -> Array:
        """-ln of the share of contacts of this age since pinning (times) whose thresholds exceed |x| (lengths); shapes
        broadcast. inf where none exceeds it."""

    @abstractmethod
    def threshold_at(self, hazard: Array | float, pinned_for: Array | float) -> Array:
        """Threshold (a length) of the contact with this hazard >= 0 at this age since pinning, the inverse of
        hazard_at; shapes broadcast. At an infinite hazard it is the largest, which may be inf."""

    def lost_hazard(self, velocity: float) -> float:
        """Hazard that contacts pass as they pin, if stretched at this speed: those below it never hold."""
        return 0.0

    @abstractmethod
    def check_speed(self, velocity: float) -> None:
        """InputError for steady speeds at which thresholds cannot be followed, or at which contacts never break."""
