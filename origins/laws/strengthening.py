"""Thresholds that grow with the logarithm of the contact's age, as those of real contacts do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.errors import non_negative, refuse
from origins.laws.compiled import CompiledFactor
from origins.laws.proportional import ProportionalGrowth
from origins.thresholds.law import Array

# A threshold that grows by more than itself in each e-fold of time is no logarithmic strengthening of a contact, of
# which 0.01 to 0.1 are measured.
_MOST = 1.0


class Logarithmic(NamedTuple):
    """β, no unit."""

    beta: float


class Strengthening(ProportionalGrowth):
    """x_s(t) = x_s0 g(t), g = 1 + β ln(1 + t/τ_0): each contact's threshold grows with its age t, also at rest.

    Berthoud, Baumberger, G'Sell and Hiver, Phys. Rev. B 59, 14313 (1999); Baumberger and Caroli, Adv. Phys. 55, 279
    (2006). ProportionalGrowth says what follows from any g. Every contact breaks, however slow the slider is.

    fresh : P_c of contacts as they form, at age 0. beta, time : β and τ_0. age : of all contacts at X = 0.
    """

    law = "strengthening"

    def __init__(self, fresh: object, beta: float, time: float, age: float = 0.0) -> None:
        self.beta = non_negative("beta", beta)
        if beta > _MOST:
            hint = f"must be at most {_MOST:g}, the growth in an e-fold of time; 0.01 to 0.1 are measured"
            refuse("beta", beta, hint)
        super().__init__(fresh, time, age)

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
        """See ProportionalGrowth."""
        return np.asarray(1.0 + self.beta * np.log1p(np.asarray(age) / self.time_unit))[()]

    def compiled(self) -> CompiledFactor:
        """The same formula for compiled loops."""
        return CompiledFactor(
            Logarithmic(self.beta),
            factor=lambda law, age: 1.0 + law.beta * np.log(1.0 + age),
            slope=lambda law, age: law.beta / (1.0 + age),
        )


def strengthening(thresholds: object, beta: float, time: float, age: float = 0.0) -> Strengthening:
    """Thresholds that grow with the contact's age t, x_s = x_s0 (1 + β ln(1 + t/τ_0)), in place of thresholds in
    origins.Contacts.

    thresholds : Thresholds or frozen scipy.stats distribution, the law P_c of x_s0 at age 0 (a length).
    beta : β, from 0, no growth, to 1; of real contacts 0.01 to 0.1 (an e-fold of time).
    time : τ_0 > 0, below which a contact hardly grows. age : of all contacts at X = 0, at least 0, in the same unit.
    Source: Berthoud, Baumberger, G'Sell and Hiver, Phys. Rev. B 59, 14313 (1999).
    Raises InputError for values outside these, and for anything but thresholds.
    """
    return Strengthening(thresholds, beta, time, age)
