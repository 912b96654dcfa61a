"""Sliders whose contacts heat breaks, and which go on too slowly for steps in time: steady sliding tells of them.

Such a slider slides smoothly in the end where steady sliding at the drive's speed v is stable, with its mass and
damping (master/steady/with_mass.py), and where at speeds from K v/(N_c<k> + K), at which a slider that sticks stretches
its contacts, to FASTEST_LOOKED_AT v one of both holds:

    nothing slips   the force that a rigid slider reaches from relaxed contacts on, F_s, is above F_k at its own and at
                    each higher speed by less than the fall that counts as a slip, RISE <x_s>. F_s at its own speed
                    alone does not tell: where F_k falls with the speed, as contacts that break late are left at low
                    ones, a slow slider that slides steadily bears more than a fast one, and slips
    heat is weak    it changes F_k and F_s by less than that fall; and the slider on contacts without it, which is
                    followed, slides smoothly, mostly after a slip
    heat steadies   F_k rises with the speed, and F_s is above it by no more than without heat: a slip in heat falls by
                    less, and is braked by more, than one of the slider without it, which is followed as above. An
                    example: samples of MD of 4 nN at 300 K, T = 2.2e-3 <x_s>^2. F_k rises from 0.485 to 0.521 <x_s> in
                    six decades, and F_s is above it by 0.039 to 0.053, without heat by 0.074

The force in the end is F_k in heat, with what the damping bears. What was not followed is told beside it: the way up to
there, or what heat changes on it.
"""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from origins.contacts import Contacts
from origins.drive import RISE
from origins.errors import InputError
from toolkit.verdict.sliders.machine import Machine, RigidSlider, rigid_slider
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.sliders.steady import settling_distance

# times the drive's speed: a mass that swings about it moves at up to twice as much
FASTEST_LOOKED_AT = 3.0
# tolerance of F_s, which is held against RISE
ROUGHLY = 1e-3
# slip rules, and "mass", under which a slider whose first slips are over slides; the others renew all contacts
SLIDES = ("mass", "instant")


def by_steady_sliding(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    rigid: RigidSlider,
    until: float,
    without_heat: Callable[[Contacts, RigidSlider], Behaviour],
) -> Behaviour | None:
    """What the slider does in the end, where steady sliding tells it by then, in s of the monotonic clock; None where
    it does not. `without_heat` : follows the slider on these contacts, of which so much is known."""
    from master.steady.response import has_response
    from master.steady.with_mass import sliding_is_stable

    unit, law = contacts.mean_threshold, contacts.thresholds
    alone = has_response(contacts) and contacts.changing is None and not law.atoms[0].size
    if not alone or not np.isfinite(settling_distance(machine, unit)):
        return None
    spring, speed, small = machine.spring, machine.velocity, RISE * unit
    try:
        if not sliding_is_stable(contacts, speed, spring, machine.mass or 0.0, machine.damping):
            return None
        each = [rigid_at(contacts, one, rigid.contacts, until) for one in looked_at(machine)]
        kinetic = np.array([one.kinetic for one in each])
        falls = np.maximum.accumulate([one.static for one in each]) - kinetic
        if falls.max() < small:
            return _at_kinetic(not_followed(rule, ""), machine, rigid, unit, 0.0)
        bare = contacts.replace(thermal=None)
        cold = rigid_at(bare, speed, rigid.contacts, until)
        off = max(
            max(abs(one.kinetic - cold.kinetic), abs(one.static - cold.static)) for one in each
        )
        steadies = bool(
            (np.diff(kinetic) > 0.0).all() and falls.max() <= cold.static - cold.kinetic
        )
        if rule not in SLIDES or not (off <= small or steadies):
            return None
        found = without_heat(bare, cold)
    except InputError:
        return None
    sure = found.kind == "smooth" and found.success and found.contacts is None
    return _at_kinetic(found, machine, rigid, unit, off) if sure else None


def with_stability(found: Behaviour, machine: Machine, contacts: Contacts) -> Behaviour:
    """This slider, which is not decided and was not seen to slip, or slides smoothly, with the springs below which
    steady sliding is unstable, where that is known."""
    from master.steady.response import has_response
    from master.steady.with_mass import unstable_below

    exact = bool(contacts.thresholds.atoms[0].size)
    # where steady sliding tells of it that is stable
    open_yet = found.kind == "undecided" and not found.slips
    slides = found.kind == "smooth" and found.rule in SLIDES and found.heat_on_the_way is None
    if not (open_yet or slides) or exact or not has_response(contacts):
        return found
    speed, mass = machine.velocity, machine.mass or 0.0
    damping = machine.damping if found.damping is None else found.damping
    below = unstable_below(contacts, speed, machine.spring, mass, damping)
    return replace(found, unstable_below=below)


def looked_at(machine: Machine) -> list[float]:
    """Speeds at which forces are looked at, one a decade, upwards: from that of contacts which the drive stretches on a
    slider that sticks, to beyond that of a mass that swings about the drive's."""
    slowest, speed = machine.spring / (1.0 + machine.spring) * machine.velocity, machine.velocity
    decades = np.arange(int(np.ceil(np.log10(speed / slowest))))
    return [*(slowest * 10.0**decades), speed, FASTEST_LOOKED_AT * speed]


def _at_kinetic(
    found: Behaviour, machine: Machine, rigid: RigidSlider, unit: float, off: float
) -> Behaviour:
    """This slider as it slides on in heat, at F_k and what the damping bears."""
    force = rigid.kinetic + machine.damping * machine.velocity
    told = Behaviour(
        rule=found.rule,
        kind="smooth",
        before=force,
        after=force,
        period=None,
        slips=found.slips,
        smaller=found.smaller,
        error=rigid.kinetic_error / unit,
        success=True,
        message=found.message,
        run_time=found.run_time,
        heat_on_the_way=off / unit,
        # the way up to there, and how slips died out on it; a first slip would be that of contacts without heat
        shrinks_by=found.shrinks_by,
        swings=found.swings,
        drive=found.drive,
        force=found.force,
    )
    return told.in_place_of(found)


def rigid_at(
    contacts: Contacts, velocity: float, number: float | None, until: float
) -> RigidSlider:
    """A rigid slider on relaxed contacts at this speed; `number` : of contacts on the area. Raises InputError once the
    time is over, or where F_k and F_s are not known."""
    import master

    if time.monotonic() > until:
        raise InputError("wall_time is used up")
    steady = master.steady_state(contacts, velocity=velocity)
    found = master.propensity(contacts, velocity=velocity, tolerance=ROUGHLY)
    if not (steady.success and np.isfinite(found.static_to_kinetic)):
        raise InputError("F_k and F_s are not known")
    return rigid_slider(contacts, steady, found, number)
