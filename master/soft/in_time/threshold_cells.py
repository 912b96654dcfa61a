"""Cells of thresholds, at whose ends A is kept, the integral over time of the rate at which contacts break.

Contacts with the threshold x_s that have never been stretched beyond it still hold with the probability e^-A, A being
the integral of their rate of breaking h(|x|; x_s) over time. A is kept for thresholds at the ends of cells, between
which ln A is taken as linear: both where contacts are hot and A hardly changes over a cell, and where they are cold and
only those of a thin skin above |x| break early, errors are of second order in the cells.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.motion import Legs
from master.survival.integrated_rate import IntegratedRate, has_relaxed_time
from origins import Contacts
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# Width of a cell, in the square of the largest threshold, below which it is that of an exact threshold.
EXACT_CELL = 1e-9


class StraightMove(NamedTuple):
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
        from master.soft.in_time import threshold_cells_kernel

        self._contacts, self.edges, self.beyond = contacts, edges, beyond
        self._kernel = threshold_cells_kernel
        # linear in the threshold
        self._stiffness = contacts.relative_stiffness(edges)
        self._hot = contacts.thermal is not None
        self.width = edges.size * self._hot
        self._log_rates: Array = np.empty(0)
        if self._hot and has_relaxed_time(contacts):
            self._log_rates = self._log_rate_at_0(edges)

    def _log_rate_at_0(self, thresholds: Array) -> Array:
        """The logarithm of h(0; x_s), where the stiffness of contacts does not matter."""
        assert self._contacts.thermal is not None
        return np.asarray(self._contacts.thermal.rates.log_rate(0.0, thresholds, 1.0))

    def log_relaxed_time(self, leg: StraightMove) -> Array:
        """The logarithm of the time at x = 0 that adds to A as one leg does, at all thresholds beyond |x|: (n,)."""
        found = self._integrated(leg).log_relaxed_time
        assert found is not None
        return found[:, 0]

    def rate_integral(self, leg: StraightMove, thresholds: Array) -> Array:
        """A of one leg at thresholds (k,) or (n, k)."""
        integrated = self._integrated(leg)
        # Thresholds that |x| passes on this leg are met, and their A is never read again. Lifted to |x| they stay where
        # rates are defined.
        passed = np.maximum(np.abs(leg.begin), np.abs(leg.end))
        above = np.maximum(thresholds, passed[:, None])
        return integrated.on_one_leg(above)

    def _integrated(self, leg: StraightMove) -> IntegratedRate:
        """A of one leg."""
        travel, count = leg.end - leg.begin, leg.end.size
        speed, duration = float(travel[0]) / leg.duration, np.full((count, 1), leg.duration)
        legs = Legs(np.stack([np.zeros(count), travel], axis=-1), duration, np.array([speed]))
        return IntegratedRate(self._contacts, leg.begin, legs)

    def survival_and_force(
        self, integrals: Array, stretch: Array, least: Array, unmet: Array
    ) -> Array:
        """Survival and force of the fraction `unmet`, whose thresholds lie beyond `least`, from A at the edges, or from
        the logarithm of the relaxed time, shape (n, 1): where thresholds stay, `least` is the largest |x| so far; where
        they grow, the place of the largest hazard so far."""
        edges, kernel, every = self.edges, self._kernel, np.arange(least.size)
        # of the cell in which the least threshold lies only the part beyond it counts; two edges follow, for _log_at
        cut = clipped(np.searchsorted(edges, least, "right") - 1, 0, edges.size - 3)
        low = clipped(least, edges[cut], edges[cut + 1])
        if self._hot and integrals.shape[1] == 1:
            log = integrals[:, 0] + self._log_rate_at_0(low)
        elif self._hot:
            next_two = (np.maximum(integrals[every, cut + k], kernel.LEAST) for k in (1, 2))
            log = self._log_at(low, cut, *map(np.log, next_two))
        else:
            integrals = np.zeros((least.size, edges.size))
            log = np.full(least.size, kernel.LEAST_LOG)
        stiffness_there = self._contacts.relative_stiffness(low)
        integrals = np.ascontiguousarray(integrals)
        given = (
            integrals,
            self._log_rates,
            cut,
            log,
            stiffness_there,
            unmet,
            self.beyond,
            self._stiffness,
        )
        holding, stiffness = kernel.survival_and_stiffness(*given)
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
