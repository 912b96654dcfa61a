"""A slider with mass along its whole path, step by step and turn after turn; its contacts' laws depend on time."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from master.motion import Motion
from master.outcome import StoppedError
from master.soft.in_time import unresolved
from master.soft.in_time.contacts import ContactsInSteps, Trial
from master.soft.inertia.body import QUIET
from master.soft.inertia.in_time.balanced_steps import BalancedStep, BalancedSteps, Drifts
from master.soft.inertia.in_time.falls import Falls
from master.soft.inertia.in_time.flights import SWINGS_BY, Bound, Flights
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.in_time.ringing import Ring, Ringing
from master.soft.inertia.in_time.steady_sliding import Slid, SteadySliding
from master.soft.inertia.in_time.swing_steps import SwingSteps, Swung
from master.soft.inertia.record import NOTHING_SPENT, Spent
from origins.drive import Drive
from origins.thresholds.law import Array

# Force of a swing, in QUIET of the tolerance, below which it counts as rest; and of inertia that is left out then,
# above which the slider swings again: so far apart that the two ways of going on do not alternate.
COMES_TO_REST, LEAVES_REST = 2.5, 10.0
# Fewest steps of a swing before rest is looked for again, where it was not found; and of rest that are worth it.
STEPS_TO_REST = 8
# Least part of a step's size that is tried at rest; before long slips up to where F' jumps, as a group begins to break.
LEAST_IN_BALANCE, LEAST_BEFORE_LONG_SLIPS = 2.0**-8, 2.0**-12


class HeavySlider:
    """The solution along the whole path, with steps of 2^-halvings of the coarsest.

    contacts, motion : its contacts; the drive's motion, None where it does not move
    sections : nodes of each smooth section: from a turn of the slider to the next, or of the drive
    falls : of the spring's force, and slips among them
    slides : long ways without steps, in order
    flown : bounds on what contacts do on flights, in order; rings : swings that are told without steps
    longest_start : the longest time from rest, or a slip's begin before, to its flight, as the slider gets fast
    """

    def __init__(
        self,
        contacts: ContactsInSteps,
        drive: Drive,
        motion: Motion | None,
        tolerance: float,
        sliding: SteadySliding | None = None,
        survival: Callable[[Array], Array] | None = None,
        ringing: Ringing | None = None,
    ) -> None:
        """At rest, in balance, at t = 0; `tolerance` is that of the force, a length; `sliding`: how it may slide on
        without steps; `survival`: as in `Flights`; `ringing`: swings that are told without steps."""
        self.contacts, self.motion = contacts, motion
        self.spring, self.quiet = float(drive.spring or 0.0), QUIET * tolerance
        self.damping, self._size = drive.damping, 0.5**contacts.halvings
        self._in_balance, self._not_before = False, 0
        self._spent = NOTHING_SPENT
        self._sliding, self._ringing, self._broken_before = sliding, ringing, 0.0
        self._way = list[HeavyNode]()  # since the slider turned last, or slid
        self.slides, self.flown, self.rings = list[Slid](), list[Bound](), list[Ring]()
        # when it left rest last; inf once it has flown or slipped without steps since
        self.longest_start, self._left_rest = 0.0, 0.0
        self.sections = list[list[HeavyNode]]()
        self.falls = Falls(motion, self.spring, contacts.unit, contacts.delay)
        if motion is None:
            self.sections.append([self._node(0.0, 0.0)])
            return
        self._swings = SwingSteps(contacts, drive, motion)
        self._drifts = Drifts(self._swings.mass, drive.damping)
        self._flights = Flights(contacts, drive, motion, tolerance, survival)
        self._balanced = BalancedSteps(
            contacts, drive, motion, self._drifts, self._flights.are_known
        )

    @property
    def may_pass_slips(self) -> bool:
        """Whether ways without steps through slips are looked for: flights, or long slips."""
        slides = self._sliding is not None and self._sliding.in_slips
        return slides or (self.motion is not None and self._flights.are_known)

    @property
    def passes_slips(self) -> bool:
        """Whether there were some."""
        in_slips = self._sliding is not None and self._sliding.in_slips
        return bool(self.flown) or (in_slips and bool(self.slides or self.rings))

    @property
    def may_fly_at_one_speed(self) -> bool:
        """Whether flights would be looked for on a drive of one speed, which this is not."""
        return self.motion is not None and self._flights.at_one_speed > self._flights.are_known

    def run(self) -> None:
        """Follow the drive to its end, leg by leg."""
        contacts, motion = self.contacts, self.motion
        if motion is None:
            return
        for leg, last in enumerate(motion.times[1:].tolist()):
            contacts.past_breaks.repeat_bend(float(motion.times[leg]))
            # the drive's speed has changed, and the slider's own has not
            self._in_balance = False
            self._drifts.begin()
            swing, goes_on = np.inf, False
            while contacts.now < last:
                end = min([*contacts.past_breaks.pending, last])
                self.sections.append([self._node(0.0, self._swings.speed)])
                contacts.past_breaks.begin_section()
                if self._in_balance:
                    self._balanced.begin_section(leg, end, self._swings.speed)
                    self._follow_in_balance(leg, end)
                    swing = self.quiet
                elif self._ring_if_none_breaks(leg, end):
                    swing = self.quiet
                else:
                    # which asks for the next one at rest, not for one behind swings
                    self._balanced.ends_section = False
                    self._swings.begin_section(leg, end, swing, goes_on)
                    swing = self._swing(leg, end)
                goes_on = True
                if contacts.now >= end and end < last:
                    contacts.form_due()

    def _swing(self, leg: int, end: float) -> float:
        """Take steps of a swing until `end`, until the slider comes to rest on its contacts, until it turns round, or
        until the swing has become much smaller or larger; returns how large it is (a length)."""
        contacts, swings = self.contacts, self._swings
        size = np.inf
        while contacts.now < end:
            swung = swings.next_resolved(self._size)
            spent = swings.spent(swung)
            off, speed = swings.swing_of(swung)
            stiff = self.spring + contacts.holding
            size = off + speed * (swings.mass / stiff) ** 0.5
            at_rest = self._force_at_rest(swung, stiff * off, speed)
            self._drifts.add(0.5 * (contacts.now + swung.trial.end), swung.motion.drift)
            self._take(leg, swung.trial, swings.size(swung.trial), swung.speed, spent)
            if self._slide_if_steady(leg) or self._fly_if_all_are_out(leg, end):
                break
            if at_rest < COMES_TO_REST * self.quiet and contacts.steps >= self._not_before:
                contacts.unresolved.note(unresolved.OF_QUIET, at_rest, contacts.now)
                self._in_balance = True
                break
            if swung.turns or swings.needs_other_steps(size):
                break
        return size

    def _follow_in_balance(self, leg: int, end: float) -> None:
        """Take steps in balance until `end`, or until inertia matters again."""
        contacts, balanced = self.contacts, self._balanced
        begin, part = contacts.steps, 1.0
        # swings are told without steps where long slips are
        before_long_slips = self._ringing is not None
        least = LEAST_BEFORE_LONG_SLIPS if before_long_slips else LEAST_IN_BALANCE
        while contacts.now < end:
            step = balanced.next_step(part * self._size)
            leaves = step is None or self._leaves_rest(step)
            # a long step jumps over the slip to the balance behind it; shorter ones end before the slip
            if leaves and part > least and (step is None or before_long_slips):
                part *= 0.5
                continue
            part = min(2.0 * part, 1.0)
            if step is None or leaves:
                self._in_balance = False
                self._left_rest = contacts.now
                if contacts.steps < begin + STEPS_TO_REST:
                    self._not_before = contacts.steps + STEPS_TO_REST
                return
            contacts.unresolved.note(unresolved.OF_QUIET, step.left_out, contacts.now)
            spent = balanced.spent(step.trial)
            self._drifts.add(0.5 * (contacts.now + step.trial.end), step.drift)
            self._take(leg, step.trial, balanced.size(step.trial), step.speed, spent)
            if self._slide_if_steady(leg) or balanced.ends_section:
                return

    def _force_at_rest(self, swung: Swung, force: float, speed: float) -> float:
        """Force that is left out if what is left of the swing at the end of this step, which is not taken yet, with
        this force and speed, counts as rest."""
        stiff, mass = self.spring + self.contacts.holding, self._swings.mass
        force += max((stiff * mass) ** 0.5, self.damping) * speed
        middle = 0.5 * (self.contacts.now + swung.trial.end)
        return max(force, self._drifts.left_out(middle, swung.motion.drift, stiff))

    def _leaves_rest(self, step: BalancedStep) -> bool:
        """Whether inertia that this step in balance leaves out matters, or it leads back in time."""
        return step.left_out > LEAVES_REST * self.quiet or self._balanced.size(step.trial) <= 0.0

    def _take(self, leg: int, trial: Trial, size: float, speed: float, spent: Spent) -> None:
        """Take a step, at whose end the slider has this speed and on which these energies were `spent`."""
        contacts, nodes = self.contacts, self.sections[-1]
        taken, breaks = max(size, 0.0), contacts.past_breaks.total
        contacts.past_breaks.check_none_is_passed(trial.end)
        contacts.take(trial, taken)
        self._spent = self._spent.plus(spent)
        self._swings.speed = speed
        if not np.isfinite(contacts.position):
            raise StoppedError(f"the motion is lost at t = {contacts.now:.6g}")
        nodes.append(self._node(nodes[-1].sizes_so_far + taken, speed))
        before, after = nodes[-2:]
        earlier = self._broken_before
        broken = earlier + breaks, earlier + contacts.past_breaks.total
        self.falls.watch(leg, before, after, broken)
        self._way = [*self._way, after] if speed else [after]

    def _slide_if_steady(self, leg: int) -> bool:
        """Slide on steadily as far as that is known; returns whether the slider did."""
        contacts, motion, sliding = self.contacts, self.motion, self._sliding
        if sliding is None or motion is None or leg < motion.speeds.size - 1:
            return False
        slid = sliding.slide(self._way, contacts)
        if slid is None:
            return False
        before = self._broken_before + contacts.past_breaks.total
        for k, (one, after) in enumerate(pairwise(slid.nodes)):
            broken = before + slid.breaks[k], before + slid.breaks[k + 1]
            self.falls.watch(leg, one, after, broken)
        last, self._broken_before = slid.nodes[-1], before + float(slid.breaks[-1])
        if sliding.in_slips:
            self._since_rest()
        kind = unresolved.OF_LONG_SLIP if sliding.in_slips else unresolved.OF_CREEP
        contacts.unresolved.note(kind, slid.error, contacts.now)
        step = self._size * self._swings.length
        contacts.slide_to(last.position, last.time, last.speed, step, sliding.life)
        self._spent = last.spent
        self.sections.append(slid.nodes)
        self.slides.append(slid)
        self._swings.speed, self._in_balance, self._way = last.speed, False, []
        sliding.begin_section()
        return True

    def _since_rest(self) -> float | None:
        """When the slider left rest, or began to slip before, as its first way without steps since then begins; None on
        others."""
        if self._left_rest >= self.contacts.now:
            return None
        since = min([self._left_rest, *self.falls.begins[len(self.falls.slips) :]])
        self.longest_start = max(self.longest_start, self.contacts.now - since)
        self._left_rest = np.inf
        return since

    def _ring_if_none_breaks(self, leg: int, end: float) -> bool:
        """Swing on, where the slider turns round now, on contacts of which none breaks, as a section of two nodes, up
        to its rest or the time `end`; returns whether it did."""
        contacts, node = self.contacts, self.sections[-1][-1]
        if self._ringing is None or self._swings.speed:
            return False
        ring = self._ringing.ahead(leg, end, contacts, node)
        if ring is None:
            return False
        until = min(node.time + ring.lasts, end)
        trial = contacts.trial(float(ring.motion.travel(until - node.time)), until)
        last = HeavyNode(1.0, until, *ring.columns(np.array([until]))[:, 0].tolist())
        contacts.unresolved.note(unresolved.OF_RINGING, SWINGS_BY * ring.broken, contacts.now)
        self._take(leg, trial, 1.0, last.speed, last.spent.less(node.spent))
        self.rings.append(ring)
        self._in_balance = until < end
        for time in (node.time, until):
            self._drifts.add(time, ring.motion.drift)
        return True

    def _fly_if_all_are_out(self, leg: int, end: float) -> bool:
        """Fly on the spring alone, as a section, where all contacts are out; returns whether the slider did."""
        contacts, before = self.contacts, self._broken_before
        flight = self._flights.ahead(leg, end, self._swings.speed)
        if flight is None:
            return False
        contacts.unresolved.note(unresolved.OF_FLIGHT, SWINGS_BY * flight.bound.force, contacts.now)
        if (since := self._since_rest()) is not None:
            contacts.past_breaks.repeat_bend(since)
        contacts.past_breaks.repeat_bend(contacts.now)
        self.flown.append(flight.bound)
        contacts.past_breaks.begin_section()
        spent = self._spent
        nodes = [self._node(0.0, self._swings.speed)]
        self.sections.append(nodes)
        for k, size in enumerate(np.diff(flight.sizes).tolist(), 1):
            broken = before + contacts.past_breaks.total
            place, now, held = flight.position[k], flight.time[k], flight.holding[k]
            contacts.fly_to(float(place), float(now), size, float(held))
            self._spent = spent.plus(flight.spent.at(k))
            nodes.append(self._node(float(flight.sizes[k]), float(flight.speed[k])))
            after = before + contacts.past_breaks.total
            self.falls.watch(leg, nodes[-2], nodes[-1], (broken, after))
        # what has formed bears a force at once: of the next section, as no spline is to lead through that
        contacts.land(flight.landed)
        self._swings.speed, self._way = nodes[-1].speed, nodes[-1:]
        self._drifts.begin()
        return True

    def _node(self, sizes_so_far: float, speed: float) -> HeavyNode:
        """The end of the step just taken, with this speed of the slider."""
        state = self.contacts
        place = state.now, state.force, state.holding, state.position
        stored = state.groups.stored(state.memory)
        return HeavyNode(sizes_so_far, *place, speed, *self._spent, stored)
