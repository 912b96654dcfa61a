"""Refining: a slider with mass followed again and again, with steps halved each time, until its force is known."""

import time
from typing import Any, NamedTuple

import numpy as np

from master.motion import Motion, drive_motion
from master.outcome import FaultError, Progress, StoppedError
from master.soft.followed import Followed
from master.soft.in_time.contacts import MOST_STEPS, MOST_WORK, ContactsInSteps
from master.soft.in_time.refining import (
    MORE_STEPS,
    MORE_WORK,
    NEAR_MEMORY_ERROR,
    balance_of,
    memory_of,
)
from master.soft.in_time.steps import CONTROL
from master.soft.inertia.energy_errors import EnergyError
from master.soft.inertia.foretold import enough_damping
from master.soft.inertia.in_time.answer import COMPARED, HeavyAnswer, answer, spacing_error
from master.soft.inertia.in_time.energy_errors import energies_told
from master.soft.inertia.in_time.long_slips import long_slips_of
from master.soft.inertia.in_time.ringing import Ringing
from master.soft.inertia.in_time.slider import HeavySlider
from master.soft.inertia.in_time.steady_sliding import sliding_of
from master.soft.inertia.run import SlipsInTime
from origins import Contacts, Drive, ProportionalGrowth
from origins.energy import Energy
from origins.errors import refuse
from origins.thresholds.law import Array

# So many of the ways without steps are named in a message.
NAMED = 3


class HeavyFound(NamedTuple):
    """What is found: force and slips with their errors; the motion at the points of the path, by the names of
    HeavyNode; the error of the contacts' force (mean thresholds); and energies with their errors."""

    followed: Followed
    columns: dict[str, Array]
    contact_force_error: float
    energy: Energy
    energy_error: EnergyError


def follow_in_steps(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress, until: float
) -> HeavyFound:
    """The slider with mass of contacts whose laws depend on time, on steps halved until its error is within the
    tolerance; `until` is a reading of time.monotonic() at which to stop. Raises InputError where the coarsest steps
    take too long."""
    balance = balance_of(contacts, drive)
    motion, asked = drive_motion(drive, balance), drive.arrival_times(balance)
    given = contacts, drive, motion, tolerance, until
    slips = long_slips_of(*given)
    sliding = sliding_of(*given) or slips
    if sliding is None:
        _refuse_long_ways(contacts, drive, balance)
    fastest = 0.0 if motion is None else float(np.abs(motion.speeds).max())
    unit = contacts.mean_threshold
    stays = contacts.changing is None and contacts.reforming is None
    survival = contacts.thresholds.sf if stays else None
    sliders, best, halvings, stopped, nodes = list[HeavySlider](), None, 0, "", 0
    spacing = np.inf
    while True:
        memory = memory_of(contacts, halvings, fastest, motion)
        in_steps = ContactsInSteps(contacts, memory, halvings, until)
        rings = None if slips is None else Ringing(drive, slips.motion, tolerance * unit, unit)
        slider = HeavySlider(in_steps, drive, motion, tolerance * unit, sliding, survival, rings)
        try:
            slider.run()
        except StoppedError as why:
            stopped = _why(why, slider, contacts, drive)
            if best is None:
                if time.monotonic() <= until and not isinstance(why, FaultError):
                    refuse("path[-1]", drive.path[-1], stopped)
                best = answer([slider], contacts, drive, asked[asked <= in_steps.now])
                sliders = [slider]
            break
        sliders, nodes = [*sliders[1 - COMPARED :], slider], nodes + in_steps.steps
        found = answer(sliders, contacts, drive, asked)
        progress(found.error_of_force_and_load)
        if best is None or _largest(found) <= _largest(best):
            best, spacing = found, spacing_error(sliders, contacts, drive)
        as_good_as_memory = _largest(found) < NEAR_MEMORY_ERROR * memory.error
        if _largest(best) <= tolerance or as_good_as_memory:
            break
        steps, work = MORE_STEPS * in_steps.cost, MORE_WORK * in_steps.work
        if steps > MOST_STEPS or work > MOST_WORK:
            many = f"{steps:.0f} steps, above {MOST_STEPS:.0f}"
            what = many if steps > MOST_STEPS else f"{work:.1e} operations, above {MOST_WORK:.0e}"
            stopped = f"steps are not halved again, which takes {what}"
            break
        halvings += 1
    return _found(best, sliders[-1], drive, balance, (nodes, stopped), spacing)


def _refuse_long_ways(contacts: Contacts, drive: Drive, balance: float) -> None:
    """InputError where the slider goes so far that the coarsest steps, of which each takes it on by CONTROL.coarsest of
    the length over which births change at most, are too many. It is behind its drive by F/K at most."""
    memory, spring = memory_of(contacts, 0, 1.0), float(drive.spring or 0.0)
    way = float(np.abs(np.diff(drive.path, prepend=balance)).sum())
    turns = 1 + np.count_nonzero(np.diff(np.sign(np.diff(drive.path, prepend=balance))))
    behind = 2.0 * turns * memory.largest_stretch / spring
    steps = (way - behind) / (CONTROL.coarsest * memory.scales.length)
    most = MOST_STEPS * 0.5 ** (COMPARED - 1)
    if steps > most:
        fault = f"a slider with mass goes on by {way - behind:.3g} or more, in {steps:.2g} steps"
        fault += f" of time, above {most:.2g}"
        refuse("path[-1]", drive.path[-1], f"{fault}; end the path sooner, or take a slip rule")


def _sliding(slider: HeavySlider, motion: Motion) -> dict[str, Any]:
    """What is to be said of long ways without steps, and the position of the drive from which on F is that of steady
    sliding at its speed, where it is."""
    slides = slider.slides
    begins = motion.at(np.array([slid.nodes[0].time for slid in slides])).tolist()
    where = ", ".join(f"X_T = {at:.6g}" for at in begins[:NAMED]) + ", ..." * (len(begins) > NAMED)
    what = "in slips" if slider.passes_slips else "on the slider slides steadily"
    note = f"from {where} {what}: F is F_k of its present speed, and no steps are taken"
    if not slides[-1].to_end:
        return {"note": note}
    beyond = slides[-1].steady_from - motion.times[-1]
    return {"note": note, "steady_from": float(motion.positions[-1] + motion.speeds[-1] * beyond)}


def _largest(found: HeavyAnswer) -> float:
    """The error by which an answer is judged."""
    return max(found.error_of_force_and_load, found.of_holding.size)


def _ensemble_takes(contacts: Contacts) -> bool:
    """Whether eq_model.simulate takes a slider with mass on these contacts."""
    stays = contacts.changing is None or isinstance(contacts.changing, ProportionalGrowth)
    return stays and contacts.reforming is None


def _why(why: StoppedError, slider: HeavySlider, contacts: Contacts, drive: Drive) -> str:
    """Why a slider was stopped, and where steps were too many what to do."""
    taken = slider.contacts
    work = MOST_WORK * (taken.most_steps / MOST_STEPS) ** 2
    if taken.cost <= taken.most_steps and taken.work <= work:
        return str(why)
    fault = f"a slider with mass takes {taken.steps} steps, {taken.work:.1e} operations in all,"
    end, hint = "end the path sooner", f"or give a larger damping ({enough_damping(drive)})"
    if slider.falls.begins and slider.motion is not None:
        begins = float(slider.motion.at(np.array(slider.falls.begins[-1])))
        end = f"end the path before the slip at X_T = {begins:.6g}"
    if len(slider.falls.begins) > len(slider.falls.slips):
        others = ", or eq_model.simulate" if _ensemble_takes(contacts) else ""
        hint = f"or take a slip rule{others}: the slip itself takes so many"
    if slider.may_fly_at_one_speed:
        hint = "or drive at one speed all along, on which slips of contacts that wait so long take no steps"
    return f"{fault} to t = {taken.now:.4g}, and no more are taken on; {end}, {hint}"


def _found(
    best: HeavyAnswer,
    last: HeavySlider,
    drive: Drive,
    balance: float,
    ended: tuple[int, str],
    spacing: float,
) -> HeavyFound:
    """The answer in the form of other sliders; `ended`: steps in all, and why they were not halved further; `spacing`:
    see `spacing_error`."""
    unit, spring, slips = last.contacts.unit, last.spring, best.slips
    place = best.columns["position"]
    force = spring * (drive.path[: place.size] - place)
    drive_error = best.error_of_force_and_load * unit / spring
    listed = SlipsInTime(
        drive=slips.drive,
        before=slips.drive - slips.force_before / spring,
        after=slips.after,
        force_before=slips.force_before,
        force_after=slips.force_after,
        drive_error=drive_error,
        time=slips.time,
        duration=slips.duration,
        top_speed=slips.top_speed,
        duration_error=best.duration_error,
        force_error=best.of_slip_forces,
        spacing_error=spacing,
    )
    nodes, stopped = ended
    of_holding = best.of_holding
    if best.beside.holding > of_holding.size:
        of_holding = best.beside.force._replace(size=of_holding.size)
    followed = Followed(
        balance=balance,
        force=force,
        holding=best.columns["holding"],
        slips=listed,
        error_of_force_and_load=best.error_of_force_and_load,
        nodes=nodes,
        parts=best.parts,
        stopped_because=stopped,
        of_holding=of_holding._replace(size=min(of_holding.size + best.beside.holding, 1.0)),
        beside_slips=best.beside.force,
    )
    if last.slides and last.motion is not None:
        followed = followed._replace(**_sliding(last, last.motion))
    of_contacts = best.of_contacts + best.beside.contact_force
    told = energies_told(best, last, drive, balance, force)
    return HeavyFound(followed, best.columns, of_contacts, *told)
