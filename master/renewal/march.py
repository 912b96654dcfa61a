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
from master.renewal.births import MOST_WORK, Births, Lump, Panels
from master.renewal.edges import LEAST_LUMP
from master.renewal.kernels import TARGETS, Kernels, Run, solve_run
from master.renewal.past import Past
from origins.start import Start

Array = npt.NDArray[np.float64]

# Width of a panel, in units of its time, below which rounding of the time spoils it.
ROUNDED = 1e-13


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
    lumps : list of Lump, the start first
    kernels : Kernels
    widest : float
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
        self.begin, self.since, self.width, self.wrong = (list[float]() for _ in range(4))
        self.breaks, self.force = list[Array](), list[Array]()
        self.lumps = [Lump(0.0, 1.0, start)]
        self.kernels, self._past = Kernels(births), Past(births, until)
        self.settled = self.widest = np.inf
        self._count, self._spare = 1, 0

    @property
    def life_error(self) -> float:
        """Error of the survival itself, to which the residuals of the panels are blind."""
        return self.life.error + self.kernels.error + self._past.error

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
        before = -1
        legs = self.motion.leg(0.5 * (self.edges[:-1] + self.edges[1:]))
        for begin, end, leg in zip(self.edges[:-1], self.edges[1:], legs.tolist(), strict=True):
            self._break_lumps(begin, end)
            if leg != before and (before >= 0 or self.widest == np.inf):
                moving = bool(self.motion.speeds[leg])
                self.widest = self._duration(self.grain, leg) if moving else 0.25 * (end - begin)
            before, late = leg, self.motion.times[leg]
            yield from self._segment(begin - late, end - late, leg)
            if self.unfinished:
                break

    def _duration(self, length: float, leg: int) -> float:
        """The time that the slider takes for a length; inf in a hold."""
        speed = abs(float(self.motion.speeds[leg]))
        return length / speed if speed else np.inf

    def _segment(self, begin: float, end: float, leg: int) -> Iterator[None]:
        """Solve from one edge to the next; both are times since the leg's beginning."""
        t, width, self._count, self._spare = begin, 0.0, 8, 0
        # halving stops here, beside a point that no panel resolves; heat may break contacts at any rate
        narrowest = min(self._duration(self.grain, leg), end - begin)
        narrowest *= 1e-10 if self.life.quick else 1e-18
        while end - t > 1e-9 * min(self.widest, end - begin):
            if clock.monotonic() > self.until:
                self.unfinished = True
                break
            if self._settled(leg, end - t):
                self._rest(t, end, leg)
                break
            left = max(1, int(np.ceil((end - t) / self.widest * (1.0 - 1e-9))))
            if abs((end - t) / left - width) > 1e-9 * width:
                width = (end - t) / left
            run = self._run(t, width, min(self._count, left), leg)
            bad = np.flatnonzero(run.wrong > self.tolerance)
            # beyond the allowed work, or on the narrowest panels, the error is accepted
            hurried = self.births.work > MOST_WORK or width < max(narrowest, ROUNDED * t)
            bad = bad[:0] if hurried else bad
            good = int(bad[0]) if bad.size else run.wrong.size
            self.keep(self.motion.times[leg] + t, width, run, good, t)
            t = t + good * width if good < left else end
            if bad.size:
                far = run.wrong[good] > 100.0 * self.tolerance
                self.widest, self._count, self._spare = (0.25 if far else 0.5) * width, 1, 0
            else:
                self._widen(width, run, left - good, hurried, leg)
                yield

    def _widen(self, width: float, run: Run, left: int, hurried: bool, leg: int) -> None:
        """Widen the next panels if the last ones, all good, have errors far below the tolerance.

        left : panels of this width that are still to be solved; hurried : widen whatever their error
        """
        grain = self._duration(self.grain, leg)
        # the error grows as the width to the power DEGREE; where contacts break at rates of all sizes,
        # and behind a point that no polynomial resolves, wider panels soon suffice
        sooner = not self.life.quick or width < 1e-2 * grain
        spare = max(self.tolerance * (1e-2 if sooner else 0.5**rule.DEGREE), 1e-14)
        self._spare = self._spare + run.wrong.size if run.wrong.max() < spare else 0
        # each width needs its own kernel: wide panels are widened only if that serves many
        still = np.abs(run.breaks[:, -1]).max() < 1e-3 * self.tolerance
        many = 0 if still or width <= 0.5 * grain else 32
        self._count = min(2 * self._count, 256)
        wider = self._spare > many and left >= many and width > 0.6 * self.widest
        if hurried or wider:
            self.widest = min(2.0 * width, self._duration(self.life.reach, leg))
            self._count, self._spare = 1 if sooner else max(1, self._count // 4), 0

    def _memory(self, leg: int) -> float:
        """The longest time from a break to the next one of the same contact."""
        return self.kernels.straight(float(self.motion.speeds[leg])).longest + self.births.delay

    def _settled(self, leg: int, left: float) -> bool:
        """Whether breaks have been steady for longer than any life, so that they stay so on this leg.

        The rate of breaks is a mean of the rates over the longest life before: where these agree
        to the tolerance, so do all that follow.
        """
        memory = 1.1 * self._memory(leg)
        since = max(float(self.motion.times[leg]), self.lumps[-1].time)
        if left < 8.0 * memory or not self.motion.speeds[leg] or self.reached - since < memory:
            return False
        first = max(bisect_right(self.begin, self.reached - memory) - 1, 0)
        rates = np.array(self.breaks[first:]) @ rule.SLOPES_AT_GAUSS.T
        rates = rates / np.array(self.width[first:])[:, None]
        alike = np.ptp(rates) < 0.25 * self.tolerance * rates.mean()
        return bool(alike and np.ptp(self.force[first:]) < 0.25 * self.tolerance * self.stretch)

    def _rest(self, t: float, end: float, leg: int) -> None:
        """One panel of steady breaks up to shortly before the end of the leg, then three more."""
        late, memory = float(self.motion.times[leg]), self._memory(leg)
        self.settled = min(self.settled, late + t - 0.5 * self.width[-1])
        breaks = self.breaks[-1][-1] / self.width[-1] * np.append(0.0, rule.NODES)[None]
        force = np.full(breaks.shape, self.force[-1].mean())
        wrong = np.full(1, self.wrong[-1] + 0.25 * self.tolerance)
        for first, second in pairwise(
            [t, end - 3.0 * memory, end - 2.0 * memory, end - memory, end]
        ):
            run = Run((second - first) * breaks, force, wrong)
            self.keep(late + first, second - first, run, 1, first)

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
        self.births.work += 100 * count  # about the cost of solving a panel, in pieces of integrals
        # the last panels of this width, of those whose births are felt
        first = bisect_right(self.begin, self.reached - self._memory(leg) - 2.0 * width)
        first = max(first, bisect_left(self.begin, self.motion.times[leg] - 1e-9 * width))
        other = np.flatnonzero(np.array(self.width[first:]) != width)
        same = len(self.width) - first - (int(other[-1]) + 1 if other.size else 0)
        kernel = self.kernels.on(float(self.motion.speeds[leg]), width, same + count)
        known = self.known(t + width * (np.arange(count)[:, None] + TARGETS), same, leg)
        return solve_run(kernel, known, self.breaks[len(self.breaks) - same :], self.stretch)

    def known(self, grid: Array, same: int = 0, leg: int | None = None) -> Array:
        """Number and force at later times, of lumps and of all panels but the last `same`.

        grid : array of shape (panels, TARGETS.size) of times, all on one leg; with `leg`, counted
            from its beginning
        """
        if leg is None:
            leg = self.motion.leg_of_all(grid)
            grid = grid - self.motion.times[leg]
        late, last = float(self.motion.times[leg]), len(self.begin) - same
        self._enter(leg)
        out, t, delay = self._past.at(grid, self.lumps), grid.ravel(), self.births.delay
        first = max(bisect_right(self.begin, late + t.min() - self._memory(leg)) - 1, 0)
        own = self._panels(max(first, self._past.first), last)
        out += self._on_leg(t, leg, own).reshape(out.shape)
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
        begin, since, width, breaks = panels
        if not begin.size:
            return np.zeros((2, t.size))
        late, speed = self.motion.times[leg], float(self.motion.speeds[leg])
        born = np.where(begin >= late, since, begin - late) + self.births.delay
        return self.kernels.sums(speed, t, np.append(born, born[-1] + width[-1]), breaks)

    def held(self, leg: int, t: float) -> float:
        """Share of all contacts that were born on a leg and hold at the time t."""
        panels, motion = self._panels(0, bisect_left(self.begin, t)), self.motion
        legs, now = motion.leg(panels.middle_of_births(self.births.delay)), int(motion.leg(t))
        panels = panels._replace(breaks=panels.breaks * (legs == leg)[:, None])
        past, x = Past(self.births, np.inf), np.array([[t - motion.times[now]]])
        past.enter(now, panels)
        own = self._on_leg(x[0], now, Panels(*(part[past.first :] for part in panels)))
        return float(past.sums(x)[0, 0, 0] + own[0, 0])

    def _enter(self, leg: int) -> None:
        """Find the births on all legs before one, unless they are found."""
        if leg != self._past.leg:
            self._past.enter(leg, self._panels(0))

    def _break_lumps(self, t: float, end: float) -> None:
        """Make a new lump of the contacts that reach an exact threshold, together, at the edge t."""
        if not t > 0.0 or not len(self.life.atoms):
            return
        self._enter(int(self.motion.leg(t)))
        sides = (t - 0.5 * self.width[-1], t + 0.5 * (end - t))
        rows = (np.array([[t, side, t]]) - self._past.late for side in sides)
        before, after = (self._past.at(row, self.lumps)[0, 0, 0] for row in rows)
        if before - after > LEAST_LUMP:
            self.lumps.append(Lump(t + self.births.delay, before - after, self.births.law))
