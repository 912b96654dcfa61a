"""Progress of long work on stderr: a line now and then."""

import sys
import threading
import time
from datetime import timedelta

PATIENCE = 10.0  # s before anything is said of work that seems short

# s since the first count before which no rate is told: points that other ranks solved are counted at one time
SHORTEST = 0.1


class Progress:
    """Reports the progress of some work, `what`, from its own thread, also while the work makes no calls.

    Create it on rank 0 only, and close it. `things` is what `count` counts; `done` is an event for which it waits
    between lines (None: its own); `most` : how long all takes at most, in words, "" where that is not known.
    """

    def __init__(
        self,
        what: str,
        things: str = "contacts",
        done: threading.Event | None = None,
        most: str = "",
    ) -> None:
        self._things, self._most = things, most
        self._what, self._said = what, "at work (kernels are compiled on first use)"
        self._begun, self._remaining, self._best = time.monotonic(), 0.0, float("inf")
        self._first: tuple[float, int] | None = None
        self._done = done or threading.Event()
        self._ticking = threading.Thread(target=self._tick, daemon=True)
        self._ticking.start()

    def count(self, done: int, expected: int) -> None:
        """So many of these things are done of those expected."""
        now = time.monotonic()
        since, before = self._first = self._first or (now, done)  # one block gives no rate
        self._said = f"{done:,} of {expected:,} {self._things} ({done / expected:.0%})"
        if now > since + SHORTEST and done > before:
            pace = (done - before) / (now - since)
            self._remaining = (expected - done) / pace
            self._said += f", {pace:.3g} a second, {clock(self._remaining)} left"

    def doing(self, what: str) -> None:
        """This begins: told at once, and again where it takes long."""
        self._said = what
        since = time.monotonic() - self._begun
        after = f", after {clock(since)}{self._most}" * bool(self._most)
        print(f"mesofriction: {self._what}: {what}{after}", file=sys.stderr, flush=True)

    def refine(self, error: float) -> None:
        """A solution has this error, in mean thresholds."""
        self._best = min(self._best, error)
        self._said = f"error {self._best:.1e} of <x_s> so far"

    def close(self) -> None:
        self._done.set()
        self._ticking.join()

    def _tick(self) -> None:
        wait = 2.0  # s, after which work that takes over a minute is announced
        while not self._done.wait(wait):
            since = time.monotonic() - self._begun
            if since < PATIENCE and self._remaining < 60.0:
                wait = PATIENCE - since
                continue
            line = f"mesofriction: {self._what}: {self._said}, after {clock(since)}{self._most}"
            print(line, file=sys.stderr, flush=True)
            self._said = self._said.removesuffix(" (kernels are compiled on first use)")
            wait = 30.0


def clock(seconds: float) -> str:
    """Seconds as on a clock, 0:01:30."""
    return str(timedelta(seconds=round(min(seconds, 8e13))))
