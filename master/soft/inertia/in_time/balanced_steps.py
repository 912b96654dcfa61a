"""Steps of a slider with mass that does not swing: forces balance, and the damping follows its slow speed.

With κ the stiffness of the contacts and r what else their force changes by in a step of the time h, the balance of a
slider that rests on its contacts drifts at the speed u = (K v - r/h)/(K + κ). The slider lags behind it, so that its
speed is V = u - γ u'/(K + κ), but for higher derivatives; at the end of the step

    K (X_T - X) - F - γ V = 0.

What this leaves out, M u' and γ³ u''/(K + κ)², is asked to be small: so such steps end long before the slider slips.
"""

from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.soft.in_time.contacts import ContactsInSteps, Trial
from master.soft.in_time.steps import CONTROL, FIRST_FRACTION, Guess, Steps
from master.soft.in_time.steps.time_units import TimeUnits
from master.soft.inertia.record import Spent
from origins.drive import Drive

# Least part of a step's size that is time where a speed is told; a shorter step is taken for one of that time, so that
# the imbalance stays finite. No such step is taken.
LEAST_TIME = 1e-3
# Factor by which the slider gets faster or slower than a section's time units are made for, at which another begins: on
# a soft spring it gets far faster than stuck to its drive, long before inertia matters.
OTHER_SPEED = 8.0
# Part of a step's size, where flights follow: of a slip in closed form the error is that of the rest before it, whose
# steps are few and cheap. The force before the slip of a machine's scan was 13 % off on the coarsest, and is 0.4 %.
BEFORE_FLIGHTS = 0.25


class BalancedStep(NamedTuple):
    """A balanced step, not taken yet.

    trial : where it leads; drift, speed : of the balance in its middle, and dX/dt at its end
    left_out : force of the inertia that it leaves out (a length)
    """

    trial: Trial
    drift: float
    speed: float
    left_out: float


class Drift(NamedTuple):
    """Speed of the balance in the middle of a step.

    middle : the time there; drift : that speed; slope : its change per time since the step before, nan without one
    """

    middle: float
    drift: float
    slope: float


class Drifts:
    """Speeds of the balance in the middle of the last steps, and what of the inertia a step in balance leaves out."""

    def __init__(self, mass: float, damping: float) -> None:
        """Of a slider; no step has been taken."""
        self._mass, self._damping = mass, damping
        self._last: Drift | None = None

    def begin(self) -> None:
        """The drive's speed changes: the drift jumps."""
        self._last = None

    def slope(self, middle: float, drift: float) -> float:
        """u' up to a step with this time in its middle; 0 where no step was before."""
        if self._last is None:
            return 0.0
        return (drift - self._last.drift) / (middle - self._last.middle)

    def left_out(self, middle: float, drift: float, stiff: float) -> float:
        """Force (a length) that a step in balance would leave out; inf where that is not known."""
        if self._last is None or np.isnan(self._last.slope):
            return np.inf
        slope = self.slope(middle, drift)
        bend = abs(slope - self._last.slope) / (middle - self._last.middle)
        return self._mass * abs(slope) + self._damping**3 / stiff**2 * bend

    def add(self, middle: float, drift: float) -> None:
        """A step was taken."""
        slope = np.nan if self._last is None else self.slope(middle, drift)
        self._last = Drift(middle, drift, slope)


class BalancedSteps(Steps):
    """Steps of a slider with mass that follows its drive in balance, on one leg of the drive's motion.

    ends_section : whether the slider's speed at the end of the last step asks for another section
    """

    def __init__(
        self,
        contacts: ContactsInSteps,
        drive: Drive,
        motion: Motion,
        drifts: Drifts,
        before_flights: bool,
    ) -> None:
        """Steps of these contacts, behind those with these drifts; `before_flights`: whether flights may follow."""
        super().__init__(contacts, float(drive.spring or 0.0), motion)
        self.mass, self.damping = float(drive.mass or 0.0), drive.damping
        self._part, self._guess = BEFORE_FLIGHTS if before_flights else 1.0, self.first_guess
        self._drive_speed, self._drifts = 0.0, drifts
        self._least_time, self._pace = 0.0, 0.0
        self.ends_section = self._by_speed = False

    def begin_section(self, leg: int, end: float, speed: float = 0.0) -> None:
        """See Steps; the slider has this speed, by which time is measured where the last section ended for that."""
        super().begin_section(leg, end)
        self._drive_speed = float(self._drive_motion.speeds[leg])
        stuck = abs(self._drive_speed) * self.spring / (1.0 + self.spring)
        self._by_speed = self.ends_section and abs(speed) > stuck > 0.0
        self._pace, self.ends_section = abs(speed) if self._by_speed else stuck, False
        rate, scales = self._time_units.rate, self.contacts.memory.scales
        # no first changes are to be resolved that are quicker than the slider can follow
        first = max(scales.time, (self.mass / self._stiff()) ** 0.5)
        if self._by_speed:
            # contacts go on as they were: no first changes are to be resolved
            rate += CONTROL.drive_weight * (abs(speed) - stuck) / self.length
            first = np.inf
        self._time_units = TimeUnits(self.contacts.now, end, rate, first)
        self._guess = self._guess._replace(time_fraction=FIRST_FRACTION)

    def _stiff(self) -> float:
        return self.spring + self.contacts.holding

    def _speeds(self, trial: Trial) -> tuple[float, float]:
        """The drift in the middle of a step, and dX/dt at its end."""
        contacts = self.contacts
        lasts = max(trial.end - contacts.now, self._least_time)
        left = trial.force - contacts.force - contacts.holding * trial.travel
        drift = (self.spring * self._drive_speed - left / lasts) / self._stiff()
        slope = self._drifts.slope(contacts.now + 0.5 * lasts, drift)
        return drift, drift + slope * (0.5 * lasts - self.damping / self._stiff())

    def imbalance(self, trial: Trial) -> float:
        """The spring's force minus those of contacts and damping, along the motion (a length)."""
        _, speed = self._speeds(trial)
        return super().imbalance(trial) - self.sign * self.damping * speed

    def spent(self, trial: Trial) -> Spent:
        """Energies on a step that is not taken yet, on which speed and forces change evenly."""
        contacts, lasts, travel = self.contacts, trial.end - self.contacts.now, trial.travel
        drive, way = float(self._drive_motion.at(np.array(contacts.now))), self._drive_speed * lasts
        of_spring = self.spring * (drive - contacts.position + 0.5 * (way - travel))
        on_contacts = 0.5 * (contacts.force + trial.force) * travel
        return Spent(of_spring * way, self.damping * travel**2 / lasts, on_contacts)

    def next_step(self, size: float) -> BalancedStep | None:
        """The balanced step of this size; None where there is none, or none is found."""
        size = min(self._part * size, self.longest())
        units, now = self._time_units, self.contacts.now
        least = units.time(units.at(now) + LEAST_TIME * size) - now
        self._least_time = max(least, float(np.spacing(now)))
        root = self.step(size, self._guess)
        for _ in range(2):
            trial = root.step.trial
            if not self.runs_back(trial):
                break
            # the spring pulls the slider away from a slow drive
            self.turn_round()
            near = min(max(self.travelled(trial) / size, 0.0), FIRST_FRACTION)
            root = self.step(size, Guess(1.0 - near, self._guess.slope))
        trial, takes_time = root.step.trial, root.step.time_part > LEAST_TIME * size
        # of first changes that are quicker than the last digit of the time
        takes_time &= root.step.trial.end > now
        if not (root.converged and takes_time):
            return None
        self._guess = Guess(root.step.time_part / size, root.slope)
        drift, speed = self._speeds(trial)
        faster = abs(speed) > OTHER_SPEED * self._pace > 0.0
        slower = self._by_speed and OTHER_SPEED * abs(speed) < self._pace
        self.ends_section = faster or slower
        left_out = self._drifts.left_out(0.5 * (now + trial.end), drift, self._stiff())
        return BalancedStep(trial, drift, speed, left_out)
