"""Means of e^-A over cells of thresholds, added up for many groups of contacts: the compiled part of ThresholdCells.

With s = ln A a straight line over a cell, from s_1 at its lower end to s_2,

    mean of e^-A = [E_1(A_2) - E_1(A_1)]/(s_1 - s_2),      E_1(z) = integral of e^-u/u from z on.

E_1(e^s) is a polynomial on each panel of s. Nothing is allocated but the answer, and cells that do not count cost
nothing: most are below |x|, or so strong that all their contacts hold.
"""

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.special import exp1

from master.soft.in_time.cells_kernel import compiled
from origins.thresholds.law import Array

# The logarithms of the least and of the largest A that are told apart from 0 and infinity: e^-A is 1, or 0, to
# round-off.
LEAST_LOG, MOST_LOG = -700.0, 6.5
LEAST = np.exp(LEAST_LOG)
# A at the lower end of a cell below which the contacts in it, and all stronger ones, hold to round-off.
ALL_HOLD = 1e-18
# Difference of e^-A between the ends of a cell below which its mean is that of the ends, with an error of the third
# power.
FLAT = 1e-4
# E_1(e^s) is tabulated from the logarithm s = FIRST_LOG on, below which three terms of its series are exact to
# round-off, on so many panels of width 1/PER_UNIT, behind which it is below 1e-25. With the degree of polynomials, its
# error is round-off.
FIRST_LOG, PER_UNIT, PANELS, DEGREE = -10.0, 4.0, 56, 10


def _integral_on(panel: int) -> Array:
    """Coefficients of E_1(e^s) in z from -1 to 1 on a panel of s, of the highest power first."""
    middle = FIRST_LOG + (panel + 0.5) / PER_UNIT
    fitted = chebyshev.chebinterpolate(lambda z: exp1(np.exp(middle + 0.5 * z / PER_UNIT)), DEGREE)
    return chebyshev.cheb2poly(fitted)[::-1]


INTEGRALS = np.array([_integral_on(panel) for panel in range(PANELS)])


@compiled
def integral_at(log: float, value: float) -> float:
    """E_1 at this value, of which `log` is the logarithm."""
    if log < FIRST_LOG:
        return value * (1.0 - value * (0.25 - value / 18.0)) - np.euler_gamma - log
    place = (log - FIRST_LOG) * PER_UNIT
    if place >= PANELS:
        return 0.0
    panel = int(place)
    z, total = 2.0 * (place - panel) - 1.0, 0.0
    for power in range(DEGREE + 1):
        total = total * z + INTEGRALS[panel, power]
    return total


@compiled
def survival_and_stiffness(
    integrals: Array,
    log_rates: Array,
    cut: NDArray[np.intp],
    log: Array,
    stiffness_there: Array,
    unmet: Array,
    beyond: Array,
    stiffness: Array,
) -> Array:
    """Survival and stiffness of contacts in groups, shape (2, groups): sums over cells of thresholds.

    integrals : A at the edges of cells, array (groups, k + 1); it falls with the threshold. Where A is a rate at the
        threshold times a time, the logarithm of that time, array (groups, 1)
    log_rates : of these rates the logarithms at the edges, (k + 1,)
    cut, log, stiffness_there : the cell in which the least threshold of a group lies, of which only the part beyond it
        counts; ln A, and k_i/<k>, at the least threshold; (groups,)
    unmet : the fraction of the contacts that lies beyond it (groups,)
    beyond, stiffness : of all contacts the fraction that lies beyond each edge, and k_i/<k> there, (k + 1,)
    """
    groups, cells, by_time = integrals.shape[0], beyond.size - 1, integrals.shape[1] == 1
    out = np.zeros((2, groups))
    for i in range(groups):
        # of the lower end of a cell: A, its logarithm, E_1 (nan before it is asked for) and e^-A; k_i/<k>
        low_log, low = log[i], np.exp(min(log[i], MOST_LOG))
        low_integral, low_survival, low_stiffness = np.nan, np.exp(-low), stiffness_there[i]
        for j in range(cut[i], cells):
            weight = max(min(unmet[i], beyond[j]) - beyond[j + 1], 0.0)
            if low <= ALL_HOLD:
                high, high_log, high_survival = low, low_log, 1.0
            elif by_time:
                high_log = integrals[i, 0] + log_rates[j + 1]
                high = np.exp(min(high_log, MOST_LOG))
                high_survival = np.exp(-high)
            else:
                high = max(integrals[i, j + 1], LEAST)
                high_log, high_survival = np.log(high), np.exp(-high)
            high_integral = np.nan
            mean = 0.5 * (low_survival + high_survival)
            if abs(high_survival - low_survival) > FLAT:
                if np.isnan(low_integral):
                    low_integral = integral_at(low_log, low)
                high_integral = integral_at(high_log, high)
                mean = (high_integral - low_integral) / (low_log - high_log)
            out[0, i] += weight * mean
            out[1, i] += weight * mean * 0.5 * (low_stiffness + stiffness[j + 1])
            low_log, low, low_integral = high_log, high, high_integral
            low_survival, low_stiffness = high_survival, stiffness[j + 1]
    return out
