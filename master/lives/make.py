"""Which life the laws of some contacts make."""

from __future__ import annotations

import numpy as np

from master.lives.age.ageing import LONGEST, AgeingLife
from master.lives.age.path import AgeingPath
from master.lives.cold import ColdLife
from master.lives.grains import GrainLife
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.replayed import RESOLVED
from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from master.lives.warm_grains import WarmGrainLife
from master.motion.motion import Motion
from origins import Contacts, GrainContact, InputError
from origins.errors import refuse

# Last coefficients of averages over the stretches at birth, in units of the tolerance, and their least
# and most. The averages are off by the square of this, or beside an onset of P_c by some 1e-3 of it.
_RESOLVED, LEAST_RESOLVED, MOST_RESOLVED = 1e-2, 1e-12, 1e-6
# Error of the share that holds of contacts that age, in units of the tolerance, and its least.
_AGED, _FINEST = 0.2, 1e-10
# The same in steady motion where strands are followed: finer ones take long.
_STEPPED = 1e-7
# Largest hazard of growing grains as they pin: e^-300 of them hold, near the end of floating point.
_MOST_LOST = 300.0
# The change of the share that holds of growing grains with heat at which no finer nodes are tried,
# in units of the tolerance, and its least and most.
_WARM, _WARM_ENDS = 0.02, (1e-11, 1e-6)


def life_of(
    contacts: Contacts,
    tolerance: float = 0.0,
    motion: Motion | None = None,
    until: float = np.inf,
) -> Life:
    """The life of these contacts.

    tolerance : of the force, in mean thresholds; 0: what is left is known as well as can be
    motion : of the slider; contacts that age have no life that does not ask it
    until : reading of time.monotonic() after which a life is known as well as it is by then
    """
    if contacts.grains is not None:
        assert motion is not None
        if contacts.thermal is None:
            return GrainLife(contacts, float(motion.times[-1]))
        accuracy = float(np.clip(_WARM * tolerance, *_WARM_ENDS))
        return WarmGrainLife(contacts, float(motion.times[-1]), accuracy)
    if contacts.ageing is not None:
        assert motion is not None
        check_ageing(contacts)
        accuracy = max(_AGED * tolerance, _FINEST)
        return (AgeingLife if motion.one_leg else AgeingPath)(contacts, motion, accuracy, until)
    if contacts.thermal is None:
        return ColdLife(contacts)
    resolved = (
        min(max(_RESOLVED * tolerance, LEAST_RESOLVED), MOST_RESOLVED) if tolerance else RESOLVED
    )
    life = MeanRateLife if contacts.thermal.closure == "paper" else ThermalLife
    return life(contacts, resolved)


def steady_life(contacts: Contacts, velocity: float) -> Life:
    """The life of contacts on a slider that moves forward at one speed v > 0, for any time.

    Raises InputError where contacts have no law each by itself, and where none holds that pins.
    """
    if contacts.grains is not None:
        _check_some_hold(contacts.grains, velocity)
        longest = _outlived(contacts, velocity)
        if contacts.thermal is None:
            return GrainLife(contacts, longest)
        return WarmGrainLife(contacts, longest, _WARM_ENDS[0])
    if contacts.ageing is not None:
        check_ageing(contacts)
        closed = contacts.ageing.normal is not None and contacts.thermal is None
        laws = contacts.thresholds, contacts.ageing.final
        way = LONGEST * max(float(law.isf(1e-17)) for law in laws)
        motion = Motion(np.array([0.0, way / velocity]), np.array([0.0, way]))
        return AgeingLife(contacts, motion, _FINEST if closed else _STEPPED)
    return life_of(contacts)


def _check_some_hold(grains: GrainContact, velocity: float) -> None:
    """Refuse speeds at which so few of the contacts that pin hold that their lives are no numbers."""
    grains.check_speed(velocity)
    lost = grains.lost_hazard(velocity)
    if lost > _MOST_LOST:
        few = f"none holds but a fraction exp(-{lost:.4g})"
        why = "they are stretched before their grains have grown"
        rule = f"{few}: {why}; slide more slowly, and of many speeds leave such ones out"
        refuse("velocity", velocity, rule)


def _outlived(contacts: Contacts, velocity: float) -> float:
    """A time after which even the strongest contacts of the start, whose grains grow, are broken."""
    grains = contacts.grains
    assert grains is not None and grains.age is not None
    longest, behind = grains.growth.first_pinning_time, max(-contacts.start.span[0], 0.0)
    while float(grains.quantile(1.0, grains.age + longest)) > velocity * longest - behind:
        longest *= 1.5
    return longest


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
