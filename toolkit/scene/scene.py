"""Scene files, checked completely before anything runs."""

import time
import tomllib
import warnings
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.contacts import Contacts
from origins.drive import Drive
from origins.errors import InputError, one_of, refuse, shown
from origins.laws.temperature import TooHot, too_cold
from toolkit.processes.ranks import on_root
from toolkit.scene import laws, samples, tables
from toolkit.scene.changes import changed
from toolkit.scene.drive import (
    check_machine,
    has_path,
    histogram_points,
    make_drive,
    sliding_speed,
    some_slips,
)
from toolkit.scene.files import read_file, read_text
from toolkit.scene.grid import Grid, make_grid
from toolkit.scene.paper import scene_of_figure
from toolkit.scene.scale import SHARED, SI, Scale, scale_of
from toolkit.scene.sweep import Sweep, make_sweep
from toolkit.scene.tables import to_toml

SHIPPED = Path(__file__).parents[1] / "scenes"


@dataclass(frozen=True)
class Scene:
    """A checked scene.

    `text` is its TOML text, its file names are relative to `folder`; `drive.path` are positions of the
    slider, or of the drive where there is a spring, (n,), lengths in the unit of the thresholds. `given_drive`,
    `master`, `eq` and `sweep` are None where the scene has no such table. `wall_time`: seconds for all of them
    together, None for no limit; `tolerance_given`: whether the scene names master.tolerance; `area`: drive.area;
    `drive_table`, `verdict`: the tables [drive] and [verdict] as they are given; `units`: of forces and springs of a
    surface, "SI" or "N_c<k>"; `grid`: a [sweep] over keys of the scene, each point of which is a scene of its own; all
    else is then of the scene without its sweep, or of the first point where the sweep gives what the scene lacks.
    """

    name: str
    title: str
    text: str
    folder: Path
    contacts: Contacts
    given_drive: Drive | None
    master: tables.MasterTable | None
    eq: tables.EqTable | None
    sweep: Sweep | None
    wall_time: float | None = None
    tolerance_given: bool = True
    area: float | None = None
    drive_table: tables.DriveTable | None = None
    verdict: tables.VerdictTable | None = None
    units: str = SI
    grid: Grid | None = None

    @property
    def drive(self) -> Drive:
        """The drive; InputError for a scene without [drive]."""
        if self.given_drive is None:
            hint = "is missing; write such as to = 5.0 with points = 501"
            raise InputError(f"{'drive' if self.drive_table is None else 'drive.to'}: {hint}")
        return self.given_drive

    def one(self, what: str) -> "Scene":
        """`self` unless it is a sweep over keys of the scene, which `what` does not take; InputError for that."""
        if self.grid is not None:
            keys = ", ".join(f'"{key}"' for key in self.grid.values)
            raise InputError(
                f"sweep: {what} takes one scene, not a sweep over {keys}; leave it out"
            )
        return self

    @property
    def path(self) -> npt.NDArray[np.float64]:
        return self.drive.path

    @property
    def scale(self) -> Scale:
        """The units of forces and springs."""
        return scale_of(self.contacts, self.area, self.units)

    def deadline(self) -> float | None:
        """End of the wall time if it begins now, in s of the monotonic clock; None without a wall time."""
        return None if self.wall_time is None else time.monotonic() + self.wall_time

    @property
    def sliding(self) -> float:
        """The speed for F_k and other quantities that depend on it."""
        swept = None if self.sweep is None else self.sweep.at["velocity"]
        return sliding_speed(self.given_drive, self.drive_table, swept)

    def histogram_points(self) -> npt.NDArray[np.intp]:
        """Indices of the path's points that eq.histograms and eq.histogram_times name. Raises InputError for others."""
        return np.empty(0, np.intp) if self.eq is None else histogram_points(self.drive, self.eq)

    def only_forward(self, what: str) -> "Scene":
        """`self` if its slider is rigid and moves forward; else InputError, which says that `what` takes only that."""
        if self.drive.spring is not None:  # as the scene writes it, with its unit
            given = tomllib.loads(self.text)["drive"]["spring"]
            refuse("drive.spring", given, f"{what} takes a rigid slider; leave it out")
        with laws.inside("drive", {}):
            self.drive.only_forward(what)
        return self


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


class Source(NamedTuple):
    """A scene as it is written: its name, its TOML text, the tables of that, and the folder of its file names."""

    name: str
    text: str
    tables: dict[str, Any]
    folder: Path


def load_scene(
    scene: "Scene | Mapping[str, Any] | str | PathLike[str]",
    solved: bool = True,
    comm: Any = None,
    changes: Mapping[str, Any] | None = None,
) -> Scene:
    """The scene of a dict, of a scene file, or of a shipped scene's name; one to be `solved` must name a solver.

    `changes` are values by key, such as {"drive.spring": 0.5}, in place of those of the scene.
    The ranks of the mpi4py communicator `comm`, all of which must call, share the sampling of its thresholds; every
    rank gets the same bits.
    Raises InputError with the path of the bad key, such as ``contacts.thresholds.std = -1.0: must be above zero``.
    """
    if isinstance(scene, Scene) and not changes:
        return scene
    try:
        return checked(read_scene(scene, comm, changes), solved, comm)
    except RecursionError as error:
        raise InputError("scene: is nested too deeply; it needs a few levels") from error
    except InputError:
        raise
    except ValueError as error:  # numpy's, of numbers near the ends of floating point
        hint = "some number is too large or too small; are all in the right unit?"
        raise InputError(f"scene: {hint} ({error})") from error


def read_scene(
    scene: "Scene | Mapping[str, Any] | str | PathLike[str]",
    comm: Any = None,
    changes: Mapping[str, Any] | None = None,
) -> Source:
    """The scene as it is written, with `changes`, before its values are checked; see load_scene."""
    try:
        if isinstance(scene, Mapping):
            name, text, folder = "scene", to_toml(scene), Path()
        elif isinstance(scene, Scene):
            name, text, folder = scene.name, scene.text, scene.folder
        else:
            file = on_root(comm, lambda: _find(scene))
            text = read_file("scene", str(file), Path(), comm, read_text)
            name, folder = file.stem, file.parent
        found = tomllib.loads(text)
        if changes:
            found = changed(found, changes)
            text = to_toml(found)
        return Source(name, text, found, folder)
    except InputError:
        raise
    except ValueError as bad:  # of tomllib: bad TOML, and whole numbers of thousands of digits
        hint = "numbers are 1.5, not 1,5; with a unit they are text in quotes"
        raise InputError(f"scene = {shown(str(scene))}: is not TOML: {bad} ({hint})") from bad


def _find(scene: object) -> Path:
    """The file of a scene given by its name, as a file, or by the label of a figure of the paper, such as A08c."""
    if not isinstance(scene, str | PathLike):
        refuse("scene", scene, "must be a dict, a scene file or the name of a shipped scene")
    if isinstance(scene, str) and scene in shipped_scenes():
        return SHIPPED / f"{scene}.toml"
    file = Path(scene)
    try:
        if file.exists():
            return file
        beside = {other.stem: str(other) for other in file.parent.glob("*.toml")}
    except (OSError, ValueError) as error:  # a name too long for the disk, or with a NUL
        refuse("scene", str(scene), f"cannot be read: {getattr(error, 'strerror', None) or error}")
    if isinstance(scene, str) and (shipped := scene_of_figure(scene)) is not None:
        return SHIPPED / f"{shipped}.toml"
    close = get_close_matches(file.stem, sorted({*beside, *shipped_scenes()}))
    meant = f" did you mean {' or '.join(beside.get(name, name) for name in close)}?"
    listed = "`mesofriction scenes` lists those that are shipped"
    hint = f"no such file, and no shipped scene;{meant if close else ''} {listed}"
    refuse("scene", str(scene), hint)


def checked(source: Source, solved: bool, comm: Any = None) -> Scene:
    """The scene, with all that its tables say checked. Raises InputError."""
    name, text, given, folder = source
    table = tables.read_table(given)
    if not name.isprintable():
        refuse("scene", name, "holds a letter that no picture can show; leave it out")
    if solved and table.master is None and table.eq is None and table.sweep is None:
        hint = "add one of them"
        if table.drive is not None and not has_path(table.drive):
            far = some_slips(table.drive, make_contacts(table.contacts, folder, comm))
            hint = f"of a machine add a path, too, such as --set drive.to={far:.2g} --set 'master={{}}'"
        raise InputError(
            f"scene: has neither [master] nor [eq] nor [sweep]; {hint}. `verdict` and `thresholds` need none, and "
            "load_scene(..., solved=False) gives its contacts"
        )
    one_of("units", table.units, (SI, SHARED))
    if table.sweep is not None and (grid := make_grid(table.sweep, given)) is not None:
        return _checked_grid(source, grid, solved, comm)
    followed = solved and (table.master is not None or table.eq is not None)
    driven = table.drive is not None and (followed or has_path(table.drive))
    check_machine(table)  # before the contacts, which may take long
    contacts = make_contacts(table.contacts, folder, comm)
    drive = make_drive(table.drive, contacts) if table.drive is not None and driven else None
    sweep = None
    if table.sweep is not None:
        sweep = make_sweep(table.sweep, contacts, sliding_speed(drive, table.drive))
    scene = Scene(
        *(name, table.title, text, folder, contacts, drive, table.master, table.eq, sweep),
        wall_time=table.wall_time,
        tolerance_given="tolerance" in given.get("master", {}),
        area=None if table.drive is None else table.drive.area,
        drive_table=table.drive,
        verdict=table.verdict,
        units=table.units,
    )
    if followed:
        _ = scene.drive  # which both solvers need
    if table.eq is not None and drive is not None:
        far = float(np.abs(scene.path).max()) / contacts.mean_threshold
        # contacts would break for hours; on a spring they break as the slider moves, which the ensemble counts itself
        if solved and far > 1e6 and scene.drive.spring is None:
            hint = f"goes as far as {far:.1g} mean thresholds of {contacts.mean_threshold:.3g}; is that its unit?"
            raise InputError(f"drive: {hint} 1e6 mean thresholds at most, or leave [eq] out")
        if scene.drive.mass is not None and (np.diff(scene.path) < 0.0).any():
            hint = "the ensemble [eq] of a slider with mass takes a drive that does not turn back"
            raise InputError(f"drive.turns: {hint}")
        scene.histogram_points()
    return scene


def _checked_grid(source: Source, grid: Grid, solved: bool, comm: Any) -> Scene:
    """The scene without its sweep over keys of the scene, beside the `grid` where it is to be `solved`. Where the sweep
    gives what the scene lacks, it is that of the first point, which is checked in any case. Raises InputError."""
    own = source._replace(tables=grid.tables(source.tables, {}))
    if not solved:
        return checked(own, False, comm)
    first = source._replace(tables=grid.tables(source.tables, grid.points[0]))
    runs = "master" in first.tables or "eq" in first.tables
    scene = checked(first, runs, comm)
    with suppress(InputError):  # where it is not complete by itself
        scene = checked(own, runs, comm)
    return replace(scene, grid=grid)


def make_contacts(table: tables.ContactsTable, folder: Path, comm: Any) -> Contacts:
    """The contacts with the laws that the table names, and no other."""
    samples.check_units(table.thresholds, table.interface)
    thresholds = laws.build(laws.THRESHOLDS, table.thresholds, "contacts.thresholds", folder, comm)
    made: dict[str, Any] = {"thresholds": thresholds, "stiffness": table.stiffness}
    surface = getattr(thresholds, "interface", None)
    for name, kinds in laws.CONTACTS.items():
        if (own := getattr(table, name)) is not None:
            surface = made.get("interface", surface)
            own = laws.without_kelvin(own, f"contacts.{name}", surface)
            own = laws.with_width(own, f"contacts.{name}")
            found = laws.build(kinds, own, f"contacts.{name}", folder, comm, made["thresholds"])
            made["thresholds" if name in tables.GROWTHS else name] = found
    thermal = table.thermal or {}
    if thermal and surface is not None and "attempt_frequency" not in thermal:
        raise InputError(
            "contacts.thermal.attempt_frequency: is missing; where lengths are in metres it is in 1/s, such as 1e12, "
            "and has no default"
        )
    warmth = thermal.get("temperature")
    if isinstance(warmth, Mapping) and (hint := too_cold(made["thermal"].temperature, thresholds)):
        refuse("contacts.thermal.temperature.kelvin", warmth["kelvin"], hint)
    with laws.inside("contacts", {name: name for name in made}), warnings.catch_warnings():
        warnings.simplefilter("ignore", TooHot)  # a note of the run says it
        return Contacts(**made)
