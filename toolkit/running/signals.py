"""Signals that end a run: as an exception, or put off until a block of the ensemble is finished."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any, NoReturn

ENDING = (signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else []))


class Terminated(BaseException):
    """SIGTERM or SIGHUP: a scheduler ends the job, or the terminal is gone."""


class TimeIsUp(BaseException):
    """The time given to `no_longer_than` is over."""


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM and SIGHUP raise Terminated, in the main thread, which alone hears signals.

    A signal that is ignored, as SIGHUP under nohup, stays ignored.
    """
    if not _in_main_thread():
        yield
        return

    said = False

    def terminate(number: int, frame: FrameType | None) -> NoReturn:
        nonlocal said
        said = True
        raise Terminated

    heard = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, terminate) for number in heard}
    try:
        yield
    except Exception as error:
        if said:  # a compiled module that is being imported raises its own exception instead
            raise Terminated from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def no_longer_than(seconds: float | None, timer: int = signal.ITIMER_REAL) -> Iterator[None]:
    """Raise TimeIsUp within once so many seconds are over; in the main thread only, None for no limit.

    `timer` is ITIMER_REAL, or ITIMER_PROF for seconds of this process's own work.
    """
    if seconds is None or not _in_main_thread():
        yield
        return

    def ring(number: int, frame: FrameType | None) -> NoReturn:
        raise TimeIsUp

    number = signal.SIGPROF if timer == signal.ITIMER_PROF else signal.SIGALRM
    before = signal.signal(number, ring)
    try:
        signal.setitimer(timer, max(seconds, 1e-6))
        yield
    finally:
        signal.setitimer(timer, 0.0)
        signal.signal(number, before)


class Deferred:
    """SIGINT, SIGTERM and SIGHUP are noted in `signal` and not yet heeded; in the main thread only."""

    def __init__(self) -> None:
        self.signal: int | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "Deferred":
        if _in_main_thread():
            for number in (signal.SIGINT, *ENDING):
                before = signal.getsignal(number)
                if before not in (None, signal.SIG_IGN):
                    self._before[number] = before
                    signal.signal(number, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)
        if kind is None and self.signal is not None:
            signal.raise_signal(self.signal)  # it came after the last block

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.signal = number

    def pass_on(self, note: str) -> None:
        """Do what the noted signal did before; an exception that this raises gets `note`."""
        number, self.signal = self.signal, None
        if number is None:
            return
        signal.signal(number, self._before.get(number, signal.SIG_DFL))
        try:
            signal.raise_signal(number)
        except BaseException as stop:
            stop.add_note(note)
            raise
        finally:
            signal.signal(number, self._note)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
