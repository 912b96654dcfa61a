"""What becomes of a contact from one birth to the next, on a slider that moves steadily forward."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master.release import PLAIN, Release
from origins import Contacts, Thresholds

if TYPE_CHECKING:
    from master.thermal_law import ThermalBreaking
    from master.thermal_paper import PaperBreaking

Array = npt.NDArray[np.float64]

LAWS = ("thermal", "delay", "reforming", "stiffness")


class Cycle:
    """The law of the stretches at which contacts break, and the length that the rest is stated in.

    Parameters
    ----------
    contacts : Contacts
    velocity : float
        v, length per time.

    Attributes
    ----------
    law : Thresholds
        Of the travel from one break to the next.
    relaxed : Thresholds
        Of the stretch at a break of contacts that form relaxed.
    unit : float
        A length: the mean of `relaxed`.
    release : Release
        What breaks and births do to the force, lengths in `unit`s.
    breaking : ThermalBreaking, PaperBreaking or None
        How contacts break at a temperature.
    """

    def __init__(self, contacts: Contacts, velocity: float = 1.0) -> None:
        self._thresholds = contacts.thresholds
        self.law: Thresholds = contacts.thresholds
        self.unit = contacts.mean_threshold
        self.breaking: ThermalBreaking | PaperBreaking | None = None
        if contacts.thermal is not None:
            from master.thermal_law import BreakingLaw

            law = BreakingLaw(contacts, velocity)
            self.law, self.breaking, self.unit = law, law.breaking, law.mean()
        self.relaxed, self.release = self.law, PLAIN
        again, linked = contacts.reforming, contacts.stiffness == "linked"
        if again is not None or contacts.delay is not None or linked:
            self._release(contacts, velocity)

    def _release(self, contacts: Contacts, velocity: float) -> None:
        """All that is there but temperature."""
        from master.births import TravelLaw, born, standing

        again, unit, linked = contacts.reforming, self.unit, contacts.stiffness == "linked"
        wait = 0.0 if contacts.delay is None else velocity * contacts.delay.time
        after, force, stiffness, widest = None, 0.0, 1.0, 0.0
        if again is not None:
            after = born(contacts, unit, self.breaking, self.law)
            reborn = Contacts(contacts.thresholds, again.law, stiffness=contacts.stiffness)
            force, stiffness = standing(reborn, unit)
            widest = max(abs(end) for end in again.law.span) / unit
        table = getattr(self.law, "stiffness", None)
        self.release = Release(
            delay=wait / unit,
            birth=0.0 if again is None else again.law.mean() / unit,
            widest=widest,
            birth_force=force,
            birth_stiffness=stiffness,
            stiffness=unit / contacts.mean_threshold if linked else 0.0,
            born=after,
            relaxed=table,
            unit=unit,
        )
        if after is not None or wait > 0.0:
            self.law = TravelLaw(self.relaxed, after, wait, unit)

    def survived(self, origin: Array, x: Array) -> Array:
        """Fraction of the contacts that stood at `origin` which hold at x; 0 where no threshold is left. Lengths."""
        held = self._thresholds.sf(np.abs(origin))
        if self.breaking is None:
            left = self._thresholds.sf(np.maximum(np.abs(origin), x))
        else:
            left = self.breaking.rows(x.ravel(), origin.ravel())[1].reshape(x.shape)
        return np.divide(left, held, out=np.zeros(x.shape), where=held > 0.0)
