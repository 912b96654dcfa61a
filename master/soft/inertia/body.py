"""The state of a slider with mass on the path of its drive; its modes of motion go on from each other by it."""

from collections.abc import Callable

import numpy as np

from master.motion import Motion
from master.soft.cold_contacts import ColdContacts
from master.soft.inertia.reaction import Reaction
from master.soft.inertia.record import NOTHING_SPENT, Instant, Record, Watched
from master.soft.moves import LoadingHistory
from origins.drive import Drive
from origins.thresholds.law import Array

# Share of the tolerance below which ringing counts as rest.
QUIET = 0.02
# Factors on that share below which a slider stays in the mode `following`, and below which it leaves `moving` for it:
# both far enough from 1 that the two modes do not alternate.
STAYS_SLOW, GETS_SLOW = 2.0, 0.5
RINGS = "stopped as the slider rings for too long; give a damping, or a larger one"

Mode = Callable[[], object]
"""A mode of motion goes on as long as it holds, and returns the next one."""


class Body:
    """A slider with mass at T = 0.

    record : results at the asked times, and slips
    t, leg : time, and index of the leg of the drive's motion
    stiff, quiet : K + 1, and the force of a swing (a length) up to which it counts as rest
    fastest : largest change in a radian with which the slider follows slowly
    move, base : the contacts' present move, and X where it began
    y, w : travel on it, and speed along it
    spent : energies from t = 0 on
    broken : breaks per contact before that move
    steps, turns : number of the integrator's steps and of turns so far
    drive_direction : of the drive, +1 or -1, in a hold the one before
    """

    move: Reaction

    def __init__(
        self,
        contacts: ColdContacts,
        drive: Drive,
        motion: Motion,
        record: Record,
        tolerance: float,
        fastest: float,
    ) -> None:
        """The slider at rest, in balance, at t = 0; `tolerance` is that of the force, a length."""
        self.contacts, self.record, self.motion = contacts, record, motion
        self.mass, self.damping = float(drive.mass or 0.0), drive.damping
        self.spring, self.unit, self.tolerance = contacts.spring, contacts.unit, tolerance
        self.fastest = fastest
        # stiffness against the slider while all contacts hold, in N_c<k>
        self.stiff, self.quiet = 1.0 + self.spring, QUIET * tolerance
        self.t, self.leg = 0.0, 0
        self.base, self.y, self.w = 0.0, 0.0, 0.0
        self.spent, self.broken = NOTHING_SPENT, 0.0
        self.steps = self.turns = 0
        moving = motion.speeds[motion.speeds != 0.0]
        self.drive_direction = int(np.sign(moving[0])) if moving.size else 1

    def elastic(self) -> Mode:
        """No contact breaks."""
        raise NotImplementedError

    def moving(self) -> Mode:
        """The slider moves on, and contacts break."""
        raise NotImplementedError

    def following(self) -> Mode:
        """The slider follows its drive slowly."""
        raise NotImplementedError

    def turn(self) -> Mode:
        """The slider stands still, and turns."""
        raise NotImplementedError

    def _new_move(self, direction: int, loaded: LoadingHistory) -> Reaction:
        """Contacts with this history on a move in this direction."""
        return Reaction(self.contacts, direction, loaded, self.tolerance)

    def _drive(self, t: float | Array) -> Array:
        """X_T on the present leg."""
        motion, leg = self.motion, self.leg
        return motion.positions[leg] + motion.speeds[leg] * (t - motion.times[leg])

    @property
    def _speed(self) -> float:
        """dX_T/dt along the present move."""
        return self.move.direction * float(self.motion.speeds[self.leg])

    def _pull(self, t: float | Array) -> Array:
        """K X_T along the move, counted from its beginning."""
        return self.spring * self.move.direction * (self._drive(t) - self.base)

    def _leg_end(self) -> float:
        """When the present leg of the drive ends."""
        return float(self.motion.times[self.leg + 1])

    def _next_leg(self) -> None:
        """Go on to the next leg of the drive, at its beginning."""
        self.t, self.leg = self._leg_end(), self.leg + 1
        if self.leg < self.motion.speeds.size:
            self.drive_direction = (
                int(np.sign(self.motion.speeds[self.leg])) or self.drive_direction
            )

    def _force(self, y: float) -> float:
        """F along the move at the travel y."""
        return self.move.panel_at(y).force(y)

    def _break_here(self) -> None:
        """Contacts that break together at this very travel break: F is that behind its drop."""
        if (self.move.curve.drops == self.y).any():
            self.y = float(np.nextafter(self.y, np.inf))

    @property
    def _error(self) -> float:
        """Error of the force of the contacts."""
        return float(self.move.curve.error_at(self.y))

    def _instant(self, t: float, y: float, broken_at: float) -> Instant:
        """The slider at the time t on the present leg, at the travel y, with the breaks up to another travel."""
        drive, place = float(self._drive(t)), self.base + self.move.direction * y
        breaks = self.broken + self.move.breaks(broken_at)
        return Instant(t, drive, place, self.spring * (drive - place), breaks)

    def _watched(
        self,
        times: Array,
        travels: tuple[Array, Array],
        drives: Array,
        at: Callable[[float], Instant],
        when: Callable[[int], float],
    ) -> Watched:
        """For the record: travels and speeds along the move, and X_T, at these times."""
        y, w = travels
        places, d = self.base + self.move.direction * y, self.move.direction * self.drive_direction
        drive_speed = self.drive_direction * float(self.motion.speeds[self.leg])
        forces = self.spring * (drives - places)
        holding = np.ones(times.size)
        return Watched(
            times, d * w, places, forces, holding, drive_speed, self.drive_direction, at, when
        )

    @property
    def _heavily_damped(self) -> bool:
        """Whether the damping is above the critical one of a slider that sticks, so that it never rings."""
        return self.damping > 2.0 * float(np.sqrt(self.mass * self.stiff))

    def _goes_on_slowly(self, rate: float) -> bool:
        """Whether a slider that follows its drive slowly does so for a way that is worth to change the mode."""
        raise NotImplementedError

    def _follows(self, part: float) -> bool:
        """Whether the slider follows its drive slowly, up to a part of what counts as rest."""
        raise NotImplementedError
