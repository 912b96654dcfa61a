"""How long a verdict may take: on a busy machine longer than on a quiet one, so that both say the same."""

import os
import re
import time
from dataclasses import dataclass

# s for all readings and rules together, where the scene gives none, and what to do where they do not suffice
WALL_TIME = 60.0
MORE_TIME = f"raise wall_time (s, {WALL_TIME:.0f} where none is given)"
LONGER = f"the command's --set wall_time={10 * WALL_TIME:.0f} gives it ten minutes"
# what a solver says of a slider that swings on, as its damping is small, and of the damping that ends it
_SWINGS = re.compile(r"; sliding swings.*?; give one above [^ ,;]+")
# s by which the pace is smoothed, as that of the first moments says little
_SMOOTH = 1.0
# largest pace that is expected before any is seen: the load may be that of cores which this process does not share
_MOST_EXPECTED = 4.0


class Budget:
    """So many `seconds`, of the clock on the wall if `strict`, else of those in which this process could work.

    Where other programs have the cores, a process has fewer seconds of the processor than of the clock; with several
    threads it has more, and then the clock counts. `pace`: seconds of the clock for each that counts, so far; at first
    that which the programs that run beside this one let expect.
    """

    def __init__(self, seconds: float, strict: bool, pace: float | None = None) -> None:
        self._seconds, self._strict = seconds, strict
        self._first_pace = _expected_pace() if pace is None else pace
        self._clock, self._work = time.monotonic(), time.process_time()

    def remaining(self) -> float:
        """How many s of the clock remain at the pace so far; below 0 once the time is over."""
        used, pace = self._used()
        return (self._seconds - used) * pace

    def part(self, fraction: float) -> "Budget":
        """A budget from now on, of this fraction of what remains."""
        used, pace = self._used()
        return Budget(fraction * (self._seconds - used), self._strict, pace)

    def _used(self) -> tuple[float, float]:
        """Seconds that count, and the pace."""
        clock = time.monotonic() - self._clock
        if self._strict:
            return clock, 1.0
        used = min(clock, time.process_time() - self._work)
        return used, (clock + _SMOOTH * self._first_pace) / (used + _SMOOTH)


def late(message: str) -> str:
    """Why a slider was not followed to its end in time, by a solver's message; the path and its tolerance are the
    verdict's own, and the damping is not."""
    return (
        f"neither force nor slips are known in time: {MORE_TIME}{''.join(_SWINGS.findall(message))}"
    )


def _expected_pace() -> float:
    """Programs that wanted a core in the last minute, and this one, for each core of the machine; at least 1."""
    waiting = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return min(max((1.0 + waiting) / (os.cpu_count() or 1), 1.0), _MOST_EXPECTED)


@dataclass(frozen=True)
class PlannedDrive:
    """The drive's travel for sliders of some contacts (a length), and the breaks of all of them on it, at most."""

    end: float
    breaks: float
