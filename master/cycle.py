"""What becomes of a contact from one birth to the next, on a slider that moves steadily forward."""

from typing import TYPE_CHECKING

from origins import Contacts, Thresholds
from origins.errors import refuse

if TYPE_CHECKING:
    from master.thermal_law import ThermalBreaking

LAWS = ("thermal",)


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
    unit : float
        A length: the mean of that law.
    breaking : ThermalBreaking or None
        How contacts break at a temperature.

    Raises InputError for thermal closure "paper", which is not taken yet.
    """

    def __init__(self, contacts: Contacts, velocity: float = 1.0) -> None:
        self.law: Thresholds = contacts.thresholds
        self.unit = contacts.mean_threshold
        self.breaking: ThermalBreaking | None = None
        if contacts.thermal is not None:
            from master.thermal_law import BreakingLaw

            if contacts.thermal.closure == "paper":
                refuse("closure", "paper", 'not taken yet; write closure="exact"')
            law = BreakingLaw(contacts, velocity)
            self.law, self.breaking, self.unit = law, law.breaking, law.mean()
