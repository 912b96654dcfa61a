"""Thermally activated breaking, for stretches of either sign and motion in either direction (paper, Sec. IV)."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from origins.errors import InputError, one_of, positive, refuse
from origins.laws.eyring import EyringRates
from origins.laws.rate_law import Array, Numbers, RateLaw
from origins.laws.soft import SoftRates
from origins.laws.stiff import StiffRates
from origins.laws.timed_law import EXACT, LINKED, TimedLaw

# The laws that Thermal and scene files take by name. The parameters of the class are those of the law there; each is
# an attribute, too, as in a dataclass.
RATE_LAWS: dict[str, Callable[..., RateLaw]] = {
    "soft": SoftRates,
    "stiff": StiffRates,
    "eyring": EyringRates,
}


class BreakingRate(TimedLaw):
    """A RateLaw with checked arguments, for stretches of either sign; in Contacts also a law of the user's own.

    rates : the RateLaw for stretches 0 <= x <= x_s, which solvers use.
    closure : "exact" or "paper": whether each contact breaks at its own rate, or all at the mean one.

    The methods take numbers or arrays that broadcast: stretches x and `start`, thresholds x_s > 0 with |x| <= x_s
    (lengths), and the relative stiffness κ = k_i/<k> > 0; else they raise InputError. Results have the common
    shape; relative errors stay below 1e-12. InputError also for a law without a name or a finite scale above zero.
    """

    rates: RateLaw
    closure: Literal["exact", "paper"] = "exact"

    def __init__(self, rates: RateLaw) -> None:
        if not isinstance(rates.name, str) or not rates.name:
            refuse("thermal.name", rates.name, 'must be what the law is called, such as "linear"')
        positive("thermal.scale", rates.scale, "the attempt frequency, per time")
        self.rates = rates

    def __repr__(self) -> str:
        """The law, by its class where it has no repr of its own but an address."""
        own = type(self.rates)
        law = f"{own.__name__}()" if own.__repr__ is object.__repr__ else repr(self.rates)
        return f"{type(self).__name__}({law})"

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw."""
        if self.closure == "exact":
            return {}
        one_rate = f'{LINKED} thermal closure = "paper", one mean rate for all contacts'
        return {"stiffness": f"{one_rate}; {EXACT}"}

    def rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers = 1.0) -> Array:
        """h(x; x_s), per time."""
        return np.exp(self.log_rate(x, threshold, stiffness))

    def log_rate(self, x: Numbers, threshold: Numbers, stiffness: Numbers = 1.0) -> Array:
        """ln h, finite where h underflows; -inf where h = 0, as for a stiff contact at x_s."""
        stretch, limit, relative = _checked(threshold, stiffness, x=x)
        return self.rates.log_rate(np.abs(stretch), limit, relative)[()]

    def cumulative(
        self, x: Numbers, threshold: Numbers, start: Numbers = 0.0, stiffness: Numbers = 1.0
    ) -> Array:
        """Integral J >= 0 of h over the stretches between `start` and x, in either direction: a length per time.

        At a speed v a contact that holds at `start` still holds at x with the probability exp(-J/v).
        """
        return np.exp(self.log_cumulative(x, threshold, start, stiffness))

    def log_cumulative(
        self, x: Numbers, threshold: Numbers, start: Numbers = 0.0, stiffness: Numbers = 1.0
    ) -> Array:
        """ln J, finite where J underflows; -inf where x = start, where J = 0."""
        end, begin, limit, relative = _checked(threshold, stiffness, x=x, start=start)
        near, far = np.sort(np.abs([end, begin]), axis=0)
        # through 0 the shorter part is passed, too
        through = np.where((end < 0.0) != (begin < 0.0), near, 0.0)
        passed = self.rates.log_passed(near - through, far, limit, relative)
        return np.logaddexp(passed, self.rates.log_passed(0.0, through, limit, relative))[()]

    def inverse(
        self, amount: Numbers, threshold: Numbers, start: Numbers = 0.0, stiffness: Numbers = 1.0
    ) -> Array:
        """Stretch x >= start at which J, integrated from `start`, reaches `amount` >= 0 (a length per time).

        The threshold where J stays below it. At a speed v a contact breaks at inverse(v e, x_s, start) with e from the
        exponential law of mean 1. Backward motion is the mirror image: -inverse(amount, threshold, -start).
        """
        goal, begin, limit, relative = _checked(threshold, stiffness, amount=amount, start=start)
        with np.errstate(divide="ignore", invalid="ignore"):
            goal = np.log(goal)
            # of the integral from behind up to 0; where the goal is less, x lies behind 0 as well
            behind = self.rates.log_passed(0.0, np.maximum(-begin, 0.0), limit, relative)
            apart = np.log(-np.expm1(-np.abs(goal - behind)))
            rest = np.where(goal == behind, -np.inf, np.maximum(goal, behind) + apart)
        x = self.rates.reached(rest, np.maximum(begin, 0.0), limit, relative)
        return np.maximum(np.where(goal < behind, -x, x), begin)[()]


@dataclass(frozen=True, init=False)
class Thermal(BreakingRate):
    """Contacts also break below their threshold, at the rate h(x; x_s) (paper, Eq. temper5).

        soft   h = ω exp[-κ (x_s² - x²) / 2T]                             (Eqs. temper5, temper8)
        stiff  h = ω s^(1/2) exp[-κ x_s² s^(3/2) / 2T], s = 1 - |x|/x_s   (Eqs. temper9, temper10)
        eyring h = ω exp[-s/α]                                            (no law of the paper)

    κ = k_i/<k>, the contact's relative stiffness, is 1 where stiffness and threshold are independent, x_s/<x_s>
    where they are linked (origins.Contacts.relative_stiffness). The barrier of a relaxed contact is κ x_s²/2T in
    units of k_BT: with linked stiffness it grows as x_s³.

    law : "soft", "stiff" or "eyring", or another name in RATE_LAWS
    temperature : T = k_BT/<k>, a length squared, one number for all contacts; where thresholds come from a rough
        surface, Interface.temperature(kelvin) gives it. None: a law that does not take it.
    attempt_frequency : ω, per time.
    closure : "exact": every contact breaks at its own rate. "paper": all break at H(x), the
        integral of h P_c over thresholds beyond x (Eqs. temper3, temper4), as if the weak ones had not broken before.
    own : what else the law takes, pairs of name and value; the call takes them as keywords, as
        Thermal("eyring", width=0.03), α, which takes no temperature.

    Raises InputError for a parameter that the law does not take, or that it needs and that is missing, and unless
    temperature and attempt frequency are finite and above zero. Methods and `rates` are those of BreakingRate.
    """

    law: str
    temperature: float | None = None
    attempt_frequency: float = 1.0
    closure: Literal["exact", "paper"] = "exact"
    own: tuple[tuple[str, Any], ...] = ()

    def __init__(
        self,
        law: str,
        temperature: float | None = None,
        attempt_frequency: float = 1.0,
        closure: Literal["exact", "paper"] = "exact",
        **own: Any,
    ) -> None:
        """Check the arguments, which are those above, and make the law; dataclasses.replace gives `own` as pairs."""
        one_of("law", law, tuple(RATE_LAWS))
        one_of("closure", closure, ("exact", "paper"))
        own = dict(own.pop("own", ())) | own
        given = {"temperature": temperature, "attempt_frequency": attempt_frequency, **own}
        given = {name: value for name, value in given.items() if value is not None}
        takes = inspect.signature(RATE_LAWS[law]).parameters
        said = f'the law "{law}" takes {", ".join(takes)}'
        for name, value in given.items():
            if name not in takes:
                refuse(name, value, f"is unknown; {said}")
        for name, parameter in takes.items():
            if parameter.default is parameter.empty and name not in given:
                raise InputError(f"{name}: is missing; {said}")
        fields: dict[str, Any] = {
            "law": law,
            "temperature": temperature,
            "attempt_frequency": attempt_frequency,
        }
        fields |= {"closure": closure, "own": tuple(sorted(own.items()))}
        for name, value in {**fields, "rates": RATE_LAWS[law](**given)}.items():
            object.__setattr__(self, name, value)


def as_thermal(law: Any) -> BreakingRate | None:
    """The argument `thermal` of origins.Contacts: None, a Thermal, or any RateLaw; else raises InputError."""
    if law is None or isinstance(law, BreakingRate):
        return law
    if type(law) in RATE_LAWS.values():
        takes = inspect.signature(type(law)).parameters
        return Thermal(law.name, **{name: getattr(law, name) for name in takes})
    if isinstance(law, RateLaw) and not isinstance(law, type):
        return BreakingRate(law)
    refuse("thermal", law, 'must be an origins.Thermal("soft", 0.1), or of a subclass of RateLaw')


def _checked(threshold: Numbers, stiffness: Numbers, **others: Numbers) -> list[Array]:
    """`others` in their order, thresholds and stiffnesses, all of the common shape; InputError for bad values."""
    named = {**others, "threshold": threshold, "stiffness": stiffness}
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in named.values()))
    for name, values in zip(named, arrays, strict=True):
        good, hint = (values > 0.0) & np.isfinite(values), "must be finite and above zero"
        if name == "amount":
            good, hint = values >= 0.0, "must be zero or above"
        elif name in others:
            good = np.abs(values) <= arrays[-2]
            hint = f"a contact holds only where |{name}| is at most its threshold"
        if not good.all():
            refuse(name, values[~good][0], hint)
    return list(arrays)
