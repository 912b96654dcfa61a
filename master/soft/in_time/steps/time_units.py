"""Time units: the time that a step takes, in the measure in which it is added to the step's travel."""

import numpy as np
from scipy.special import wrightomega

# Time units in which the time since the begin of a section grows by a factor e. While the drive holds there are no
# others; while it moves they are added to uniform ones, and have to resolve only the first changes.
PER_E_FOLD_OF_HOLD, PER_E_FOLD_OF_MOVE = 2.0, 0.4
# Least product of the rate of uniform time units and `first`: below it the inverse would divide by 0, and time units
# are logarithmic to all digits.
LEAST_UNIFORM = 1e-200
# Last digits of the time that rounding may take from the end of a step.
ROUNDED = 2.0


class TimeUnits:
    """Time since the begin of a smooth section in time units, of which a step takes about one or less: at the time t
    since rate t + c ln(1 + t/first), uniform where the drive moves, logarithmic where changes slow down.

    An example: rate 3, first 0.001 and c = 0.4. At t = 0.001, 0.1 and 1 these are 0.28, 2.15 and 5.76 time units: the
    first thousandth takes as much of a step as a tenth does later.

    begin, end : times between which the motion is smooth
    rate : uniform time units per time; 0 while the drive holds
    first : the time from which on logarithmic units grow: the shortest over which contacts change; inf for no change
    """

    def __init__(self, begin: float, end: float, rate: float, first: float) -> None:
        self._section_begin, self._section_end = begin, end
        self.rate, self._first = rate, min(first, end - begin)
        self._per_e_fold = 0.0
        if not rate:
            self._per_e_fold = PER_E_FOLD_OF_HOLD
        elif first < end - begin:
            self._per_e_fold = PER_E_FOLD_OF_MOVE

    def at(self, time: float) -> float:
        """Time units since the begin."""
        later = time - self._section_begin
        return self.rate * later + self._per_e_fold * float(np.log1p(later / self._first))

    def last_digits(self, time: float) -> float:
        """What ROUNDED last digits of a time are in time units there: no search finds one of these to better than that,
        which late on a path is a hundred times what a balance asks for."""
        per_time = self.rate + self._per_e_fold / (self._first + (time - self._section_begin))
        return ROUNDED * float(np.spacing(time)) * per_time

    def time(self, units: float) -> float:
        """The time after so many time units, at most the end."""
        if not self._per_e_fold:
            return min(self._section_begin + units / self.rate, self._section_end)
        # u = (time - begin)/first solves uniform u + ln(1 + u) = e_folds: Wright's function omega(z), omega + ln omega
        # = z, is uniform (1 + u)
        e_folds = units / self._per_e_fold
        uniform = max(self.rate * self._first / self._per_e_fold, LEAST_UNIFORM)
        omega = float(wrightomega(e_folds + uniform + np.log(uniform)))
        later = self._first * (omega / uniform - 1.0)
        return min(self._section_begin + later, self._section_end)
