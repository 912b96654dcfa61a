"""Survival of contacts whose thresholds age independently.

At one speed it is a function of the time since the birth, for each stretch at birth. On a path that turns round, rests
or changes its speed, contacts of the start, and births of earlier legs, are strands that follow the slider leg by leg.
For a Gaussian final law without heat, and fresh densities that hardly diverge at 0, survivals come from the integral
equation of the first passage (`Passage`); else from densities of thresholds in cells (`Strands`) of two resolutions,
whose errors differ by a factor of eight; these survivals are extrapolated, and the error is measured.
"""

import time as clock
from collections.abc import Callable, Iterator
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from master.motion import History, Motion
from master.numerics.averages import StretchRule, stretch_rule
from master.survival.age.cells import TRAVEL_STEP, Cells, highest, narrowest
from master.survival.age.passage import Passage
from master.survival.age.passages import Passages
from master.survival.age.strands import Strands, over_root, survival_at
from master.survival.life import Life, Survivors
from origins import Contacts
from origins.start import SingleStart, Start
from origins.thresholds.law import Array

# Smallest ratio of an error to that of the resolution before that is trusted; and that above which no
# finer resolution is tried.
LEAST_RATIO, STALLED = 0.125, 0.8
# Factor on an estimated error, which may be larger between the moments at which it is estimated.
MOMENTS_MARGIN = 1.3
# Moments on each leg that are compared, divided by its duration: 20 early ones, and even in the root of time.
MOMENTS = np.append(np.geomspace(1e-8, 1e-4, 20), np.linspace(0.0, 1.0, 80)[1:] ** 2)
# Number of stretches at birth between which survivals are interpolated; and numbers of stretches that
# represent a law, tried in this order: the last one gives some 1e-8 for a start across 0, where survivals have a kink.
BETWEEN, COUNTS = 22, (6, 9, 13, 19, 28)
LONGEST_LIFE = 3.0  # reaches divided by the speed: a time after which hardly any contact holds


class AgeingLife(Life):
    """Life (see master.survival.life) of contacts that age, closure "exact".

    With more than one leg `survival_and_force` is for contacts of the start, and for those that have moved straight
    since their birth; master.renewal.strand_births follows births of earlier legs.

    accuracy : aimed-at error of the share that holds; with cells it takes very long to reach 1e-9 and less
    width : narrowest width of the laws (a length)
    until : reading of time.monotonic() after which no finer resolution is tried
    """

    def __init__(
        self, contacts: Contacts, motion: Motion, accuracy: float, until: float = np.inf
    ) -> None:
        """Follow the contacts of the start where the motion has more than one leg, or fresh ones."""
        ageing = contacts.ageing
        assert ageing is not None and ageing.closure == "exact"
        laws = contacts.thresholds, ageing.final
        self.contacts, self.motion, self.has_strands = contacts, motion, not motion.one_leg
        self.accuracy, self._until = accuracy, until
        self.largest_stretch = highest(*laws, 1e-17)
        self.width = min(narrowest(law) for law in laws)
        self.resolution_length = TRAVEL_STEP * self.width
        longest = LONGEST_LIFE * self.largest_stretch / np.maximum(np.abs(motion.speeds), 1e-300)
        # of each leg the time until it ends or hardly any contact holds
        self._lasts = np.minimum(np.diff(motion.times), longest)
        # where the fresh density diverges at 0, so do the breaks right after a birth: below this power
        # (measured) panels would have to be shorter than rounding allows
        fresh = contacts.thresholds
        diverges = fresh.support()[0] == 0.0 and fresh.onset_power < -0.15
        self._by_passage = not diverges and ageing.normal is not None and contacts.thermal is None
        self._stretches: dict[Start, StretchRule] = {}
        self._tables: dict[tuple[float, float], Callable[[Array], Array]] = {}
        self._errors: dict[str, float] = {}
        if self.has_strands:
            start = self.follow(self.begin(self.stretches(contacts.start)), 0)
            self._start = [over_root(times, left[..., 0]) for times, left in start]
        elif not self._by_passage:
            # so that its error is known from the beginning
            self._table(float(motion.speeds[0]), 0.0)

    def _add_error(self, source: str, error: float) -> None:
        """Count an error of the share that holds: `error` sums the largest of each source, and 1e-13 by rounding."""
        self._errors[source] = max(self._errors.get(source, 0.0), error)
        self.error = self.left_out = sum(self._errors.values()) + 1e-13

    def survival_and_force(self, born: Start | Array, history: History) -> Survivors:
        """Those of contacts at any stretch; see Life.survival_and_force."""
        motion = history.motion
        leg = motion.leg_of_all(history.t)
        # on a motion of one leg, as that of a kernels.Straight, contacts of the start are looked up as births
        if born is self.contacts.start and not motion.one_leg:
            now = self._start[leg](history.t - motion.times[leg])
            share, force = np.moveaxis(now, -1, 0) + np.zeros((2, *history.now.shape))
            return Survivors(share, force, self.error)
        if isinstance(born, Start):
            rule = self.stretches(born)
            each = [
                self.survival_and_force(np.full((1, 1), stretch), history)
                for stretch in rule.stretch
            ]
            share, force = np.tensordot(rule.weight, [found.both for found in each], 1)
            return Survivors(share, force, self.error)
        # the speed of Straight's own motion is rounded; by the speed of this one its table is found again
        speed = float((motion if self.has_strands else self.motion).speeds[leg])
        lag = np.maximum(history.t - history.s, 0.0)
        share = self._held(speed, born, lag)
        return Survivors(share, share * (born + speed * lag), self.error)

    def _held(self, speed: float, born: Array, lag: Array) -> Array:
        """Share that holds of contacts born at these stretches; many are told by a polynomial on either side of 0."""
        places, out = np.unique(born), np.zeros(lag.shape)
        if places.size <= BETWEEN:
            return sum((self._table(speed, float(x))(lag) * (born == x) for x in places), out)
        stretch = np.broadcast_to(born, lag.shape)
        nodes = chebyshev.chebpts1(BETWEEN)
        to_series = np.linalg.inv(chebyshev.chebvander(nodes, BETWEEN - 1))
        for here in (stretch < 0.0, stretch >= 0.0):
            if here.any():
                low = float(stretch[here].min())
                way = max(float(np.ptp(stretch[here])), 1e-12 * self.largest_stretch)
                tables = [self._table(speed, float(low + 0.5 * way * (1.0 + x))) for x in nodes]
                known = np.array([table(lag[here]) for table in tables])
                z = 2.0 * (stretch[here] - low) / way - 1.0
                out[here] = chebyshev.chebval(z, to_series @ known, tensor=False).clip(0.0, 1.0)
        return out

    def _table(self, speed: float, stretch: float) -> Callable[[Array], Array]:
        """Survival over the time of contacts born at this stretch on a slider that keeps this speed."""
        if (speed, stretch) not in self._tables:
            # |x| does not change when speed and stretch change sign
            along, lasts = -stretch if speed < 0.0 else stretch, float(np.ptp(self.motion.times))
            longest = (
                min(lasts, LONGEST_LIFE * self.largest_stretch / abs(speed)) if speed else lasts
            )
            if self._by_passage:
                found = self._passage(along)
                found.move(abs(speed), longest)
                self._add_error("passages", found.error + max(found.left, 0.0) * (longest < lasts))
                self._tables[speed, stretch] = found.survival
            else:
                born = Strands(
                    self.cells, *stretch_rule(SingleStart(along), self.largest_stretch, 1)
                )
                self._tables[speed, stretch] = survival_at(born, abs(speed), longest)
        return self._tables[speed, stretch]

    def _passage(self, stretch: float) -> Passage:
        """Of contacts that are born now at a stretch."""
        contacts, fastest = self.contacts, float(np.abs(self.motion.speeds).max())
        assert contacts.ageing is not None
        aim = max(1e-2 * self.accuracy, 1e-11 if self.has_strands else 1e-12)  # of each panel
        return Passage(contacts.thresholds, contacts.ageing, fastest, stretch, aim)

    def begin(self, rule: StretchRule, coarse: bool = False) -> Strands | Passages:
        """A strand of contacts that are born now; those in cells in the coarsest, or in those that suffice."""
        if self._by_passage:
            return Passages(self._passage, *rule, 0.1 * self.accuracy)
        return Strands(self._coarse if coarse else self.cells, *rule)

    def follow(self, strands: Strands | Passages, first: int) -> Iterator[tuple[Array, Array]]:
        """The strands' shares and forces on one leg after another, from the first on."""
        for speed, lasts in zip(self.motion.speeds[first:], self._lasts[first:], strict=True):
            told = strands.follow(float(speed), float(lasts))
            self._add_error("followed", strands.error)
            yield told

    @cached_property
    def cells(self) -> tuple[Cells, Cells]:
        """Cells of the two resolutions that suffice for strands."""
        cells, before, change, error = self._coarse, self._trial(self._coarse), np.inf, np.inf
        while error > self.accuracy and cells[1].can_be_finer and clock.monotonic() <= self._until:
            finer = cells[1], self._cells_of(cells[1].resolution + 1)
            now = self._trial(finer)
            change, larger = float(np.abs(now - before).max()), change
            # of the first change only that it is larger than the next is known
            fall = float(np.clip(change / larger, LEAST_RATIO, STALLED)) if larger < np.inf else 0.5
            last, error = error, MOMENTS_MARGIN * change / (1.0 - fall)
            if error > self.accuracy:
                cells, before, error = finer, now, fall * error
            if error > STALLED * last:
                break
        self._add_error("cells", error)
        return cells

    @cached_property
    def _coarse(self) -> tuple[Cells, Cells]:
        return self._cells_of(-1), self._cells_of(0)

    def _cells_of(self, resolution: int) -> Cells:
        return Cells(self.contacts, resolution, float(np.abs(self.motion.speeds).max()))

    def _trial(self, cells: tuple[Cells, Cells]) -> Array:
        """Share that holds, along the whole motion, of contacts of the start and of some births, shape (moments,)."""
        legs = self.motion.speeds.size
        firsts = np.linspace(0, legs - 1, min(4, legs)).astype(int).tolist()
        relaxed = stretch_rule(SingleStart(0.0), self.largest_stretch, 1)
        born = [(0, self.stretches(self.contacts.start)), *((first, relaxed) for first in firsts)]
        return np.concatenate([self._shares(Strands(cells, *rule), first) for first, rule in born])

    def _shares(self, strand: Strands | Passages, first: int) -> Array:
        """As _trial, of a strand born as the leg `first` begins, at moments of this and later legs."""
        # early moments are left out for births at x = 0: contacts bear no force yet, however many hold
        moments = MOMENTS if strand.born.any() else MOMENTS[20:]
        followed = zip(self.follow(strand, first), self._lasts[first:], strict=True)
        each = [over_root(t, left[:, 0, 0])(lasts * moments) for (t, left), lasts in followed]
        return np.concatenate(each)

    def stretches(self, born: Start) -> StretchRule:
        """Stretches for births of the law `born`, as many as the survivals need."""
        if born.is_single:
            return stretch_rule(born, self.largest_stretch, 1)
        if born in self._stretches:
            return self._stretches[born]
        most, before = self.contacts.thresholds.support()[1], np.zeros(1)
        lags, speed = np.linspace(0.0, self._lasts[0], 150), float(self.motion.speeds[0])
        for count in COUNTS:
            rule = stretch_rule(born, most, count)
            if self._by_passage and not self.has_strands:
                tables = [self._table(speed, x) for x in rule.stretch.tolist()]
                now = rule.weight @ np.array([table(lags) for table in tables])
            else:  # strands use few cells, whose errors hardly matter
                now = self._shares(self.begin(rule, coarse=True), 0)
            change, before = float(np.abs(now - before).max()), now
            if change <= self.accuracy or (count > COUNTS[0] and clock.monotonic() > self._until):
                break
        self._add_error("stretches", change)
        self._stretches[born] = rule
        return rule
