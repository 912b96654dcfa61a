"""A scene's [drive]: the points of the slider's path, and their times."""

import re
from typing import Any, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from origins.contacts import Contacts
from origins.drive import Drive, SlipRule
from origins.errors import InputError, non_negative, one_of, positive, refuse
from origins.thresholds.law import Array
from toolkit.scene import laws
from toolkit.scene.tables import DriveTable, EqTable, SceneTable

_NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"


class MachineUnit(NamedTuple):
    """How a number of the machine is written as text: in SI units, or over N_c<k>, with an example of the first; and in
    which others, each with what one of it is in SI units."""

    si: str
    shared: str
    example: str
    others: dict[str, float]


_SPRINGS = {"mN/m": 1e-3, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "N/µm": 1e6, "N/um": 1e6}
_MACHINE = {
    "spring": MachineUnit("N/m", "N_c<k>", "50 N/m", _SPRINGS),
    "mass": MachineUnit("kg", "N_c<k> s2", "0.2 kg", {"g": 1e-3, "mg": 1e-6}),
    "damping": MachineUnit("N s/m", "N_c<k> s", "3 N s/m", {"kg/s": 1.0}),
}

# each with what one of it is in which SI unit
IN_SI = {own.si: (1.0, own.si) for own in _MACHINE.values()} | {
    unit: (size, own.si) for own in _MACHINE.values() for unit, size in own.others.items()
}
# all of these, as they follow a number
MACHINE_UNITS = {unit for one in _MACHINE.values() for unit in (one.si, one.shared, *one.others)}
# keys that no rigid slider hangs on
MACHINE_KEYS = {"drive.slip", *(f"drive.{name}" for name in _MACHINE)}
# of the spring, from no force on, on a path with some slips
_LOADINGS = 5.0


class Given(NamedTuple):
    """A number of the machine as it is given: its value, None without one, and its unit, "" of a bare number."""

    value: float | None
    unit: str


def check_machine(scene: SceneTable) -> None:
    """Refuse a slip rule that is none, and numbers of a scene's machine whose unit is wrong or missing. That needs no
    contacts, which take seconds of a measured surface."""
    if scene.drive is not None and scene.drive.slip is not None:
        one_of("drive.slip", scene.drive.slip, get_args(SlipRule))
    kind = scene.contacts.thresholds.get("kind")
    if kind not in list(laws.THRESHOLDS):
        return  # it is refused as what it is, where contacts are made, and not as one whose <k> is not known
    of_surface = kind == "from-topography"
    for name in _MACHINE:
        if scene.drive is not None:
            _given(name, scene.drive, of_surface or scene.contacts.interface is not None)


def _given(name: str, table: DriveTable, known: bool) -> Given:
    """A number of the machine, checked as far as that goes without the contacts; `known`: whether <k> is, in N/m."""
    own = _MACHINE[name]
    key, given, unit = f"drive.{name}", getattr(table, name), ""
    if isinstance(given, str):
        read = re.fullmatch(f"{_NUMBER} (.+)", given)
        if read is None:
            hint = f'must be a number and a unit, "{own.example}" or "0.5 {own.shared}"'
            refuse(key, given, hint)
        units = {own.si: 1.0, own.shared: 1.0} | own.others
        if read[2] not in units:
            refuse(key, given, f"unit {read[2]} is not known; known: {', '.join(units)}")
        check = non_negative if name == "damping" else positive
        try:
            given = check(key, float(read[1]) * units[read[2]])
        except InputError as error:  # of the text as it was given
            refuse(key, given, str(error).partition(": ")[2])
        unit = own.shared if read[2] == own.shared else own.si
    if unit == own.si and not known:
        raise InputError(f"{key}: in {unit} {laws.NEEDS_STIFFNESS}; or give a number")
    if unit == own.si and table.area is None:
        refuse(key, getattr(table, name), "needs drive.area, the nominal area in m²; add it")
    if known and given and not unit:
        hint = f'has no unit; of a surface write either {name} = "{given:g} {own.si}" with area ='
        other = f'{name} = "{given:g} {own.shared}"'
        refuse(key, given, f"{hint} the nominal area in m², or {other}")
    return Given(given if given is None else float(given), unit)


def machine_number(name: str, table: DriveTable, contacts: Contacts) -> float | None:
    """drive.spring, drive.mass or drive.damping over N_c<k>, a number; None without one. Raises InputError.

    Text gives the unit, for a spring "0.5 N_c<k>", or "50 N/m", which needs thresholds from a surface and drive.area,
    the nominal area in m². For a surface a bare number but 0 is refused, as either unit could be meant.
    """
    interface, own = contacts.interface, _MACHINE[name]
    given, unit = _given(name, table, interface is not None)
    if given is not None and unit == own.si and interface is not None and table.area is not None:
        if interface.contact_density is None:
            hint = "needs contacts.interface.contact_density, contacts per nominal area in 1/m²; add it"
            refuse(f"drive.{name}", getattr(table, name), hint)
        if (number := interface.contact_density * table.area) < 1.0:
            few = f"holds {number:.2g} contacts"
            # a pressure in MPa has 1e-6 of the contacts that are meant
            asked = [one for one in getattr(interface, "cautions", ()) if "?" in one]
            hint = f"; give over {1.0 / interface.contact_density:.2g} m²"
            refuse(
                "drive.area",
                table.area,
                f"{few}: {' '.join(asked)} Else{hint[1:]}" if asked else few + hint,
            )
        return given / (number * interface.mean_stiffness)
    if table.area is not None and interface is None:
        refuse("drive.area", table.area, f"{laws.NEEDS_STIFFNESS}; or leave it out")
    return given


def some_slips(table: DriveTable, contacts: Contacts) -> float:
    """How far a drive goes until a slider has slipped some times, a length: F rises to some F_s, at most <x_s> N_c<k>,
    in each loading of its spring."""
    spring = machine_number("spring", table, contacts)
    return _LOADINGS * contacts.mean_threshold * (1.0 if spring is None else 1.0 + 1.0 / spring)


def has_path(table: DriveTable) -> bool:
    """Whether the table says where the drive goes; without it describes a machine, whose path a verdict finds."""
    return table.to is not None or table.turns is not None


def make_drive(table: DriveTable, contacts: Contacts | None = None) -> Drive:
    """The checked drive of a scene. Raises InputError with the path of the bad key. Without `contacts` it is the path
    and its times alone: of a sweep the table may lack the spring that its slip rule, or its mass, asks for."""
    machine: dict[str, Any] = {}
    if contacts is not None:
        machine = {name: machine_number(name, table, contacts) for name in _MACHINE}
    places, clock = _corners(table)
    if places.size > table.points:
        refuse("drive.points", table.points, f"the path has {places.size} ends; give as many")
    path, time = _path(places, clock, table.points, table.hold_scale)
    keys = {"time": "times"} | {name: name for name in ("velocity", "slip", *_MACHINE)}
    slip: Any = None if contacts is None else table.slip
    with laws.inside("drive", keys):
        return Drive(path, table.velocity, time, slip=slip, **machine)


def sliding_speed(
    drive: Drive | None, table: DriveTable | None, swept: Array | None = None
) -> float:
    """The speed (length per time) of a scene's smooth sliding: of its first leg that is not a hold; without a path the
    first of `swept`, else that of the machine of the `table` [drive], else 1."""
    if drive is None:
        if swept is not None:
            return float(swept.flat[0])
        return 1.0 if table is None else float(table.velocity)
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
        even = np.linspace(0.0, 1.0, number[leg + 1] - number[leg] + 1)[1:-1]
        later = hold_scale * np.expm1(even * np.log1p((clock[leg + 1] - clock[leg]) / hold_scale))
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
