"""Kernels: what a panel adds to number and force on later panels of the same leg and width."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.straight import StraightLife, clock
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births
from origins.start import SingleStart

Array = npt.NDArray[np.float64]

# Where on a panel number and force are asked for: at its beginning, the nodes, and between.
TARGETS: Array = np.concatenate([[0.0], rule.NODES, rule.CHECKS])


class Kernel(NamedTuple):
    """What a panel adds to number and force on panels of its own width, by distance.

    number, force : arrays of shape (panels apart, targets, DEGREE + 1)
    solve : array of shape (DEGREE, DEGREE), from what is missing at the nodes to the breaks there
    """

    number: Array
    force: Array
    solve: Array


class Kernels:
    """Kernels for the legs of a motion, each computed when it is first asked for.

    Within one leg what is left of contacts depends on the time since their birth alone, so that a
    kernel depends on the width of the panels and their distance.
    """

    def __init__(self, births: Births) -> None:
        self._births, self._motion = births, births.motion
        self._known: dict[tuple[float, float], Kernel] = {}
        self._straight: dict[tuple[float, float], StraightLife] = {}

    def along(self, births: Births) -> Kernels:
        """Kernels for births of the same contacts along another motion; what is known is shared."""
        other = Kernels(births)
        other._known, other._straight = self._known, self._straight
        return other

    @property
    def errors(self) -> list[float]:
        """Errors of the tables that kernels were computed from."""
        return [straight.error for straight in self._straight.values()]

    def longest(self, leg: int) -> float:
        """The longest time for which contacts born on a leg may be seen on it."""
        speed = float(self._motion.speeds[leg])
        duration = float(np.diff(self._motion.times)[leg])
        lasting = self._births.life.reach + max(abs(end) for end in self._births.law.span)
        return min(duration, lasting / abs(speed)) if speed else duration

    def widths(self, leg: int) -> Array:
        """Widths of panels for which there is a kernel on a leg."""
        speed = float(self._motion.speeds[leg])
        return np.array([width for known, width in self._known if known == speed])

    def on(self, leg: int, width: float, panels: int) -> Kernel:
        """Kernel of panels so many apart, or until none of the births holds."""
        speed, delay = float(self._motion.speeds[leg]), self._births.delay
        most = int(np.ceil((self.longest(leg) + delay) / width)) + 1
        panels = min(panels, most)
        known = self._known.get((speed, width))
        have = known.number.shape[0] if known else 0
        if known and have >= panels:
            return known
        panels = min(most, max(panels, 2 * have))
        t = width * (np.arange(have, panels)[:, None] + TARGETS)
        found = self._along(leg, panels * width).blocks(t.ravel(), 0.0, width)
        number, force = found.reshape(2, panels - have, TARGETS.size, -1)
        if known:
            number = np.concatenate([known.number, number])
            force = np.concatenate([known.force, force])
        solve = known.solve if known else np.linalg.inv(number[0, 1 : rule.DEGREE + 1, 1:])
        kernel = Kernel(number, force, np.asarray(solve, dtype=float))
        self._known[speed, width] = kernel
        return kernel

    def _along(self, leg: int, duration: float) -> Births:
        """Births on a leg that goes on: from a table, unless what is left is as quickly told."""
        births, speed = self._births, float(self._motion.speeds[leg])
        if births.life.quick and births.law.is_single:
            straight = Motion(np.array([0.0, duration]), np.array([0.0, duration * speed]))
            return Births(births.life, births.law, straight, births.delay, births.accuracy)
        key = speed, self.longest(leg)
        if key not in self._straight:
            self._straight[key] = StraightLife(births.life, births.law, *key)
        relaxed = SingleStart(0.0)
        return Births(self._straight[key], relaxed, clock(duration), births.delay, births.accuracy)
