"""Pull: contacts on a slider that moves in one direction, solved as far as is needed.

At T = 0 nothing depends on time, so t of the march is the distance that the slider has travelled.
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from master.lives.cold import ColdLife
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import MOST_WORK, Births
from master.renewal.cut import cut, hold
from master.renewal.edges import Moment, Together, edges
from master.renewal.kernels import TARGETS
from master.renewal.march import March
from master.soft.curve import Curve, Panels
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

# First guess of a panel's width, in grains of the life; it gives 1e-10 for Gaussian thresholds.
WIDE = 6.0
# Shortest move, and narrowest panel, in grains of the life.
STILL = 1e-12


class StoppedError(Exception):
    """The solution has reached its limit of work or time."""


@dataclass
class Matter:
    """The contacts, and the tolerance and limits of their solution.

    Attributes
    ----------
    life : ColdLife
    start, again : Start
        Stretches at the start, and those at which broken contacts form again.
    unit : float
        Mean threshold (a length).
    tolerance : float
        Of the number of breaks on a panel.
    until : float
        Reading of time.monotonic() at which to stop.
    crowded : bool
        Whether there were more lumps than can be followed.
    nodes : int
        Moments at which number conservation was solved.
    """

    life: ColdLife
    start: Start
    again: Start
    unit: float
    tolerance: float
    until: float = np.inf
    crowded: bool = False
    nodes: int = 0

    @classmethod
    def of(cls, contacts: Contacts, tolerance: float, until: float = np.inf) -> Matter:
        life, unit = ColdLife(contacts), contacts.mean_threshold
        again = SingleStart(0.0) if contacts.reforming is None else contacts.reforming.law
        # the beginning of a slip depends on F', and the error of a polynomial's slope is some hundred
        # times that of its values: hence 1e-4 of the tolerance, which counts as 1e-6 mean thresholds
        # at most; below 1e-13 panels would be halved for round-off alone
        finer = max(1e-4 * min(tolerance, 1e-6) * unit / life.reach, 1e-13)
        return cls(life, contacts.start, again, unit, finer, until)

    def relaxed(self) -> Matter:
        """The same contacts, all just formed again."""
        return replace(self, start=self.again, nodes=0)

    def force_of(self, born: Start) -> float:
        """F/(N_c <k>) of contacts with these stretches (a length)."""
        still = np.zeros((1, 3))
        history = Motion.along(np.array([0.0, self.unit])).history(still, still)
        return float(self.life.left(born, history)[1, 0, 0])


@dataclass(frozen=True)
class Past:
    """The history before a straight move of the slider.

    Attributes
    ----------
    march : March or None
        None before the first move.
    cut, end : float
        Distance travelled up to which the march holds, and at which the move begins: in between no
        contact is born.
    line : tuple of float
        X where the slider began, where it turned, and where it is (lengths).
    moments : tuple of Moment
        Those at which breaks bend.
    error : float
        Error of the force due to errors of this history (a length).
    """

    march: March | None = None
    cut: float = 0.0
    end: float = 0.0
    line: tuple[float, ...] = (0.0,)
    moments: tuple[Moment, ...] = ()
    error: float = 0.0

    def line_to(self, x: float) -> tuple[float, ...]:
        """The line with one more point, without points between which the direction is kept."""
        line = self.line
        straight = len(line) > 1 and (line[-1] - line[-2]) * (x - line[-1]) > 0.0
        return (*line[: len(line) - straight], x)


class Pull:
    """Contacts while the slider moves in one direction, +1 or -1, and broken contacts re-form."""

    def __init__(self, matter: Matter, direction: int, past: Past) -> None:
        self.matter, self.direction, self.past = matter, direction, past
        # plan 2 mean thresholds ahead first: most sliders slip before
        self._moments, self._ahead = past.moments, 2.0 * matter.unit
        self._march = self._plan(past.march, past.cut, past.end)
        self._first, self._runs = len(self._march.begin), self._march.runs()

    def at(self, y: Array | float) -> Any:
        """X after the travel y, relative to where the slider began (lengths)."""
        return self.past.line[-1] + self.direction * y

    def reach(self, y: float) -> None:
        """Solve up to the travel y at least."""
        while len(self._march.begin) == self._first or self._solved < self.past.end + y:
            self._spend()
            before = len(self._march.begin)
            if next(self._runs, self) is self:
                self._ahead *= 2.0
                self._march = self._plan(self._march, self._solved, self._solved)
                self._runs = self._march.runs()
            else:
                self.matter.nodes += (len(self._march.begin) - before) * rule.DEGREE

    def _spend(self) -> None:
        """Raise StoppedError where the limit of work or time is reached."""
        # following a lump over one run of panels costs as much as 15 pieces of integrals over births
        self._march.births.work += 15 * len(self._march.lumps)
        if self._march.births.work > MOST_WORK or clock.monotonic() > self.matter.until:
            raise StoppedError

    def curve(self, spring: float) -> Curve:
        """The load along the move, as far as it is solved."""
        past, lumps = self.past, self._march.lumps
        begin, width, force, wrong = self._panels()
        panels = Panels(
            begin - past.end, width, self.direction * force, wrong * self.matter.life.reach
        )
        # a drop by more than this share of the contacts, well above rounding, makes a slip
        drops = [lump.time for lump in lumps if lump.time > past.end and lump.weight > 1e-13]
        # round-off of the force grows with the distance travelled
        rounding = 1e-14 * (self.matter.unit + panels.begin)
        rounding += self._march.life_error * self.matter.life.reach
        error = past.error + np.maximum.accumulate(panels.rough) + rounding
        return Curve(panels, error, np.array(drops) - past.end, spring)

    def _panels(self) -> Panels:
        """The move's panels, in distance travelled; errors are relative to the longest stretch."""
        march, here = self._march, slice(self._first, None)
        lists = march.begin, march.width, march.force, march.wrong
        return Panels(*(np.array(values[here]) for values in lists))

    def after(self, y: float, error: float) -> Past:
        """The history after the travel y; `error` is that of the force due to it."""
        y = max(y, STILL * self.matter.life.grain)
        end, line = self.past.end + y, self.past.line_to(self.at(y))
        met = tuple(moment for moment in self._moments if moment.time < end)
        return Past(self._march, end, end, line, (*met, Moment(end, 1)), error)

    @property
    def _solved(self) -> float:
        return self._march.reached

    def _plan(self, march: March | None, cut_at: float, since: float) -> March:
        """The march that continues from `since`; from `cut_at` to there no contact is born."""
        matter, end = self.matter, since - self.past.end + self._ahead
        motion = Motion.along(np.array(self.past.line_to(self.at(end))))
        births = Births(matter.life, matter.again, motion, accuracy=0.1 * matter.tolerance)
        if march is None:
            wide = WIDE * matter.life.grain
            nothing, reach = np.empty(0), matter.life.reach
            march = March(births, matter.start, nothing, matter.tolerance, wide, reach)
        else:
            march = cut(march, cut_at, births)
            if cut_at < since:
                hold(march, cut_at, since)
        single = [lump for lump in march.lumps if lump.law.is_single]
        plan = edges(
            motion,
            matter.life,
            matter.start,
            matter.again,
            0.0,
            matter.tolerance,
            since=since,
            known=self._moments,
            born=[Together(lump.time, lump.weight, lump.law.mean()) for lump in single],
        )
        if plan.too_many_lumps:
            matter.crowded = True
            raise StoppedError
        self._moments, march.edges = tuple(plan.moments), plan.times
        return march


class Held(Pull):
    """Contacts during a slip in which broken contacts stay out until the slider stops."""

    def __init__(self, matter: Matter, direction: int, past: Past) -> None:
        super().__init__(matter, direction, past)
        self._width, self._kept = WIDE * matter.life.grain, list[Panels]()

    def reach(self, y: float) -> None:
        """See Pull."""
        grain, tolerance = self.matter.life.grain, self.matter.tolerance
        while not self._kept or self._solved < self.past.end + y:
            self._spend()
            begin = self._solved
            later = self._march.edges[self._march.edges > begin + STILL * grain]
            if not later.size:
                self._ahead *= 2.0
                self._march = self._plan(self._march, self.past.end, self.past.end)
                continue
            width = min(self._width, float(later[0]) - begin)
            _, force = self._march.known(begin + width * TARGETS[None])
            force = force[:, : rule.DEGREE + 1]
            wrong = np.abs(force @ rule.TO_LEGENDRE[-2:].T).max(axis=1) / self.matter.life.reach
            if wrong[0] > tolerance and width > STILL * grain:
                self._width = 0.5 * width
                continue
            self._kept.append(Panels(np.array([begin]), np.array([width]), force, wrong))
            self._width *= 2.0 if wrong[0] < tolerance * 0.5**rule.DEGREE else 1.0

    def _panels(self) -> Panels:
        return Panels(*(np.concatenate(parts) for parts in zip(*self._kept, strict=True)))

    @property
    def _solved(self) -> float:
        last = self._kept[-1] if self._kept else None
        return self.past.end if last is None else float(last.begin[0] + last.width[0])

    def holding(self, y: float) -> float:
        """Share of the contacts that hold after the travel y."""
        at = np.full((1, TARGETS.size), self.past.end + y)
        return float(self._march.known(at)[0][0, 0])

    def stands(self, y: float, error: float) -> Past:
        """The history when the slip ends after the travel y, and broken contacts re-form."""
        moved = self.after(y, error)
        met = (*self.past.moments, Moment(moved.end, 0))
        return replace(moved, cut=self.past.end, moments=met)
