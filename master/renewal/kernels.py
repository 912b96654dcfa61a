"""Kernels: births on the present leg, whose survival depends only on the time since the birth.

So the survival is kept in a table, for each speed; the contribution of a panel to another one of its
width depends only on their distance, and is computed once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import NONE_LEFT, bends_of
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import Births, Pieces, Rows
from master.renewal.table import Table, beside

Array = npt.NDArray[np.float64]

# Shares of a panel at which number and force are evaluated: its beginning, the nodes, and between.
TARGETS: Array = np.concatenate([[0.0], rule.NODES, rule.CHECKS])
# Error of the survival, and of the force over the longest stretch, to which the table is refined.
ACCURACY = 1e-13
# Allowed error of polynomials at the ends of panels, over the accuracy: near a root it is larger there
# than inside.
ENDS = 100.0
# Halvings of the longest time, to resolve lives that are much shorter.
RUNGS = 64
# The narrowest panel of the table over its length; with heat lives may be far shorter.
SHORTEST, SHORTEST_IN_HEAT = 1e-12, 1e-20
# Relative distance of two times of the table that count as equal.
TIE = 1e-11


class Straight:
    """E and K over the time since birth, of contacts that have moved at one speed since.

    They are kept in a table, unless the life itself is as quick.

    Attributes
    ----------
    asked : float
        The longest time that was asked for: that of a leg, or one after which no contact holds.
    longest : float
        The same, or an earlier time after which heat has broken all contacts.
    edges : array of shape (n,)
        Times between which E and K are polynomials, or nearly so.
    error : float
        Of the share that holds.
    """

    def __init__(self, births: Births, speed: float, longest: float) -> None:
        """Tabulate the survival up to the lag `longest`."""
        life, law = births.life, births.law
        motion = Motion(np.array([0.0, longest]), np.array([0.0, longest * speed]))
        most = min(max(abs(end) for end in law.span) + abs(speed) * longest, life.reach)
        self.scale = most or life.reach

        def found(lag: Array) -> Array:
            births.work += births.dear * lag.shape[0]
            left = life.left(law, motion.history(lag, np.zeros((1, 1))))
            left[1] /= self.scale
            return left

        self.asked, ladder = longest, np.empty(0)
        if not life.quick:
            ladder = longest * 0.5 ** np.arange(RUNGS, -1.0, -1.0)
            left = found(ladder[:, None])[0, :, 0]
            ladder, left = ladder[1.0 - left > ACCURACY], left[1.0 - left > ACCURACY]
            dead = np.flatnonzero(left < NONE_LEFT)
            if dead.size:
                longest, ladder = float(ladder[dead[0]]), ladder[: dead[0]]
        self.longest = longest
        moving = bends_of(life, law, speed)
        bends = moving[moving < longest * (1.0 - TIE)]
        self._bounds = np.concatenate([[0.0], bends, [longest]])
        self._life, self.missed = life, 0.0
        self._read: Callable[[Array], Array] = found
        if life.quick and law.is_single:
            smooth = bends_of(life, law, speed, life.marks)
            edges = np.concatenate([self._bounds, smooth[smooth < longest * (1.0 - TIE)]])
            self.edges = np.unique(edges)
            return
        edges = np.unique(np.concatenate([self._bounds, ladder]))
        shortest = (SHORTEST if life.quick else SHORTEST_IN_HEAT) * longest
        accuracy = ACCURACY if life.quick else max(ACCURACY, 0.1 * births.accuracy)
        table = Table(found, edges, accuracy, shortest, ends=0.0 if life.quick else ENDS)
        self._read, self.edges, self.missed = table, table.edges, table.error

    @property
    def error(self) -> float:
        """See above."""
        return self._life.error + self.missed

    def left(self, lag: Array) -> Array:
        """Share and force at times since birth, shape (rows, columns); each row is smooth.

        The middle column decides on which side of an exact threshold a row is.
        """
        found = self._read(beside(lag, self._bounds))
        found[1] *= self.scale
        return found


class Kernel(NamedTuple):
    """Contributions of a panel to number and force on panels of its own width, by distance.

    number, force : arrays of shape (panels apart, targets, DEGREE + 1)
    solve : array of shape (DEGREE, DEGREE), matrix from 1 - number at the nodes to the breaks there
    """

    number: Array
    force: Array
    solve: Array


class Moments(NamedTuple):
    """Integrals over pieces of panels of share and force times Legendre polynomials of the panel.

    target, panel : arrays of shape (pieces,)
    values : array of shape (2, pieces, DEGREE + 1)
    """

    target: Rows
    panel: Rows
    values: Array

    def by_target(self, targets: int) -> Array:
        """Sums over the pieces of each target, shape (2, targets, DEGREE + 1)."""
        out = np.zeros((2, targets, rule.DEGREE + 1))
        some, first = np.unique(self.target, return_index=True)
        if some.size:
            out[:, some] = np.add.reduceat(self.values, first, axis=1)
        return out


class Kernels:
    """Kernels and sums for the legs of a motion, each table computed when it is first needed."""

    def __init__(self, births: Births) -> None:
        self._births, self._motion = births, births.motion
        self._known: dict[tuple[float, float], Kernel] = {}
        self._straight: dict[float, Straight] = {}
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
    def error(self) -> float:
        """Largest error of the survivals in the tables."""
        return max((straight.error for straight in self._straight.values()), default=0.0)

    def straight(self, leg: int) -> Straight:
        """The table of survival and force of contacts born on a leg."""
        births, speed = self._births, float(self._motion.speeds[leg])
        lasting = births.life.reach + max(abs(end) for end in births.law.span)
        longest = min(self._lasting[speed], lasting / abs(speed) if speed else np.inf)
        if speed not in self._straight or self._straight[speed].asked < longest:
            self._straight[speed] = Straight(births, speed, longest)
        return self._straight[speed]

    def on(self, leg: int, width: float, panels: int) -> Kernel:
        """Kernel for panels at most `panels` apart, or fewer where all births break before."""
        speed, delay = float(self._motion.speeds[leg]), self._births.delay
        most = int(np.ceil((self.straight(leg).longest + delay) / width)) + 1
        panels = min(panels, most)
        known = self._known.get((speed, width))
        have = known.number.shape[0] if known else 0
        if known and have >= panels:
            return known
        panels = min(most, max(panels, 2 * have))
        t = (width * (np.arange(have, panels)[:, None] + TARGETS)).ravel()
        found = self._moments(leg, t, np.array([delay, delay + width])).by_target(t.size)
        found = found @ rule.SLOPES
        share = np.clip(np.stack([t, t - delay]) / width, 0.0, 1.0)
        found[0] += rule.values(share[0]) - rule.values(share[1])
        number, force = found.reshape(2, panels - have, TARGETS.size, -1)
        if known:
            number = np.concatenate([known.number, number])
            force = np.concatenate([known.force, force])
        solve = known.solve if known else _inverse(number[0, 1 : rule.DEGREE + 1, 1:])
        kernel = Kernel(number, force, solve)
        self._known[speed, width] = kernel
        return kernel

    def sums(self, leg: int, t: Array, ends: Array, breaks: Array) -> Array:
        """Number and force at times t, shape (n,), of births on a leg; shape (2, n).

        ends : array of shape (panels + 1,), times at which panels of births end; breaks : on these
        """
        found = self._moments(leg, t, ends)
        slopes = (breaks @ rule.SLOPES.T)[found.panel]
        parts = np.einsum("jpk,pk->jp", found.values, slopes)
        return np.stack([np.bincount(found.target, part, t.size) for part in parts])

    def _moments(self, leg: int, t: Array, ends: Array) -> Moments:
        """Integrals over the births on panels of a leg, exact for the polynomials of the table."""
        straight = self.straight(leg)
        begin, end = np.maximum(ends[0], t - straight.longest), np.minimum(ends[-1], t)
        begin = np.minimum(begin, end)[:, None]
        first, last = np.searchsorted(ends, [begin.min(), end.max()])
        cuts = np.concatenate(
            [
                np.tile(ends[first:last], (t.size, 1)),
                begin,
                end[:, None],
                t[:, None] - straight.edges,
            ],
            axis=1,
        )
        pieces = Pieces.of(np.clip(cuts, begin, end[:, None]))
        length = (pieces.right - pieces.left)[:, None]
        panel = np.searchsorted(ends, 0.5 * (pieces.left + pieces.right)) - 1
        place = pieces.left[:, None] + length * rule.GAUSS_NODES
        self._births.work += place.shape[0]
        held = straight.left(t[pieces.target, None] - place)
        width = np.diff(ends)[panel, None]
        held *= length / width * rule.GAUSS_WEIGHTS
        basis = rule.legendre_values((place - ends[panel, None]) / width)
        values = held.transpose(1, 0, 2) @ basis
        return Moments(pieces.target, panel, values.transpose(1, 0, 2))


def _inverse(number: Array) -> Array:
    """The inverse of a matrix; nan where it has none, as on a panel far wider than a life."""
    try:
        return np.asarray(np.linalg.inv(number), dtype=float)
    except np.linalg.LinAlgError:
        return np.full(number.shape, np.nan)
