"""Thresholds that all grow by one factor with the age of their contact: what follows from that factor alone."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from copy import copy
from functools import cached_property

import numpy as np
import numpy.typing as npt

from origins.errors import between, non_negative, refuse
from origins.laws.compiled import CompiledFactor, is_shipped
from origins.laws.growing import AGES, INVERSE, LONGEST, GrowingThresholds
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.powered import Powered, straight
from origins.thresholds.scipy_laws import as_thresholds

# Rounding of a factor, relative: that of some operations.
ROUNDED = 1e-15


class ProportionalGrowth(GrowingThresholds):
    """x_s(t) = x_s0 g(t), with one g for all contacts; a subclass states g, as `factor`.

    g is 1 at age 0, does not fall, and is concave: it grows ever more slowly. On a leg of one speed v the ratio
    |x|/g(t) then first falls and later rises, or only one of the two: its slope has the sign of N = v g - |x| g', and
    N' = -|x| g'' >= 0. It is largest at one end of the leg, so that contacts born together hold with the probability
    S(max |x|/g) at the ends so far, S the survival of P_c. In steady sliding, x = v t, it rises all along, since
    g - t g' >= g(0). Contacts form again relaxed, and k_i does not grow.

    fresh : P_c of contacts as they form, at age 0; as origins.Contacts takes thresholds
    time : over which fresh thresholds grow; age : of all contacts at X = 0, in the same unit
    Raises InputError for values that are no times, and for anything but thresholds.
    """

    _stated_by = "ProportionalGrowth"
    _to_state = ("fresh", "time_unit", "age")
    _stated_where = "call super().__init__(fresh, time, age) in the __init__ of the subclass"

    def __init__(self, fresh: object, time: float, age: float = 0.0) -> None:
        if isinstance(fresh, GrowingThresholds):
            refuse("thresholds", fresh, "grow already; give the law P_c of those at age 0")
        self.fresh = as_thresholds(fresh)
        self.time_unit = between("time", time, 1e-100, 1e100)
        self.age: float = non_negative("age", age)
        if not self.age <= LONGEST * self.time_unit:
            refuse("age", age, f"must be at most {LONGEST:g} times time = {self.time_unit:g}")
        self.interface = self.fresh.interface

    @abstractmethod
    def factor(self, age: npt.ArrayLike) -> Array:
        """g at these ages >= 0 (times), a number or an array of any shape; shape of them."""

    def compiled(self) -> CompiledFactor | None:
        """The factor and its slope for compiled loops; None, and of a law outside this package: the ensemble calls
        `factor`, a thousand times as long."""
        return None

    @property
    def compiled_factor(self) -> CompiledFactor | None:
        """What `compiled` gives; None of a class that states another factor than the one from which it has that, and
        where it is not `is_shipped`."""
        of_class = (vars(one) for one in type(self).__mro__)
        stated = next(names for names in of_class if "factor" in names or "compiled" in names)
        found = self.compiled() if "compiled" in stated else None
        return found if found is not None and is_shipped(found.factor) else None

    def over(self, fresh: object) -> ProportionalGrowth:
        """The same growth of contacts with another law P_c at age 0."""
        other = copy(self)
        for found in ("at_start", "bends"):
            vars(other).pop(found, None)
        other.fresh = as_thresholds(fresh)
        other.interface = other.fresh.interface
        return other

    @property
    def grows(self) -> bool:  # type: ignore[override]
        """See GrowingThresholds."""
        return float(self.factor(LONGEST * self.time_unit)) != 1.0

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """See ChangingThresholds: the mean one of contacts of the start, the oldest."""
        pinned_for = self.start_pinned_for
        return fresh * float(self.factor(pinned_for + duration) / self.factor(pinned_for))

    @cached_property
    def at_start(self) -> Thresholds:  # type: ignore[override]
        """P_c of all contacts at X = 0: that of fresh ones, in lengths g(age) times as large. InputError where the
        factor is not what ProportionalGrowth says: nothing that it gives is used before."""
        self._check_factor()
        if self.age == 0.0 or not self.grows:
            return self.fresh
        law = Powered(self.fresh, straight(float(self.factor(self.start_pinned_for)), 1.0))
        law.interface, law.in_metres = self.interface, self.fresh.in_metres
        law.cut_weight = self.fresh.cut_weight
        return law

    @cached_property
    def bends(self) -> Array:  # type: ignore[override]
        """See GrowingThresholds: hazards at the breakpoints of P_c."""
        hazards = -self.fresh.logsf(self.fresh.breakpoints)
        return np.unique(hazards[(hazards > 0.0) & np.isfinite(hazards)])

    def hazard_at(self, x: Array | float, pinned_for: Array | float) -> Array:
        """See GrowingThresholds."""
        return np.asarray(-self.fresh.logsf(np.abs(x) / self.factor(pinned_for))) + 0.0

    def threshold_at(self, hazard: Array | float, pinned_for: Array | float) -> Array:
        """See GrowingThresholds."""
        return self._at_birth(np.asarray(hazard, dtype=float)) * self.factor(pinned_for)

    def thresholds_of(self, hazard: Array) -> Callable[[npt.NDArray[np.intp], Array], Array]:
        """See GrowingThresholds: quantiles, which take long, are found once."""
        at_birth = self._at_birth(hazard)
        return lambda which, pinned_for: at_birth[which, None] * self.factor(pinned_for)

    def _at_birth(self, hazard: Array) -> Array:
        """Thresholds at age 0 of contacts with these hazards, of their shape."""
        # of weaker contacts the share has more digits than that of the others
        few, at_birth = hazard < 0.5, np.empty(hazard.shape)
        at_birth[few] = self.fresh.ppf(-np.expm1(-hazard[few]))
        at_birth[~few] = self.fresh.isf(np.exp(-hazard[~few]))
        return at_birth

    def _check_factor(self) -> None:
        """InputError where the factor of some ages is not what this class says of it."""
        self._asked("factor", self.time_unit)
        ages = self.time_unit * np.append(0.0, AGES)
        factor = self._asked("factor", ages.reshape(2, -1)).ravel()
        if not np.isfinite(factor).all():
            self._refuse("factor is not finite at all ages")
        if not abs(factor[0] - 1.0) <= INVERSE:
            self._refuse(f"factor(0) is {factor[0]:.6g} and must be 1")
        steps = np.diff(factor) / np.diff(ages)
        if not (steps >= 0.0).all():
            self._refuse("factor must not fall with the age")
        # differences of the factor are rounded, and the more of the slope the closer the ages
        rounding = ROUNDED * factor[1:] / np.diff(ages)
        bent = np.flatnonzero(np.diff(steps) > INVERSE * steps[1:] + rounding[1:] + rounding[:-1])
        if bent.size:
            at = float(ages[bent[0] + 1])
            self._refuse(f"factor must be concave, and rises ever faster near the age {at:.3g}")
