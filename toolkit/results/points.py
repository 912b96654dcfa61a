"""The record of a sweep: a table with a row for each point, and its files."""

import csv
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from origins.brief import brief
from origins.thresholds.law import Array
from toolkit.results.kinds import OVER_STIFFNESS, units_of
from toolkit.scene.drive import IN_SI
from toolkit.scene.scale import Scale
from toolkit.scene.tables import FIXED_UNITS, LENGTHS

# columns of a sweep of smooth sliding over speeds, temperatures, rates of ageing or delays, those that it has
SMOOTH: tuple[str, ...] = ("velocity", "force", "force_error", "holding", "holding_error")
SMOOTH += ("temperature", "kelvin", "rate", "delay", "critical_spring", "critical_spring_error")


@dataclass(frozen=True)
class SweepRecord:
    """What each point of a sweep gives; ``record["critical_spring"]`` is a column.

    along : the keys that are swept
    columns : by name, arrays of one shape. Of a sweep over keys of the scene (n,), of numbers or of text, the keys
        first; nan and "" where a point has no such number, and "message" says why it failed, where it did. Of smooth
        sliding (n,) or (n, m), the first axis `along` its first: `force` = F_k/(N_c<k>) (a length), `force_error` (in
        <x_s>), `holding`, the fraction that holds, and its error; if requested `critical_spring` = K*/(N_c<k>) and its
        error; `velocity`, `temperature`, `rate`, `delay` at each point, `kelvin` if temperatures were given in K. These
        are attributes, too: None for one that is not there, as of a law that the contacts do not have
    units : of columns, "" or missing for a pure number, a key, whose unit is the scene's, and smooth sliding
    run_time : s, of all launches and processes together
    """

    along: tuple[str, ...]
    columns: dict[str, Array]
    units: dict[str, str]
    run_time: float
    success: bool
    message: str

    __repr__ = brief

    def __getitem__(self, name: str) -> Array:
        """A column by its name."""
        return self.columns[name]

    def __getattr__(self, name: str) -> Array | None:
        if name not in SMOOTH:
            raise AttributeError(f"a sweep has no {name}")
        return self.columns.get(name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for name in SMOOTH if name in self.columns)]

    @property
    def smooth(self) -> bool:
        """Whether it is of smooth sliding; else each point is a run of the scene."""
        return "force" in self.columns

    @property
    def size(self) -> int:
        """How many points there are."""
        return next(iter(self.columns.values())).size

    def _ipython_key_completions_(self) -> list[str]:
        """What a notebook offers after ``record["``."""
        return list(self.columns)

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


def key_units(along: Iterable[str], scale: Scale) -> dict[str, str]:
    """Units of keys of a scene that are swept as numbers, where they are known; by the last word of a key."""
    length, time = scale.length_unit, scale.time_unit
    units = FIXED_UNITS | dict.fromkeys(LENGTHS, length) | dict.fromkeys(("delay", "time"), time)
    units |= {"temperature": f"{length}²", "rate": f"{length}²/{time}"}
    units |= {"velocity": scale.speed_unit}
    return {key: units.get(key.rpartition(".")[2], "") for key in along}


def without_unit(values: Array) -> tuple[Array, str]:
    """The numbers of texts such as "50 N/m" and their unit, of a machine's in SI units, so that 5 kN/m may stand beside
    50 N/m; the values themselves and "" where they are no such texts, or have several units."""
    if values.dtype.kind != "U":
        return values, ""
    read = [
        re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?) (.+)", one)
        for one in map(str, values.ravel())
    ]
    each = [(float(one[1]), *IN_SI.get(one[2], (1.0, one[2]))) for one in read if one]
    units = {unit for _, _, unit in each}
    if not all(read) or len(units) != 1:
        return values, ""
    numbers = [number * size for number, size, _ in each]
    return np.array(numbers).reshape(values.shape), units.pop()


def force_factors(record: SweepRecord, scale: Scale) -> Array:
    """What forces and springs over N_c<k> are in the unit of the scale at each point, whose surface or area may be its
    own."""
    name = {"N": "kinetic_force_newtons", "Pa": "kinetic_stress"}.get(scale.force_unit)
    out = np.full(record.size, scale.force)
    if name in record.columns:
        shared = record["kinetic_force"]
        np.divide(record[name], shared, out=out, where=shared > 0.0)
    return out


def by_head(result: Any) -> dict[str, Array]:
    """The columns of a Result's sweep, shape (points,), by name and unit in brackets; forces and springs in the unit of
    its scale."""
    record, scale = result.sweep, result.scale
    units = record.units
    if record.smooth:
        units = units_of(result, short=True) | {"force_error": "<x_s>"}
    keys = [key for key in record.along if record[key].dtype.kind != "U"]
    units = key_units(keys, scale) | {name: unit for name, unit in units.items() if unit}
    columns = {name: own.ravel() for name, own in record.columns.items()}
    for key in record.along:
        columns[key], its_own = without_unit(columns[key])
        units |= {key: its_own} if its_own else {}
    factors = force_factors(record, scale)
    # of smooth sliding errors are in <x_s>
    errors = result.mean_threshold if record.smooth else 1.0
    for name, own in columns.items():
        if name in ("critical_spring", "critical_spring_error"):
            columns[name], units[name] = factors * own, scale.spring_unit
        elif units.get(name) in ("m", "length", "<x_s>") and "force" in name:
            columns[name] = factors * own * (errors if name == "force_error" else 1.0)
            units[name] = scale.force_unit
    for twin in ("kinetic_force_newtons", "kinetic_stress", "critical_spring_newtons"):
        if units.get(twin) in (scale.force_unit, scale.spring_unit):
            del columns[twin]
    return {
        f"{name} [{_plainly(units[name])}]" if units.get(name) else name: own
        for name, own in columns.items()
    }


def _plainly(unit: str) -> str:
    """A unit of result.h5, such as "m / s" or "(m)^2", as tables and the docs write it: "m/s", "m²"."""
    return re.sub(r"\((.+)\)\^2", r"\1²", unit).replace(" / ", "/")


def _is_empty(column: Array) -> bool:
    """Whether a column of numbers has none."""
    return column.dtype.kind == "f" and bool(np.isnan(column).all())


def write_sweep(result: Any, path: Path) -> None:
    """A line for each point of a Result's sweep, a column for each of `by_head` that has a value somewhere, with all
    digits; `message` is "as asked" where nothing was missed."""
    columns = {head: own for head, own in by_head(result).items() if not _is_empty(own)}
    if "message" in columns:
        said = columns["message"]
        columns["message"] = np.where(said == "", "as asked", said)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(own.tolist() for own in columns.values()), strict=True))


def fill_sweep(group: Any, record: SweepRecord, units: Mapping[str, str]) -> None:
    """Write the record into an HDF5 group: a data set for each column, by its name, or numbered in their order where
    columns are keys of the scene."""
    for name in ("run_time", "success", "message"):
        group.attrs[name] = getattr(record, name)
    group.attrs["along"], pure = list(record.along), "1" if record.smooth else ""
    for number, (name, column) in enumerate(record.columns.items()):
        own = group.create_dataset(name if record.smooth else f"{number:03d}", data=column.tolist())
        own.attrs["name"], own.attrs["units"] = name, units.get(name, pure)
        if "force" in name and units.get(name) not in ("", "N", None):
            own.attrs["quantity"] = OVER_STIFFNESS


def read_sweep(group: Any) -> SweepRecord:
    """The record that `fill_sweep` wrote, in this version or an older one."""
    columns, units = dict[str, Array](), dict[str, str]()
    smooth = "force" in group
    for key in [name for name in SMOOTH if name in group] if smooth else sorted(group):
        values, name = group[key][()], str(group[key].attrs.get("name", key))
        text = values.dtype.kind == "O"
        columns[name] = np.array([one.decode() for one in values]) if text else values
        units |= {} if smooth else {name: str(group[key].attrs["units"])}
    return SweepRecord(
        along=tuple(map(str, group.attrs["along"])),
        columns=columns,
        units=units,
        run_time=float(group.attrs["run_time"]),
        success=bool(group.attrs["success"]),
        message=str(group.attrs["message"]),
    )
