"""Memory: what tells how many of the contacts born together still hold; here of contacts whose thresholds stay.

Of each group a Memory keeps a record, some numbers that describe its history; those of contacts whose thresholds change
are in master.soft.in_time.changing.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from master.soft.in_time.threshold_cells import StraightMove, ThresholdCells
from master.survival.age.extent import narrowest
from master.survival.heat import MeanRateLife
from master.survival.integrated_rate import has_relaxed_time
from master.survival.life import TIE
from origins import Contacts, Thresholds
from origins.thresholds.law import Array

# Fractions of the contacts with thresholds below and above the ends of cells: some four a decade of weight where it
# matters, tails down to round-off. On the coarsest steps each cell is cut in 2; the parts are halved with the steps,
# from the fourth on with every second one.
RANKS = np.array([1e-14, 1e-8, 1e-5, 1e-3, 0.01, 0.05, 0.15, 0.3, 0.5])
# Fraction of fresh contacts, the weakest, whose rate of breaking steps need not resolve: they break soon, with little
# effect on the others.
WEAK = 0.3
# Survival, of contacts that never were stretched, beyond which no threshold is looked for: below round-off.
STRONGEST = 1e-18
# Least threshold that is told apart from 0, in mean or largest thresholds.
NO_THRESHOLD = 1e-12
# Rounding of the tables of the mean rate H, relative.
OF_TABLES = 1e-12
# Work of a cell in a sum of e^-A, in that of A at its edge where that is followed, too (measured).
OF_SUM = 0.4
# Nodes for a start with a width on the coarsest steps, and those more with each halving: with heat or with
# thresholds that change each node has a record of its own; without they cost little, and a start may be wide: they are
# doubled with each halving, a few times.
WARM_NODES, MORE_WARM_NODES = 24, 8
COLD_NODES, MOST_DOUBLINGS = 100, 3
# Fall of ln h over two cells, from the attempt frequency, up to which A is still told apart from 0 at the far edge; and
# least fraction of the contacts in a cell where that matters.
DISTINCT, BULK = 600.0, 1e-3


class Scales(NamedTuple):
    """The scales that the steps of a slider have to resolve.

    length : travel over which survivals and births change (a length)
    time : the shortest time over which they change in a hold; inf where nothing changes then
    rate : at which fresh contacts break (per time), 0 where steps need not resolve it
    """

    length: float
    time: float = np.inf
    rate: float = 0.0


class Memory:
    """What the history of contacts born together tells of them. Records are arrays of shape (n, width), a row a group.

    error : of the survival that `survival_and_force` returns, however fine cells and steps are
    largest_stretch : stretch at t = 0 or at birth beyond which no contact holds (a length)
    width : numbers in the record of a group
    work : of a step of a group, in numbers of a record that are followed
    scales : what steps have to resolve
    starts : most nodes for a start with a width; more with each halving of the steps, so that their error shows
    balance : accuracy of a step's balance, in sizes of steps: far below the error of a step
    nearing : steps are at most this part of the way to where a slip is foreseen; inf where they need not become finer
    safety : factor on the last change in the error estimate, see `_of_steps` in answer/extrapolation.py: changes of
        answers fall irregularly where births jump or P_c bends, and by a half where thresholds grow
    error_of_slips, fall_of_slips : least error of a path with slips under "instant" of steps halved twice, 0 where none
        is known, and how many times it falls with each further halving
    exact : whether there are exact thresholds
    resolves_heat : whether ln A is known at the next two edges above |x|, from which it is extrapolated
    """

    error, balance, safety = 1e-15, 1e-9, 3.0
    error_of_slips, fall_of_slips = 0.0, 1.0
    nearing, exact, resolves_heat = np.inf, False, True
    largest_stretch: float
    width: int
    scales: Scales
    starts: int

    @property
    def work(self) -> float:
        return self.width

    @property
    def length_in_slips(self) -> float:
        """As scales.length, in a slip, in which no time goes by (a length)."""
        return self.scales.length

    def resolve_creep(self, speed: float) -> None:
        """Make `scales.length` that of a slider which moves at this speed, above 0, while its contacts hold. Here it
        does not depend on the speed."""

    def start(self, stretch: Array) -> Array:
        """Record of contacts with stretches (n,) at t = 0."""
        raise NotImplementedError

    def fresh(self, stretch: Array, speed: float) -> Array:
        """Record of contacts that are born at stretches (n,) on a slider of this speed: |dX/dt|, also where it
        moves back; inf where it moves in no time."""
        return self.start(stretch)

    def advance(self, record: Array, leg: StraightMove) -> Array:
        """Record after a move at one speed from leg.begin to leg.end, in the time leg.duration.

        Errors have to fall with the square of a step, or faster: what a memory integrates over the move it takes at
        its middle, by Simpson's rule, or exactly; what it asks of the contacts as they are then, at its end:

            ThresholdMemory   A grows by the integral of h along the move, exactly
            MeanRateMemory    H by Simpson's rule; thresholds that |x| meets, from begin to end
            GrowingMemory     A by thresholds in the middle of the move; the hazard at its end, by stretch and age there
            AgeingMemory      weights of cells by Radau's method, of third order

        Tests: those of test_plain_in_time.py that name a memory.
        """
        raise NotImplementedError

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        """Survival and force, the mean of k x/<k> over all (lengths), shape (2, n), of all thresholds.

        Of contacts born stretched at r, a memory of thresholds tells both with those counted in whose thresholds are
        below |r|, and which never formed: survival at birth is S(|r|), times theirs. Others, of contacts that age, say,
        tell theirs alone: survival at birth is 1. Either way the weights of Groups are divided by that at birth.

        largest : the largest |x| so far
        """
        raise NotImplementedError


class ThresholdMemory(Memory):
    """Contacts with thresholds that stay, which break there or by heat (closure "exact"): keeps A at edges of cells, or
    where rates are separable the logarithm of the time at x = 0 that gives it at each."""

    def __init__(self, contacts: Contacts, halvings: int) -> None:
        """Choose the cells of thresholds, and over what births and steps change."""
        law = self._law = contacts.thresholds
        self._hot = contacts.thermal is not None
        # whether survival and force are sums over cells of thresholds
        self._is_summed = self._hot or contacts.stiffness != "independent"
        self.exact = bool(law.atoms[0].size)
        self.starts = warm_nodes(halvings) if self._hot else cold_nodes(halvings)
        self.largest_stretch, self.scales = largest_stretch(law), scales_of(contacts)
        edges = cell_edges(law, self.largest_stretch, halvings)
        self._cells = ThresholdCells(contacts, edges, law.sf(edges))
        self.resolves_heat = resolves_heat(contacts, edges)
        self._by_time = has_relaxed_time(contacts)
        self.width = 1 if self._by_time else self._cells.width

    @property
    def work(self) -> float:
        return self.width + OF_SUM * self._cells.width if self._by_time else self.width

    def start(self, stretch: Array) -> Array:
        return np.full((stretch.size, self.width), -np.inf if self._by_time else 0.0)

    def advance(self, record: Array, leg: StraightMove) -> Array:
        if not leg.duration or not self._hot:
            return record
        if self._by_time:
            return np.logaddexp(record, self._cells.log_relaxed_time(leg)[:, None])
        return np.asarray(record + self._cells.rate_integral(leg, self._cells.edges))

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        unmet = np.asarray(self._law.sf(largest * (1.0 + TIE)))
        if not self._is_summed:
            return np.stack([unmet, stretch * unmet])
        return self._cells.survival_and_force(record, stretch, largest, unmet)


class MeanRateMemory(Memory):
    """Heat by the closure "paper": all break at the mean rate H(x), and where |x| grows at their thresholds.

    A record holds the survival so far, and |x| at birth. A contact forgets the thresholds that it has
    survived: one that goes out again may break at all that it has passed before (App. C).
    """

    def __init__(self, contacts: Contacts, halvings: int) -> None:
        self._life, law = MeanRateLife(contacts), contacts.thresholds
        self.width, self.starts = 2, cold_nodes(halvings)
        self.error = self._life.error + OF_TABLES
        self.exact, self.largest_stretch = bool(law.atoms[0].size), largest_stretch(law)
        rate = float(self._life.rate(np.zeros(1))[0])
        self.scales = scales_of(contacts)._replace(rate=rate)

    def start(self, stretch: Array) -> Array:
        return np.stack([np.ones(stretch.size), np.abs(stretch)], axis=1)

    def advance(self, record: Array, leg: StraightMove) -> Array:
        """See Memory; H is averaged over the move by Simpson's rule."""
        life, (survival, born) = self._life, record.T
        ends, middle = np.abs([leg.begin, leg.end]), 0.5 * np.abs(leg.begin + leg.end)
        mean = (life.rate(ends).sum(axis=0) + 4.0 * life.rate(middle)) / 6.0
        survival = survival * life.cold_survival(leg.begin, leg.end, born, leg.largest)
        return np.stack([survival * np.exp(-mean * leg.duration), born], axis=1)

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        return np.stack([record[:, 0], stretch * record[:, 0]])


def scales_of(contacts: Contacts) -> Scales:
    """The scales of contacts with thresholds that stay."""
    law, thermal = contacts.thresholds, contacts.thermal
    # births change over the width of the sharpest tenth of P_c
    scales = Scales(min(narrowest(law), contacts.mean_threshold))
    if thermal is None:
        return scales
    weak = np.array([max(float(law.ppf(WEAK)), NO_THRESHOLD * contacts.mean_threshold)])
    rate = float(thermal.rates.rate(0.0, weak, contacts.relative_stiffness(weak))[0])
    return scales._replace(time=1.0 / thermal.rates.scale, rate=rate)


def largest_stretch(law: Thresholds) -> float:
    """The stretch beyond which no contact holds."""
    return max([min(float(law.support()[1]), float(law.isf(STRONGEST))), *law.atoms[0]])


def cell_edges(law: Thresholds, largest: float, halvings: int) -> Array:
    """Ends of cells of thresholds."""
    ends = np.concatenate([law.ppf(RANKS), law.isf(RANKS), law.breakpoints, [largest]])
    # a very narrow cell for each exact threshold
    atoms = [law.atoms[0] * (1.0 + k * TIE) for k in (-2.0, -0.5, 0.5)]
    ends = np.concatenate([ends, *atoms])
    ends = np.unique(np.clip(ends, NO_THRESHOLD * largest, largest))
    cells = 2 ** min(halvings + 1, halvings // 2 + 3)
    return np.unique([np.linspace(*two, cells + 1) for two in pairwise(ends)])


def resolves_heat(contacts: Contacts, edges: Array) -> bool:
    """Whether A is told apart from 0 at the far edge of all cells of the bulk."""
    thermal, law = contacts.thermal, contacts.thresholds
    if thermal is None or thermal.closure == "paper":
        return True
    bulk = np.flatnonzero(np.diff(-law.sf(edges)) > BULK)[:-1]
    far = edges[bulk + 2]
    log_rate = thermal.rates.log_rate(edges[bulk], far, contacts.relative_stiffness(far))
    return bool((np.log(thermal.rates.scale) - log_rate < DISTINCT).all())


def warm_nodes(halvings: int) -> int:
    """Nodes for a start with a width of contacts with a record of their own; they differ from halving to halving, so
    that their error shows."""
    return WARM_NODES + MORE_WARM_NODES * halvings


def cold_nodes(halvings: int) -> int:
    """The same of contacts without one."""
    return int(COLD_NODES * 2 ** min(halvings, MOST_DOUBLINGS))
