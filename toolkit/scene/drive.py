"""A scene's [drive]: the points of the slider's path, and their times."""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.contacts import Contacts
from origins.drive import Drive
from origins.errors import InputError, finite, positive, refuse, whole
from toolkit.scene import laws
from toolkit.scene.tables import DriveTable

Array = npt.NDArray[np.float64]

_SPRING = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?) (N/m|N_c<k>)")
_MOST_POINTS = 10_000_000
_LEAST_SCALE = 1e-14  # of the last time: a smaller scale is lost in rounding
_SAME = 1e-9  # relative distance at which positions, or times, count as equal
_KEYS = {"velocity": "velocity", "time": "times", "spring": "spring", "slip": "slip"}


def spring_number(table: DriveTable, contacts: Contacts) -> float | None:
    """drive.spring as K/(N_c<k>), a number; None without one. Raises InputError.

    Text gives the unit: "0.5 N_c<k>", or "50 N/m", which needs thresholds from a surface and drive.area, the nominal
    area in m². For a surface a bare number is refused, as either unit could be meant.
    """
    interface, given, unit = contacts.interface, table.spring, ""
    if isinstance(given, str):
        if (read := _SPRING.fullmatch(given)) is None:
            refuse("drive.spring", given, 'must be a number and a unit, "50 N/m" or "0.5 N_c<k>"')
        value, unit = positive("drive.spring", float(read[1]), "such as 0.5"), read[2]
    if table.area is not None and unit != "N/m":
        rule = 'is for a spring in N/m, such as spring = "50 N/m"; leave it out'
        refuse("drive.area", table.area, rule)
    if unit == "N_c<k>":
        return value
    if interface is None or given is None:
        if unit:
            rule = "needs <k> in N/m, which thresholds from a rough surface know; give a number"
            refuse("drive.spring", given, rule)
        return given  # type: ignore[return-value]  # no text
    each = interface.contact_density * interface.mean_stiffness
    if not unit:
        refuse(
            "drive.spring",
            given,
            f'has no unit; of a surface write either spring = "{given:g} N/m" with area = the nominal area in m², of '
            f'which each has N_c<k> = {each:.3g} N/m, or spring = "{given:g} N_c<k>" for so many times that',
        )
    if table.area is None or interface.contact_density * positive("drive.area", table.area) < 1.0:
        rule = f"needs drive.area, the nominal area in m² of a whole slider, with some contacts; it is {table.area}"
        refuse("drive.spring", given, rule)
    return value / (each * table.area)


def make_drive(table: DriveTable, spring: float | None = None) -> Drive:
    """The checked drive of a scene. Raises InputError with the path of the bad key.

    `spring` is the result of `spring_number`. Left out, one with a unit counts as 1, where only the path is needed.
    """
    if spring is None:
        spring = 1.0 if isinstance(table.spring, str) else table.spring
    points = whole("drive.points", table.points, least=2)
    places, clock = _corners(table)
    if not places.size <= points <= _MOST_POINTS:
        rule = f"must be at most {_MOST_POINTS:,}, and at least as many as the path has ends, {places.size}"
        refuse("drive.points", points, rule)
    path, time = _path(places, clock, points, table.hold_scale)
    with laws.inside("drive", _KEYS):
        return Drive(path, table.velocity, time, spring, table.slip or "reset")  # type: ignore[arg-type]


class Speed(NamedTuple):
    """A speed of smooth sliding, length per time; `chosen` says which of the scene's speeds it is, if it has more."""

    value: float
    chosen: str = ""


def sliding_speed(drive: Drive | None, swept: Array | None = None) -> Speed:
    """The speed of a scene: of its first leg that is not a hold; without a drive the first of `swept`; else 1."""
    if drive is None:
        if swept is None:
            return Speed(1.0, "as none is given")
        return Speed(float(swept.flat[0]), "the sweep's first" if np.ptp(swept) > 0.0 else "")
    moved = np.diff(drive.path)
    if drive.time is None or not moved.any():
        return Speed(drive.velocity)
    speeds = np.abs(moved / np.diff(drive.time))[moved != 0.0]
    alike = np.allclose(speeds, speeds[0], rtol=1e-6)  # but for how times round
    return Speed(float(f"{speeds[0]:.12g}"), "" if alike else "the first leg's")


def _corners(table: DriveTable) -> tuple[Array, Array | None]:
    """The first position (0 by default) and all ends in order, and the times of these, if they are given."""
    if (table.to is None) == (table.turns is None):
        raise InputError(
            "drive: needs one of to and turns, such as to = 5.0 or turns = [3.0, -3.0, 3.0]; "
            f"{'neither is' if table.to is None else 'both are'} given"
        )
    if table.to is not None and finite("drive.to", table.to) <= 0.0:
        rule = f"must be above zero; for the other way write turns = [{table.to or -1.0:g}]"
        refuse("drive.to", table.to, rule)
    turns = [table.to] if table.turns is None else table.turns
    ends = [finite(f"drive.turns[{k}]", end) for k, end in enumerate(turns)]
    if not ends:
        refuse("drive.turns", [], "must hold a position at least")
    places = np.array([finite("drive.from", table.begin or 0.0), *ends])
    if table.times is None:
        if (places[1:] == places[:-1]).any():
            key, value = ("turns", ends) if table.turns is not None else ("to", table.to)
            rule = "has a leg of no length; leave it out, or give drive.times for a hold"
            refuse(f"drive.{key}", value, rule)
        return places, None
    given = table.begin is not None
    if len(table.times) != len(ends) + given:
        own = "drive.from and each of drive.turns" if given else "each of drive.turns"
        refuse("drive.times", table.times, f"must hold one time for {own}, {len(ends) + given}")
    clock = np.array([finite(f"drive.times[{k}]", at) for k, at in enumerate(table.times)])
    back = np.flatnonzero(np.diff(clock, prepend=[] if given else 0.0) <= 0.0) + given
    if back.size:
        rule = "must be later than the time before, 0 the first of them without drive.from"
        refuse(f"drive.times[{back[0]}]", clock[back[0]], rule)
    return places, clock if given else np.append(0.0, clock)


def _path(
    places: Array, clock: Array | None, points: int, hold_scale: float | None
) -> tuple[Array, Array | None]:
    """Points of the straight pieces between the corners, which are included, and their times. Points are as even as
    possible; with times each piece has equally many, and those of a hold are even in ln(1 + t/hold_scale)."""
    corner = np.arange(places.size)
    travelled = np.append(0.0, np.abs(np.diff(places)).cumsum()) if clock is None else corner
    number = np.round(travelled / travelled[-1] * (points - 1)).astype(int)
    # each leg has at least one point, whatever the rounding
    number = np.maximum.accumulate(number - corner) + corner
    number = np.minimum(number, points - 1 - corner[::-1])
    path = np.interp(np.arange(points), number, places)
    time = None if clock is None else np.interp(np.arange(points), number, clock)
    if hold_scale is None:
        return path, time
    scale, holds = positive("drive.hold_scale", hold_scale), np.flatnonzero(np.diff(places) == 0.0)
    if clock is None or time is None or not holds.size or scale < _LEAST_SCALE * clock[-1]:
        rule = "is of holds: turns where the path stands, with drive.times not too far beyond it"
        raise InputError(f"drive.hold_scale = {hold_scale}: {rule}")
    for leg in holds:
        share = np.linspace(0.0, 1.0, number[leg + 1] - number[leg] + 1)[1:-1]
        later = scale * np.expm1(share * np.log1p((clock[leg + 1] - clock[leg]) / scale))
        time[number[leg] + 1 : number[leg + 1]] = clock[leg] + later
    return path, time


def histogram_points(
    drive: Drive, positions: Sequence[float] | None, times: Sequence[float] | None
) -> npt.NDArray[np.intp]:
    """Indices of the path's points at these positions, each time the slider comes there (at a hold the first and the
    last of them), and at these times; in order, none twice.

    Raises InputError for values that are none of the path's points, and for times on a path that has none.
    """
    if times is not None and drive.time is None:
        rule = "are of a path with drive.times; without them say where the slider is, as in histograms = [1.0]"
        refuse("eq.histogram_times", list(times), rule)
    found, clock = set[int](), drive.path if drive.time is None else drive.time
    for name, asked, points in (
        ("histograms", positions, drive.path),
        ("histogram_times", times, clock),
    ):
        for k, value in enumerate(asked or ()):
            off = np.abs(points - finite(f"eq.{name}[{k}]", value))
            there = np.flatnonzero(off <= _SAME * max(abs(value), np.abs(drive.path).max()))
            if name == "histogram_times":
                there = np.flatnonzero((off <= _SAME * abs(value)) & (off == off.min()))[:1]
            if not there.size:
                near = np.unique(points[np.argsort(off, kind="stable")[:2]])
                rule = f"is none of the path's points; near it are {' and '.join(f'{x:.12g}' for x in near)}"
                all_are = "; all of drive.times are" if name == "histogram_times" else ""
                refuse(f"eq.{name}[{k}]", value, rule + all_are)
            found |= {int(at) for at in there if at - 1 not in there or at + 1 not in there}
    return np.array(sorted(found), np.intp)
