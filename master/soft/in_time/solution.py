"""A soft slider with laws of single contacts that tell time, to the tolerance asked."""

from __future__ import annotations

import time as clock

import numpy as np

from master.outcome import Progress, outcome, unheard
from master.soft.in_time.make import Maker
from master.soft.in_time.refining import refined
from master.soft.in_time.track import fastest, pieces, reached
from master.soft.regime import Course, regime
from master.soft.slips import Slips
from master.soft.solution import SoftSolution
from origins import Contacts
from origins.drive import Drive
from origins.errors import refuse

# A start whose mean stretch is this near to nothing, over K, balances the drive where it begins; in
# mean thresholds.
SAME = 1e-12


def solve_in_time(
    contacts: Contacts,
    drive: Drive,
    tolerance: float,
    progress: Progress = unheard,
    wall_time: float | None = None,
) -> SoftSolution:
    """Force as the drive moves and pulls the slider, for contacts with any laws.

    Rates, delay and holds run on the drive's clock; arguments are checked before. The drive begins
    at t = 0 where it balances the start, X_T = F(0)/K with the slider at X = 0. A contact that breaks
    in a slip waits out its delay, where there is one, under every rule but "reset".

    Raises InputError for re-forming elsewhere than at x = 0 under "reform-after", and with a delay
    under "instant"; where a drive in time does not begin at the balance; where a path takes too
    many steps.
    """
    began = clock.perf_counter()
    assert drive.spring is not None
    until = np.inf if wall_time is None else clock.monotonic() + wall_time
    unit, spring, waits = contacts.mean_threshold, drive.spring, contacts.delay is not None
    out = drive.slip == "reform-after" or (waits and drive.slip == "instant")
    if contacts.reforming is not None and out:
        rule = 'takes contacts that form again at x = 0; leave out reforming, or use "reset"'
        refuse("slip", drive.slip, rule)
    maker = Maker(contacts, fastest(drive))
    balance = float(maker.all(0).pull[0]) / spring
    if abs(drive.path[0] - balance) <= SAME * unit:
        balance = float(drive.path[0])  # a start of no mean stretch is one of rounding
    late = drive.time is not None and drive.time[0] == 0.0
    if late and abs(drive.path[0] - balance) > SAME * unit:
        rule = f"at time 0 the drive stands where it balances the start, {balance:.9g}"
        refuse("path[0]", drive.path[0], rule)
    asked = reached(drive, balance)
    found = refined(contacts, maker, drive, balance, asked, tolerance, progress, until)
    told = found.force.size
    path, whole = drive.path[:told], told == drive.path.size
    error = found.error
    success, message = outcome(contacts, error, tolerance, found.reason)
    if not whole:
        last = f"X_T = {path[-1]:.6g}" if told else "the first point"
        success, message = False, f"stopped at {last} by wall_time; the path is cut there"
    drives, before, after, above, below = found.slips
    slips = Slips(drives, before, after, above, below, error * unit / spring)
    position = path - found.force / spring
    moving = [piece for piece in pieces(drive, balance) if piece.travel != 0.0]
    course = None
    if moving:
        speeds = [abs(piece.travel) / piece.duration for piece in moving]
        mean = sum(abs(piece.travel) for piece in moving) / sum(p.duration for p in moving)
        speed = drive.velocity if drive.time is None else mean
        course = Course(asked[:told], found.force, position, moving[-1].begin, speeds[-1], speed)
    return SoftSolution(
        path=path,
        balance=balance,
        position=position,
        force=found.force,
        force_error=error,
        holding=found.holding,
        slips=slips,
        period=slips.period,
        regime=regime(contacts, drive, slips, tolerance, whole and np.isfinite(error), course),
        run_time=clock.perf_counter() - began,
        nodes=found.steps,
        success=success,
        message=message,
    )
