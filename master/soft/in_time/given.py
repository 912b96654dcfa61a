"""Given: a rigid slider whose contacts are followed in steps of its path in time.

As where grains grow in heat and the path turns or holds: what each strand has spent is kept, so that
a step costs the same however many legs lie behind it (master.soft.in_time.memory).
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master.outcome import Progress, outcome, unheard
from master.soft.in_time.make import Maker
from master.soft.in_time.refining import refined
from master.soft.in_time.track import fastest, reached
from origins import Contacts, Drive, InputError
from origins.brief import brief

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class TimedSolution:
    """F along a path in time, with the error it is good to.

    Attributes
    ----------
    path, time : arrays of shape (n,)
        Slider positions X (lengths), and when they are reached.
    force : array of shape (n,)
        F/(N_c <k>), the mean stretch of the contacts (a length).
    force_error : float
        Estimate of the largest error of `force` over the path, in units of the mean threshold.
    holding : array of shape (n,)
        Fraction of contacts that hold.
    run_time : float
        Seconds that the solution took.
    nodes : int
        Steps of the best solution.
    success : bool
        Whether force_error is at or below the tolerance asked for.
    message : str
        In words: what was reached, or why not; what was cut off from the start.
    """

    path: Array
    time: Array
    force: Array
    force_error: float
    holding: Array
    run_time: float
    nodes: int
    success: bool
    message: str

    __repr__ = brief

    def distribution(self, point: int) -> None:
        """Q(x;X) is not known where contacts grow in heat: InputError."""
        raise InputError(
            "contacts.grains: Q(x;X) is not known along paths in time yet where contacts grow"
        )


def solve_given(
    contacts: Contacts,
    drive: Drive,
    tolerance: float,
    progress: Progress = unheard,
    wall_time: float | None = None,
) -> TimedSolution:
    """Force on a rigid slider on steps halved until they tell it to the tolerance; see `solve`.

    Raises InputError where a path takes too many steps.
    """
    began = clock.perf_counter()
    until = np.inf if wall_time is None else clock.monotonic() + wall_time
    asked = reached(drive, 0.0)
    maker = Maker(contacts, fastest(drive))
    found = refined(contacts, maker, drive, 0.0, asked, tolerance, progress, until)
    told = found.force.size
    success, message = outcome(contacts, found.error, tolerance, found.reason)
    if told < asked.size:
        last = f"X = {drive.path[told - 1]:.6g}" if told else "the first point"
        success, message = False, f"stopped at {last} by wall_time; the path is cut there"
    return TimedSolution(
        path=drive.path[:told],
        time=asked[:told],
        force=found.force,
        force_error=found.error,
        holding=found.holding,
        run_time=clock.perf_counter() - began,
        nodes=found.steps,
        success=success,
        message=message,
    )
