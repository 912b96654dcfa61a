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

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births
from origins.start import Start

Array = npt.NDArray[np.float64]


@dataclass
class Lump:
    """Contacts that were born, or stood at t = 0, at one moment."""

    time: float
    weight: float
    law: Start
    left: float = 1.0


class Run(NamedTuple):
    """Panels of one width, one after the other, as solved.

    breaks : array of shape (panels, DEGREE + 1), since each panel's beginning, at 0 and the nodes
    force : the same of the force
    wrong : array of shape (panels,), how far off the number of breaks may be on each
    """

    breaks: Array
    force: Array
    wrong: Array


class Kernel(NamedTuple):
    """What a panel adds to number and force on panels of its own width, by distance.

    number, force : arrays of shape (panels apart, targets, DEGREE + 1)
    solve : array of shape (DEGREE, DEGREE), from what is missing at the nodes to the breaks there
    """

    number: Array
    force: Array
    solve: Array


# Where on a panel number and force are asked for: at its beginning, the nodes, and between.
TARGETS: Array = np.concatenate([[0.0], rule.NODES, [rule.CHECK]])
# Panels whose breaks or survivors are fewer than this add nothing to what rounds at 1e-16.
NOTHING = 1e-18
# Width of the narrowest panel, in units of the life's grain, below which halving has met a point
# that no panel resolves.
NARROWEST = 1e-10
# Panels of a first run, and of the longest: a run that fails is solved in vain.
FIRST, LONGEST = 8, 256


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
        Time over which the number of breaks has to be resolved: the first guess of a panel's width.
    """

    def __init__(
        self, births: Births, start: Start, edges: Array, tolerance: float, grain: float
    ) -> None:
        self.births, self.edges, self.tolerance, self.grain = births, edges, tolerance, grain
        self.life, self.motion = births.life, births.motion
        self.begin: list[float] = []
        self.width: list[float] = []
        self.breaks: list[Array] = []
        self.force: list[Array] = []
        self.wrong: list[float] = []
        self.lumps = [Lump(0.0, 1.0, start)]
        self.alive: list[int] = []  # panels of whose births some may still hold
        self._kernels: dict[tuple[float, float], Kernel] = {}

    def run(self) -> March:
        """Solve all panels."""
        allowed = self.grain
        for begin, end in zip(self.edges[:-1], self.edges[1:], strict=True):
            self._break_lumps(begin, end)
            allowed = self._segment(begin, end, allowed)
        return self

    def _segment(self, begin: float, end: float, allowed: float) -> float:
        """Solve from one edge to the next; returns the width allowed for the next panels."""
        t, width, count, smooth = begin, 0.0, FIRST, 0
        while end - t > 1e-9 * allowed:
            left = max(1, int(np.ceil((end - t) / allowed * (1.0 - 1e-9))))
            if abs((end - t) / left - width) > 1e-9 * width:
                width = (end - t) / left
            run = self._run(t, width, min(count, left))
            bad = np.flatnonzero(run.wrong > self.tolerance)
            if bad.size and width < NARROWEST * self.grain:
                bad = bad[1:]  # no panel resolves this one: it stays, with its error
            good = int(bad[0]) if bad.size else run.wrong.size
            self._keep(t, width, run, good)
            t = end - (left - good) * width
            if bad.size:
                hopeless = run.wrong[bad[0]] > 100.0 * self.tolerance
                allowed, count, smooth = (0.25 if hopeless else 0.5) * width, 1, 0
                continue
            count = min(2 * count, LONGEST)
            needless = run.wrong.max() < max(self.tolerance * 0.5**rule.DEGREE, 1e-14)
            smooth = smooth + good if needless else 0
            # other widths need other kernels: beside the grain these must pay
            if smooth > (32 if width > 0.5 * self.grain else 0) and width > 0.6 * allowed:
                allowed, count, smooth = min(2.0 * width, self._widest()), max(1, count // 2), 0
        return allowed

    def _widest(self) -> float:
        return 16.0 * self.grain

    def _keep(self, t: float, width: float, run: Run, good: int) -> None:
        """Take over the first panels of a run, and forget panels of whose births none holds."""
        first = len(self.begin)
        self.begin.extend(t + width * np.arange(good))
        self.width.extend([width] * good)
        self.breaks.extend(run.breaks[:good])
        self.force.extend(run.force[:good])
        self.wrong.extend(run.wrong[:good])
        broken = np.abs(run.breaks[:good]).max(axis=1) > NOTHING
        self.alive.extend(first + np.flatnonzero(broken))

    def _run(self, t: float, width: float, count: int) -> Run:
        """Panels of one width from t on."""
        same = self._same(t, width)
        leg = int(self.motion.leg(t + 0.5 * width))
        kernel = self._kernel(leg, width, same + count)
        grid = t + width * (np.arange(count)[:, None] + TARGETS)
        number, force = self._known(grid, same)
        apart = min(kernel.number.shape[0], same + count)
        nodes = slice(1, rule.DEGREE + 1)
        size = rule.DEGREE + 1
        far = kernel.number[apart - 1 : 0 : -1, nodes]  # farthest first, as the panels stand
        far = np.ascontiguousarray(far.transpose(1, 0, 2).reshape(rule.DEGREE, -1))
        panels = np.zeros((same + count, size))
        if same:
            panels[:same] = self.breaks[-same:]
        flat = panels.reshape(-1)
        missing = 1.0 - number[:, nodes]
        for index in range(same, same + count):
            seen = min(index, apart - 1)
            lack = missing[index - same]
            if seen:
                past = flat[(index - seen) * size : index * size]
                lack = lack - far[:, (apart - 1 - seen) * size :] @ past
            panels[index, 1:] = kernel.solve @ lack
        # number and force at all targets, of all panels at once
        padded = np.concatenate([np.zeros((apart - 1, size)), panels[max(0, same - apart + 1) :]])
        skip = max(0, apart - 1 - same)
        windows = np.lib.stride_tricks.sliding_window_view(padded[skip * 0 :], (apart, size))[:, 0]
        windows = windows[-count:].reshape(count, -1)
        both = np.concatenate([kernel.number[:apart], kernel.force[:apart]], axis=1)[::-1]
        both = both.transpose(1, 0, 2).reshape(2 * TARGETS.size, -1)
        added = windows @ both.T
        number, force = number + added[:, : TARGETS.size], force + added[:, TARGETS.size :]
        force = force[:, :size]
        broken = panels[same:]
        wrong = np.abs(broken @ rule.TO_LEGENDRE[-1]) + np.abs(number[:, -1] - 1.0)
        wrong += np.abs(force @ rule.TO_LEGENDRE[-1]) / self.life.reach
        return Run(broken, force, wrong)

    def _same(self, t: float, width: float) -> int:
        """How many of the last panels have this width and lie on the leg that begins at t or before."""
        leg_begin = self.motion.times[int(self.motion.leg(t + 0.5 * width))]
        same = 0
        while same < len(self.width) and self.width[-1 - same] == width:
            if self.begin[-1 - same] < leg_begin - 1e-9 * width:
                break
            same += 1
        return same

    def _kernel(self, leg: int, width: float, panels: int) -> Kernel:
        """Kernels of panels on one leg, so many apart or until none of the births holds."""
        births, speed = self.births, float(self.motion.speeds[leg])
        lasting = self.life.reach + max(abs(end) for end in births.law.span)
        most = int(np.ceil((lasting / abs(speed) + births.delay) / width)) + 1 if speed else panels
        panels = min(panels, most)
        known = self._kernels.get((speed, width))
        have = known.number.shape[0] if known else 0
        if known and have >= panels:
            return known
        panels = min(most, max(panels, 2 * have))
        straight = Motion(np.array([0.0, panels * width]), np.array([0.0, panels * width * speed]))
        along = Births(births.life, births.law, straight, births.delay, births.accuracy)
        t = width * (np.arange(have, panels)[:, None] + TARGETS)
        found = along.blocks(t.ravel(), 0.0, width)
        number, force = found.reshape(2, panels - have, TARGETS.size, -1)
        if known:
            number = np.concatenate([known.number, number])
            force = np.concatenate([known.force, force])
        own = number[0, 1 : rule.DEGREE + 1, 1:]
        kernel = Kernel(number, force, known.solve if known else np.linalg.inv(own))
        self._kernels[speed, width] = kernel
        return kernel

    def _known(self, grid: Array, same: int) -> tuple[Array, Array]:
        """Number and force, on panels of times, of lumps and of panels but the last `same`."""
        number, force = np.zeros(grid.shape), np.zeros(grid.shape)
        now = float(grid[0, 0])
        for lump in self.lumps:
            high, low = self._furthest(now, lump.law, np.array([[lump.time]]))
            if lump.time < now and max(high[0], -low[0]) >= self.life.reach:
                continue
            here = grid[:, TARGETS.size // 2] > lump.time
            number[~here] += lump.weight
            if here.any():
                history = self.motion.history(grid[here], np.full((1, 1), lump.time))
                held, pull = self.life.left(lump.law, history)
                number[here] += lump.weight * held
                force[here] += lump.weight * pull
        last = len(self.begin) - same
        seen = [panel for panel in self.alive if panel < last]
        if seen:
            begin = np.array([self.begin[panel] for panel in seen])
            width = np.array([self.width[panel] for panel in seen])
            broken = np.array([self.breaks[panel] for panel in seen])
            s = np.stack([begin, begin + 0.5 * width, begin + width], axis=1)
            high, low = self._furthest(now, self.births.law, s + self.births.delay)
            held = np.maximum(high, -low) < self.life.reach
            held |= begin + width + self.births.delay > now
            if held.any():
                added = self.births.sums(grid.ravel(), begin[held], width[held], broken[held])
                number += added[0].reshape(grid.shape)
                force += added[1].reshape(grid.shape)
            if not held.all():
                dead = {panel for panel, kept in zip(seen, held, strict=True) if not kept}
                self.alive = [panel for panel in self.alive if panel not in dead]
        return number, force

    def _furthest(self, t: float, law: Start, s: Array) -> tuple[Array, Array]:
        """How far contacts born at s have been stretched at least by t, forward and backward.

        s has shape (n, columns); returns arrays of shape (n,), the least of each row.
        """
        first, last = law.span
        history = self.motion.history(np.full((1, 1), t), np.minimum(s, t))
        return first + history.high.min(axis=1), last + history.low.max(axis=1)

    def _break_lumps(self, t: float, end: float) -> None:
        """Make a new lump of what reaches an exact threshold at the edge t."""
        if not t > 0.0:
            return
        before = t - 0.5 * self.width[-1]
        after = t + 0.5 * (end - t)
        sides = [np.array([[t, before, t]]), np.array([[t, after, t]])]
        lost = 0.0
        for lump in self.lumps:
            if lump.time >= t:
                continue
            born = np.full((1, 1), lump.time)
            held = [
                self.life.left(lump.law, self.motion.history(at, born))[0, 0, 0] for at in sides
            ]
            lost += lump.weight * (held[0] - held[1])
            lump.left = held[1] * lump.weight
        self.lumps = [lump for lump in self.lumps if lump.left > NOTHING]
        if lost > 1e-15:
            lump = Lump(t + self.births.delay, lost, self.births.law)
            lump.left = lost
            self.lumps.append(lump)
