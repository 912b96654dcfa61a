"""Slips of a slider with mass that are swings of its start: nothing feeds them, so that they tell of no stick-slip."""

import numpy as np

from master.soft.slips import Slips
from origins import Contacts
from origins.drive import Drive

# Part of the time of a free swing within which slips follow each other where they are swings: a contact that breaks or
# holds at a turn hardly changes it, while a slider that sticks waits there for the drive.
OF_A_SWING = 0.05


def unfed_swings(contacts: Contacts, drive: Drive, slips: Slips, critical: float) -> str:
    """Why slips that do not fade are swings about F_k that nothing feeds, in words; "" where they may be others.

    At T = 0 contacts that form at once pull by F_k however fast the slider is, once they have forgotten how they began.
    A mass that set out at rest then swings freely, without damping for ever: up to twice as fast as the drive, and down
    to where it nearly stops. Exact thresholds forget nothing. Above K*, `critical`, no slip begins by itself; on softer
    springs a slider that sticks waits at each turn.
    """
    mass, spring = drive.mass, float(drive.spring or 0.0)
    if mass is None or contacts.in_time or contacts.thresholds.atoms[0].size or not drive.forward:
        return ""
    swing = 2.0 * np.pi * drive.velocity * (mass / spring) ** 0.5
    freely = slips.period is not None and abs(slips.period - swing) <= OF_A_SWING * swing
    if spring < critical and (drive.time is not None or not freely):
        return ""
    ends = "without damping nothing ends them: give one"
    if drive.damping:
        way = 2.0 * mass / drive.damping * drive.velocity
        ends = f"the damping lessens them by e on each {way:.3g} of the drive: drive farther"
    return f"they are swings of the mass about F_k, which contacts that form at once do not feed; {ends}"
