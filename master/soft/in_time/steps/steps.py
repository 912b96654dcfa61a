"""Steps of a chosen size on one leg of the drive's motion, at whose ends the forces balance."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.outcome import FaultError
from master.soft.in_time.contacts import ContactsInSteps, Trial
from master.soft.in_time.groups import UNACCOUNTED
from master.soft.in_time.steps.balance import Root, TriedStep, before_exact, secant
from master.soft.in_time.steps.time_units import TimeUnits


class StepControl(NamedTuple):
    """Numbers of the control of steps; none has a unit, as each is relative to a size, a length or another step.

    coarsest : travel of the coarsest step of the size 1, in lengths over which births change. Errors fall with the
        square of the steps: of the slip in `SlipBegins.up_to_slip` from 4e-3 to 6e-5 in three halvings. `force_error`
        need not fall so: it follows the changes of answers that are extrapolated already (answer/extrapolation.py).
    drive_weight : time units in which the slider, stuck to the drive, travels by `Steps.length`. Below 1 as its travel
        matters more, above 0 as something must count while contacts creep under a slider that hardly moves.
    e_folds : ln of the factor by which the number that holds may fall on a step of the size 1: of fresh contacts that
        heat breaks at rest (`Steps.begin_section`), or of all near a slip (`SlipBegins.resolving_factor`).
    beyond_drive : least size, in steps, that `Steps.longest` allows, as the slider may go farther than its drive
    back : a step is solved again with the other sign if it leads against `Steps.sign` by this part of its time units
    time_fractions : of a step's size, from the latest on, where a balance before exact thresholds break is looked for
    """

    coarsest: float = 0.5
    drive_weight: float = 0.25
    e_folds: float = 0.5
    beyond_drive: float = 0.03
    back: float = 0.5
    time_fractions: tuple[float, ...] = (
        *(1.0, 0.999, 0.99, 0.97, 0.94, 0.9, 0.8, 0.7, 0.6, 0.45, 0.3, 0.2, 0.1, 0.03),
    )


CONTROL = StepControl()
# Fraction of a section's first step that is time, as long as none is known: travel and time count alike.
FIRST_FRACTION = 0.5
# What may be left of the imbalance, in mean thresholds: it counts as an error of F.
BALANCED = 1e-8
# Factor on the time on a step, from the delay on, at which a balance is looked for.
LONGER_WAIT = 10.0
# Of K X_T, rounding of K (X_T - X), where X is a sum over thousands of steps.
ROUNDED_LOAD = 1e-12


class Node(NamedTuple):
    """The end of a step: the sum of the sizes of its section's steps so far (see Steps), and the state; time and
    position are counted from the beginning of the path, breaks from there or the last slip that replaced all."""

    sizes_so_far: float
    time: float
    force: float
    holding: float
    position: float
    breaks: float = np.nan

    def shifted(self, time: float, position: float) -> "Node":
        """The same state, later by this time and farther by this way."""
        return self._replace(time=self.time + time, position=self.position + position)


class Guess(NamedTuple):
    """Where the search for a balanced step begins; it changes where that ends by its accuracy only.

    time_fraction : of the step's size that is time
    slope : of the imbalance over the time units (a length)
    """

    time_fraction: float
    slope: float


class Steps:
    """Steps of contacts on one leg of the drive's motion X_T(t), as long as births are smooth.

    `begin_section` comes first, at each begin of a smooth section. `step` gives the balanced step of a size and changes
    nothing: the caller takes it. It also gives the slope of the imbalance, from which SlipBegins searches next.

    contacts, spring : whose steps they are, and K/(N_c <k>)
    length : the travel of a step of the size 1 that takes no time (a length)
    sign : that of the slider's motion, along which travels and imbalances are counted: that of the drive; in a hold
        that of F, as the slider creeps the way the spring pulls; the other one after `turn_round`
    section_end : time up to which births are smooth
    first_guess : for the first step of all
    """

    def __init__(self, contacts: ContactsInSteps, spring: float, drive: Motion) -> None:
        self.contacts, self.spring, self._drive_motion = contacts, spring, drive
        self.length = CONTROL.coarsest * contacts.memory.scales.length
        self.sign = 1.0
        slope = (1.0 + spring) * (1.0 + 1.0 / CONTROL.drive_weight) * self.length
        self.first_guess = Guess(FIRST_FRACTION, slope)

    def begin_section(self, leg: int, end: float) -> None:
        """Begin steps on a leg of the drive's motion, smooth up to the time `end`."""
        contacts, speed = self.contacts, float(self._drive_motion.speeds[leg])
        scales = contacts.memory.scales
        self.sign = float(np.sign(speed) or np.sign(contacts.force) or 1.0)
        # time units per time: as a stuck slider travels, and as fresh contacts break by heat
        uniform = 0.0
        if speed:
            # while contacts hold, the slider moves K/(1 + K) times as fast as the drive
            stuck = abs(speed) * self.spring / (1.0 + self.spring)
            uniform = CONTROL.drive_weight * stuck / self.length + scales.rate / CONTROL.e_folds
        self._time_units = TimeUnits(contacts.now, end, uniform, scales.time)
        self.section_end = end

    def size(self, trial: Trial) -> float:
        """The size of a step."""
        time_part = self._time_units.at(trial.end) - self._time_units.at(self.contacts.now)
        return time_part + self.travelled(trial)

    def travelled(self, trial: Trial) -> float:
        """The part of a step's size that is travel."""
        return self.sign * trial.travel / self.length

    def runs_back(self, trial: Trial) -> bool:
        """Whether the slider runs against `sign` by so much that its travel, which then lowers the size, is no longer
        small beside its time units: no step of a small size leads there, and the one that balances may be as long as
        the section."""
        time_part = self.size(trial) - self.travelled(trial)
        return self.travelled(trial) < -CONTROL.back * time_part

    def turn_round(self) -> None:
        """Count travels and imbalances the other way, as the spring may pull the slider away from a slow drive."""
        self.sign = -self.sign

    def longest(self) -> float:
        """The largest size that is of use for the next step; inf in a hold.

        No step takes time beyond the section's end: what a size has left there would be travel without balance. A step
        up to there has the size time_part + travel/length if the slider goes as far as its drive. This is twice that,
        as it goes farther before a slip; and at least CONTROL.beyond_drive, but for exact thresholds."""
        contacts, end = self.contacts, self.section_end
        travel = float(np.ptp(self._drive_motion.at(np.array([contacts.now, end]))))
        time_part = self._time_units.at(end) - self._time_units.at(contacts.now)
        least = 0.0 if contacts.memory.exact else CONTROL.beyond_drive * 0.5**contacts.halvings
        return max(2.0 * (time_part + travel / self.length), least) if travel else np.inf

    def imbalance(self, trial: Trial) -> float:
        """The spring's force minus that of the contacts, along the motion (a length): above 0 the slider moves on."""
        stretch = self._drive_motion.at(np.array(trial.end)) - self.contacts.position - trial.travel
        return float(self.sign * (self.spring * stretch - trial.force))

    def check_balance(self, what: str, told: float, now: Node) -> None:
        """FaultError unless the forces in this state, K (X_T - X) and F, differ by the imbalance that was `told` (a
        length, along the motion): that of the step's trial, or what is left at the end of a slip. Rounding is that
        of X_T on a stiff spring, and of F."""
        load = self.spring * float(self._drive_motion.at(np.array(now.time)))
        imbalance = self.sign * (load - self.spring * now.position - now.force)
        rounding = UNACCOUNTED * self.contacts.unit + ROUNDED_LOAD * abs(load)
        if not abs(imbalance - told) <= rounding:
            raise FaultError(
                f"the forces do not balance after {what} to t = {now.time:.6g}, X = {now.position:.6g}: the spring "
                f"pulls by {load - self.spring * now.position:.6g}, contacts by {now.force:.6g}, where the two were "
                f"to differ by {told:.3g}, a fault of the program"
            )

    def tried(self, size: float, time_part: float, slope: float) -> TriedStep:
        """The step of this size of which so much is time; `slope`: of the imbalance, where that is below 0."""
        now, taken = self.contacts.now, max(time_part, 0.0)
        # the time after no time units may differ from now by rounding
        end = max(self._time_units.time(self._time_units.at(now) + taken), now) if taken else now
        trial = self.contacts.trial(self.sign * self.length * (size - taken), end)
        return TriedStep(time_part, trial, self.imbalance(trial) + slope * min(time_part, 0.0))

    def step(self, size: float, guess: Guess) -> Root:
        """The balanced step of this size, or up to the section's end, looked for from a guess.

        The more of its size is time, the farther the drive gets and the less the slider travels: the imbalance rises
        with the time units, but for the first of them after a slip, and its root is the balance. Where the root is
        below 0 there is none after a step of this size, see TriedStep. It is found to the last digits of the time.
        """
        here, slope = self.contacts, guess.slope
        accuracy = max(here.memory.balance * size, self._time_units.last_digits(here.now))
        tried = partial(self.tried, size, slope=slope)
        small = accuracy * self.first_guess.slope
        root = secant(tried, tried(guess.time_fraction * size), slope, accuracy, small)
        # where contacts break fast, and time units are long, F changes by much on a tiny part of a step
        finer = (
            accuracy * BALANCED * here.unit / max(abs(root.step.imbalance), BALANCED * here.unit)
        )
        finer = max(finer, self._time_units.last_digits(here.now))
        if root.converged and finer < accuracy:
            small *= finer / accuracy
            root = secant(tried, root.step, root.slope, finer, small)
        if root.step.time_part < 0.0 and here.delay:
            waited = self._behind_delay(partial(self.tried, slope=slope), size)
            root = root if waited is None else secant(tried, waited, slope, accuracy, small)
        if root.step.time_part < 0.0 and self.contacts.memory.exact:
            # F jumps where exact thresholds break: the secant may have passed a balance just before that
            before = before_exact(tried, size * np.array(CONTROL.time_fractions), accuracy)
            return root if before is None else Root(before, root.slope, converged=True)
        return root

    def _behind_delay(
        self, tried: Callable[[float, float], TriedStep], size: float
    ) -> TriedStep | None:
        """A step of this size after which contacts pull more than the spring, on which more than a delay passes; None
        where none is found. In less time none of those that break on it form again, and the spring may pull more:
        of steps that are far longer than the delay, as on soft springs, those of no time tell nothing."""
        now, waits = self.contacts.now, self.contacts.delay
        while (waits := LONGER_WAIT * waits) < np.inf:
            time_part = self._time_units.at(now + waits) - self._time_units.at(now)
            if time_part >= size:
                return None
            step = tried(size, time_part)
            if step.imbalance < 0.0:
                return step
        return None
