"""Progress of long runs: in a terminal a bar, once they have lasted a second; in a log file, or under mpirun, a line
after ten seconds and then every thirty. Both count the time from the start."""

import math
import sys
import threading
import time
from typing import Any

_PATIENCE, _LOG_PATIENCE = 1.0, 10.0
_LOG_PACE = 30.0
_PACE = 0.1
_LONG = 60.0  # seconds: what takes longer is said as soon as that is known
_NOT_YET = 1e-9  # that a bar is not drawn before it knows when it began


class Progress:
    """Call as progress(done, expected); on rank 0 only. It shows contacts per second and the time left.

    patience : seconds before anything is shown; None: those of a terminal or of a log file."""

    def __init__(self, patience: float | None = None) -> None:
        self._begun = time.monotonic()
        self._bar: Any = None
        self._terminal = sys.stderr.isatty()
        usual = _PATIENCE if self._terminal else _LOG_PATIENCE
        self._next = self._begun + (usual if patience is None else patience)
        self._first: tuple[float, int] | None = None
        self._warned = False

    def __call__(self, done: int, expected: int) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = now, done
            self._next = max(self._next, now + _PATIENCE)  # a first block does not tell the pace
        if done >= expected:
            self.close()
            self._first = None  # of the next scene
        elif self._bar is not None:
            self._bar.total = expected
            self._bar.update(done - self._bar.n)
        elif now >= self._next and self._terminal:
            from tqdm import tqdm

            shown = {"unit": " contacts", "unit_scale": True, "mininterval": _PACE}
            self._bar = tqdm(leave=False, total=expected, initial=done, delay=_NOT_YET, **shown)
            self._bar.start_t -= now - self._begun
            self._bar.initial = self._first[1]
            self._bar.refresh()
        elif now < self._next:
            self._warn(now, done, expected)
        else:
            self._next, self._warned = now + _LOG_PACE, True
            _log(self._line(now, done, expected))

    def _warn(self, now: float, done: int, expected: int) -> None:
        """Say once that it will take long, as soon as the pace is known."""
        begun, before = self._first or (now, done)
        if self._warned or done == before or now - begun < _PATIENCE:
            return
        left = (expected - done) * (now - begun) / (done - before)
        self._warned = left > _LONG
        if self._warned:
            _log(f"eq: will take some {_clock(left)} more")

    def _line(self, now: float, done: int, expected: int) -> str:
        """What there is to tell in words."""
        begun, before = self._first or (now, done)
        said = f"eq: {done:,} of {expected:,} contacts ({done / expected:.0%}) after {_clock(now - self._begun)}"
        if done == before:
            return said
        pace = (done - before) / (now - begun)
        return f"{said}, {pace:.3g} a second, {_clock((expected - done) / pace)} left"

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class Refinement:
    """Call as refinement(error) with the error that a solution has; it shows how many of the powers of ten from the
    first one to the tolerance are gone, and the time since it was made, also while nothing is called.

    tolerance : that was asked for; None for work that knows no error on its way.
    what : the work in words.
    patience : seconds before anything is shown; None: those of a terminal or of a log file.
    done : an event for which it waits between what it shows, and which ends it; None: one of its own."""

    def __init__(
        self,
        tolerance: float | None,
        patience: float | None = None,
        done: threading.Event | None = None,
        what: str = "master equation",
    ) -> None:
        self._tolerance, self._what = tolerance, what
        self._first = self._best = math.inf
        self._bar: Any = None
        self._patience, self._done = patience, done or threading.Event()
        self._ticking = threading.Thread(target=self._tick, daemon=True)
        self._ticking.start()

    def __call__(self, error: float) -> None:
        if math.isinf(self._first):
            self._first = error
        self._best = min(self._best, error)

    def _tick(self) -> None:
        begun, terminal = time.monotonic(), sys.stderr.isatty()
        wait, pace = (_PATIENCE, _PATIENCE) if terminal else (_LOG_PATIENCE, _LOG_PACE)
        wait = wait if self._patience is None else self._patience
        while not self._done.wait(wait):
            wait = pace
            said = self._said()
            if not terminal:
                _log(f"{self._what}: {said}, after {_clock(time.monotonic() - begun)}")
                continue
            if self._bar is None:
                from tqdm import tqdm

                form = self._what + ": {bar} {postfix}, {elapsed}"
                self._bar = tqdm(
                    leave=False, total=1.0, bar_format=form, mininterval=0.0, delay=_NOT_YET
                )
                self._bar.start_t -= time.monotonic() - begun
            self._bar.n = self._share()
            self._bar.set_postfix_str(said)

    def _said(self) -> str:
        if self._tolerance is None:
            return "at work"
        if not math.isfinite(self._best):
            return "no error estimate yet"
        return f"error {self._best:.1e} of {self._tolerance:.1e} asked"

    def _share(self) -> float:
        if (
            self._tolerance is None
            or not math.isfinite(self._first)
            or self._first <= self._tolerance
        ):
            return 0.0
        return min(
            1.0, math.log(self._first / self._best) / math.log(self._first / self._tolerance)
        )

    def close(self) -> None:
        """Take the bar away."""
        self._done.set()
        self._ticking.join()
        if self._bar is not None:
            self._bar.close()


def _log(line: str) -> None:
    print(f"mesofriction: {line}", file=sys.stderr, flush=True)


def _clock(seconds: float) -> str:
    """Hours, minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"
