"""Which life the laws of some contacts make."""

from __future__ import annotations

from master.lives.age.forward import ForwardAgeing
from master.lives.age.path import AgeingPath
from master.lives.cold import ColdLife
from master.lives.grains import GrainLife
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from master.lives.warm_grains import WarmGrainLife
from master.motion.motion import Motion
from origins import Contacts, InputError


def life_of(
    contacts: Contacts, velocity: float = 0.0, longest: float = 0.0, accuracy: float = 1e-10
) -> Life | None:
    """The life of these contacts; None where only the old solvers know what is left of them.

    velocity : dX/dt, only asked for by thresholds that age: where it is 0 there is no life of these
    longest : time after which no contact is looked at any more, only asked for by thresholds that
        grow: where it is 0 there is no life of these
    accuracy : of the share that holds, where it is found by steps
    """
    if contacts.grains is not None and longest > 0.0:
        warm = contacts.thermal is not None
        return WarmGrainLife(contacts, longest) if warm else GrainLife(contacts, longest)
    if contacts.ageing is not None and velocity != 0.0:
        check_ageing(contacts)
        return ForwardAgeing(contacts, velocity, accuracy)
    if contacts.ageing is not None or contacts.grains is not None:
        return None
    if contacts.thermal is None:
        return ColdLife(contacts)
    return ThermalLife(contacts) if contacts.thermal.closure == "exact" else MeanRateLife(contacts)


def ageing_life(contacts: Contacts, motion: Motion, accuracy: float) -> Life:
    """The life of contacts that age, closure "exact", on any motion of the slider."""
    check_ageing(contacts)
    if motion.one_leg:
        longest = float(motion.times[-1])
        return ForwardAgeing(contacts, float(motion.speeds[0]), accuracy, longest)
    return AgeingPath(contacts, motion, accuracy)


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
