"""Thermally activated breaking, for stretches of either sign and motion in either direction (paper, Sec. IV)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from origins.errors import InputError, one_of, positive, refuse
from origins.laws.rate_law import Array, Numbers, RateLaw
from origins.laws.soft import SoftRates
from origins.laws.stiff import StiffRates

# the laws that Thermal and scene files take by name
RATE_LAWS: dict[str, type[SoftRates] | type[StiffRates]] = {"soft": SoftRates, "stiff": StiffRates}


class BreakingRate:
    """A RateLaw for stretches of either sign, with checked arguments.

    Attributes
    ----------
    rates : RateLaw
        The law for stretches 0 <= x <= x_s, which solvers use.
    closure : "exact" or "paper"
        Whether each contact breaks at its own rate, or all at the mean one.

    The methods take numbers or arrays that broadcast: stretches x and `start`, thresholds x_s > 0 with |x| <= x_s
    (lengths), and the relative stiffness κ = k_i/<k> > 0; else they raise InputError. Results have the common
    shape; relative errors stay below 1e-12.
    """

    rates: RateLaw
    closure: Literal["exact", "paper"]

    def rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers = 1.0) -> Array:
        """h(x; x_s), per time."""
        return np.exp(self.log_rate(x, threshold, stiffness))

    def plain_rate(self, x: Array, threshold: Array) -> Array:
        """h at mean stiffness for sums over many contacts, not checked; continued by its formula beyond thresholds,
        unless it vanishes there."""
        stretch = np.abs(x)
        if self.rates.vanishes_at_threshold:
            stretch = np.minimum(stretch, threshold)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_rate = self.rates.log_rate(stretch, threshold, 1.0)
        # above e^50 ω no contact holds, and this is still a number
        return np.asarray(np.exp(np.minimum(log_rate, 50.0 + np.log(self.rates.scale))))

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers = 1.0) -> Array:
        """ln h, finite where h underflows; -inf where h = 0, as for a stiff contact at x_s."""
        stretch, limit, spring = _checked(threshold, stiffness, x=x)
        return self.rates.log_rate(np.abs(stretch), limit, spring)[()]

    def cumulative(
        self, x: Numbers, threshold: Numbers, start: Numbers = 0.0, stiffness: Numbers = 1.0
    ) -> Array:
        """Integral A >= 0 of h over the stretches between `start` and x, in either direction: a length per time.

        At a speed v a contact that holds at `start` still holds at x with the probability exp(-A/v).
        """
        return np.exp(self.log_cumulative(x, threshold, start, stiffness))

    def log_cumulative(
        self, x: Numbers, threshold: Numbers, start: Numbers = 0.0, stiffness: Numbers = 1.0
    ) -> Array:
        """ln A, finite where A underflows; -inf where x = start, where A = 0."""
        end, begin, limit, spring = _checked(threshold, stiffness, x=x, start=start)
        near, far = np.sort(np.abs([end, begin]), axis=0)
        across = (end < 0.0) != (begin < 0.0)
        passed = self.rates.log_passed(np.where(across, 0.0, near), far, limit, spring)
        rest = self.rates.log_passed(0.0, np.where(across, near, 0.0), limit, spring)
        return np.logaddexp(passed, rest)[()]

    def inverse(
        self, amount: Numbers, threshold: Numbers, start: Numbers = 0.0, stiffness: Numbers = 1.0
    ) -> Array:
        """Stretch x >= start at which A, integrated from `start`, reaches `amount` >= 0 (a length per time).

        The threshold where A stays below it. At a speed v a contact breaks at inverse(v e, x_s, start)
        with e from the exponential law of mean 1. Backward motion is the mirror image:
        -inverse(amount, threshold, -start).
        """
        goal, begin, limit, spring = _checked(threshold, stiffness, amount=amount, start=start)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_goal = np.log(goal)
            # from behind the integral from there to 0 is taken off; where less remains to go, x is behind 0 as well
            behind = self.rates.log_passed(0.0, np.maximum(-begin, 0.0), limit, spring)
            apart = np.log(-np.expm1(-np.abs(log_goal - behind)))
            remaining = np.maximum(log_goal, behind) + np.where(log_goal == behind, -np.inf, apart)
        x = self.rates.reached(remaining, np.maximum(begin, 0.0), limit, spring)
        return np.maximum(np.where(log_goal < behind, -x, x), begin)[()]


@dataclass(frozen=True)
class Thermal(BreakingRate):
    """Contacts also break below their threshold, at the rate h(x; x_s) (paper, Eq. temper5).

        soft   h = ω exp[-κ (x_s² - x²) / 2T]                             (Eqs. temper5, temper8)
        stiff  h = ω s^(1/2) exp[-κ x_s² s^(3/2) / 2T], s = 1 - |x|/x_s   (Eqs. temper9, temper10)

    κ = k_i/<k>, the contact's relative stiffness, is 1 where stiffness and threshold are independent, x_s/<x_s>
    where they are linked (origins.Contacts.relative_stiffness). The barrier of a relaxed contact is κ x_s²/2T in
    units of k_BT: with linked stiffness it grows as x_s³.

    Attributes
    ----------
    law : "soft" or "stiff"
    temperature : float
        T = k_BT/<k>, a length squared, one number for all contacts; where thresholds come from a rough surface,
        Interface.temperature(kelvin) gives it.
    attempt_frequency : float
        ω, per time.
    closure : "exact" or "paper"
        "exact": every contact breaks at its own rate. "paper": all break at H(x), the integral of h P_c over
        thresholds beyond x (Eqs. temper3, temper4), as if the weak ones had not broken before.

    Raises InputError unless temperature and attempt frequency are finite and above zero. The methods, and `rates`,
    are those of BreakingRate.
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


class GivenRates(BreakingRate):
    """Contacts break below their threshold by a RateLaw of the user, each at its own rate.

    `law` is its name, `attempt_frequency` its scale (per time). Raises InputError unless it has a name and a scale
    that is finite and above zero.
    """

    closure = "exact"

    def __init__(self, rates: RateLaw) -> None:
        if not isinstance(rates.name, str) or not rates.name:
            refuse("thermal.name", rates.name, 'must be what the law is called, such as "linear"')
        positive("thermal.scale", rates.scale, "the attempt frequency, per time")
        self.rates, self.law, self.attempt_frequency = rates, rates.name, rates.scale

    @property
    def temperature(self) -> float:
        """Raises InputError: a RateLaw need not have a temperature."""
        raise InputError(
            f'temperature: the law "{self.law}" of these contacts has none that could be read or '
            "changed; use contacts.replace(thermal=...) with the law as it is at each temperature"
        )


def as_thermal(law: object) -> Thermal | GivenRates | None:
    """The argument `thermal` of origins.Contacts: None, a Thermal, or any RateLaw; else raises InputError."""
    if law is None or isinstance(law, Thermal | GivenRates):
        return law
    if isinstance(law, SoftRates | StiffRates) and type(law) in RATE_LAWS.values():
        return Thermal(law.name, law.temperature, law.attempt_frequency)
    if isinstance(law, RateLaw) and not isinstance(law, type):
        return GivenRates(law)
    such = 'Thermal("soft", temperature=0.1), or a RateLaw'
    refuse("thermal", law, f"must be an origins.Thermal, such as {such}")


def _checked(threshold: Numbers, stiffness: Numbers, **others: Numbers) -> list[Array]:
    """`others` in their order, thresholds and stiffnesses, all of the common shape; InputError for bad values."""
    named = {**others, "threshold": threshold, "stiffness": stiffness}
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in named.values()))
    limit = arrays[-2]
    for name, values in zip(named, arrays, strict=True):
        good, rule = (values > 0.0) & np.isfinite(values), "must be finite and above zero"
        if name == "amount":
            good, rule = values >= 0.0, "must be zero or above"
        elif name in others:
            good = np.abs(values) <= limit
            rule = f"a contact holds only where |{name}| is at most its threshold"
        if not good.all():
            refuse(name, values[~good][0], rule)
    return list(arrays)
