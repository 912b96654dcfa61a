"""A scene's [sweep] over keys of the scene in quotes, such as "drive.spring": which scenes its points are."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

import msgspec
import numpy as np

from origins.errors import InputError, finite, one_of, positive, refuse
from toolkit.scene.changes import changed
from toolkit.scene.tables import RangeTable, SweepTable

# what a sweep's own keys are, beside keys in quotes
_OWN = {"velocity": "drive.velocity", "temperature": "contacts.thermal.temperature"}
_OWN |= {"kelvin": "contacts.thermal.temperature", "rate": "contacts.ageing.rate"}
_OWN |= {"delay": "contacts.delay.time"}
MOST = 10_000  # points: a solve of the whole scene each


@dataclass(frozen=True)
class Grid:
    """The points of a sweep over keys of the scene: every combination of `values`, by key, the last key fastest.

    critical_spring : whether K* is asked for at each point
    """

    values: dict[str, list[Any]]
    critical_spring: bool

    @property
    def points(self) -> list[dict[str, Any]]:
        """The values of each point, by key."""
        return [
            dict(zip(self.values, point, strict=True)) for point in product(*self.values.values())
        ]

    def tables(self, tables: Mapping[str, Any], point: Mapping[str, Any]) -> dict[str, Any]:
        """The tables of the scene at a point: without [sweep], with the point's values."""
        base = {name: table for name, table in tables.items() if name != "sweep"}
        values = {key: {"kelvin": one} if key == "kelvin" else one for key, one in point.items()}
        return changed(base, {_OWN.get(key, key): one for key, one in values.items()})


def make_grid(table: SweepTable, given: Mapping[str, Any]) -> Grid | None:
    """The grid of a [sweep] that has keys of the scene in quotes; None for one that has only its own. `given` are the
    scene's tables. Raises InputError with the path of a bad key."""
    if not table.keys:
        return None
    values: dict[str, list[Any]] = {}
    for name, one in given["sweep"].items():
        if name in _OWN or name in table.keys:
            values[name] = _values(f"sweep.{_quoted(name)}", one)
    if {"temperature", "kelvin"} <= set(values):
        raise InputError("sweep: has temperature and kelvin; give one of them")
    if (points := prod(map(len, values.values()))) > MOST:
        raise InputError(f"sweep: has {points:,} points; take {MOST:,} at most")
    return Grid(values, table.critical_spring)


def _quoted(name: str) -> str:
    return f'"{name}"' if "." in name else name


def _values(name: str, value: object) -> list[Any]:
    """One value, those of a list, or those of a range, as text where the range has a unit."""
    if isinstance(value, list):
        if not value or not all(isinstance(one, int | float | str) for one in value):
            refuse(
                name, value, 'must be a list of numbers or texts, such as [0.5, 1.0], or ["50 N/m"]'
            )
        return value
    if not isinstance(value, Mapping):
        return [value]
    try:
        table = msgspec.convert(value, RangeTable)
    except msgspec.ValidationError as error:
        hint = "must be a value, a list, or { from = 10.0, to = 100.0, points = 5 }"
        raise InputError(f"{name}: {hint}, with spacing and unit if you like ({error})") from error
    begin, end = finite(f"{name}.from", table.begin), finite(f"{name}.to", table.to)
    if one_of(f"{name}.spacing", table.spacing, ("log", "even")) == "even":
        numbers = np.linspace(begin, end, table.points)
    else:
        hint = 'for logarithmic spacing; or write spacing = "even"'
        ends = positive(f"{name}.from", begin, hint), positive(f"{name}.to", end, hint)
        numbers = np.geomspace(*ends, table.points)
    rounded = [float(f"{number:.12g}") for number in numbers]  # as a user writes them
    return rounded if table.unit is None else [f"{number!r} {table.unit}" for number in rounded]
