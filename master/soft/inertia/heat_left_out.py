"""Whether slips of a slider with mass hang on heat that is left out, and changes the force by `effect` at most.

Where contacts form again at once F is a function of X at T = 0. Heat may take away a slip in which F + K X falls by
twice the effect or less; so weak a pull moves the spring's force by no more than a few times that, and the bound, some
six times the true effect or more (OF_BOUND), holds it. That is an argument and no proof. Ensembles of few contacts slip
late, by as much without heat: of 52 machines on springs close to K* those in heat and without it differed by at most
half the bound (1e-5 <= T <= 4e-4 <x_s>²). But heat moves the slip's begin: F that is lower by the effect meets the
drive earlier by effect/K, and in a slip the spring's force falls V/v times as fast as it rises (`beside_slips`).

With a delay contacts let go in a slip, and F falls to 0 however small the fall at its begin: all hangs on that. Then

- a slider that does not slip goes on at the drive's speed: where the load of a rigid one falls at that speed from the
  force at which the slip begins by more than twice the effect, it slips in heat, too;
- where that load rises all the way by more than heat changes its slope none slips;
- else rigid sliders in heat are asked (`soft/first_fall.py`), as for a slider without mass. They tell of new contacts,
  and so of slips that begin at the same force as the first.
"""

from typing import NamedTuple

import numpy as np

from master.soft.cold_contacts import ColdContacts
from master.soft.first_fall import path_beyond, rigid_slider, slips_alike
from master.soft.inertia.run import Run, SlipsInTime
from master.soft.inertia.short_delay import fastest_of
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Tolerance of the contacts whose steepest change is asked for, in mean thresholds: any will do.
TOLERANCE = 1e-6
# Part of the bound by which heat changes F where slips begin. Of 58 random machines (soft and stiff heat, T from 1e-6
# to 5e-4 <x_s>², 1e4 to 1e14 attempts, seven laws of thresholds) a rigid slider at the speed of a stuck one has there a
# change of 0.15 of the bound at most, and 0.08 as a rule.
OF_BOUND = 0.25


def heat_decides(
    in_heat: Contacts, drive: Drive, slips: SlipsInTime, place: Array, effect: float, until: float
) -> bool:
    """Whether heat that was left out may take away a slip of contacts with a delay, or bring one about.

    in_heat : the contacts with it; slips, place : without it, and X at the path's points (n,); effect : a length
    until : as in `solve`
    """
    if not in_heat.waiting_time:
        return False
    cold, spring = in_heat.replace(thermal=None), float(drive.spring or 0.0)
    begins, force = np.abs(slips.before), np.abs(slips.force_before)
    travel = float((begins[:1] if begins.size else np.abs(place)).max())
    path = path_beyond(in_heat, travel)
    length = ColdContacts(cold, spring, TOLERANCE, until).break_length
    for contacts in (cold, cold.replace(start=None)):  # as they start, and new ones
        rigid = rigid_slider(contacts, path, fastest_of(drive), until)
        if rigid is None:
            return True
        load = rigid.force + spring * path
        falls = float((np.maximum.accumulate(load) - load).max())
        lower = max(float(rigid.force.max()) - float(force.min(initial=np.inf)), 0.0)
        rises = float(np.gradient(load, path).min())
        if falls - lower <= 2.0 * effect and rises <= 2.0 * effect / length:
            alike = 2.0 * (effect + slips.force_error * in_heat.mean_threshold)
            new = in_heat.start.span == (0.0, 0.0) and drive.time is None
            new &= float(np.abs(force - force[:1]).max(initial=0.0)) <= alike
            many = bool(begins.size)
            return not (new and slips_alike(in_heat, drive, travel, many, effect, until))
    return False


class BesideSlips(NamedTuple):
    """What heat that was left out changes at points of the path beside slips, at most (lengths): in the force of the
    spring, and in that of the contacts."""

    force: float
    contact_force: float


def beside_slips(run: Run, drive: Drive, effect: float) -> BesideSlips:
    """The same where F changes by OF_BOUND of `effect` at most (a length): as a change of X_T by 1/K of that, which the
    drive passes at its speed there, at most in all its time; and so much later or earlier a slip begins.

    In that time the spring's force falls at K V, by all of the slip at most; V is the top speed of the slip, and while
    contacts wait after it that at the point. The contacts' force goes with the begin of a slip.
    """
    slips, spring, record = run.slips(0.0), float(drive.spring or 0.0), run.record
    times, count = np.append(0.0, record.times), run.force.size
    ways, lasts = np.abs(np.diff(drive.path, prepend=run.balance)), np.diff(times)
    leg = np.clip(np.searchsorted(times, slips.time) - 1, 0, lasts.size - 1)
    moved, late = OF_BOUND * effect / spring * lasts[leg], float(times[-1])
    apart = np.divide(moved, ways[leg], out=np.full(leg.size, late), where=moved < late * ways[leg])
    at, speed = record.times[:count, None], np.abs(record.speed[:count, None])
    ends = slips.time + slips.duration + apart
    inside = (at >= slips.time - apart) & (at <= ends + run.waits)
    fastest = np.where(at > ends, speed, np.abs(slips.top_speed))
    falls = np.minimum(spring * fastest * apart, np.abs(slips.drop))
    force = float(np.where(inside, falls, 0.0).max(initial=0.0))
    return BesideSlips(force, max(force, run.unknown_hold(slips, apart)))
