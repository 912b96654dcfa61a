"""The drive's motion X_T(t), from the balance at t = 0 to the end of its path."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.motion.motion import Motion
from origins import Drive

Array = npt.NDArray[np.float64]


def reached(drive: Drive, balance: float) -> Array:
    """Times at which the points of the path are reached, from the balance at t = 0."""
    if drive.time is not None:
        return drive.time
    return np.asarray(np.abs(np.diff(drive.path, prepend=balance)).cumsum() / drive.velocity)


def drive_motion(drive: Drive, balance: float) -> Motion | None:
    """X_T(t); None where the path is the balance alone."""
    times = np.append(0.0, reached(drive, balance))
    return Motion(times, np.append(balance, drive.path)) if times[-1] > 0.0 else None
