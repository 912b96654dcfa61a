"""A scene's [drive]: where the slider goes, and when, as points of a path."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins.drive import Drive
from origins.errors import InputError, finite, positive, refuse, whole
from toolkit import laws

if TYPE_CHECKING:
    from toolkit.scene import DriveTable

_MOST_POINTS = 10_000_000


def make_drive(table: "DriveTable") -> Drive:
    """The checked drive of a scene. Raises InputError with the path of the bad key."""
    points = whole("drive.points", table.points, least=2)
    if points > _MOST_POINTS:
        refuse("drive.points", points, f"must be at most {_MOST_POINTS:,}")
    if (table.to is None) == (table.turns is None):
        both = "both are given" if table.to is not None else "neither is given"
        raise InputError(f"drive: needs one of to = 5.0 and turns = [3.0, -3.0, 3.0], and {both}")
    if table.times is not None and (table.turns is None or len(table.times) != len(table.turns)):
        refuse("drive.times", table.times, "needs drive.turns, with one time for each of them")
    ends = [positive("drive.to", table.to)] if table.turns is None else table.turns
    number, places = _spaced(ends, points, stands=table.times is not None)
    path = np.interp(np.arange(points), number, places)
    times = None if table.times is None else _times(table.times, number, places)
    with laws.inside("drive", {"velocity": "velocity", "time": "times", "spring": "spring", "slip": "slip"}):
        return Drive(path, table.velocity, times, table.spring, table.slip)


def _spaced(ends: list[float], points: int, stands: bool) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """0 and each of the ends in turn, and which of the points they are; these as even as that allows.

    Where the slider `stands` two may be the same.
    """
    places = np.array([0.0, *(finite(f"drive.turns[{k}]", end) for k, end in enumerate(ends))])
    if places.size < 2 or points < places.size:
        refuse("drive.turns", ends, f"must hold a position at least, and fewer than drive.points = {points}")
    same = np.flatnonzero(np.diff(places) == 0.0)
    if same.size and not stands:
        refuse(f"drive.turns[{same[0]}]", ends[same[0]], "is where the path already stands; leave it out")
    travelled = np.append(0.0, np.abs(np.diff(places)).cumsum())
    if travelled[-1] == 0.0:
        refuse("drive.turns", ends, "must lead away from X = 0")
    number = np.round(travelled / travelled[-1] * (points - 1)).astype(int)
    # each leg has a point of its own at least, whichever way rounding went
    number = np.maximum.accumulate(number - np.arange(places.size)) + np.arange(places.size)
    return np.minimum(number, points - 1 - np.arange(places.size)[::-1]), places


def _times(
    times: list[float], number: npt.NDArray[np.int64], places: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """When each of the points is reached, at one speed between the ends."""
    when = np.array([0.0, *(finite(f"drive.times[{k}]", time) for k, time in enumerate(times))])
    for k in np.flatnonzero((np.diff(when) < 0.0) | ((np.diff(when) == 0.0) & (np.diff(places) != 0.0))):
        refuse(f"drive.times[{k}]", times[k], f"must come after {when[k]:g}, when the slider is at {places[k]:g}")
    return np.interp(np.arange(number[-1] + 1), number, when)
