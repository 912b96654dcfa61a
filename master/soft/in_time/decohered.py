"""Decohered contacts: those to which a long slip leads under "instant", whatever they were at its begin.

A slip takes no time, so that no law in time acts in it: contacts break at the thresholds they had at its begin, or at
those they were born with, and form again at once. Once none that held at its begin is left, F is a mean of its values
over the longest life (renewal equation) and stays within them, and F - F_k falls as e^(-y/X*) with the slider's way y.
On a soft spring that way is a million thresholds. It need not be followed until breaks are steady, for which narrow
laws take hundreds of thresholds: where the spring pulls the slider on as long as F stays within these values, and where
by then nothing is left of F - F_k, stretches are distributed as in steady sliding, by S(x)/<x_s>.

An example: thresholds 1 ± 0.2, K = 0.001, steps of the size 1; the longest life L is 2.2, and the slip 171 long.

    way of the slider   0        2.84          7.70              11.05                171.4
                        |---------|-------------|-----------------|----------...-------|
                        begins    none holds    sure: replaced    rest in one move     balance
    since the last               1.3 L         2.2 L             1.5 L
                                 `add`         `is_sure`         `ends_by_now`        `_error_of_rest` in slip_ends.py

From 2.84 on no contact holds that held at the begin; on the next 2.2 L the force is seen to stay within its values of
the last 1.1 L (`swing`), far below the spring's. At 7.70 all contacts are replaced by those of `start`, as this slip
would make them. In steps of finite size their F is a little off F_k: after 1.5 L it has let go, and the rest of the way
is algebra. Behind the slip the slider goes on with its drive, as contacts bear F_k at any speed, where heat leaves that
nearly as it is (`slid_to_end`).
"""

from functools import cached_property

import numpy as np

from master.motion import Motion
from master.numerics.averages import StretchNodes, stretch_nodes
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.creep import Crept
from master.soft.in_time.steps import Node
from master.steady.cycle import Cycle
from master.steady.kinetic import kinetic_curve
from master.steady.response import has_response, is_stable
from master.stick_slip.roots import decoherence_length
from master.survival.life import ColdLife
from origins import Contacts, Drive
from origins.start import Start
from origins.thresholds.law import Thresholds

# Share of the contacts that live longer than the longest life: what so few add to F is below the margin.
LONGER_LIVED = 1e-9
# Margin between the spring's force and the largest force, in mean thresholds; and what may be left of F - F_k.
MARGIN, REMAINING = 1e-6, 1e-12
# Ways, in longest lives: along which F is compared; and that the slider must have gone since none is left, and must
# have before it.
COMPARED_ALONG, UNDISTURBED = 1.1, 2.2
# The way of a slip behind this, in longest lives: more than those along which F is compared.
AFTER = 1.5
# The first mode may be hidden by this factor in the range of F (as in soft/moves.py).
HIDDEN = 100.0
# Part of the tolerance by which heat may change F_k at the speed of a drive that is then slid with at once.
OF_HEAT = 0.1


class SlipSoFar:
    """A slip under "instant" up to the end of its last step. All is counted along the motion, the way the spring pulls:
    travels and forces of a slip backward are positive, too.

    travelled, forces : the slider's way since the begin of the slip, and F, at the end of each step (lengths)
    load : the spring's force there (a length)
    none_holds_since : the travel at which the last contact that held at its begin had broken; inf before
    decohered_since : the way at which all contacts were replaced by those of Decohered; inf before
    """

    def __init__(self, contacts: ContactsInSteps, sign: float) -> None:
        """At its begin. `sign`: of the motion, as in Steps."""
        self._sign, self._began_at = sign, contacts.position
        # a contact that held at the begin is stretched by the way plus this at least
        self._least_stretch = min(float((sign * contacts.groups.stretch).min()), 0.0)
        self.travelled, self.forces = list[float](), list[float]()
        self.load = np.nan
        self.none_holds_since = self.decohered_since = np.inf

    def add(self, contacts: ContactsInSteps, pull: float) -> None:
        """A step was taken, at whose end the spring pulls by so much more than the contacts (a length)."""
        distance = abs(contacts.position - self._began_at)
        self.travelled.append(distance)
        self.forces.append(self._sign * contacts.force)
        self.load = pull + self.forces[-1]
        longest_stretch = float((self._sign * contacts.groups.stretch).max())
        if longest_stretch < distance + self._least_stretch:
            self.none_holds_since = min(self.none_holds_since, distance)


class SteadyStretches(Start):
    """The stretches of contacts in steady sliding at T = 0, of the density S(x)/<x_s>."""

    def __init__(self, law: Thresholds) -> None:
        super().__init__(
            0.5 * law.moment(2) / law.mean(), (0.0, longest_life(law)), law.breakpoints
        )
        self.pdf = lambda x: np.asarray(law.sf(x)) / law.mean()


class Decohered:
    """What a long slip of these contacts leads to; asked for after each of its steps.

    start : nodes for the stretches of all contacts then
    life : the longest life, on which all but LONGER_LIVED break (a length)
    distance_after : the slider's travel in steps from then on, on which F gets near to its limit in such steps; the
        rest of the slip is one move
    """

    def __init__(self, contacts: Contacts, spring: float, nodes: int, tolerance: float) -> None:
        law, self._contacts, self._tolerance = contacts.thresholds, contacts, tolerance
        self._cold, self._spring = Contacts(law, stiffness=contacts.stiffness), spring
        self._unit, self.life = law.mean(), longest_life(law)
        self.distance_after, self._nodes = AFTER * self.life, nodes

    @cached_property
    def start(self) -> StretchNodes:
        """See the class; made for the first slip that is so long."""
        return stretch_nodes(SteadyStretches(self._cold.thresholds), self.life, self._nodes)

    @cached_property
    def _length(self) -> float:
        """X*, not too short by its error (a length); inf where F does not tend to F_k as an exponential."""
        length, error = decoherence_length(self._cycle)
        return length + error

    @cached_property
    def _cycle(self) -> Cycle:
        return Cycle(self._cold, ColdLife(self._cold), 1.0)

    @cached_property
    def _steady_force(self) -> float:
        """F_k of contacts without heat, which those decohered contacts bear (a length)."""
        return self._cycle.force()[0]

    def swing(self, slip: SlipSoFar) -> float:
        """By how much F changed along the last life (a length), by those at the ends of steps."""
        distance = slip.travelled[-1] - COMPARED_ALONG * self.life
        return float(np.ptp(slip.forces[int(np.searchsorted(slip.travelled, distance)) :]))

    def ends_by_now(self, slip: SlipSoFar) -> bool:
        """Whether a slip has gone on for long enough since its contacts were replaced by these."""
        return slip.travelled[-1] - slip.decohered_since >= self.distance_after

    def is_sure(self, slip: SlipSoFar) -> bool:
        """Whether this slip is sure to go on until the contacts are such, by the argument at the head."""
        now, needed = slip.travelled[-1], UNDISTURBED * self.life
        if now - slip.none_holds_since < needed:
            return False
        swing = self.swing(slip)
        # F was no larger than now by more than a swing, and between the ends of steps by no more than another. Contacts
        # that have decohered bear F_k, which may be above F in steps: if the spring bears less the slip ends at once.
        most = max(slip.forces[-1], self._steady_force) + 2.0 * swing + MARGIN * self._unit
        ahead = (slip.load - most) / self._spring
        if ahead <= needed:
            return False
        return HIDDEN * swing * np.exp(-ahead / self._length) <= REMAINING * self._unit

    def slid_to_end(self, begin: Node, motion: Motion, until: float) -> Crept | None:
        """How the slider goes on from a slip that left such contacts, on the last leg of its drive: with the drive at
        once, where heat changes F_k by next to nothing at its speed, and so by less at all above it, and where steady
        sliding is stable there. None elsewhere. In steps of finite size F is a little off F_k, and the slider would
        seek it in a hundred small slips. `until`: reading of time.monotonic() after which StoppedError comes."""
        speed, sign = abs(float(motion.speeds[-1])), float(np.sign(motion.speeds[-1]))
        if not has_response(self._contacts) or self._contacts.changing is not None or not speed:
            return None
        curve = kinetic_curve(self._contacts, np.array([speed]))
        force, missed = float(curve.force[0]), float(curve.force_error[0]) * self._unit
        error = abs(self._steady_force - force) + missed
        if not error <= OF_HEAT * self._tolerance * self._unit:
            return None
        if not is_stable(self._contacts, speed, self._spring, until):
            return None
        ends = np.array([begin.time, motion.times[-1]])
        position = motion.at(ends) - sign * force / self._spring
        rows = zip((0.0, 1.0), ends.tolist(), position.tolist(), strict=True)
        nodes = [Node(size, time, sign * force, 1.0, place) for size, time, place in rows]
        # breaks may have seemed steady before they were
        return Crept([nodes], error + abs(sign * begin.force - force), begin.time)


def longest_life(law: Thresholds) -> float:
    """The way on which all but LONGER_LIVED of the contacts break (a length)."""
    return min(float(law.support()[1]), float(law.isf(LONGER_LIVED)))


def decohered(contacts: Contacts, drive: Drive, nodes: int, tolerance: float) -> Decohered | None:
    """What a long slip leads to under "instant", by so many nodes. None under other rules, with a delay, where
    thresholds change as contacts form, by a law of one's own, or have grown at X = 0, where contacts form again
    stretched or break as in the closure "paper"; and for laws with exact thresholds, whose order may last, or without a
    steady force."""
    law, thermal = contacts.thresholds, contacts.thermal
    paper = thermal is not None and thermal.closure == "paper"
    fresh = contacts.changing is None or contacts.changing.begins_as_start
    stays = fresh and contacts.reforming is None and not paper
    if drive.slip != "instant" or contacts.delay is not None:
        return None
    if not stays or law.atoms[0].size or not np.isfinite(law.moment(3)):
        return None
    return Decohered(contacts, float(drive.spring or 0.0), nodes, tolerance)
