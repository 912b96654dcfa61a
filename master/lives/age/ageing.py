"""Survival of contacts whose thresholds age independently.

At one speed it is a function of the time since the birth, for each stretch at birth. For a Gaussian
final law without heat it comes from the integral equation of the first passage; for other final
laws, or with heat, strands follow the thresholds in time (master.lives.age.strands). Strands have two
resolutions, whose errors differ by a factor of eight; their survivals are extrapolated, and the error
is measured. On a path that turns round, rests or changes its speed, contacts of the start, and births
of earlier legs, are strands that follow the slider leg by leg.
"""

from __future__ import annotations

import time as clock
from functools import cached_property

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev
from scipy.interpolate import BSpline

from master.lives.age.cells import narrowest
from master.lives.age.passage import Passage
from master.lives.age.strands import TRAVEL_STEP, Followed, Mesh, Strands, StrandSurvival
from master.lives.averages import StretchRule, stretch_rule
from master.lives.life import Life
from master.motion.motion import History, Motion
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Error of the finer and of the coarser of two resolutions, over the change between them; a finer
# resolution is tried as long as the error falls below HARDLY times the one before.
FELL, COARSE, HARDLY = 0.5, 4.0, 0.7
# The largest difference at any moment, over the largest at the moments that are compared.
MARGIN = 2.0
# Number of stretches at birth between which survivals are interpolated; and numbers of stretches that
# represent a law, tried in this order: the last one gives some 1e-8 for a start across 0, where
# survivals have a kink.
BETWEEN, COUNTS = 22, (6, 9, 13, 19, 28)
LONGEST = 3.0  # reaches over speed: a time after which hardly any contact holds


class AgeingLife(Life):
    """Life (see master.lives.life) of contacts that age, closure "exact", where X = v t.

    Parameters
    ----------
    contacts : Contacts
    motion : Motion
        X(t); with more than one leg, `left` is for contacts that were born on the last one.
    accuracy : float
        Aimed-at error of the share that holds; strands take very long for 1e-9 and less.
    until : float
        Reading of time.monotonic() after which no finer resolution is tried.

    Attributes
    ----------
    mesh : Mesh
        Cells and steps that suffice for strands.
    furthest : float
        Length beyond which there are hardly any thresholds.
    """

    def __init__(
        self, contacts: Contacts, motion: Motion, accuracy: float, until: float = np.inf
    ) -> None:
        """Keep the contacts and the motion; strands are followed when they are first asked for."""
        ageing = contacts.ageing
        assert ageing is not None and ageing.closure == "exact"
        laws = contacts.thresholds, ageing.final
        self.contacts, self.motion = contacts, motion
        self._accuracy, self._until = accuracy, until
        self.furthest = max(float(law.isf(1e-17)) for law in laws)
        self.reach = self.furthest
        self.grain = TRAVEL_STEP * min(narrowest(law) for law in laws)
        self.fastest = float(np.abs(motion.speeds).max())
        self._closed = ageing.normal is not None and contacts.thermal is None
        self._rules: list[tuple[Start, StretchRule]] = []
        self._tables: dict[tuple[float, float], Passage | StrandSurvival] = {}
        self._missed = self._ruled = self._tabled = self._differed = 0.0
        if not motion.one_leg:
            _ = self.mesh
            return
        births = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        last = max(abs(end) for law in births for end in law.span)
        # a millionth of the thresholds beyond the largest stretch at birth counts for the reach
        last = min(last, float(contacts.thresholds.isf(1e-6)))
        speed = float(motion.speeds[0])
        reached = [r + self._table(speed, r).reach_lag * abs(speed) for r in {0.0, last}]
        self.reach = min(self.furthest, max(reached))

    def _judge(self) -> None:
        """Error of the share that holds: of rules, of strands, of tables, and 1e-13 by rounding."""
        self.error = self._ruled + self._missed + self._tabled + 1e-13

    @cached_property
    def mesh(self) -> Mesh:
        """See above."""
        mesh = Mesh(self.contacts, 1, self.fastest)
        before = self._trial(mesh)
        # the difference between two resolutions, before they are extrapolated
        self._missed = MARGIN * self._differed
        while self._missed > self._accuracy and mesh.resolution < 6:
            if not mesh.cells[1].can_be_finer or clock.monotonic() > self._until:
                break
            finer = Mesh(self.contacts, mesh.resolution + 1, self.fastest)
            now = self._trial(finer)
            last, change = self._missed, float(np.abs(now - before).max())
            if COARSE * change <= self._accuracy and not self.motion.one_leg:
                self._missed = COARSE * change
                break
            mesh, before = finer, now
            self._missed = min(FELL * change, MARGIN * self._differed)
            if self._missed > HARDLY * last:
                break
        self._judge()
        return mesh

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that hold, and their force per contact born; see Life.left."""
        speed = float(self.motion.speeds[0])
        if not self.motion.one_leg:
            legs = history.legs()
            lived = legs.duration.reshape(-1, legs.speed.size).max(axis=0) > 0.0
            speed = float(legs.speed[np.argmax(lived) if lived.any() else -1])
        lag = np.maximum(history.t - history.s, 0.0)
        if not isinstance(born, Start):
            share = self._held(speed, np.broadcast_to(born, lag.shape), lag)
            return np.stack([share, share * (born + speed * lag)])
        out = np.zeros((2, *lag.shape))
        rule = self._rule(born)
        for stretch, weight in zip(rule.stretch, rule.weight, strict=True):
            held = weight * self._table(speed, float(stretch)).survival(lag)
            out += held * np.stack([np.ones(lag.shape), stretch + speed * lag])
        return out

    def _held(self, speed: float, stretch: Array, lag: Array) -> Array:
        """Share that holds of contacts born at these stretches, arrays of one shape; of many stretches
        a polynomial on either side of 0."""
        places = np.unique(stretch)
        if places.size <= BETWEEN:
            parts = [self._table(speed, float(x)).survival(lag) * (stretch == x) for x in places]
            return sum(parts, np.zeros(lag.shape))
        out, nodes = np.zeros(lag.shape), np.cos(np.pi * (np.arange(BETWEEN) + 0.5) / BETWEEN)
        for here in (stretch < 0.0, stretch >= 0.0):
            if here.any():
                low, high = float(stretch[here].min()), float(stretch[here].max())
                middle, half = 0.5 * (low + high), max(0.5 * (high - low), 1e-12 * self.reach)
                tables = [self._table(speed, float(x)) for x in middle + half * nodes]
                known = [table.survival(lag[here]) for table in tables]
                series = np.linalg.solve(chebyshev.chebvander(nodes, BETWEEN - 1), np.array(known))
                z = (stretch[here] - middle) / half
                out[here] = np.clip(chebyshev.chebval(z, series, tensor=False), 0.0, 1.0)
        return out

    def _table(self, speed: float, stretch: float) -> Passage | StrandSurvival:
        """Survival of contacts born at this stretch on a slider that keeps this speed."""
        if (speed, stretch) not in self._tables:
            # |x| does not change when speed and stretch change sign
            along, contacts = -stretch if speed < 0.0 else stretch, self.contacts
            table: Passage | StrandSurvival
            if self._closed and speed:
                assert contacts.ageing is not None
                aim = float(np.clip(1e-3 * self._accuracy, 1e-13, 1e-10))  # of each panel
                table = Passage(contacts.thresholds, contacts.ageing, abs(speed), along, aim)
            else:
                lasts = np.diff(self.motion.times)
                longest = float(lasts[self.motion.speeds == speed].max(initial=lasts.min()))
                if speed:
                    longest = min(longest, LONGEST * (self.furthest - along) / abs(speed))
                table = StrandSurvival(self.begin(SingleStart(along)), abs(speed), longest)
            self._tabled = max(self._tabled, table.error)
            self._judge()
            self._tables[speed, stretch] = table
        return self._tables[speed, stretch]

    def _rule(self, born: Start) -> StretchRule:
        """Stretches for births of the law `born`, as many as the survivals need."""
        for known, rule in self._rules:
            if known is born:
                return rule
        most, missed = self.contacts.thresholds.support()[1], 0.0
        rule = stretch_rule(born, most, COUNTS[0])
        if rule.stretch.size > 1:
            before = self._shares(rule)
            for count in COUNTS[1:]:
                rule = stretch_rule(born, most, count)
                now = self._shares(rule)
                missed, before = float(np.abs(now - before).max()), now
                if missed <= self._accuracy or clock.monotonic() > self._until:
                    break
        self._ruled = max(self._ruled, missed)
        self._judge()
        self._rules.append((born, rule))
        return rule

    def begin(self, born: Start) -> Strands:
        """A strand of contacts that are born now at stretches of the law `born`."""
        return Strands(self.mesh, *self._rule(born))

    def _shares(self, rule: StretchRule) -> Array:
        """Share that holds of contacts born at the rule's stretches at the motion's beginning; strands
        use few cells, whose errors hardly depend on the rule."""
        if self._closed and self.motion.one_leg and self.fastest:
            speed = float(self.motion.speeds[0])
            lags = np.linspace(0.0, 2.0 * self._table(speed, 0.0).reach_lag, 100)
            tables = [self._table(speed, float(stretch)) for stretch in rule.stretch]
            return rule.weight @ np.array([table.survival(lags) for table in tables])
        mesh = Mesh(self.contacts, 1, self.fastest)
        # the same way for any stretches, so that two rules are compared at the same moments
        return self._followed(Strands(mesh, *rule), 0, 2.0 * self.furthest)

    def _trial(self, mesh: Mesh) -> Array:
        """Share that holds, along the whole motion, of the contacts of the start and of some births."""
        legs = self.motion.speeds.size
        births = np.linspace(0, legs - 1, min(4, legs)).astype(int)
        self._differed = 0.0
        start = Strands(mesh, *self._rule(self.contacts.start))
        parts = [self._followed(start, 0, self.furthest - min(float(start.stretch.min()), 0.0))]
        for first in births.tolist():
            relaxed = Strands(mesh, np.zeros(1), np.ones(1))
            parts.append(self._followed(relaxed, first, self.furthest))
        return np.concatenate(parts)

    def _followed(self, strand: Strands, first: int, furthest: float) -> Array:
        """Share that holds of a strand born as the leg `first` begins, at moments of this and later legs."""
        motion, shares, held = self.motion, [], 1.0
        length = TRAVEL_STEP * strand.mesh.width
        for leg in range(first, motion.speeds.size):
            duration, speed = motion.times[leg + 1] - motion.times[leg], motion.speeds[leg]
            if motion.one_leg and speed:
                duration = min(duration, furthest / abs(speed))
            looks = 12 + int(abs(speed) * duration / length)
            ends = np.linspace(0.0, duration, looks + 1)
            if leg == first:  # further points right after a birth
                ends = np.insert(ends, 1, ends[1] * np.array([0.01, 0.1]))
            for time in np.diff(ends):
                if held > 1e-9:
                    strand.advance(speed, time)
                    held = float(strand.left()[0, 0])
                shares.append(held)
        self._differed = max(self._differed, strand.error)
        return np.array(shares)


class AgeingPath(AgeingLife):
    """Life (see master.lives.life) of contacts that age, closure "exact", on any motion.

    `left` is for contacts that moved straight since their birth, and for those of the start;
    master.renewal.strand_births follows births of earlier legs.
    """

    has_strands = True
    _start: Strands | None = None

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life."""
        legs = history.legs()
        lived = (legs.duration.reshape(-1, legs.speed.size).max(axis=0) > 0.0).sum()
        # strands of all stretches of a start follow the slider together
        all_at_once = born is self.contacts.start and not self.contacts.start.is_single
        if lived <= 1 and not all_at_once:
            return super().left(born, history)
        last = history.motion.leg_of_all(history.t)
        t = history.t - history.motion.times[last]
        return self._of_start(last, np.broadcast_to(t, legs.duration.shape[:-1]))

    def _of_start(self, leg: int, t: Array) -> Array:
        """Share and force of the contacts of the start, at times since the beginning of a leg."""
        if self._start is None:
            self._start = self.begin(self.contacts.start)
            self._started: list[BSpline] = []
        while len(self._started) <= leg:
            found = self.follow(self._start, len(self._started))
            self._started.append(found.over_root(found.left[..., 0]))
        spline = self._started[leg]
        found = spline(np.sqrt(np.clip(t, 0.0, float(spline.t[-1]) ** 2)))
        return np.moveaxis(found, -1, 0)

    def aged(self, born: Start, speed: float, ages: Array) -> Strands:
        """Strands of contacts that have moved straight on since their births, `ages` (n,) ago.

        At one speed one strand gives all of them, at different times.
        """
        order, strand = np.argsort(ages), self.begin(born)
        found, age = [], 0.0
        for later in ages[order]:
            strand.advance(speed, later - age)
            found.append(strand.take(np.zeros(1, dtype=np.intp)))
            age = later
        return found[0].join(*found[1:]).take(np.argsort(order))

    def follow(self, strands: Strands, leg: int) -> Followed:
        """Move strands along a leg; returns their shares and forces on the way."""
        duration = float(np.diff(self.motion.times)[leg])
        return strands.follow(float(self.motion.speeds[leg]), duration)
