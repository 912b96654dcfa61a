"""What the curves of a run are drawn against: positions, or times where the scene gives them; and its conditions."""

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from toolkit.pictures.axes import Lengths
from toolkit.results.records import OWN_UNIT, Curve, Result, SoftRecord
from toolkit.scene.drive import make_drive

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from toolkit.scene.sweep import SweepRecord
    from toolkit.scene.tables import DriveTable

Array = npt.NDArray[np.float64]

_NCK = r"$N_c\langle k\rangle$"
_MARKS = str.maketrans("", "", "$^{}")  # of a formula
_WIDE = 70  # letters of a title's line
_DIGIT, _GAP = (
    0.0155,
    0.015,
)  # of an axis, which a digit of a tick's label takes, and the room between two


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
    at = np.searchsorted(solved.path, solved.slip_drive)
    there = np.interp(solved.slip_drive, solved.path, places)
    ends = np.column_stack([solved.slip_force_before, solved.slip_force_after]).ravel()
    return np.insert(places, at.repeat(2), there.repeat(2)), np.insert(force, at.repeat(2), ends)


def write_along(axes: "Axes", result: Result) -> None:
    """The axis of that."""
    reach = max(
        (float(np.abs(along(result, curve)).max()) for curve in curves(result)), default=0.0
    )
    times = clock(result)
    if (
        times is not None
        and result.asked.drive is not None
        and result.asked.drive.hold_scale is not None
    ):
        _write_stretched(axes, times, result.asked.drive)
        scale = f"{result.asked.drive.hold_scale:.3g}{' s' * bool(units(result, 's'))}"
        axes.set_xlabel(
            f"time $t${units(result, 's')}, with + since the turn before; each leg has a scale of its own,\n"
            f"that of a hold is logarithmic, even in ln(1 + t/{scale})"
        )
        return
    if times is not None:
        Lengths.of(reach, False).write(axes.xaxis, "time $t$" + units(result, "s"))
        return
    drive = result.asked.drive
    pulled = drive is not None and drive.spring is not None
    place = "drive position $X_T$" if pulled else "slider position $X$"
    Lengths.of(reach, result.thresholds.unit != OWN_UNIT).write(axes.xaxis, place)


def _write_stretched(axes: "Axes", times: Array, asked: "DriveTable") -> None:
    """An axis of times on which points are even, so that the decades of a hold can be told; ticks where it turns, and
    at powers of ten in holds, counted from where they begin, as is a time that is that of the turn before in print."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    number = np.arange(times.size, dtype=float)

    def places(time: Array | float) -> Array:
        return np.interp(time, times, number)

    def back(place: Array) -> Array:
        return np.interp(place, number, times)

    axes.set_xscale("function", functions=(places, back))
    axes.set_xlim(times[0], times[-1])
    ends = np.unique(np.append(times[0], np.asarray(asked.times)))
    told = [f"{end:.7g}" for end in ends]
    for k in range(1, ends.size):
        if told[k] == f"{ends[k - 1]:.7g}":  # what a hold of years leaves of a time
            told[k] = f"+{ends[k] - ends[k - 1]:.4g}"
    ticks = [
        (float(ends[k]), told[k]) for k in (-1, *range(ends.size - 1))
    ]  # first come, first kept
    path = make_drive(asked).path
    for begin, end in pairwise(ends):
        if np.ptp(path[(times >= begin) & (times <= end)]) == 0.0:
            first, last = np.log10([asked.hold_scale or 1.0, end - begin])
            powers = np.arange(np.ceil(first), np.floor(last) + 1.0)
            ticks += [(float(begin + 10.0**power), f"+$10^{{{power:.0f}}}$") for power in powers]
    kept: list[tuple[float, str]] = []
    for at, text in ticks:
        room = (
            abs(places(at) - places(other)) / times.size - _half(text) - _half(there)
            for other, there in kept
        )
        if all(gap > _GAP for gap in room):
            kept.append((at, text))
    kept.sort()
    axes.xaxis.set_major_locator(FixedLocator([at for at, _ in kept]))
    axes.xaxis.set_major_formatter(FixedFormatter([text for _, text in kept]))


def _half(text: str) -> float:
    """Half the width of a tick's label, of an axis; powers are smaller than what they stand at."""
    return 0.5 * _DIGIT * len(text.translate(_MARKS))


def units(result: Result, unit: str) -> str:
    """An SI unit in brackets, as an axis has it, where lengths are in metres; else nothing."""
    return f" ({unit})" if result.thresholds.unit != OWN_UNIT else ""


def grows(result: Result) -> bool:
    """Whether thresholds grow with the age of each contact."""
    return result.asked.contacts.thresholds.get("kind") == "growing-grains"


def conditions(result: Result, sweep: "SweepRecord | None" = None) -> str:
    """The laws of the contacts and their numbers as a picture tells them, in lines; empty where contacts have none. Of
    a sweep those that it does not vary."""

    def told(symbol: str, value: float, unit: str) -> str:
        return f"${symbol}$ = {value:.3g}" + (
            f" {unit}" if result.thresholds.unit != OWN_UNIT else ""
        )

    def value(name: str, own: float) -> float:
        """A sweep may have one of its own."""
        values = getattr(sweep, name, None)
        return own if values is None else float(values.flat[0])

    def temperature(table: Mapping[str, Any]) -> str:
        own = table["temperature"]
        if table is contacts.thermal and sweep is not None and sweep.kelvin is not None:
            own = {"kelvin": sweep.kelvin.flat[0]}
        elif table is contacts.thermal and not isinstance(own, Mapping):
            own = value("temperature", own)
        return f"$T$ = {own['kelvin']:.4g} K" if isinstance(own, Mapping) else told("T", own, "m²")

    asked = result.asked
    contacts, again = asked.contacts, asked.contacts.reforming
    closure = {"paper": " (paper's closure)"}
    swept = () if sweep is None else sweep.along
    said = []
    if (thermal := contacts.thermal) is not None:
        said.append(f"{thermal['law']} law{closure.get(thermal.get('closure', ''), '')}")
        if not {"temperature", "kelvin"} & set(swept):
            said[-1] += f" at {temperature(thermal)}"
        said.append(told(r"\omega", thermal.get("attempt_frequency", 1.0), "1/s"))
    if contacts.stiffness == "linked":
        said.append("linked $k \\sim x_s$")
    if again is not None:
        place = (
            temperature(again)
            if "temperature" in again
            else f"{again.get('value', again.get('mean')):.3g}"
        )
        width = f" ± {again['std']:.3g}" if "std" in again else ""
        unit = " m" if result.thresholds.unit != OWN_UNIT and "temperature" not in again else ""
        said.append(f"re-forming at {place}{width}{unit}")
    delay = value("delay", contacts.delay["time"] if contacts.delay is not None else 0.0)
    if delay and "delay" not in swept:
        said.append(told(r"\tau_m", delay, "s"))
    if contacts.ageing is not None and "rate" not in swept:
        rate = told("D", value("rate", contacts.ageing["rate"]), "m²/s")
        said.append(rate + closure.get(contacts.ageing.get("closure", ""), ""))
    if grows(result):
        said.append(rf"$\alpha$ = {contacts.thresholds['alpha']:.3g}")
    if sweep is not None and "velocity" not in swept:
        said.append(told("v", float(sweep.velocity.flat[0]), "m/s"))
    elif said and sweep is None and asked.drive is not None and asked.drive.times is None:
        said.append(told("v", asked.drive.velocity, "m/s"))
    if sweep is None and asked.drive is not None and asked.drive.spring is not None:
        spring = asked.drive.spring
        own = spring.replace("N_c<k>", _NCK) if isinstance(spring, str) else f"{spring:.3g} {_NCK}"
        said.append(f"$K$ = {own}, slip: {asked.drive.slip or 'reset'}")
    return _in_lines(said)


def _in_lines(said: list[str]) -> str:
    lines: list[str] = []
    for part in said:
        if lines and len((lines[-1] + part).translate(_MARKS)) < _WIDE:
            lines[-1] += f", {part}"
        else:
            lines.append(part)
    return ",\n".join(lines)
