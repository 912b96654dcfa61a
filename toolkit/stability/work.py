"""Solutions that end after so much work, not so much time on the clock, which hangs on what else a machine does."""

import time
from collections.abc import Callable
from typing import Any

from origins.errors import NothingInTimeError

# in the messages of solutions that their wall time has cut, of the master equation and of the ensemble
OUT_OF_TIME = ("wall_time", "stopped before all")
_ENOUGH = 0.7  # of the time: a process that worked for so much of it was not kept from its work
_BUSIEST = 10.0  # times as much on the clock it is given at once, where it hardly came to work


def within_work(solve: Callable[..., Any], seconds: float) -> Any:
    """What `solve(wall_time=...)` gives in so many CPU-seconds, a solution with `success`.

    It has as many on the clock first. Where these have cut it while other programs had the cores, it is asked again
    with more of them. Raises NothingInTimeError as it does.
    """
    wall_time = seconds
    while True:
        began, begun = time.monotonic(), time.process_time()
        try:
            found = solve(wall_time=wall_time)
        except NothingInTimeError as over:
            found = over
        took, worked = time.monotonic() - began, time.process_time() - begun
        nothing = isinstance(found, NothingInTimeError)
        cut = nothing or (not found.success and took >= wall_time)
        if not cut or worked >= _ENOUGH * min(took, seconds):
            if nothing:
                raise found
            return found
        wall_time *= min(seconds / max(worked, 1e-3), _BUSIEST)
