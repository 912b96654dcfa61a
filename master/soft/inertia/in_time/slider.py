"""A slider with mass along its whole path, step by step and turn after turn; its contacts' laws depend on time."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.outcome import StoppedError
from master.soft.in_time.contacts import ContactsInSteps, Trial
from master.soft.in_time.steps import CONTROL
from master.soft.in_time.unresolved import OF_CREEP, OF_QUIET
from master.soft.inertia.body import QUIET
from master.soft.inertia.in_time.falls import Falls, StepEnd
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.in_time.slow_steps import Crept, Drifts, SlowSteps
from master.soft.inertia.in_time.steady_sliding import Slid, SteadySliding
from master.soft.inertia.in_time.swing_steps import SwingSteps, Swung
from origins.drive import Drive
from origins.thresholds.numerical import clipped

# Force of a swing, in QUIET of the tolerance, below which it counts as rest; and of inertia that is left out then,
# above which the slider swings again: so far apart that the two ways of going on do not alternate.
COMES_TO_REST, LEAVES_REST = 2.5, 10.0
# Fewest steps of a swing before rest is looked for again, where it was not found; and of rest that are worth it.
STEPS_TO_REST = 8
# Times the e-folds of contacts that may break on a step up to which it is taken as it is; least factor on its size.
BELIEVED, LEAST_SHRINK = 1.5, 0.03


class Spent(NamedTuple):
    """Energies on a step, per N_c<k> (length squared): the work of the drive, and what damping and moving the contacts
    took."""

    given: float
    damped: float
    on_contacts: float


class HeavySlider:
    """The solution along the whole path, with steps of 2^-halvings of the coarsest.

    contacts, motion : its contacts; the drive's motion, None where it does not move
    sections : nodes of each smooth section: from a turn of the slider to the next, or of the drive
    falls : of the spring's force, and slips among them
    slides : long ways without steps, in order
    """

    def __init__(
        self,
        contacts: ContactsInSteps,
        drive: Drive,
        motion: Motion | None,
        tolerance: float,
        sliding: SteadySliding | None = None,
    ) -> None:
        """At rest, in balance, at t = 0; `tolerance` is that of the force, a length; `sliding`: how it may slide on
        without steps."""
        self.contacts, self.motion = contacts, motion
        self.spring, self.quiet = float(drive.spring or 0.0), QUIET * tolerance
        self.damping, self._size = drive.damping, 0.5**contacts.halvings
        self._shrink, self._is_slow, self._not_before = 1.0, False, 0
        self._work = self._damped = self._on_contacts = 0.0
        self._sliding, self._broken_before = sliding, 0.0
        self._way = list[HeavyNode]()  # since the slider turned last, or slid
        self.slides = list[Slid]()
        self.sections = list[list[HeavyNode]]()
        self.falls = Falls(motion, self.spring, contacts.unit)
        if motion is None:
            self.sections.append([self._node(0.0, 0.0)])
            return
        contacts.takes_no_birth_back = True
        self._swings = SwingSteps(contacts, drive, motion)
        self._drifts = Drifts(self._swings.mass, drive.damping)
        self._slow = SlowSteps(contacts, drive, motion, self._drifts)
        self._drive_speed = 0.0

    def run(self) -> None:
        """Follow the drive to its end, leg by leg."""
        contacts, motion = self.contacts, self.motion
        if motion is None:
            return
        for leg, last in enumerate(motion.times[1:].tolist()):
            contacts.past_breaks.repeat_bend(float(motion.times[leg]))
            # the drive's speed has changed, and the slider's own has not
            self._is_slow, self._drive_speed = False, float(motion.speeds[leg])
            self._drifts.begin()
            swing, goes_on = np.inf, False
            while contacts.now < last:
                end = min([*contacts.past_breaks.pending, last])
                self.sections.append([self._node(0.0, self._swings.speed)])
                contacts.past_breaks.begin_section()
                if self._is_slow:
                    self._slow.begin_section(leg, end)
                    self._creep(leg, end)
                    swing = self.quiet
                else:
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
            swung = self._resolving(swings)
            energies = self._energies_of(swung)
            off, speed = swings.swing_of(swung)
            stiff = self.spring + contacts.holding
            size = off + speed * (swings.mass / stiff) ** 0.5
            comes_to_rest = self._comes_to_rest(swung, stiff * off, speed)
            self._drifts.add(0.5 * (contacts.now + swung.trial.end), swung.motion.drift)
            self._take(leg, swung.trial, swings.size(swung.trial), swung.speed, energies)
            if self._slides_on(leg):
                break
            if comes_to_rest and contacts.steps >= self._not_before:
                self._is_slow = True
                break
            if swung.turns or swings.needs_other_steps(size):
                break
        return size

    def _creep(self, leg: int, end: float) -> None:
        """Take steps in balance until `end`, or until inertia matters again."""
        contacts, slow = self.contacts, self._slow
        begin = contacts.steps
        while contacts.now < end:
            crept = slow.next_step(self._size)
            if crept is None or self._leaves_rest(crept):
                self._is_slow = False
                if contacts.steps < begin + STEPS_TO_REST:
                    self._not_before = contacts.steps + STEPS_TO_REST
                return
            contacts.unresolved.note(OF_QUIET, crept.left_out, contacts.now)
            energies = self._energies_of_crept(crept.trial)
            self._drifts.add(0.5 * (contacts.now + crept.trial.end), crept.drift)
            self._take(leg, crept.trial, slow.size(crept.trial), crept.speed, energies)
            if self._slides_on(leg):
                return

    def _resolving(self, swings: SwingSteps) -> Swung:
        """The next step of a swing, so short that not too many contacts break on it."""
        while True:
            size = self._size * self._shrink
            swung = swings.next_step(size)
            taken = min(swings.size(swung.trial), size)
            factor = self._resolving_factor(swung.trial, taken)
            few = taken <= BELIEVED * factor * self._size
            if few:
                self._shrink = min(factor, 1.0)
                return swung
            self._shrink = max(min(factor, 0.7 * self._shrink), LEAST_SHRINK)
            if taken <= LEAST_SHRINK * self._size:
                return swung

    def _resolving_factor(self, trial: Trial, size: float) -> float:
        """The factor on the size of steps at which as many contacts break on one as is resolved; at most 1."""
        holding = self.contacts.holding
        if trial.kept >= holding or size <= 0.0:
            return 1.0
        loss = np.log(holding / trial.kept) / size if trial.kept > 0.0 else np.inf
        return float(clipped(CONTROL.e_folds / loss, LEAST_SHRINK, 1.0))

    def _comes_to_rest(self, swung: Swung, force: float, speed: float) -> bool:
        """Whether what is left of the swing at the end of this step, which is not taken yet, with this force and speed,
        counts as rest."""
        stiff, mass = self.spring + self.contacts.holding, self._swings.mass
        force += max((stiff * mass) ** 0.5, self.damping) * speed
        middle = 0.5 * (self.contacts.now + swung.trial.end)
        left_out = self._drifts.left_out(middle, swung.motion.drift, stiff)
        return max(force, left_out) < COMES_TO_REST * self.quiet

    def _leaves_rest(self, crept: Crept) -> bool:
        """Whether inertia that this step in balance leaves out matters, or it leads back in time."""
        size = self._slow.size(crept.trial)
        return crept.left_out > LEAVES_REST * self.quiet or size <= 0.0

    def _energies_of(self, swung: Swung) -> Spent:
        """The work of the drive, and what damping and contacts take, on a step of a swing that is not taken yet."""
        contacts, trial, motion = self.contacts, swung.trial, swung.motion
        lasts, travel = trial.end - contacts.now, trial.travel
        # integral of y over the time of the step
        moved = motion.centre * lasts + 0.5 * motion.drift * lasts**2
        moved += float(motion.departure_integral(lasts))
        rate = self.spring * self._drive_speed
        pulled = (self._swings.pull + contacts.force) * lasts + 0.5 * rate * lasts**2
        given = self._drive_speed * (pulled - self.spring * moved)
        damped = self.damping * float(motion.squared_speed(lasts))
        stiff = contacts.holding
        left = trial.force - contacts.force - stiff * travel
        on_contacts = contacts.force * travel + 0.5 * stiff * travel**2
        on_contacts += left * (travel - moved / lasts)
        return Spent(given, damped, on_contacts)

    def _energies_of_crept(self, trial: Trial) -> Spent:
        """The same on a step in balance, on which speed and forces change evenly."""
        contacts, lasts = self.contacts, trial.end - self.contacts.now
        before = self._swings.pull + contacts.force
        after = before + self.spring * (self._drive_speed * lasts - trial.travel)
        given = 0.5 * self._drive_speed * lasts * (before + after)
        on_contacts = 0.5 * (contacts.force + trial.force) * trial.travel
        return Spent(given, self.damping * trial.travel**2 / lasts, on_contacts)

    def _take(
        self,
        leg: int,
        trial: Trial,
        size: float,
        speed: float,
        energies: Spent,
    ) -> None:
        """Take a step, at whose end the slider has this speed and on which these energies were given and taken."""
        contacts, nodes = self.contacts, self.sections[-1]
        taken, breaks = max(size, 0.0), contacts.past_breaks.total
        contacts.past_breaks.check_none_is_passed(trial.end)
        contacts.take(trial, taken)
        given, damped, on_contacts = energies
        self._work, self._damped = self._work + given, self._damped + damped
        self._on_contacts += on_contacts
        self._swings.speed = speed
        if not np.isfinite(contacts.position):
            raise StoppedError(f"the motion is lost at t = {contacts.now:.6g}")
        nodes.append(self._node(nodes[-1].sizes_so_far + taken, speed))
        before, after = nodes[-2:]
        earlier = self._broken_before
        self._watch(leg, before, after, (earlier + breaks, earlier + contacts.past_breaks.total))
        self._way = [*self._way, after] if speed else [after]

    def _watch(
        self, leg: int, before: HeavyNode, after: HeavyNode, broken: tuple[float, float]
    ) -> None:
        """Look for falls of the spring's force between two nodes, with the breaks per contact up to each."""
        begin, end = (
            StepEnd(one.time, one.position, one.speed, one.holding) for one in (before, after)
        )
        self.falls.watch(leg, begin, end, broken)

    def _slides_on(self, leg: int) -> bool:
        """Whether the slider slides on steadily from here; if so it has, as far as that is known."""
        contacts, motion, sliding = self.contacts, self.motion, self._sliding
        if sliding is None or motion is None or leg < motion.speeds.size - 1:
            return False
        slid = sliding.slide(self._way, contacts)
        if slid is None:
            return False
        before = self._broken_before + contacts.past_breaks.total
        for k, (one, after) in enumerate(pairwise(slid.nodes)):
            broken = before + slid.breaks[k], before + slid.breaks[k + 1]
            self._watch(leg, one, after, broken)
        last, self._broken_before = slid.nodes[-1], before + float(slid.breaks[-1])
        contacts.unresolved.note(OF_CREEP, slid.error, contacts.now)
        step = self._size * self._swings.length
        contacts.slide_to(last.position, last.time, last.speed, step, sliding.life)
        self._work, self._damped, self._on_contacts = last.work, last.damped, last.on_contacts
        self.sections.append(slid.nodes)
        self.slides.append(slid)
        self._swings.speed, self._is_slow, self._way = last.speed, False, []
        sliding.begin_section()
        return True

    def _node(self, sizes_so_far: float, speed: float) -> HeavyNode:
        """The end of the step just taken, with this speed of the slider."""
        state = self.contacts
        stored = state.groups.stored(state.memory)
        return HeavyNode(
            sizes_so_far,
            state.now,
            state.force,
            state.holding,
            state.position,
            speed,
            self._work,
            self._damped,
            self._on_contacts,
            stored,
        )
