"""Which Life the laws of the contacts ask for."""

from __future__ import annotations

from master.lives.cold import ColdLife
from master.lives.life import Life
from master.lives.mean_rate import MeanRateLife
from master.lives.stretches import RESOLVED
from master.lives.thermal import ThermalLife
from origins import Contacts


# Share of the tolerance to which averages over the stretches at birth are resolved. What they miss
# is its square, or beside an onset of P_c some 1e-3 of it, and is looked at as they go.
_RESOLVED = 1e-2


def make_life(contacts: Contacts, tolerance: float) -> Life:
    """The life of contacts without ageing; the paper's closure of heat or the exact one.

    tolerance : of the force, in mean thresholds
    """
    if contacts.thermal is None:
        return ColdLife(contacts)
    paper = contacts.thermal.closure == "paper"
    life = MeanRateLife(contacts) if paper else ThermalLife(contacts)
    life.resolved = min(max(_RESOLVED * tolerance, RESOLVED), 1e-6)
    return life
