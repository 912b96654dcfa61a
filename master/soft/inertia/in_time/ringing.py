"""Ringing without steps: a slider that has come to rest swings on contacts of which none breaks any more.

Where contacts break by their stretch alone, and grow no weaker, as those of long_slips.py, those that hold have been
stretched as far as they are in a swing that is inside the swings before. The slider is then a damped oscillator in
closed form, on the spring of a machine for some thousand swings:

    M y'' + γ y' + (K + κ) y = K (X_T - X_0) - F_0,    F = F_0 + κ y,    κ the stiffness of those that hold.

Whether a swing is inside those before is asked of the contacts: they are moved to both ends of all swings to come, and
what breaks there counts as an error, or as too much.
"""

from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.inertia.body import QUIET
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.oscillation import Held, Oscillation, Pulled
from origins.drive import RISE, Drive
from origins.thresholds.law import Array

# Part of the tolerance that contacts may bear which break in the swings.
ALLOWED = 0.05
# Largest swing of the spring's force that is told without steps, as a part of the least fall that is a slip.
SMALL = 0.25
# Fewest periods for which it is worth it.
WORTH = 3.0


class Ring(NamedTuple):
    """Swings of the slider from a turn on; see the head of the file.

    begin : the slider at the turn; motion : y(t) since then; lasts : time until it is at rest, or the drive's leg ends
    pulled, held : by the spring, and by contacts of the stiffness κ
    broken : force of contacts that would break, and form again (a length)
    """

    begin: HeavyNode
    motion: Oscillation
    lasts: float
    pulled: Pulled
    held: Held
    broken: float

    def columns(self, times: Array) -> Array:
        """The columns of a node behind its time, at these times of the path, shape (columns, n)."""
        of, t = self.motion, times - self.begin.time
        y, begin = of.travel(t), self.begin
        spent = of.spent(t, y, self.pulled, self.held)
        return np.stack(
            [
                begin.force + self.held.holding * y,
                np.full(t.size, begin.holding),
                begin.position + y,
                of.speed(t),
                *begin.spent.plus(spent),
                begin.stored + spent.on_contacts,
            ]
        )


class Ringing:
    """Swings of a slider on these contacts that are told without steps."""

    def __init__(self, drive: Drive, motion: Motion, tolerance: float, unit: float) -> None:
        """On a drive of one speed. tolerance : of the force; unit : the mean threshold (lengths)."""
        self._motion, self._tolerance = motion, tolerance
        self._quiet, self._small = QUIET * tolerance, SMALL * RISE * unit
        self._mass, self._damping = float(drive.mass or 0.0), drive.damping
        self._spring = float(drive.spring or 0.0)

    def ahead(
        self, leg: int, end: float, contacts: ContactsInSteps, begin: HeavyNode
    ) -> Ring | None:
        """The swings from this turn on, until the slider is at rest or the time `end`; None where contacts break on
        them, or where they are not worth it."""
        speed, stiff, spring = float(self._motion.speeds[leg]), contacts.holding, self._spring
        drive = float(self._motion.at(np.array(begin.time)))
        pulled = Pulled(spring, self._damping, speed, spring * (drive - begin.position))
        pull, all_stiff = pulled.force - begin.force, spring + stiff
        of_motion = self._mass, self._damping, all_stiff, pull, spring * speed, 0.0, begin.speed
        motion = Oscillation.of(*of_motion)
        if not motion.swings or 2.0 * spring * motion.size > self._small:
            return None
        lasts = min(motion.time_until(self._quiet / all_stiff), end - begin.time)
        if not lasts > WORTH * motion.period:
            return None
        broken = self._broken(contacts, motion, lasts)
        if broken > ALLOWED * self._tolerance:
            return None
        return Ring(begin, motion, lasts, pulled, Held(stiff, begin.force), broken)

    def _broken(self, contacts: ContactsInSteps, motion: Oscillation, lasts: float) -> float:
        """The force that contacts may bear which break in the swings (a length). The upper end of a swing is a convex
        function of the time, so that the farthest is the first or the last one; the same holds below."""
        memory, before = contacts.memory, contacts.groups
        balance = motion.centre + motion.drift * np.array([0.0, lasts])
        size = np.array([motion.size, motion.bound(lasts)])
        low, high = float((balance - size).min()), float((balance + size).max())
        after = before.moved(memory, low, 0.0).moved(memory, high - low, 0.0)
        holds = before.survival_and_force(memory)[0]
        still = after.survival_and_force(memory)[0]
        return float((after.largest * (holds - still)) @ before.weight)


def with_rings(columns: Array, rings: list[Ring], times: Array) -> Array:
    """These columns of nodes behind their times (columns, n) at these times, with those of swings where there are
    such."""
    for ring in rings:
        inside = (times > ring.begin.time) & (times < ring.begin.time + ring.lasts)
        if inside.any():
            columns[:, inside] = ring.columns(times[inside])
    return columns
