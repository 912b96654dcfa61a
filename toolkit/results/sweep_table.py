"""A sweep as a plain table: a line for each point, a column for each quantity, as other programs read it."""

import csv
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path

import numpy as np

from toolkit.scene.sweep import SweepRecord


def write_csv(sweep: SweepRecord, units: Mapping[str, str], path: Path) -> None:
    """Write the sweep's arrays, those that it has, as comma-separated values with all their digits; the first line has
    their names, with the unit in brackets where `units` has one for the name."""
    columns = {field.name: getattr(sweep, field.name) for field in fields(sweep)}
    columns = {
        name: value.ravel() for name, value in columns.items() if isinstance(value, np.ndarray)
    }
    heads = [f"{name} [{units[name]}]" if name in units else name for name in columns]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
