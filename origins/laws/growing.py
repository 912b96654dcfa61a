"""Thresholds that grow with the age of their contact, each keeping its quantile for life: what solvers ask of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from origins.errors import refuse
from origins.laws.timed_law import EXACT, LINKED, MEAN_RATE, ChangingThresholds
from origins.thresholds.law import Array

# Relative error of hazards, and change of one beside 1, that may be rounding in a law of one's own.
INVERSE, ROUGHNESS = 1e-6, 1e-9
# Of times, in time_unit, over which thresholds may be followed.
LONGEST = 1e100
# The strongest contacts whose breaks are asked for: a larger share than this of all holds at no age that is followed.
STRONGEST = 1e-17
# Ages, and times along a leg, in time_unit, at which hazards are looked at.
AGES, LATER = np.geomspace(1e-3, 1e3, 7), np.geomspace(1e-3, 1e4, 36)


class GrowingThresholds(ChangingThresholds):
    """Contacts whose thresholds grow with their age; each keeps its quantile in the law of thresholds for life.

    A contact's quantile is told by its hazard η = -ln of the share of contacts whose thresholds are larger. η is
    exponentially distributed with mean 1, and the contact breaks where hazard_at(|x|, age) first reaches it. Contacts
    that are born relaxed together hold with the probability exp(-max hazard_at), and with one more at X = 0 of contacts
    that are stretched then, exp(hazard_at(|x_ini|, start_pinned_for) - max hazard_at).

    Ages count from the instant at which a contact first holds, here "since pinning"; it is out for
    `first_pinning_time` before. While |x| changes at one speed, the hazard at the contact's stretch first falls and
    then rises, or only one of the two, so that the largest is that at one end of the leg.

    A law states at_start, time_unit, hazard_at and threshold_at, and what of the following is other than here:

    law : its name in Contacts.laws and in messages
    at_start : P_c of all contacts at X = 0, of the age `age`
    time_unit : a time, over which fresh thresholds grow
    age : of all contacts at X = 0, since their last break, a time; None: not given, which origins.Contacts refuses
    interface : the rough surface behind them, or None
    grows : False where thresholds stay as they are after all, so that the law counts as absent
    begins_at_0 : whether all thresholds are 0 as contacts pin
    quick_width : a length over which breaks of contacts just pinned change, inf where the law at X = 0 says it
    bends : sorted finite hazards above 0 at which thresholds are no smooth function of the hazard; thresholds there, at
        an age, are threshold_at(bends, age)
    """

    law: ClassVar[str] = "growing"
    _to_state: ClassVar[tuple[str, ...]] = ("at_start", "time_unit")
    _stated_by: ClassVar[str] = "GrowingThresholds"
    age: float | None = 0.0
    interface: Any = None
    time_unit: float
    quick_width: float = np.inf
    keeps_tail = True
    grows = True
    begins_at_0 = False
    bends: Array = np.empty(0)

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw."""
        averages = 'thermal: closure = "paper" averages over one P_c, and each age has another'
        of_their_own = "ageing: thresholds that grow with their age do age, by a law of their own"
        grows = "thresholds that grow: nothing says whether k_i grows, too"
        relaxed = "contacts whose thresholds grow are taken as they form again relaxed alone"
        return {
            MEAN_RATE: f"{averages}; {EXACT}",
            "ageing": f"{of_their_own}; leave one out",
            "stiffness": f'{LINKED} {grows}; use "independent"',
            "reforming": f"reforming: {relaxed}; leave it out",
        }

    def __repr__(self) -> str:
        """The class alone, as nothing is known here of a subclass's arguments."""
        return f"{type(self).__name__}(...)"

    def __str__(self) -> str:
        """The law in words."""
        return f"thresholds that grow from the age {self.age:.4g} on"

    @cached_property
    def older_at_start(self) -> bool:  # type: ignore[override]
        """See ChangingThresholds."""
        return self.start_pinned_for > 0.0

    @property
    def begins_as_start(self) -> bool:  # type: ignore[override]
        """See ChangingThresholds."""
        return not (self.older_at_start or self.first_pinning_time or self.begins_at_0)

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

    def thresholds_of(self, hazard: Array) -> Callable[[npt.NDArray[np.intp], Array], Array]:
        """The function that gives thresholds (n, k) of some of the contacts with these hazards, shape (m,), by their
        indices (n,), at times since pinning (n, k)."""
        return lambda which, pinned_for: self.threshold_at(hazard[which, None], pinned_for)

    def lost_hazard(self, velocity: float) -> float:
        """Hazard that contacts pass as they pin, if stretched at this speed |dX/dt| >= 0: those below it never hold."""
        return 0.0

    def largest_threshold(self, fresh: float, share: float, duration: float) -> float:
        """See ChangingThresholds: that of contacts of the start, the oldest, which keep their quantile as all do."""
        return self.typical_threshold(fresh, duration)

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """See ChangingThresholds: that of the contact of the start which has the threshold `fresh`."""
        pinned_for = self.start_pinned_for
        hazard = self.hazard_at(np.array([fresh]), pinned_for)
        return float(self.threshold_at(hazard, pinned_for + duration)[0])

    def check_speed(self, velocity: float) -> None:
        """InputError for speeds so low that the ages at which contacts break are beyond floating point."""
        ages = self.at_start.mean() / velocity / self.time_unit
        if not ages < LONGEST:
            hint = f"contacts break at ages of {ages:.1g} times time = {self.time_unit:g}; at most {LONGEST:g} times"
            refuse("velocity", velocity, hint)
        latest, strongest = LONGEST * self.time_unit, -np.log(np.array([STRONGEST]))
        slowest = float(self.threshold_at(strongest, latest)[0]) / latest
        if not slowest < velocity:
            hint = f"the strongest contacts never break below v = {slowest:.4g}, as fast as they grow; slide faster"
            refuse("velocity", velocity, hint)

    def check_growth(self) -> None:
        """InputError where hazards at some ages, stretches and speeds are not what this class says of them, so that no
        solver follows a law that it would follow wrongly."""
        # contacts of one threshold pass many hazards at once
        exact = self.at_start.atoms[0].size > 0
        hazards, ages = np.array([0.05, 0.7, 3.0]), self.time_unit * AGES[:, None]
        thresholds = self._asked("threshold_at", hazards, ages)
        found = self._asked("hazard_at", thresholds, ages)
        if not (exact or np.allclose(found, hazards, rtol=INVERSE)):
            self._refuse("hazard_at at threshold_at(hazard, age) is not that hazard")
        if not np.allclose(self._asked("hazard_at", -thresholds, ages), found, rtol=INVERSE):
            self._refuse("hazard_at(-x, age) is not hazard_at(x, age): x has either sign")
        if not (np.diff(thresholds, axis=0) >= 0.0).all():
            self._refuse("threshold_at falls with the age")
        at_start = self.threshold_at(hazards, self.start_pinned_for)
        if not (exact or np.allclose(-self.at_start.logsf(at_start), hazards, rtol=INVERSE)):
            self._refuse("at_start is not the law of thresholds at the age of the start")
        # legs of the start, stretched or not, and of contacts that form; in rows, times in columns
        begin = at_start[1] * np.array([[0.5], [-0.5], [0.0]]).repeat(3, axis=0)
        speed = at_start[1] / self.time_unit * np.tile([[1e-2], [1.0], [1e2]], (3, 1))
        age, later = np.where(begin, self.start_pinned_for, 0.0), self.time_unit * LATER
        found = self.hazard_at(begin + speed * later, age + later)
        finite = np.where(np.isfinite(found), found, 1e300)
        steps = np.diff(finite) / (1.0 + finite[:, 1:])
        falls_later = np.maximum.accumulate(steps > ROUGHNESS, axis=1) & (steps < -ROUGHNESS)
        if falls_later.any():
            at = float(speed[falls_later.any(axis=1)][0, 0])
            fault = f"hazard_at rises and falls again on a leg of the speed {at:.3g}"
            self._refuse(f"{fault}: thresholds must grow ever more slowly")

    def _asked(self, name: str, *given: Array | float) -> Array:
        """What the method of this name gives; InputError where it fails or the shape is another than that of what it
        was given, as that of code for single numbers."""
        shape = np.broadcast_shapes(*map(np.shape, given))
        rule = f"{name} must take arrays of any shape and return the same shape"
        try:
            found = np.asarray(getattr(self, name)(*given), dtype=float)
        except (TypeError, ValueError, IndexError) as error:
            said = " ".join(f"{type(error).__name__}: {error}".split())
            self._refuse(f"{rule}; for the shape {shape} it ends in {said}")
        if found.shape != shape:
            self._refuse(f"{rule}; for the shape {shape} it returns {found.shape}")
        return found
