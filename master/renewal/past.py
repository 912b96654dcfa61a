"""Past: what was born before the present leg adds to number and force on it, and what was born on it.

As a function of time what all earlier births and lumps add on a leg is one smooth function between
edges, whatever legs they come from: it is kept in a table that halving refines. Births of the leg
itself are told by the one table of contacts that moved straight on (StraightLife). So a life that
is dear to ask, or that remembers, is asked for two things alone: contacts born on one leg and seen
on it, and sums over those born on each earlier leg.

Times are counted from the beginning of the present leg, so that they keep their digits late on.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from master.lives import straight
from master.lives.age.path import AgeingPath
from master.renewal.births import MOST_WORK, Births
from master.renewal.kernels import Kernels
from master.renewal.known import Added
from master.renewal.leg_births import LegBirths, Panels
from master.renewal.lumps import NOTHING, Lump
from master.renewal.strand_births import StrandBirths
from master.renewal.table import Table

Array = npt.NDArray[np.float64]

# Errors of the table and of the births of one leg, in units of the tolerance.
FINER = 0.2  # where a survival costs no more than a look-up in a table
ACCURACY, ACCURACY_OF_LEG = 0.1, 0.05
# Coefficients of the table's polynomials: each of its values is a sum over all past births, so that
# few wide panels are best.
SIZE = 18
# Contacts that a leg or a lump may have left to be let go, in units of that error: many are felt.
NEGLIGIBLE = 1e-3
# Share of a leg below which its table is not halved.
SHORTEST = 1e-14
# Share of each length of a ladder of the next one, how many of these there may be, and how many are
# asked for at once.
_RUNG, _MOST_RUNGS, _RUNGS_AT_ONCE = 1.0 / 16.0, 20, 4


class Past:
    """All that was born before the present leg: number and force on it.

    Parameters
    ----------
    births : Births
    kernels : Kernels
        Which know what is left of contacts that were born on the present leg.
    tolerance : float
        Of the number of breaks.
    until : float
        Reading of time.monotonic() after which nothing is refined.

    Attributes
    ----------
    error : float
        Bound on the error of the number that all legs so far had from their tables.
    """

    def __init__(
        self, births: Births, kernels: Kernels, tolerance: float, until: float = np.inf
    ) -> None:
        self._births, self._kernels, self._until = births, kernels, until
        self._accuracy, self._of_leg = ACCURACY * tolerance, ACCURACY_OF_LEG * tolerance
        if births.life.pair_work == 1:
            self._accuracy *= FINER
        self._legs: list[LegBirths | StrandBirths] = []
        self._leg, self._begin, self._end = -1, 0.0, 0.0
        self._table: Callable[[Array], Array] | None = None
        self.error = 0.0

    def enter(self, leg: int, edges: Array, lumps: Sequence[Lump], panels: Panels) -> None:
        """Make the table for a leg, unless it is there; edges are counted from its beginning."""
        if leg == self._leg:
            return
        self._close(leg, panels)
        self._leg, self._motion = leg, self._births.motion.since(leg)
        self._late = float(self._births.motion.times[leg])
        for own in self._legs:
            own.seen_from(self._motion)
        holding = [lump for lump in lumps if lump.holds and self._is_past(lump)]
        self._table = None
        if not holding and not self._legs:
            return
        rungs = self._rungs(holding, float(edges[-1]))
        scale = np.array([1.0, 1.0 / self._births.life.reach])[:, None, None]

        def found(x: Array) -> Array:
            return np.add.reduce(self._parts(x, holding)) * scale

        holding = [lump for lump in holding if lump.holds]
        if holding or self._legs:
            within = edges[(edges > 0.0) & (edges < rungs[-1])]
            shortest = SHORTEST * edges[-1]
            all_edges = np.unique(np.concatenate([rungs, within]))
            wrong = sum(own.missed for own in self._legs)
            if isinstance(self._births.life, AgeingPath):
                self._table = found  # by splines already
            else:
                given = found, all_edges, self._accuracy, shortest
                table = Table(*given, ends=True, size=SIZE, goes_on=self._goes_on)
                self._table, wrong = table, wrong + table.error
            self.error = max(self.error, wrong)

    def _goes_on(self) -> bool:
        """Whether there is work and time left."""
        return self._births.work <= MOST_WORK and clock.monotonic() <= self._until

    def _parts(self, x: Array, lumps: Sequence[Lump]) -> list[Array]:
        """Number and force of each earlier leg's births, and of each lump: arrays (2, *x.shape).

        x : array of shape (rows, columns); the middle column tells on which side of an exact
            threshold a row is
        """
        # the moment at which the leg begins would count as one of the leg before
        t = np.maximum(x, np.finfo(float).tiny)
        parts = [own.sums(t.ravel()).reshape(2, *x.shape) for own in self._legs]
        for lump in lumps:
            self._births.work += self._births.dear * t.size
            history = self._motion.history(t, np.full((1, 1), lump.time - self._late))
            parts.append(lump.weight * self._births.life.left(lump.law, history))
        return parts

    def _rungs(self, lumps: Sequence[Lump], length: float) -> Array:
        """Times since the leg's beginning, first 0, between which the table looks for its panels.

        They get denser towards 0 until half of all contacts hold, as nodes far apart see none of a
        short life, and end where next to none is left. Legs and lumps of which none is felt at the
        beginning are let go.
        """
        times = np.array([0.0, _RUNG * length, length])
        parts, count = self._parts(times[:, None], lumps), len(self._legs)
        felt = [bool(abs(part[0, 0, 0]) > self._negligible) for part in parts]
        for lump, part in zip(lumps, parts[count:], strict=True):
            lump.holds = bool(part[0, 0, 0] > NOTHING)
        number = np.add.reduce(parts)[0, :, 0]
        kept = [part for part, feels in zip(self._legs, felt[:count], strict=True) if feels]
        self._legs, lumps = kept, [lump for lump in lumps if lump.holds]
        while number[1] < 0.5 * number[0] and times.size < _MOST_RUNGS:
            finer = times[1] * _RUNG ** np.arange(_RUNGS_AT_ONCE, 0.0, -1.0)
            found = np.add.reduce(self._parts(finer[:, None], lumps))[0, :, 0]
            times, number = np.insert(times, 1, finer), np.insert(number, 1, found)
        first = int(np.flatnonzero(number >= 0.5 * number[0])[-1])
        ended = np.append(np.flatnonzero(number < self._negligible), times.size - 1)[0]
        return np.append(0.0, times[max(first, 1) : ended + 1])

    def between(self, begin: float, end: float) -> None:
        """From now on moments lie between these edges of the leg, and at an edge on this side."""
        self._begin, self._end = begin, float(np.nextafter(end, begin))

    def _close(self, leg: int, panels: Panels) -> None:
        """Take over the births on all legs from the present one up to before another."""
        births, motion = self._births, self._births.motion
        on = motion.leg(panels.begin + births.delay + 0.5 * panels.width)
        for earlier in range(max(self._leg, 0), leg):
            own = on == earlier
            if own.any() and np.abs(panels.breaks[own]).max() > self._negligible:
                some = Panels(*(part[own] for part in panels))
                if births.delay > 0.0:
                    born = some.begin + births.delay - motion.times[earlier]
                    some = some._replace(since=np.maximum(born, 0.0))
                kind = StrandBirths if isinstance(births.life, AgeingPath) else LegBirths
                self._legs.append(kind(births, earlier, some, self._of_leg, self._goes_on))

    @property
    def _negligible(self) -> float:
        return max(NEGLIGIBLE * self._accuracy, NOTHING)

    def _is_past(self, lump: Lump) -> bool:
        """Whether a lump was born before this leg, or otherwise than contacts re-form."""
        if lump.time == self._late:
            law, again, alike = lump.law, self._births.law, self._births.life.fresh_start
            return not (law is again or (alike and law.span == again.span and law.is_single))
        return lump.time < self._late

    def at(self, x: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force of earlier births and of all lumps at times x since the leg's beginning.

        x : array of shape (panels, n), a row within one panel

        Returns an array of shape (2, *x.shape).
        """
        out = np.zeros((2, *x.shape))
        if self._table is not None:
            out = self._table(np.clip(x, self._begin, self._end))
            out[1] *= self._births.life.reach
        middle = x[:, x.shape[1] // 2]
        for lump in lumps:
            if lump.holds and not self._is_past(lump):
                born = lump.time - self._late
                early = middle < born
                out[0, early] += lump.weight
                if not early.all():
                    out[:, ~early] += lump.weight * self._straight(x[~early] - born)
        return out

    def _straight(self, lag: Array) -> Array:
        """What is left of contacts born on this leg a time before, shape (2, *lag.shape)."""
        history = straight.clock(1.0).history(np.maximum(lag, 0.0), np.zeros((1, 1)))
        return self._kernels.straight(self._leg).left(self._births.law, history)

    def on_leg(self, x: Array, panels: Panels) -> Added:
        """Number and force of births on this leg, and of those that are out, at times x."""
        births, earlier = self._kernels.on_leg(self._leg, float(x.max())), self._births
        motion, here = earlier.motion, panels.begin >= self._late
        begin = np.where(here, panels.since, panels.begin - self._late)
        lag = float(x[0, 0]) - begin - panels.width - births.delay
        held = self._straight(np.maximum(lag, 0.0)[None])[0, 0]
        left = held * np.abs(panels.breaks).max(axis=1)
        born = motion.leg(panels.begin + 0.5 * panels.width + births.delay)
        gone = (born < self._leg) | ((lag > 0.0) & (left < self._negligible))
        out = np.zeros((2, x.size))
        if not gone.all():
            kept = ~gone
            out = births.sums(x.ravel(), begin[kept], panels.width[kept], panels.breaks[kept])
        return Added(out.reshape(2, *x.shape), np.asarray(gone))
