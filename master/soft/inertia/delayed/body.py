"""The state of a slider with mass and its contacts, which form again after a delay: what motions change and record."""

from collections.abc import Callable

import numpy as np

from master.outcome import NUMBERS, FaultError
from master.soft.inertia.body import QUIET
from master.soft.inertia.delayed.cohorts import Cohorts
from master.soft.inertia.delayed.collocation import SliderConstants, SliderState
from master.soft.inertia.delayed.drive_path import DrivePath
from master.soft.inertia.delayed.panel import FORCE, TimePanel
from master.soft.inertia.delayed.past_breaks import PastBreaks
from master.soft.inertia.delayed.survival import Survival
from master.soft.inertia.reaction import ALIKE
from master.soft.inertia.record import NOTHING_SPENT, Instant, Record, Spent, Watched, crossing
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array

# Error of a panel, in units of the tolerance of the force: ringing that is smaller counts as rest.
OF_PANEL = QUIET
# Difference of two places that count as one, in units of the error of a panel; and in units of the place, of which it
# is some fifty times the rounding.
SAME, SAME_ROUNDED = 0.1, 1e-14
# Force per contact that holds, in longest stretches, for whether hardly any holds: on the safe side of 1.
MOST_FORCE = 4.0
# Difference of the force that a panel tells of its end and that of the contacts there, in tolerances of the force, from
# which on it is a fault: 50 times the error that a panel may have, 30 times the largest one measured.
FORCES = 1.0
# Number of new cohorts after which those that are alike are merged; and what that changes in the force later, in units
# of the error of a panel.
MANY, OF_MERGING = 50, 0.1
# Share of the contacts below which those that are due to form are the rounding of the births.
LEAST_REST = 1e-17


class DelayedBody:
    """A slider at an instant, its contacts, and the leg of its drive: all that the two kinds of motion have in common.

    OnPanels and Swinging read it, and change it by its methods alone: `take_panel` and `take_swing` at the end of each
    of their motions, and between them `take_time`, `end_leg`, `form_lump` and `break_together`.

    machine, drive : given; of the drive the leg changes
    tolerance, accuracy : of the force, and the error that a panel may have (lengths)
    state : time, X and dX/dt
    contacts : cohorts that have formed up to now
    past : breaks up to now, which are the births to come
    spent : energies from t = 0 up to now
    contact_force : F at the end of the last panel (a length)
    """

    def __init__(
        self, contacts: Contacts, drive: Drive, path: DrivePath, record: Record, tolerance: float
    ) -> None:
        """At rest, in balance, at t = 0; `tolerance` is that of the force, a length."""
        mass, spring = float(drive.mass or 0.0), float(drive.spring or 0.0)
        self.machine = SliderConstants(mass, drive.damping, spring, contacts.mean_threshold)
        self.drive, self._record = path, record
        self.tolerance, self.accuracy = tolerance, OF_PANEL * tolerance
        self.state = SliderState(0.0, 0.0, 0.0)
        self.contacts = Cohorts.at_start(contacts, Survival(contacts.thresholds))
        self.past = PastBreaks(contacts.waiting_time, self.contacts.unbroken())
        self.past.kink(0.0)
        self.spent, self.contact_force = NOTHING_SPENT, 0.0
        self._many = MANY

    def take_panel(
        self,
        panel: TimePanel,
        end: SliderState,
        contacts: Cohorts,
        formed: float,
        spent: Spent,
        steady: bool = False,
    ) -> None:
        """Be where a panel ends, with these contacts, of which a share `formed` on it, and with what was spent on it.

        The order counts: the breaks and births of the panel are told first, as those who are due by them, and have not
        formed, form now; after a `steady` panel they wait, as its births are those of the speed, which differ from the
        breaks one delay before by what both miss. FaultError where more or fewer contacts hold than have formed and not
        broken, or where they pull by another force than the panel told.
        """
        self.past.add(panel)
        self.past.formed += formed
        self._go_to(end, contacts, spent, form_rest=not steady)
        self._check_number()
        self.contact_force = float(panel.at(panel.end, FORCE))
        self._check_force(self.contact_force)
        if self.contacts.born.size > self._many:
            self.contacts = self.contacts.merged(OF_MERGING * self.accuracy, self.near(end.x))
            self._many = MANY + self.contacts.born.size

    def _check_number(self) -> None:
        """FaultError unless as many contacts hold, by their survivals, as have formed and not broken by the past. Both
        differ by what panels miss: by up to 0.06 of the tolerance (measured on seven motions)."""
        past, unit = self.past, self.machine.unit
        expected, holding = past.holding(past.formed, past.breaks), self.contacts.unbroken()
        if abs(expected - holding) > NUMBERS * self.tolerance / unit:
            raise FaultError(
                f"number is not conserved: at t = {self.state.t:.6g}, X = {self.state.x:.6g} a share {holding:.6g} of "
                f"the contacts holds, and {expected:.6g} have formed and not broken, a fault of the program"
            )

    def _check_force(self, expected: float) -> None:
        """FaultError unless the contacts, by their survivals, pull as the panel told of its end (a length). Both differ
        by what panels miss: by up to 0.03 of the tolerance (measured on eight motions)."""
        force = float(self.contacts.response(np.array([self.state.x])).force[0])
        if abs(expected - force) > FORCES * self.tolerance:
            raise FaultError(
                f"forces do not agree: at t = {self.state.t:.6g}, X = {self.state.x:.6g} the contacts pull "
                f"by {force:.6g}, and at the end of the panel by {expected:.6g}, a fault of the program"
            )

    def take_swing(self, state: SliderState, contacts: Cohorts, spent: Spent) -> None:
        """Be where a closed motion ends, with what was spent on it."""
        self._go_to(state, contacts, spent)

    def take_rings(self, state: SliderState, contacts: Cohorts, spent: Spent, reach: float) -> None:
        """The same of many swings in which few contacts formed, who do so together at the end. The next swing stretches
        them by up to `reach`: those that this breaks are broken, and what they take is taken from the speed."""
        self._go_to(state, contacts, spent, form_rest=False)
        formed = self.past.born(state.t) - self.past.formed
        if formed <= LEAST_REST:
            return
        taken = formed * self.contacts.survival.released(reach)
        left = max(state.w**2 - 2.0 * taken / self.machine.mass, 0.0)
        self.state = state._replace(w=float(np.copysign(np.sqrt(left), state.w)))
        of_motion = 0.5 * self.machine.mass * (state.w**2 - left)
        self.spent = self.spent.plus(Spent(0.0, 0.0, of_motion))
        here = np.array([state.x])
        self.contacts = self.contacts.and_born(here, np.array([formed]), state.x - reach)
        self.past.formed += formed

    def _go_to(
        self, state: SliderState, contacts: Cohorts, spent: Spent, form_rest: bool = True
    ) -> None:
        """Be there, with this spent on the way; the few contacts that are due, and formed on no panel, do so now."""
        self.state, self.contacts = state, contacts
        self.spent = self.spent.plus(spent)
        rest = self.past.born(state.t) - self.past.formed
        if form_rest and abs(rest) > LEAST_REST:
            self._form(rest)
            self.past.formed += rest

    def take_time(self, t: float) -> None:
        """The same at a time that differs by rounding."""
        self.state = self.state._replace(t=t)

    def end_leg(self) -> None:
        """Go on to the next leg of the drive, whose speed changes that of the breaks."""
        self.take_time(self.drive.leg_end)
        self.past.kink(self.state.t)
        self.drive.next_leg()

    def form_lump(self) -> None:
        """Contacts that broke together form again together."""
        self._form(self.past.form_lump())

    def break_together(self, x: float, before: float) -> None:
        """Contacts at an exact threshold break at this place, of a share `before` that held."""
        self.contacts = self.contacts.moved(x)
        self.state = self.state._replace(x=x)
        self.past.add_lump(self.state.t, before - self.contacts.unbroken())

    def _form(self, fraction: float) -> None:
        """So many contacts form here and now."""
        x = self.state.x
        self.contacts = self.contacts.and_born(np.array([x]), np.array([fraction]), x)

    @property
    def spring_force(self) -> float:
        """K (X_T - X), per N_c<k> (a length)."""
        return self.machine.spring * (float(self.drive.at(self.state.t)) - self.state.x)

    @property
    def contact_force_here(self) -> float:
        """F by the contacts' survivals (a length)."""
        return float(self.contacts.response(np.array([self.state.x])).force[0])

    @property
    def net_force(self) -> float:
        """K (X_T - X) - F, per N_c<k> (a length)."""
        return self.spring_force - self.contact_force_here

    @property
    def hardly_any_holds(self) -> bool:
        """Whether so few contacts hold that their force is below the tolerance."""
        holding = self.contacts.response(np.array([self.state.x])).holding[0]
        longest = MOST_FORCE * self.contacts.survival.longest
        return bool(holding * longest <= ALIKE * self.tolerance)

    def near(self, x: float) -> float:
        """Positions nearer than that are the same."""
        return SAME * self.accuracy / (1.0 + self.machine.spring) + SAME_ROUNDED * abs(x)

    def asked(self, begin: float, end: float) -> slice:
        """Which of the asked times lie on a motion."""
        return self._record.between(begin, end)

    def asked_times(self, which: slice) -> Array:
        """The asked times."""
        return self._record.times[which]

    def write(self, at: int, state: SliderState, contacts: Cohorts, spent: Spent) -> None:
        """The results at one asked time on a motion; `spent` since the motion began."""
        record, response = self._record, contacts.response(np.array([state.x]))
        record.write(at, state.x, state.w, response.force[0], self.spent.plus(spent))
        # where hardly any holds it may be below 0 by its error
        record.holding[at] = max(float(response.holding[0]), 0.0)
        record.stored[at] = contacts.stored(state.x)

    def instant(self, t: float, x: float, breaks: float) -> Instant:
        """The slider at a time on the present leg, for the record."""
        drive = float(self.drive.at(t))
        return Instant(t, drive, x, self.machine.spring * (drive - x), breaks)

    def watched(
        self,
        times: Array,
        drives: Array,
        places: Array,
        holding: Array,
        speed: Callable[[Array | float], Array],
        at: Callable[[float], Instant],
    ) -> Watched:
        """For the record: X_T, X and the share that holds at these times, by a clock of the caller's, at whose times
        dX/dt is `speed` and the slider is `at`."""
        way = self.drive.direction
        drive_speed, forces = way * self.drive.speed, self.machine.spring * (drives - places)

        def when(index: int) -> float:
            def excess(t: float) -> float:
                return way * float(speed(t)) - max(drive_speed, 0.0)

            return crossing(excess, times[index], times[index + 1])

        speeds = way * speed(times)
        return Watched(times, speeds, places, forces, holding, drive_speed, way, at, when)
