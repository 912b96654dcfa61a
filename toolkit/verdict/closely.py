"""The points of one slip of a slider with mass, and of the swing after it, that show it in its own time."""

from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.verdict.ensemble import SEED
from toolkit.verdict.islands import with_barriers
from toolkit.verdict.machine import (
    Behaviour,
    Machine,
    first_of,
    with_slips,
)

# how far a slip is shown, in times that it lasts: before its begin, and after it, where a swing with a tenth of
# critical damping has fallen to a tenth; and points of that time
BEFORE, AFTER, POINTS = 0.5, 8.0, 400
# of the force, in mean thresholds: no more is seen in a picture
TOLERANCE = 1e-2
# times that the slip is looked for: with other points of the path it may begin a little earlier or later
TRIES = 3


def closely(found: Behaviour, machine: Machine, contacts: Contacts, seconds: float) -> Behaviour:
    """The behaviour with the dense trace of its first slip, which is solved again up to there alone; as it is where
    slips take no time, and where they are not found again within so many seconds."""
    begin, lasts = found.first_slip, found.slip_time
    if begin is None or lasts is None or seconds < found.run_time:
        return found
    if found.damping is not None:
        machine = replace(machine, damping=found.damping)
    start, distance = contacts.start.mean() / machine.spring, machine.velocity * lasts
    with suppress(InputError):
        for _ in range(TRIES):
            places = begin + distance * np.linspace(-BEFORE, 1.0 + AFTER, POINTS)
            places = places[places > start]
            path = np.concatenate([[start], places])
            solved = _solved(found, machine, contacts, path, seconds / TRIES)
            late = first_of(solved.slips)
            if late is None or solved.path.size < path.size:
                break
            if abs(late - begin) < 0.5 * BEFORE * distance:
                drive, force = with_slips(solved, machine.velocity)
                shown = drive >= places[0]
                return replace(found, slip_drive=drive[shown], slip_force=force[shown])
            begin = late
    return found


def _solved(
    found: Behaviour, machine: Machine, contacts: Contacts, path: Array, seconds: float
) -> Any:
    """The slider along this path, by the solver that told of it; of the ensemble one alone."""
    asked = machine.keywords("mass")
    if found.contacts is None:
        import master

        return master.solve(contacts, path, TOLERANCE, wall_time=seconds, **asked)
    import eq_model

    # the ensemble told of contacts without their heat
    cold = with_barriers(contacts).replace(thermal=None)
    one = eq_model.simulate(cold, path, n_contacts=found.contacts, n_replicas=1, seed=SEED, **asked)
    return replace(one, force=one.forces[0])


def in_its_own_time(found: Behaviour, machine: Machine) -> tuple[Array, Array]:
    """Seconds since the slip began, and how far the slider has moved since (a length)."""
    drive, force = found.slip_drive, found.slip_force
    top = int(np.argmax(force))
    place = drive - force / machine.spring
    return (drive - drive[top]) / machine.velocity, place - place[top]
