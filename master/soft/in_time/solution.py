"""Sliders whose contacts have laws that depend on time, followed in steps to a tolerance."""

from __future__ import annotations

import time as clock

import numpy as np

from master.outcome import Progress, outcome, unheard
from master.soft.in_time.carried import Allowed, Carried
from master.soft.in_time.make import memory_of
from master.soft.in_time.refining import refined
from master.soft.in_time.track import reached
from master.soft.solution import AT_REST, SoftSolution, solution_of
from master.solution import Solution
from origins import Contacts, Drive
from origins.errors import refuse

# Two positions of the drive nearer than this, in mean thresholds, count as equal.
SAME = 1e-12


def solve_given(
    contacts: Contacts,
    drive: Drive,
    tolerance: float,
    progress: Progress = unheard,
    wall_time: float | None = None,
) -> Solution:
    """Force on a rigid slider, with steps halved until the tolerance is reached; see `solve`.

    It is used for growing grains with heat on paths that turn or hold. The slider is taken as one on
    a spring so stiff that it follows the drive.

    Raises InputError where a path takes too many steps.
    """
    began = clock.perf_counter()
    until = np.inf if wall_time is None else clock.monotonic() + wall_time
    # K/(N_c <k>) = 1e10: the slider is nearly rigid, with an error F/K of X
    stiff = Drive(drive.path, drive.velocity, drive.time, 1e10, drive.slip)
    found = refined(contacts, stiff, 0.0, tolerance, progress, until)
    end = drive.path[: found.force.size]
    success, message = outcome(contacts, found.error, tolerance, found.reason)
    if end.size < drive.path.size:
        last = f"X = {end[-1]:.6g}" if end.size else "the first point"
        success, message = False, f"stopped at {last} by wall_time; the path is cut there"
    times = reached(drive, 0.0)[: end.size]
    return Solution(
        path=end,
        force=found.force,
        time=times,
        force_error=found.error,
        holding=found.holding,
        run_time=clock.perf_counter() - began,
        nodes=found.nodes,
        success=success,
        message=message,
        _march=None,
        _by_index=True,
        _moments=times,
    )


def solve_in_time(
    contacts: Contacts,
    drive: Drive,
    tolerance: float,
    progress: Progress = unheard,
    wall_time: float | None = None,
) -> SoftSolution:
    """Force while the drive moves and pulls the slider, for contacts with any laws.

    Rates, delay and holds run on the drive's clock; the caller checks the arguments. The drive begins
    at t = 0 where it balances the start, X_T = F(0)/K with the slider at X = 0. A contact that breaks
    in a slip is out for the delay, if there is one, under every rule but "reset".

    Raises InputError for re-forming elsewhere than at x = 0 under "reform-after", and with a delay
    under "instant"; where a drive in time does not begin at the balance; where a path takes too
    many steps.
    """
    began = clock.perf_counter()
    until = np.inf if wall_time is None else clock.monotonic() + wall_time
    unit, waits = contacts.mean_threshold, contacts.delay is not None
    out = drive.slip == "reform-after" or (waits and drive.slip == "instant")
    if contacts.reforming is not None and out:
        refuse("slip", drive.slip, AT_REST)
    start = Carried(contacts, memory_of(contacts, 0, 1.0), 0, Allowed(0.0, 0.0))
    balance = start.force / float(drive.spring or 0.0)
    if abs(drive.path[0] - balance) <= SAME * unit:
        balance = float(drive.path[0])  # the difference is rounding
    late = drive.time is not None and drive.time[0] == 0.0
    if late and abs(drive.path[0] - balance) > SAME * unit:
        rule = f"at time 0 the drive stands where it balances the start, {balance:.9g}"
        refuse("path[0]", drive.path[0], rule)
    found = refined(contacts, drive, balance, tolerance, progress, until)
    return solution_of(contacts, drive, tolerance, began, found)
