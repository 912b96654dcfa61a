"""A slider with mass and a delay that slides on with small swings: once they neither grow nor drift, the rest of the
drive's way is told by their middle.

Where a delay makes friction fall with the speed, steady sliding may be unstable, and swings grow until the slider
nearly stops in each of them. They may then stay far below a slip, for thousands of swings.
"""

from typing import NamedTuple

import numpy as np

from master.outcome import StoppedError
from master.soft.inertia.delayed.body import DelayedBody
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.record import Record, Spent
from origins.drive import RISE
from origins.thresholds.law import Array

# Panels between two looks at whether the slider goes on so, or a tenth of those seen.
PANELS = 100
# Least way of the drive in which swings are compared with those before: so many of them, and mean thresholds.
SWINGS, THRESHOLDS = 5.0, 100.0
# Least speed in a swing, in units of the largest, below which it has grown as far as it can.
STOPS = 0.1
# Difference of such swings, as a part, up to which they are alike; and times a number's range that may be told of it.
ALIKE, TWICE = 0.1, 2.0
# Part of the tolerance of the force that swings may take; and after so many more of them they may take more, as a
# slider that is followed to its limits tells nothing.
OF_TOLERANCE, MANY = 0.5, 3.0
# Why a run is stopped that does not see swings grow.
UNRESOLVED = (
    "steady sliding is unstable, by swings that this tolerance does not resolve; tighten it"
)


class GoesOn(NamedTuple):
    """Estimates from above of what swings that are not followed change: of the spring's force and the contacts'
    (lengths), of the share that holds, and of energies (a length squared).

    since : X_T from which on they are not followed
    """

    since: float
    force: float
    contact_force: float
    holding: float
    energy: float


class Seen(NamedTuple):
    """The slider at the end of a panel: X_T, forces of spring and contacts (lengths), share of the contacts that holds,
    energies since t = 0 that the drive gave, that the damping took, and that moving the contacts took, and dX/dt."""

    drive: float
    spring: float
    contacts: float
    holding: float
    given: float
    damped: float
    on_contacts: float
    speed: float


# Columns of an array of them.
DRIVE, SPRING, CONTACTS, HOLDING, GIVEN, DAMPED, ON_CONTACTS, SPEED = range(len(Seen._fields))
FORCES, ENERGIES = slice(SPRING, HOLDING + 1), slice(GIVEN, ON_CONTACTS + 1)


class SmallSwings:
    """The swings of a slider since its last slip, on the last leg of its drive.

    tolerance : of the force that is asked for (a length), which that of a run may be a part of
    """

    def __init__(
        self, body: DelayedBody, sliding: FastSliding, record: Record, tolerance: float
    ) -> None:
        """`sliding`: what the contacts' law says of a slider that passes many thresholds."""
        self._body, self._sliding, self._record, self._tolerance = body, sliding, record, tolerance
        self._seen, self._slips, self._next_look = list[Seen](), 0, PANELS

    def goes_on(self) -> GoesOn | None:
        """After a panel: None unless swings are known to go on so up to the path's end; then the results are written.

        The way of the drive on the last third of the panels since the last slip is compared with as long a way before
        it. The range of each number in both tells the swings. Where the slider nearly stops in each of them, they have
        grown as far as they do: they must be alike in both. Else they may grow on up to the path's end as those of the
        spring's force have grown, and their mean may go on as it has moved. StoppedError where small swings must grow,
        and do not.
        """
        body, drive = self._body, self._body.drive
        slips = len(self._record.slips)
        if slips > self._slips:
            self._seen, self._slips, self._next_look = [], slips, PANELS
        if drive.over or drive.leg_end < drive.end or not drive.speed:
            return None
        at = float(drive.at(body.state.t))
        spring = body.machine.spring * (at - body.state.x)
        forces = spring, body.contact_force, body.contacts.unbroken()
        self._seen.append(Seen(at, *forces, *body.spent, body.state.w))
        if len(self._seen) < self._next_look:
            return None
        self._next_look = len(self._seen) + max(PANELS, len(self._seen) // 10)
        seen = np.array(self._seen)
        distance = np.abs(seen[:, DRIVE] - at)
        window = float(distance[-(len(seen) // 3)])
        if 2.0 * window > distance[0]:
            return None
        late, before = (
            seen[distance <= window],
            seen[(distance > window) & (distance <= 2.0 * window)],
        )
        if len(before) < 2:
            return None
        ranges = np.ptp(before, axis=0), np.ptp(late, axis=0)
        least = self._least_distance(float(max(ranges[0][SPRING], ranges[1][SPRING])))
        if window < least:
            return None
        stops = late[:, SPEED].min() <= STOPS * late[:, SPEED].max()
        grows = float(ranges[1][SPRING] / ranges[0][SPRING]) if ranges[0][SPRING] else 1.0
        if self._grow and not stops:
            if grows > 1.0 + ALIKE:
                return None
            raise StoppedError(UNRESOLVED)
        most = np.maximum(*ranges)
        if stops:
            if abs(grows - 1.0) > ALIKE:
                return None
            changes = TWICE * most
        else:
            windows_to_go = abs(float(drive.at(drive.end)) - at) / window
            with np.errstate(over="ignore"):
                most = most * np.float64(max(grows, 1.0)) ** windows_to_go
            changes = most + np.abs(_mean(late) - _mean(before)) * windows_to_go
        force, contacts, holding = changes[FORCES].tolist()
        enough = OF_TOLERANCE * self._tolerance
        if force > (RISE * body.machine.unit if window > MANY * least else enough):
            return None
        self._write(late)
        return GoesOn(at, force, contacts, holding, self._of_energies(late, before))

    def _of_energies(self, late: Array, before: Array) -> float:
        """How far energies may be off at the path's end, as they went on otherwise in late swings than before: that
        of a swing's motion, and the difference of the slopes along the drive's way on what is left of it."""
        body, drive = self._body, self._body.drive
        slopes = [
            np.ptp(one[:, ENERGIES], axis=0) / np.ptp(one[:, DRIVE]) for one in (late, before)
        ]
        to_go = abs(float(drive.at(drive.end)) - float(drive.at(body.state.t)))
        of_motion = 0.5 * body.machine.mass * float(np.abs(late[:, SPEED]).max()) ** 2
        return of_motion + TWICE * float(np.abs(slopes[1] - slopes[0]).max()) * to_go

    @property
    def _grow(self) -> bool:
        """Whether small swings grow, as friction falls with the speed by more than the damping rises. Wide panels may
        hide that for a while, until the slider nearly stops in each swing."""
        speed, none = np.array([abs(self._body.drive.speed)]), np.zeros(1)
        of_speed = self._sliding.nearly_steady(speed, none, self._body.past.delay).by_speed
        return bool(self._body.machine.damping + float(of_speed[0]) < 0.0)

    def _least_distance(self, swing: float) -> float:
        """The least way of the drive in which swings of the spring's force by so much (a length) are compared."""
        machine = self._body.machine
        free = 2.0 * np.pi * abs(self._body.drive.speed) * (machine.mass / machine.spring) ** 0.5
        return float(max(SWINGS * max(swing / machine.spring, free), THRESHOLDS * machine.unit))

    def _write(self, late: Array) -> None:
        """The results at the asked times from here on: forces and shares in the middle of late swings, energies as they
        went on in them."""
        body, record, drive = self._body, self._record, self._body.drive
        which = body.asked(body.state.t, np.inf)
        at = drive.at(body.asked_times(which))
        low, high = late.min(axis=0), late.max(axis=0)
        spring, _, holding = (0.5 * (low + high))[FORCES].tolist()
        record.holding[which] = holding
        record.stored[which] = body.contacts.stored(body.state.x)
        # by the drive's way; what the drive gives goes into the damping and the contacts
        lasts = late[-1] - late[0]
        given, damped = spring, lasts[DAMPED] / lasts[DRIVE]
        rates = np.array([given, damped, given - damped])
        energies = late[-1, ENERGIES] + (at - late[-1, DRIVE])[:, None] * rates
        friction = spring - body.machine.damping * drive.speed
        place = at - spring / body.machine.spring
        record.write(which, place, drive.speed, friction, Spent(*energies.T))


def _mean(seen: Array) -> Array:
    """The means along the drive's way, which is the first column."""
    distance = np.diff(seen[:, [DRIVE]], axis=0)
    return np.asarray((0.5 * (seen[1:] + seen[:-1]) * distance).sum(axis=0) / distance.sum())
