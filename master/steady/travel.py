"""Travel: survival and force of contacts that move steadily forward, over the way since birth.

In steady sliding contacts are born at a constant rate, so that force and density follow from
integrals over the way, the slider's travel since a contact's birth (paper, Eqs. Q11a-Q11d):

    C = integral of E,      F_k/(N_c <k>) = (integral of K) / (C + v tau).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life
from master.lives.straight import bends_of
from master.motion.motion import Motion
from master.renewal.table import Table
from origins.errors import refuse
from origins.start import Start

Array = npt.NDArray[np.float64]

# Accuracy of tables of which only integrals are needed: of births at one stretch, and at many, where
# a survival takes some hundred times as long and is smoother.
ACCURACY, OF_MANY = 1e-9, 1e-8
# The coarsest accuracy, where E itself is known to no better.
COARSEST = 1e-7
# The finest accuracy for births at many stretches with heat: the quadrature rule of their average
# changes along the way, which makes steps of some 1e-12 that no panel resolves.
STEPPED = 1e-11
# Width of the narrowest panel, in units of the typical way from a birth to its break.
SHORTEST = 1e-13
# Ways that differ by less than this share count as equal.
SAME = 1e-14
# Allowed error of polynomials at the ends of their panels, in units of the accuracy: the check detects
# steps beyond the outermost nodes.
ENDS = 10.0
# Ratio of the ways at which the survival is sampled to find where contacts break; and how many ways
# are sampled together, from the longest down.
RATIO, TOGETHER = 4.0, 6
# In units of the life's reach: contacts that break within shorter ways are refused.
NEAREST = 1e-150
# Tails of the force kernel that fall nearly as slowly as 1/x are taken to fall as x^-(1 + this).
LEAST_FALL = 1e-2
# In units of the life's reach: not even the heaviest tail is followed further.
FURTHEST = 1e120
# Shares of contacts: UNBROKEN broken ones count as none; below FEW the error of the survival is
# relative instead of absolute; NONE is negligible in the integrals.
UNBROKEN, FEW, NONE = 1e-3, 1e-4, 1e-17
# An interval between two sampled ways in which more than the share MANY breaks is cut into PARTS: one
# evaluation at many ways takes less time than several at few.
MANY, PARTS = 0.05, 8
TOO_SLOW = "contacts break before they have moved a length that is a number; slide faster"


class Travel:
    """E and K of contacts born at some stretches, tabulated over the way, and their integrals.

    Parameters
    ----------
    life : Life
    born : Start
        The stretches at which contacts are born.
    velocity : float
        v > 0, length per time.
    accuracy : float, optional
        Last coefficients of E, and of K over `scale`, below which a panel is not halved: the error
        of integrals is then about its square.

    Attributes
    ----------
    life, born, accuracy
        As given.
    table : Table
        E and K/`scale` over the way (a length).
    atoms : array of shape (n,)
        Ways after which contacts reach exact thresholds together.
    grain : float
        Length over which E falls.
    longest : float
        The way after which the share that holds is negligible.
    typical : float
        A length: the way after which about half of the contacts have broken.
    scale : float
        A length: `typical`, or the longest stretch at birth where that is longer.
    far : float
        A length: the stretch of contacts at the end of the table.
    most : float
        A length: the largest value of |K|.
    length, length_error : float
        C, the integral of E, and its error; lengths.
    area, area_error : float
        The integral of K and its error; lengths squared.

    Raises InputError where contacts break within ways that underflow.
    """

    def __init__(
        self, life: Life, born: Start, velocity: float, accuracy: float | None = None
    ) -> None:
        if accuracy is None:
            accuracy = ACCURACY if born.is_single else OF_MANY
        if not (born.is_single or life.quick):
            accuracy = max(accuracy, STEPPED)
        self.life, self.born, self._velocity, self.accuracy = life, born, velocity, accuracy
        ways = self._ladder()
        # panels that follow E more closely than it is known would follow its rounding
        accuracy = max(accuracy, min(life.error, COARSEST))
        bends = velocity * bends_of(life, born, velocity)
        self.atoms: Array = life.atoms - born.mean() if born.is_single else np.empty(0)
        edges = np.concatenate([ways, bends])
        edges = np.unique(np.append(0.0, edges[(edges > 0.0) & (edges < ways[-1])]))
        # edges that are equal apart from rounding are merged
        later = np.append(edges[1:], ways[-1])
        edges = np.append(edges[later - edges > SAME * later], ways[-1])
        shortest = SHORTEST * min(self.typical, float(edges[1]))
        self.table = Table(self.scaled, edges, accuracy, shortest, ends=ENDS)
        held, borne = self.table(self.table.edges)
        self.most = float(np.abs(borne).max()) * self.scale
        lost = np.maximum(-np.diff(held), 0.0)
        self.grain = float(self.table.widths @ lost / lost.sum())
        length, area = self.table.integrals()
        length_off, area_off = self.table.missed()
        # the error of E itself, which is relative where few contacts hold
        weights = np.minimum(self.table(self.table.begin)[0] / FEW, 1.0) * self.table.widths
        self.longest = float(ways[-1])
        self.far = self.longest + born.span[0]
        beyond = self._beyond(ways[-2:])
        if isinstance(life, ThermalLife):
            few = np.array([life.few])
            alive = np.clip(self.table(few)[0] / life.FEW, 0.0, 1.0)
            beyond = beyond + alive * life.rounded_away() / np.array([1.0, self.scale])
        length_off += life.error * weights.sum() + abs(beyond[0])
        area_off += life.error * float(weights @ self.table.end) / self.scale + abs(beyond[1])
        self.length, self.length_error = float(length), float(length_off)
        self.area, self.area_error = float(area) * self.scale, float(area_off) * self.scale

    def _beyond(self, ways: Array) -> Array:
        """Integrals of E and K beyond the last way, where both continue as powers; shape (2,).

        ways : array of shape (2,), the last two of the ladder
        """
        before, last = np.abs(self.scaled(ways[:, None])[:, :, 0]).T
        fall = np.full(2, 2.0)
        held = last > 0.0
        fall[held] = np.log(before[held] / last[held]) / np.log(ways[1] / ways[0])
        return np.asarray(last * ways[1] / np.clip(fall - 1.0, LEAST_FALL, 1.0))

    def left(self, way: Array) -> Array:
        """E and K after ways (lengths) of shape (rows, columns)."""
        far = float(way.max())
        motion = Motion(np.array([0.0, far / self._velocity]), np.array([0.0, far]))
        history = motion.history(way / self._velocity, np.zeros((1, 1)))
        return self.life.left(self.born, history)

    def scaled(self, way: Array) -> Array:
        """E and K over `scale` after ways (lengths) of shape (rows, columns)."""
        found = self.left(way)
        found[1] /= self.scale
        return found

    def _ladder(self) -> Array:
        """Ways from where nearly all contacts hold to where hardly any do, dense where many break.

        Sets `typical` and `scale`.
        """
        reach = self.life.reach + max(-2.0 * float(self.born.span[0]), 0.0)
        rungs, held = np.array([reach]), np.zeros(1)
        while held[0] < 1.0 - UNBROKEN and rungs[0] > NONE * float(held[1:] @ np.diff(rungs)):
            if rungs[0] < NEAREST * reach:
                refuse("velocity", self._velocity, TOO_SLOW)
            lower = rungs[0] * RATIO ** -np.arange(TOGETHER, 0.0, -1.0)
            rungs, held = np.append(lower, rungs), np.append(self._held(lower), held)
        self.typical = float(rungs[np.flatnonzero(held > 0.5 * held.max())[-1]])
        self.scale = max(self.typical, *(abs(end) for end in self.born.span))
        first = max(int(np.argmax(held < 1.0 - UNBROKEN)) - 1, 0)
        rungs, held = rungs[first:], held[first:]
        many = np.flatnonzero(-np.diff(held) > MANY * held.max())
        close = rungs[many, None] + np.diff(rungs)[many, None] * np.arange(1, PARTS) / PARTS
        last, left, further = reach, float(self._held(np.array([reach]))[0]), []
        while left * (last / self.typical) ** 2 > NONE and last < FURTHEST * reach:
            last *= 2.0
            left = float(self._held(np.array([last]))[0])
            further.append(last)
        return np.sort(np.concatenate([rungs, close.ravel(), further]))

    def _held(self, way: Array) -> Array:
        """E after ways (lengths) of shape (n,)."""
        return np.asarray(self.left(way[:, None])[0, :, 0])
