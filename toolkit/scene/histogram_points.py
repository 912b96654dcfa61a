"""Where a scene's ensemble counts stretches and thresholds: points of the path, by position and by time."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from origins.drive import Drive
from origins.errors import finite, refuse

Points = npt.NDArray[np.intp]

_SAME_PLACE = 1e-9  # of the furthest point
_SAME_TIME = 1e-9  # of itself


def histogram_points(
    drive: Drive, positions: Sequence[float] | None, times: Sequence[float] | None
) -> Points:
    """Indices of the path's points at these positions, each time the slider comes there, where it rests the first and
    the last of them; and at these times. None twice, in order.

    Raises InputError for what is none of the path's points, and for times on a path that has none.
    """
    found = [np.empty(0, np.intp)]
    close = _SAME_PLACE * float(np.abs(drive.path).max())
    for k, position in enumerate(positions or ()):
        away = np.abs(drive.path - finite(f"eq.histograms[{k}]", position))
        if away.min() > close:
            _refuse(f"eq.histograms[{k}]", position, drive.path, away, "")
        there = np.flatnonzero(away <= close)
        comes, leaves = (
            np.diff(there, prepend=-2) > 1,
            np.diff(there, append=drive.path.size + 1) > 1,
        )
        found.append(there[comes | leaves])
    if times is not None and drive.time is None:
        rule = "are of a path with drive.times; without them say where the slider is, as in histograms = [1.0]"
        refuse("eq.histogram_times", list(times), rule)
    for k, time in enumerate(times or ()):
        assert drive.time is not None
        away = np.abs(drive.time - finite(f"eq.histogram_times[{k}]", time))
        if away.min() > _SAME_TIME * abs(time):
            _refuse(f"eq.histogram_times[{k}]", time, drive.time, away, "; all of drive.times are")
        found.append(np.atleast_1d(away.argmin()))
    return np.unique(np.concatenate(found))


def _refuse(
    key: str,
    value: float,
    points: npt.NDArray[np.float64],
    away: npt.NDArray[np.float64],
    more: str,
) -> None:
    nearest = np.unique(points[np.argsort(away, kind="stable")[:2]])
    refuse(
        key,
        value,
        f"is none of the path's points; near it are {' and '.join(f'{x:.12g}' for x in nearest)}{more}",
    )
