"""Which life the laws of some contacts make."""

from __future__ import annotations

from master.lives.cold import ColdLife
from master.lives.grains import GrainLife
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from master.lives.warm_grains import WarmGrainLife
from origins import Contacts


def life_of(contacts: Contacts, longest: float = 0.0) -> Life | None:
    """The life of these contacts; None where only the old solvers know what is left of them.

    longest : time after which no contact is looked at any more; only thresholds that grow ask it,
        and where it is 0 there is no life of these
    """
    if contacts.grains is not None and longest > 0.0:
        warm = contacts.thermal is not None
        return WarmGrainLife(contacts, longest) if warm else GrainLife(contacts, longest)
    if contacts.ageing is not None or contacts.grains is not None:
        return None
    if contacts.thermal is None:
        return ColdLife(contacts)
    return ThermalLife(contacts) if contacts.thermal.closure == "exact" else MeanRateLife(contacts)
