"""Thermally activated breaking: which rate law, at which temperature, by which closure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from origins.errors import InputError, one_of, positive, refuse
from origins.laws import RATE_LAWS, SoftRates, StiffRates
from origins.laws.breaking_rate import BreakingRate
from origins.laws.rate_law import RateLaw


@dataclass(frozen=True)
class Thermal(BreakingRate):
    """Contacts also break below their threshold, at the rate h(x; x_s) (paper, Eq. temper5).

        soft   h = ω exp[-κ (x_s² - x²) / 2T]                             (Eqs. temper5, temper8)
        stiff  h = ω s^(1/2) exp[-κ x_s² s^(3/2) / 2T], s = 1 - |x|/x_s   (Eqs. temper9, temper10)

    T is the temperature and κ = k_i/<k> the contact's relative stiffness, given by
    origins.Contacts.relative_stiffness: 1 where stiffness and threshold are independent,
    x_s/<x_s> where they are linked. The barrier of a relaxed contact is κ x_s²/2T in units of
    k_BT, so with linked stiffness it grows as x_s³, and T = k_BT/<k> is one number for all contacts
    while k_BT/k_i = T/κ is each contact's own.

    Attributes
    ----------
    law : "soft" or "stiff"
    temperature : float
        T = k_BT/<k>, a length squared; where thresholds come from a rough surface,
        Interface.temperature(kelvin) gives it.
    attempt_frequency : float
        ω, per time.
    closure : "exact" or "paper"
        "exact": every contact breaks at its own rate. "paper": all break at H(x), the integral of
        h P_c over thresholds beyond x (Eqs. temper3, temper4), as if the weak ones had not broken
        before.
    rates : RateLaw
        The same rate for stretches 0 <= x <= x_s, for solvers.

    Raises InputError unless temperature and attempt frequency are finite and above zero. The
    methods are those of BreakingRate.
    """

    law: Literal["soft", "stiff"]
    temperature: float
    attempt_frequency: float = 1.0
    closure: Literal["exact", "paper"] = "exact"

    def __post_init__(self) -> None:
        one_of("law", self.law, tuple(RATE_LAWS))
        one_of("closure", self.closure, ("exact", "paper"))
        rates = RATE_LAWS[self.law](self.temperature, self.attempt_frequency)
        object.__setattr__(self, "rates", rates)


@dataclass(frozen=True)
class GivenRates(BreakingRate):
    """Contacts break below their threshold by a RateLaw of the user, each at its own rate.

    Attributes
    ----------
    rates : RateLaw
    law : str
        Its name.
    attempt_frequency : float
        Its scale, per time.
    closure : "exact"

    Raises InputError unless the law has a name and a scale that is finite and above zero.
    """

    rates: RateLaw
    closure: Literal["exact", "paper"] = "exact"

    def __post_init__(self) -> None:
        if not isinstance(self.rates.name, str) or not self.rates.name:
            rule = 'must be what the law is called, such as "linear"'
            refuse("thermal.name", self.rates.name, rule)
        positive("thermal.scale", self.rates.scale, "the attempt frequency, per time")

    @property
    def law(self) -> str:
        """The law's name."""
        return self.rates.name

    @property
    def attempt_frequency(self) -> float:
        """ω, per time."""
        return self.rates.scale

    @property
    def temperature(self) -> float:
        """Raises InputError: a RateLaw need not have a temperature."""
        raise InputError(
            f'temperature: the law "{self.law}" of these contacts has none that could be read or '
            "changed; use contacts.replace(thermal=...) with the law as it is at each temperature"
        )


def as_thermal(law: object) -> Thermal | GivenRates | None:
    """The argument `thermal` of origins.Contacts, checked: None, a Thermal, or any RateLaw.

    With a RateLaw each contact breaks at its own rate. Raises InputError for other arguments.
    """
    if law is None or isinstance(law, Thermal | GivenRates):
        return law
    if isinstance(law, SoftRates | StiffRates) and type(law) in RATE_LAWS.values():
        return Thermal(law.name, law.temperature, law.attempt_frequency)
    if isinstance(law, RateLaw) and not isinstance(law, type):
        return GivenRates(law)
    such = 'Thermal("soft", temperature=0.1), or a RateLaw'
    refuse("thermal", law, f"must be an origins.Thermal, such as {such}")
