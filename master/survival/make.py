"""The choice of the Life that belongs to the laws of some contacts."""

import numpy as np

from master.motion import Motion
from master.survival.age.ageing import AgeingLife
from master.survival.grains import GrainLife
from master.survival.heat import COEFFICIENT_LIMIT, MeanRateLife, ThermalLife
from master.survival.life import ColdLife, Life
from origins import Contacts, InputError
from origins.contacts import LAWS
from origins.errors import refuse

# Laws of contacts of which the master equation knows the life.
TAKEN = tuple(law for law in LAWS if law != "strengthening")
# Error of the survival of contacts that age, in tolerances of the force, of which it is one part of several; and the
# least, to which first passages are solved in a time that users wait for.
AGEING_PART, AGEING_FINEST = 0.2, 1e-10
# Power of the density of fresh thresholds at 0 below which panels of the first passage, which follow the breaks right
# after a birth, would have to be shorter than rounding allows (measured).
STEEPEST_ONSET = -0.15
# Largest hazard lost right after pinning, of contacts with growing grains: the survival e^-300 is close to underflow.
MOST_LOST = 300.0
# Longest time for which contacts that age are followed, in mean thresholds divided by the speed: as long as any holds.
LONGEST_AGE = 1e9


def life_of(
    contacts: Contacts, tolerance: float = 0.0, motion: Motion | None = None, until: float = np.inf
) -> Life:
    """The life of these contacts.

    tolerance : of the force, in mean thresholds; 0 where it is not known: as fine as a table needs
    motion : of the slider; needed for contacts that age or have growing grains
    until : reading of time.monotonic() after which a life is not refined any more

    Raises InputError for the paper's closure of ageing, in which single contacts have no law of their own; for ageing
    with heat, towards a law that is not normal, or of fresh thresholds whose density diverges at 0; and for growing
    grains with heat on a motion of several legs.
    """
    if contacts.grains is not None:
        assert motion is not None
        if contacts.thermal is not None and not motion.one_leg:
            fault = "heat beside thresholds that grow is taken at one speed alone, by the master equation"
            instead = "use eq_model.simulate, which takes a rigid slider that turns or rests"
            raise InputError(f"contacts.thermal: {fault}; {instead}")
        return GrainLife(contacts, float(motion.times[-1]))
    if contacts.ageing is not None:
        assert motion is not None
        if contacts.ageing.closure == "paper":
            fault = 'closure = "paper" (Q15) has one P_c for all contacts at each X, and none for single ones'
            hint = 'use closure = "exact", or ask steady_state or critical_velocity, which take it'
            raise InputError(f"contacts.ageing: {fault}; {hint}")
        if refusal := why_no_passage(contacts):
            raise InputError(refusal)
        accuracy = max(AGEING_PART * tolerance, AGEING_FINEST)
        return AgeingLife(contacts, motion, accuracy, until)
    # the error of averages is the square of their last coefficients, or near an onset of P_c 1e-3 of them
    limit = float(np.clip(tolerance, 1e-12, 1e-6)) if tolerance else COEFFICIENT_LIMIT
    if contacts.thermal is None:
        return ColdLife(contacts, limit)
    life = MeanRateLife if contacts.thermal.closure == "paper" else ThermalLife
    return life(contacts, limit)


def why_no_passage(contacts: Contacts) -> str:
    """Why contacts that age have no first passage that can be solved: heat beside it, a final law that is not normal,
    or fresh thresholds whose density diverges at 0. The ensemble takes all of these. "" where there is one."""
    ageing, fresh = contacts.ageing, contacts.thresholds
    if ageing is None:
        return ""
    instead = "use eq_model.simulate, which takes these contacts"
    if contacts.thermal is not None:
        fault = "on a rigid slider the master equation takes no heat beside ageing"
        return f"contacts.thermal: {fault}; leave one out, or {instead}"
    if ageing.normal is None:
        fault = "on a rigid slider the master equation takes ageing towards a gaussian law alone"
        return f"contacts.ageing: final is no gaussian, and {fault}; {instead}"
    # breaks right after a birth diverge as the density does
    if fresh.support()[0] == 0.0 and fresh.onset_power < STEEPEST_ONSET:
        power = f"as x^{fresh.onset_power:.3g}"
        fault = (
            f"their density diverges at 0 {power}, where contacts that age break as they are born"
        )
        return f"contacts.thresholds: {fault}; {instead}"
    return ""


def steady_life(contacts: Contacts, velocity: float) -> Life:
    """The life of contacts on a slider that moves forward at one speed v > 0, for any time. Raises InputError for
    closures in which single contacts have no law, and where no pinned contact holds."""
    grains = contacts.grains
    if grains is not None:
        grains.check_speed(velocity)
        lost = grains.lost_hazard(velocity)
        if lost > MOST_LOST:
            few = f"none holds but a fraction exp(-{lost:.4g})"
            why = "they are stretched before their grains have grown"
            hint = f"{few}: {why}; slide more slowly, and of many speeds leave such ones out"
            refuse("velocity", velocity, hint)
        assert grains.age is not None
        # until even the strongest contacts of the start are broken
        longest = grains.growth.first_pinning_time
        to_0 = max(-contacts.start.span[0], 0.0)  # distance that the start has to go to x = 0
        while float(grains.quantile(1.0, grains.age + longest)) > velocity * longest - to_0:
            longest *= 1.5
    elif contacts.ageing is not None:
        longest = LONGEST_AGE * contacts.mean_threshold / velocity
    else:
        return life_of(contacts)
    motion = Motion(np.array([0.0, longest]), np.array([0.0, longest * velocity]))
    return life_of(contacts, motion=motion)
