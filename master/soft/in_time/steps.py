"""Steps: one step of a slider that a spring pulls, K (X_T - X) = F, and where a slip begins.

A step has a size, and two parts that add up to it: the travel of the slider, in units of `Steps.length`, and steps of
time (see StepCount). The size is chosen; the balance of forces decides how much of it is time. So steps are even both
where the slider creeps, and nearly all is time, and just before a slip, where dX/dt diverges and nearly all is travel
(pseudo-arclength continuation).

A slip begins where a longer step would end earlier: at a fold, where the time of balance, as a function of the size, is
the latest, or where contacts at an exact threshold break and there is no balance from then on.

A slider whose balance has other terms, such as inertia, is a subclass of Steps with an `imbalance` of its own.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from master.motion import Motion
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.groups import Trial
from master.soft.in_time.step_count import StepCount


class StepControl(NamedTuple):
    """Numbers of the control of steps; none has a unit, as each is relative to a size, a length or another step.

    coarsest : travel of the coarsest step of the size 1, in lengths over which births change. Errors fall with the
        square of the steps, and three halvings from here are some 1e-3.
    drive_weight : steps of time in which the slider, stuck to the drive, travels by one step. Below 1 as the slider's
        travel matters more, above 0 as something must count while contacts creep under a slider that hardly moves.
    balance, balance_of_ageing : accuracy of a step's balance, in sizes: far below the errors of a step, which are
        larger where thresholds age.
    onset : accuracy of the begin of a slip, in sizes: X_T is flat there, or has a kink.
    last_jump : accuracy of a size at which exact thresholds break, in sizes: F jumps there, so it is that of rounding.
    beyond_jump : factor on the size of the step that looks beyond a jump of P_c, where F falls at once.
    far_from_slip : steps of time, in those of a slider that is stuck to the drive, above which no slip is near.
    before_fold : factor on the size of the step that tells on which side of a fold a step ends.
    nearing, least_shrink : steps of contacts that age are at most this part of the way to where a slip is foreseen, but
        not below this factor on their size, as a slip that is foreseen may not come.
    """

    coarsest: float = 0.5
    drive_weight: float = 0.25
    balance: float = 1e-9
    balance_of_ageing: float = 1e-7
    onset: float = 1e-9
    last_jump: float = 1e-14
    beyond_jump: float = 1.01
    far_from_slip: float = 0.3
    before_fold: float = 0.99
    nearing: float = 0.25
    least_shrink: float = 0.03


CONTROL = StepControl()
# Fractions of a step's size that may be steps of time, from the latest on: there a balance before exact thresholds
# break is looked for, which a secant from one guess may miss.
TIME_FRACTIONS = np.array(
    [1.0, 0.999, 0.99, 0.97, 0.94, 0.9, 0.8, 0.7, 0.6, 0.45, 0.3, 0.2, 0.1, 0.03]
)
# Most steps of the secant method: bisection alone would reach round-off from any bracket in 52.
MOST_SECANTS = 40


class BalancedStep(NamedTuple):
    """A step at whose end the forces balance.

    time_steps : how much of its size are steps of time. Below 0 if there is no balance from now on: then the step takes
        no time, and this is how far back the balance would be.
    trial : where it leads to
    """

    time_steps: float
    trial: Trial


class Steps:
    """Steps of contacts on one leg of the drive's motion X_T(t), as long as births are smooth.

    It offers `begin` for each smooth section, `step` for a balanced step of a given size, `up_to_slip` to cut it where
    a slip begins, and `size` and `imbalance` of any Trial of the contacts; taking a step is up to the caller.

    spring : K/(N_c <k>)
    length : the travel of a step of the size 1 that takes no time (a length)
    sign : direction in which the spring pulls: travels and imbalances are counted along it
    shrink : factor on the next step's size: 1 far from slips
    """

    def __init__(self, contacts: Cohorts, spring: float, drive: Motion) -> None:
        self._contacts, self.spring, self._drive = contacts, spring, drive
        self.length, self.sign = CONTROL.coarsest * contacts.memory.scales.length, 1.0
        ageing = contacts.memory.finer_before_slips
        self._accuracy = CONTROL.balance_of_ageing if ageing else CONTROL.balance
        # how fast the imbalance grows with the steps of time (a length), at first a guess
        self._imbalance_per_time = (1.0 + spring) * (1.0 + 1.0 / CONTROL.drive_weight) * self.length

    def begin(self, leg: int, end: float) -> None:
        """Begin steps on a leg of the drive's motion, smooth up to the time `end`."""
        scales, speed = self._contacts.memory.scales, float(self._drive.speeds[leg])
        self.sign = float(np.sign(speed) or np.sign(self._contacts.force) or 1.0)
        uniform = 0.0
        if speed:
            # while contacts hold, the slider moves K/(1 + K) times as fast as the drive
            stuck = abs(speed) * self.spring / (1.0 + self.spring)
            uniform = CONTROL.drive_weight * stuck / self.length + scales.rate / CONTROL.coarsest
        self._count, self._end = StepCount(self._contacts.now, end, uniform, scales.time), end
        # the fraction of its size that the last step took in steps of time, unknown yet, and a guess of the next one's
        self._last_time_fraction, self._time_fraction, self.shrink = np.nan, 0.5, 1.0

    def size(self, trial: Trial) -> float:
        """The size of a step."""
        time_steps = self._count.steps(trial.now) - self._count.steps(self._contacts.now)
        return time_steps + self._travelled(trial)

    def longest(self) -> float:
        """Twice the size of a step to the section's end if the slider moves as far as the drive; inf in a hold."""
        now, drive = self._contacts.now, self._drive
        travel = float(np.abs(np.diff(drive.at(np.array([now, self._end])))[0]))
        time_steps = self._count.steps(self._end) - self._count.steps(now)
        return 2.0 * (time_steps + travel / self.length) if travel else np.inf

    def imbalance(self, trial: Trial) -> float:
        """The spring's force minus that of the contacts, along the motion (a length): above 0 the slider moves on."""
        stretch = self._drive.at(np.array(trial.now)) - self._contacts.position - trial.travel
        return float(self.sign * (self.spring * stretch - trial.force))

    def step(self, size: float) -> BalancedStep:
        """The balanced step of this size, or up to the section's end.

        The root is looked for in the number of its steps of time. Below 0, as time does not go back, the imbalance goes
        on as a straight line: a root there says that there is no balance from now on.
        """
        now, slope = self._contacts.now, self._imbalance_per_time
        steps_so_far, last = self._count.steps(now), list[Trial]()

        def imbalance(time_steps: float) -> float:
            later, back = max(time_steps, 0.0), min(time_steps, 0.0)
            time = max(self._count.time(steps_so_far + later), now) if later else now
            last[:] = [self._contacts.trial(self.sign * self.length * (size - later), time)]
            return self.imbalance(last[0]) + slope * back

        accuracy = self._accuracy * size
        found, self._imbalance_per_time = secant(
            imbalance, self._time_fraction * size, slope, accuracy
        )
        if found < 0.0 and self._contacts.memory.exact:
            found = _before_exact(imbalance, size, accuracy, found)
            imbalance(found)
        return BalancedStep(found, last[0])

    def up_to_slip(self, step: BalancedStep, size: float) -> tuple[Trial, bool]:
        """The step that was asked for with this size, or that up to a slip that begins within it; and whether one
        does."""
        size = min(size, self.size(step.trial)) if step.trial.now > self._contacts.now else size
        looks_beyond = self._contacts.jumps and step.time_steps > 0.0
        longest = CONTROL.beyond_jump * size if looks_beyond else size
        slips = self._ends_earlier(step, size, longest) if looks_beyond else self._slips(step, size)
        if not slips:
            self._foresee(step.time_steps / size, size)
            return step.trial, False
        trial = self._latest(size, longest)
        last = self._last_before_exact(size, longest) if self._contacts.memory.exact else None
        if last is not None and last.now > trial.now:
            trial = last
        return trial, trial.now < self._end  # where the section ends, a slip may still be to come

    def _travelled(self, trial: Trial) -> float:
        """The part of a step's size that is travel."""
        return self.sign * trial.travel / self.length

    def _ends_earlier(self, step: BalancedStep, size: float, longer: float) -> bool:
        """Whether a step that is longer than this one ends earlier: behind a jump of P_c, where F falls at once."""
        return self.step(longer).time_steps < size - self._travelled(step.trial)

    def _slips(self, step: BalancedStep, size: float) -> bool:
        """Whether a slip begins before the end of a step of this size."""
        # far from a slip the slider follows the drive, and this part of the size is time
        if step.time_steps > CONTROL.far_from_slip * CONTROL.drive_weight * size:
            return False
        if step.time_steps <= 0.0:
            return True
        # nearer, a fold lies within the step where a shorter one takes as much time or more
        return self.step(CONTROL.before_fold * size).time_steps >= step.time_steps

    def _foresee(self, time_fraction: float, size: float) -> None:
        """Guess the next step from this one's fraction of steps of time, and how far a slip is, where it falls to 0.

        Steps become finer within four of the coarsest before a slip of contacts that age: their thresholds cross |x|
        step by step, and the slip would depend on where those steps end.
        """
        change = float(np.nan_to_num(time_fraction - self._last_time_fraction))
        self._last_time_fraction, self._time_fraction = time_fraction, time_fraction + change
        self.shrink = 1.0
        if self._contacts.memory.finer_before_slips and change < 0.0:
            to_slip = CONTROL.nearing * time_fraction * size / -change
            self.shrink = min(max(to_slip, CONTROL.least_shrink), 1.0)

    def _latest(self, size: float, longest: float) -> Trial:
        """The step up to a fold: that which takes the most time."""
        found = minimize_scalar(
            lambda at: -self.step(at).time_steps,
            bounds=(0.0, longest),
            options={"xatol": CONTROL.onset * size},
        )
        return self.step(float(found.x)).trial

    def _last_before_exact(self, size: float, longest: float) -> Trial | None:
        """The longest step after which there still is a balance, before exact thresholds break, by bisection; None
        where there is none at once."""
        low, high = 0.0, longest
        while high - low > CONTROL.last_jump * size:
            middle = 0.5 * (low + high)
            time_steps = self.step(middle).time_steps
            if time_steps > 0.0:
                low, self._time_fraction = middle, time_steps / middle
            else:
                high = middle
        return self.step(low).trial if low else None


def _before_exact(
    imbalance: Callable[[float], float], size: float, accuracy: float, found: float
) -> float:
    """The steps of time at the last balance before exact thresholds break, in a step of this size; or else `found`."""
    time_steps = size * TIME_FRACTIONS
    for high, low in pairwise(time_steps.tolist()):
        if imbalance(low) < 0.0:
            held = imbalance(high) <= 0.0
            return high if held else float(brentq(imbalance, low, high, xtol=accuracy))
    return found


def secant(
    function: Callable[[float], float], guess: float, slope: float, accuracy: float
) -> tuple[float, float]:
    """The root of an increasing function, where it is called last, and the slope there. Both are found from guesses by
    the secant method. A step that leaves the bracket of the root is replaced by bisection."""
    low, high, at, value = -np.inf, np.inf, guess, function(guess)
    for _ in range(MOST_SECANTS):
        low, high = (at, high) if value < 0.0 else (low, at)
        after = at - value / slope
        if abs(after - at) <= accuracy:
            break
        if not low < after < high and np.isfinite(high - low):
            after = 0.5 * (low + high)
        last_at, last_value = at, value
        at, value = after, function(after)
        rise = (value - last_value) / (at - last_at)
        slope = rise if rise > 0.0 else slope
    return at, slope
