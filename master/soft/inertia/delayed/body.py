"""The state of a slider with mass and its contacts, which form again after a delay, on the path of its drive."""

from collections.abc import Callable

import numpy as np

from master.motion import Motion
from master.soft.inertia.body import QUIET
from master.soft.inertia.delayed.collocation import Machine, State
from master.soft.inertia.delayed.contacts import Cohorts
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import NODES, Panel
from master.soft.inertia.delayed.past_breaks import PastBreaks
from master.soft.inertia.delayed.survival import Survival
from master.soft.inertia.reaction import ALIKE
from master.soft.inertia.record import Instant, Record, Watched
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array

# Error of a panel, in units of the tolerance of the force: ringing that is smaller counts as rest.
OF_PANEL = QUIET
# Multiples of the delay after a kink of the breaks at which births have a visible one: each is smoother by one order.
ECHOES = 3
# Difference of two places that count as one, in units of the error of a panel.
SAME = 0.1
# Rounding of times.
EPSILON = 1e-13
# Survival below which no contact holds where births pass the slider in numbers.
FEW = 1e-12


class DelayedBody:
    """A slider at an instant, and its contacts.

    record : results at the asked times, and slips
    stored_first : energy of the contacts at t = 0

    What panels and closed motions hand on to each other, beside state, contacts and past breaks:
    _width : width of the next panel; inf after a closed motion, where the first one is guessed
    _last : the panel before, whose polynomial is the first guess on the next; None after a turn or a closed motion
    _kinks : times at which births bend, one, two or three delays after breaks do
    _levels : positions at which the contacts' force bends, until the slider passes them
    _way : direction of the drive, that of the last leg in a hold
    _leg : of the drive; _panels, _turns : how many there were, which are limited
    """

    def __init__(
        self,
        contacts: Contacts,
        drive: Drive,
        motion: Motion,
        record: Record,
        tolerance: float,
        until: float,
    ) -> None:
        """At rest, in balance, at t = 0; `tolerance` is that of the force, a length."""
        law, unit = contacts.thresholds, contacts.mean_threshold
        mass = float(drive.mass or 0.0)
        self._machine = Machine(mass, drive.damping, float(drive.spring or 0.0), unit)
        self._motion, self._record, self._until = motion, record, until
        self._tolerance, self._accuracy = tolerance, OF_PANEL * tolerance
        survival = Survival(law)
        self._largest = survival.longest
        self._contacts = Cohorts.at_start(contacts, survival)
        self._past = PastBreaks(contacts.waiting_time, self._contacts.unbroken())
        self._sliding = FastSliding(law, max([float(law.isf(FEW)), *law.atoms[0]]))
        self._state, self._leg = State(0.0, 0.0, 0.0), 0
        self._work = self._damped = self._on_contacts = 0.0
        self._panels = self._turns = 0
        self._last: Panel | None = None
        self._width = np.inf
        # places at which the contacts' force has a kink when the slider passes them
        self._levels = list[float]()
        if contacts.start.is_single:
            start = contacts.start.mean()
            for kink in law.breakpoints[law.breakpoints > abs(start)].tolist():
                self._levels += [kink - start, -kink - start]
        self._kinks = list[float]()
        moving = motion.speeds[motion.speeds != 0.0]
        self._way = int(np.sign(moving[0])) if moving.size else 1
        self._kink(0.0)
        self.stored_first = self._contacts.stored(0.0)

    @property
    def nodes(self) -> int:
        """Instants at which the motion was solved."""
        return self._panels * NODES.size

    def _drive(self, t: float | Array) -> Array:
        """X_T on the present leg."""
        motion, leg = self._motion, self._leg
        return np.asarray(motion.positions[leg] + motion.speeds[leg] * (t - motion.times[leg]))

    @property
    def _speed(self) -> float:
        """dX_T/dt."""
        return float(self._motion.speeds[self._leg])

    def _leg_end(self) -> float:
        return float(self._motion.times[self._leg + 1])

    def _next_leg(self) -> None:
        """Go on to the next leg."""
        self._state = self._state._replace(t=self._leg_end())
        self._kink(self._state.t)
        self._leg += 1
        if self._leg < self._motion.speeds.size:
            self._way = int(np.sign(self._speed)) or self._way

    def _kink(self, t: float) -> None:
        """The rate of breaks has a kink at t, and that of births one delay later, a smoother one after two."""
        self._kinks += [t + k * self._past.delay for k in range(1, ECHOES + 1)]

    def _out(self) -> bool:
        """Whether hardly any contact holds."""
        held = self._contacts.response(np.array([self._state.x])).holding[0]
        return bool(held * 4.0 * self._largest <= ALIKE * self._tolerance)

    def _near(self, x: float) -> float:
        """Positions nearer than that are the same."""
        return SAME * self._accuracy / (1.0 + self._machine.spring) + 1e-14 * abs(x)

    def _write_contacts(self, at: int, contacts: Cohorts, x: float) -> None:
        """The state of the contacts at one asked time."""
        held = contacts.response(np.array([x]))
        # where hardly any holds it may be below 0 by its error
        self._record.holding[at] = max(float(held.holding[0]), 0.0)
        self._record.contact_force[at] = held.force[0]
        self._record.stored[at] = contacts.stored(x)

    def _instant(self, t: float, x: float, breaks: float) -> Instant:
        """The slider at a time on the present leg."""
        drive = float(self._drive(t))
        return Instant(t, drive, x, self._machine.spring * (drive - x), breaks)

    def _watched(
        self,
        times: Array,
        places: tuple[Array, Array],
        held: Array,
        drives: Array,
        at: Callable[[float], Instant],
        when: Callable[[int], float],
    ) -> Watched:
        """For the record: X and dX/dt, the share that holds, and X_T, at these times."""
        (x, speed), way, forces = places, self._way, self._machine.spring * (drives - places[0])
        return Watched(times, way * speed, x, forces, held, way * self._speed, way, at, when)

    def _form_lump(self) -> None:
        """Contacts that broke together form again together."""
        share, x = self._past.form_lump(), self._state.x
        self._contacts = self._contacts.and_born(np.array([x]), np.array([share]), x)

    def _form_rest(self) -> None:
        """The few contacts that are due, and formed on no panel, do so now."""
        past, x = self._past, self._state.x
        rest = past.born(self._state.t) - past.formed
        if abs(rest) > 1e-17:
            self._contacts = self._contacts.and_born(np.array([x]), np.array([rest]), x)
            past.formed += rest
