"""The record of a sweep over keys of the scene: a table with a row for each point, and its files."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from origins.brief import brief
from origins.thresholds.law import Array


@dataclass(frozen=True)
class PointsRecord:
    """What each point of a sweep over keys of the scene gives; ``record["critical_spring"]`` is a column.

    along : the keys that are swept; columns : by name, arrays of shape (n,), of numbers or of text, the keys first; nan
        and "" where a point has no such number, and "message" says why it failed, where it did
    units : of columns, "" or missing for a pure number and for a key, whose unit is the scene's
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

    def _ipython_key_completions_(self) -> list[str]:
        """What a notebook offers after ``record["``."""
        return list(self.columns)

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


def write_points_csv(record: PointsRecord, path: Path) -> None:
    """A line for each point, a column for each of the record's, its unit in brackets, with all digits."""
    heads = (
        f"{name} [{record.units[name]}]" if record.units.get(name) else name
        for name in record.columns
    )
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(zip(*(column.tolist() for column in record.columns.values()), strict=True))


def fill_points(group: Any, record: PointsRecord) -> None:
    """Write the record into an HDF5 group: a data set for each column, numbered in their order."""
    for name in ("run_time", "success", "message"):
        group.attrs[name] = getattr(record, name)
    group.attrs["along"] = list(record.along)
    for number, (name, column) in enumerate(record.columns.items()):
        own = group.create_dataset(f"{number:03d}", data=column.tolist())
        own.attrs["name"], own.attrs["units"] = name, record.units.get(name, "")


def read_points(group: Any) -> PointsRecord:
    """The record that `fill_points` wrote."""
    columns, units = dict[str, Array](), dict[str, str]()
    for number in sorted(group):
        values, name = group[number][()], str(group[number].attrs["name"])
        text = values.dtype.kind == "O"
        columns[name] = np.array([one.decode() for one in values]) if text else values
        units[name] = str(group[number].attrs["units"])
    return PointsRecord(
        along=tuple(map(str, group.attrs["along"])),
        columns=columns,
        units=units,
        run_time=float(group.attrs["run_time"]),
        success=bool(group.attrs["success"]),
        message=str(group.attrs["message"]),
    )
