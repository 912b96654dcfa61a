"""What becomes of a contact from one birth to the next, on a slider that moves steadily forward."""

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master._old.release import PLAIN, Release
from origins import Contacts, InputError, Thresholds
from origins.start import Start, as_start

if TYPE_CHECKING:
    from master._old.origin_breaks import Breaking

Array = npt.NDArray[np.float64]


class Cycle:
    """The law of the stretches at which contacts break, and the length that the rest is stated in.

    Parameters
    ----------
    contacts : Contacts
    velocity : float
        v, length per time.
    accuracy : float
        Error of the survival of contacts that age which is aimed at.

    Attributes
    ----------
    velocity : float
    law : Thresholds
        Of the travel from one break to the next.
    births : Start
        Stretches at which broken contacts form again.
    relaxed : Thresholds
        Of the stretch at a break of contacts that form relaxed.
    unit : float
        A length: the mean of `relaxed`; of those that hold at all where thresholds grow with age.
    wait : float
        How far the slider moves while a broken contact is out, a length.
    release : Release
        What breaks and births do to the force, lengths in `unit`s.
    breaking : Breaking or None
        How contacts break at a temperature, or as they age.
    tabulated : bool
        Whether the law is known by tables, of breaks by a rate or with ageing.
    grown : bool
        Whether contacts at X = 0 are older than those that form later, and break by another law.
    error : float
        Estimate of the error of the survival, where the law is known by a numerical solution.

    Raises InputError for the paper's closure of ageing, which is no law of single contacts, for ageing with the
    paper's closure of temperature, and for thresholds that grow with age where contacts are stretched so fast that none
    holds.
    """

    def __init__(self, contacts: Contacts, velocity: float = 1.0, accuracy: float = 1e-8) -> None:
        self._contacts, self.velocity = contacts, velocity
        self.births = as_start(None) if contacts.reforming is None else contacts.reforming.law
        self.relaxed: Thresholds = contacts.thresholds
        self.unit = contacts.mean_threshold
        self._breaking: Breaking | None = None
        self._later: Callable[[], Breaking] | None = None
        self.grown = contacts.grains is not None
        self.error = 0.0
        if contacts.ageing is not None:
            from master._old.ageing_breaking import AgeingBreaking

            if contacts.ageing.closure == "paper":
                raise InputError(
                    'contacts.ageing: closure = "paper" (Q15) has one P_c for all contacts at each X, so that single '
                    'contacts have no law of their own; use closure = "exact", or ask steady_state or '
                    "critical_velocity, which take it"
                )
            if contacts.thermal is not None and contacts.thermal.closure == "paper":
                raise InputError(
                    'contacts.thermal: closure = "paper" averages the rate over one P_c for all contacts, and those '
                    'that age have no such law; use closure = "exact"'
                )
            ageing = AgeingBreaking(contacts, velocity, accuracy)
            self.relaxed, self._breaking, self.error = ageing.effective, ageing, ageing.error
            self.unit = self.relaxed.mean()
        elif contacts.grains is not None and contacts.thermal is not None:
            from master._old.grain_breaking import BornGrains
            from master._old.grain_heat import GrainHeat
            from master._old.grain_passage import warmed

            born = warmed(contacts, velocity, None, accuracy)
            self.relaxed = grown = BornGrains(contacts.grains, velocity, born.law)
            self.unit, self.error = grown.unit, born.error
            self._later = partial(GrainHeat, contacts, velocity, accuracy)
        elif contacts.thermal is not None:
            from master._old.breaking_law import BreakingLaw

            law = BreakingLaw(contacts, velocity)
            self.relaxed, self._breaking, self.unit = law, law.breaking, law.mean()
        elif contacts.grains is not None:
            from master._old.grain_breaking import BornGrains, GrainBreaking

            self.relaxed = grown = BornGrains(contacts.grains, velocity)
            self._breaking, self.unit = GrainBreaking(contacts, velocity), grown.unit
        self.tabulated = contacts.thermal is not None or contacts.ageing is not None
        self.wait = velocity * contacts.waiting_time

    @cached_property
    def law(self) -> Thresholds:
        """See above."""
        from master._old.births import TravelLaw

        born = self.release.born
        if born is None and self.wait == 0.0:
            return self.relaxed
        return TravelLaw(self.relaxed, born, self.wait, self.unit)

    @cached_property
    def release(self) -> Release:
        """See above; breaks after births at many stretches are found when they are asked for."""
        contacts = self._contacts
        plain = contacts.reforming is None and contacts.waiting_time == 0.0 and contacts.stiffness == "independent"
        return PLAIN if plain else self._release(contacts)

    @property
    def breaking(self) -> "Breaking | None":
        """See above; of contacts at X = 0 that break by a law of their own it is found when it is asked for."""
        if self._breaking is None and self._later is not None:
            self._breaking = self._later()
        return self._breaking

    def _release(self, contacts: Contacts) -> Release:
        """All that is there but temperature."""
        from master._old.births import born, standing

        again, unit, linked = contacts.reforming, self.unit, contacts.stiffness == "linked"
        after, force, stiffness, widest = None, 0.0, 1.0, 0.0
        if again is not None:
            after = born(contacts, unit, self.breaking, self.relaxed)
            reborn = Contacts(contacts.thresholds, again.law, stiffness=contacts.stiffness)
            force, stiffness = standing(reborn, unit)
            widest = max(abs(end) for end in again.law.span) / unit
        return Release(
            delay=self.wait / unit,
            birth=0.0 if again is None else again.law.mean() / unit,
            widest=widest,
            birth_force=force,
            birth_stiffness=stiffness,
            stiffness=unit / contacts.mean_threshold if linked else 0.0,
            born=after,
            relaxed=getattr(self.relaxed, "stiffness", None),
            unit=unit,
        )

    def without_wait(self) -> "Cycle":
        """The same where broken contacts form again at once."""
        still = copy(self)
        still.wait = 0.0
        vars(still)["release"] = replace(self.release, delay=0.0)
        vars(still).pop("law", None)
        return still

    def survived(self, start: Start, origin: Array, x: Array) -> Array:
        """Fraction of the contacts that stood at `origin`, stretches of `start`, which hold at x; 0 where no threshold
        is left. Lengths."""
        if self.grown and start is self.births:
            return np.asarray(self.relaxed.sf(x))
        held = self._contacts.thresholds.sf(np.abs(origin))
        if self.breaking is None:
            left = self._contacts.thresholds.sf(np.maximum(np.abs(origin), x))
        else:
            left = self.breaking.of(start).rows(x.ravel(), origin.ravel())[1].reshape(x.shape)
        return np.divide(left, held, out=np.zeros(x.shape), where=held > 0.0)
