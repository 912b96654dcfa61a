"""Kernels: contributions of a panel to number and force on later panels of its leg and width."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.straight import ACCURACY, StraightLife, clock
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births
from master.renewal.edges import UNFELT
from origins.start import SingleStart

Array = npt.NDArray[np.float64]

# Shares of a panel at which number and force are evaluated: its beginning, the nodes, and between.
TARGETS: Array = np.concatenate([[0.0], rule.NODES, rule.CHECKS])


class Kernel(NamedTuple):
    """Contributions of a panel to number and force on panels of its own width, by distance.

    number, force : arrays of shape (panels apart, targets, DEGREE + 1)
    solve : array of shape (DEGREE, DEGREE), matrix from 1 - number at the nodes to the breaks there
    """

    number: Array
    force: Array
    solve: Array


class Kernels:
    """Kernels for the legs of a motion, each computed when it is first needed.

    Within one leg the survival depends only on the time since birth, so that a kernel depends on
    the width of the panels and their distance.
    """

    def __init__(self, births: Births) -> None:
        self._births, self._motion = births, births.motion
        self._known: dict[tuple[float, float], Kernel] = {}
        self._straight: dict[float, StraightLife] = {}
        # the duration of the longest leg of each speed
        self._lasting: dict[float, float] = {}
        for speed, duration in zip(births.motion.speeds, np.diff(births.motion.times), strict=True):
            self._lasting[speed] = max(float(duration), self._lasting.get(speed, 0.0))

    def along(self, births: Births) -> Kernels:
        """Kernels for births of the same contacts along another motion, sharing those computed."""
        other = Kernels(births)
        other._known, other._straight = self._known, self._straight
        return other

    @property
    def errors(self) -> list[float]:
        """Errors of the tables that kernels were computed from."""
        return [straight.error for straight in self._straight.values()]

    def longest(self, leg: int) -> float:
        """The longest time for which contacts born on a leg may hold while it lasts."""
        duration = float(np.diff(self._motion.times)[leg])
        longest = min(duration, self._reaching(leg))
        return longest if self._births.life.quick else min(longest, self.straight(leg).longest)

    def _reaching(self, leg: int) -> float:
        """The time after which contacts born on a leg are stretched beyond reach."""
        speed = abs(float(self._motion.speeds[leg]))
        lasting = self._births.life.reach + max(abs(end) for end in self._births.law.span)
        return lasting / speed if speed else np.inf

    def straight(self, leg: int) -> StraightLife:
        """The table of survival and force of contacts born on a leg."""
        births, speed = self._births, float(self._motion.speeds[leg])
        longest = min(self._lasting[speed], self._reaching(leg))
        if speed not in self._straight or self._straight[speed].asked < longest:
            accuracy = ACCURACY if births.life.quick else max(ACCURACY, 0.1 * births.accuracy)
            life = StraightLife(births.life, births.law, speed, longest, accuracy)
            self._straight[speed] = life
        return self._straight[speed]

    def known_width(self, leg: int, width: float, unfelt: float) -> float:
        """This width, or one with a known kernel that differs from it negligibly.

        Distances between edges that are sums of the same bends are equal apart from rounding.

        unfelt : largest negligible difference, a length
        """
        speed = float(self._motion.speeds[leg])
        slack = min(unfelt / abs(speed) if speed else 0.0, UNFELT * width)
        known = [other for with_speed, other in self._known if with_speed == speed]
        nearest = min(known, key=lambda other: abs(other - width), default=width)
        return nearest if abs(nearest - width) <= slack else width

    def on(self, leg: int, width: float, panels: int) -> Kernel:
        """Kernel for panels at most `panels` apart, or fewer where all births break before."""
        speed, delay = float(self._motion.speeds[leg]), self._births.delay
        most = int(np.ceil((self.longest(leg) + delay) / width)) + 1
        panels = min(panels, most)
        known = self._known.get((speed, width))
        have = known.number.shape[0] if known else 0
        if known and have >= panels:
            return known
        panels = min(most, max(panels, 2 * have))
        t = width * (np.arange(have, panels)[:, None] + TARGETS)
        found = self.on_leg(leg, panels * width).blocks(t.ravel(), 0.0, width)
        number, force = found.reshape(2, panels - have, TARGETS.size, -1)
        if known:
            number = np.concatenate([known.number, number])
            force = np.concatenate([known.force, force])
        solve = known.solve if known else _inverse(number[0, 1 : rule.DEGREE + 1, 1:])
        kernel = Kernel(number, force, solve)
        self._known[speed, width] = kernel
        return kernel

    def on_leg(self, leg: int, duration: float) -> Births:
        """Births on a leg that continues: from a table, unless the life itself is as quick."""
        births, speed = self._births, float(self._motion.speeds[leg])
        if births.life.quick and births.law.is_single:
            straight = Motion(np.array([0.0, duration]), np.array([0.0, duration * speed]))
            return Births(births.life, births.law, straight, births.delay, births.accuracy)
        relaxed = SingleStart(0.0)
        return Births(self.straight(leg), relaxed, clock(duration), births.delay, births.accuracy)


def _inverse(number: Array) -> Array:
    """The inverse of a matrix; nan where it has none, as on a panel far wider than a life."""
    try:
        return np.asarray(np.linalg.inv(number), dtype=float)
    except np.linalg.LinAlgError:
        return np.full(number.shape, np.nan)
