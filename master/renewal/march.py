"""March: number conservation solved panel after panel, along any motion of a rigid slider.

With B(t) the breaks per contact since t = 0, at every t

    1 = G_0(t) + integral over s of E(t, s) dB(s),      F(t) = M_0(t) + integral of K(t, s) dB(s),

where E also counts contacts that are out, which carry no force (see births). G_0 and M_0 are sums over lumps: the
contacts that hold at t = 0, and sets of contacts that break at one moment because they reach one exact threshold
together. On a panel B is a polynomial; its values at the Radau nodes follow from conservation there, given all panels
before. Within one leg of the motion the contribution of a panel to a later one depends only on their distance, so that
a run of equal panels needs one small matrix product a panel. A panel that does not resolve B is halved at once.
"""

from __future__ import annotations

import time as clock
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.births import MOST_WORK, Births, Panels
from master.renewal.edges import LEAST_LUMP
from master.renewal.kernels import TARGETS, Kernels
from master.renewal.lumps import Lump, breaking
from master.renewal.past import Past
from master.renewal.run import Pace, Run, solve_run, steady
from origins.start import Start

Array = npt.NDArray[np.float64]

# A segment longer than this many panels of the last width begins with wide panels.
LONG = 1000.0
# Width of the narrowest panel in units of the life's grain, at T = 0 and with heat (which may break
# contacts at any rate): halving stops here, beside a point that no panel resolves.
NARROWEST, NARROWEST_IN_TIME = 1e-10, 1e-18
# Width of a panel, in units of its time, below which rounding of the time spoils it.
ROUNDED = 1e-13
# Cost of solving a panel, in pieces of integrals (the unit of MOST_WORK), beside these integrals.
RUN_WORK = 100


class March:
    """Breaks and force on panels, by number conservation (paper, Eq. Q5c), run after run.

    Parameters
    ----------
    births : Births
        Computes the contributions of a panel's births to number and force at later times.
    start : Start
        The stretches at t = 0.
    edges : array of shape (n,)
        Times, sorted, at which the number of breaks may bend or jump; the first is 0.
    tolerance : float
        Largest error of the number of breaks on a panel.
    grain : float
        Length over which the number of breaks has to be resolved: the first guess of a panel.
    stretch : float
        The longest |x| that a contact may have: an error of the number times this is one of the force.
    until : float
        Reading of time.monotonic() at which to stop.

    Attributes
    ----------
    begin, width, breaks, force, wrong : lists, one entry a panel
    since : list, the panels' beginnings counted from that of their leg, which keeps all digits
    lumps : list of Lump
    kernels : Kernels
    allowed : float
        Largest width of the next panels.
    settled : float
        Time from which on the rate of breaks was constant; inf where it never was.
    unfinished : bool
        Whether the march was stopped before the last edge.
    """

    def __init__(
        self,
        births: Births,
        start: Start,
        edges: Array,
        tolerance: float,
        grain: float,
        stretch: float,
        until: float = np.inf,
    ) -> None:
        """Begin with the start as the only lump, before the first panel."""
        self.births, self.edges, self.tolerance, self.grain = births, edges, tolerance, grain
        self.life, self.motion = births.life, births.motion
        self.stretch, self.until, self.unfinished = stretch, until, False
        self.settled = np.inf
        self.begin, self.since = list[float](), list[float]()
        self.width: list[float] = []
        self.breaks: list[Array] = []
        self.force: list[Array] = []
        self.wrong: list[float] = []
        self.lumps = [Lump(0.0, 1.0, start)]
        self.kernels, self.allowed = Kernels(births), np.inf
        self._past = Past(births, until)

    @property
    def life_error(self) -> float:
        """Error of the survival itself, to which the residuals of the panels are blind."""
        return max(self.life.error, self.kernels.error) + self._past.error

    @property
    def reached(self) -> float:
        """The time at which the last solved panel ends."""
        return float(self.begin[-1] + self.width[-1]) if self.begin else 0.0

    def run(self) -> March:
        """Solve all panels."""
        for _ in self.runs():
            pass
        return self

    def runs(self) -> Iterator[None]:
        """Solve all panels, yielding after each run of them."""
        leg = -1
        legs = self.motion.leg(0.5 * (self.edges[:-1] + self.edges[1:]))
        for begin, end, now in zip(self.edges[:-1], self.edges[1:], legs, strict=True):
            self._break_lumps(begin, end)
            since = self.motion.times[now]
            if now != leg and (leg >= 0 or self.allowed == np.inf):
                speed = abs(float(self.motion.speeds[now]))
                self.allowed = self.grain / speed if speed else 0.25 * (end - begin)
            leg = now
            yield from self._segment(begin - since, end - since, int(leg))
            if self.unfinished:
                break

    def _pace(self, begin: float, end: float, leg: int) -> Pace:
        """The widths of panels on a segment."""
        allowed, speed = self.allowed, abs(float(self.motion.speeds[leg]))
        most, grain = np.inf, np.inf
        if speed:
            most, grain = self.life.reach / speed, self.grain / speed
            if end - begin > LONG * allowed:
                # after a narrow feature it takes fewer panels to find the width from above
                allowed = min(0.25 * (end - begin), most)
        in_time = not self.life.quick
        narrowest = NARROWEST_IN_TIME if in_time else NARROWEST
        narrowest *= grain if speed else end - begin
        narrowest = max(narrowest, ROUNDED * (begin if in_time else end))
        return Pace(allowed, grain, most, narrowest, self.tolerance, in_time)

    def _segment(self, begin: float, end: float, leg: int) -> Iterator[None]:
        """Solve from one edge to the next; both are times since the leg's beginning."""
        pace = self._pace(begin, end, leg)
        t, width = begin, 0.0
        while end - t > 1e-9 * min(pace.allowed, end - begin):
            if clock.monotonic() > self.until:
                self.unfinished = True
                break
            if self._settled(leg, end - t):
                self._rest(t, end, leg)
                break
            left = max(1, int(np.ceil((end - t) / pace.allowed * (1.0 - 1e-9))))
            if abs((end - t) / left - width) > 1e-9 * width:
                width = (end - t) / left
            run = self._run(t, width, min(pace.count, left), leg)
            bad = np.flatnonzero(run.wrong > self.tolerance)
            # beyond the allowed work, or beside a point that no panel resolves, the error is accepted
            hurried = self.births.work > MOST_WORK or width < max(pace.narrowest, ROUNDED * t)
            bad = bad[:0] if hurried else bad
            good = int(bad[0]) if bad.size else run.wrong.size
            self.keep(self.motion.times[leg] + t, width, run, good, t)
            t = t + good * width if good < left else end
            if bad.size:
                pace.refused(width, run.wrong[bad[0]])
            else:
                pace.resolved(width, run, left - good, hurried)
            self.allowed = pace.allowed
            if not bad.size:
                yield

    def _settled(self, leg: int, left: float) -> bool:
        """Whether breaks have been steady for longer than any life, so that they stay so on this leg.

        The rate of breaks is a mean of the rates over the longest life before: where these agree
        to the tolerance, so do all that follow.
        """
        memory = self.kernels.straight(leg).longest + self.births.delay
        if left < 8.0 * memory or not self.begin or not self.motion.speeds[leg]:
            return False
        if self.reached - max(self.motion.times[leg], self.lumps[-1].time) < 1.1 * memory:
            return False
        first, width = len(self.begin), 0.0
        while width < 1.1 * memory:
            first -= 1
            width += self.width[first]
        panels = Run(np.array(self.breaks[first:]), np.array(self.force[first:]), np.empty(0))
        return steady(panels, np.array(self.width[first:]), self.tolerance, self.stretch)

    def _rest(self, t: float, end: float, leg: int) -> None:
        """One panel of steady breaks up to shortly before the end of the leg, then three more."""
        since = float(self.motion.times[leg])
        self.settled = min(self.settled, since + t - 0.5 * self.width[-1])
        memory = self.kernels.straight(leg).longest + self.births.delay
        rate = self.breaks[-1][-1] / self.width[-1]
        share = np.append(0.0, rule.NODES)
        last = np.full(share.size, self.force[-1].mean())
        wrong = np.full(1, self.wrong[-1] + 0.25 * self.tolerance)
        ends = [t, end - 3.0 * memory, end - 2.0 * memory, end - memory, end]
        for first, second in pairwise(ends):
            run = Run((rate * (second - first) * share)[None], last[None], wrong)
            self.keep(since + first, second - first, run, 1, first)

    def keep(self, t: float, width: float, run: Run, good: int, since: float) -> None:
        """Append the first `good` panels of a run that begins at t, `since` from its leg's beginning."""
        steps = width * np.arange(good)
        self.begin.extend(t + steps)
        self.since.extend(since + steps)
        self.width.extend([width] * good)
        self.breaks.extend(run.breaks[:good])
        self.force.extend(run.force[:good])
        self.wrong.extend(run.wrong[:good])

    def _run(self, t: float, width: float, count: int, leg: int) -> Run:
        """Solve panels of one width from t on, counted from the leg's beginning."""
        self.births.work += RUN_WORK * count
        same = self._same(width, leg)
        kernel = self.kernels.on(leg, width, same + count)
        grid = t + width * (np.arange(count)[:, None] + TARGETS)
        found = self.known(grid, same, leg)
        return solve_run(kernel, found, self.breaks[len(self.breaks) - same :], self.stretch)

    def _same(self, width: float, leg: int) -> int:
        """How many of the last panels, all on this leg, have this width."""
        begin, same = self.motion.times[leg] - 1e-9 * width, 0
        while same < len(self.width) and self.width[-1 - same] == width:
            if self.begin[-1 - same] < begin:
                break
            same += 1
        return same

    def known(self, grid: Array, same: int = 0, leg: int | None = None) -> Array:
        """Number and force at later times, of lumps and of all panels but the last `same`.

        grid : array of shape (panels, TARGETS.size) of times, all on one leg; with `leg`, counted
            from its beginning
        """
        if leg is None:
            leg = self.motion.leg_of_all(grid)
            grid = grid - self.motion.times[leg]
        late, last = float(self.motion.times[leg]), len(self.begin) - same
        edges = self.edges[self.motion.leg(self.edges) == leg] - late
        self._past.enter(leg, self._panels(0), self.lumps, np.append(0.0, edges))
        out, t = self._past.at(grid, self.lumps), grid.ravel()
        longest, delay = self.kernels.straight(leg).longest, self.births.delay
        first = max(bisect_right(self.begin, late + t.min() - longest - delay) - 1, 0)
        own = self._on_leg(t, leg, self._panels(max(first, self._past.first), last))
        out += own.reshape(out.shape)
        if delay > 0.0 and first < last:
            # contacts that are out count as well
            begin, _, width, breaks = self._panels(first, last)
            share = (late + t - [[[0.0]], [[delay]]] - begin[:, None]) / width[:, None]
            values = rule.values(np.clip(share, 0.0, 1.0))
            out[0] += np.einsum("ptn,pn->t", values[0] - values[1], breaks).reshape(grid.shape)
        return out

    def _panels(self, first: int, last: int | None = None) -> Panels:
        """Solved panels from one to before another."""
        lists = (self.begin, self.since, self.width)
        begin, since, width = (np.array(part[first:last], dtype=float) for part in lists)
        breaks = np.array(self.breaks[first:last]).reshape(-1, rule.DEGREE + 1)
        return Panels(begin, since, width, breaks)

    def _on_leg(self, t: Array, leg: int, panels: Panels) -> Array:
        """Number and force at times t on a leg, counted from its beginning, of births on it."""
        if not panels.begin.size:
            return np.zeros((2, t.size))
        late = self.motion.times[leg]
        born = np.where(panels.begin >= late, panels.since, panels.begin - late) + self.births.delay
        return self.kernels.sums(
            leg, t, np.append(born, born[-1] + panels.width[-1]), panels.breaks
        )

    def held(self, leg: int, t: float) -> float:
        """Share of all contacts that were born on a leg and hold at the time t."""
        panels, motion = self._panels(0, bisect_left(self.begin, t)), self.motion
        legs, now = motion.leg(panels.middle_of_births(self.births.delay)), int(motion.leg(t))
        panels = panels._replace(breaks=panels.breaks * (legs == leg)[:, None])
        past, x = Past(self.births), np.array([[t - motion.times[now]]])
        past.find(now, panels)
        own = self._on_leg(x[0], now, Panels(*(part[past.first :] for part in panels)))
        return float(past.sums(x)[0, 0, 0] + own[0, 0])

    def _break_lumps(self, t: float, end: float) -> None:
        """Make a new lump of the contacts that reach an exact threshold at the edge t."""
        if not t > 0.0 or not len(self.life.atoms):
            return
        before, after = t - 0.5 * self.width[-1], t + 0.5 * (end - t)
        lost = breaking(self.births, self.lumps, before, t, after)
        lost += self._past.breaking(t)
        if lost > LEAST_LUMP:
            self.lumps.append(Lump(t + self.births.delay, lost, self.births.law))
