"""Whether a slider on new contacts first slips in heat where it does without it, by rigid sliders in heat.

A slider slips where the load on its drive, F + K X, begins to fall. While it sticks it moves at K v/(1 + K) at first.
It gets faster up to the slip, where it is so fast that heat breaks nothing. So a rigid slider finds F in heat at each
of some speeds from that first one to the drive's v, two decades apart.

An example: the contacts of a scan, whose thresholds are nearly exponential, on 8e-7 N_c<k>. Without heat F falls by
5.4e-4 <x_s> behind X = 4.39 <x_s>. A bound allows heat to change F by 5e-3. At all speeds from 8e-7 v to v rigid
sliders in heat have the same fall at the same place, from a force that is higher by 2e-4 to 4e-4.
"""

from typing import NamedTuple

import numpy as np

from master.outcome import unheard
from master.rigid import motion_of, solve_rigid
from master.solution import Solution
from master.survival.make import life_of
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Points of a rigid slider's path, its tolerance (mean thresholds), and times its error that a fall of the load counts.
POINTS, TOLERANCE, CLEAR = 1200, 1e-7, 4.0
# Decades between two speeds, at most.
DECADES_APART = 2.0
# The path ends beyond the place that is asked about by this part of it, and beyond a slip by so many mean thresholds.
BEYOND_PART, BEYOND = 0.2, 2.0


class FirstFall(NamedTuple):
    """Where the load of a rigid slider first falls, and F there (lengths); both inf where it falls nowhere."""

    travel: float
    force: float


def slips_alike(
    contacts: Contacts, drive: Drive, travel: float, slips: bool, effect: float, until: float
) -> bool:
    """Whether new contacts, whatever `contacts` begin with, first let the slider slip in heat where they do without it.

    drive : of one speed, with a spring; until : as in `solve`
    travel, slips : without heat it slips first after this travel (a length), or has not slipped up to it
    effect : in heat it is to slip from the same force to this one (a length), or not up to that travel either
    """
    contacts = contacts.replace(start=None)
    spring, speed = float(drive.spring or 0.0), drive.velocity
    slowest = spring / (1.0 + spring)
    many = 2 + int(-np.log10(slowest) / DECADES_APART)
    # a fall that comes later does not matter where it has not slipped
    path = path_beyond(contacts, travel, 0.0 if travel and not slips else BEYOND)
    cold = first_fall(contacts.replace(thermal=None), path, spring, speed, until)
    if cold is None or (not slips and cold.travel <= travel):
        return False
    # the slowest first, as heat has the most time there: one that is not alike decides
    for one in speed * np.geomspace(slowest, 1.0, many):
        hot = first_fall(contacts, path, spring, float(one), until)
        if hot is None or (not slips and hot.travel <= travel):
            return False
        if slips and not abs(hot.force - cold.force) <= effect:
            return False
    return True


def path_beyond(contacts: Contacts, travel: float, beyond: float = BEYOND) -> Array:
    """Points of a rigid slider's path from 0 to a part of this travel (a length) and so many mean thresholds beyond."""
    return np.linspace(0.0, (1.0 + BEYOND_PART) * travel + beyond * contacts.mean_threshold, POINTS)


def rigid_slider(contacts: Contacts, path: Array, velocity: float, until: float) -> Solution | None:
    """F along a path at this speed; None where it is not known to TOLERANCE."""
    drive = Drive(path, velocity)
    motion, _ = motion_of(drive, contacts.mean_threshold)
    life = life_of(contacts, TOLERANCE, motion, until)
    found = solve_rigid(contacts, drive, life, TOLERANCE, unheard, until)
    return found if found.success else None


def first_fall(
    contacts: Contacts, path: Array, spring: float, velocity: float, until: float
) -> FirstFall | None:
    """Where the load of a rigid slider on new contacts first falls along this path, at this speed; None where F is not
    known to TOLERANCE."""
    found = rigid_slider(contacts, path, velocity, until)
    if found is None:
        return None
    load = found.force + spring * path
    highest = np.maximum.accumulate(load)
    least = CLEAR * found.force_error * contacts.mean_threshold
    falls = np.flatnonzero(highest - load > least)
    if not falls.size:
        return FirstFall(np.inf, np.inf)
    at = int(np.argmax(load[: falls[0]]))
    return FirstFall(float(path[at]), float(found.force[at]))
