"""Survival of contacts whose thresholds age independently towards a normal law, without heat.

At one speed it is a function of the time since the birth, for each stretch at birth. On a path that turns round, rests
or changes its speed, contacts of the start, and births of earlier legs, are strands that follow the slider leg by leg.
Both come from the integral equation of the first passage (`Passage`).
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from master.motion import History, Motion
from master.numerics.averages import StretchNodes, stretch_nodes
from master.survival.age.extent import highest, narrowest
from master.survival.age.passage import Passage
from master.survival.age.passages import Passages, over_root
from master.survival.changing import ChangingLife
from master.survival.life import MARGIN, Survivors
from origins import Contacts
from origins.start import Start
from origins.thresholds.law import Array

# Share of the thresholds that may lie above the longest stretch: below the rounding of 1.
NONE_ABOVE = 1e-17
# Error of the survival of contacts that age, in tolerances of the force, of which it is one part of several; and the
# least, to which first passages are solved in a time that users wait for.
PART, FINEST = 0.2, 1e-10
# Power of the density of fresh thresholds at 0 below which panels of the first passage, which follow the breaks right
# after a birth, would have to be shorter than rounding allows (measured).
STEEPEST_ONSET = -0.15
# Longest time for which contacts are followed, in mean thresholds divided by the speed: as long as any holds.
LONGEST_AGE = 1e9
# Resolution of panels at first, divided by the narrowest width of the laws.
RESOLUTION = 0.25
# Instants on each leg that are compared, divided by its duration: 20 early ones, and even in the root of time.
INSTANTS = np.append(np.geomspace(1e-8, 1e-4, 20), np.linspace(0.0, 1.0, 80)[1:] ** 2)
# Numbers of stretches that represent a law, tried in this order: the last one gives some 1e-8 for a start across 0,
# where survivals bend.
COUNTS = 6, 9, 13, 19, 28
# Between so many stretches survivals are interpolated, more of them until the error of the fraction that holds is below
# INTERPOLATED: enough for Q(x), which is drawn. Narrow laws would take long to 1e-10.
BETWEEN, INTERPOLATED = (22, 44, 88), 1e-7
# Part of the coefficients, the last ones, whose sum times MARGIN bounds those left out of an interpolating polynomial,
# also where they fall only as their number squared.
LAST_PART = 0.25
LONGEST_LIFE = 3.0  # reaches divided by the speed: a time after which hardly any contact holds
# Rounding of a survival, a fraction of the contacts: it is a sum over panels of the first passage.
ROUNDING = 1e-13


class TimedSurvival(NamedTuple):
    """Survival over the time since the birth, of contacts born at one stretch, and its largest error."""

    at: Callable[[Array], Array]
    error: float


class BirthStretches(NamedTuple):
    """Stretches that represent a law of births, and the error of a survival that is averaged over them."""

    nodes: StretchNodes
    error: float


class AgeingLife(ChangingLife):
    """Life (see master.survival.life) of contacts that age, closure "exact", towards a normal law and without heat.

    With more than one leg `survival_and_force` is for contacts of the start, and for those that have moved straight
    since their birth; master.renewal.strand_births follows births of earlier legs.

    accuracy : aimed-at error of the fraction that holds
    width : narrowest width of the laws (a length)
    until : reading of time.monotonic() after which no finer averages over stretches at birth are tried
    """

    error_is_relative = False
    no_density = (
        "contacts.ageing: Q(x;X) is not known yet along paths of several legs where contacts age"
    )

    def __init__(
        self, contacts: Contacts, motion: Motion, accuracy: float, until: float = np.inf
    ) -> None:
        """Follow the contacts of the start where the motion has more than one leg."""
        ageing = contacts.ageing
        assert ageing is not None and ageing.closure == "exact" and ageing.normal is not None
        laws = contacts.thresholds, ageing.final
        self.contacts, self.motion, self.has_strands = contacts, motion, not motion.one_leg
        self.accuracy, self._until = accuracy, until
        self.largest_stretch = highest(*laws, NONE_ABOVE)
        self.width = min(narrowest(law) for law in laws)
        self.resolution_length = RESOLUTION * self.width
        # in a hold, at the speed 0, as long as any number
        longest = LONGEST_LIFE * self.largest_stretch / np.maximum(np.abs(motion.speeds), 1e-300)
        # of each leg the time until it ends or hardly any contact holds
        self._durations = np.minimum(np.diff(motion.times), longest)
        self._stretches: dict[Start, BirthStretches] = {}
        self._tables: dict[tuple[float, float], TimedSurvival] = {}
        self.error = ROUNDING
        if self.has_strands:
            stretches = self.stretches(contacts.start)
            strand = self.begin(stretches.nodes)
            followed = list(self.follow(strand, 0))
            self._start = [over_root(times, found[..., 0]) for times, found in followed]
            self.error += stretches.error + strand.error

    @classmethod
    def made(cls, contacts: Contacts, tolerance: float, motion: Motion, until: float) -> AgeingLife:
        """See ChangingLife."""
        return cls(contacts, motion, max(PART * tolerance, FINEST), until)

    @classmethod
    def why_not(cls, contacts: Contacts, one_leg: bool = True) -> str:
        """See ChangingLife: no first passage is solved for the paper's closure, beside heat, towards a law that is not
        normal, and of fresh thresholds whose density diverges at 0. The ensemble takes all but the first."""
        ageing, fresh = contacts.ageing, contacts.thresholds
        assert ageing is not None
        if ageing.closure == "paper":
            fault = 'closure = "paper" (Q15) has one P_c for all contacts at each X, and none for single ones'
            hint = 'use closure = "exact", or ask steady_state or critical_velocity, which take it'
            return f"contacts.ageing: {fault}; {hint}"
        instead = "use eq_model.simulate, which takes these contacts"
        if contacts.thermal is not None:
            fault = "on a rigid slider the master equation takes no heat beside ageing"
            return f"contacts.thermal: {fault}; leave one out, or {instead}"
        if ageing.normal is None:
            fault = (
                "on a rigid slider the master equation takes ageing towards a gaussian law alone"
            )
            return f"contacts.ageing: final is no gaussian, and {fault}; {instead}"
        # breaks right after a birth diverge as the density does
        if fresh.support()[0] == 0.0 and fresh.onset_power < STEEPEST_ONSET:
            power = f"as x^{fresh.onset_power:.3g}"
            fault = f"their density diverges at 0 {power}, where contacts that age break as they are born"
            return f"contacts.thresholds: {fault}; {instead}"
        return ""

    @classmethod
    def longest(cls, contacts: Contacts, velocity: float) -> float:
        """See ChangingLife."""
        return LONGEST_AGE * contacts.mean_threshold / velocity

    def survival_and_force(self, born: Start | Array, history: History) -> Survivors:
        """Those of contacts at any stretch; see Life.survival_and_force."""
        motion = history.motion
        leg = motion.leg_of_all(history.t)
        # on a motion of one leg, as that of a present.Straight, contacts of the start are looked up as births
        if born is self.contacts.start and not motion.one_leg:
            now = self._start[leg](history.t - motion.times[leg])
            survival, force = np.moveaxis(now, -1, 0) + np.zeros((2, *history.now.shape))
            return Survivors(survival, force, self.error)
        if isinstance(born, Start):
            nodes, stretches_error = self.stretches(born)
            each = [
                self.survival_and_force(np.full((1, 1), stretch), history)
                for stretch in nodes.stretch
            ]
            survival, force = np.tensordot(nodes.weight, [found.both for found in each], 1)
            error = max(found.error for found in each) + stretches_error
            return Survivors(survival, force, error)
        # the speed of Straight's own motion is rounded; by the speed of this one its table is found again
        speed = float((motion if self.has_strands else self.motion).speeds[leg])
        lag = np.maximum(history.t - history.s, 0.0)
        holding, table_error = self._fraction_holding(speed, born, lag)
        error = max(self.error, table_error + ROUNDING)
        return Survivors(holding, holding * (born + speed * lag), error)

    def _fraction_holding(self, speed: float, born: Array, lag: Array) -> tuple[Array, float]:
        """Of contacts born at these stretches the fraction that holds a time `lag` later, and its largest error: that
        of the tables, and of many stretches that of polynomials between some of them. The fraction bends where |x|
        begins at 0 or at a jump of the fresh law."""
        places, out, error = np.unique(born), np.zeros(lag.shape), 0.0
        if places.size <= BETWEEN[0]:
            for x in places:
                table = self._table(speed, float(x))
                out += table.at(lag) * (born == x)
                error = max(error, table.error)
            return out, error
        stretch, bends = np.broadcast_to(born, lag.shape), self.contacts.thresholds.breakpoints
        piece = np.searchsorted(np.concatenate([-bends[::-1], [0.0], bends]), stretch, "right")
        for each in np.unique(piece):
            here = piece == each
            out[here], missed = self._interpolated(speed, stretch[here], lag[here])
            error = max(error, missed)
        return out, error

    def _interpolated(self, speed: float, stretch: Array, lag: Array) -> tuple[Array, float]:
        """As `_fraction_holding`, of contacts born at many stretches (n,) without a bend between, after lags (n,)."""
        low = float(stretch.min())
        # one stretch, but for rounding, is followed as a narrow range
        span = max(float(np.ptp(stretch)), 1e-12 * self.largest_stretch)
        for count in BETWEEN:
            nodes = chebyshev.chebpts1(count)
            tables = [self._table(speed, float(low + 0.5 * span * (1.0 + x))) for x in nodes]
            at_nodes = np.array([table.at(lag) for table in tables])
            series = np.linalg.solve(chebyshev.chebvander(nodes, count - 1), at_nodes)
            last = np.abs(series[int((1.0 - LAST_PART) * count) :])
            interpolation = MARGIN * float(last.sum(axis=0).max())
            if interpolation <= INTERPOLATED:
                break
        survival = chebyshev.chebval(2.0 * (stretch - low) / span - 1.0, series, tensor=False)
        return survival.clip(0.0, 1.0), max(table.error for table in tables) + interpolation

    def _table(self, speed: float, stretch: float) -> TimedSurvival:
        """Survival over the time of contacts born at this stretch on a slider that keeps this speed."""
        if (speed, stretch) not in self._tables:
            # |x| does not change when speed and stretch change sign
            along = -stretch if speed < 0.0 else stretch
            whole = float(np.ptp(self.motion.times))
            followed = whole
            if speed:
                followed = min(whole, LONGEST_LIFE * self.largest_stretch / abs(speed))
            passage = self._passage(along)
            passage.move(abs(speed), followed)
            # contacts that hold when they are followed no longer count as an error
            rest = max(passage.surviving, 0.0) if followed < whole else 0.0
            self._tables[speed, stretch] = TimedSurvival(passage.survival, passage.error + rest)
        return self._tables[speed, stretch]

    def _passage(self, stretch: float) -> Passage:
        """Of contacts that are born now at a stretch."""
        contacts, fastest = self.contacts, float(np.abs(self.motion.speeds).max())
        assert contacts.ageing is not None
        # of each panel, as a survival is a sum over some fifty; finer ones would resolve their rounding
        aim = max(1e-2 * self.accuracy, 1e-11 if self.has_strands else 1e-12)
        return Passage(contacts.thresholds, contacts.ageing, fastest, stretch, aim)

    def begin(self, nodes: StretchNodes) -> Passages:
        """Passages of one strand, the contacts that are born now."""
        # a tenth: it is one of several parts of the error of a strand
        return Passages(self._passage, *nodes, 0.1 * self.accuracy)

    def follow(self, strands: Passages, first: int) -> Iterator[tuple[Array, Array]]:
        """Of strands the fractions that hold and the forces on one leg after another, from the leg `first` on; see
        Passages.follow."""
        legs = zip(self.motion.speeds[first:], self._durations[first:], strict=True)
        for speed, duration in legs:
            yield strands.follow(float(speed), float(duration))

    def _at_instants(self, strand: Passages) -> Array:
        """Fraction of a strand born at the beginning that holds at INSTANTS of all legs, shape (instants,)."""
        # early instants are left out for births at x = 0: contacts bear no force yet, however many hold
        instants = INSTANTS if strand.born.any() else INSTANTS[20:]
        followed = zip(self.follow(strand, 0), self._durations, strict=True)
        each = [
            over_root(t, found[:, 0, 0])(duration * instants) for (t, found), duration in followed
        ]
        return np.concatenate(each)

    def stretches(self, born: Start) -> BirthStretches:
        """Stretches for births of the law `born`, as many as the survivals need."""
        if born.is_single:
            return BirthStretches(stretch_nodes(born, self.largest_stretch, 1), 0.0)
        if born in self._stretches:
            return self._stretches[born]
        largest = self.contacts.thresholds.support()[1]
        # at which survivals by different numbers of stretches are compared
        lags, speed = np.linspace(0.0, self._durations[0], 150), float(self.motion.speeds[0])
        before = np.zeros(1)
        for count in COUNTS:
            nodes = stretch_nodes(born, largest, count)
            if self.has_strands:
                now = self._at_instants(self.begin(nodes))
            else:
                tables = [self._table(speed, x) for x in nodes.stretch.tolist()]
                now = nodes.weight @ np.array([table.at(lags) for table in tables])
            change, before = float(np.abs(now - before).max()), now
            if change <= self.accuracy or (count > COUNTS[0] and clock.monotonic() > self._until):
                break
        self._stretches[born] = BirthStretches(nodes, change)
        return self._stretches[born]
