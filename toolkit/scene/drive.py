"""A scene's [drive]: the points of the slider's path, and their times."""

import re
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.contacts import Contacts
from origins.drive import Drive
from origins.errors import InputError, positive, refuse
from origins.thresholds.law import Array
from toolkit.scene import laws
from toolkit.scene.tables import DriveTable, EqTable

_SPRING = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?) (N/m|N_c<k>)")


def spring_number(table: DriveTable, contacts: Contacts) -> float | None:
    """drive.spring as K/(N_c<k>), a number; None without one. Raises InputError.

    Text gives the unit: "0.5 N_c<k>", or "50 N/m", which needs thresholds from a surface and drive.area, the nominal
    area in m². For a surface a bare number is refused, as either unit could be meant.
    """
    interface, given, unit = contacts.interface, table.spring, ""
    if isinstance(given, str):
        if (read := _SPRING.fullmatch(given)) is None:
            refuse("drive.spring", given, 'must be a number and a unit, "50 N/m" or "0.5 N_c<k>"')
        given, unit = positive("drive.spring", float(read[1])), read[2]
    if unit == "N/m":
        if interface is None:
            hint = "in N/m needs <k> in N/m, which thresholds from a rough surface know"
            raise InputError(f"drive.spring: {hint}; give a number")
        if table.area is None:
            refuse("drive.spring", table.spring, "needs drive.area, the nominal area in m²; add it")
        if (held := interface.contact_density * table.area) < 1.0:
            hint = f"holds {held:.2g} contacts; give over {1.0 / interface.contact_density:.2g} m²"
            refuse("drive.area", table.area, hint)
        return positive("drive.spring", given) / (held * interface.mean_stiffness)
    if interface is not None and given is not None and not unit:
        hint = f'has no unit; of a surface write either spring = "{given:g} N/m" with area = the nominal area in m²'
        refuse("drive.spring", given, f'{hint}, or spring = "{given:g} N_c<k>"')
    if table.area is not None and interface is None:
        refuse("drive.area", table.area, 'is for a spring in N/m, as "50 N/m"; leave it out')
    return given


def has_path(table: DriveTable) -> bool:
    """Whether the table says where the drive goes; without it describes a machine, whose path a verdict finds."""
    return table.to is not None or table.turns is not None


def make_drive(table: DriveTable, spring: float | None = None) -> Drive:
    """The checked drive of a scene. Raises InputError with the path of the bad key. `spring` is the result of
    `spring_number`. Left out, one with a unit counts as 1, where only the path is needed."""
    if spring is None:
        spring = 1.0 if isinstance(table.spring, str) else table.spring
    places, clock = _corners(table)
    if places.size > table.points:
        refuse("drive.points", table.points, f"the path has {places.size} ends; give as many")
    path, time = _path(places, clock, table.points, table.hold_scale)
    keys = {"velocity": "velocity", "time": "times", "spring": "spring", "slip": "slip"}
    with laws.inside("drive", keys):
        return Drive(path, table.velocity, time, spring, table.slip or "reset")  # type: ignore[arg-type]


def sliding_speed(drive: Drive | None, swept: Array | None = None) -> float:
    """The speed (length per time) of a scene's smooth sliding: of its first leg that is not a hold; without a drive the
    first of `swept`; else 1."""
    if drive is None:
        return 1.0 if swept is None else float(swept.flat[0])
    moved = np.diff(drive.path)
    if drive.time is None or not moved.any():
        return drive.velocity
    first = np.flatnonzero(moved)[0]
    speed = abs(moved[first]) / (drive.time[first + 1] - drive.time[first])
    return float(f"{speed:.12g}")  # without what times are rounded by


def _corners(table: DriveTable) -> tuple[Array, Array | None]:
    """The first position (0 by default) and all ends in order, and the times of these, if they are given."""
    if (table.to is None) == (table.turns is None):
        raise InputError(
            "drive: needs one of to and turns, such as to = 5.0 or turns = [3.0, -3.0, 3.0]; "
            f"{'neither is' if table.to is None else 'both are'} given"
        )
    ends = [table.to] if table.turns is None else table.turns
    places = np.array([table.begin or 0.0, *ends], float)
    if table.times is None:
        if (places[1:] == places[:-1]).any() or not ends:
            refuse("drive.turns", ends, "has a leg of no length; for a hold give drive.times")
        return places, None
    clock = np.array([*([] if table.begin is not None else [0.0]), *table.times])
    if clock.size != places.size:
        count = places.size - (table.begin is None)
        hint = f"must hold one time for drive.from and each of drive.turns, {count}"
        refuse("drive.times", table.times, hint)
    if (np.diff(clock) <= 0.0).any():
        refuse("drive.times", table.times, "each must be later than the one before, and than 0")
    return places, clock


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
    holds = np.flatnonzero(np.diff(places) == 0.0)
    # a scale below 1e-14 of the last time is lost in rounding
    if clock is None or time is None or not holds.size or hold_scale < 1e-14 * clock[-1]:
        hint = "is for holds: a position twice in drive.turns, with drive.times; at least 1e-14 of the last"
        raise InputError(f"drive.hold_scale = {hold_scale}: {hint}")
    for leg in holds:
        share = np.linspace(0.0, 1.0, number[leg + 1] - number[leg] + 1)[1:-1]
        later = hold_scale * np.expm1(share * np.log1p((clock[leg + 1] - clock[leg]) / hold_scale))
        time[number[leg] + 1 : number[leg + 1]] = clock[leg] + later
    return path, time


def histogram_points(drive: Drive, asked: EqTable) -> npt.NDArray[np.intp]:
    """Indices of the path's points at eq.histograms, each time the slider comes there (at a hold the first and the last
    of them), and at eq.histogram_times; in order, none twice. Raises InputError for values that are none of the path's
    points, and for times on a path that has none."""
    places: dict[str, Any] = {"histograms": drive.path, "histogram_times": drive.time}
    found = set[int]()
    for name, points in places.items():
        for k, value in enumerate(getattr(asked, name) or []):
            if points is None:
                hint = "are of a path with drive.times; without them say where the slider is, as in histograms = [1.0]"
                refuse(f"eq.{name}", asked.histogram_times, hint)
            off = np.abs(points - value)
            # relative distances of 1e-9 count as none; a position near 0 is rounded as the path is
            size = abs(value) if points is drive.time else max(abs(value), np.abs(points).max())
            there = np.flatnonzero(off <= 1e-9 * size)
            if not there.size:
                near = np.unique(points[np.argsort(off, kind="stable")[:2]])
                hint = f"is none of the path's points; near it are {' and '.join(f'{x:.12g}' for x in near)}"
                refuse(f"eq.{name}[{k}]", value, hint)
            if points is drive.time:
                there = there[[np.argmin(off[there])]]
            found |= {int(at) for at in there if at - 1 not in there or at + 1 not in there}
    return np.array(sorted(found), np.intp)
