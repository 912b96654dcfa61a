"""Work that is the same on every machine: how many functions are called."""

import sys
from types import FrameType, TracebackType
from typing import Any


class CountedCalls:
    """A context; `number` is that of the functions, Python's own among them, called within it on this thread.

    Releases of Python and of what it imports differ by some tens of percent: bounds must leave room for that.
    """

    def __init__(self) -> None:
        self.number = 0
        self._before: Any = None

    def __enter__(self) -> "CountedCalls":
        self._before = sys.getprofile()
        sys.setprofile(self._hear)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        sys.setprofile(self._before)

    def _hear(self, frame: FrameType, event: str, argument: object) -> None:
        if event in ("call", "c_call"):
            self.number += 1
