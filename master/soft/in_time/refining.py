"""Refining: the whole path solved with steps halved each time, and extrapolated.

Errors of the answers fall about as the square of the step, faster with ageing, more slowly where thresholds grow
or births jump; all are extrapolated to step 0 as if by the square. The error estimate is three times, with ageing
once, the last change of the extrapolated or of the plain answers, whichever is smaller, plus the error of the contacts'
memory and rounding, or what the steps do not resolve if that is larger. Steps are halved until force and holding are
both known; the error of the force, and of the load at slips, is claimed.
"""

import time
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master.motion import drive_motion
from master.outcome import Progress, StoppedError
from master.soft.in_time.changing import MEMORIES
from master.soft.in_time.cohorts import MOST_STEPS, MOST_WORK, Cohorts
from master.soft.in_time.idle_heat import unresolved_heat
from master.soft.in_time.memory import MeanRateMemory, Memory
from master.soft.in_time.near_slip import slip_undecided
from master.soft.in_time.reading import read
from master.soft.in_time.slider import Slider
from master.soft.in_time.steps import CONTROL
from master.soft.regime import Followed, slips_of
from origins import Contacts, Drive
from origins.errors import refuse
from origins.thresholds.law import Array

# Sliders that an error estimate takes, each with its steps halved once more: answers, their changes, and the
# change of the extrapolated ones.
COMPARED = 3
# Errors fall by 4 with each halving as the square of the steps: 1/3 of the last change is left, and is added.
REST_OF_CHANGE = 1.0 / 3.0
# Instants at which the error is looked for beside the points of the path: few points would hardly tell it.
INSTANTS = 65
# A drive that begins this near the balance, in mean thresholds, begins there: the difference is rounding.
AT_BALANCE = 1e-12
# Slips in which F changes by less than this part of the tolerance are not listed.
UNLISTED = 1.0 / 3.0
# Rounding of the force in one step, in mean thresholds.
ROUNDING = 1e-13
# The next halving takes twice the steps, each of which has twice the groups; and errors below this many times that of
# the memory are not made smaller by it.
MORE_STEPS, MORE_WORK, NEAR_MEMORY_ERROR = 2.0, 4.0, 2.0


def memory_of(contacts: Contacts, halvings: int, fastest: float) -> Memory:
    """The memory of contacts on a drive of at most this speed; its meshes are halved as often as the steps."""
    for law, made in MEMORIES.items():
        if isinstance(contacts.changing, law):
            return made(contacts, halvings, fastest)
    if contacts.thermal is not None and contacts.thermal.closure == "paper":
        return MeanRateMemory(contacts, halvings)
    return Memory(contacts, halvings)


def balance_of(contacts: Contacts, drive: Drive) -> float:
    """X_T = F(0)/K, where the drive begins (a length); refuses a path in time that begins elsewhere."""
    start = Cohorts(contacts, memory_of(contacts, 0, 1.0), 0, np.inf)
    balance = start.force / float(drive.spring or 0.0)
    if abs(drive.path[0] - balance) <= AT_BALANCE * contacts.mean_threshold:
        return float(drive.path[0])
    if drive.time is not None and drive.time[0] == 0.0:
        hint = f"at time 0 the drive stands where it balances the start, {balance:.9g}"
        refuse("path[0]", drive.path[0], hint)
    return balance


def refined(
    contacts: Contacts,
    drive: Drive,
    balance: float,
    tolerance: float,
    progress: Progress,
    until: float,
) -> Followed:
    """Slips, and force and holding at the points of the path, on finer and finer steps.

    until : reading of time.monotonic() at which to stop

    Raises InputError where the coarsest steps take too long.
    """
    if time.monotonic() <= until:
        refuse_long_slides(contacts, drive)
    motion, asked = drive_motion(drive, balance), drive.arrival_times(balance)
    fastest = 0.0 if motion is None else float(np.abs(motion.speeds).max())
    sliders, best, halvings = list[Slider](), None, 0
    while True:
        memory = memory_of(contacts, halvings, fastest)
        cohorts = Cohorts(contacts, memory, halvings, until)
        slider = Slider(cohorts, drive, motion, UNLISTED * tolerance * contacts.mean_threshold)
        try:
            slider.run()
        except StoppedError as why:
            if best is None:
                if time.monotonic() <= until:
                    refuse("path[-1]", drive.path[-1], f"{why}; end the path sooner")
                asked = asked[asked <= cohorts.now]
                best = extrapolated([slider], contacts, drive, balance, asked)
            return best._replace(stopped_because=str(why))
        # only sliders with the same number of slips can be compared
        sliders = [*(one for one in sliders[-2:] if len(one.slips) == len(slider.slips)), slider]
        found = extrapolated(sliders, contacts, drive, balance, asked)
        progress(found.error)
        if best is None or found.largest_error <= best.largest_error:
            best = found
        steps, work = MORE_STEPS * cohorts.steps, MORE_WORK * cohorts.work
        as_good_as_memory = found.largest_error < NEAR_MEMORY_ERROR * memory.error
        too_many = steps > MOST_STEPS or work > MOST_WORK
        if best.largest_error <= tolerance or as_good_as_memory or too_many:
            return best
        halvings += 1


def refuse_long_slides(contacts: Contacts, drive: Drive) -> None:
    """InputError where a slider under "instant" goes with its drive for longer than the coarsest steps may take.

    Only the way of a slip takes no steps. Heat lets F fall less at higher speeds, so that there is one long slip at
    most, before X_T = F/K; from relaxed contacts F is at most <x_s^2>/<x_s>, by Lorden's inequality of renewal theory.
    """
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.stiffness == "independent"
    if drive.slip != "instant" or not (relaxed and contacts.laws == ("thermal",) and drive.forward):
        return
    law, memory = contacts.thresholds, memory_of(contacts, 0, 1.0)
    latest = law.moment(2) / law.mean() / float(drive.spring or 0.0)
    way = float(drive.path[-1]) - latest
    steps = way / (CONTROL.coarsest * memory.scales.length)
    most = MOST_STEPS * 0.5 ** (COMPARED - 1)
    if steps > most:
        goes = f'by {way:.3g} or more with its drive under "instant", in {steps:.2g} steps'
        hint = f"end the path before {latest + way * most / steps:.4g}"
        refuse("path[-1]", drive.path[-1], f"the slider goes {goes}, above {most:.2g}; {hint}")


def extrapolated(
    sliders: list[Slider], contacts: Contacts, drive: Drive, balance: float, asked: Array
) -> Followed:
    """The answer at times (n,) of three sliders with as many slips; of fewer, with an infinite error."""
    unit, spring, points = contacts.mean_threshold, float(drive.spring or 0.0), asked.size
    cohorts, error, error_of_holding = sliders[-1].contacts, np.inf, np.inf
    # rows: time, K X_T, F before and after, see Slider
    slips = [np.array(one.slips).reshape(-1, 4).T for one in sliders]
    instants = [rows[0] for rows in slips]
    asked = np.append(asked, np.linspace(0.0, asked.max(initial=0.0), INSTANTS))
    n = asked.size
    # n forces, n holding fractions, and the three others for each slip; all without a unit
    answers = [
        np.append(read(one.sections, asked) / [[unit], [1.0]], rows[1:] / unit)
        for one, rows in zip(sliders, slips, strict=True)
    ]
    answer = answers[-1]
    if len(sliders) == COMPARED:
        change_before, change = np.diff(answers, axis=0)
        # at times between two sliders' slips F changes by its drop, which is no error; K X_T says how far F is off
        beside = np.any([_beside(asked, *pair) for pair in pairwise(instants)], axis=0)
        counted = np.append(np.tile(~beside, 2), np.ones(change.size - 2 * n, dtype=bool))
        change_of_extrapolated = change + REST_OF_CHANGE * (change - change_before)
        changes = np.abs([change, change_of_extrapolated]) * counted
        safety = cohorts.memory.safety
        of_force, of_holding = np.delete(changes, np.s_[n : 2 * n], axis=1), changes[:, n : 2 * n]
        error, error_of_holding = (
            safety * float(part.max(axis=1, initial=0.0).min()) for part in (of_force, of_holding)
        )
        answer = answer + np.where(counted, REST_OF_CHANGE * change, 0.0)
        if beside.any():  # read F at an instant as long before or after the slip as it is from the extrapolated slip
            later = REST_OF_CHANGE * (instants[2] - instants[1])
            nearest = np.abs(asked[beside, None] - instants[2] - later).argmin(axis=1)
            there = read(sliders[2].sections, asked[beside] - later[nearest])
            answer[: 2 * n].reshape(2, n)[:, beside] = there / [[unit], [1.0]]
        if slip_undecided(sliders):
            error = max(error, float(np.abs(answer[:n]).max()))
    # round-off of the force grows with the number of steps, and where the slider slips with K, as K X_T does
    stiff = spring if slips[-1].size else min(spring, 1.0)
    rounding = ROUNDING * (1.0 + cohorts.steps) * (1.0 + stiff)
    duration = 0.0 if sliders[-1].motion is None else float(sliders[-1].motion.times[-1])
    cold_skin = unresolved_heat(contacts, cohorts.memory, drive, duration)
    error = max(error + cohorts.memory.error + rounding + cold_skin, cohorts.unresolved / unit)
    force, holding = answer[: 2 * n].reshape(2, n)[:, :points]
    slips_at = answer[2 * n :].reshape(3, -1) * unit / [[spring], [1.0], [1.0]]
    return Followed(
        balance=balance,
        force=force * unit,
        holding=holding,
        slips=slips_of(slips_at, spring, error * unit / spring),
        error=error,
        holding_error=error_of_holding,
        nodes=cohorts.steps,
    )


def _beside(times: Array, before: Array, now: Array) -> npt.NDArray[np.bool_]:
    """Times that the change of a slip's time moves across it, or nearly so."""
    apart, crossed = times[:, None] - now, (times[:, None] < now) != (times[:, None] < before)
    return np.asarray(((np.abs(apart) <= np.abs(now - before)) | crossed).any(axis=1))
