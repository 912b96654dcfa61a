"""Delays so short beside the slips of a slider with mass that following it is hopeless: told before the work."""

import numpy as np

from master.soft.inertia.delayed.panel_search import MOST_PANELS
from origins import Contacts
from origins.drive import Drive
from origins.errors import refuse

# Panels between two volleys of contacts that form and break together, one delay apart: 2 to 90 were seen on 12 paths,
# so that the forecast is an estimate, and no bound.
OF_A_VOLLEY = 20.0
# A swing is slow from so many times the delay and the passing of a threshold on; and swings have grown after so many
# times M over the fall of F_k.
SLOW, GROWN = 10.0, 100.0


def slip_time(mass: float, damping: float, spring: float) -> float:
    """About how long a slip lasts until its swings are no longer than a threshold; all three per N_c<k>."""
    if damping == 0.0:
        return np.inf
    apart = np.sqrt(max(damping**2 - 4.0 * mass * spring, 0.0))
    fading = 2.0 * spring / (damping + apart) if apart else 0.5 * damping / mass
    return float(np.pi * np.sqrt(mass / spring) + max(-np.log(spring), 0.0) / fading)


def refuse_short_delay(contacts: Contacts, drive: Drive) -> None:
    """InputError where sliding is surely unstable at the drive's speed v, and swings would take too many panels.

    Steady sliding has F_k(v) = F_k/(1 + v tau/<x_s>). Where that falls faster than the damping rises, swings that are
    slow beside the delay and the passing of a threshold grow (docs/sliders.md). From relaxed contacts F is at most
    <x_s^2>/<x_s>, by Lorden's inequality of renewal theory: beyond that the slider has moved as far as its drive.
    Panels are no wider than the delay, or take a threshold each.
    """
    law, unit, spring = contacts.thresholds, contacts.mean_threshold, float(drive.spring or 0.0)
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
    if not (relaxed and drive.forward and contacts.stiffness == "independent"):
        return
    mass, delay = float(drive.mass or 0.0), contacts.waiting_time
    kinetic = 0.5 * law.moment(2) / unit
    latest, times = 2.0 * kinetic / spring, drive.arrival_times(0.0)
    if not latest < drive.path[-1]:
        return
    left = float(times[-1] - np.interp(latest, drive.path, times))
    speed = float(drive.path[-1] - latest) / left if left > 0.0 else np.inf
    falls = kinetic * delay / unit / (1.0 + speed * delay / unit) ** 2
    swing = float(np.pi * np.sqrt(mass / spring))
    slow = swing > SLOW * max(delay, unit / speed)
    if not (slow and falls > 2.0 * drive.damping and left > GROWN * mass / falls):
        return
    lasts = min(slip_time(mass, drive.damping, spring), left)
    panels = min(OF_A_VOLLEY * lasts / delay, speed * left / unit)
    if panels > MOST_PANELS:
        fault = f"contacts break and form too often in a slip of some {lasts:.2g}, on about {panels:.0e} panels of time"
        hint = f"take eq_model.simulate, end the path before {latest:.4g}, or leave the mass out and give a slip rule"
        refuse("delay", delay, f"{fault}, of which at most {MOST_PANELS:,} are followed; {hint}")
