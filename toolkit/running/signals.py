"""Signals that end a run: as an exception, or put off until a block of the ensemble is finished."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

ENDING = (signal.SIGTERM, signal.SIGHUP)


class Terminated(BaseException):
    """SIGTERM or SIGHUP: a scheduler ends the job, or the terminal is gone."""


class TimeIsUp(BaseException):
    """The time given to `no_longer_than` is over."""


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM and SIGHUP raise Terminated, in the main thread, which alone hears signals.

    A signal that is ignored, as SIGHUP under nohup, stays ignored.
    """
    said = False

    def terminate(number: int, frame: FrameType | None) -> NoReturn:
        nonlocal said
        said = True
        raise Terminated

    with _handled(terminate, *ENDING):
        try:
            yield
        except Exception as error:
            if said:  # a compiled module that is being imported raises its own exception instead
                raise Terminated from error
            raise


@contextmanager
def no_longer_than(seconds: float | None) -> Iterator[None]:
    """Raise TimeIsUp within once so many seconds are over; in the main thread only, None for no limit."""
    if seconds is None or not _in_main_thread():
        yield
        return

    def ring(number: int, frame: FrameType | None) -> NoReturn:
        raise TimeIsUp

    with _handled(ring, signal.SIGALRM):
        try:
            signal.setitimer(signal.ITIMER_REAL, max(seconds, 1e-6))
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)


class Deferred:
    """SIGINT, SIGTERM and SIGHUP are noted in `signal` and not yet heeded; in the main thread only."""

    def __init__(self) -> None:
        self.signal: int | None = None

    def __enter__(self) -> "Deferred":
        self._context = _handled(self._note, signal.SIGINT, *ENDING)
        self._before = self._context.__enter__()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._context.__exit__(None, None, None)
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


@contextmanager
def _handled(handler: Any, *numbers: int) -> Iterator[dict[int, Any]]:
    """These signals go to `handler` within, but those that are ignored; gives what handled them before."""
    before: dict[int, Any] = {}
    if _in_main_thread():
        for number in numbers:
            if signal.getsignal(number) not in (None, signal.SIG_IGN):
                before[number] = signal.signal(number, handler)
    try:
        yield before
    finally:
        for number, own in before.items():
            signal.signal(number, own)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
