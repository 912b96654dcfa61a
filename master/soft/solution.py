"""A soft slider: a spring K between the drive X_T and the slider X, K (X_T - X) = F(X).

Where F'(X) = -K (where laws depend on time: where no balance follows on), the slider slips, which
takes no time; `master.solve` says what a slip does. The drive begins where the spring balances the
starting force, X_T = F(0)/K at X = 0, and moves from there straight to its path (paper Sec. III E).
"""

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from master.outcome import Progress
from master.soft.cold import ColdSlider
from master.soft.followed import LEAVE_HEAT, ErrorPart, Followed
from master.soft.in_time.idle_heat import Idle, without_idle_heat
from master.soft.in_time.refining import balance_of, refined
from master.soft.regime import Regime, regime
from master.soft.slips import Slips
from origins import Contacts
from origins.brief import brief
from origins.drive import Drive
from origins.errors import InputError, refuse
from origins.thresholds.law import Array


@dataclass(frozen=True)
class SoftSolution:
    """F and X at the points of the drive's path, the slips on the way and the regime.

    path : positions X_T of the drive, shape (n,), lengths.
    balance : X_T = F(0)/K, the drive's position at t = 0, a length.
    position : positions X of the slider, shape (n,), lengths; where X_T is just that of a slip, after it, but before it
        where the drive turns there or its path ends.
    force : F/(N_c <k>) = K (X_T - X), shape (n,), lengths.
    force_error : estimate from above of the largest error of `force` along the path, and of K X_T at slips, in units of
        the mean threshold; just before a slip F is as accurate as if X_T were off by slips.drive_error.
    holding : fraction of contacts that hold, shape (n,): 1 without delay and growing grains, as slips take no time.
    holding_error : estimate from above of its largest error, a share of the contacts, but near slips, where it changes
        fast: there, and one delay later, it is as accurate as if X_T were off by slips.drive_error; `success` asks for
        both errors.
    period : distance of X_T between the last two main slips, a length, see Slips.main; None for fewer than two.
    run_time : s; nodes : number of instants at which number conservation was solved.
    success : whether force_error and holding_error are at or below the requested tolerance.
    note : what `message` says of how the slider was followed: heat that was left out, a delay that is taken as damping,
        creep without steps in time; "" where there is nothing to say.
    heat_left_out : what heat that was left out changes in the force at most, in mean thresholds, a part of force_error;
        None where there is no heat, or it was followed.
    """

    path: Array
    balance: float
    position: Array
    force: Array
    force_error: float
    holding: Array
    holding_error: float
    slips: Slips
    period: float | None
    regime: Regime
    run_time: float
    nodes: int
    success: bool
    message: str
    note: str
    heat_left_out: float | None

    __repr__ = brief


def solve_soft(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress, until: float
) -> SoftSolution:
    """Force while the drive X_T moves along its path and pulls the slider by its spring.

    A slider is followed in steps of time where its contacts' laws depend on time, and where contacts
    re-form stretched backward and the drive turns, since each then comes back to its largest |x| at
    a different X. Raises InputError where contacts that form again elsewhere than at x = 0 would be out in a slip, and
    where a drive in time does not begin at the balance; for too many steps, and exact thresholds with a wide start.
    """
    began, reforming, slip = time.perf_counter(), contacts.reforming, drive.slip
    out_in_slip = slip == "reform-after" or (contacts.delay is not None and slip == "instant")
    if reforming is not None and out_in_slip:
        hint = 'takes contacts that form again at x = 0; leave out reforming, or use "reset"'
        refuse("slip", slip, hint)
    given = contacts
    if contacts.thermal is not None:
        balance = balance_of(contacts, drive)
        duration = float(drive.arrival_times(balance)[-1])
        idle = without_idle_heat(contacts, drive, duration, tolerance)
        contacts = idle.contacts
    else:
        idle = Idle(contacts)
    backward = reforming is not None and reforming.law.span[0] < 0.0
    if contacts.in_time or (backward and not drive.forward):
        if contacts.thresholds.atoms[0].size and not contacts.start.is_single:
            fault = "with a width reach exact thresholds one after the other, which steps in time do not resolve"
            raise InputError(
                f"contacts.start: stretches {fault}; give the exact values a width, too"
            )
        # not the balance above: without the heat a wide start has other nodes, and F(0) differs a little
        found = refined(contacts, drive, balance_of(contacts, drive), tolerance, progress, until)
        error = idle.error
        of_drive = error * contacts.mean_threshold / float(drive.spring or 0.0)
        slips = replace(found.slips, drive_error=found.slips.drive_error + of_drive)
        left_out = ErrorPart("heat that is left out", error, LEAVE_HEAT)
        found = found._replace(
            error_of_force_and_load=found.error_of_force_and_load + error,
            slips=slips,
            parts=(*found.parts, left_out),
        )
    else:
        of_heat = idle.effect * contacts.mean_threshold
        found = ColdSlider(contacts, drive, tolerance, until, of_heat, given).follow()
        progress(found.error_of_force_and_load)
    position = drive.path[: found.force.size] - found.force / float(drive.spring or 0.0)
    common = common_fields((given, contacts), drive, found, tolerance, until)
    if idle.message:
        common |= without_heat(common, idle, found.error_of_force_and_load)
    return SoftSolution(position=position, run_time=time.perf_counter() - began, **common)


def without_heat(common: dict[str, Any], idle: Idle, change: float) -> dict[str, Any]:
    """Fields of a SoftSolution that tell of heat that was left out, and changes the force by at most so many mean
    thresholds."""
    told = f"{idle.message} {change:.1e} mean thresholds"
    note = f"{common['note']}; {told}" if common["note"] else told
    return {"message": f"{common['message']}; {told}", "note": note, "heat_left_out": change}


def common_fields(
    contacts: tuple[Contacts, Contacts],
    drive: Drive,
    found: Followed,
    tolerance: float,
    until: float,
) -> dict[str, Any]:
    """Fields of a SoftSolution that do not depend on whether the slider has a mass. `contacts`: those of the caller, of
    which weights beyond every threshold are told, and those that were followed, without laws that are left out."""
    given, followed = contacts
    if found.fault(tolerance):
        found = found._replace(error_of_force_and_load=np.inf)
    success, message = found.outcome(given, drive, tolerance, "X_T")
    return {
        "path": drive.path[: found.force.size],
        "balance": found.balance,
        "force": found.force,
        "force_error": found.force_error,
        "holding": found.holding,
        "holding_error": found.holding_error,
        "slips": found.slips,
        "period": found.slips.period,
        "regime": regime(followed, drive, found, tolerance, until),
        "nodes": found.nodes,
        "success": success,
        "message": message,
        "note": found.note,
        "heat_left_out": None,
    }
