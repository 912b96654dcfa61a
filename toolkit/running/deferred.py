"""Signals that have to wait, until what must not be interrupted is done."""

import signal
import threading
from types import FrameType, TracebackType
from typing import Any


class Deferred:
    """SIGINT and SIGTERM noted in `signal` instead of heeded; in the main thread only, which alone hears them."""

    def __init__(self) -> None:
        self.signal: int | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "Deferred":
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                before = signal.getsignal(number)
                if before not in (None, signal.SIG_IGN):
                    self._before[number] = before
                    signal.signal(number, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)
        if kind is None and self.signal is not None:
            signal.raise_signal(self.signal)  # it came last of all

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.signal = number

    def pass_on(self, note: str) -> None:
        """Do what the signal did before; an exception that this raises says `note`."""
        number, self.signal = self.signal, None
        if number is None:
            return
        signal.signal(number, self._before[number])
        try:
            signal.raise_signal(number)
        except BaseException as stop:
            stop.add_note(note)
            raise
        finally:
            signal.signal(number, self._note)
