"""How long a verdict may take, on a busy machine longer than on a quiet one, so that both say the same; and which
sliders may be followed contact by contact."""

import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar, cast

from origins.contacts import Contacts
from origins.laws.proportional import ProportionalGrowth
from toolkit.processes.signals import Terminated, TimeIsUp, no_longer_than
from toolkit.running.progress import clock
from toolkit.verdict.sliders.machine import Machine, RigidSlider, critical_damping, slip_duration
from toolkit.verdict.sliders.ways import first_way, lives_in_a_slip, loading_of

# s for all readings and rules together, where the scene gives none, and what to do where they do not suffice
WALL_TIME = 60.0
MORE_TIME = f"raise wall_time (s, {WALL_TIME:.0f} where none is given)"
HOW_TO_GIVE_MORE_TIME = f"the command's --set wall_time={10 * WALL_TIME:.0f} gives it ten minutes"
NO_TIME = f"wall_time is used up ({WALL_TIME:.0f} s where none is given): raise it"
INTERRUPTED = "interrupted before it was followed"
# why nothing is told of a slider, and of a reading other than the scene's own
NO_FORCES = (
    f"F_s and K* were not found in time, and without them no slider is followed: {MORE_TIME}"
)
# most breaks of all sliders, some 10 s at 25 ns each; where contacts wait while a mass moves, as it rings on them when
# it sticks, some 8 s of the processor at 200 ns each; where they break by heat, some 10 s at 800 ns each, and where
# heat or strengthening acts on a slider with mass at 2 µs each; and s for them
MOST_BREAKS, MOST_BREAKS_RINGING, MOST_BREAKS_IN_HEAT, OF_MOST = 4e8, 4e7, 1.2e7, 10.0
MOST_BREAKS_IN_TIME = 5e6
# s that there always are for sliders, and are no noise of a busy machine
SHORT = 2.0
# times as long as above a break in heat may take, as on a slider that creeps in Eyring heat, where a pilot says so
DEAREST = 5.0
# breaks of each contact along a loading with which a few, that wait for less than a slip of the mass, are followed
# where nothing else decides: four sliders of a thousand along 6.5 loadings take 4e8, some 50 s of the processor
MOST_LIVES = 1.5e4
# and where these break by heat, form again at once, and a mass moves: 8e6 breaks, some 40 s of the processor
MOST_LIVES_IN_HEAT = 2e3
# the least delay, in times of a slip; of K*: on softer springs the number of contacts decides nothing
LONG_DELAY, SOFT = 3.0, 0.1
# why nothing is told of a slider that rings without a damping, where one that was taken bears much of its force
NO_DAMPING = "no damping is given"
# what a solver says of a slider that swings on, as its damping is small, without the advice on the path
_SWINGS = re.compile(r"; sliding swings.*?, if the machine has that")
# what it says of one that rings while it sticks
_LARGER = re.compile(
    r"[;,] (?:or )?give a (?:larger damping|damping, or a larger one) \(.*? is ([^ ),]+)[^)]*\)"
)
# parts of the time for the contacts of the area, see `part_of_sliders`
NEARLY_ALL, OF_SLIDERS, LESS = 0.9, 0.5, 0.3
# s by which the pace is smoothed, as that of the first moments says little
_SMOOTH = 1.0
# largest pace that is expected before any is seen: the load may be that of cores which this process does not share
_MOST_EXPECTED = 4.0

T = TypeVar("T")


class Stops:
    """Lets a block of work end early: at the end of its time, and, if interrupts are `kept`, at the first of these. It
    is then held as `by`, which is None until it comes, so that what is known can be told. A second one is raised."""

    def __init__(self, kept: bool = False) -> None:
        """Nothing has come yet."""
        self._kept, self.by = kept, cast(BaseException | None, None)

    @contextmanager
    def or_late(self) -> Iterator[None]:
        """End the block, and nothing else, once its time is over or, where that is kept, at an interrupt."""
        try:
            yield
        except TimeIsUp:
            return
        except (KeyboardInterrupt, Terminated) as stop:
            if not self._kept or self.by is not None:
                raise
            self.by = stop


class Budget:
    """So many `seconds`, of the clock on the wall if `strict`, else of those in which this process could work.

    Where other programs have the cores, a process has fewer seconds of the processor than of the clock; with several
    threads it has more, and then the clock counts. `pace`: seconds of the clock for each that counts, so far; at first
    that which the programs that run beside this one let expect. Nothing remains once one of `stops` has come.
    """

    def __init__(
        self, seconds: float, strict: bool, pace: float | None = None, stops: Stops | None = None
    ) -> None:
        self._seconds, self._strict = seconds, strict
        self.stops = stops or Stops()
        self._first_pace = _expected_pace() if pace is None else pace
        self._clock, self._work = time.monotonic(), time.process_time()

    def remaining(self) -> float:
        """How many s of the clock remain at the pace so far; below 0 once the time is over."""
        used, pace = self._used()
        return 0.0 if self.stops.by else (self._seconds - used) * pace

    def part(self, fraction: float) -> "Budget":
        """A budget from now on, of this fraction of what remains; what it does not use stays in this one."""
        used, pace = self._used()
        return Budget(fraction * (self._seconds - used), self._strict, pace, self.stops)

    def spend(self, fraction: float, work: Callable[["Budget"], T]) -> T | None:
        """What `work` returns, given this part of the budget; None where that is used up before, or at an interrupt
        that is kept."""
        part = self.part(fraction)
        if (seconds := part.remaining()) > 0.0:
            with self.stops.or_late(), no_longer_than(seconds, remaining_time=part.remaining):
                return work(part)
        return None

    def _used(self) -> tuple[float, float]:
        """Seconds that count, and the pace."""
        passed = time.monotonic() - self._clock
        if self._strict:
            return passed, 1.0
        used = min(passed, time.process_time() - self._work)
        return used, (passed + _SMOOTH * self._first_pace) / (used + _SMOOTH)


def part_of_sliders(contacts: Contacts, many: bool) -> float:
    """Which part of the time that is left once the own reading is known is for the contacts of the area, in all but
    what the picture of a slip takes where there are not `many` readings; less where a law acts in time, under which
    other readings take longer, and fewer contacts tell the same."""
    if not many:
        return NEARLY_ALL
    return LESS if contacts.held_in_time else OF_SLIDERS


def at_most(wall_time: float | None) -> str:
    """How long a verdict takes at most, for its progress: the time that is given, or some time of work, which takes
    longer on a busy machine."""
    if wall_time is None:
        return f" (some {WALL_TIME:.0f} s of work in all, longer on a busy machine)"
    return f" (wall_time {clock(wall_time)})"


def late(message: str) -> str:
    """Why a slider was not followed to its end in time, by a solver's message; the path and its tolerance are the
    verdict's own, and the damping is not."""
    swings = "".join(_SWINGS.findall(message))
    return f"neither force nor slips are known in time: {MORE_TIME}{swings}"


def without_useless_damping(message: str, machine: Machine) -> str:
    """A solver's message without its advice on a damping that would be above the critical one of mass and spring: no
    machine has it, and the slider is another one."""
    advice = _LARGER.search(message)
    if advice and float(advice[1]) > critical_damping(machine):
        return message.replace(advice[0], "")
    return message


def too_long(needed: float, remaining: float) -> str:
    """Why contacts that need so many s are not followed in those that remain."""
    if not remaining:
        return f"were not followed: {NO_TIME}"
    return f"would take some {needed:,.2g} s, where {remaining:.2g} s are left: {MORE_TIME}"


def lacks_damping(message: str) -> bool:
    """Whether a slider is not told of for want of a damping, by its message."""
    return message.startswith(NO_DAMPING)


def _expected_pace() -> float:
    """Programs that wanted a core in the last minute, and this one, for each core of the machine; at least 1."""
    waiting = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return min(max((1.0 + waiting) / (os.cpu_count() or 1), 1.0), _MOST_EXPECTED)


def long_delay(machine: Machine, mean: float, force: float) -> float:
    """A delay of contacts (a time) far above that of a slip of the mass from this `force`, and above that in which one
    that slides on at the drive's speed moves by their `mean` threshold: fewer hold where it slides."""
    return LONG_DELAY * max(slip_duration(machine, force), mean / machine.velocity)


def taken_on_springs(contacts: Contacts) -> bool:
    """Whether the ensemble takes contacts of these laws on a spring, beside a mass, too."""
    return contacts.changing is None or isinstance(contacts.changing, ProportionalGrowth)


def may_follow(machine: Machine, contacts: Contacts, rule: str, rigid: RigidSlider) -> bool:
    """Whether finitely many contacts tell what infinitely many do.

    With a mass where a delay is far above the time of a slip, `slip_duration`: else contacts re-form while it goes on,
    and break again at every threshold that it passes. Without one under the rules that renew contacts after a slip, on
    springs far below K*: near it their number decides. Where laws in time act, those alone that the ensemble takes
    beside a mass.
    """
    if contacts.held_in_time and not (rule == "mass" and taken_on_springs(contacts)):
        return False
    if rule == "mass":
        return contacts.waiting_time >= LONG_DELAY * slip_duration(machine, rigid.static)
    return rule != "instant" and machine.spring < SOFT * rigid.critical_spring


def few_are_followed(machine: Machine, contacts: Contacts, static: float) -> bool:
    """Whether a few contacts that may break many times in a slip of the mass from this force take no more breaks than
    are followed."""
    loading = loading_of(machine, contacts, static)
    lives = 1.0 + lives_in_a_slip(machine, contacts, static, loading)
    return not contacts.held_in_time and lives <= MOST_LIVES


def few_in_heat_are_followed(machine: Machine, contacts: Contacts, static: float) -> bool:
    """Whether a few contacts that break by heat on a damped mass, and form again at once, take no more breaks than are
    followed: as many as the drive passes thresholds on its first way, as `static` is F_s/(N_c <k>) (a length)."""
    alone = contacts.thermal is not None and not contacts.waiting_time and machine.damping > 0.0
    way = first_way(machine, contacts, loading_of(machine, contacts, static))
    lives = way / contacts.mean_threshold
    return alone and taken_on_springs(contacts) and lives <= MOST_LIVES_IN_HEAT


def most_breaks(contacts: Contacts, rule: str) -> float:
    """Most breaks of all sliders of these contacts that are followed under this slip rule, or with a "mass"."""
    if contacts.held_in_time:
        return MOST_BREAKS_IN_TIME if rule == "mass" else MOST_BREAKS_IN_HEAT
    return MOST_BREAKS_RINGING if rule == "mass" and contacts.waiting_time else MOST_BREAKS


def seconds_of(breaks: float, contacts: Contacts, rule: str, took: float) -> float:
    """How many s of the processor so many breaks take, which a pilot did in `took`: a short one tells less than their
    number, but in heat, where moves of a slider that creeps cost more than breaks do."""
    usual = OF_MOST * breaks / most_breaks(contacts, rule)
    if took >= SHORT:
        return took
    return min(max(took, usual), DEAREST * usual) if contacts.thermal is not None else usual
