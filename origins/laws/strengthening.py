"""Thresholds that grow with the logarithm of the contact's age, as those of real contacts do."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from origins.errors import between, non_negative, refuse
from origins.laws.growing import GrowingThresholds
from origins.laws.timed_law import LINKED
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.powered import Powered, straight
from origins.thresholds.scipy_laws import as_thresholds

# A threshold that grows by more than itself in each e-fold of time is no logarithmic strengthening of a contact, of
# which 0.01 to 0.1 are measured.
_MOST = 1.0
_LONGEST = 1e100  # of times, in time_unit, over which thresholds may be followed


class Strengthening(GrowingThresholds):
    """x_s(t) = x_s0 g(t), g = 1 + β ln(1 + t/τ_0): each contact's threshold grows with its age t, also at rest.

    Berthoud, Baumberger, G'Sell and Hiver, Phys. Rev. B 59, 14313 (1999); Baumberger and Caroli, Adv. Phys. 55, 279
    (2006). On a leg of one speed v the ratio |x|/g(t) first falls and then rises, or only one of the two: its slope has
    the sign of N = v g - |x| g', and N' = -|x| g'' >= 0 as g is concave. It is largest at one end of the leg, so that
    contacts born together hold with the probability S(max |x|/g) at the ends so far, S the survival of P_c. In steady
    sliding, x = v t, it rises all along, since g - t g' >= 1: every contact breaks, however slow the slider is.

    fresh : P_c of contacts as they form, at age 0. beta, time : β and τ_0. age : of all contacts at X = 0.
    """

    law = "strengthening"
    keeps_tail = True

    def __init__(self, fresh: Thresholds, beta: float, time: float, age: float = 0.0) -> None:
        self.fresh, self.beta = fresh, non_negative("beta", beta)
        if beta > _MOST:
            hint = f"must be at most {_MOST:g}, the growth in an e-fold of time; 0.01 to 0.1 are measured"
            refuse("beta", beta, hint)
        self.time_unit = between("time", time, 1e-100, 1e100)
        self.age = age = non_negative("age", age)
        self.older_at_start = age > 0.0
        if not self.age <= _LONGEST * self.time_unit:
            refuse("age", age, f"must be at most {_LONGEST:g} times time = {self.time_unit:g}")
        self.interface = fresh.interface

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw."""
        grows = "thresholds that grow: nothing says whether k_i grows, too"
        relaxed = "contacts whose thresholds grow are taken as they form again relaxed alone"
        return super().apart | {
            "stiffness": f'{LINKED} {grows}; use "independent"',
            "reforming": f"reforming: {relaxed}; leave it out",
        }

    def largest_threshold(self, fresh: float, share: float, duration: float) -> float:
        """See ChangingThresholds: that of contacts of the start, the oldest, which grows as all do."""
        return self.typical_threshold(fresh, duration)

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """See ChangingThresholds: the mean one of contacts of the start, the oldest."""
        pinned_for = self.start_pinned_for
        return fresh * float(self.factor(pinned_for + duration) / self.factor(pinned_for))

    def __repr__(self) -> str:
        """Its arguments, such as strengthening(Gaussian(...), beta=0.03, time=1)."""
        age = f", age={self.age:.6g}" if self.age else ""
        return (
            f"strengthening({self.fresh!r}, beta={self.beta:.6g}, time={self.time_unit:.6g}{age})"
        )

    def __str__(self) -> str:
        """The law in words."""
        return f"thresholds that grow by the factor 1 + {self.beta:.4g} ln(1 + age/{self.time_unit:.4g})"

    def factor(self, age: npt.ArrayLike) -> Array:
        """g at these ages >= 0 (times); shape of them."""
        return np.asarray(1.0 + self.beta * np.log1p(np.asarray(age) / self.time_unit))[()]

    @cached_property
    def at_start(self) -> Thresholds:
        """P_c of all contacts at X = 0: that of fresh ones, in lengths g(age) times as large."""
        if self.age == 0.0 or self.beta == 0.0:
            return self.fresh
        law = Powered(self.fresh, straight(float(self.factor(self.start_pinned_for)), 1.0))
        law.interface, law.cut_weight = self.interface, self.fresh.cut_weight
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
        hazard = np.asarray(hazard, dtype=float)
        few = (
            hazard < 0.5
        )  # contacts are weaker: their share has more digits than that of the others
        at_birth = np.empty(hazard.shape)
        at_birth[few] = self.fresh.ppf(-np.expm1(-hazard[few]))
        at_birth[~few] = self.fresh.isf(np.exp(-hazard[~few]))
        return at_birth * self.factor(pinned_for)

    def check_speed(self, velocity: float) -> None:
        """InputError for speeds so low that the ages at which contacts break are beyond floating point."""
        ages = self.fresh.mean() / velocity / self.time_unit
        if not ages < _LONGEST:
            hint = f"contacts break at ages of {ages:.1g} times time = {self.time_unit:g}; at most {_LONGEST:g} times"
            refuse("velocity", velocity, hint)


def strengthening(thresholds: object, beta: float, time: float, age: float = 0.0) -> Strengthening:
    """Thresholds that grow with the contact's age t, x_s = x_s0 (1 + β ln(1 + t/τ_0)), in place of thresholds in
    origins.Contacts.

    thresholds : Thresholds or frozen scipy.stats distribution, the law P_c of x_s0 at age 0 (a length).
    beta : β, from 0, no growth, to 1; of real contacts 0.01 to 0.1 (an e-fold of time).
    time : τ_0 > 0, below which a contact hardly grows. age : of all contacts at X = 0, at least 0, in the same unit.
    Source: Berthoud, Baumberger, G'Sell and Hiver, Phys. Rev. B 59, 14313 (1999).
    Raises InputError for values outside these, and for anything but thresholds.
    """
    if isinstance(thresholds, GrowingThresholds):
        refuse("thresholds", thresholds, "grow already; give the law P_c of those at age 0")
    return Strengthening(as_thresholds(thresholds), beta, time, age)
