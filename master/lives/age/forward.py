"""Contacts whose thresholds age, at one speed of the slider: survivals as functions of the age."""

from __future__ import annotations

from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev
from scipy.interpolate import BSpline, make_interp_spline

from master.lives.age.ageing import AgeingLife
from master.lives.age.grid import narrowest
from master.lives.age.passage import Passage
from master.lives.life import UnbentLife
from master.lives.stretch_rule import StretchRule, StretchRules
from master.motion.motion import History, Motion
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# Of the accuracy asked for, what each panel of a first passage may miss.
PER_PANEL = 1e-3
# Survival at which a table of strands ends.
SPENT = 1e-12
# Times at which survivals from more stretches are compared with those from fewer.
LOOKS = 100
# Degree of the splines between the steps of a strand; their errors are below the steps' own.
DEGREE = 5
# Length over which survivals are resolved, of the narrowest width of the laws.
GRAIN = 0.25
# Stretches from which those in between are interpolated, on (-1, 1), and from survivals there to
# Chebyshev coefficients.
_CHEBYSHEV: Array = np.cos(np.pi * (np.arange(22) + 0.5) / 22)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(_CHEBYSHEV, 21))
# Mean lives, as long as the reach over the speed, after which next to none holds.
LONGEST = 3.0


class Survival(Protocol):
    """What holds of contacts born together, as a function of the time since."""

    reach_lag: float
    error: float

    def survival(self, lag: Array) -> Array:
        """Share at times `lag` >= 0 since the birth, same shape."""
        ...


class ForwardAgeing(UnbentLife):
    """Life (see master.lives.life) of contacts that age, closure "exact", where X = v t.

    Towards a Gaussian final law without heat by the integral equation of the first passage; any
    other final law, and heat, by strands. `left` takes any ages; it answers for both solvers of
    number conservation and for steady motion alike.

    Parameters
    ----------
    contacts : Contacts
    velocity : float
        A length per time, of either sign.
    accuracy : float
        Error of the share that holds that is aimed at.
    longest : float
        Time after which no contact is looked at any more; finite where the velocity is 0.
    strands : AgeingLife, optional
        What strands follow, where it is known.
    """

    def __init__(
        self,
        contacts: Contacts,
        velocity: float,
        accuracy: float = 1e-10,
        longest: float = np.inf,
        strands: AgeingLife | None = None,
    ) -> None:
        ageing = contacts.ageing
        assert ageing is not None and (velocity != 0.0 or np.isfinite(longest))
        self._longest, self._strands = longest, strands
        self._contacts, self._velocity, self._accuracy = contacts, velocity, accuracy
        self._rules = StretchRules(contacts.thresholds.support()[1], accuracy, self._shares)
        self._passages = ageing.normal is not None and contacts.thermal is None
        self._passages &= velocity != 0.0
        self._tables: dict[float, Survival] = {}
        ends = np.array(ageing.final.support() if ageing.normal is None else [])
        # where thresholds are reflected contacts begin to break all at once
        self.bends: Array = ends[np.isfinite(ends) & (ends > 0.0)]
        self.bend_sizes: Array = np.ones(self.bends.size)
        self.reach = 0.0
        self.table(0.0)
        self.grain = GRAIN * min(narrowest(law) for law in (contacts.thresholds, ageing.final))

    @property
    def error(self) -> float:
        """Of the share that holds, as measured so far."""
        return self._rules.error + max(table.error for table in self._tables.values())

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that hold, and their force per contact born; see Life.left."""
        lag = np.maximum(history.t - history.s, 0.0)
        if not isinstance(born, Start):
            share = self._held(np.broadcast_to(born, lag.shape), lag)
            return np.stack([share, share * (born + self._velocity * lag)])
        share, force = np.zeros(lag.shape), np.zeros(lag.shape)
        rule = self._rules.of(born)
        for stretch, weight in zip(rule.stretch, rule.weight, strict=True):
            held = weight * self.table(float(stretch)).survival(lag)
            share += held
            force += held * (stretch + self._velocity * lag)
        return np.stack([share, force])

    def _held(self, stretch: Array, lag: Array) -> Array:
        """Share that holds of contacts born at many stretches, arrays of one shape.

        A polynomial of the stretch on either side of 0.
        """
        out = np.zeros(lag.shape)
        first, last = self._contacts.start.span
        for side in (stretch < 0.0, stretch >= 0.0):
            if not side.any():
                continue
            # all over the start's span, so that the nodes are the same each time
            most = min(last, 0.0) if stretch[side][0] < 0.0 else last
            least = first if stretch[side][0] < 0.0 else max(first, 0.0)
            low, high = min(least, stretch[side].min()), max(most, stretch[side].max())
            if low == high:
                out[side] = self.table(low).survival(lag[side])
                continue
            nodes = 0.5 * (low + high) + 0.5 * (high - low) * _CHEBYSHEV
            known = [self.table(float(node)).survival(lag[side]) for node in nodes]
            z = (2.0 * stretch[side] - low - high) / (high - low)
            series = np.tensordot(_TO_SERIES, np.array(known), axes=1)
            out[side] = np.clip(chebyshev.chebval(z, series, tensor=False), 0.0, 1.0)
        return out

    def _shares(self, rule: StretchRule) -> Array:
        """What holds after many times of contacts born at the stretches of a rule."""
        lags = np.linspace(0.0, 2.0 * self.table(0.0).reach_lag, LOOKS)
        tables = [self.table(float(stretch)) for stretch in rule.stretch]
        return rule.weight @ np.array([table.survival(lags) for table in tables])

    def table(self, stretch: float) -> Survival:
        """Survival of contacts born at this stretch."""
        if stretch not in self._tables:
            self._tables[stretch] = found = self._made(stretch)
            way = found.reach_lag * abs(self._velocity)
            self.reach = max(self.reach, abs(stretch), stretch * np.sign(self._velocity) + way)
        return self._tables[stretch]

    def _made(self, stretch: float) -> Survival:
        contacts = self._contacts
        assert contacts.ageing is not None
        # |x| is the same where all lengths change their sign
        along = stretch * np.sign(self._velocity)
        speed = abs(self._velocity)
        if self._passages:
            aim = float(np.clip(PER_PANEL * self._accuracy, 1e-13, 1e-10))
            return Passage(contacts.thresholds, contacts.ageing, speed, along, aim)
        if self._strands is None:
            laws = contacts.thresholds, contacts.ageing.final
            reach = max(float(law.isf(1e-17)) for law in laws)
            reach -= min(contacts.start.span[0] * np.sign(self._velocity), 0.0)
            lasts = min(reach / speed, self._longest)
            motion = Motion(np.array([0.0, lasts]), np.array([0.0, lasts * speed]))
            self._strands = AgeingLife(contacts, motion, self._accuracy)
        return StrandSurvival(self._strands, along, speed, self._longest)


class StrandSurvival:
    """Survival of contacts born at one stretch that age at one speed >= 0, followed by a strand.

    Where |x| turns at 0, and where it comes up to the lower end of the final law, another table
    begins; each is over the root of the time since it began, as survivals change there.
    """

    def __init__(self, life: AgeingLife, stretch: float, speed: float, most: float) -> None:
        strands = life.begin(SingleStart(stretch))
        marks, longest = np.empty(0), most
        if speed > 0.0:
            longest = min(longest, LONGEST * (life.reach - stretch) / speed)
            marks = (np.array([0.0, life.mesh.cells[0].floor]) - stretch) / speed
        marks = np.unique([0.0, *marks[(marks > 0.0) & (marks < longest)], longest])
        self._begins: list[float] = []
        self._splines: list[BSpline] = []
        share = 1.0
        for begin, end in pairwise(marks):
            times, shares = [0.0], [share]
            strands.torn = True  # thresholds may have gathered where the level comes now
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
