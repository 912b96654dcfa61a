"""Breaks so far, B, which are the births to come, J: contacts that break are born one delay later, J(t) = B(t - delay).

An example, whose numbers a test holds: the delay is 0.25; B jumps at t = 1, in a slip, from 0.3 to 0.5, and J repeats
the jump at t = 1.25. `births_up_to` says which breaks are read for J beside it.

    0.7 |                                            BBBBB
    0.6 |                                    BBBBBBBBJJJJJ
    0.5 |                                BBBB    JJJJ
    0.4 |                                |       |              Sections, along each of which breaks are smooth:
    0.3 |                            BBBB    JJJJ               0, up to the slip
    0.2 |                    BBBBBBBBJJJJJJJJ                   1, the slip, which takes no time
    0.1 |          BBBBBBBBBBJJJJJJJJ                           2, behind it
    0.0 |BBBBBBBBBBJJJJJJJJ
      t +-------+-------+-------+-------+-------+-------+
        0       0.25    0.5     0.75    1       1.25    1.5
"""

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.numerics.polynomials import polynomial_through
from master.outcome import FaultError

# Nodes of the polynomials through past breaks, of a higher order than the steps, which are of second order.
NODES = 4
# A step that is this small beside the one before adds no node: polynomials through both ends would magnify rounding.
NEARBY = 1e-3
# Part of the time by which rounding may put a time on the path beside another; and that of breaks, a share of the
# contacts.
ROUNDED_TIME, ROUNDED_BREAKS = 1e-12, 1e-9
# Ends of steps on either side of a time, between whose breaks births lie that are read back there.
AROUND = 2
# Part of what values change by on the nodes of a polynomial, by which rounding may put it beside them: steps may be
# NEARBY times as long as others.
BESIDE_NODES = 1e-3


class StepEnd(NamedTuple):
    """The end of a step: its time, the breaks up to there, and the sizes of its section's steps up to there."""

    time: float
    breaks: float
    sizes_so_far: float


class BirthsUpTo(NamedTuple):
    """Births per contact up to the end of a step, J = per_break B + rest, with B the breaks up to there:

    step                       | per_break | rest              | births in it are those of
    no delay                   | 1         | 0                 | its own breaks
    delay longer than the step | 0         | B(end - delay)    | past breaks
    delay shorter than it      | part p    | (1 - p) B(begin)  | past breaks, and a part p of its own
    none form                  | 0         | J(begin)          | none, see ContactsInSteps.trial
    """

    per_break: float
    rest: float


class Jump(NamedTuple):
    """Breaks that jumped.

    section : that of no time in which they did
    at, due_at : when they did, and when births repeat it (times)
    behind : index of its own end, of the breaks behind it, among the ends of all steps
    """

    section: int
    at: float
    due_at: float
    behind: int


class BreaksInSteps:
    """Breaks per contact since t = 0 or a reset, at the ends of steps.

    delay : time for which a broken contact is out
    pending : times at which the rate of births will change abruptly, and the fraction that is born at once there: above
        0 where breaks jumped a delay before, 0 where their rate did

    _to_repeat, _repeated : jumps, in order, that births are still to repeat; and the last one that they have repeated,
        None before. Between two of them births are those of the breaks between both. Which these are is told by the
        jumps, as times do not tell it to their last digit: a delay may be as short as that.
    """

    def __init__(self, delay: float, now: float) -> None:
        self.delay, self._counted_since = delay, now
        # ends of steps with the breaks up to there, in sections along which breaks are smooth
        self._sections = [[StepEnd(now, 0.0, 0.0)]]
        # all of these once more, in one list: births are checked by what stands around them
        self._times, self._breaks = [now], [0.0]
        self.pending: dict[float, float] = {}
        self._to_repeat = list[Jump]()
        self._repeated: Jump | None = None

    @property
    def total(self) -> float:
        """Breaks up to the end of the last step."""
        return self._sections[-1][-1].breaks

    def add(self, now: float, breaks: float, size: float) -> None:
        """A step of this size ended now, with so many breaks up to its end."""
        section = self._sections[-1]
        sizes_so_far = section[-1].sizes_so_far + size
        if len(section) > 1 and size < NEARBY * (
            section[-1].sizes_so_far - section[-2].sizes_so_far
        ):
            section.pop()
        section.append(StepEnd(now, breaks, sizes_so_far))
        self._times.append(now)
        self._breaks.append(breaks)

    def births_up_to(self, *, begin: float, end: float) -> BirthsUpTo:
        """Births up to the end of a step from `begin`, the end of the last step, to `end`: J(end) = B(end - delay).
        Both are times on the path, whose names are asked for, as no type tells them apart.

        In the example at the head births jump at t = 1.25, when `take_due` is called, and steps may end beside it by
        rounding, here 1e-9; `section` is the index of the one that is read, never that of the jump, 1:

            end                         end - delay  _repeated  broken_at  section  births are the breaks
            1.05                        0.8          None       0.8        0        0.2208, up to t = 0.8
            1.25 + 1e-9, not taken yet  1 + 1e-9     None       1          0        0.3, all before the slip
            1.25 - 1e-9, taken          1 - 1e-9     the jump   1          2        0.5, those in the slip, too
            1.5                         1.25         the jump   1.25       2        0.6, some behind the slip

        They may be less than those told so far, where the last step was longer than the delay and led to a slip: it
        took the rate of breaks as constant, and that rises. No birth is taken back, but behind a slip in which all
        broke (ContactsInSteps.take_back_early_births).
        """
        if not self.delay:
            return BirthsUpTo(1.0, 0.0)
        broken_at = self._broken_at(end)
        if broken_at <= self._counted_since and self._repeated is None:
            return BirthsUpTo(0.0, 0.0)  # none has broken a delay before
        if broken_at > begin:
            # within this step, on which B goes straight from `total`, that at its begin, to that at its end, which is
            # not known yet: B(broken_at) = (1 - fraction) total + fraction B(end)
            fraction = (broken_at - begin) / (end - begin)
            return BirthsUpTo(fraction, (1.0 - fraction) * self.total)
        return BirthsUpTo(0.0, _breaks_at(self._section_of(broken_at), broken_at))

    def _broken_at(self, end: float) -> float:
        """When those broke that are born last up to the time `end`: one delay before. Rounding puts that across no
        jump: it is not before a jump that births have repeated, nor after one that they are still to repeat."""
        earliest = self._repeated.at if self._repeated else -np.inf
        latest = self._to_repeat[0].at if self._to_repeat else np.inf
        return min(max(end - self.delay, earliest), latest)

    def _section_of(self, broken_at: float) -> list[StepEnd]:
        """The section of breaks at this time; of two that meet there the later one, if births have repeated the jump
        between them, else the earlier one. FaultError for the jump, and for none."""
        first_to_read = self._repeated.section + 1 if self._repeated else 0
        for section in self._sections[first_to_read:]:
            if section[-1].time >= broken_at:
                if len(section) == 1 or section[0].time < section[-1].time:
                    return section
                break
        raise FaultError(f"no breaks are known at t = {broken_at:.9g}, a fault of the program")

    def begin_section(self) -> None:
        """The rate of breaks, or their sum, may jump at this instant: no polynomial leads across. Called by
        `Slider.begin_section`; and by `slip_without_births` before its step, which takes no time: its breaks are a
        section of their own, whose sum `repeat_jump` reads. In `slip_with_births` nobody asks for past breaks."""
        self._sections.append([self._sections[-1][-1]._replace(sizes_so_far=0.0)])

    def repeat_bend(self, at: float) -> None:
        """The rate of breaks jumps: that of births jumps a delay later, and bends after two. Without a delay births
        follow at once, and nothing is repeated."""
        if self.delay:
            for later in (at + self.delay, at + 2.0 * self.delay):
                self.pending.setdefault(later, 0.0)

    def repeat_jump(self, at: float) -> None:
        """Breaks jumped by those of the last section, which took no time: births repeat it a delay later."""
        before, after = self._sections[-1][0].breaks, self._sections[-1][-1].breaks
        self.repeat_bend(at)
        due_at = at + self.delay
        self._to_repeat.append(Jump(len(self._sections) - 1, at, due_at, len(self._breaks) - 1))
        self.pending[due_at] = self.pending.get(due_at, 0.0) + after - before

    def take_back(self, breaks: float) -> float:
        """Take so many out of the last section, which took no time, but no more than are in it; returns how many."""
        before, after = self._sections[-1][0], self._sections[-1][-1]
        taken = min(max(breaks, 0.0), after.breaks - before.breaks)
        self._sections[-1][-1] = after._replace(breaks=after.breaks - taken)
        self._breaks[-1] -= taken
        return taken

    def check_none_is_passed(self, end: float) -> None:
        """FaultError where a step to the time `end` goes beyond one that is pending, at which its section ends: births
        would stay what they were there, and contacts out for good."""
        due = min(self.pending, default=np.inf)
        if end > due:
            raise FaultError(
                f"a step goes to t = {end:.9g}, beyond t = {due:.9g}, where births jump or bend, a fault of the program"
            )

    def check_births(self, begin: float, now: float, births: float, born: float) -> None:
        """Two faults of births, of which conservation does not tell, as `trial` fits breaks to any births.

        FaultError where `births` up to now are not the breaks one delay before: where they are farther from those at
        the ends of steps around than these are apart. They may be more where none was `born` in the last step, which
        leads from `begin` to now, as an earlier step may have told too many (see births_up_to).

        FaultError where breaks jumped a delay before, amid that step: births should jump at its end.
        """
        if not self.delay:
            return  # births follow at once, but in a slip of "reform-after"
        at, rounded = now - self.delay, ROUNDED_TIME * abs(now)
        first = bisect_left(self._times, at - rounded) - AROUND
        end = bisect_right(self._times, at + rounded) + AROUND
        around = self._breaks[max(first, 0) : end]
        least, most = min(around), max(around)
        beside = most - least + ROUNDED_BREAKS
        if births < least - beside or (born > 0.0 and births > most + beside):
            raise FaultError(
                f"births are not the breaks one delay before: up to t = {now:.9g} they are {births:.9g}, but around "
                f"t = {at:.9g} breaks are {least:.9g} to {most:.9g}, a fault of the program"
            )

        jumped = bisect_right(self._times, begin - self.delay + rounded)
        for i in range(max(jumped, 1), bisect_left(self._times, at - rounded)):
            jump = self._breaks[i] - self._breaks[i - 1]
            if self._times[i] == self._times[i - 1] and jump > ROUNDED_BREAKS:
                raise FaultError(
                    f"births jump amid a step, from t = {begin:.9g} to {now:.9g}, as breaks did by {jump:.6g} "
                    f"at t = {self._times[i]:.9g}, a fault of the program"
                )

    def check_repeated(self, births: float) -> None:
        """FaultError where births up to now are less than the breaks behind the jump that they have just repeated, by
        more than those of the two steps before it: contacts that broke in it would stay out."""
        behind = self._repeated.behind if self._repeated else 0
        before = self._breaks[max(behind - AROUND - 1, 0) : behind]
        if before and births < self._breaks[behind] - (max(before) - min(before)) - ROUNDED_BREAKS:
            raise FaultError(
                f"births do not repeat a jump of breaks: they are {births:.6g}, and breaks behind the slip at "
                f"t = {self._times[behind]:.9g} were {self._breaks[behind]:.6g}, a fault of the program"
            )

    def take_due(self, now: float) -> float:
        """The fraction that is born at once now, which is pending no longer.

        A section ends at each pending time, so that `now` is the earliest of them, to the last digit: what is due now
        has `due_at <= now`, and nothing is overdue. Several jumps may be due together, of slips at one time. From here
        on births are those of the breaks behind these jumps.
        """
        while self._to_repeat and self._to_repeat[0].due_at <= now:
            self._repeated = self._to_repeat.pop(0)
        return sum(self.pending.pop(at) for at in list(self.pending) if at <= now)


def _breaks_at(section: list[StepEnd], time: float) -> float:
    """Breaks up to a time in a section, from cubics of time and breaks over the sizes of steps, in which both are
    smooth. Towards a slip breaks come ever faster, and a cubic of breaks over time swung by a hundredth of all contacts
    there: births were below 0. Where breaks set in, by many orders of magnitude in a step, the cubic of sizes leaves
    what they are at the ends of the step, too, between which they are, as they never fall. The section must not end
    before the time."""
    # the step in which the time is ends here; at the section's begin, 0, it is in none
    step_end = bisect_left(section, time, key=lambda end: end.time)
    first = max(min(step_end - NODES // 2, len(section) - NODES), 0)
    ends = section[first : first + NODES]
    later, breaks = [end.time - time for end in ends], [end.breaks for end in ends]
    is_in_a_step = step_end > 0
    if is_in_a_step and all(a.sizes_so_far < b.sizes_so_far for a, b in pairwise(ends)):
        begin = step_end - 1 - first
        gap = ends[begin + 1].sizes_so_far - ends[begin].sizes_so_far
        # 0 and 1 at the ends of this step
        at = [(end.sizes_so_far - ends[begin].sizes_so_far) / gap for end in ends]
        until, broken = polynomial_through(at, later), polynomial_through(at, breaks)
        _check_nodes(until, later, begin, time)
        _check_nodes(broken, breaks, begin, time)
        if until(0.0) < 0.0 < until(1.0):
            found = broken(float(brentq(until, 0.0, 1.0)))
            return min(max(found, ends[begin].breaks), ends[begin + 1].breaks)
    return float(np.interp(0.0, later, breaks))  # at the end of a step, but for rounding


def _check_nodes(
    polynomial: Callable[[float], float], values: list[float], begin: int, time: float
) -> None:
    """FaultError unless the polynomial, at 0 and 1, is what the values are at the ends of the step from the index
    `begin` on; `time`: at which it will be read."""
    off = max(abs(polynomial(0.0) - values[begin]), abs(polynomial(1.0) - values[begin + 1]))
    if off > BESIDE_NODES * (max(values) - min(values)) + ROUNDED_BREAKS:
        raise FaultError(
            f"the cubic through past steps that is read at t = {time:.9g} misses the ends of the step there by "
            f"{off:.3g}, a fault of the program"
        )
