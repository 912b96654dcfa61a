"""The pace of contacts that age under "instant": where no answer will come, that is told after few steps.

They creep before a slip, and after a long one, and the pace of steps falls: with thresholds 1 ± 0.2 that tend to 1.2 ±
0.1 by D = 1e-3, on K = 1e-6, steps 100 to 200 after the slip lead the drive on by 1,500, steps 1,900 to 2,000 by 800.
All were taken until none was left, for 3 to 20 s.

Right behind a long slip F is that of fresh contacts, and falls at once, by what a step's error is, as time begins to
pass again: in cells of thresholds it jumps. Where times are long beside that of such a step, as on soft springs, slip
after slip begins within rounding of the time.
"""

import numpy as np

from master.motion import Motion
from master.outcome import StoppedError
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.steps import Node
from origins.drive import Drive

# Steps of a section after which its pace is looked at, again and again; and that of the last ones, which tell it.
LOOKED_AT, LAST = 50, 100
# Of the way that is left, what the steps that are left have to lead to at this pace: twice as fast may still do.
REACHED = 0.5
# Last digits of the time within which no section ends, and how many that do are taken: of 24 random machines those with
# an answer, at 1e-3, had 4 at most, and of all others that slip some without end.
NO_TIME, TAKEN = 1e3, 5
# Slips in a row in which F falls by less than this part of the largest fall: of 62 random machines six had dozens of
# such and no answer after 25 s, and those with an answer had three slips at most.
IN_A_ROW, SMALL = 20, 0.01


class Pace:
    """The pace of these contacts on this drive, whose motion is `motion`; nothing is stopped of others."""

    def __init__(self, contacts: ContactsInSteps, drive: Drive, motion: Motion | None) -> None:
        self._contacts = contacts
        self._looks = drive.slip == "instant" and contacts.memory.error_of_slips > 0.0
        # in a hold, or from one leg to the next, the pace may grow
        one_leg = motion is not None and motion.speeds.size == 1
        self._foresees = self._looks and one_leg and contacts.halvings == 0

    def after_step(self, nodes: list[Node], end: float) -> None:
        """StoppedError where the steps that are left would lead less than halfway to the time `end`, at the pace of the
        last of these nodes of a section."""
        if not self._foresees or len(nodes) % LOOKED_AT or len(nodes) < 2 * LAST:
            return
        contacts, gained = self._contacts, nodes[-1].time - nodes[-LAST].time
        leads = gained * (contacts.most_steps - contacts.cost) / LAST
        if leads < REACHED * (end - contacts.now):
            fault = f"the last {LAST} steps lead on by {gained:.3g} only: at this pace the {contacts.most_steps:.0f}"
            raise StoppedError(
                f"{fault} that are taken lead to a time of some {contacts.now + leads:.3g}"
            )

    def at_slip(self, sections: list[list[Node]], drops: list[float]) -> None:
        """StoppedError where many of these sections, each of which ended in a slip, take next to no time; and where
        small slips follow each other: in the listed ones, in order, F falls by these `drops` (lengths)."""
        now = sections[-1][-1].time
        least = NO_TIME * float(np.spacing(now))
        short = sum(each[-1].time - each[0].time < least for each in sections)
        last, as_steps = drops[-IN_A_ROW:], "as of contacts that age steps tell F to some 1e-3 only"
        if self._looks and short > TAKEN:
            fault = (
                f"slip after slip begins within rounding of the time, by t = {now:.6g}, {as_steps}"
            )
            raise StoppedError(f'{fault}; take slip = "reset"')
        if self._looks and len(last) == IN_A_ROW and max(last) < SMALL * max(drops):
            fault = f"behind a slip {IN_A_ROW} small ones follow by t = {now:.6g}, {as_steps}"
            raise StoppedError(f'{fault}; take slip = "reset"')
