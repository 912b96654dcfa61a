"""Contacts: the laws that each contact follows, and the stretches of all contacts at X = 0."""

from __future__ import annotations

import dataclasses
import warnings
from copy import copy
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, one_of, refuse
from origins.grains.contact import GrainContact
from origins.laws.ageing import Ageing
from origins.laws.delay import Delay
from origins.laws.growing import GrowingThresholds
from origins.laws.rate_law import RateLaw
from origins.laws.strengthening import Strengthening
from origins.laws.temperature import TooHot, too_cold, too_hot
from origins.laws.thermal import RATE_LAWS, BreakingRate, Thermal, as_thermal
from origins.laws.timed_law import MEAN_RATE, ChangingThresholds, TimedLaw
from origins.roughness.interface import Interface
from origins.roughness.stated import StatedInterface
from origins.start import FormationLaw, as_start
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.scipy_laws import as_thresholds

# All laws that a contact may have beside thresholds and a start, by the attributes of Contacts; one that is absent is
# None (stiffness: "independent"). Solvers use this list, Contacts.laws and Contacts.replace; what a law is asked beside
# its equation stands there, see origins/laws/timed_law.py. The first stands for any law in place of thresholds.
LAWS = ("growing", "thermal", "ageing", "delay", "reforming", "stiffness")
_ARGUMENTS = ("thresholds", "start", *LAWS[1:], "interface")


class Contacts:
    """Contacts that break at random thresholds, or before, and form again; a law that is None is absent.

    Parameters
    ----------
    thresholds : Thresholds, scipy.stats distribution on x >= 0, or a law by which they change, a ChangingThresholds
        Law P_c(x) of fresh thresholds (a length). Distributions of scipy are frozen ones, stats.gamma(2.5), or objects
        of its newer interface, stats.Normal(mu=1.0, sigma=0.05), here and below; a weight below 0 of up to 1e-6 is cut
        off, and solvers report it. Thresholds of strengthening(...), or of a GrainContact with an age, such as
        growing_grains(...), grow until the contact breaks, also at rest, and P_c is that of all contacts at X = 0. Of
        growing grains a broken contact re-forms when its new grains pin and the delay after that is over. At β = 0
        strengthening is dropped.
    start : None, float, Start or scipy.stats distribution
        Stretches at X = 0, of contacts that hold; None: all relaxed, x = 0. A contact that starts at x has a
        threshold from P_c conditional on x_s > |x|.
    thermal : Thermal or RateLaw, optional
        Breaking below the threshold, at a rate. With a RateLaw each contact breaks at its own rate.
    ageing : Ageing, optional
        Diffusion of the threshold while the contact holds. At rate 0 the law is dropped, except in the paper's
        closure, which differs from no ageing even then.
    delay : Delay, optional
        How long a broken contact stays out; at time 0 there is none.
    reforming : None, float, Start or scipy.stats distribution
        Stretches at which broken contacts form again, such as origins.boltzmann_reforming(temperature); None: x = 0.
        The threshold follows P_c conditional on x_s > |x|.
    stiffness : "independent" or "linked"
        "independent": k_i does not depend on the threshold, and counts as <k> (paper, Eq. Q6). "linked": k_i is
        proportional to x_si, as where f_s ~ A and k ~ A^(1/2): k_i = <k> x_si/<x_s>, <k> being the mean at birth.
    interface : StatedInterface, optional
        <k> and the number of contacts in SI units, for thresholds in metres that are no rough surface's, which has an
        Interface of its own.

    Attributes
    ----------
    growing : GrowingThresholds or None
        None where thresholds do not grow with age. By their kind they are also `grains`, a GrainContact, or
        `strengthening`, a Strengthening; the other is None.
    waiting_time : float
        Time from a break to re-forming: the delay plus the time until grains pin. A contact that is then stretched
        too fast to hold waits once more.
    mean_threshold : float
        <x_s>, the unit in which tolerances are stated.
    interface : Interface, StatedInterface or None
        Load, contact density, <k> and friction in SI units, where the thresholds come from a rough surface; else the
        argument.
    cut_weight : float
        Starting weight that lay beyond every threshold and was cut off; 0 by default.
    thermal, ageing, delay, reforming
        The laws; None where the law is absent. `thermal.rates` is the RateLaw, `reforming` a FormationLaw.
    laws : tuple of str
        Names of the laws that are present, from origins.contacts.LAWS; a law in place of thresholds is called by its
        own name, "grains", "strengthening" or that of a law of one's own.
    in_time, held_in_time : tuple of str
        Of these those under which time matters, and those under which it matters to contacts that hold.
    changing : ChangingThresholds or None
        The law by which thresholds change while contacts hold; None: they stay as P_c gave them.

    Raises InputError where more than 1e-6 of the start or of the re-forming lies beyond every threshold, as such
    contacts cannot hold; for laws that cannot be combined, with the reason; for fresh thresholds where the final law
    has no weight; and for temperatures below 1e-20 <x_s>², at which rates are 0 up to the threshold.
    """

    def __init__(
        self,
        thresholds: object,
        start: object = None,
        thermal: BreakingRate | RateLaw | None = None,
        ageing: Ageing | None = None,
        delay: Delay | None = None,
        reforming: object = None,
        stiffness: Literal["independent", "linked"] = "independent",
        interface: StatedInterface | None = None,
    ) -> None:
        """Check the parts, each by itself and together; the arguments are those above."""
        own = thresholds if isinstance(thresholds, ChangingThresholds) else None
        if own is not None:
            own.check_stated()
            thresholds = own.at_start
        self.thresholds = as_thresholds(thresholds)
        if isinstance(own, GrowingThresholds) and not own.grows:
            own = None
        self._own = own
        if self.growing is not None:
            self.growing.check_growth()
        if interface is not None:
            self._state(interface)
        self._stated, self.interface = interface, self.thresholds.interface
        self.start = as_start(start)
        self.mean_threshold = _checked_mean(self.thresholds)
        self.cut_weight = FormationLaw("start", self.start, self.thresholds).cut_weight
        reformed = FormationLaw("reforming", as_start(reforming, "reforming"), self.thresholds)
        self.reforming = None if reformed.law.span == (0.0, 0.0) else reformed
        self.thermal = as_thermal(thermal)
        self.ageing, self.delay, self.stiffness = ageing, delay, stiffness
        self._check_laws()
        self.waiting_time = 0.0 if self.delay is None else self.delay.time
        if self.changing is not None:
            self.waiting_time += self.changing.first_pinning_time

    def _state(self, interface: StatedInterface) -> None:
        """Let the thresholds have this interface, but not those of the caller."""
        if isinstance(self.thresholds.interface, Interface):
            hint = "is for thresholds that are no surface's, which has its own; leave it out"
            refuse("interface", interface, hint)
        self.thresholds = copy(self.thresholds)
        self.thresholds.interface = interface

    def __repr__(self) -> str:
        """The laws that the contacts have, each by its own repr."""
        laws = {name: getattr(self, name, None) for name in _ARGUMENTS}
        laws["interface"] = self._stated
        laws["thresholds"] = self._own or self.thresholds
        said = (f"{name}={law!r}" for name, law in laws.items() if law is not None)
        return f"Contacts({', '.join(said)})"

    @property
    def growing(self) -> GrowingThresholds | None:
        """See Contacts."""
        return self._own if isinstance(self._own, GrowingThresholds) else None

    @property
    def grains(self) -> GrainContact | None:
        """Thresholds of growing grains, or None."""
        return self.growing if isinstance(self.growing, GrainContact) else None

    @property
    def strengthening(self) -> Strengthening | None:
        """Thresholds that grow with the logarithm of the age, or None; a class made from it has another growth."""
        return self.growing if type(self.growing) is Strengthening else None

    @property
    def laws(self) -> tuple[str, ...]:
        """See Contacts; in the order of origins.contacts.LAWS."""
        return tuple(self._there)

    @property
    def _there(self) -> dict[str, Any]:
        """The laws that are present, by their names in `laws`."""
        own = {self._own.law: self._own} if self._own else {}
        there = {name: getattr(self, name) for name in LAWS[1:]}
        return own | {name: law for name, law in there.items() if law not in (None, "independent")}

    @property
    def in_time(self) -> tuple[str, ...]:
        """See Contacts."""
        return tuple(name for name, law in self._there.items() if isinstance(law, TimedLaw))

    @property
    def held_in_time(self) -> tuple[str, ...]:
        """See Contacts."""
        return tuple(name for name in self.in_time if self._there[name].while_holding)

    @property
    def changing(self) -> ChangingThresholds | None:
        """See Contacts."""
        laws = (law for law in self._there.values() if isinstance(law, ChangingThresholds))
        return next(laws, None)

    @property
    def older_at_start(self) -> bool:
        """Whether contacts of the start are older than those that have just formed."""
        return self.changing is not None and self.changing.older_at_start

    def oldest_threshold(self, duration: float) -> float:
        """About the threshold (a length) that decides how far the oldest contacts are stretched after this time."""
        if self.changing is None:
            return self.mean_threshold
        return self.changing.typical_threshold(self.mean_threshold, duration)

    def replace(self, **changes: Any) -> Contacts:
        """These contacts with some of the constructor's arguments replaced, by name.

        None removes a law (stiffness: "independent"). Arguments not named stay. All are checked again: raises
        InputError as the constructor does, and for an unknown name.
        """
        given = {name: getattr(self, name) for name in _ARGUMENTS}
        given["reforming"] = None if self.reforming is None else self.reforming.law
        given["thresholds"] = self._own or self.thresholds
        given["interface"] = self._stated  # that of a surface comes with its thresholds
        for name, value in changes.items():
            if name not in given:
                refuse(name, value, f"is not what contacts have; that is {', '.join(given)}")
        return Contacts(**(given | changes))

    def relative_stiffness(self, threshold: npt.ArrayLike) -> Array:
        """k_i/<k> of contacts with these thresholds (lengths): 1 if independent, x_si/<x_s> if linked; same shape."""
        threshold = np.asarray(threshold, dtype=float)
        linked = self.stiffness == "linked"
        return threshold / self.mean_threshold if linked else np.ones_like(threshold)[()]

    def each_by_itself(self) -> Contacts:
        """These contacts with both closures "exact": each breaks at its own rate and ages by itself."""
        changes = {}
        for name in ("thermal", "ageing"):
            if (law := getattr(self, name)) is not None and law.closure == "paper":
                changes[name] = dataclasses.replace(law, closure="exact")
        return self.replace(**changes) if changes else self

    def _check_laws(self) -> None:
        """InputError for arguments that are no laws, and for laws that cannot be combined."""
        temperature = getattr(self.thermal, "temperature", None)
        if temperature is not None:
            if hint := too_cold(temperature, self.thresholds):
                refuse("thermal.temperature", temperature, hint)
            if warning := too_hot(temperature, self.thresholds):
                warnings.warn(warning, TooHot, stacklevel=3)
        if not isinstance(self.ageing, Ageing | None):
            refuse("ageing", self.ageing, "must be an origins.Ageing, as Ageing(law, rate=5e-4)")
        if not isinstance(self.delay, Delay | None):
            refuse("delay", self.delay, "must be an origins.Delay, such as Delay(time=0.2)")
        one_of("stiffness", self.stiffness, ("independent", "linked"))
        if self.ageing and self.ageing.rate == 0.0 and self.ageing.closure == "exact":
            self.ageing = None
        if self.delay and self.delay.time == 0.0:
            self.delay = None
        if self._own is not None and self._own.law in LAWS[1:]:
            hint = "is the name of another law; give these thresholds their own"
            refuse("law", self._own.law, hint)
        there = set(self.laws)
        if self.thermal is not None and self.thermal.closure == "paper":
            there.add(MEAN_RATE)
        for name in self.in_time:
            for other, reason in self._there[name].apart.items():
                if other in there:
                    raise InputError(reason)
        if self.ageing is not None:
            self.ageing.check_fresh(self.thresholds)


def _checked_mean(thresholds: Thresholds) -> float:
    """<x_s>; InputError where it is beyond all powers of floating point, for a weight at 0 and an invalid survival."""
    positions, weights = thresholds.atoms
    if (loose := float(weights[positions <= 0.0].sum())) > 0.0:
        hint = "such contacts never hold, so leave them out and count them apart"
        raise InputError(f"thresholds: a weight of {loose:.3g} lies at x = 0; {hint}")
    if not 1e-80 < (mean := thresholds.mean()) < 1e80:  # powers up to the fourth are finite numbers
        hint = "powers of it are beyond floating point; choose another law or unit of length"
        raise InputError(f"thresholds: the mean is {mean:.3g}: {hint}")
    thresholds.sf(mean * np.linspace(0.05, 3.0, 60))  # refuses an invalid one, by its name
    return mean


def check_contacts(
    contacts: object,
    solver: str,
    takes: tuple[str, ...] = (),
    own_rates: bool = False,
    other: str = "",
) -> None:
    """Raise InputError for anything but Contacts, such as thresholds alone, and for laws that `solver` does not take,
    but `other` may: those not in `takes`, and unless `own_rates` a RateLaw that is not one of origins.laws."""
    if not isinstance(contacts, Contacts):
        refuse("contacts", contacts, "must be contacts; write origins.Contacts(thresholds)")
    for name in contacts.laws:
        if (name if name in LAWS else LAWS[0]) in takes:
            continue
        value = " = 'linked'" if name == "stiffness" else ""
        hint = (
            f"does not take it yet; leave {name} out of the contacts{other and ', or use '}{other}"
        )
        raise InputError(f"contacts.{name}{value}: {solver} {hint}")
    if not (own_rates or isinstance(contacts.thermal, Thermal | None)):
        choices = " or ".join(f'Thermal("{name}", ...)' for name in RATE_LAWS)
        hint = f'does not take the rate law "{contacts.thermal.rates.name}" yet; use {choices}'
        raise InputError(f"contacts.thermal: {solver} {hint}")
