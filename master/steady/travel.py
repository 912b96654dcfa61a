"""Travel: survival and force of contacts that move steadily forward, over the way since birth.

In steady sliding contacts are born at a constant rate, so that force and density follow from
integrals over the way, the slider's travel since a contact's birth (paper, Eqs. Q11a-Q11d):

    C = integral of E,      F_k/(N_c <k>) = (integral of K) / (C + v tau).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.heat.thermal import ThermalLife
from master.lives.life import Life, bends_of
from master.motion.motion import Motion
from master.renewal.table import Table
from origins import Contacts, InputError
from origins.errors import refuse
from origins.start import Start

Array = npt.NDArray[np.float64]

# Accuracy of tables of which only integrals are needed: of births at one stretch, and at many, where
# a survival takes some hundred times as long and is smoother.
ACCURACY, OF_MANY = 1e-9, 1e-8
# The coarsest accuracy, where E itself is known to no better; and the finest for births at many
# stretches with heat: the quadrature rule of their average changes along the way, which makes steps
# of some 1e-12 that no panel resolves.
COARSEST, STEPPED = 1e-7, 1e-11
# Width of the narrowest panel, in units of the typical way from a birth to its break.
SHORTEST = 1e-13
# Ratio of the ways at which the survival is sampled to find where contacts break; and how many ways
# are sampled together, from the longest down.
RATIO, TOGETHER = 4.0, 6
# Shares of contacts: UNBROKEN broken ones count as none; below FEW the error of the survival is
# relative instead of absolute; NONE is negligible in the integrals.
UNBROKEN, FEW, NONE = 1e-3, 1e-4, 1e-17
# An interval between two sampled ways in which more than the share MANY breaks is cut into PARTS: one
# evaluation at many ways takes less time than several at few.
MANY, PARTS = 0.05, 8


class Travel:
    """E and K of contacts born at some stretches, tabulated over the way, and their integrals.

    Parameters
    ----------
    contacts : Contacts
    life : Life
        Theirs.
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
    most : float
        A length: the largest value of |K|.
    length, length_error : float
        C, the integral of E, and its error; lengths.
    area, area_error : float
        The integral of K and its error; lengths squared.

    Raises InputError where contacts break within ways that underflow.
    """

    def __init__(
        self,
        contacts: Contacts,
        life: Life,
        born: Start,
        velocity: float,
        accuracy: float | None = None,
    ) -> None:
        """Tabulate E and K over the way since a birth, and integrate them."""
        if accuracy is None:
            accuracy = ACCURACY if born.is_single else OF_MANY
        if not (born.is_single or life.quick):
            accuracy = max(accuracy, STEPPED)
        self.life, self.born, self._velocity, self.accuracy = life, born, velocity, accuracy
        ways = self._ladder()
        bends = velocity * bends_of(life, born, velocity)
        self.atoms: Array = life.atoms - born.mean() if born.is_single else np.empty(0)
        edges = np.concatenate([ways, bends])
        edges = np.unique(np.append(0.0, edges[(edges > 0.0) & (edges < ways[-1])]))
        # edges that are equal apart from rounding are merged
        later = np.append(edges[1:], ways[-1])
        edges = np.append(edges[later - edges > 1e-14 * later], ways[-1])
        # panels that follow E more closely than it is known would follow its rounding; steps beyond
        # their outermost nodes show at their ends
        accuracy = max(accuracy, min(life.error, COARSEST))
        shortest = SHORTEST * min(self.typical, float(edges[1]))
        self.table = Table(self.scaled, edges, accuracy, shortest, ends=10.0)
        held, borne = self.table(self.table.edges)
        self.most = float(np.abs(borne).max()) * self.scale
        lost = np.maximum(-np.diff(held), 0.0)
        self.grain = float(self.table.widths @ lost / lost.sum())
        self.longest = float(ways[-1])
        self.length, self.area = self.table.integrals().tolist()
        # the error of E itself is relative where few contacts hold
        weights = np.minimum(self.table(self.table.begin)[0] / FEW, 1.0) * self.table.widths
        own = life.error * np.array([weights.sum(), weights @ self.table.end / self.scale])
        off = self.table.missed() + own + np.abs(self._beyond(ways[-2:]))
        if isinstance(life, ThermalLife):
            alive = np.clip(self.table(np.array([life.few]))[0] / life.FEW, 0.0, 1.0)
            far = max(self.longest, float(contacts.thresholds.isf(1e-30)))
            lost = life.rounded_away() + thresholds_beyond(contacts, far)
            off += alive * lost / np.array([1.0, self.scale])
        self.length_error, self.area_error = off.tolist()
        self.area *= self.scale
        self.area_error *= self.scale
        if not {"grains", "thermal", "ageing", "reforming"}.intersection(contacts.laws):
            self._close(contacts)
        else:
            # relative round-off of integrals of the survival
            self.length_error += 1e-13 * self.length
            self.area_error += 1e-13 * abs(self.area)

    def _close(self, contacts: Contacts) -> None:
        """At T = 0 C and the area are closed moments: their differences to the integrals are the errors."""
        law, power = contacts.thresholds, power_of(contacts)
        length = law.mean()
        area = 0.5 * law.moment(power) / length ** (power - 2)
        self.length_error = abs(length - self.length) + 4e-16 * length
        self.area_error = abs(area - self.area) + 4e-16 * area
        self.length, self.area = length, area

    def force(self, wait: float) -> tuple[float, float]:
        """F_k/(N_c <k>) and its error (lengths), where contacts are out for the travel `wait`."""
        whole = self.length + wait
        force = self.area / whole
        return force, (self.area_error + abs(force) * self.length_error) / whole

    def _beyond(self, ways: Array) -> Array:
        """Integrals of E and K beyond the last way, where both continue as powers; shape (2,).

        ways : array of shape (2,), the last two of the ladder
        """
        before, last = np.abs(self.scaled(ways[:, None])[:, :, 0]).T
        fall = np.full(2, 2.0)
        held = last > 0.0
        fall[held] = np.log(before[held] / last[held]) / np.log(ways[1] / ways[0])
        # a tail that falls nearly as slowly as 1/x is taken to fall as x^-1.01
        return np.asarray(last * ways[1] / np.clip(fall - 1.0, 1e-2, 1.0))

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
            if rungs[0] < 1e-150 * reach:
                told = "contacts break before they have moved a length that is a number"
                refuse("velocity", self._velocity, f"{told}; slide faster")
            lower = rungs[0] * RATIO ** -np.arange(TOGETHER, 0.0, -1.0)
            rungs, held = np.append(lower, rungs), np.append(self._held(lower), held)
        self.typical = float(rungs[np.flatnonzero(held > 0.5 * held.max())[-1]])
        self.scale = max(self.typical, *(abs(end) for end in self.born.span))
        first = max(int(np.argmax(held < 1.0 - UNBROKEN)) - 1, 0)
        rungs, held = rungs[first:], held[first:]
        many = np.flatnonzero(-np.diff(held) > MANY * held.max())
        close = rungs[many, None] + np.diff(rungs)[many, None] * np.arange(1, PARTS) / PARTS
        last, left, further = reach, float(self._held(np.array([reach]))[0]), []
        # not even the heaviest tail is followed beyond 1e120 times the reach
        while left * (last / self.typical) ** 2 > NONE and last < 1e120 * reach:
            last *= 2.0
            left = float(self._held(np.array([last]))[0])
            further.append(last)
        return np.sort(np.concatenate([rungs, close.ravel(), further]))

    def _held(self, way: Array) -> Array:
        """E after ways (lengths) of shape (n,)."""
        return np.asarray(self.left(way[:, None])[0, :, 0])


def thresholds_beyond(contacts: Contacts, far: float) -> Array:
    """Bounds on the contributions of thresholds beyond `far` (a length), whose tail is taken as a
    power, to <x_b> and <k x_b^2>, lengths to the powers 1 and 2; shape (2,)."""
    law, stiff = contacts.thresholds, float(contacts.relative_stiffness(far))
    held, twice, power = float(law.sf(far)), float(law.sf(2.0 * far)), power_of(contacts)
    # a tail steeper than the power 1000 ends, or nearly so
    steep = min(float(np.log2(held / twice)), 1e3) if twice > 0.0 else 1e3
    if held > 0.0 and not steep > power:
        return np.full(2, np.inf)
    return held * far * np.array([1.0, stiff * far]) * steep / (steep - power)


def power_of(contacts: Contacts) -> int:
    """The order of the moment of the thresholds in the kinetic force."""
    return 3 if contacts.stiffness == "linked" else 2


def check_finite(contacts: Contacts) -> None:
    """Raise InputError where the kinetic force is infinite.

    Heat does not help, as strong contacts hardly break before their threshold. Thresholds that
    diffuse or grow are exempt: the tail of the initial ones does not last, or they have a largest.
    """
    if contacts.ageing is not None or contacts.grains is not None:
        return
    power = power_of(contacts)
    if not np.isfinite(contacts.thresholds.moment(power)):
        raise InputError(
            f"thresholds: <x_s^{power}> is infinite, and with it the kinetic force: the force "
            f"grows for ever; use a law whose tail falls faster than x^-{power + 1}"
        )
