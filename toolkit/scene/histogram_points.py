"""Where a scene's ensemble counts stretches and thresholds: points of the path, by position and by time."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from origins.drive import Drive
from origins.errors import finite, refuse

Points = npt.NDArray[np.intp]

_SAME = 1e-9  # of the furthest point, and of a time


def histogram_points(
    drive: Drive, positions: Sequence[float] | None, times: Sequence[float] | None
) -> Points:
    """Indices of the path's points at these positions, each time the slider comes there, where it rests the first and
    the last of them; and at these times. None twice, in order.

    Raises InputError for what is none of the path's points, and for times on a path that has none.
    """
    if times is not None and drive.time is None:
        rule = "are of a path with drive.times; without them say where the slider is, as in histograms = [1.0]"
        refuse("eq.histogram_times", list(times), rule)
    found = set[int]()
    close = _SAME * float(np.abs(drive.path).max())
    for k, position in enumerate(positions or ()):
        there = np.flatnonzero(_off(drive.path, f"eq.histograms[{k}]", position, close) <= close)
        found |= {int(at) for at in there if at - 1 not in there or at + 1 not in there}
    for k, time in enumerate(times or ()):
        if drive.time is not None:
            key = f"eq.histogram_times[{k}]"
            found.add(int(_off(drive.time, key, time, _SAME * abs(time)).argmin()))
    return np.array(sorted(found), np.intp)


def _off(
    points: npt.NDArray[np.float64], key: str, value: float, close: float
) -> npt.NDArray[np.float64]:
    """How far each point is from the value; InputError where none is close."""
    off = np.abs(points - finite(key, value))
    if off.min() > close:
        near = " and ".join(
            f"{x:.12g}" for x in np.unique(points[np.argsort(off, kind="stable")[:2]])
        )
        more = "; all of drive.times are" if key.startswith("eq.histogram_times") else ""
        refuse(key, value, f"is none of the path's points; near it are {near}{more}")
    return off
