"""Contacts whose thresholds change under a spring: those that age (closure "exact"), and those whose thresholds grow;
of laws of one's own see own_laws.

Of contacts that age every group carries the density of its thresholds, on the cells of master.soft.in_time.cells.

Where thresholds grow each contact keeps its quantile for life. The fraction e^-H has not reached its threshold yet, H
being the largest hazard of their law at their stretch and age so far (master.survival.growing). With heat they also
break earlier, see threshold_cells.py: here the cells are those of the quantile.

In and out: see Memory. A record holds what is kept of a group:

    AgeingMemory    | weights of the cells (no unit), |x| risen since they were moved (a length)
    GrowingMemory   | H (no unit), time since pinning; with heat A for each edge of cells (no unit)

An example of thresholds with the hazard x/(1 + a) at the age a, on average 1 + a, and a contact pinned at x = 0: after
a move to x = 0.9 until a = 0.5 H is 0.6, so that e^-0.6 = 0.55 hold. After another back to x = 0.2 until a = 1 the
hazard is 0.1, and H still 0.6: none breaks on the way back.
"""

from collections.abc import Callable

import numpy as np

from master.motion import Motion
from master.soft.in_time.cells import Cells
from master.soft.in_time.memory import (
    Memory,
    Scales,
    cell_edges,
    largest_stretch,
    resolves_heat,
    scales_of,
    warm_nodes,
)
from master.soft.in_time.own_laws.of_life import LifeMemory
from master.soft.in_time.own_laws.ordered import OrderedMemory
from master.soft.in_time.threshold_cells import StraightMove, ThresholdCells
from master.survival.growing import GrowingLife
from origins import Ageing, Contacts, GrowingThresholds, InputError, OrderedThresholds
from origins.thresholds.law import Array

# Columns of a group's record: largest hazard so far, time since pinning, and from there A.
LARGEST_HAZARD, PINNED_FOR, RATE_INTEGRAL = range(3)
# Last column of the record of contacts that age.
RISEN = -1
# Births change over this many of the narrowest widths of the laws.
WIDTHS_OF_BIRTHS = 2.0
# First step of a hold: of contacts that age in times in which thresholds spread by the narrowest width, of growing ones
# in their unit of time.
FIRST_OF_AGEING, FIRST_OF_GROWTH = 1e-3, 0.05
# Cells of thresholds that age are coarser than steps by this many halvings: their errors are then a tenth of those of
# steps (measured on springs of 1e-6 and 1 N_c<k>), and with every halving of cells a step takes 1.7 times as long.
COARSER_CELLS = 1
# Widths below the mean of the thresholds that they age to from which on steps resolve how a slider creeps; cells are
# then coarser by so many halvings, as |x| has no thin layer, and steps at most this part of the way to a slip: of K =
# 1e-6, D = 1e-2 and w = 0.02 the force at a slip is off by 2e-4, 4e-5 and 9e-6 with three halvings (by 2e-3, 8e-4 and
# 3e-5 by other steps).
CREEPING, COARSER_IN_CREEP, NEARING_IN_CREEP = 3.5, 2, 0.5
# Largest root of the hazard at an edge: the survival there is 2e-14. Cells on the coarsest steps; they are halved with
# every second one.
LARGEST_ROOT, COARSEST_CELLS = 5.6, 48
# With heat F + K X is flat within some hundredths of <x_s> before a slip, so that its place hangs on where steps end.
# Steps of half the way there tell it to 1e-3 two halvings earlier than even steps; those of a quarter do not.
NEARING_OF_HOT_GROWTH = 0.5


class AgeingMemory(Memory):
    """Contacts with `ageing`, closure "exact"; the errors of cells fall by 8 with each halving, faster than others.

    A record holds the weights of the cells, and as its last number by how much |x| has risen since these were moved.
    In a slip, which takes no time, thresholds stay and |x| rises step after step: the weights are left alone until it
    is over, and those above |x| are summed.

    fastest : speed at which an edge of the density is resolved
    """

    # Steps become finer within four of the coarsest before a slip; each has a larger error than those of other laws.
    error, balance, nearing, safety = 0.0, 1e-7, 0.25, 1.0
    # Seen in five cases of K from 1e-6 to 0.1 N_c<k>. The error fell 66 times with a halving at K = 1e-6, and 430 times
    # at K = 0.1, where slips take a tenth of the steps that are taken on: no bound, but an estimate.
    error_of_slips, fall_of_slips = 3e-3, 25.0

    def __init__(self, contacts: Contacts, halvings: int, fastest: float) -> None:
        ageing = contacts.ageing
        assert ageing is not None
        self._made_of = contacts, halvings, fastest
        self._cells = cells = Cells(contacts, halvings - COARSER_CELLS, fastest)
        self.width = cells.edges.size
        self.largest_stretch = min(law.support()[1] for law in (contacts.thresholds, ageing.final))
        self.starts = warm_nodes(halvings)
        self._born_at = self._of_born = np.empty(0)
        shortest = FIRST_OF_AGEING * cells.width**2 / ageing.rate
        self.scales = Scales(WIDTHS_OF_BIRTHS * cells.width, shortest, cells.heat_rate)

    @property
    def length_in_slips(self) -> float:
        """See Memory."""
        return WIDTHS_OF_BIRTHS * self._cells.width

    def resolve_creep(self, speed: float) -> None:
        """See Memory. Thresholds that have aged to a law of the width w pass the level |x|, by g widths below their
        mean, at the rate D/w² g e^(-g²/2)/(2 pi)^(1/2) (Kramers). On a slider of the speed V most break about where
        g² = 2 ln[D/(w V (2 pi)^(1/2))], and their rate grows by e on the travel w/g."""
        width, (contacts, halvings, fastest) = self._cells.width, self._made_of
        ageing = contacts.ageing
        assert ageing is not None
        passed = ageing.rate / (width * speed * (2.0 * np.pi) ** 0.5)
        widths_below = (2.0 * np.log(max(passed, 1.0))) ** 0.5
        if widths_below < CREEPING:
            return
        length = self.length_in_slips / float(widths_below)
        self.scales, self.nearing = self.scales._replace(length=length), NEARING_IN_CREEP
        self._cells = Cells(contacts, halvings - COARSER_IN_CREEP, fastest)
        self.width = self._cells.edges.size

    def start(self, stretch: Array) -> Array:
        return np.append(self._cells.fresh(stretch), np.zeros((stretch.size, 1)), axis=1)

    def fresh(self, stretch: Array, speed: float) -> Array:
        """See Memory; thresholds at birth depend on the stretch only, which is the same for all cohorts."""
        if stretch is not self._born_at:
            self._born_at, self._of_born = stretch, self.start(stretch)
        return self._of_born

    def advance(self, record: Array, leg: StraightMove) -> Array:
        out, rise = record.copy(), np.abs(leg.end) - np.abs(leg.begin)
        # where |x| falls on the way, weights are moved at once, as what it lost before does not come back
        moves = np.full(rise.size, leg.duration > 0.0) | (rise < 0.0) | (leg.begin * leg.end < 0.0)
        out[~moves, RISEN] += rise[~moves]
        if moves.any():
            which = slice(None) if moves.all() else moves  # a slice copies nothing
            begin, end, risen = leg.begin[which], leg.end[which], record[which, RISEN]
            weights = record[which, :RISEN]
            if risen.any():
                weights = self._cells.shifted(weights, risen)
            out[which, :RISEN] = self._cells.stepped(weights, begin, end, leg.duration)
            out[which, RISEN] = 0.0
        return out

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        holding, risen = record[:, :RISEN].sum(axis=1), np.flatnonzero(record[:, RISEN])
        if risen.size:
            holding[risen] = self._cells.weight_above(record[risen, :RISEN], record[risen, RISEN])
        return np.stack([holding, stretch * holding])


class GrowingMemory(Memory):
    """Keeps the largest hazard, the time since pinning, and with heat A."""

    error = 1e-13

    def __init__(self, contacts: Contacts, halvings: int, fastest: float) -> None:
        """Choose the cells, and over what births and steps change."""
        growing, scales, hot = contacts.growing, scales_of(contacts), contacts.thermal is not None
        assert growing is not None
        if refusal := GrowingLife.why_not(contacts):
            raise InputError(refusal)
        self._growing, self._hot, self.starts = growing, hot, warm_nodes(halvings)
        self.nearing = NEARING_OF_HOT_GROWTH if hot else np.inf
        self.largest_stretch, rate = growing.at_start.support()[1], scales.rate
        if growing.begins_at_0:
            # edges are roots of hazards, as small thresholds are proportional to these
            edges = np.linspace(0.0, LARGEST_ROOT, COARSEST_CELLS * 2 ** (halvings // 2) + 1)
            self._hazards = edges**2
            # the rate by which fresh contacts break is that of contacts without thresholds
            rate = 0.0 if contacts.thermal is None else contacts.thermal.rates.scale
        else:
            law = contacts.thresholds
            edges = cell_edges(law, largest_stretch(law), halvings)
            self._hazards = growing.hazard_at(edges, growing.start_pinned_for)
            self.resolves_heat = resolves_heat(contacts, edges)
        self._cells = ThresholdCells(contacts, edges, np.exp(-self._hazards))
        self.width = RATE_INTEGRAL + self._cells.width
        length = WIDTHS_OF_BIRTHS * min(scales.length, growing.quick_width)
        self.scales = Scales(length, min(FIRST_OF_GROWTH * growing.time_unit, scales.time), rate)

    def start(self, stretch: Array) -> Array:
        record = np.zeros((stretch.size, self.width))
        record[:, PINNED_FOR] = self._growing.start_pinned_for
        record[:, LARGEST_HAZARD] = self._growing.hazard_at(stretch, record[:, PINNED_FOR])
        return record

    def fresh(self, stretch: Array, speed: float) -> Array:
        """See Memory; contacts form relaxed, so that their hazard and age are 0. Those that are stretched faster than
        their thresholds grow never hold."""
        record = np.zeros((stretch.size, self.width))
        record[:, LARGEST_HAZARD] = self._growing.lost_hazard(speed)
        return record

    def advance(self, record: Array, leg: StraightMove) -> Array:
        """See Memory; the rate is that of thresholds in the middle of the move, the hazard that at its end, by the
        stretch and the age there."""
        out = record.copy()
        out[:, PINNED_FOR] += leg.duration
        hazard = self._growing.hazard_at(leg.end, out[:, PINNED_FOR])
        out[:, LARGEST_HAZARD] = np.maximum(out[:, LARGEST_HAZARD], hazard)
        if self._hot and leg.duration:
            middle = record[:, PINNED_FOR, None] + 0.5 * leg.duration
            threshold = self._growing.threshold_at(self._hazards, middle)
            out[:, RATE_INTEGRAL:] += self._cells.rate_integral(leg, threshold)
        return out

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        hazard = record[:, LARGEST_HAZARD]
        unmet = np.exp(-hazard)
        if not self._hot:
            return np.stack([unmet, stretch * unmet])
        least = self._edge_of(hazard)
        return self._cells.survival_and_force(record[:, RATE_INTEGRAL:], stretch, least, unmet)

    def _edge_of(self, hazard: Array) -> Array:
        """Where these hazards lie among the edges of cells."""
        if self._growing.begins_at_0:
            return np.sqrt(hazard)
        return self._growing.threshold_at(hazard, self._growing.start_pinned_for)


# The memory of contacts whose thresholds change, by the class of the law: made of the contacts, how often steps are
# halved, and the drive's largest speed. Those of other laws follow from what they state, see `memory_by_law`.
MEMORIES: dict[type, Callable[[Contacts, int, float], Memory]] = {
    Ageing: AgeingMemory,
    GrowingThresholds: GrowingMemory,
}


def memory_by_law(
    contacts: Contacts, halvings: int, fastest: float, motion: Motion | None
) -> Memory:
    """The memory of contacts whose thresholds change; arguments as those of refining.memory_of."""
    for law, made in MEMORIES.items():
        if isinstance(contacts.changing, law):
            return made(contacts, halvings, fastest)
    own = OrderedMemory if isinstance(contacts.changing, OrderedThresholds) else LifeMemory
    return own(contacts, halvings, motion)
