"""Which life the laws of some contacts make."""

from __future__ import annotations

from master.lives.cold import ColdLife
from master.lives.heat.above import ACCURACY
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.stretches import RESOLVED
from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from origins import Contacts

# Error of what is left of contacts, in units of the tolerance: a sum over births weighs many.
_ACCURACY = 1e-3
# The same of averages over the stretches at birth. What they miss is the square of this, or beside
# an onset of P_c some 1e-3 of it, and is looked at as they go.
_RESOLVED, LEAST_RESOLVED, MOST_RESOLVED = 1e-2, 1e-12, 1e-6


def life_of(contacts: Contacts, tolerance: float = 0.0) -> Life | None:
    """The life of these contacts; None where only the old solvers know what is left of them.

    tolerance : of the force, in mean thresholds; 0: what is left is known as well as can be
    """
    if contacts.ageing is not None or contacts.grains is not None:
        return None
    if contacts.thermal is None:
        return ColdLife(contacts)
    resolved = (
        min(max(_RESOLVED * tolerance, LEAST_RESOLVED), MOST_RESOLVED) if tolerance else RESOLVED
    )
    if contacts.thermal.closure == "paper":
        return MeanRateLife(contacts, resolved)
    return ThermalLife(contacts, max(_ACCURACY * tolerance, ACCURACY), resolved)
