"""March: number conservation solved panel after panel, along any motion of a rigid slider.

With B(t) the breaks per contact since t = 0, at every t

    1 = G_0(t) + integral over s of E(t, s) dB(s),      F(t) = M_0(t) + integral of K(t, s) dB(s),

where E counts a contact that is out as one that is there, and bears nothing (see births). G_0 and
M_0 belong to lumps: the contacts that hold at t = 0, and all that break at one moment because they
reached one exact threshold together. On a panel B is a polynomial; its values at the Radau nodes
follow from conservation there, given all panels before. Within one leg of the motion what a panel
adds to a later one depends on their distance alone, so that a run of equal panels needs one small
matrix product a panel. A panel that does not resolve B is halved there and then.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.births import Births
from master.renewal.edges import LEAST_LUMP, UNFELT
from master.renewal.kernels import TARGETS, Kernels
from origins.start import Start

Array = npt.NDArray[np.float64]

# Panels whose breaks or survivors are fewer than this add nothing to what rounds at 1e-16.
NOTHING = 1e-18
# Width of the narrowest panel, in units of the life's grain, below which halving has met a point
# that no panel resolves.
NARROWEST = 1e-10
# Width of a panel, in units of its time, that rounding spoils.
ROUNDED = 1e-13
# Panels of a first run, and of the longest: a run that fails is solved in vain.
FIRST, LONGEST = 8, 256
# Panels narrower than half a grain are doubled at once where they resolve more than is asked;
# wider ones after so many, since other widths need other kernels.
PATIENCE = 32
# Segments longer than so many of the last panels are tried on wide panels first.
LONG = 1000.0
# Panels, as seen from later targets, that are integrated one by one before halving ends: some 10 s.
MOST_WORK = 6_000_000
# What solving a panel costs beside, in such pieces.
RUN_WORK = 100
# What conservation and force miss between the nodes, times this, bounds the error of a panel: it
# is looked for at a few points, and the largest in between is up to twice as large.
MARGIN = 2.0


@dataclass
class Lump:
    """Contacts that were born, or stood at t = 0, at one moment.

    time : of the birth; weight : share of all contacts; law : of the stretches at birth
    holds : whether any of them is left
    """

    time: float
    weight: float
    law: Start
    holds: bool = True


class Run(NamedTuple):
    """Panels of one width, one after the other, as solved.

    breaks : array of shape (panels, DEGREE + 1), since each panel's beginning, at 0 and the nodes
    force : the same of the force
    wrong : array of shape (panels,), bound on the error of the number of breaks, and of the force
        over the longest stretch, on each
    """

    breaks: Array
    force: Array
    wrong: Array


class March:
    """Breaks and force on panels, found one run after the other.

    Parameters
    ----------
    births : Births
        What the births of a panel add later on.
    start : Start
        The stretches at t = 0.
    edges : array of shape (n,)
        Times, sorted, at which the number of breaks may bend or jump; the first is 0.
    tolerance : float
        Largest error of the number of breaks on a panel.
    grain : float
        Length over which the number of breaks has to be resolved: the first guess of a panel.
    stretch : float
        The longest |x| that a contact may have: what an error of the number weighs in the force.
    until : float
        Reading of time.monotonic() at which to stop with what there is.

    Attributes
    ----------
    begin, width, breaks, force, wrong : lists, one entry a panel
    lumps : list of Lump
    alive : list of int
        Panels of whose births some may still hold.
    kernels : Kernels
    allowed : float
        Width allowed for the next panels.
    settled : float
        Time from which on breaks were steady; inf where they never were.
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
        self.births, self.edges, self.tolerance, self.grain = births, edges, tolerance, grain
        self.life, self.motion = births.life, births.motion
        self.stretch, self.until, self.unfinished = stretch, until, False
        self.settled = np.inf
        self.begin: list[float] = []
        self.width: list[float] = []
        self.breaks: list[Array] = []
        self.force: list[Array] = []
        self.wrong: list[float] = []
        self.lumps = [Lump(0.0, 1.0, start)]
        self.alive: list[int] = []
        self.kernels, self.allowed = Kernels(births), np.inf

    @property
    def life_error(self) -> float:
        """Error of what is left of contacts, which no panel sees."""
        return max([self.life.error, *self.kernels.errors])

    @property
    def reached(self) -> float:
        """The time up to which the march has come."""
        return float(self.begin[-1] + self.width[-1]) if self.begin else 0.0

    def run(self) -> March:
        """Solve all panels."""
        for _ in self.runs():
            pass
        return self

    def runs(self) -> Iterator[None]:
        """Solve all panels, and stop to be asked for more after each run of them."""
        leg = -1
        for begin, end in zip(self.edges[:-1], self.edges[1:], strict=True):
            self._break_lumps(begin, end)
            now = int(self.motion.leg(0.5 * (begin + end)))
            if now != leg and (leg >= 0 or self.allowed == np.inf):
                speed = abs(float(self.motion.speeds[now]))
                self.allowed = self.grain / speed if speed else 0.25 * (end - begin)
            leg = now
            yield from self._segment(begin, end, leg)
            if self.unfinished:
                break

    def _segment(self, begin: float, end: float, leg: int) -> Iterator[None]:
        """Solve from one edge to the next."""
        allowed = self.allowed
        speed = abs(float(self.motion.speeds[leg]))
        if speed and end - begin > LONG * allowed:
            # after a narrow feature: to find the width from above takes fewer panels
            allowed = min(0.25 * (end - begin), self.life.reach / speed)
        t, width, count, smooth = begin, 0.0, FIRST, 0
        narrowest = NARROWEST * (self.grain / speed if speed else end - begin)
        narrowest = max(narrowest, ROUNDED * end)
        while end - t > 1e-9 * min(allowed, end - begin):
            if clock.monotonic() > self.until:
                self.unfinished = True
                break
            if self._settled(leg, end - t):
                self._rest(t, end, leg)
                break
            left = max(1, int(np.ceil((end - t) / allowed * (1.0 - 1e-9))))
            if abs((end - t) / left - width) > 1e-9 * width:
                width = self._known_width((end - t) / left, left, leg)
            run = self._run(t, width, min(count, left), leg)
            bad = np.flatnonzero(run.wrong > self.tolerance)
            if self.births.work > MOST_WORK:
                bad = bad[:0]  # what is not resolved by now stays, with its error
            elif bad.size and width < narrowest:
                bad = bad[bad > 0]  # no panel resolves this one: it stays, with its error
            good = int(bad[0]) if bad.size else run.wrong.size
            self.keep(t, width, run, good)
            t = t + good * width if good < left else end
            if bad.size:
                hopeless = run.wrong[bad[0]] > 100.0 * self.tolerance
                allowed, count, smooth = (0.25 if hopeless else 0.5) * width, 1, 0
                self.allowed = allowed
                continue
            count = min(2 * count, LONGEST)
            needless = run.wrong.max() < max(self.tolerance * 0.5**rule.DEGREE, 1e-14)
            smooth = smooth + good if needless else 0
            still = np.abs(run.breaks[:, -1]).max() < 1e-3 * self.tolerance
            patience = 0 if still or width * speed <= 0.5 * self.grain else PATIENCE
            if self.births.work > MOST_WORK or (smooth > patience and width > 0.6 * allowed):
                allowed, count, smooth = 2.0 * width, max(1, count // 2), 0
                if speed:
                    allowed = min(allowed, self.life.reach / speed)
            self.allowed = allowed
            yield

    def _known_width(self, width: float, panels: int, leg: int) -> float:
        """This width, or one of this leg that differs by what is not felt: its kernel is known.

        Edges that are sums of the same bends lie at equal distances, but for rounding.
        """
        speed = abs(float(self.motion.speeds[leg]))
        slack = UNFELT * self.tolerance * (self.grain / speed if speed else 0.0) / panels
        known = self.kernels.widths(leg)
        if known.size:
            nearest = float(known[np.abs(known - width).argmin()])
            if abs(nearest - width) <= min(slack, UNFELT * width):
                return nearest
        return width

    def _settled(self, leg: int, left: float) -> bool:
        """Whether all that may be felt has broken at one rate, so that the rest of a leg will too.

        The rate of breaks is a mean of the rates over the longest life before: where these were
        the same to the tolerance, so are all that follow.
        """
        memory = self.kernels.longest(leg) + self.births.delay
        if left < 8.0 * memory or not self.begin or not self.motion.speeds[leg]:
            return False
        gone = self.begin[-1] + self.width[-1] - max(self.motion.times[leg], self.lumps[-1].time)
        if gone < 1.1 * memory:
            return False
        first, width = len(self.begin), 0.0
        while width < 1.1 * memory:
            first -= 1
            width += self.width[first]
        widths = np.array(self.width[first:])
        rates = np.array(self.breaks[first:]) @ rule.SLOPES_AT_GAUSS.T / widths[:, None]
        force = np.array(self.force[first:])
        alike = np.ptp(rates) < 0.25 * self.tolerance * rates.mean()
        return bool(alike and np.ptp(force) < 0.25 * self.tolerance * self.stretch)

    def _rest(self, t: float, end: float, leg: int) -> None:
        """One panel of steady breaks up to shortly before the end of the leg, then three more."""
        self.settled = min(self.settled, t - 0.5 * self.width[-1])
        memory = self.kernels.longest(leg) + self.births.delay
        rate = self.breaks[-1][-1] / self.width[-1]
        share = np.append(0.0, rule.NODES)
        last = np.full(share.size, self.force[-1].mean())
        wrong = np.full(1, self.wrong[-1] + 0.25 * self.tolerance)
        ends = [t, end - 3.0 * memory, end - 2.0 * memory, end - memory, end]
        for first, second in pairwise(ends):
            breaks = rate * (second - first) * share
            self.keep(first, second - first, Run(breaks[None], last[None], wrong), 1)

    def keep(self, t: float, width: float, run: Run, good: int) -> None:
        """Take over the first panels of a run, and note those of whose births some may hold."""
        first = len(self.begin)
        self.begin.extend(t + width * np.arange(good))
        self.width.extend([width] * good)
        self.breaks.extend(run.breaks[:good])
        self.force.extend(run.force[:good])
        self.wrong.extend(run.wrong[:good])
        broken = np.abs(run.breaks[:good]).max(axis=1) > NOTHING
        self.alive.extend(first + np.flatnonzero(broken))

    def _run(self, t: float, width: float, count: int, leg: int) -> Run:
        """Panels of one width from t on."""
        self.births.work += RUN_WORK * count
        same = self._same(width, leg)
        kernel = self.kernels.on(leg, width, same + count)
        grid = t + width * (np.arange(count)[:, None] + TARGETS)
        number, force = self.known(grid, same)
        apart = min(kernel.number.shape[0], same + count)
        size, nodes = rule.DEGREE + 1, slice(1, rule.DEGREE + 1)
        # farthest panels first, as they stand
        far = kernel.number[apart - 1 : 0 : -1, nodes].transpose(1, 0, 2)
        far = np.ascontiguousarray(far.reshape(rule.DEGREE, -1))
        panels = np.zeros((apart - 1 + count, size))
        kept = min(same, apart - 1)
        if kept:
            panels[apart - 1 - kept : apart - 1] = self.breaks[-kept:]
        flat, missing = panels.reshape(-1), 1.0 - number[:, nodes]
        for panel in range(count):
            past = flat[panel * size : (panel + apart - 1) * size]
            panels[panel + apart - 1, 1:] = kernel.solve @ (missing[panel] - far @ past)
        # number and force at all targets, of all panels at once
        windows = np.lib.stride_tricks.sliding_window_view(panels, (apart, size))
        both = np.concatenate([kernel.number[:apart], kernel.force[:apart]], axis=1)[::-1]
        both = both.transpose(1, 0, 2).reshape(2 * TARGETS.size, -1)
        added = windows.reshape(count, -1) @ both.T
        number, force = number + added[:, : TARGETS.size], force + added[:, TARGETS.size :]
        lost = np.abs(number[:, size:] - 1.0).max(axis=1)
        bent = np.abs(force[:, :size] @ rule.AT_CHECKS.T - force[:, size:]).max(axis=1)
        wrong = MARGIN * (lost + bent / self.stretch)
        return Run(panels[apart - 1 :], force[:, :size], wrong)

    def _same(self, width: float, leg: int) -> int:
        """How many of the last panels, all on this leg, have this width."""
        begin, same = self.motion.times[leg] - 1e-9 * width, 0
        while same < len(self.width) and self.width[-1 - same] == width:
            if self.begin[-1 - same] < begin:
                break
            same += 1
        return same

    def known(self, grid: Array, same: int = 0) -> tuple[Array, Array]:
        """Number and force at later times, of lumps and of all panels but the last `same`.

        grid : array of shape (panels, TARGETS.size), all on one leg; its middle column tells on
            which side of an exact threshold a row is
        """
        number, force, now = np.zeros(grid.shape), np.zeros(grid.shape), float(grid[0, 0])
        middle = grid[:, TARGETS.size // 2]
        for lump in self.lumps:
            if not lump.holds or self._gone(now, lump.law, np.array([[lump.time]]))[0]:
                continue
            out = middle < lump.time
            number[out] += lump.weight
            if not out.all():
                history = self.motion.history(grid[~out], np.full((1, 1), lump.time))
                held, pull = self.life.left(lump.law, history)
                number[~out] += lump.weight * held
                force[~out] += lump.weight * pull
        last = len(self.begin) - same
        seen = np.array([panel for panel in self.alive if panel < last], dtype=int)
        if seen.size:
            begin, width = np.array(self.begin)[seen], np.array(self.width)[seen]
            s = np.stack([begin, begin + 0.5 * width, begin + width], axis=1) + self.births.delay
            gone = self._gone(now, self.births.law, s)
            if gone.any():
                dead = set(seen[gone].tolist())
                self.alive = [panel for panel in self.alive if panel not in dead]
            whole = self.births.still_whole(grid, begin, width)
            breaks = np.array(self.breaks)[seen]
            for which, sums in (
                (whole, self.births.whole_sums),
                (~whole & ~gone, self.births.sums),
            ):
                if which.any():
                    added = sums(grid.ravel(), begin[which], width[which], breaks[which])
                    number += added[0].reshape(grid.shape)
                    force += added[1].reshape(grid.shape)
        return number, force

    def _gone(self, t: float, law: Start, s: Array) -> npt.NDArray[np.bool_]:
        """Whether contacts born at s, shape (n, columns), have all been stretched beyond reach by t.

        Those that are out at t are not gone.
        """
        first, last = law.span
        history = self.motion.history(np.full((1, 1), t), np.minimum(s, t))
        least = np.maximum(first + history.high.min(axis=1), -(last + history.low.max(axis=1)))
        return np.asarray((least >= self.life.reach) & (s.max(axis=1) < t))

    def _break_lumps(self, t: float, end: float) -> None:
        """Make a new lump of what reaches an exact threshold at the edge t."""
        if not t > 0.0 or not len(self.births.life.atoms):
            return
        before, after = t - 0.5 * self.width[-1], t + 0.5 * (end - t)
        lost = 0.0
        for lump in self.lumps:
            if not lump.holds or lump.time >= t:
                continue
            born = np.full((1, 1), lump.time)
            held = [
                float(self.life.left(lump.law, self.motion.history(at, born))[0, 0, 0])
                for at in (np.array([[t, before, t]]), np.array([[t, after, t]]))
            ]
            lost += lump.weight * (held[0] - held[1])
            lump.holds = lump.weight * held[1] > NOTHING
        if lost > LEAST_LUMP:
            self.lumps.append(Lump(t + self.births.delay, lost, self.births.law))
