"""Breaks so far, which are the births to come: a contact that breaks is born again one delay later."""

from bisect import bisect_left
from typing import NamedTuple

from scipy.interpolate import KroghInterpolator

# By this part of the time since the beginning a delay is prolonged, so that births that are due at an instant do not
# come before it by rounding.
LATE = 1e-13
# Nodes of the polynomial through past breaks, of a higher order than the steps, which are of second order.
NODES = 4


class BirthsUpTo(NamedTuple):
    """Births per contact up to the end of a step, as a linear function of the breaks up to there: `per_break` times
    these breaks, and a rest."""

    per_break: float
    rest: float


class BreaksInSteps:
    """Breaks per contact since t = 0 or a reset, at the ends of steps.

    delay : time for which a broken contact is out
    pending : times at which the rate of births will change abruptly, and the fraction that is born at once there: above
        0 where breaks jumped a delay before, 0 where their rate did
    """

    def __init__(self, delay: float, now: float) -> None:
        self.delay, self._counted_since = delay, now
        # ends of steps with the breaks up to there, in sections along which breaks are smooth
        self._sections = [[(now, 0.0)]]
        self.pending: dict[float, float] = {}

    @property
    def total(self) -> float:
        """Breaks up to the end of the last step."""
        return self._sections[-1][-1][1]

    def add(self, now: float, breaks: float) -> None:
        """A step ended now, with so many breaks up to its end."""
        self._sections[-1].append((now, breaks))

    def births_up_to(self, *, begin: float, end: float) -> BirthsUpTo:
        """Births up to the end of a step from `begin`, the end of the last step, to `end`, times on the path. Their
        names are asked for, as no type tells them apart."""
        if not self.delay:
            return BirthsUpTo(1.0, 0.0)
        broken_at = end - self.delay - LATE * (end - self._counted_since)
        if broken_at <= self._counted_since:
            return BirthsUpTo(0.0, 0.0)
        if broken_at > begin:
            # within this step, on which B goes straight from `total`, that at its begin, to that at its end, which is
            # not known yet: B(broken_at) = (1 - fraction) total + fraction B(end)
            fraction = (broken_at - begin) / (end - begin)
            return BirthsUpTo(fraction, (1.0 - fraction) * self.total)
        section = next(section for section in self._sections if section[-1][0] >= broken_at)
        first = bisect_left(section, (broken_at,)) - NODES // 2
        first = max(min(first, len(section) - NODES), 0)
        times, breaks = zip(*section[first : first + NODES], strict=True)
        return BirthsUpTo(0.0, float(KroghInterpolator(times, breaks)(broken_at)))

    def begin_section(self) -> None:
        """The rate of breaks, or their sum, may jump at this instant: no polynomial leads across. Called by

        - `Slider._begin_section`: the drive turns, births jump or bend, or a slip has ended;
        - `slip_without_births`, before its step, which takes no time: its breaks are a section of their own, whose sum
          `repeat_jump` reads. The section after it begins with the slider's next one.

        Not by `slip_with_births`: births follow at once there, and nobody asks for past breaks.
        """
        self._sections.append(self._sections[-1][-1:])

    def repeat_bend(self, at: float) -> None:
        """The rate of breaks jumps: that of births jumps a delay later, and bends after two. Without a delay births
        follow at once, and nothing is repeated."""
        if self.delay:
            for later in (at + self.delay, at + 2.0 * self.delay):
                self.pending.setdefault(later, 0.0)

    def repeat_jump(self, at: float) -> None:
        """Breaks jumped by those of the last section, which took no time: births repeat it a delay later."""
        (_, before), (_, after) = self._sections[-1][0], self._sections[-1][-1]
        self.repeat_bend(at)
        due_at = at + self.delay
        self.pending[due_at] = self.pending.get(due_at, 0.0) + after - before

    def take_due(self, now: float) -> float:
        """The fraction that is born at once now, which is pending no longer."""
        return sum(self.pending.pop(at) for at in list(self.pending) if at <= now)
