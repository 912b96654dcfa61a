"""Cells of thresholds, at whose ends A is kept, the integral over time of the rate at which contacts break.

Contacts with the threshold x_s that have never been stretched beyond it still hold with the probability e^-A, A being
the integral of their rate of breaking h(|x|; x_s) over time. A is kept for thresholds at the ends of cells, between
which ln A is taken as linear: both where contacts are hot and A hardly changes over a cell, and where they are cold and
only those of a thin skin above |x| break early, errors are of second order in the cells.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import exp1

from master.motion import Legs
from master.survival.integrated_rate import IntegratedRate
from origins import Contacts
from origins.thresholds.law import Array

# The logarithms of the least and of the largest A that are told apart from 0 and infinity: e^-A is 1, or 0, to
# round-off.
LEAST_LOG, MOST_LOG = -700.0, 6.5
# Width of a cell, in the square of the largest threshold, below which it is that of an exact threshold.
EXACT_CELL = 1e-9
# Difference of e^-A between the ends of a cell below which its mean is that of the ends, with an error of the third
# power.
FLAT = 1e-4


class Leg(NamedTuple):
    """A straight move of contacts at one speed.

    begin, end : stretches, arrays of shape (n,) (lengths)
    largest : the largest |x| of the whole life after it, shape (n,) (lengths)
    duration : time
    """

    begin: Array
    end: Array
    largest: Array
    duration: float


class ThresholdCells:
    """The thresholds of contacts, in cells.

    edges : between which ln A is linear, shape (k + 1,): thresholds, or what increases with them
    beyond : fractions of the contacts that lie beyond each
    width : numbers in a record of A: one at each edge with heat, else none
    """

    def __init__(self, contacts: Contacts, edges: Array, beyond: Array) -> None:
        self._contacts, self.edges, self.beyond = contacts, edges, beyond
        self._hot = contacts.thermal is not None
        self.width = edges.size * self._hot

    def rate_integral(self, leg: Leg, thresholds: Array) -> Array:
        """A of one leg at thresholds (k,) or (n, k)."""
        travel, count = leg.end - leg.begin, leg.end.size
        speed, duration = float(travel[0]) / leg.duration, np.full((count, 1), leg.duration)
        legs = Legs(np.stack([np.zeros(count), travel], axis=-1), duration, np.array([speed]))
        integrated = IntegratedRate(self._contacts, leg.begin, legs)
        # Thresholds that |x| passes on this leg are met, and their A is never read again. Lifted to |x| they stay where
        # rates are defined.
        passed = np.maximum(np.abs(leg.begin), np.abs(leg.end))
        above = np.maximum(thresholds, passed[:, None])
        return np.asarray(np.exp(integrated.log(np.arange(count), above)))

    def survival_and_force(
        self, integrals: Array, stretch: Array, least: Array, unmet: Array
    ) -> Array:
        """Survival and force of the fraction `unmet`, whose thresholds lie beyond `least`, from A at the edges: where
        thresholds stay, `least` is the largest |x| so far; where they grow, the place of the largest hazard so far."""
        edges, every = self.edges, np.arange(least.size)
        weight = np.maximum(np.minimum(unmet[:, None], self.beyond[:-1]) - self.beyond[1:], 0.0)
        # of the cell in which the least threshold lies only the part beyond it counts; two edges follow, for _log_at
        cut = np.clip(np.searchsorted(edges, least, "right") - 1, 0, edges.size - 3)
        low = np.clip(least, edges[cut], edges[cut + 1])
        if self._hot:
            log = np.log(np.maximum(integrals, np.exp(LEAST_LOG)))
            log[every, cut] = self._log_at(low, cut, log[every, cut + 1], log[every, cut + 2])
            weight = weight * mean_survival(log, weight > 0.0)
        holding = weight.sum(axis=1)
        if self._contacts.stiffness == "independent":
            return np.stack([holding, stretch * holding])
        ends = np.tile(edges, (least.size, 1))
        ends[every, cut] = low
        middle = 0.5 * (ends[:, 1:] + ends[:, :-1])
        stiffness = (weight * self._contacts.relative_stiffness(middle)).sum(axis=1)
        return np.stack([holding, stretch * stiffness])

    def _log_at(self, low: Array, cut: npt.NDArray[np.intp], near: Array, far: Array) -> Array:
        """ln A at thresholds `low` in the cells `cut`, from its values near = ln A(x_1) and far = ln A(x_2) at the next
        two edges x_1 < x_2:

            ln A(low) = near + (x_1² - low²)/(x_2² - x_1²) max(near - far, 0).

        A is not kept at `low`, which lies between edges; and from the edge below it nothing can be taken, as |x| has
        passed that threshold. It is a straight line in x_s² because barriers of elastic energy are: with h = ω exp[-k
        (x_s² - x²)/2k_BT], the soft law, it is exact where k is the same for all; other laws differ from it by the
        square of the cell. A higher barrier is passed no sooner, so that a rise from near to far is rounding, and
        counts as none. The cell of an exact threshold is so narrow that its slope is rounding: there ln A(low) = near.
        """
        squares = self.edges**2
        width = squares[cut + 2] - squares[cut + 1]
        width = np.where(width > EXACT_CELL * squares[-1], width, np.inf)
        return near + (squares[cut + 1] - low**2) / width * np.maximum(near - far, 0.0)


def mean_survival(log: Array, counts: npt.NDArray[np.bool_]) -> Array:
    """Mean of e^-A over cells at whose ends ln A has the values (n, k + 1), shape (n, k); only rough where a cell does
    not count, as most do not that |x| has passed, on which A is steep."""
    survival = np.exp(-np.exp(np.minimum(log, MOST_LOG)))
    low, high = survival[:, :-1], survival[:, 1:]
    mean = 0.5 * (low + high)
    steep = counts & (np.abs(high - low) > FLAT)
    # the integral of e^-A over ln A is -E_1(A), which two cells beside each other share at the edge between them
    wanted = np.zeros(log.shape, bool)
    wanted[:, :-1] = steep
    wanted[:, 1:] |= steep
    integral = np.empty(log.shape)
    integral[wanted] = exp1(np.exp(np.clip(log[wanted], LEAST_LOG, MOST_LOG)))
    rise = integral[:, 1:][steep] - integral[:, :-1][steep]
    mean[steep] = rise / (log[:, :-1][steep] - log[:, 1:][steep])
    return mean
