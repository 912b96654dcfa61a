"""Curves of a soft slider with each slip at its own place, from the slip's own data."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array
from toolkit.results.kinds import is_heavy, is_precise
from toolkit.results.records import Result

# Part of a curve's range that is seen; the share of the points of its swings at which it turns above which a line would
# draw slower swings that do not exist: of swings with eight points each it is a quarter; and how many turns are so many
# that they are swings.
_SEEN, _TOO_FEW_POINTS, _SWINGS = 0.02, 0.3, 3
# of the median step of the drive: shorter ones are those of a slip, which is drawn from its own data
_OF_A_SLIP = 0.1
# neighbouring points of a curve that swings between them, of which a band has the least and the largest: of so many at
# any phases one is mostly within a tenth of the amplitude from the end of a swing
_IN_BAND = 12


class SlipData(NamedTuple):
    """Slips of one slider, arrays of shape (m,): X_T as each begins; X and F/(N_c<k>) before and after it; how long it
    lasts and its top speed, None for slips that take no time."""

    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    duration: Array | None
    top_speed: Array | None


def in_time(result: Result) -> bool:
    """Whether curves are drawn against time: where the scene gives times, and where slips take time."""
    heavy = is_heavy(result.eq) or getattr(result.master, "velocity", None) is not None
    return bool(result.curves) and (result.timed or heavy)


def along(result: Result, curve: Any) -> Array:
    """The abscissa of a curve: times, or its path."""
    return result.time[: curve.path.size] if in_time(result) else curve.path


def slips_of(curve: Any, replica: int | None = None) -> SlipData | None:
    """The slips of a solver's answer, of an ensemble those of one replica; None of a rigid slider."""
    slips = getattr(curve, "slips", None)
    if slips is None:
        return None
    own = slice(None) if replica is None else slips.replica == replica
    kept: list[Any] = [getattr(slips, name, None) for name in SlipData._fields]
    kept = [None if one is None else np.asarray(one)[own] for one in kept]
    return SlipData(*kept)


def hides_swings(
    drive: Array, value: Array, slips: SlipData | None = None, speed: bool = False
) -> bool:
    """Whether the points of a curve of a slider with mass, shape (n,), are too far apart to show how it swings: it then
    turns at most of those that are on a swing.

    Steps on which a slip begins or goes on are left out, as it is drawn from its own data, and those on which little
    happens: of a `speed` little beside the top speed of slips.
    """
    steps, height = np.diff(value), float(np.ptp(value))
    if speed and slips is not None and slips.top_speed is not None:
        height = max(height, float(slips.top_speed.max(initial=0.0)))
    run = np.abs(np.diff(drive))
    seen = (np.abs(steps) > _SEEN * height) & (run >= _OF_A_SLIP * np.median(run))
    if slips is not None:
        places, ends = np.sort(slips.drive), np.sort([drive[:-1], drive[1:]], axis=0)
        seen &= np.searchsorted(places, ends[1], "right") == np.searchsorted(places, ends[0])
    pairs = seen[1:] & seen[:-1]
    turns = pairs & (steps[1:] * steps[:-1] < 0.0)
    return bool(turns.sum() >= max(_SWINGS, _TOO_FEW_POINTS * pairs.sum()))


def swings_between(curve: Any, value: Any, replica: int | None = None, speed: bool = False) -> bool:
    """Whether the curve of a slider with mass, or of one of its replicas, swings between the points of the path."""
    if getattr(curve, "velocity", None) is None:  # without a mass
        return False
    known, slips = is_heavy(curve) or is_precise(curve), slips_of(curve, replica)
    return known and hides_swings(curve.path, value, slips, speed)


def draw_curve(axes: Any, place: Array, value: Array, swings: bool, style: dict[str, Any]) -> None:
    """A curve of shape (n,) as a line, or where it `swings` between its points as a band from the least to the largest
    value of neighbouring ones, as a line would draw slower swings that do not exist."""
    if not swings:
        axes.plot(place, value, **style)
        return
    number = min(_IN_BAND, value.size)
    padded = np.pad(value, (number // 2, number - 1 - number // 2), mode="edge")
    near = np.lib.stride_tricks.sliding_window_view(padded, number)
    kept = {name: own for name, own in style.items() if name in ("color", "label", "zorder")}
    axes.fill_between(place, near.min(axis=1), near.max(axis=1), alpha=0.35, lw=0.5, **kept)


def with_slips(
    place: Array, drive: Array, value: Array, slips: SlipData | None, position: bool = False
) -> tuple[Array, Array]:
    """A curve with the ends of each slip where it happens, between points of the path.

    place : abscissae, which are times where slips last; drive : X_T, value : F/(N_c<k>), or X if `position`; all of
    shape (n,)
    """
    if slips is None or not slips.drive.size:
        return place, value
    names = ("before", "after") if position else ("force_before", "force_after")
    ends = np.column_stack([getattr(slips, name) for name in names])
    segments = _segments(drive, value, slips.drive, ends)
    kept = segments >= 0
    if slips.duration is not None:
        # X_T does not tell when a slip that lasts begins in a hold: the points of the path show it
        kept &= drive[segments + 1] != drive[segments]
    segments, ends, at_drive = segments[kept], ends[kept], slips.drive[kept]
    begin = _moments(place, drive, at_drive, segments)
    if slips.duration is not None:
        # points of the path may lie within a slip: all are brought into the order of time
        where = np.concatenate([place, begin, begin + slips.duration[kept]])
        order = np.argsort(where, kind="stable")
        return where[order], np.concatenate([value, *ends.T])[order]
    # of a point just at a slip the value may be that before it: then the slip comes after the point
    off = np.abs(value[segments + 1, None] - ends)
    still = (drive[segments + 1] == at_drive) & (off[:, 0] < off[:, 1])
    at = (segments + 1 + still).repeat(2)
    return np.insert(place, at, begin.repeat(2)), np.insert(value, at, ends.ravel())


def moments(place: Array, drive: Array, value: Array, slips: SlipData) -> Array:
    """The abscissae at which the slips begin; arguments as in `with_slips`; nan before the path and in holds."""
    ends = np.column_stack([slips.force_before, slips.force_after])
    segments = _segments(drive, value, slips.drive, ends)
    found = _moments(place, drive, slips.drive, np.maximum(segments, 0))
    moving = (segments >= 0) & (drive[segments + 1] != drive[segments])
    return np.where(moving, found, np.nan)


def _segments(
    drive: Array, value: Array, places: Array, ends: npt.NDArray[np.float64]
) -> npt.NDArray[np.intp]:
    """Indices of the points of the path after which the slips at `places` come, in the order of time; -1 for one before
    the path begins. A drive that turns comes to a place several times: a slip is where the values fit best."""
    low, high = np.minimum(drive[1:], drive[:-1]), np.maximum(drive[1:], drive[:-1])
    found, begin = np.full(places.size, -1, np.intp), 0
    for number, place in enumerate(places):
        there = begin + np.flatnonzero((low[begin:] <= place) & (place <= high[begin:]))
        if not there.size:
            continue
        first, second = ends[number]
        misfit = np.abs(value[there] - first) + np.abs(value[there + 1] - second)
        fits = misfit <= 2.0 * misfit.min() + 0.05 * abs(first - second)
        begin = found[number] = there[np.flatnonzero(fits)[0]]
    return found


def _moments(
    place: Array, drive: Array, slips: Array, segments: npt.NDArray[np.intp]
) -> npt.NDArray[np.float64]:
    """Abscissae of slips within their segments; in a hold, where the drive stands, at the segment's end."""
    run = drive[segments + 1] - drive[segments]
    moved = np.where(run == 0.0, 1.0, run)
    fraction = np.where(run == 0.0, 1.0, (slips - drive[segments]) / moved)
    return np.asarray(place[segments] + fraction * (place[segments + 1] - place[segments]))
