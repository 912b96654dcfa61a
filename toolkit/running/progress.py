"""Progress of long runs on stderr: in a terminal a bar of tqdm once they have lasted a second, in a log file, or under
mpirun, a line after ten seconds and then every thirty. Both count the time from the start."""

import math
import sys
import threading
import time
from typing import Any

_PATIENCE, _LOG_PATIENCE = 1.0, 10.0  # seconds before anything is shown
_LOG_PACE = 30.0  # seconds from line to line
_EARLY = 0.2  # of the patience: when the time that is left is looked at first
_LONG = 60.0  # seconds: work that takes longer is said so early


class Refinement:
    """Call as refinement(error) with the error that a solution has; it shows how many of the powers of ten from the
    first one to the tolerance are gone, also while nothing is called.

    tolerance : that was asked for; None for work that knows no error on its way.
    patience : seconds before anything is shown; None: those of a terminal or of a log file.
    done : an event for which it waits between what it shows, and which ends it; None: one of its own.
    what : the work in words.
    """

    _tells_what_is_left = False

    def __init__(
        self,
        tolerance: float | None,
        patience: float | None = None,
        done: threading.Event | None = None,
        what: str = "master equation",
    ) -> None:
        self._tolerance, self._what = tolerance, what
        self._first = self._best = math.inf
        self._begun = time.monotonic()
        self._patience, self._done = patience, done or threading.Event()
        self._ticking = threading.Thread(target=self._tick, daemon=True)
        self._ticking.start()

    def __call__(self, error: float) -> None:
        if math.isinf(self._first):
            self._first = error
        self._best = min(self._best, error)

    def close(self) -> None:
        """Take the bar away."""
        self._done.set()
        self._ticking.join()

    def _tick(self) -> None:
        terminal, bar = sys.stderr.isatty(), None
        patience, pace = (_PATIENCE, _PATIENCE) if terminal else (_LOG_PATIENCE, _LOG_PACE)
        patience = patience if self._patience is None else self._patience
        early = self._tells_what_is_left and not terminal
        wait = _EARLY * patience if early else patience
        while not self._done.wait(wait):
            wait, due = (patience - wait, self._left() > _LONG) if early else (pace, True)
            early = False
            if not self._at_work():
                continue
            if terminal:
                bar = bar or self._bar()
                bar.n = self._share()
                bar.set_postfix_str(self._said())
            elif due:
                since = _clock(time.monotonic() - self._begun)
                line = f"mesofriction: {self._what}: {self._said()}, after {since}"
                print(line, file=sys.stderr, flush=True)
        if bar is not None:
            bar.close()

    def _bar(self) -> Any:
        from tqdm import tqdm

        form = self._what + ": {percentage:3.0f}%|{bar}| {postfix}, {elapsed}"
        bar = tqdm(leave=False, total=1.0, bar_format=form, mininterval=0.0, delay=1e-9)
        bar.start_t -= time.monotonic() - self._begun
        return bar

    def _said(self) -> str:
        if self._tolerance is None:
            return "at work"
        if not math.isfinite(self._best):
            return "no error estimate yet"
        return f"error {self._best:.1e} of {self._tolerance:.1e} asked"

    def _share(self) -> float:
        """Of the work that is done, as far as that is known."""
        if self._tolerance is None or not math.isfinite(self._first):
            return 0.0
        if self._first <= self._tolerance:
            return 0.0
        decades = math.log(self._first / self._tolerance)
        return min(1.0, math.log(self._first / self._best) / decades)

    def _at_work(self) -> bool:
        return True

    def _left(self) -> float:
        """Seconds that it will take, 0 where that is not known."""
        return 0.0


class Progress(Refinement):
    """Call as progress(done, expected); on rank 0 only. It shows contacts per second and the time left."""

    _tells_what_is_left = True

    def __init__(self, patience: float | None = None, done: threading.Event | None = None) -> None:
        self._now = self._before = 0, 0
        self._started = math.inf
        super().__init__(None, patience, done, what="eq")

    def __call__(self, done: int, expected: int) -> None:  # type: ignore[override]
        if math.isinf(self._started):  # a first block does not tell the pace
            self._started, self._before = time.monotonic(), (done, expected)
        self._now = done, expected
        if done >= expected:
            self._started = math.inf  # of the next scene

    def _at_work(self) -> bool:
        return not math.isinf(self._started)

    def _said(self) -> str:
        done, expected = self._now
        said = f"{done:,} of {expected:,} contacts ({done / expected:.0%})"
        pace = self._pace()
        return said if not pace else f"{said}, {pace:.3g} a second, {_clock(self._left())} left"

    def _share(self) -> float:
        return self._now[0] / max(self._now[1], 1)

    def _left(self) -> float:
        pace = self._pace()
        return (self._now[1] - self._now[0]) / pace if pace else 0.0

    def _pace(self) -> float:
        """Contacts a second, 0 where that is not known."""
        since = time.monotonic() - self._started
        return (self._now[0] - self._before[0]) / since if since > 0.0 else 0.0


def _clock(seconds: float) -> str:
    """Hours, minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"
