"""Memory: the numbers that describe the history of contacts born together at one stretch.

Contacts with the threshold x_s that have never been stretched beyond it still hold with the probability e^-A, A being
the integral of their rate of breaking h(|x|; x_s) over time. A is kept for thresholds at the ends of cells, between
which ln A is taken as linear: both where contacts are hot and A hardly changes over a cell, and where they are cold and
only those of a thin skin above |x| break early, errors are of second order in the cells.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import exp1

from master.motion import Legs
from master.survival.age.extent import narrowest
from master.survival.heat import MeanRateLife
from master.survival.integrated_rate import IntegratedRate
from master.survival.life import TIE
from origins import Contacts
from origins.thresholds.law import Array

# Fractions of the contacts with thresholds below and above the ends of cells: some four a decade of weight where it
# matters, tails down to round-off. On the coarsest steps each cell is cut in 2; the parts are halved with the steps,
# from the fourth on with every second one.
RANKS = np.array([1e-14, 1e-8, 1e-5, 1e-3, 0.01, 0.05, 0.15, 0.3, 0.5])
# The logarithms of the least and of the largest A that are told apart from 0 and infinity: e^-A is 1, or 0, to
# round-off.
LEAST_LOG, MOST_LOG = -700.0, 6.5
# Fraction of fresh contacts, the weakest, whose rate of breaking steps need not resolve: they break soon, with little
# effect on the others.
WEAK = 0.3
# Survival, of contacts that never were stretched, beyond which no threshold is looked for: below round-off.
STRONGEST = 1e-18
# Least threshold that is told apart from 0, in mean or largest thresholds.
NO_THRESHOLD = 1e-12
# Nodes for a start with a width on the coarsest steps, and those more with each halving: with heat or with
# thresholds that change each node has a record of its own; without they cost little, and a start may be wide.
WARM_NODES, MORE_WARM_NODES, COLD_NODES, MOST_DOUBLINGS = 24, 8, 100, 3
# Width of a cell, in the square of the largest threshold, below which it is that of an exact threshold.
EXACT_CELL = 1e-9
# Fall of ln h over two cells, from the attempt frequency, up to which A is still told apart from 0 at the far edge; and
# least fraction of the contacts in a cell where that matters.
TOLD_APART, BULK = 600.0, 1e-3
# Difference of e^-A between the ends of a cell below which its mean is that of the ends, with an error of the third
# power.
FLAT = 1e-4


class Scales(NamedTuple):
    """The scales that the steps of a slider have to resolve.

    length : travel over which survivals and births change (a length)
    time : the shortest time over which they change in a hold; inf where nothing changes then
    rate : at which fresh contacts break (per time), 0 where steps need not resolve it
    """

    length: float
    time: float = np.inf
    rate: float = 0.0


class Leg(NamedTuple):
    """A straight move of contacts at one speed.

    begin, end, largest : arrays of shape (n,), stretches (lengths), and the largest |x| after it
    duration : time
    """

    begin: Array
    end: Array
    largest: Array
    duration: float


class Memory:
    """The history of contacts with thresholds that stay, which break there or by heat.

    A memory for another law of contacts offers the attributes below, `start`, `fresh`, `advance` and
    `survival_and_force`.

    error : of the survival that `survival_and_force` returns, however fine cells and steps are
    largest_stretch : stretch at t = 0 or at birth beyond which no contact holds (a length)
    width : length of a group's record, of which all but the first `others` numbers are A
    starts : most nodes for a start with a width; they differ from halving to halving, so that their error shows
    finer_before_slips : whether steps become finer towards a slip
    safety : times the last change in the error estimate, see `refining`: changes of the answers fall irregularly
        where births jump or P_c bends, and by a half where thresholds grow
    exact : whether there are exact thresholds
    resolves_heat : whether ln A is known at the next two edges above |x|, from which it is extrapolated
    """

    error, others, finer_before_slips, exact, resolves_heat = 1e-15, 0, False, False, True
    safety = 3.0

    def __init__(self, contacts: Contacts, halvings: int) -> None:
        """Choose the cells of thresholds, and over what births and steps change."""
        law = self._law = contacts.thresholds
        self._hot, self._contacts = contacts.thermal is not None, contacts
        self.exact = bool(law.atoms[0].size)
        self.starts = warm_nodes(halvings) if self._hot else cold_nodes(halvings)
        strongest = min(float(law.support()[1]), float(law.isf(STRONGEST)))
        self.largest_stretch = max([strongest, *law.atoms[0]])
        # births change over the width of the sharpest tenth of P_c
        self.scales = Scales(min(narrowest(law), contacts.mean_threshold))
        if contacts.thermal is not None:
            rates = contacts.thermal.rates
            least = NO_THRESHOLD * contacts.mean_threshold
            weak = np.maximum(np.array([float(law.ppf(WEAK))]), least)
            fresh_rate = float(rates.rate(0.0, weak, contacts.relative_stiffness(weak))[0])
            self.scales = self.scales._replace(time=1.0 / rates.scale, rate=fresh_rate)
        ends = np.concatenate(
            [law.ppf(RANKS), law.isf(RANKS), law.breakpoints, [self.largest_stretch]]
        )
        # a very narrow cell for each exact threshold
        atoms = [law.atoms[0] * (1.0 + k * TIE) for k in (-2.0, -0.5, 0.5)]
        ends = np.concatenate([ends, *atoms])
        ends = np.clip(ends, NO_THRESHOLD * self.largest_stretch, self.largest_stretch)
        cells = 2 ** min(halvings + 1, halvings // 2 + 3)
        edges = np.unique([np.linspace(*two, cells + 1) for two in pairwise(np.unique(ends))])
        self._set_cells(edges, law.sf(edges))
        if contacts.thermal is not None and contacts.thermal.closure == "exact":
            rates, bulk = (
                contacts.thermal.rates,
                np.flatnonzero(np.diff(-law.sf(edges)) > BULK)[:-1],
            )
            far, stiffness = edges[bulk + 2], contacts.relative_stiffness(edges[bulk + 2])
            fall = np.log(rates.scale) - rates.log_rate(edges[bulk], far, stiffness)
            self.resolves_heat = bool((fall < TOLD_APART).all())

    def _set_cells(self, edges: Array, beyond: Array) -> None:
        """Set the thresholds between which ln A is linear, and the fractions of contacts beyond them."""
        self._edges, self._beyond = edges, beyond
        self.width = self.others + edges.size * self._hot

    def start(self, stretch: Array) -> Array:
        """Record, shape (n, width), of contacts with stretches (n,) at t = 0."""
        return np.zeros((stretch.size, self.width))

    def fresh(self, stretch: Array, speed: float) -> Array:
        """Record of contacts that are born at stretches (n,) on a slider of this speed."""
        return self.start(stretch)

    def advance(self, record: Array, leg: Leg) -> Array:
        """Record after a move, shape (n, width)."""
        if not leg.duration or not self._hot:
            return record
        return np.asarray(record + self._rate_integral(leg, self._edges))

    def _rate_integral(self, leg: Leg, thresholds: Array) -> Array:
        """A of one leg at thresholds (k,) or (n, k)."""
        travel, count = leg.end - leg.begin, leg.end.size
        speed, duration = float(travel[0]) / leg.duration, np.full((count, 1), leg.duration)
        legs = Legs(np.stack([np.zeros(count), travel], axis=-1), duration, np.array([speed]))
        integrated = IntegratedRate(self._contacts, leg.begin, legs)
        above = np.maximum(thresholds, leg.largest[:, None])
        return np.asarray(np.exp(integrated.log(np.arange(count), above)))

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        """Survival and force, the mean of k x/<k> over all (lengths), shape (2, n). Both are multiplied by the
        survival at birth; `largest` is the largest |x| so far."""
        unmet = np.asarray(self._law.sf(largest * (1.0 + TIE)))
        if not self._hot and self._contacts.stiffness == "independent":
            return np.stack([unmet, stretch * unmet])
        return self._summed(record, stretch, largest, unmet)

    def _summed(self, integrals: Array, stretch: Array, least: Array, unmet: Array) -> Array:
        """Survival and force of the fraction `unmet`, whose thresholds lie beyond `least`, from A at the edges."""
        edges, every = self._edges, np.arange(least.size)
        weight = np.maximum(np.minimum(unmet[:, None], self._beyond[:-1]) - self._beyond[1:], 0.0)
        # of the cell in which the least threshold lies, only the part beyond it counts
        cut = np.clip(np.searchsorted(edges, least, "right") - 1, 0, edges.size - 3)
        low = np.clip(least, edges[cut], edges[cut + 1])
        if self._hot:
            log = np.log(np.maximum(integrals, np.exp(LEAST_LOG)))
            log[every, cut] = self._log_at(low, cut, log[every, cut + 1], log[every, cut + 2])
            weight = weight * mean_survival(log)
        ends = np.tile(edges, (least.size, 1))
        ends[every, cut] = low
        middle = 0.5 * (ends[:, 1:] + ends[:, :-1])
        stiffness = (weight * self._contacts.relative_stiffness(middle)).sum(axis=1)
        return np.stack([weight.sum(axis=1), stretch * stiffness])

    def _log_at(self, low: Array, cut: npt.NDArray[np.intp], near: Array, far: Array) -> Array:
        """ln A at thresholds `low` in the cells `cut`, from its values at the next two edges, by the square of the
        threshold as barriers change; the narrow cell of an exact threshold has no slope."""
        squares = self._edges**2
        width = squares[cut + 2] - squares[cut + 1]
        width = np.where(width > EXACT_CELL * squares[-1], width, np.inf)
        return near + (squares[cut + 1] - low**2) / width * np.maximum(near - far, 0.0)


class MeanRateMemory(Memory):
    """The paper's closure: all break at the mean rate H(x), and where |x| grows at their thresholds.

    Kept are the survival, and |x| at birth. A contact forgets the thresholds that it has
    survived: one that goes out again may break at all that it has passed before (App. C).
    """

    def __init__(self, contacts: Contacts, halvings: int) -> None:
        super().__init__(contacts, halvings)
        self._life = MeanRateLife(contacts)
        # rounding in tables of H is some 1e-12
        self.width, self.starts, self.error = 2, cold_nodes(halvings), self._life.error + 1e-12
        self.scales = self.scales._replace(rate=float(self._life.rate(np.zeros(1))[0]))

    def start(self, stretch: Array) -> Array:
        return np.stack([np.ones(stretch.size), np.abs(stretch)], axis=1)

    def advance(self, record: Array, leg: Leg) -> Array:
        """See Memory; the mean of H over the move is that of Simpson's rule."""
        life, (survival, born) = self._life, record.T
        ends, middle = np.abs([leg.begin, leg.end]), 0.5 * np.abs(leg.begin + leg.end)
        mean = (life.rate(ends).sum(axis=0) + 4.0 * life.rate(middle)) / 6.0
        survival = survival * life.cold_survival(leg.begin, leg.end, born, leg.largest)
        return np.stack([survival * np.exp(-mean * leg.duration), born], axis=1)

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        return np.stack([record[:, 0], stretch * record[:, 0]])


def warm_nodes(halvings: int) -> int:
    """Nodes for a start with a width of contacts with a record of their own; they differ from halving to halving, so
    that their error shows."""
    return WARM_NODES + MORE_WARM_NODES * halvings


def cold_nodes(halvings: int) -> int:
    """The same of contacts without one."""
    return int(COLD_NODES * 2 ** min(halvings, MOST_DOUBLINGS))


def mean_survival(log: Array) -> Array:
    """Mean of e^-A over cells at whose ends ln A has the values (n, k + 1), shape (n, k)."""
    survival = np.exp(-np.exp(np.minimum(log, MOST_LOG)))
    low, high = survival[:, :-1], survival[:, 1:]
    mean = 0.5 * (low + high)
    steep = np.abs(high - low) > FLAT
    ends = log[:, :-1][steep], log[:, 1:][steep]
    # the integral of e^-A over ln A is -E_1(A)
    below, above = (exp1(np.exp(np.clip(end, LEAST_LOG, MOST_LOG))) for end in ends)
    mean[steep] = (above - below) / (ends[0] - ends[1])
    return mean
