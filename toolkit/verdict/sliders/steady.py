"""Whether a slider with mass whose contacts wait slides on once it slides, and when its swings have died away, by
closed forms.

Contacts form anew a delay τ after they break: at the speed v a share h = 1/(1 + τ v/<x_s>) of them holds, and bears
F_k(v) = h <x_s²>/2<x_s>.
"""

import numpy as np

from origins.contacts import Contacts
from toolkit.verdict.sliders.machine import Machine, half_a_swing

# swing of the spring's force, in mean thresholds, that may be left where sliding is called smooth; and after how many
# time constants one has died away, e^-10
SWINGS, SETTLING = 0.01, 10.0


def friction_falls(machine: Machine, contacts: Contacts) -> float:
    """By how much F_k falls with the speed, -dF_k/dv per N_c<k> (a time), at that of the drive; 0 without a delay."""
    waits, mean = contacts.waiting_time, contacts.mean_threshold
    square = contacts.thresholds.moment(2)
    return float(0.5 * waits * square / (mean + waits * machine.velocity) ** 2)


def friction_decides(machine: Machine, contacts: Contacts) -> bool:
    """Whether swings of the mass grow just where friction falls with the speed by more than the damping rises: they
    pass thresholds, as the drive goes on by <x_s> or more in half of one, and no law of the contacts but a delay, or
    heat that is left out, acts on friction."""
    laws = {*contacts.held_in_time} - {"thermal"}
    if not machine.mass or laws or contacts.reforming is not None or contacts.stiffness == "linked":
        return False
    passes = half_a_swing(machine) * machine.velocity >= contacts.mean_threshold
    return bool(passes and np.isfinite(contacts.thresholds.moment(2)))


def unstable_delays(machine: Machine, contacts: Contacts) -> tuple[float, float] | None:
    """The delays of contacts else like these, without heat, between which friction at the drive's speed v falls with
    the speed by more than the damping γ rises; up to inf without one. None where no delay does so, and where friction
    does not decide, see `friction_decides`.

    With the delay u <x_s>/v it falls by F u/v (1 + u)², F = <x_s²>/2<x_s>, which is γ at both roots of
    u² - (F/γv - 2) u + 1; their product is 1. A damping of F/4v or more is above it for all u.
    """
    if not friction_decides(machine, contacts):
        return None
    if not machine.damping:
        return 0.0, float(np.inf)
    mean = contacts.mean_threshold
    force = 0.5 * contacts.thresholds.moment(2) / mean
    both = force / (machine.damping * machine.velocity) - 2.0
    if both <= 2.0:
        return None
    larger = 0.5 * (both + np.sqrt(both**2 - 4.0))
    unit = mean / machine.velocity
    return float(unit / larger), float(unit * larger)


def is_stable_with_delay(machine: Machine, contacts: Contacts) -> bool:
    """Whether steady sliding at the drive's speed is known to be stable against slow changes of the speed.

    Such swings of the mass do not grow where γ is above -dF_k/dv, as long as they pass thresholds: the drive goes on by
    <x_s> or more in half of one. Quicker ones may grow all the same, and stay far smaller than slips. Nor do volleys of
    contacts grow that broke together and come back together: unlike thresholds scatter them, by σ² = var(x_s) in each
    life, and the slider, which goes on faster while fewer hold it, gathers them by h <x_s²>/K, so that they draw apart
    where K is above h <x_s²>/σ². False also where more than a delay acts.
    """
    only_wait = not (contacts.held_in_time or contacts.reforming is not None)
    if not (machine.mass and contacts.waiting_time and only_wait) or contacts.stiffness == "linked":
        return False
    mean, square = contacts.mean_threshold, contacts.thresholds.moment(2)
    variance = square - mean**2
    share = mean / (mean + machine.velocity * contacts.waiting_time)
    passes = half_a_swing(machine) * machine.velocity >= mean
    apart = machine.spring * variance > share * square
    return bool(
        passes
        and apart
        and np.isfinite(square)
        and machine.damping > friction_falls(machine, contacts)
    )


def settling_distance(machine: Machine, unit: float) -> float:
    """The drive's way in which the swing of a mass that slides on at F_k dies away: SETTLING time constants of
    M X'' + γ X' + K X = 0, inf without damping; 0 where a swing of a speed like the drive's changes the spring's
    force by less than SWINGS of the mean threshold `unit`."""
    if machine.mass is None:
        return 0.0
    swing = machine.velocity * (np.sqrt(machine.mass * machine.spring) + machine.damping)
    if swing < SWINGS * unit:
        return 0.0
    return SETTLING * time_constant(machine) * machine.velocity


def time_constant(machine: Machine) -> float:
    """In which the swing of a mass that slides on at F_k falls by e (a time); inf without damping, 0 without a mass."""
    if not machine.mass:
        return 0.0
    if not machine.damping:
        return float(np.inf)
    # of the slower root; beyond critical damping that is about K/γ, else both have the real part γ/2M
    beyond = max(machine.damping**2 - 4.0 * machine.mass * machine.spring, 0.0)
    slower = 2.0 * machine.spring / (machine.damping + np.sqrt(beyond))
    return float(1.0 / min(slower, 0.5 * machine.damping / machine.mass))
