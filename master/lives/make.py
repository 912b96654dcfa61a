"""Which life the laws of some contacts make."""

from __future__ import annotations

from master.lives.age.forward import ForwardAgeing
from master.lives.age.path import AgeingPath
from master.lives.cold import ColdLife
from master.lives.grains import GrainLife
from master.lives.heat.above import ACCURACY
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.stretches import RESOLVED
from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from master.lives.warm_grains import WarmGrainLife
from master.motion.motion import Motion
from origins import Contacts, InputError

# Error of what is left of contacts, in units of the tolerance: a sum over births weighs many.
_ACCURACY = 1e-3
# The same of averages over the stretches at birth. What they miss is the square of this, or beside
# an onset of P_c some 1e-3 of it, and is looked at as they go.
_RESOLVED, MOST_RESOLVED = 1e-2, 1e-6
# Error of the share that holds of contacts that age, in units of the tolerance, and its least.
_AGED, _FINEST = 0.1, 1e-10


def life_of(
    contacts: Contacts, tolerance: float = 0.0, motion: Motion | None = None
) -> Life | None:
    """The life of these contacts; None where only the old solvers know what is left of them.

    tolerance : of the force, in mean thresholds; 0: what is left is known as well as can be
    motion : of the slider; contacts that age have no life that does not ask it
    """
    if contacts.grains is not None:
        if motion is None:
            return None
        longest = float(motion.times[-1])
        if contacts.thermal is None:
            return GrainLife(contacts, longest)
        # whose quantiles are summed for each birth and moment: too long on several legs
        return WarmGrainLife(contacts, longest) if motion.one_leg else None
    if contacts.ageing is not None:
        if motion is None:
            return None
        check_ageing(contacts)
        accuracy = max(_AGED * tolerance, _FINEST)
        if not motion.one_leg:
            return AgeingPath(contacts, motion, accuracy)
        longest = float(motion.times[-1])
        return ForwardAgeing(contacts, float(motion.speeds[0]), accuracy, longest)
    if contacts.thermal is None:
        return ColdLife(contacts)
    resolved = min(max(_RESOLVED * tolerance, RESOLVED), MOST_RESOLVED)
    if contacts.thermal.closure == "paper":
        return MeanRateLife(contacts, resolved)
    return ThermalLife(contacts, max(_ACCURACY * tolerance, ACCURACY), resolved)


def check_ageing(contacts: Contacts) -> None:
    """Raise InputError where contacts that age have no law each by itself."""
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        raise InputError(
            'contacts.ageing: closure = "paper" (Q15) has one P_c for all contacts at each X, so '
            'that single contacts have no law of their own; use closure = "exact", or ask '
            "steady_state or critical_velocity, which take it"
        )
    if contacts.thermal is not None and contacts.thermal.closure == "paper":
        raise InputError(
            'contacts.thermal: closure = "paper" averages the rate over one P_c for all contacts, '
            'and those that age have no such law; use closure = "exact"'
        )
