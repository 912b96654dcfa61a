"""What the curves of a run are drawn against: positions, or times where the scene gives them; and its conditions."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolkit.axes import Lengths
from toolkit.driving import make_drive
from toolkit.results import OWN_UNIT, Curve, Result, SoftRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]


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


def write_along(axes: "Axes", result: Result) -> None:
    """The axis of that."""
    reach = max((float(np.abs(along(result, curve)).max()) for curve in curves(result)), default=0.0)
    if clock(result) is not None:
        Lengths.of(reach, False).write(axes.xaxis, "time $t$")
        return
    place = "drive position $X_T$" if isinstance(result.master, SoftRecord) else "slider position $X$"
    Lengths.of(reach, result.thresholds.unit != OWN_UNIT).write(axes.xaxis, place)


def conditions(result: Result) -> str:
    """Temperature, delay, rate of ageing and speed as a picture tells them; empty where contacts have no such law."""
    asked = result.asked
    contacts = asked.contacts
    said = []
    if contacts.thermal is not None:
        temperature = contacts.thermal["temperature"]
        kelvin = isinstance(temperature, Mapping)
        said.append(f"$T$ = {temperature['kelvin']:.4g} K" if kelvin else f"$T$ = {temperature:.3g}")
    if contacts.delay is not None:
        said.append(rf"$\tau_m$ = {contacts.delay['time']:.3g}")
    if contacts.ageing is not None:
        said.append(f"$D$ = {contacts.ageing['rate']:.3g}")
    if said and asked.drive is not None and asked.drive.times is None:
        said.append(f"$v$ = {asked.drive.velocity:.3g}")
    return ", ".join(said)
