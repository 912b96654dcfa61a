"""What the curves of a run are drawn against: positions, or times where the scene gives them; and its conditions."""

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolkit.pictures.axes import name_lengths
from toolkit.results.records import Curve, Result, SoftRecord
from toolkit.scene.drive import make_drive
from toolkit.scene.sweep import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from toolkit.scene.sweep import SweepRecord

Array = npt.NDArray[np.float64]

_WIDE = 90  # letters of a title's line
_TICKS = 8  # at most, at turns of a drive whose holds are drawn stretched


def curves(result: Result) -> list[Curve]:
    """What the solvers found, the master equation's first."""
    return [curve for curve in (result.master, result.eq) if curve is not None]


def clock(result: Result) -> Array | None:
    """When each point of the path is reached, where the scene says so; else None."""
    asked = result.asked.drive
    return None if asked is None or asked.times is None else make_drive(asked).time


def along(result: Result, curve: Curve) -> Array:
    """What a curve is drawn against: times where there are some, else its path."""
    times = clock(result)
    return curve.path if times is None else times[: curve.path.size]


def with_slips(places: Array, force: Array, solved: SoftRecord) -> tuple[Array, Array]:
    """The curve with the ends of each slip put in where it happens, between points of the path.

    `places` are what the curve is drawn against. A drive that turns or rests is left as it is.
    """
    if not (np.diff(solved.path) > 0.0).all():
        return places, force
    slips = solved.slips
    at = np.searchsorted(solved.path, slips.drive)
    there = np.interp(slips.drive, solved.path, places)
    ends = np.column_stack([slips.force_before, slips.force_after]).ravel()
    return np.insert(places, at.repeat(2), there.repeat(2)), np.insert(force, at.repeat(2), ends)


def write_along(axes: "Axes", result: Result) -> None:
    """The axis of that. Where holds have a scale, points are even on it, so that each decade of a hold can be told."""
    times, drive = clock(result), result.asked.drive
    if times is None or drive is None:
        pulled = drive is not None and drive.spring is not None
        place = "drive position $X_T$" if pulled else "slider position $X$"
        name_lengths(axes.xaxis, place, result.in_metres)
        return
    unit = " (s)" if result.in_metres else ""
    axes.set_xlabel(f"time $t${unit}")
    if drive.hold_scale is None or drive.times is None:
        return
    number = np.arange(times.size, dtype=float)
    axes.set_xscale(
        "function",
        functions=(lambda t: np.interp(t, times, number), lambda n: np.interp(n, number, times)),
    )
    axes.set_xlim(times[0], times[-1])
    turns = np.unique([times[0], *drive.times])
    some = turns[:: -(-turns.size // _TICKS)]
    told = [f"{time:.7g}" for time in some]
    for k in range(1, some.size):
        if told[k] == f"{some[k - 1]:.7g}":  # what a hold of years leaves of a time
            told[k] = f"+{some[k] - some[k - 1]:.3g}"
    axes.set_xticks(some, told)
    axes.set_xticks([], minor=True)
    axes.set_xlabel(
        f"time $t${unit}, with + since the turn before; each leg has a scale of its own,\n"
        f"that of a hold is logarithmic, even in ln(1 + t/{drive.hold_scale:.3g})"
    )


def grows(result: Result) -> bool:
    """Whether thresholds grow with the age of each contact."""
    return result.asked.contacts.thresholds.get("kind") == "growing-grains"


def conditions(result: Result, sweep: "SweepRecord | None" = None) -> str:
    """The laws of the contacts and their numbers as a picture tells them, in lines; empty where contacts have none.

    Of a sweep those that it does not vary.
    """
    contacts, drive, said = result.asked.contacts, result.asked.drive, []
    swept = (
        {} if sweep is None else {name: getattr(sweep, name) for name in (*QUANTITIES, "kelvin")}
    )
    varied = {name for name, values in swept.items() if values is not None}
    varied |= {"time"} if "delay" in varied else set()  # the scene's key for it
    for law in ("thermal", "ageing", "delay", "reforming"):
        table = getattr(contacts, law) or {}
        numbers = [_told(key, value) for key, value in table.items() if key not in varied]
        said += [f"{law}: {', '.join(filter(None, numbers))}"] if any(numbers) else []
    if contacts.stiffness == "linked":
        said.append("linked $k \\sim x_s$")
    if grows(result):
        said.append(f"alpha = {contacts.thresholds['alpha']:.3g}")
    same = varied - {"time", *(() if sweep is None else sweep.along)}
    same -= {"temperature"} if "kelvin" in varied else set()
    said += [f"{name} = {swept[name].flat[0]:.3g}" for name in sorted(same)]
    if sweep is None and drive is not None:
        if said and drive.times is None:
            said.append(f"v = {drive.velocity:.3g}")
        if drive.spring is not None:
            spring = drive.spring if isinstance(drive.spring, str) else f"{drive.spring:.3g} N_c<k>"
            said.append(f"spring {spring}, slip: {drive.slip or 'reset'}")
    return textwrap.fill("; ".join(said), _WIDE)


def _told(key: str, value: object) -> str:
    """A key of a scene and its value in words; nothing of a table such as another law."""
    if isinstance(value, Mapping):
        return f"{value['kelvin']:.4g} K" if "kelvin" in value else ""
    name = key.replace("_", " ")
    return f"{name} = {value:.3g}" if isinstance(value, int | float) else f"{name} {value}"
