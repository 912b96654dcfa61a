"""Steps: one step of a slider that a spring pulls, K (X_T - X) = F, and where a slip begins.

This is pseudo-arclength continuation: the size of a step combines X and time, dX/length + d(steps of
time, see StepCount), so that steps are even both where the slider creeps and just before a slip, where dX/dt
diverges. A slip begins at a fold, where the time of balance, as a function of the size, is the latest.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import wrightomega

from master.motion import Motion
from master.soft.in_time.cohorts import Cohorts, Trial

# A step on the coarsest level, as a share of the length over which births change.
COARSEST = 0.5
# Weight of the drive's travel in the size of a step, relative to the slider's, which matters more.
DRIVE_WEIGHT = 0.25
# Accuracy of the beginning of a slip, where X_T is flat or has a kink, as a share of the step.
CLOSE_TO_SLIP = 1e-9
# Shares of a step that it may take in time, where a balance before exact thresholds is looked for.
PROBES = np.array([1.0, 0.999, 0.99, 0.97, 0.94, 0.9, 0.8, 0.7, 0.6, 0.45, 0.3, 0.2, 0.1, 0.03])


class StepCount:
    """Count of steps: uniform in time, and where changes slow down, in its logarithm.

    begin, end : times between which a section of the motion is smooth
    rate : uniform steps per time; 0 while the drive holds
    first : the shortest time over which contacts change at its begin; inf where nothing changes then
    """

    def __init__(self, begin: float, end: float, rate: float, first: float) -> None:
        self._begin, self._end, self._rate, self._first = begin, end, rate, min(first, end - begin)
        # steps in which the time since the begin grows by a factor e: in a hold; in a move, beside those of the travel
        self._per_e_fold = 2.0 if not rate else 0.4 if first < end - begin else 0.0

    def steps(self, time: float) -> float:
        """Steps since the beginning."""
        later = time - self._begin
        return self._rate * later + self._per_e_fold * float(np.log1p(later / self._first))

    def time(self, steps: float) -> float:
        """The time after so many steps, at most the end."""
        if not self._per_e_fold:
            return min(self._begin + steps / self._rate, self._end)
        # u = (time - begin) / first solves even u + log(1 + u) = e_folds, also for hardly any `even`
        e_folds = steps / self._per_e_fold
        even = max(self._rate * self._first / self._per_e_fold, 1e-200)
        omega = float(wrightomega(e_folds + even + np.log(even)))
        return min(self._begin + self._first * (omega / even - 1.0), self._end)


class Steps:
    """Steps of contacts on one leg of the drive's motion X_T(t), as long as births are smooth.

    spring : K/(N_c <k>)
    length : the travel of a step of the size 1 that takes no time (a length)
    sign : direction in which the spring pulls: travels and imbalances are counted along it
    shrink : factor on the next step's size: 1 far from slips
    """

    def __init__(self, contacts: Cohorts, spring: float, drive: Motion) -> None:
        self._contacts, self._spring, self._drive = contacts, spring, drive
        self.length, self.sign = COARSEST * contacts.memory.scales.length, 1.0
        # accuracy of a step's balance, as a share of the step; the errors of contacts that age are larger than 1e-7
        self._close = 1e-7 if contacts.memory.finer_before_slips else 1e-9
        # guess of how fast the imbalance grows with the steps of time
        self._steep = (1.0 + spring) * (1.0 + 1.0 / DRIVE_WEIGHT) * self.length

    def begin(self, leg: int, end: float) -> None:
        """Begin steps on a leg of the drive's motion, smooth up to the time `end`."""
        scales, speed = self._contacts.memory.scales, float(self._drive.speeds[leg])
        self.sign = float(np.sign(speed) or np.sign(self._contacts.force) or 1.0)
        # while contacts hold, the slider moves K/(1 + K) times as fast as the drive
        even = DRIVE_WEIGHT * abs(speed) * self._spring / (self.length * (1.0 + self._spring))
        even = even + scales.rate / COARSEST if speed else 0.0
        self._count, self._end = StepCount(self._contacts.now, end, even, scales.time), end
        # share of the steps of time in the last step, and guess of it in the next one
        self._share, self._guess, self.shrink = np.nan, 0.5, 1.0

    def size(self, trial: Trial) -> float:
        """The size of a step."""
        takes = self._count.steps(trial.now) - self._count.steps(self._contacts.now)
        return takes + self.sign * trial.travel / self.length

    def longest(self) -> float:
        """Twice the size of a step to the section's end if the slider moves as far as the drive; inf in a hold."""
        now, drive = self._contacts.now, self._drive
        way = float(np.abs(np.diff(drive.at(np.array([now, self._end])))[0]))
        takes = self._count.steps(self._end) - self._count.steps(now)
        return 2.0 * (takes + way / self.length) if way else np.inf

    def imbalance(self, trial: Trial) -> float:
        """The spring's force minus that of the contacts, along the motion."""
        ahead = self._drive.at(np.array(trial.now)) - self._contacts.place - trial.travel
        return float(self.sign * (self._spring * ahead - trial.force))

    def step(self, size: float) -> tuple[float, Trial]:
        """The steps of time that a balanced step of this size, or up to the end, takes; and it. If there
        is no balance from now on, they are below 0, and the step takes no time."""
        now, steep = self._contacts.now, self._steep
        done = self._count.steps(now)

        def imbalance(steps: float) -> float:
            later, back = max(steps, 0.0), min(steps, 0.0)
            time = max(self._count.time(done + later), now) if later else now
            self._trial = self._contacts.trial(self.sign * self.length * (size - later), time)
            return self.imbalance(self._trial) + steep * back

        found, self._steep = secant(imbalance, self._guess * size, steep, self._close * size)
        if found < 0.0 and self._contacts.memory.exact:
            # a guess beyond an exact threshold misses the balance before it
            steps = size * PROBES
            ahead = next((k for k in range(1, steps.size) if imbalance(steps[k]) < 0.0), 0)
            if ahead:
                low, high = steps[ahead], steps[ahead - 1]
                held = imbalance(high) <= 0.0
                found = high if held else brentq(imbalance, low, high, xtol=self._close * size)
            imbalance(found)
        return found, self._trial

    def up_to_slip(self, takes: float, trial: Trial, size: float) -> tuple[Trial, bool]:
        """The step `trial`, which was asked for with this size and `takes` so many steps of time, as `step` returns
        both, or that up to a slip that begins within it; and whether one does."""
        size = min(size, self.size(trial)) if trial.now > self._contacts.now else size
        longer = 1.01 * size if self._contacts.jumps and takes > 0.0 else size
        if (
            longer > size
        ):  # where P_c jumps F falls at once: right behind, a longer step takes less time
            sticks = self.step(longer)[0] >= size - self.sign * trial.travel / self.length
        else:  # no slip is near while a step takes more than 0.3 DRIVE_WEIGHT of its size in time, as it does where
            # the slider follows the drive, or while a shorter step would take less time
            sticks = takes > 0.3 * DRIVE_WEIGHT * size or 0.0 < takes > self.step(0.99 * size)[0]
        if sticks:
            share = takes / size
            change = float(np.nan_to_num(share - self._share))
            self._share, self._guess = share, share + change
            # A slip begins where this share falls to 0. Within four of the coarsest steps before it steps become finer:
            # thresholds that age cross |x| step by step, and the slip would depend on where those steps end
            nearing = self._contacts.memory.finer_before_slips and change < 0.0
            self.shrink = min(max(0.25 * share * size / -change, 0.03), 1.0) if nearing else 1.0
            return trial, False
        options = {"xatol": CLOSE_TO_SLIP * size}
        last = minimize_scalar(lambda x: -self.step(x)[0], bounds=(0.0, longer), options=options).x
        trial = self.step(float(last))[1]
        low, high = 0.0, longer if self._contacts.memory.exact else 0.0
        while high - low > 1e-14 * size:  # the largest size before exact thresholds break
            middle = 0.5 * (low + high)
            takes = self.step(middle)[0]
            low, high = (middle, high) if takes > 0.0 else (low, middle)
            self._guess = takes / middle if takes > 0.0 else self._guess
        trial = max(trial, self.step(low)[1] if low else trial, key=lambda each: each.now)
        return trial, trial.now < self._end  # where the section ends, a slip may still be to come


def secant(
    function: Callable[[float], float], guess: float, slope: float, close: float
) -> tuple[float, float]:
    """The root of an increasing function, where it is called last, and the slope there. Both are found from guesses by
    the secant method. A step that leaves the bracket of the root is replaced by bisection."""
    low, high, at, value = -np.inf, np.inf, guess, function(guess)
    for _ in range(40):
        low, high = (at, high) if value < 0.0 else (low, at)
        after = at - value / slope
        if abs(after - at) <= close:
            break
        if not low < after < high and np.isfinite(high - low):
            after = 0.5 * (low + high)
        before, at, value = (at, value), after, function(after)
        rise = (value - before[1]) / (at - before[0])
        slope = rise if rise > 0.0 else slope
    return at, slope
