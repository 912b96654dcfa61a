"""How far a slider is pulled, and how often its contacts break on the way."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from origins.contacts import Contacts
from toolkit.verdict.sliders.machine import Machine, critical_damping, half_a_swing, slip_duration
from toolkit.verdict.sliders.steady import time_constant

# length of the drive's path in loadings, from no force to the static one, along which sliders are followed first; and
# of a mass on contacts that form again at once in swings beyond one loading, at least, which may be longer
LOADINGS, SWINGS = 6.5, 2.0
# swing of the spring's force to each side, in mean thresholds, below which sliders may be called smooth
SMALL = 0.15


@dataclass(frozen=True)
class PlannedDrive:
    """The drive's travel for sliders of some contacts (a length), and the breaks of all of them on it, at most."""

    end: float
    breaks: float


def loading_of(machine: Machine, contacts: Contacts, static: float) -> float:
    """The drive's way from no force to `static`, F_s/(N_c <k>) (a length), and until contacts that broke in a slip bear
    the slider again."""
    return (
        static / machine.spring + contacts.mean_threshold + way_without_contacts(machine, contacts)
    )


def first_way(machine: Machine, contacts: Contacts, loading: float) -> float:
    """How far sliders of some contacts are pulled first (a length), `loading` being the way up to the static force; of
    a damped mass on contacts that form again at once until the swing with which it begins has died away to SMALL."""
    swings = SWINGS * way_of_a_swing(machine, contacts)
    if swings and machine.damping:
        begins = machine.velocity * (
            np.sqrt(machine.spring * (machine.mass or 0.0)) + machine.damping
        )
        dies = np.log(max(begins / (SMALL * contacts.mean_threshold), 1.0))
        swings = max(swings, float(dies) * time_constant(machine) * machine.velocity)
    return max(LOADINGS * loading, loading + swings)


def way_of_a_swing(machine: Machine, contacts: Contacts) -> float:
    """The drive's way during a swing of a mass whose contacts form again at once (a length); 0 of those that wait, for
    which it is a part of `way_without_contacts`."""
    return 0.0 if contacts.waiting_time else 2.0 * machine.velocity * half_a_swing(machine)


def way_without_contacts(machine: Machine, contacts: Contacts) -> float:
    """The drive's way while contacts wait and the mass, which they do not hold, swings once (a length): 0 without a
    delay. On a fast drive it is most of the way from slip to slip."""
    waits = contacts.waiting_time
    return machine.velocity * (waits + 2.0 * half_a_swing(machine)) if waits else 0.0


def lives_in_a_slip(machine: Machine, contacts: Contacts, force: float, way: float) -> float:
    """How often each contact breaks at most while a mass slips from this `force`, F/(N_c <k>) (a length), and swings
    until it rests, or until the drive has gone on by `way`.

    A contact lives for a mean threshold of the slider's way, and then waits for the delay. Damping leaves each swing a
    part of the one before, and friction, which falls as 1/speed where contacts wait for most of the time, takes the
    same energy of each. A mass that the drive carries along swings by v (K M)^(1/2) and
    swings on.
    """
    mean, delay = contacts.mean_threshold, contacts.waiting_time
    carried = machine.velocity * float(np.sqrt((machine.mass or 0.0) * machine.spring))
    force, swings_on = max(force, carried), carried > force
    lasts, part = slip_duration(machine, force), machine.damping / critical_damping(machine)
    left = float(np.exp(-np.pi * part / np.sqrt(1.0 - part**2))) if part < 1.0 else 0.0
    friction = machine.spring * mean * lasts
    swings = delay * force / (delay * force * (1.0 - left) + friction)
    most = way / machine.velocity / lasts
    swings = max(most if swings_on else min(swings, most), 1.0)
    slipped = force / machine.spring * (1.0 + left)
    return swings * slipped / (mean + delay * slipped / lasts)


def breaks_until(end: float, seen: Any, mean: float) -> float:
    """How many breaks all sliders have up to this place of the drive, from those `seen`: as often along the way where
    all have slipped, as a loading is like the one before it; else each contact at every `mean` threshold, as some
    slide."""
    began, seen_to = seen.path[[0, -1]]
    if np.unique(seen.slips.replica).size == seen.forces.shape[0]:
        return float(seen.breaks * (end - began) / (seen_to - began))
    return float(seen.breaks + seen.contacts * (end - seen_to) / mean)
