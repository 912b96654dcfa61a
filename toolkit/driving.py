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
    ends = [positive("drive.to", table.to)] if table.turns is None else table.turns
    path, time = _path(ends, table.times, points)
    if table.slip is not None and table.spring is None:
        rule = "is what a slip of a soft slider does, and without drive.spring the slider is rigid; give one or neither"
        refuse("drive.slip", table.slip, rule)
    with laws.inside("drive", {"velocity": "velocity", "time": "times", "spring": "spring", "slip": "slip"}):
        return Drive(path, table.velocity, time, table.spring, table.slip or "reset")


def _path(
    ends: list[float], times: list[float] | None, points: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None]:
    """Straight from 0 to each of the ends in turn, all of them among the points, and when; points as even as that
    allows, with times as many to each piece."""
    places = np.array([0.0, *(finite(f"drive.turns[{k}]", end) for k, end in enumerate(ends))])
    if places.size < 2 or points < places.size:
        refuse("drive.turns", ends, f"must hold a position at least, and fewer than drive.points = {points}")
    if times is not None:
        if len(times) != len(ends):
            refuse("drive.times", times, f"must hold one time for each of drive.turns, {len(ends)}")
        clock = np.array([0.0, *(finite(f"drive.times[{k}]", at) for k, at in enumerate(times))])
        back = np.flatnonzero(np.diff(clock) <= 0.0)
        if back.size:
            refuse(f"drive.times[{back[0]}]", times[back[0]], "must be later than the time before, 0 the first of them")
        number = _numbers(np.arange(places.size, dtype=float), points)
        return tuple(np.interp(np.arange(points), number, values) for values in (places, clock))
    same = np.flatnonzero(np.diff(places) == 0.0)
    if same.size:
        rule = "is where the path already stands; leave it out, or give drive.times for a hold"
        refuse(f"drive.turns[{same[0]}]", ends[same[0]], rule)
    number = _numbers(np.append(0.0, np.abs(np.diff(places)).cumsum()), points)
    return np.interp(np.arange(points), number, places), None


def _numbers(travelled: npt.NDArray[np.float64], points: int) -> npt.NDArray[np.int64]:
    """Which of the points are corners, these having travelled so far."""
    number = np.round(travelled / travelled[-1] * (points - 1)).astype(int)
    # each leg has a point of its own at least, whichever way rounding went
    corner = np.arange(travelled.size)
    number = np.maximum.accumulate(number - corner) + corner
    return np.minimum(number, points - 1 - corner[::-1])
