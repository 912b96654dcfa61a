"""Which life the laws of some contacts make."""

from __future__ import annotations

from master.lives.cold import ColdLife
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from origins import Contacts


def life_of(contacts: Contacts) -> Life | None:
    """The life of these contacts; None where only the old solvers know what is left of them."""
    if contacts.ageing is not None or contacts.grains is not None:
        return None
    if contacts.thermal is None:
        return ColdLife(contacts)
    return ThermalLife(contacts) if contacts.thermal.closure == "exact" else MeanRateLife(contacts)
