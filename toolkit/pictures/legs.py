"""The axis along a drive: positions or times, with holds shaded and steps of the speed marked."""

from typing import Any, NamedTuple

import numpy as np

from toolkit.pictures.axes import name_axis
from toolkit.pictures.traces import in_time
from toolkit.results.records import Result
from toolkit.scene.scale import written

_UNEVEN = 20.0  # legs whose durations differ by more are drawn equally wide
# legs that are named; part of the axis that a letter of a name needs; ticks at ends of legs
_MOST_LEGS, _LETTER, _TICKS = 12, 0.011, 8
# part of the axis along the drive that a line of upright text needs; of the one across, what words above the data need,
# and each letter of upright ones
_LINE, _WORDS, _UPRIGHT_LETTER = 0.02, 0.29, 0.05


class Leg(NamedTuple):
    """A straight piece of a drive in time: it begins and ends at these times, and goes at this speed, 0 in a hold."""

    begin: float
    end: float
    speed: float


def legs_of(result: Result) -> list[Leg]:
    """The legs of a drive whose turns have times; none of another."""
    table = result.asked.drive
    if table is None or table.times is None or table.turns is None:
        return []
    places = [table.begin or 0.0, *table.turns]
    times = [*([] if table.begin is not None else [0.0]), *table.times]
    pieces = zip(times, times[1:], places, places[1:], strict=False)
    return [Leg(t0, t1, (x1 - x0) / (t1 - t0)) for t0, t1, x0, x1 in pieces]


def write_along(axes: Any, result: Result) -> None:
    """Label this axis. With a hold_scale, or legs of very different durations, points are even on it, so that each
    decade of a hold, and each leg, is visible."""
    drive = result.asked.drive
    if not in_time(result):
        pulled = drive is not None and drive.spring is not None
        place = "drive position $X_T$" if pulled else "slider position $X$"
        name_axis(axes.xaxis, place, result.scale.length_unit)
        return
    legs = legs_of(result)
    lasting = [leg.end - leg.begin for leg in legs]
    uneven = len(legs) <= _MOST_LEGS and max(lasting, default=1.0) > _UNEVEN * min(
        lasting, default=1.0
    )
    if drive is None or (drive.hold_scale is None and not uneven):
        name_axis(axes.xaxis, "time $t$", result.scale.time_unit)
        return
    times, number = result.time, np.arange(result.time.size, dtype=float)
    both = (lambda t: np.interp(t, times, number), lambda n: np.interp(n, number, times))
    axes.set_xscale("function", functions=both)
    turns = np.unique([times[0], *(leg.end for leg in legs)])
    turns = turns[:: -(-turns.size // _TICKS)]  # evenly, as they stand where legs end
    axes.set_xticks(turns, [_in_short(time) for time in turns])
    axes.set_xlim(times[0], times[-1])
    scale = "each leg equally wide"
    if drive.hold_scale is not None:
        scale = f"even in ln(1 + t/{drive.hold_scale:.3g}) since each hold began"
    unit = "s" if result.thresholds.in_metres else "units of time"
    axes.set_xlabel(f"time $t$ ({unit}), {scale}")


def _in_short(time: float) -> str:
    """A time in three digits, or in all before its point; from a million on as a power of ten."""
    return f"{time:.0f}" if 1e3 <= abs(time) < 1e6 else f"{time:.3g}"


def mark_legs(axes: Any, result: Result, named: bool = False) -> None:
    """Shade holds, draw a line where the speed changes, and if `named` write the speed of each leg above the data."""
    legs = legs_of(result)
    if len(legs) < 2:
        return
    for leg in legs:
        if leg.speed == 0.0:
            axes.axvspan(leg.begin, leg.end, color="0.93", lw=0, zorder=0)
    for leg in legs[1:]:
        axes.axvline(leg.begin, color="0.7", lw=0.8, ls=":", zorder=1)
    if not named or len(legs) > _MOST_LEGS:
        return
    names = list[tuple[float, str, bool]]()
    for leg in legs:
        ends = axes.transData.transform([(leg.begin, 0.0), (leg.end, 0.0)])
        (left, _), (right, _) = axes.transAxes.inverted().transform(ends)
        unit = result.scale.speed_unit
        speed = f"{leg.speed:.3g}" if unit != "m/s" else written(leg.speed, unit, digits=3)
        said = "hold" if leg.speed == 0.0 else f"speed {speed}"
        upright = right - left < _LETTER * len(said)
        if upright:
            said = said.removeprefix("speed ")
        if not upright or right - left > _LINE:
            names.append((0.5 * (left + right), said, upright))
    room = max([_WORDS, *(_UPRIGHT_LETTER * len(said) for _, said, upright in names if upright)])
    low, high = axes.get_ylim()
    axes.set_ylim(low, low + (high - low) / (1.0 - room))
    for middle, said, upright in names:
        where: dict[str, Any] = {"transform": axes.transAxes, "ha": "center", "va": "top"}
        where |= {"rotation": "vertical"} if upright else {}
        axes.text(middle, 0.97, said, fontsize="small", **where)
