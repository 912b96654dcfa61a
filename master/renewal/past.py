"""Past: contributions of earlier births, before and on the present leg, to number and force on it.

The sum of the contributions of all births before a leg is a smooth function of time between edges,
whatever legs they come from: it is kept in a table that is refined by halving. Births on the leg
itself use the one table of contacts that moved at one speed (StraightLife). So a life that is
expensive to evaluate, or depends on the whole history, provides only two things: the survival of
contacts on the leg of their birth, and sums over the births of each earlier leg.

Times are counted from the beginning of the present leg, so that they keep their digits late on.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from master.lives import straight
from master.lives.age.ageing import AgeingPath
from master.renewal.births import MOST_WORK, Added, Births, Panels
from master.renewal.earlier import EarlierBirths
from master.renewal.kernels import Kernels
from master.renewal.lumps import NOTHING, Lump
from master.renewal.strand_births import StrandBirths
from master.renewal.table import Table

Array = npt.NDArray[np.float64]

# Error of the table, and of the births of one leg, in units of the tolerance.
ACCURACY = 0.1
# Coefficients of the table's polynomials: each of its values is a sum over all past births, so that
# few wide panels are best; fewer coefficients on legs shorter than the share SHORT of the life's grain.
SIZE, SIZE_OF_SHORT, SHORT = 18, 7, 0.25
# Allowed error at the ends of the table's panels, in units of its accuracy: panels of the march begin
# there, and could not resolve a jump of the number.
ENDS = 2.0
# Share of contacts below which a leg or a lump is dropped, in units of that accuracy: many may be.
NEGLIGIBLE = 1e-3
# Share of a leg below which panels of its table are not halved.
SHORTEST = 1e-20
# Beside an exact threshold a panel is evaluated this share of it inside its ends.
BESIDE = 1e-7
# Share of its width at which a leg's first panel is cut.
FIRST_CUT = 1.0 / 16.0


class Past:
    """Number and force, on the present leg, of contacts born earlier.

    Parameters
    ----------
    births : Births
    kernels : Kernels
        They hold the table of contacts that were born on the present leg.
    tolerance : float
        Of the number of breaks.
    until : float
        Reading of time.monotonic() after which no table is refined.

    Attributes
    ----------
    error : float
        Bound on the error of the number due to the tables, the largest of all legs so far.
    """

    def __init__(
        self, births: Births, kernels: Kernels, tolerance: float, until: float = np.inf
    ) -> None:
        self._births, self._kernels, self._until = births, kernels, until
        self._accuracy = ACCURACY * tolerance
        self._earlier: list[EarlierBirths | StrandBirths] = []
        self._leg, self._begin, self._end = -1, 0.0, 0.0
        self._table: Callable[[Array], Array] | None = None
        self.error = 0.0

    def enter(self, leg: int, edges: Array, lumps: Sequence[Lump], panels: Panels) -> None:
        """Make the table for a leg, unless it is made; edges are counted from its beginning."""
        if leg == self._leg:
            return
        self._close(leg, panels)
        self._leg, self._motion = leg, self._births.motion.since(leg)
        self._late = float(self._births.motion.times[leg])
        self._earlier = [
            own for own in self._earlier if own.seen_from(self._motion, self._negligible)
        ]
        holding = self._holding([lump for lump in lumps if lump.holds and self._is_past(lump)])
        self._table = None
        if not holding and not self._earlier:
            return
        scale = np.array([1.0, 1.0 / self._births.life.reach])[:, None, None]

        def found(x: Array) -> Array:
            if self._births.life.atoms.size:
                # at an edge the births of a hold may meet an exact threshold, all at once
                inside = BESIDE * np.ptp(x, axis=1, keepdims=True)
                x = np.clip(x, x[:, :1] + inside, x[:, -1:] - inside)
            return np.add.reduce(self._parts(x, holding)) * scale

        if isinstance(self._births.life, AgeingPath):
            self._table = found  # these sums are splines already
            self.error = max(self.error, sum(own.missed for own in self._earlier))
            return
        given = found, np.unique(edges), self._accuracy, SHORTEST * float(edges[-1])
        way = abs(float(self._motion.speeds[leg])) * float(edges[-1])
        size = SIZE_OF_SHORT if 0.0 < way < SHORT * self._births.life.grain else SIZE
        # on wide panels all nodes may miss a short life: `ends` and `first_cut` detect it
        table = Table(*given, ends=ENDS, size=size, first_cut=FIRST_CUT, goes_on=self._goes_on)
        self._table, missed = table, sum(own.missed for own in self._earlier)
        self.error = max(self.error, ENDS * table.error + missed)

    def _holding(self, lumps: list[Lump]) -> list[Lump]:
        """The lumps of which some hold at the beginning of this leg; sets `holds` of all."""
        for law in {id(lump.law): lump.law for lump in lumps}.values():
            own = [lump for lump in lumps if lump.law is law]
            s = np.array([[lump.time - self._late] for lump in own])
            history = self._motion.history(np.full(s.shape, np.finfo(float).tiny), s)
            held = self._births.life.left(law, history)[0, :, 0]
            for lump, left in zip(own, held, strict=True):
                lump.holds = bool(left * lump.weight > NOTHING)
        return [lump for lump in lumps if lump.holds]

    def breaking(self, t: float) -> float:
        """Share of all contacts that were born in holds and reach an exact threshold at t.

        t : an edge, on this leg
        """
        t -= self._late
        near = t - BESIDE * min(t, self._births.life.grain) * np.array([2.0, 1.0, 0.0])
        held = [own.sums(near)[0] for own in self._earlier if own.in_hold] if t > 0.0 else []
        # the second difference removes the contacts that break at a steady rate
        return float(sum(-np.diff(part, n=2)[0] for part in held))

    def _goes_on(self) -> bool:
        """Whether there is work and time left."""
        return self._births.work <= MOST_WORK and clock.monotonic() <= self._until

    def _parts(self, x: Array, lumps: Sequence[Lump]) -> list[Array]:
        """Number and force of each earlier leg's births, and of each lump: arrays (2, *x.shape).

        x : array of shape (rows, columns); the middle column decides on which side of an exact
            threshold a row lies
        """
        # t = 0 itself would count as a moment of the leg before
        t = np.maximum(x, np.finfo(float).tiny)
        parts = [own.sums(t.ravel()).reshape(2, *x.shape) for own in self._earlier]
        for lump in lumps:
            self._births.work += self._births.dear * t.size
            history = self._motion.history(t, np.full((1, 1), lump.time - self._late))
            parts.append(lump.weight * self._births.life.left(lump.law, history))
        return parts

    def between(self, begin: float, end: float) -> None:
        """From now on evaluate times as lying between these edges of the leg, at an edge inside."""
        self._begin, self._end = begin, float(np.nextafter(end, begin))

    def _close(self, leg: int, panels: Panels) -> None:
        """Store the births on all legs from the present one up to the one before `leg`."""
        births, motion = self._births, self._births.motion
        on = motion.leg(panels.begin + births.delay + 0.5 * panels.width)
        for earlier in range(max(self._leg, 0), leg):
            own = on == earlier
            if own.any() and np.abs(panels.breaks[own]).max() > self._negligible:
                some = Panels(*(part[own] for part in panels))
                if births.delay > 0.0:
                    born = some.begin + births.delay - motion.times[earlier]
                    some = some._replace(since=np.maximum(born, 0.0))
                if isinstance(births.life, AgeingPath):
                    strands = StrandBirths(births, earlier, some, self._accuracy, self._goes_on)
                    self._earlier.append(strands)
                    continue
                last = self._earlier[-1] if self._earlier else None
                if not isinstance(last, EarlierBirths) or not last.follows(earlier):
                    last = EarlierBirths(births, self._accuracy, self._goes_on)
                    self._earlier.append(last)
                last.add(earlier, some)

    @property
    def _negligible(self) -> float:
        return max(NEGLIGIBLE * self._accuracy, NOTHING)

    def _is_past(self, lump: Lump) -> bool:
        """Whether a lump was born before this leg, or at stretches that broken contacts do not take."""
        if lump.time == self._late:
            law, again, alike = lump.law, self._births.law, self._births.life.fresh_start
            return not (law is again or (alike and law.span == again.span and law.is_single))
        return lump.time < self._late

    def at(self, x: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force of earlier births and of all lumps at times x since the leg's beginning.

        x : array of shape (panels, n), each row within one panel

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
        """Survival and force of contacts born on this leg a time `lag` ago, shape (2, *lag.shape)."""
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
