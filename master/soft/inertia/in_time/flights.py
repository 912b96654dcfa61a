"""Flights: ways of a slider with mass on which its contacts are out, without steps.

Contacts that wait for a delay before they form again are out soon after a slip has begun. The slider then moves on its
spring alone, a damped oscillator in closed form,

    M y'' + γ y' + K y = K (X_T - X_0),

by a million thresholds on the spring of a machine, and swings there, until those that broke in the slip form again.

Contacts that broke one by one before the slip form on the way. Each breaks as soon as the slider has moved by its
threshold, which it does at once, as a slip is fast: J and B grow together. Of those whose largest |x| is d a share of
at most S(d) holds, and bears y S(y) each born at most, y >= d. A flight begins and ends where all together might bear
more than ALLOWED of the tolerance; what they might bear before counts as an error of F.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.outcome import stop_after
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.groups import Groups
from master.soft.in_time.memory import Memory
from master.soft.in_time.steps import CONTROL
from master.soft.in_time.threshold_cells import StraightMove
from master.soft.inertia.oscillation import NONE_HOLDS, Oscillation, Pulled
from master.soft.inertia.record import Spent
from origins.drive import Drive
from origins.thresholds.law import Array

# Force, in tolerances, that contacts may bear which are taken to be out; and times that by which the spring's force may
# be off, as the slider swings about its balance with them.
ALLOWED, SWINGS_BY = 0.05, 2.0
# They must not hold the slider either, which few contacts do on a soft spring: so they are weaker than it by this
# factor, or to stretch them takes this part of the energy of the slider at most.
WEAKER, OF_ENERGY = 0.1, 0.05
# Departure of the slider from its balance as contacts form again that broke in a slip, in mean thresholds, up to which
# flights are followed: they come back in volleys where it still swings, too fast for steps. And the softest spring, in
# N_c<k>, on which steps lead through a slip.
AT_RETURN, SOFTEST_IN_STEPS = 10.0, 1e-2
# Phase (radians) of the swing on its spring between two nodes, between which X is a cubic of the time: off by
# PHASE^4/384 of the swing. An overdamped slider has two rates: between both, nodes are GROWTH of the time apart.
PHASE, GROWTH = 0.15, 0.05
# Departure from the slider's balance, in mean thresholds, below which it drifts evenly; and nodes on the rest then.
STILL, OF_DRIFT = 1e-6, 32
# Times between two nodes of which births count together in the bound on the contacts that hold, ever denser up to the
# later node, as parts of the interval left; and most of them that it looks back on.
PARTS_LEFT, LOOKS_BACK = np.append(0.7 ** np.arange(1, 24), 0.0), 480
# Share of the contacts that hold, above which no flight is looked for; and in a group, below which it is left out.
FEW_HOLD, GONE = 0.1, 1e-15
# Cells of the mesh on which bounds are told, 0.5 % apart, and the first, in mean thresholds.
MESH, FIRST_OF_MESH = 4000, 1e-6
# Most nodes; halvings of their distance in search of the end; and by which factor the last one may be longer.
MOST, HALVINGS, LONGER = 4000, 12, 1.001
# Least way worth a flight, in travels of a step; steps behind a shorter one, before which none is looked for.
WORTH, NEXT_LOOK = 40.0, 20


class Bounds:
    """The largest y^n S(y) from y = d on, per contact born, of contacts whose largest |x| is at least d.

    d is met from above on a mesh, in equal ratios, so that each value is a bound.
    """

    def __init__(self, survival: Callable[[Array], Array], unit: float, largest: float) -> None:
        """Of contacts with this S(d) and mean threshold, none of which holds beyond the largest stretch."""
        ends = np.append(0.0, np.geomspace(FIRST_OF_MESH * unit, largest, MESH))
        self._ends, held = ends[1:-1], survival(ends)

        def beyond(order: int) -> Array:
            in_cells = ends[1:] ** order * held[:-1]
            return np.asarray(np.maximum.accumulate(in_cells[::-1])[::-1])

        self._held, self._force, self._square = held[:-1], beyond(1), beyond(2)

    def of(self, births: Array, travelled: Array) -> "Bound":
        """Of so many births, per contact, that have travelled at least so far."""
        cell = np.searchsorted(self._ends, travelled, side="right")
        return Bound(*(float(births @ of[cell]) for of in (self._held, self._force, self._square)))


class Bound(NamedTuple):
    """The share of the contacts that may hold, the force that they may bear, and x^2 of these (a length squared)."""

    holding: float
    force: float
    square: float

    def plus(self, other: "Bound") -> "Bound":
        """Of both."""
        return Bound(*(a + b for a, b in zip(self, other, strict=True)))

    def or_larger(self, other: "Bound") -> "Bound":
        """Of the larger ones."""
        return Bound(*(max(pair) for pair in zip(self, other, strict=True)))


class Flight(NamedTuple):
    """The slider at the nodes of a flight, arrays of shape (n,), the first one where it begins.

    time, position, speed : the time on the path, X and dX/dt
    sizes : of the intervals so far, in which all is smooth
    spent : energies from its begin on
    holding : the share of the contacts that holds, of those formed on the way
    landed : these contacts at its end, in groups
    bound : on what contacts do that are taken to be out
    """

    time: Array
    position: Array
    speed: Array
    sizes: Array
    spent: Spent
    holding: Array
    landed: Groups
    bound: Bound


class Formed(NamedTuple):
    """Contacts that formed on a flight, up to some instants, arrays of shape (n,), the last one now.

    times, travels : since its begin
    births : share of the contacts born since the instant before, relaxed
    """

    times: Array
    travels: Array
    births: Array

    def and_then(self, later: "Formed") -> "Formed":
        """These and later ones; those born before the last LOOKS_BACK instants count to the first one kept."""
        both = Formed(*(np.append(*pair) for pair in zip(self, later, strict=True)))
        kept = Formed(*(one[-LOOKS_BACK:].copy() for one in both))
        kept.births[0] += both.births[:-LOOKS_BACK].sum()
        return kept

    def furthest(self) -> Array:
        """How far those born between two instants have travelled at least, shape (n,): as far as from the nearer one to
        now, if it is on one side of both, and half of the range since the later one; of the first, with which all older
        ones count, the latter alone."""
        ahead = self.travels[-1] - np.stack([np.roll(self.travels, 1), self.travels])
        to_now = np.where(ahead[0] * ahead[1] > 0.0, np.abs(ahead).min(axis=0), 0.0)
        return np.asarray(np.maximum(to_now, 0.5 * np.ptp(self._later(), axis=0)))

    def holding(self, survival: Callable[[Array], Array]) -> float:
        """The share that holds now where heat breaks none, of those born between two instants in the middle."""
        return float(self.births[1:] @ survival(self._largest()))

    def in_groups(self, memory: Memory, survival: Callable[[Array], Array]) -> Groups:
        """Those that hold now, each two instants' births as a group."""
        largest, place, born_at = self._largest(), *map(_middles, (self.travels, self.times))
        some = np.flatnonzero(self.births[1:] * survival(largest) > GONE)
        some = some if some.size else np.array([largest.size - 1])
        stretch, lasts = self.travels[-1] - place[some], self.times[-1] - born_at[some]
        record = [
            memory.advance(
                memory.start(np.zeros(1)),
                StraightMove(np.zeros(1), stretch[[k]], largest[some[[k]]], float(lasts[k])),
            )
            for k in range(some.size)
        ]
        return Groups(stretch, largest[some], self.births[1:][some], np.concatenate(record))

    def _later(self) -> Array:
        """The largest and the least travel from each instant on, shape (2, n)."""
        after = self.travels[::-1]
        return np.stack([np.maximum.accumulate(after), np.minimum.accumulate(after)])[:, ::-1]

    def _largest(self) -> Array:
        """The largest |x| so far of those born in the middle between two instants, shape (n - 1,)."""
        place, (most, least) = _middles(self.travels), self._later()[:, 1:]
        return np.maximum(most - place, place - least)


class FlightNodes(NamedTuple):
    """Nodes of a flight, arrays of shape (n,), and the contacts that formed on it.

    times, sizes, held : since its begin, of the intervals so far, and the share of the contacts that holds
    bound : on what contacts do anywhere
    """

    times: Array
    sizes: Array
    held: Array
    bound: Bound
    formed: Formed


class Flights:
    """Flights of a slider on these contacts; see the head of the file.

    are_known : whether they are looked for; at_one_speed : whether they would be on a drive of one speed
    """

    def __init__(
        self,
        contacts: ContactsInSteps,
        drive: Drive,
        motion: Motion,
        tolerance: float,
        survival: Callable[[Array], Array] | None,
    ) -> None:
        """tolerance : of the force (a length). survival : S(x) of contacts that form, which are relaxed then and keep
        their thresholds; None for others, of which no flight is known."""
        self._contacts, self._motion, self._survival = contacts, motion, survival
        self._mass, self._damping = float(drive.mass or 0.0), drive.damping
        self._spring = float(drive.spring or 0.0)
        self._most, self._not_before = ALLOWED * tolerance, 0
        given = self._mass, self._damping, self._spring, 0.0, 0.0, contacts.unit / self._spring, 0.0
        swing = Oscillation.of(*given).bound(contacts.delay)
        soft = self._spring <= SOFTEST_IN_STEPS and swing <= AT_RETURN * contacts.unit
        self.at_one_speed = survival is not None and soft and bool(contacts.delay)
        # what follows a slip on a drive that turns, stops or changes its speed is not known by the slip's own clock
        self.are_known = self.at_one_speed and motion.speeds.size == 1 and bool(motion.speeds[0])
        if survival is not None and self.are_known:
            self._bounds = Bounds(survival, contacts.unit, contacts.memory.largest_stretch)

    def ahead(self, leg: int, end: float, speed: float) -> Flight | None:
        """The flight from now on of a slider of this speed, up to the time `end` at most; None where contacts hold, or
        come back so soon that it is not worth it."""
        contacts, groups = self._contacts, self._contacts.groups
        may_be_out = self.are_known and contacts.holding < FEW_HOLD
        if self._survival is None or not may_be_out or contacts.steps < self._not_before:
            return None
        kept = self._bounds.of(groups.weight, groups.largest)
        if kept.force > self._most:
            return None
        drive_speed, now = float(self._motion.speeds[leg]), contacts.now
        pull = self._spring * (float(self._motion.at(np.array(now))) - contacts.position)
        rate = self._spring * drive_speed
        motion = Oscillation.of(self._mass, self._damping, self._spring, pull, rate, 0.0, speed)
        # for a delay, births are those of breaks before the flight
        lasts = min(end - now, contacts.delay)
        way = self._way(motion, lasts, kept)
        t, travel = way.times, motion.travel(way.times)
        of_step = CONTROL.coarsest * contacts.memory.scales.length * 0.5**contacts.halvings
        if np.abs(np.diff(travel)).sum() < WORTH * of_step:
            self._not_before = contacts.steps + NEXT_LOOK
            return None
        pulled = Pulled(self._spring, self._damping, drive_speed, pull)
        spent = motion.spent(t, travel, pulled, NONE_HOLDS)
        time = np.minimum(now + t, end)
        if t[-1] == lasts == end - now:
            time[-1] = end  # to the last digit
        place, pace = contacts.position + travel, motion.speed(t)
        landed, held = way.formed.in_groups(contacts.memory, self._survival), way.held
        held[-1] = landed.survival_and_force(contacts.memory)[0] @ landed.weight
        return Flight(time, place, pace, way.sizes, spent, held, landed, way.bound)

    def _way(self, motion: Oscillation, lasts: float, kept: Bound) -> FlightNodes:
        """The nodes of this motion, for this time at most, or until too many contacts may hold; `kept`: of those that
        hold as it begins."""
        contacts, survival, rates = self._contacts, self._survival, np.abs(motion.roots)
        assert survival is not None
        shortest, longest = PHASE / rates.max(), PHASE / rates.min()
        births, largest = self._births(0.0), kept
        times, sizes, held = [0.0], [0.0], [0.0]
        formed = Formed(np.zeros(1), np.array([motion.travel(0.0)]), np.zeros(1))
        while times[-1] < lasts and len(times) < MOST:
            stop_after(contacts.until)
            t = times[-1]
            step = max(shortest, min(longest, GROWTH * t))
            if motion.bound(t) < STILL * contacts.unit:
                step = max(step, lasts / OF_DRIFT)
            for ahead in step * 0.5 ** np.arange(HALVINGS + 1):
                until = lasts if lasts - t < LONGER * ahead else t + float(ahead)
                births_then = self._births(until)
                new = -max(births_then - births, 0.0) * np.diff(PARTS_LEFT, prepend=1.0)
                instants = until - (until - t) * PARTS_LEFT
                tried = formed.and_then(Formed(instants, motion.travel(instants), new))
                bound = kept.plus(self._bounds.of(tried.births, tried.furthest()))
                if self._is_weak(motion, until, bound):
                    break
            else:
                break
            births, largest, formed = births_then, largest.or_larger(bound), tried
            times.append(until)
            sizes.append(sizes[-1] + (until - t) / step)
            held.append(formed.holding(survival))
        return FlightNodes(np.array(times), np.array(sizes), np.array(held), largest, formed)

    def _is_weak(self, motion: Oscillation, t: float, bound: Bound) -> bool:
        """Whether contacts that do no more than this do not hold the slider at this time."""
        departure, speed = float(motion.departure(t)), float(motion.speed(t))
        energy = self._mass * speed**2 + self._spring * departure**2
        weak = bound.holding <= WEAKER * self._spring or bound.square <= OF_ENERGY * energy
        return weak and bound.force <= self._most

    def _births(self, t: float) -> float:
        """J at this time from now on."""
        now, breaks = self._contacts.now, self._contacts.past_breaks
        return breaks.births_up_to(begin=now, end=now + t).rest


def _middles(values: Array) -> Array:
    """Means of neighbours, shape (n - 1,)."""
    return 0.5 * (values[1:] + values[:-1])
