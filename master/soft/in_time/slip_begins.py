"""Where a slip begins: where a longer step would end earlier.

That is at a fold, where the time of balance, as a function of the step's size, is the latest, or where contacts at an
exact threshold break and there is no balance from then on.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from master.soft.in_time.cohorts import Trial
from master.soft.in_time.steps import CONTROL, BalancedStep, Steps


class OnsetControl(NamedTuple):
    """Numbers of the search for a slip; none has a unit.

    onset : accuracy of the begin of a slip, in sizes of steps: X_T is flat there, or has a kink.
    last_jump : accuracy of a size at which exact thresholds break, in sizes: F jumps there, so it is that of rounding.
    beyond_jump : factor on the size of the step that looks beyond a jump of P_c, where F falls at once.
    far_from_slip : steps of time, in those of a slider that is stuck to the drive, above which no slip is near.
    before_fold : factor on the size of the step that tells on which side of a fold a step ends.
    nearing, least_shrink : steps of contacts that age are at most this part of the way to where a slip is foreseen, but
        not below this factor on their size, as a slip that is foreseen may not come.
    """

    onset: float = 1e-9
    last_jump: float = 1e-14
    beyond_jump: float = 1.01
    far_from_slip: float = 0.3
    before_fold: float = 0.99
    nearing: float = 0.25
    least_shrink: float = 0.03


ONSET = OnsetControl()


class SlipBegins:
    """The search for a slip along the steps of one smooth section. It writes Steps.guess: after each step what the next
    one is foreseen to take in time, and while it searches what the last step tried did.

    shrink : factor on the next step's size: 1 far from slips
    """

    def __init__(self, steps: Steps) -> None:
        """At the begin of the section."""
        self._steps, self.shrink = steps, 1.0
        # the fraction of its size that the last step took in steps of time, unknown yet
        self._last_time_fraction = np.nan

    def up_to_slip(self, step: BalancedStep, size: float) -> tuple[Trial, bool]:
        """The step that was asked for with this size, or that up to a slip that begins within it; and whether one
        does."""
        steps = self._steps
        if step.trial.now > steps.contacts.now:  # it may have been cut at the section's end
            size = min(size, steps.size(step.trial))
        longest = size
        if steps.contacts.jumps and step.time_steps > 0.0:
            # at a jump of P_c F falls at once: there is no fold, but a step beyond ends earlier, that is, it takes less
            # time than this one, whose time is its size less its travel
            longest = ONSET.beyond_jump * size
            slips = steps.step(longest).time_steps < size - steps.travelled(step.trial)
        else:
            slips = self._is_fold_within(step, size)
        if not slips:
            self._foresee(step.time_steps / size, size)
            return step.trial, False
        trial = self._latest(size, longest)
        last = self._last_before_exact(size, longest) if steps.contacts.memory.exact else None
        if last is not None and last.now > trial.now:
            trial = last
        # at the section's end, a slip may still be to come
        return trial, trial.now < steps.section_end

    def _is_fold_within(self, step: BalancedStep, size: float) -> bool:
        """Whether a fold lies before the end of a step of this size."""
        # far from a slip the slider follows the drive, and this part of the size is time
        if step.time_steps > ONSET.far_from_slip * CONTROL.drive_weight * size:
            return False
        if step.time_steps <= 0.0:
            return True
        # nearer, a fold lies within the step where a shorter one takes as much time or more
        return self._steps.step(ONSET.before_fold * size).time_steps >= step.time_steps

    def _foresee(self, time_fraction: float, size: float) -> None:
        """Guess the next step from this one's fraction of steps of time, and how far a slip is, where it falls to 0.

        Steps become finer within four of the coarsest before a slip of contacts that age: their thresholds cross |x|
        step by step, and the slip would depend on where those steps end.
        """
        change = float(np.nan_to_num(time_fraction - self._last_time_fraction))
        self._last_time_fraction, self._steps.guess = time_fraction, time_fraction + change
        self.shrink = 1.0
        if self._steps.contacts.memory.finer_before_slips and change < 0.0:
            to_slip = ONSET.nearing * time_fraction * size / -change
            self.shrink = min(max(to_slip, ONSET.least_shrink), 1.0)

    def _latest(self, size: float, longest: float) -> Trial:
        """The step up to a fold: that which takes the most time."""
        found = minimize_scalar(
            lambda at: -self._steps.step(at).time_steps,
            bounds=(0.0, longest),
            options={"xatol": ONSET.onset * size},
        )
        return self._steps.step(float(found.x)).trial

    def _last_before_exact(self, size: float, longest: float) -> Trial | None:
        """The longest step after which there still is a balance, before exact thresholds break, by bisection; None
        where there is none at once."""
        low, high = 0.0, longest
        while high - low > ONSET.last_jump * size:
            middle = 0.5 * (low + high)
            time_steps = self._steps.step(middle).time_steps
            if time_steps > 0.0:
                low, self._steps.guess = middle, time_steps / middle
            else:
                high = middle
        return self._steps.step(low).trial if low else None
