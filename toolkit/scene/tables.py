"""The tables of a scene file: their keys, types and defaults; and a scene given as a dict, written as TOML text."""

import json
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from origins.errors import InputError, refuse


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A table of the scene file: its fields are the keys it may hold."""


class ContactsTable(Table, frozen=True):
    thresholds: dict[str, Any]
    start: dict[str, Any] | None = None
    thermal: dict[str, Any] | None = None
    ageing: dict[str, Any] | None = None
    delay: dict[str, Any] | None = None
    reforming: dict[str, Any] | None = None
    stiffness: str = "independent"


class DriveTable(Table, frozen=True):
    points: int
    to: float | None = None
    begin: float | None = msgspec.field(default=None, name="from")
    turns: list[float] | None = None
    times: list[float] | None = None
    hold_scale: float | None = None
    velocity: float = 1.0
    spring: float | str | None = None
    slip: str | None = None
    area: float | None = None


class MasterTable(Table, frozen=True):
    tolerance: float = 1e-8


class EqTable(Table, frozen=True):
    contacts: int = 100_000
    replicas: int = 16
    seed: int = 1
    tolerance: float | None = None
    wall_time: float | None = None
    slip_fraction: float | None = None
    histograms: list[float] | None = None
    histogram_times: list[float] | None = None


class RangeTable(Table, frozen=True):
    begin: float = msgspec.field(name="from")
    to: float
    points: int
    spacing: str = "log"


Values = float | list[float] | RangeTable


class SweepTable(Table, frozen=True):
    velocity: Values | None = None
    temperature: Values | None = None
    kelvin: Values | None = None
    rate: Values | None = None
    delay: Values | None = None
    critical_spring: bool = False


class SceneTable(Table, frozen=True):
    contacts: ContactsTable
    drive: DriveTable | None = None
    title: str = ""
    master: MasterTable | None = None
    eq: EqTable | None = None
    sweep: SweepTable | None = None
    wall_time: float | None = None


_TABLES = {"": SceneTable, "contacts": ContactsTable, "drive": DriveTable, "eq": EqTable}
_TABLES |= {"master": MasterTable, "sweep": SweepTable}
_COUNTS = ("points", "contacts", "replicas", "seed")


def read_table(tables: Mapping[str, Any]) -> SceneTable:
    """The tables with their types checked and defaults filled in. Raises InputError with the path of the bad key."""
    try:
        return msgspec.convert(_counted(tables), SceneTable)
    except msgspec.ValidationError as error:
        # such as: Expected `float | null`, got `str` - at `$.drive.to`
        rule, _, place = str(error).partition(" - at ")
        where, name = place.strip("`$").lstrip("."), rule.split("`")[1]
        key = f"{where}.{name}".lstrip(".")
        if "missing required field" in rule:
            raise InputError(f"{key}: is missing") from error
        if "unknown field" in rule:
            known = ", ".join(_TABLES.get(where, RangeTable).__struct_encode_fields__)
            raise InputError(f"{key}: unknown key; known here: {known}") from error
        said = rule.replace(" | null", "").replace("`", "").replace("object", "table")
        raise InputError(f"{where}: {said[0].lower()}{said[1:]}") from error


def _counted(value: Any, key: str = "") -> Any:
    """The same tables, with counts written as 1e5 as whole numbers."""
    if isinstance(value, Mapping):
        return {name: _counted(item, name) for name, item in value.items()}
    whole = key in _COUNTS and isinstance(value, float) and value.is_integer()
    return int(value) if whole else value


def to_toml(tables: Mapping[str, Any]) -> str:
    """TOML text, a line for each key, that reads back as `tables`; keys whose value is None are left out.

    Raises InputError for a value that TOML cannot represent.
    """
    return "".join(f"{line}\n" for line in _pairs(tables, ""))


def _pairs(table: Mapping[str, Any], where: str) -> list[str]:
    there = {str(key): value for key, value in table.items() if value is not None}
    bare = {key: key if key.isascii() and key.isidentifier() else _text(key) for key in there}
    return [f"{bare[key]} = {_value(there[key], f'{where}{key}')}" for key in there]


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: object, where: str) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return (int if isinstance(value, int) else float).__repr__(value)  # not a subclass's own
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(item, f'{where}[{k}]') for k, item in enumerate(value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(_pairs(value, f'{where}.'))}}}"
    refuse(where, value, "a scene holds numbers, strings, lists and tables only")
