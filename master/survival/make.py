"""The choice of the Life that belongs to the laws of some contacts."""

import numpy as np

from master.motion import Motion
from master.survival.age.ageing import AgeingLife
from master.survival.grains import GrainLife
from master.survival.heat import RESOLVED, MeanRateLife, ThermalLife
from master.survival.life import ColdLife, Life
from origins import Contacts, InputError
from origins.errors import refuse


def life_of(
    contacts: Contacts, tolerance: float = 0.0, motion: Motion | None = None, until: float = np.inf
) -> Life:
    """The life of these contacts.

    tolerance : of the force, in mean thresholds; 0 where it is not known: to RESOLVED, with ageing to 1e-10
    motion : of the slider; needed for contacts that age or have growing grains
    until : reading of time.monotonic() after which a life is not refined any more

    Raises InputError for the paper's closure of ageing, in which single contacts have no law of their own.
    """
    if contacts.grains is not None:
        assert motion is not None
        return GrainLife(contacts, float(motion.times[-1]))
    if contacts.ageing is not None:
        assert motion is not None
        if contacts.ageing.closure == "paper":
            fault = 'closure = "paper" (Q15) has one P_c for all contacts at each X, and none for single ones'
            hint = 'use closure = "exact", or ask steady_state or critical_velocity, which take it'
            raise InputError(f"contacts.ageing: {fault}; {hint}")
        return AgeingLife(contacts, motion, max(0.2 * tolerance, 1e-10), until)
    # the error of averages is the square of their last coefficients, or near an onset of P_c 1e-3 of them
    resolved = float(np.clip(tolerance, 1e-12, 1e-6)) if tolerance else RESOLVED
    if contacts.thermal is None:
        return ColdLife(contacts, resolved)
    life = MeanRateLife if contacts.thermal.closure == "paper" else ThermalLife
    return life(contacts, resolved)


def steady_life(contacts: Contacts, velocity: float) -> Life:
    """The life of contacts on a slider that moves forward at one speed v > 0, for any time. Raises InputError for
    closures in which single contacts have no law, and where no pinned contact holds."""
    grains, ageing, tolerance = contacts.grains, contacts.ageing, 0.0
    if grains is not None:
        grains.check_speed(velocity)
        lost = grains.lost_hazard(velocity)
        if lost > 300.0:  # a share of e^-300 is close to underflow
            few = f"none holds but a fraction exp(-{lost:.4g})"
            why = "they are stretched before their grains have grown"
            hint = f"{few}: {why}; slide more slowly, and of many speeds leave such ones out"
            refuse("velocity", velocity, hint)
        assert grains.age is not None
        # until even the strongest contacts of the start are broken
        longest, behind = grains.growth.first_pinning_time, max(-contacts.start.span[0], 0.0)
        while float(grains.quantile(1.0, grains.age + longest)) > velocity * longest - behind:
            longest *= 1.5
    elif ageing is not None:
        longest = 1e9 * contacts.mean_threshold / velocity  # they are followed as long as any holds
        if ageing.normal is None or contacts.thermal is not None:
            tolerance = 5e-7  # where strands are followed, smaller errors take too long
    else:
        return life_of(contacts)
    motion = Motion(np.array([0.0, longest]), np.array([0.0, longest * velocity]))
    return life_of(contacts, tolerance, motion)
