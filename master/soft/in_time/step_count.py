"""The count of steps along time: uniform where the drive moves, logarithmic where changes slow down."""

import numpy as np
from scipy.special import wrightomega

# Steps in which the time since the begin of a section grows by a factor e. While the drive holds they are all there is;
# while it moves they stand beside the steps of its travel, and need resolve the first changes only.
PER_E_FOLD_OF_HOLD, PER_E_FOLD_OF_MOVE = 2.0, 0.4
# Least product of the rate of uniform steps and `first`: below it the inverse would divide by 0, and steps are
# logarithmic to all digits.
LEAST_UNIFORM = 1e-200


class StepCount:
    """Count of steps since the begin of a smooth section of the motion, rate t + c ln(1 + t/first) at the time t since.

    begin, end : times between which the motion is smooth
    rate : uniform steps per time; 0 while the drive holds
    first : the shortest time over which contacts change at the begin; inf where nothing changes then
    """

    def __init__(self, begin: float, end: float, rate: float, first: float) -> None:
        self._begin, self._end, self._rate, self._first = begin, end, rate, min(first, end - begin)
        self._per_e_fold = 0.0
        if not rate:
            self._per_e_fold = PER_E_FOLD_OF_HOLD
        elif first < end - begin:
            self._per_e_fold = PER_E_FOLD_OF_MOVE

    def steps(self, time: float) -> float:
        """Steps since the begin."""
        later = time - self._begin
        return self._rate * later + self._per_e_fold * float(np.log1p(later / self._first))

    def time(self, steps: float) -> float:
        """The time after so many steps, at most the end."""
        if not self._per_e_fold:
            return min(self._begin + steps / self._rate, self._end)
        # u = (time - begin)/first solves uniform u + ln(1 + u) = e_folds: Wright's function omega(z), omega + ln omega
        # = z, is uniform (1 + u)
        e_folds = steps / self._per_e_fold
        uniform = max(self._rate * self._first / self._per_e_fold, LEAST_UNIFORM)
        omega = float(wrightomega(e_folds + uniform + np.log(uniform)))
        return min(self._begin + self._first * (omega / uniform - 1.0), self._end)
