"""Steady sliding of a slider with mass: long ways on which F is F_k of the present speed, without steps.

On the spring of a machine a slider creeps or slips by a million thresholds, too many for steps. But once its contacts
have forgotten their start, and while the speed V changes by little on the few thresholds that they live, F is F_k(V),
and with u = ln V, S the spring's force along the motion and v the drive's speed

    M V u' = S - γ V - F_k(u),    S' = K (v - V).

Where M V u' is far below all that is asked for the slider is in balance, and the first equation becomes
S = F_k(u) + γ V, (dF_k/du + γ V) u' = S'. Steps in balance lead to such sliding as they lead to creep without a mass,
where M V^2 is small beside what F_k and damping change by on a life, L (dF_k/du + γ V).

Sliding begins in balance. It goes on to the end of the path, or until V changes by CHANGE or more along L, the longest
life of a contact. There the contacts stand as in steady sliding at that speed, and steps go on.

The error of F is what it is off F_k(V) by as steps end, and by the lag of first order in the change of V
(master/soft/in_time/creep.py, whose search for steady creep this is). The spring's force is off by no more in balance;
with inertia by twice as much, as in half a swing that is not damped.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.motion import Motion
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.creep import CREEP, Creep, may_creep
from master.soft.in_time.decohered import LONGER_LIVED, longest_life
from master.soft.in_time.steps import Node
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.in_time.steady_motion import SlidingMachine, SteadyMotion
from master.steady.kinetic_table import KineticTable
from origins import Contacts, Drive
from origins.thresholds.law import Array

# Largest change of ln V on a longest life with which F is F_k(V), on the coarsest steps; halved with them, so that what
# it misses shows.
CHANGE = 0.1
# Ratio of M V^2 to L (dF_k/du + γ V) up to which steps in balance may end in sliding.
LIGHT = 0.5
# Least way that is worth it, in longest lives.
WORTH = 20.0
# Relative change of the life of contacts that grow as it is found.
LIFE_IS_FOUND = 1e-3
# Speeds at which the energy of steady contacts is summed, and cohorts of each sum.
ENERGIES, COHORTS = 7, 200


class Slid(NamedTuple):
    """How the slider slides on: nodes from here on; breaks per contact on the way; the error of the spring's force (a
    length); whether the path ends there; the time from which on F is within the tolerance of its last value; and by how
    much the error of the contacts' force is larger."""

    nodes: list[HeavyNode]
    breaks: Array
    error: float
    to_end: bool
    steady_from: float
    of_contacts: float = 0.0


class SlidingBegin(NamedTuple):
    """Where steady sliding begins: ln V, the table of F_k, and the error of F there (a length)."""

    u: float
    table: KineticTable
    error: float


class SteadySliding(Creep):
    """Steady sliding on the last leg of a drive that goes on at one speed; lengths are along the motion.

    in_slips : whether it is looked for in slips, or in balance
    """

    in_slips, _most_change = False, CHANGE

    def __init__(
        self, contacts: Contacts, drive: Drive, motion: Motion, tolerance: float, until: float
    ) -> None:
        """See Creep."""
        super().__init__(contacts, drive, motion, tolerance, until)
        self._machine = SlidingMachine(
            mass=float(drive.mass or 0.0),
            damping=drive.damping,
            spring=self._spring,
            drive_speed=self._speed,
            unit=self._unit,
            life=_life_at(contacts, self._speed),
            until=until,
        )

    def slide(self, way: list[HeavyNode], contacts: ContactsInSteps) -> Slid | None:
        """How the slider goes on from the last of these nodes, since it turned round last. None where it goes on in
        steps: where sliding is not steady or not known to be, or the path ends soon."""
        last, sign = way[-1], self._sign
        distance, speed = sign * (last.position - way[0].position), sign * last.speed
        looked = len(way) < CREEP.next_look * self._nodes_at_last_look
        if speed <= 0.0 or looked or distance < CREEP.least_distance * abs(last.force):
            return None
        self._nodes_at_last_look = len(way)
        left = max(self._speed, speed) * float(self._motion.times[-1] - last.time)
        # contacts that grow live longest where the slider is slowest
        slowest = min(self._speed, speed)
        self._machine = self._machine._replace(life=_life_at(self._contacts, slowest))
        # a life that is not known is not compared: no way is worth it then
        if not left >= WORTH * self._machine.life:
            return None
        begin = self._in_balance(way, distance)
        return None if begin is None else self._slid(last, begin, contacts, SteadyMotion)

    def _in_balance(self, way: list[HeavyNode], distance: float) -> SlidingBegin | None:
        """The begin of sliding in balance, by the rules of steady creep; None where it is not known to be so."""
        steady = self._steady([Node(*node[:5]) for node in way], distance)
        if steady is None:
            return None
        table, load = steady.table, self._load(way[-1])

        def excess(u: float) -> float:
            return float(table.force(np.array(u))) + self._machine.damping * np.exp(u) - load

        low, high = table.ends.tolist()
        if excess(low) * excess(high) >= 0.0:
            return None
        u = float(brentq(excess, low, high))
        load -= self._machine.inertia(u, table)
        if excess(low) * excess(high) >= 0.0:
            return None
        u = float(brentq(excess, low, high))
        heavy = self._machine.mass * np.exp(
            2.0 * u
        ) > LIGHT * self._machine.life * self._machine.stiffness(u, table)
        if heavy or not self._stable(u):
            return None
        error = max(steady.offset.at_step_0(self._offset_of_longer_steps), steady.lag)
        self._offset_of_longer_steps = steady.offset
        return SlidingBegin(u, table, float(error + steady.offset.variation))

    def _load(self, node: HeavyNode) -> float:
        """The spring's force (a length)."""
        drive = float(self._motion.at(np.array(node.time)))
        return self._sign * self._spring * (drive - node.position)

    def _slid(
        self,
        last: HeavyNode,
        begin: SlidingBegin,
        contacts: ContactsInSteps,
        equations: type[SteadyMotion],
    ) -> Slid:
        """The solution from the last node on, by these equations."""
        left = float(self._motion.times[-1]) - last.time
        steady = equations(self._machine, begin.table, left)
        state = np.array([begin.u, self._load(last), last.time, *np.zeros(4)])
        rows, to_end = steady.followed(
            state, float(self._motion.times[-1]), self._most_change * 0.5**contacts.halvings
        )
        sigma, u, load, time, given, damped, on_contacts, breaks = rows
        if to_end:
            time[-1] = self._motion.times[-1]
        force, speed, sign = begin.table.force(u), np.exp(u), self._sign
        place = self._motion.at(time) - sign * load / self._spring
        slowest = float(np.exp(u.min()))  # where contacts that grow live longest
        self._machine = self._machine._replace(life=_life_at(self._contacts, slowest))
        stored = self._stored(u, contacts)
        energies = last.work + given, last.damped + damped, last.on_contacts + on_contacts
        columns = sigma, time, sign * force, np.ones(u.size), place, sign * speed, *energies, stored
        nodes = [HeavyNode(*row) for row in np.stack(columns, axis=1).tolist()]
        off = np.flatnonzero(np.abs(load - load[-1]) > self._tolerance)
        steady_from = float(time[off[-1] + 1 if off.size else 0]) if to_end else np.inf
        error = (begin.error + begin.table.error) * (2.0 if steady.swings else 1.0)
        return Slid(nodes, breaks / self._unit, error, to_end, steady_from)

    @property
    def life(self) -> float:
        """The longest life of a contact since sliding began last (a length)."""
        return self._machine.life

    def _stored(self, u: Array, contacts: ContactsInSteps) -> Array:
        """Energy of the contacts at these ln V (length squared), straight between some of them."""
        at = np.linspace(u.min(), u.max(), ENERGIES if np.ptp(u) else 1)
        step = self.life / COHORTS
        energies = [contacts.stored_at(speed, step, self.life) for speed in np.exp(at).tolist()]
        return np.asarray(np.interp(u, at, energies))


def _life_at(contacts: Contacts, speed: float) -> float:
    """The way on which all but LONGER_LIVED of the contacts break at this speed (a length), also as they grow stronger
    on it."""
    life, growing = longest_life(contacts.thresholds), contacts.growing
    if growing is None:
        return life
    hazard, before = -np.log(LONGER_LIVED), 0.0
    while life > (1.0 + LIFE_IS_FOUND) * before:
        before, life = life, float(growing.threshold_at(hazard, life / speed))
    return life


def sliding_of(
    contacts: Contacts, drive: Drive, motion: Motion | None, tolerance: float, until: float
) -> SteadySliding | None:
    """Steady sliding of these contacts in heat, None where it is not known; until : as in `creep_of`."""
    if motion is None or not may_creep(contacts, motion):
        return None
    return SteadySliding(contacts, drive, motion, tolerance, until)
