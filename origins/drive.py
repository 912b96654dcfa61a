"""The drive: where the slider, or the spring that pulls it, goes; checked once for both solvers."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, finite_array, positive, refuse

SlipRule = Literal["reset", "reform-after", "instant"]


class Drive:
    """A path, the speed along it, and the spring that pulls; straight between the points.

    Parameters
    ----------
    path : array of shape (n,)
        Positions (lengths), n >= 1, which may turn round: X of a rigid slider, from X = 0 straight to the first of
        them; X_T, the drive's own, of a soft one.
    velocity : float
        Speed along the path (length per time), the same everywhere; what only rates, ageing and delay tell.
    time : array of shape (n,), optional
        When each point is reached, from 0 on and in order, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>); None: the slider is rigid.
    slip : "reset", "reform-after" or "instant"
        What a slip of a soft slider does; left as it is for a rigid one.

    Attributes
    ----------
    forward : bool
        Whether the path begins at 0 or above and never turns back.

    Raises InputError for what is not finite, not positive or not in order, and for an unknown slip.
    """

    def __init__(
        self,
        path: npt.ArrayLike,
        velocity: float = 1.0,
        time: npt.ArrayLike | None = None,
        spring: float | None = None,
        slip: SlipRule = "reset",
    ) -> None:
        self.path = finite_array("path", path)
        self.velocity = positive("velocity", velocity)
        self.time = None if time is None else _check_time(time, self.path, velocity)
        self.spring = None if spring is None else positive("spring", spring)
        if slip not in get_args(SlipRule):
            refuse("slip", slip, 'must be "reset", "reform-after" or "instant"')
        if self.spring is None and slip != "reset":
            refuse("slip", slip, "is what a slip of a soft slider does, and without spring the slider is rigid")
        self.slip = slip
        before = np.append(0.0, self.path[:-1])
        self._back = np.flatnonzero(self.path < before)
        self.forward = not self._back.size

    def only_forward(self, solver: str) -> Drive:
        """Itself, if it is a rigid slider's that moves forward; InputError with the name of what only solves that."""
        if self.spring is not None:
            refuse("spring", self.spring, f"{solver} takes a rigid slider; leave it out")
        if self._back.size:
            at = int(self._back[0])
            before = f"lies behind path[{at - 1}] = {self.path[at - 1]:g}" if at else "lies behind X = 0"
            refuse(f"path[{at}]", self.path[at], f"{before}; {solver} takes a path that does not turn round")
        return self


def _check_time(time: npt.ArrayLike, path: npt.NDArray[np.float64], velocity: float) -> npt.NDArray[np.float64]:
    if velocity != 1.0:
        raise InputError(f"velocity = {velocity!r}: the times of the points say how fast; give one of the two")
    times = finite_array("time", time)
    if times.shape != path.shape:
        refuse("time", times, f"must have the shape of the path, {path.shape}")
    if times[0] < 0.0:
        refuse("time[0]", times[0], "must be at least 0, when the slider is at X = 0")
    early = np.flatnonzero(np.diff(times, prepend=0.0) < 0.0)
    if early.size:
        at = int(early[0])
        refuse(f"time[{at}]", times[at], f"is before time[{at - 1}] = {times[at - 1]:g}; times must be in order")
    moved = np.flatnonzero((np.diff(times, prepend=0.0) == 0.0) & (np.diff(path, prepend=0.0) != 0.0))
    if moved.size:
        at = int(moved[0])
        refuse(f"time[{at}]", times[at], "leaves no time to get there; the path moves, so must the time")
    return times
