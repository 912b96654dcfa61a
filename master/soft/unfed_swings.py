"""Slips of a slider with mass that are swings of its start: nothing feeds them, so that they tell of no stick-slip."""

import numpy as np

from master.soft.slips import Slips
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array

# Part of the time of a free swing within which slips follow each other where they are swings: a contact that breaks or
# holds at a turn hardly changes it, while a slider that sticks waits there for the drive.
OF_A_SWING = 0.05
# Part by which the damping lessens a free swing from one to the next, of which swings that nothing feeds fade by the
# larger part.
OF_FADING = 0.5


def unfed_swings(
    contacts: Contacts,
    drive: Drive,
    slips: Slips,
    critical: float,
    speeds: Array,
    trend: float | None,
) -> str:
    """Why slips that do not fade are swings about F_k that nothing feeds, in words; "" where they may be others.

    critical, speeds, trend : K*, the drive's speeds, and the relative change of the drop from one slip to the next
    At T = 0 contacts that form at once pull by F_k however fast the slider is, once they have forgotten how they began.
    A mass that set out at rest then swings freely, without damping for ever: up to twice as fast as the drive, and down
    to where it nearly stops. Exact thresholds forget nothing. Above K*, `critical`, no slip begins by itself; on softer
    springs a slider that sticks waits at each turn. Where contacts might feed a swing its damping tells: one that fades
    as fast as that alone lets it is not fed.
    """
    mass, spring, damping = drive.mass, float(drive.spring or 0.0), drive.damping
    if mass is None:
        return ""
    speed = float(np.abs(speeds).max(initial=0.0))
    swing = 2.0 * np.pi * speed * (mass / spring) ** 0.5
    freely = slips.period is not None and abs(slips.period - swing) <= OF_A_SWING * swing
    freely &= bool(np.ptp(np.abs(speeds[speeds != 0.0])) <= 1e-9 * speed) if speed else False
    forget = not contacts.in_time and not contacts.thresholds.atoms[0].size
    if forget and _before_a_turn(drive, slips) and (spring >= critical or freely):
        why = "which contacts that form at once do not feed"
    elif freely and trend is not None and trend <= OF_FADING * _fading(mass, damping, spring) < 0.0:
        why = "which fade as the damping alone lets them"
    else:
        return ""
    ends = "without damping nothing ends them: give one"
    if damping:
        way = 2.0 * mass / damping * speed
        ends = f"the damping lessens them by e on each {way:.3g} of the drive: drive farther"
    return f"they are swings of the mass about F_k, {why}; {ends}"


def _fading(mass: float, damping: float, spring: float) -> float:
    """Relative change of a weakly damped free swing from one to the next, below 0."""
    return float(np.expm1(-np.pi * damping / (mass * spring) ** 0.5))


def _before_a_turn(drive: Drive, slips: Slips) -> bool:
    """Whether all slips come before the drive turns, if it does."""
    steps = np.diff(drive.path, prepend=0.0)
    moves = steps[steps != 0.0]
    back = np.flatnonzero(steps * moves[0] < 0.0)
    if not back.size:
        return True
    way = np.sign(moves[0])
    ahead = way * slips.drive <= way * drive.path[back[0] - 1]
    return bool((ahead & (way * slips.drop > 0.0)).all())
