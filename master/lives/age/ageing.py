"""Survival of contacts whose thresholds age independently, on a slider that moves straight.

At one speed it is a function of the time since the birth, for each stretch at birth. For a Gaussian
final law without heat it comes from the integral equation of the first passage; for other final
laws, or with heat, strands follow the thresholds in time (master.lives.age.strands). Strands have two
resolutions, whose errors differ by a factor of eight; their survivals are extrapolated, and the error
is measured.
"""

from __future__ import annotations

import time as clock
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev
from scipy.interpolate import BSpline, make_interp_spline

from master.lives.age.grid import narrowest
from master.lives.age.passage import Passage
from master.lives.age.strands import TRAVEL_STEP, Mesh, Strands
from master.lives.life import UnbentLife
from master.lives.stretch_rule import StretchRule, StretchRules
from master.motion.motion import History, Motion
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Error of the finer and of the coarser of two resolutions, over the change between them; a finer
# resolution is tried as long as the error falls below HARDLY times the one before.
FELL, COARSE, HARDLY = 0.5, 4.0, 0.7
# The largest difference at any moment, over the largest at the moments that are compared.
MARGIN = 2.0
# Error by rounding of the share that holds.
ROUND_OFF = 1e-13
# The finest resolution. To choose one, TRIALS births are followed and compared at LOOKS or more points
# of each leg, until only the share FAINT holds.
FINEST, TRIALS, LOOKS, FAINT = 6, 4, 12, 1e-9
# Further points right after a birth, in units of the time to the first point.
EARLY = np.array([0.01, 0.1])
# Error of each panel of a first passage, in units of the accuracy.
PER_PANEL = 1e-3
# Survival at which a table of strands ends, and the degree of its splines.
SPENT, DEGREE = 1e-12, 5
# Number of stretches at birth between which survivals are interpolated.
BETWEEN = 22
# Number of equal parts of the reach, each tabulated on its own panels.
MARKS = 16
# Time, in units of reach over speed, after which hardly any contact holds.
LONGEST = 3.0
# Share of thresholds above the largest stretch at birth that counts for the reach.
LEAST = 1e-6


class AgeingLife(UnbentLife):
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
        Length beyond which there are hardly any thresholds. (On one leg no contact holds beyond `reach`.)
    """

    def __init__(
        self,
        contacts: Contacts,
        motion: Motion,
        accuracy: float = 1e-10,
        until: float = np.inf,
    ) -> None:
        ageing = contacts.ageing
        assert ageing is not None and ageing.closure == "exact"
        laws = contacts.thresholds, ageing.final
        self.contacts, self.motion = contacts, motion
        self._accuracy, self._until = accuracy, until
        self.furthest = max(float(law.isf(1e-17)) for law in laws)
        self.reach = self.furthest
        self.grain = TRAVEL_STEP * min(narrowest(law) for law in laws)
        self.fastest = float(np.abs(motion.speeds).max())
        ends = np.array(ageing.final.support() if ageing.normal is None else [])
        # at an end of P_cf, where thresholds are reflected, breaking begins abruptly
        self.bends: Array = ends[np.isfinite(ends) & (ends > 0.0) & motion.one_leg]
        self.bend_sizes: Array = np.ones(self.bends.size)
        self._closed = ageing.normal is not None and contacts.thermal is None
        most = contacts.thresholds.support()[1]
        self._rules = StretchRules(most, accuracy, self._shares, until)
        self._tables: dict[tuple[float, float], Passage | StrandSurvival] = {}
        self._missed = self._differed = 0.0
        if not motion.one_leg:
            _ = self.mesh
            return
        births = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        last = max(abs(end) for law in births for end in law.span)
        last = min(last, float(contacts.thresholds.isf(LEAST)))
        speed = float(motion.speeds[0])
        reached = [r + self._table(speed, r).reach_lag * abs(speed) for r in {0.0, last}]
        self.reach = min(self.furthest, max(reached))

    @property
    def error(self) -> float:
        """Error of the share that holds, as measured so far."""
        tables = max((table.error for table in self._tables.values()), default=0.0)
        return self._rules.error + max(self._missed, tables) + ROUND_OFF

    @cached_property
    def mesh(self) -> Mesh:
        """See above."""
        mesh = Mesh(self.contacts, 1, self.fastest)
        before = self._trial(mesh)
        # the difference between two resolutions, before they are extrapolated
        self._missed = MARGIN * self._differed
        while self._missed > self._accuracy and mesh.resolution < FINEST:
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
        return mesh

    def marks(self, width: float) -> Array:
        """See Life; on wider panels integrals may be off by more than their last coefficients."""
        return np.union1d(self.bends, np.linspace(0.0, self.reach, MARKS + 1)[1:])

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
        rule = self._rules.of(born)
        for stretch, weight in zip(rule.stretch, rule.weight, strict=True):
            held = weight * self._table(speed, float(stretch)).survival(lag)
            out += held * np.stack([np.ones(lag.shape), stretch + speed * lag])
        return out

    def _held(self, speed: float, stretch: Array, lag: Array) -> Array:
        """Share that holds of contacts born at one stretch, or within the start's span.

        Arrays of one shape; a polynomial of the stretch on either side of 0.
        """
        if stretch.size and not np.ptp(stretch):
            return self._table(speed, float(stretch.flat[0])).survival(lag)
        out = np.zeros(lag.shape)
        first, last = self.contacts.start.span
        nodes = np.cos(np.pi * (np.arange(BETWEEN) + 0.5) / BETWEEN)
        for low, high in ((first, min(last, 0.0)), (max(first, 0.0), last)):
            here = (low <= stretch) & (stretch < high)
            if here.any():
                places = 0.5 * (low + high) + 0.5 * (high - low) * nodes
                known = [self._table(speed, float(x)).survival(lag[here]) for x in places]
                series = np.linalg.solve(chebyshev.chebvander(nodes, BETWEEN - 1), np.array(known))
                z = (2.0 * stretch[here] - low - high) / (high - low)
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
                aim = float(np.clip(PER_PANEL * self._accuracy, 1e-13, 1e-10))
                table = Passage(contacts.thresholds, contacts.ageing, abs(speed), along, aim)
            else:
                lasts = np.diff(self.motion.times)
                most = float(lasts[self.motion.speeds == speed].max(initial=lasts.min()))
                table = StrandSurvival(self, along, abs(speed), most)
            self._tables[speed, stretch] = table
        return self._tables[speed, stretch]

    def begin(self, born: Start, count: int = 1) -> Strands:
        """`count` strands of contacts that are born now at stretches of the law `born`."""
        return self._born(self.mesh, born, count)

    def _born(self, mesh: Mesh, born: Start, count: int = 1) -> Strands:
        rule = self._rules.of(born)
        return Strands(mesh, np.tile(rule.stretch, count), np.tile(rule.weight, (count, 1)))

    def _shares(self, rule: StretchRule) -> Array:
        """Share that holds of contacts born at the rule's stretches at the motion's beginning.

        Strands use few cells here, as the errors of the cells hardly depend on the rule.
        """
        if self._closed and self.motion.one_leg and self.fastest:
            speed = float(self.motion.speeds[0])
            lags = np.linspace(0.0, 2.0 * self._table(speed, 0.0).reach_lag, 100)
            tables = [self._table(speed, float(stretch)) for stretch in rule.stretch]
            return rule.weight @ np.array([table.survival(lags) for table in tables])
        mesh = Mesh(self.contacts, 1, self.fastest)
        # the same way for any stretches, so that two rules are compared at the same moments
        return self._followed(
            Strands(mesh, rule.stretch, rule.weight[None]), 0, 2.0 * self.furthest
        )

    def _trial(self, mesh: Mesh) -> Array:
        """Share that holds, along the whole motion, of the contacts of the start and of some births."""
        legs = self.motion.speeds.size
        births = np.linspace(0, legs - 1, min(TRIALS, legs)).astype(int)
        self._differed = 0.0
        start, relaxed = self._born(mesh, self.contacts.start), SingleStart(0.0)
        parts = [self._followed(start, 0, self.furthest - min(float(start.stretch.min()), 0.0))]
        for first in births.tolist():
            parts.append(self._followed(self._born(mesh, relaxed), first, self.furthest))
        return np.concatenate(parts)

    def _followed(self, strand: Strands, first: int, furthest: float) -> Array:
        """Share that holds of a strand born as the leg `first` begins, at moments of this and later legs."""
        motion, shares, held = self.motion, [], 1.0
        length = TRAVEL_STEP * strand.mesh.width
        for leg in range(first, motion.speeds.size):
            duration, speed = motion.times[leg + 1] - motion.times[leg], motion.speeds[leg]
            if motion.one_leg and speed:
                duration = min(duration, furthest / abs(speed))
            looks = LOOKS + int(abs(speed) * duration / length)
            ends = np.linspace(0.0, duration, looks + 1)
            if leg == first:
                ends = np.insert(ends, 1, ends[1] * EARLY)
            for time in np.diff(ends):
                if held > FAINT:
                    strand.advance(speed, time)
                    held = float(strand.left()[0, 0])
                shares.append(held)
        self._differed = max(self._differed, strand.error)
        return np.array(shares)


class StrandSurvival:
    """Survival of contacts born at one stretch that age at one speed >= 0, followed by a strand.

    A new table begins where |x| turns at 0, and where it reaches the lower end of the final law; the
    variable of each is the root of the time since its beginning, in which survivals are smooth there.
    """

    def __init__(self, life: AgeingLife, stretch: float, speed: float, most: float) -> None:
        strands = life.begin(SingleStart(stretch))
        marks, longest = np.empty(0), most
        if speed > 0.0:
            longest = min(longest, LONGEST * (life.furthest - stretch) / speed)
            marks = (np.array([0.0, life.mesh.cells[0].floor]) - stretch) / speed
        marks = np.unique([0.0, *marks[(marks > 0.0) & (marks < longest)], longest])
        self._begins: list[float] = []
        self._splines: list[BSpline] = []
        share = 1.0
        for begin, end in pairwise(marks):
            times, shares = [0.0], [share]
            strands.torn = True  # thresholds may have gathered right above the new level
            for time in np.diff(strands.steps_of(speed, end - begin)):
                strands.advance(speed, time)
                strands.torn = False
                times.append(times[-1] + float(time))
                share = float(strands.left()[0, 0])
                shares.append(share)
                if share < SPENT:
                    break
            self._begins.append(begin)
            self._splines.append(make_interp_spline(np.sqrt(times), shares, k=DEGREE))
            self.reach_lag = float(begin + times[-1])
            strands.since = 0.0
            if share < SPENT:
                break
        self.error = life.error + (share if share < SPENT else 0.0)

    def survival(self, lag: Array) -> Array:
        """Share at times `lag` >= 0 since the birth, same shape."""
        out = np.zeros(lag.shape)
        ends = [*self._begins[1:], self.reach_lag]
        for begin, end, spline in zip(self._begins, ends, self._splines, strict=True):
            here = (lag >= begin) & (lag <= end)
            out[here] = np.clip(spline(np.sqrt(lag[here] - begin)), 0.0, 1.0)
        return out
