"""Steps of a slider with mass: one step, at whose end the slider is where its own closed motion leads it.

On a step of the time h the contacts' force is that at the begin, F_0, plus what their stiffness κ makes of the travel
y, plus what is left, which grows evenly to r at the end, as contacts break and form:

    M y'' + γ y' + K y = K (X_T - X_0) - F,        F = F_0 + κ y + r t/h,        r = F_1 - F_0 - κ d.

This is a damped oscillator in closed form (`Oscillation`). Its travel y(h) has to be the travel d by which the contacts
were moved; F_1 hangs on d. An elastic slider is followed exactly on steps of any size, others to second order.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.motion import Motion
from master.outcome import FaultError, StoppedError
from master.soft.in_time.contacts import ContactsInSteps, Trial
from master.soft.in_time.steps import CONTROL, Guess, Root, Steps
from master.soft.in_time.steps.time_units import TimeUnits
from master.soft.inertia.oscillation import Held, Oscillation, Pulled
from master.soft.inertia.record import Spent
from origins.drive import Drive
from origins.thresholds.numerical import clipped

# Phase (radians) on the coarsest step, if the slider did not travel, of its swing on MORE_HOLD times the contacts
# that hold: contacts are moved evenly, and break by heat as if their stretch grew so. With 0.5 a full swing takes 13
# steps or more.
PHASE = 0.5
# Times that phase where the swing is smaller than this part of the coarsest travel, until it is so many times as large:
# the swing itself is followed exactly, and moving the contacts evenly is off by [swing] [phase]²/8 at most.
MORE_PHASE, SMALL_SWING, LARGE_AGAIN = 3.0, 0.03, 4.0
# Times the share of contacts that holds at the begin of a section up to which its steps follow the swing on them.
MORE_HOLD = 4.0
# Part of a step's size in which the turn at its end is found; and halvings of a step behind a turn, in search of one on
# which the slider does not turn yet.
AT_TURN, HALVINGS_BEHIND_TURN = 1e-8, 12
# Least time of that step, in last digits of the time: a turn is not known better.
IN_DIGITS = 4.0
# Speed, in coarsest travels in the time of a radian of the swing, below which a slider that turns is taken as at rest:
# rounding of its forces.
NO_SPEED = 1e-9
# The same at a turn that was found, in these or in the speed before it: where it is larger, steps have a gap there.
STILL_MOVES = 1e-3
# A step is taken as it is while at most so many times as many e-folds of contacts break on it as CONTROL allows; and
# the least factor on its size where more do.
BELIEVED, LEAST_SHRINK = 1.5, 0.03
# Acceleration at a turn, in mean thresholds of force, below which it is rounding: the slider then starts as its drive.
NO_PULL = 1e-10


class Swung(NamedTuple):
    """A balanced step, not taken yet.

    trial : where it leads the contacts; motion : the slider's closed motion on it, from its begin on
    speed : dX/dt at its end; turns : whether the slider turns round there
    """

    trial: Trial
    motion: Oscillation
    speed: float
    turns: bool


class SwingSteps(Steps):
    """Steps of a slider with mass on one leg of its drive's motion, between two turns of the slider.

    speed : dX/dt now, which the caller sets after each step that it takes
    sign : of the slider's motion in this section
    """

    def __init__(self, contacts: ContactsInSteps, drive: Drive, motion: Motion) -> None:
        """Steps of these contacts, from rest."""
        super().__init__(contacts, float(drive.spring or 0.0), motion)
        self.mass, self.damping, self.speed = float(drive.mass or 0.0), drive.damping, 0.0
        self._fastest, self._time_fraction = self._swings_at(1.0), 0.5
        self._most_holding = self._shrink = 1.0
        self._drive_speed, self._rate, self._is_small = 0.0, self._fastest / PHASE, False

    def _swings_at(self, holding: float) -> float:
        """How fast the slider swings while this share of the contacts holds, or comes to rest, where that is slower
        (radians, or e-folds, per time)."""
        stiff = holding + self.spring
        slowest = stiff / self.damping if self.damping else np.inf
        return float(min((stiff / self.mass) ** 0.5, slowest))

    @property
    def pull(self) -> float:
        """The spring's force minus that of the contacts now (a length), along X."""
        here = self.contacts
        drive = float(self._drive_motion.at(np.array(here.now)))
        return self.spring * (drive - here.position) - here.force

    def begin_section(
        self, leg: int, end: float, swing: float = np.inf, goes_on: bool = False
    ) -> None:
        """Begin steps on a leg of the drive's motion up to the time `end`, or to the slider's next turn, with a swing
        of this size (a length); `goes_on`: whether the section follows another of this leg, behind which contacts go on
        as they were."""
        contacts = self.contacts
        scales, self._drive_speed = contacts.memory.scales, float(self._drive_motion.speeds[leg])
        pull = self.pull
        pull = pull if abs(pull) > NO_PULL * contacts.unit else 0.0
        way = self.speed or pull or self._drive_speed or contacts.force or 1.0
        self.sign = float(np.sign(way))
        self._is_small = self._counts_as_small(swing)
        phase = MORE_PHASE * PHASE if self._is_small else PHASE
        self._most_holding = min(MORE_HOLD * contacts.holding, 1.0)
        self._rate = self._swings_at(self._most_holding) / phase + scales.rate / CONTROL.e_folds
        # no first changes are to be resolved that are quicker than the slider can follow
        first = np.inf if goes_on else max(scales.time, 1.0 / self._fastest)
        self._time_units = TimeUnits(contacts.now, end, self._rate, first)
        self.section_end = end

    def _counts_as_small(self, swing: float) -> bool:
        """Whether a swing of this size is small."""
        most = SMALL_SWING * self.length
        return swing < (LARGE_AGAIN * most if self._is_small else most)

    def needs_other_steps(self, swing: float) -> bool:
        """Whether a swing that has this size now asks for steps of other sizes than this section has, or more contacts
        hold than it has steps for."""
        harder = self._most_holding < min(self.contacts.holding, 1.0)
        return harder or self._counts_as_small(swing) != self._is_small

    def swing_of(self, swung: Swung) -> tuple[float, float]:
        """Departure from its balance of a slider at the end of a step that is not taken yet, and its speed."""
        lasts = swung.trial.end - self.contacts.now
        return float(np.abs(swung.motion.departure(lasts))), float(
            np.abs(swung.motion.departure(lasts, 1))
        )

    def motion_of(self, trial: Trial) -> Oscillation:
        """The slider's closed motion on this step, which takes time."""
        contacts, lasts = self.contacts, trial.end - self.contacts.now
        rate = self.spring * self._drive_speed - self._left(trial) / lasts
        given = self.mass, self.damping, self.spring + contacts.holding, self.pull, rate
        return Oscillation.of(*given, 0.0, self.speed)

    def spent(self, swung: Swung) -> Spent:
        """Energies on a step that is not taken yet."""
        contacts, trial = self.contacts, swung.trial
        lasts, force = trial.end - contacts.now, self.pull + contacts.force
        pulled = Pulled(self.spring, self.damping, self._drive_speed, force)
        held = Held(contacts.holding, contacts.force, self._left(trial) / lasts)
        return swung.motion.spent(lasts, trial.travel, pulled, held)

    def _left(self, trial: Trial) -> float:
        """What of the contacts' force on a step is left beside their stiffness (a length)."""
        return trial.force - self.contacts.force - self.contacts.holding * trial.travel

    def imbalance(self, trial: Trial) -> float:
        """How much farther the slider moves in the time of this step than its contacts were moved (a length)."""
        lasts = trial.end - self.contacts.now
        moved = float(self.motion_of(trial).travel(lasts)) if lasts else 0.0
        return self.sign * (moved - trial.travel)

    def next_resolved(self, size: float) -> Swung:
        """The balanced step of this size, or a shorter one, on which not too many contacts break."""
        while True:
            swung = self.next_step(size * self._shrink)
            taken = min(self.size(swung.trial), size * self._shrink)
            factor = self._resolving_factor(swung.trial, taken)
            if taken <= BELIEVED * factor * size:
                self._shrink = min(factor, 1.0)
                return swung
            self._shrink = max(min(factor, 0.7 * self._shrink), LEAST_SHRINK)
            if taken <= LEAST_SHRINK * size:
                return swung

    def _resolving_factor(self, trial: Trial, size: float) -> float:
        """The factor on the size of steps at which as many contacts break on one as is resolved; at most 1."""
        holding = self.contacts.holding
        if trial.kept >= holding or size <= 0.0:
            return 1.0
        loss = np.log(holding / trial.kept) / size if trial.kept > 0.0 else np.inf
        return float(clipped(CONTROL.e_folds / loss, LEAST_SHRINK, 1.0))

    def next_step(self, size: float) -> Swung:
        """The balanced step of this size, or a shorter one up to the section's end, or to the slider's turn."""
        found, swung = self._solved(size)
        least = -NO_SPEED * self.length * self._fastest
        if found.converged and self.sign * swung.speed >= least:
            self._time_fraction = found.step.time_part / size
            return swung
        return self._to_turn(size)

    def _solved(self, size: float) -> tuple[Root, Swung]:
        """The balanced step of this size, and the motion on it, also if the slider turned before its end."""
        slope = self.length + abs(self.speed) / self._rate
        root = self.step(size, Guess(self._time_fraction, slope))
        trial = root.step.trial
        lasts = trial.end - self.contacts.now
        if not lasts:  # it has not converged
            trial = self.contacts.trial(0.0, self.contacts.now + size / self._rate)
            lasts, root = trial.end - self.contacts.now, root._replace(converged=False)
        if not lasts:
            raise StoppedError(_too_fine(self.contacts.now))
        # a step that leads through the turn ahead, and back beyond the place where it began, is none
        if self.sign * trial.travel < 0.0:
            root = root._replace(converged=False)
        motion = self.motion_of(trial)
        return root, Swung(trial, motion, float(motion.speed(lasts)), turns=False)

    def _to_turn(self, size: float, tried_other: bool = False) -> Swung:
        """The step to where the slider turns round, which it does before one of this size ends. From a turn, where it
        moves neither way on any step that is tried, FaultError."""
        shortest = IN_DIGITS * float(np.spacing(self.contacts.now)) * self._rate

        def ahead(at: float) -> float:
            """The speed along the motion at the end of a step; below 0 where none has this size."""
            if at < shortest:
                return abs(self.speed)
            found, swung = self._solved(at)
            return self.sign * swung.speed if found.converged else -1.0

        low, high = 0.0, size
        if not self.speed:
            low = size
            for _ in range(HALVINGS_BEHIND_TURN):
                low, high = 0.5 * low, low
                if ahead(low) > 0.0:
                    break
            else:
                if tried_other:
                    raise FaultError(
                        f"the slider moves neither way from rest at t = {self.contacts.now:.6g}, a fault of the program"
                    )
                self.sign = -self.sign
                found, swung = self._solved(size)
                ahead_there = found.converged and self.sign * swung.speed >= 0.0
                return swung if ahead_there else self._to_turn(size, tried_other=True)
        at = float(brentq(ahead, low, high, xtol=AT_TURN * size))
        _, swung = self._solved(max(at, shortest))
        if abs(swung.speed) > STILL_MOVES * max(abs(self.speed), self.length * self._fastest):
            raise FaultError(f"no turn of the slider is found beyond t = {self.contacts.now:.6g}")
        return swung._replace(speed=0.0, turns=True)


def _too_fine(now: float) -> str:
    """Why no step is taken at this time: it would be no later by the digits that a time has."""
    return f"near t = {now:.9g} steps are shorter than the last digit of t: the mass is too light for so slow a drive"
