"""SIGTERM as an exception, from before the first heavy import on."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn


class Terminated(BaseException):
    """SIGTERM: a scheduler's word that time is up."""


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM raises Terminated, in the main thread, which alone may say so; whatever comes of that is Terminated."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    said = False

    def terminate(number: int, frame: FrameType | None) -> NoReturn:
        nonlocal said
        said = True
        raise Terminated

    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    except Exception as error:
        if said:  # compiled modules that are being imported put an exception of their own in its place
            raise Terminated from error
        raise
    finally:
        signal.signal(signal.SIGTERM, before)
