"""A soft slider along its whole path, K (X_T - X) = F, step by step and slip after slip."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.outcome import FaultError, StoppedError
from master.soft.in_time.contacts import MOST_STEPS, ContactsInSteps
from master.soft.in_time.creep import Creep
from master.soft.in_time.decohered import Decohered
from master.soft.in_time.groups import UNACCOUNTED
from master.soft.in_time.slip_begins import SlipBegins
from master.soft.in_time.slip_ends import slip_with_births, slip_without_births
from master.soft.in_time.steps import Node, Steps
from master.soft.in_time.unresolved import OF_BEND, OF_CREEP, OF_DELAY, OF_SMALL_SLIPS
from origins.drive import Drive

# A slip in which F falls by this part of the largest force at a slip so far is a large one: the drive then loads the
# spring anew, so that the time up to the next one tells of those to come. Few contacts that come back after a delay
# slip soon and by little.
LARGE = 0.1
# Least size of a step before the end of a section, in steps: rounding of times would make it 0.
SHORTEST = 1e-6
# Of a step's size, by which rounding of its times may put it below 0. Of a size further below 0 the state at its end
# would be left out where forces are read (answer/reading.py).
ROUNDED_SIZE = 1e-6
# Ends of steps through which a curved line goes (answer/reading.py). On fewer a straight one is drawn: where the time
# is a parabola of the size, as up to a slip, F is off by a quarter of its change, or twice that where F bends, too.
OF_CURVE, OFF_STRAIGHT = 4, 0.5


class Slip(NamedTuple):
    """A slip: its time, K X_T, and F before and after it (lengths)."""

    time: float
    load: float
    force_before: float
    force_after: float


class Slider:
    """The solution along the whole path, with steps of 2^-halvings of the coarsest.

    motion, spring : of the drive, None where it does not move; and K/(N_c <k>)
    sections : nodes of each smooth section
    needed : halvings without which the tolerance is not met
    least_drop : change of F (a length) below which a slip is not listed, but counted as an error of F. After a slip the
        first contacts that come back hold a soft spring for a moment, and slip: how often depends on where steps end
    creep : how the slider goes on without steps once its speed changes slowly; None where that is not known
    creeps_from : the time from which on it goes on so; None where it never does
    steady_from : that from which on F is that of steady sliding at the drive's speed, inf where none is known
    decohered : what a long slip under "instant" leads to; None where that is not known
    slips : in order
    """

    def __init__(
        self,
        contacts: ContactsInSteps,
        drive: Drive,
        motion: Motion | None,
        needed: int,
        least_drop: float,
        decohered: Decohered | None = None,
        creep: Creep | None = None,
    ) -> None:
        """Before the first step; `run` takes all of them."""
        self.contacts, self.motion, self._least_drop = contacts, motion, least_drop
        self._decohered, self._creep = decohered, creep
        self.creeps_from: float | None = None
        self.steady_from = np.inf
        self._halvings_to_come = max(needed - contacts.halvings, 0)
        self._rule, self.spring = drive.slip, float(drive.spring or 0.0)
        self._size = 0.5**contacts.halvings  # of a step
        # share of the contacts of which it is unknown whether they are out as a slip begins; and the error of F by that
        # (a length), the largest of all slips
        self._unknown_out = self._error_of_delay = 0.0
        self._has_decohered = False  # whether the last slip was so long
        self.sections = list[list[Node]]()
        # the sections of this leg from where all contacts were new to a slip that left all contacts new again
        self._stick_and_slip = list[list[Node]]()
        self.slips = list[Slip]()

    def run(self) -> None:
        """Follow the drive to its end, leg by leg; sections of a leg end where births jump, and at slips."""
        contacts, motion = self.contacts, self.motion
        if motion is None:
            self.sections.append([self.node_now(0.0)])
            return
        self._steps = Steps(contacts, self.spring, motion)
        self._search = SlipBegins(self._steps)
        for leg, last in enumerate(motion.times[1:].tolist()):
            contacts.past_breaks.repeat_bend(float(motion.times[leg]))
            self._stick_and_slip = []
            # the section at whose begin all contacts were new; None after a slip that did not leave all new
            new_since: int | None = None
            while True:
                self._repeat_while_new(last)
                if contacts.are_new:
                    new_since = len(self.sections)
                end = min([*contacts.past_breaks.pending, last])
                self.begin_section(leg, end)
                if self.slide(end):
                    self.slip(self._drive_position())
                    self._stop_if_too_many_steps(last)
                    self.remember_if_new(new_since)
                    new_since = None
                elif end < last:
                    contacts.form_due()
                else:
                    break

    def begin_section(self, leg: int, end: float) -> None:
        """Begin a section, along which all is smooth up to `end` or to a slip.

        At its begin the motion, breaks or births jump or bend: no polynomial may lead across, nor may the next step be
        guessed from the last one. So all who keep steps for that begin a new list here, at the present time.
        """
        self.sections.append([self.node_now(0.0)])
        self._steps.begin_section(leg, end)  # time units are counted from now
        self._search.begin_section()  # no slip is foreseen yet
        if self._creep is not None:
            self._creep.begin_section()
        self.contacts.past_breaks.begin_section()  # no polynomial leads across

    def slide(self, end: float) -> bool:
        """Take steps of the section just begun until `end`, or until a slip begins; returns whether one does."""
        contacts, steps, search = self.contacts, self._steps, self._search
        nodes, slips = self.sections[-1], False
        while not slips and contacts.now < end and not self._crept_to_end(nodes):
            size = min(self._size * search.shrink, max(steps.longest(), SHORTEST * self._size))
            trial, slips = search.up_to_slip(size)
            if trial.travel or trial.end > contacts.now:
                taken = steps.size(trial)
                if taken < -ROUNDED_SIZE * self._size:
                    raise FaultError(
                        f"the step from t = {contacts.now:.6g} to {trial.end:.6g} has the size {taken:.3g}: it "
                        "leads against the motion, a fault of the program"
                    )
                taken = max(taken, 0.0)
                contacts.past_breaks.check_none_is_passed(trial.end)
                imbalance = steps.imbalance(trial)
                contacts.take(trial, taken)
                nodes.append(self.node_now(nodes[-1].sizes_so_far + taken))
                steps.check_balance("a step", imbalance, nodes[-1])
        if slips and contacts.delay:
            self._bound_error_of_delay(nodes)
        if slips and len(nodes) < OF_CURVE and self._begins_at_bend(nodes):
            change = max(abs(after.force - node.force) for node, after in pairwise(nodes))
            contacts.unresolved.note(OF_BEND, OFF_STRAIGHT * change, contacts.now)
        return slips

    def _begins_at_bend(self, nodes: list[Node]) -> bool:
        """Whether a section of these nodes begins where the drive changes its speed or turns."""
        return self.motion is not None and nodes[0].time in self.motion.times[1:]

    def _crept_to_end(self, nodes: list[Node]) -> bool:
        """Let the slider creep steadily from the last of these nodes of a section to the end of the path, if it does
        so; whether it did. Then it is at the end, and no steps are left to take."""
        contacts, creep, motion = self.contacts, self._creep, self.motion
        if motion is None or nodes[0].time < motion.times[-2]:
            return False
        crept = None
        if self._decohered and self._has_decohered and len(nodes) == 1:
            crept = self._decohered.slid_to_end(nodes[0], motion, contacts.until)
        if crept is None and creep is not None:
            crept = creep.from_here(nodes, contacts.most_steps - contacts.cost)
        if crept is None:
            return False
        self.creeps_from, self.steady_from = contacts.now, crept.steady_from
        contacts.unresolved.note(OF_CREEP, crept.error, contacts.now)
        self.sections += crept.sections
        end = crept.sections[-1][-1]
        contacts.now, contacts.force, contacts.position = end.time, end.force, end.position
        return True

    def _bound_error_of_delay(self, nodes: list[Node]) -> None:
        """Bound the error of F as a slip begins, at the last of these nodes, where steps are longer than the delay.

        Such a step takes the rate of breaks as constant, while breaks come ever faster towards a slip: a fraction of
        the births up to its begin is counted too early. The cubics through all breaks up to there tell how many have
        really been born. The others are still out, and pull nothing; counted as born they pull by the travel since the
        last step that ended a delay before, at most.
        """
        contacts = self.contacts
        past, now = contacts.past_breaks, contacts.now
        counted = contacts.holding - 1.0 + past.total
        fraction = abs(counted - past.births_up_to(begin=now, end=now).rest)
        before = next((node for node in reversed(nodes) if node.time <= now - past.delay), nodes[0])
        self._unknown_out = fraction
        error = fraction * abs(contacts.position - before.position)
        self._error_of_delay = max(self._error_of_delay, error)

    def _bound_error_of_delay_after_slip(self) -> None:
        """Bound the error of F by the same contacts after a slip without births.

        If they held as it began, those that still hold pull by a mean threshold at most. Where no contact holds, those
        that come back before the others may pull the slider alone, with the force that the spring gains in a delay.
        """
        contacts, motion, delay = self.contacts, self.motion, self.contacts.delay
        assert motion is not None
        error = self._unknown_out * contacts.unit
        if not contacts.holding:
            distance = float(np.ptp(motion.at(np.array([contacts.now, contacts.now + delay]))))
            error = min(error, self.spring * distance)
        self._error_of_delay = max(self._error_of_delay, error)

    def remember_if_new(self, new_since: int | None) -> None:
        """Keep the sections since all contacts were new, where the slip at their end has left all of them new again."""
        if new_since is not None and self.contacts.are_new:
            self._stick_and_slip = self.sections[new_since:]

    def _repeat_while_new(self, end: float) -> None:
        """While all contacts are new, and slip before `end`, let them stick and slip as they did before on this leg."""
        contacts, cycle = self.contacts, self._stick_and_slip
        if not (cycle and contacts.are_new):
            return
        begin, slip = cycle[0][0], cycle[-1][-1]
        if abs(begin.force - contacts.force) > UNACCOUNTED * contacts.unit:
            raise FaultError(
                f"what is repeated from t = {contacts.now:.6g} on began with F = {begin.force:.6g}, but new contacts "
                f"have F = {contacts.force:.6g}, a fault of the program"
            )
        steps = sum(len(section) - 1 for section in cycle)
        while slip.time + contacts.now - begin.time < end:
            here = self.node_now(0.0)
            later, farther = here.time - begin.time, here.position - begin.position
            for section in cycle:
                self.sections.append([node.shifted(later, farther) for node in section])
            contacts.repeat(steps, self.sections[-1][-1].time)  # which leaves all of them new
            contacts.position = self._drive_position() - contacts.force / self.spring
            self._list_slip(slip.force)

    def _stop_if_too_many_steps(self, end: float) -> None:
        """StoppedError where slips up to a time would take too many steps, if each takes as many as the last one."""
        contacts, two = self.contacts, self.slips[-2:]
        # of slips back F is below 0, and rises
        least = LARGE * max((abs(slip.force_before) for slip in self.slips), default=0.0)
        large = [slip for slip in two if abs(slip.force_before - slip.force_after) > least]
        if len(large) < 2 or two[-1].time < contacts.now:
            return
        began = two[0].time
        count = sum(len(section) - 1 for section in self.sections if section[0].time >= began)
        most = MOST_STEPS * 0.5**self._halvings_to_come
        last = contacts.now + (contacts.now - began) * (most - contacts.cost) / count
        if last < end:
            steps = "1 step" if count == 1 else f"{count} steps"
            fault = f"a slip takes {steps}, and the {most:.0f} that are taken on at this tolerance"
            ends = f"the last slips begin at {began:.6g} and {two[1].time:.6g}"
            raise StoppedError(f"{fault} lead to a time of some {last:.3g} only; {ends}")

    def _drive_position(self) -> float:
        """Where the drive is now (a length)."""
        assert self.motion is not None
        return float(self.motion.at(np.array(self.contacts.now)))

    def node_now(self, sizes_so_far: float) -> Node:
        state = self.contacts
        breaks = state.past_breaks.total
        return Node(sizes_so_far, state.now, state.force, state.holding, state.position, breaks)

    def slip(self, drive_position: float) -> None:
        """Let the slider slip while the drive holds at this position, by its rule:

        rule            without a delay                    with a delay
        "reset"         all contacts are new               the same, those that are out, too
        "reform-after"  without births                     without births
        "instant"       broken contacts form again in it   without births: a slip takes no time, a delay does
        """
        contacts, force = self.contacts, self.contacts.force
        if self._rule == "reset":
            contacts.relax()
            # relax has changed the force; X follows: the slider stops where the spring balances the new contacts
            contacts.position = drive_position - contacts.force / self.spring
            self._steps.check_balance("a slip", 0.0, self.node_now(0.0))
        elif self._rule == "reform-after" or contacts.delay > 0.0:
            slip_without_births(contacts, self._steps)
            self._bound_error_of_delay_after_slip()
        else:
            size, decohered = self._size, self._decohered
            self._has_decohered = slip_with_births(contacts, self._steps, size, decohered)
        self._list_slip(force)

    def _list_slip(self, before: float) -> None:
        """List the slip that ends now, if F changed by enough from what it was before."""
        contacts, load = self.contacts, self.spring * self._drive_position()
        drop = abs(before - contacts.force)
        if drop < self._least_drop:
            contacts.unresolved.note(OF_SMALL_SLIPS, drop, contacts.now)
        else:
            self.slips.append(Slip(contacts.now, load, before, contacts.force))
        # the error of one slip delays the next, so that errors add up
        error = contacts.memory.safety * self._error_of_delay * len(self.slips)
        contacts.unresolved.note(OF_DELAY, error, contacts.now)
