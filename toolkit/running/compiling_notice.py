"""A line while numba compiles for long, as it does on first use: numba itself, once it is imported, says when."""

import sys
import threading
import time
from types import TracebackType
from typing import Any

_PATIENCE, _LOG_PATIENCE = 1.0, 10.0  # seconds, of a terminal and of a log file
_LOOK = 0.1  # seconds
_KIND = "numba:compile"
_SAID = "mesofriction: compiling, which takes up to some minutes; numba keeps it for all runs of this version"


class CompilingNotice:
    """A context within which that line is told once, if it comes to it; to be entered on rank 0 only.

    patience : seconds of compiling before it is told; None: those of a terminal or of a log file.
    look : seconds from one look at whether numba compiles to the next."""

    def __init__(self, patience: float | None = None, look: float = _LOOK) -> None:
        usual = _PATIENCE if sys.stderr.isatty() else _LOG_PATIENCE
        self._patience, self._look = usual if patience is None else patience, look
        self._begun, self._depth = 0.0, 0
        self._done = threading.Event()
        self._watching = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> "CompilingNotice":
        self._watching.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._done.set()
        self._watching.join()

    def _watch(self) -> None:
        event = None
        while event is None:
            if self._done.wait(self._look):
                return
            # not imported for this: what compiles nothing needs no numba
            found = sys.modules.get("numba.core.event")
            event = found if hasattr(found, "unregister") else None
        listener = self._listener(event)
        event.register(_KIND, listener)
        try:
            while not self._done.wait(self._look):
                if self._depth and time.monotonic() - self._begun > self._patience:
                    print(_SAID, file=sys.stderr, flush=True)
                    return
        finally:
            event.unregister(_KIND, listener)

    def _listener(self, event: Any) -> Any:
        notice = self

        class Listener(event.Listener):
            """Notes when the outermost of nested compilations began."""

            def on_start(self, told: Any) -> None:
                if not notice._begun:
                    notice._begun = time.monotonic()
                notice._depth += 1

            def on_end(self, told: Any) -> None:
                notice._depth = max(notice._depth - 1, 0)

        return Listener()
