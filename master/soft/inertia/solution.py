"""A soft slider with a mass, M X'' + γ X' = K (X_T - X) - F, on the path of its drive.

It is followed with ever smaller tolerances, until the forces of the last two runs agree (`runs.py`). Where contacts'
laws depend on time, but for a delay alone, `in_time/` takes steps in time instead, halves them, and tells the error
itself (`in_time/answer.py`).
"""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from master.outcome import Progress
from master.soft.followed import ELSEWHERE, LEAVE_OUT, LOOSEN, OF_UNSURE_SLIP, ErrorPart, Followed
from master.soft.in_time.idle_heat import Idle, without_weak_heat
from master.soft.in_time.refining import balance_of
from master.soft.inertia.energy_errors import EnergyError
from master.soft.inertia.foretold import refuse_endless_swings, refuse_long_ringing
from master.soft.inertia.growing_swings import growing_swings
from master.soft.inertia.heat_left_out import beside_slips, heat_decides
from master.soft.inertia.in_time.refining import HeavyFound, follow_in_steps
from master.soft.inertia.run import Differences
from master.soft.inertia.runs import HeatLeftOut, run_ever_finer
from master.soft.inertia.short_delay import short_delay
from master.soft.solution import SoftSolution, common_fields, without_heat
from master.survival.life import ALL_ATOMS
from origins import Contacts
from origins.drive import Drive
from origins.energy import Energy
from origins.errors import InputError, refuse
from origins.thresholds.law import Array

# Rounding of the force, relative to K X_T.
ROUNDING = 1e-14
# Least force of steady sliding, in mean thresholds: that of equal ones.
LEAST_SLIDING = 0.5
# Error of the force, in mean thresholds, where it is not known whether a slip comes: all that contacts bear.
ANYWHERE = 1.0


@dataclass(frozen=True)
class InertialSolution(SoftSolution):
    """Motion of a slider with mass; see SoftSolution, whose `force` is that of the spring, K (X_T - X).

    velocity : dX/dt at the points of the path, shape (n,), without an error of its own: beside a slip, and while the
        slider rings on its contacts, it may be that of another moment (in answers of 27 random machines to 2e-3 to 2e-2
        off by up to 1e-3 of the top speed, and three times the drive's)
    contact_force : F/(N_c<k>), shape (n,), a length; contact_force_error : estimate from above of its largest error, in
        mean thresholds: above `force_error` where the slider passes many thresholds in a slip
    holding_error : the same of `holding`, 0 where contacts form at once; where they wait out a delay `success` does not
        ask for it, as it hangs, as the contacts' force does, on when a slip comes
    energy, energy_error : by parts, see Energy and EnergyError
    """

    velocity: Array
    contact_force: Array
    contact_force_error: float
    energy: Energy
    energy_error: EnergyError


def solve_inertial(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress, until: float
) -> InertialSolution:
    """Motion while the drive X_T moves along its path and pulls the slider, from rest, by its spring.

    Heat that hardly changes the force is left out, and a bound on its effect is counted in the errors; so is a delay
    that only takes from the damping. With other laws beside thresholds, start and delay the slider is followed in steps
    of time. Exact thresholds beside others are followed to OF_EXACT. Raises InputError for linked stiffness, for exact
    thresholds with such laws, for motions that take too long, and where a drive in time does not begin at the balance.
    """
    began, given, idle = time.perf_counter(), contacts, Idle(contacts)
    _check_laws(contacts, drive)
    if contacts.thermal is not None and not set(contacts.laws) - {"delay", "thermal"}:
        duration = float(drive.arrival_times(balance_of(contacts, drive))[-1])
        idle = without_weak_heat(contacts, drive, duration)
        contacts = idle.contacts
    if set(contacts.laws) - {"delay"}:
        in_steps = follow_in_steps(contacts, drive, tolerance, progress, until)
        common = common_fields((given, contacts), drive, in_steps.followed, tolerance, until)
        return _in_steps(in_steps, common, began)
    _check(contacts, drive, until)
    short = short_delay(contacts, drive, tolerance, until) if contacts.waiting_time else None
    if short is not None:
        contacts, drive = short.contacts, short.drive
    unit, spring = contacts.mean_threshold, float(drive.spring or 0.0)
    grows = growing_swings(contacts, drive) if contacts.waiting_time else None
    heat = HeatLeftOut(idle.effect * unit, idle.error) if idle.message else HeatLeftOut()
    runs = run_ever_finer(contacts, drive, tolerance, until, progress, grows, heat)
    best, errors, stopped = runs.best, runs.errors, runs.stopped
    most = float(best.record.holding[: best.force.size].max(initial=0.0))
    # a first run that was stopped has asked for less than `tolerance`, and knows no error
    if most > 1.0 + max(tolerance, best.tolerance):
        stopped = f"number is not conserved: holding reaches {most:.4g}, a fault of the program"
        errors = Differences(*(np.inf for _ in errors))
    neglected = ROUNDING * (1.0 + spring * float(np.abs(drive.path).max()) / unit) + heat.error
    if stopped and grows is not None and grows.message:
        stopped += f"; {grows.message}"
    notes, of_contacts, of_holding = list[str](), errors.contact_force, errors.holding
    if short is not None:
        neglected += short.error
        for run in {best, runs.coarser}:
            short.correct(run.record)
        of_holding += short.of_holding
        notes.append(short.message)
    if (swings := best.goes_on) is not None:
        neglected += swings.force / unit
        of_contacts += swings.contact_force / unit
        of_holding += swings.holding
        notes.append(
            f"from X_T = {swings.since:.6g} on, swings of the force by {swings.force / unit:.1e} are told by their "
            "middle, as they neither grow nor drift"
        )
    hot, of_slips = contacts.replace(thermal=given.thermal), 0.0
    told = best.slips(errors.force_and_load * unit / spring), best.record.place
    asked = bool(idle.message) and bool(np.isfinite(errors.force_and_load))
    if asked and heat_decides(hot, drive, *told, idle.effect * unit, until):
        of_slips = ANYWHERE
    of_all = errors.force_and_load + neglected + of_slips
    drive_error = of_all * unit / spring
    beside = errors.force - errors.force_and_load if np.isfinite(errors.force) else 0.0
    by_heat = beside_slips(best, drive, heat.effect)
    found = Followed(
        balance=best.balance,
        force=best.force,
        holding=best.record.holding[: best.force.size],
        slips=best.slips(drive_error, best.duration_error(runs.coarser, of_all)),
        error_of_force_and_load=float(of_all),
        of_holding=ErrorPart("a run", best.tolerance if np.isinf(of_all) else 0.0),
        nodes=runs.nodes,
        stopped_because=stopped,
        parts=(
            ErrorPart(f"two runs with other tolerances{runs.parting}", errors.force_and_load),
            ErrorPart("rounding, and heat, a delay or swings that are left out", neglected, LOOSEN),
            ErrorPart(OF_UNSURE_SLIP, of_slips, LEAVE_OUT),
        ),
        beside_slips=ErrorPart(
            "points beside a slip, where the two runs differ by its time, or heat that is left out may move it",
            beside + by_heat.force / unit,
            ELSEWHERE,
        ),
        note="; ".join(notes),
    )
    energy, record = best.energy(), best.record
    at_all, near_slips = of_all * unit, (of_all + beside) * unit + by_heat.force
    energy_error = runs.energy_error(drive, at_all, near_slips, (neglected + of_slips) * unit)
    if short is not None:
        energy_error = energy_error.with_more(short.of_energy(record.damped))
    if swings is not None:
        energy_error = energy_error.with_more(swings.energy)
    solved = slice(0, found.force.size)
    common = common_fields((given, contacts), drive, found, tolerance, until)
    common["holding_error"] = 0.0
    if given.waiting_time:
        share = of_holding + neglected + of_slips + by_heat.contact_force / (LEAST_SLIDING * unit)
        common["holding_error"] = min(share, 1.0)
    if idle.message:
        common |= without_heat(common, idle, idle.error + of_slips)
    return InertialSolution(
        **common,
        position=record.place[solved],
        run_time=time.perf_counter() - began,
        velocity=record.speed[solved],
        contact_force=record.contact_force[solved],
        contact_force_error=float(
            of_contacts + by_heat.contact_force / unit + neglected + of_slips
        ),
        energy=energy,
        energy_error=energy_error,
    )


def _in_steps(found: HeavyFound, common: dict[str, Any], began: float) -> InertialSolution:
    """What was found in steps of time, since time.perf_counter() was at `began`."""
    columns = found.columns
    return InertialSolution(
        **common,
        position=columns["position"],
        run_time=time.perf_counter() - began,
        velocity=columns["speed"],
        contact_force=columns["force"],
        contact_force_error=found.contact_force_error,
        energy=found.energy,
        energy_error=found.energy_error,
    )


def _check_laws(contacts: Contacts, drive: Drive) -> None:
    """Refuse contacts with laws beside which no mass is followed."""
    if "stiffness" in contacts.laws:
        hint = "the master equation follows a slider with mass on contacts of one stiffness, not with stiffness"
        refuse("mass", drive.mass, f"{hint}; use eq_model.simulate, or leave one of them out")
    if set(contacts.laws) - {"delay"} and contacts.thresholds.atoms[0].size:
        fault = "exact thresholds beside a mass are followed with no law but a delay, not with"
        laws = ", ".join(sorted(set(contacts.laws) - {"delay"}))
        raise InputError(f"contacts: {fault} {laws}; give the exact values a width")


def _check(contacts: Contacts, drive: Drive, until: float) -> None:
    """Refuse contacts without laws but a delay whose motion with a mass is not solved."""
    if contacts.delay is None:
        refuse_long_ringing(contacts, drive)
        return
    weights = contacts.thresholds.atoms[1]
    if weights.size and (not contacts.start.is_single or weights.sum() < ALL_ATOMS):
        fault = "exact thresholds beside others, or a start with a width, break at ever new places"
        raise InputError(
            f"contacts: with a mass and a delay {fault}; give the exact values a width"
        )
    refuse_endless_swings(contacts, drive, until)
