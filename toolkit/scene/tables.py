"""The tables of a scene file: their keys, types and defaults."""

import re
from collections.abc import Mapping
from typing import Any, Literal, get_args

import msgspec

from origins.errors import InputError, shown, without_point

_EXPECTED = {
    "object": "a table",
    "array": "a list of numbers, such as [1.0, 2.0]",
    "float": "a number, such as 1.0",
    "int": "a whole number",
    "str": 'text in quotes, such as "text"',
    "bool": "true or false",
}


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
    slip: Literal["reset", "reform-after", "instant"] | None = None
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
    spacing: Literal["log", "even"] = "log"


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


def read_table(tables: Mapping[str, Any]) -> SceneTable:
    """The tables with their types checked and defaults filled in. Raises InputError."""
    try:
        return msgspec.convert(tables, SceneTable)
    except msgspec.ValidationError as error:
        raise InputError(_explain(str(error), tables)) from error


def _explain(message: str, tables: Mapping[str, Any]) -> str:
    """msgspec's message, which ends in the place as `$.drive.to`, as one line in house style."""
    rule, _, place = message.partition(" - at ")
    keys = [key for key in place.strip("`").split(".")[1:] if key]
    value: Any = tables
    kind: Any = SceneTable
    for key in keys:
        name, *numbers = key.split("[")  # as in turns[1], an item of a list
        kind, value = _field_type(kind, name), value[name]
        for number in numbers:
            value = value[int(number.rstrip("]"))]
    unknown = re.match(r"Object contains unknown field `(.*)`", rule)
    missing = re.match(r"Object missing required field `(.*)`", rule)
    other = re.match(r"Expected `(\w+)", rule)
    if unknown:
        key = unknown[1]
        known = ", ".join(kind.__struct_encode_fields__)
        return f"{'.'.join([*keys, key])} = {shown(value[key])}: unknown key; known here: {known}"
    if missing:
        return f"{'.'.join([*keys, missing[1]])}: is missing"
    if rule.startswith("Invalid enum value"):
        allowed = [f'"{one}"' for one in _choices(kind)]
        rule = f"must be {', '.join(allowed[:-1])} or {allowed[-1]}"
    if kind is RangeTable and other:
        rule = "must be a number, a list of numbers, or { from = 1.0, to = 100.0, points = 50 }"
    elif other and other[1] in _EXPECTED:
        rule = f"must be {_EXPECTED[other[1]]}"
        rule += without_point(value, least=0) if other[1] == "int" else ""
    if keys[-1:] == ["wall_time"]:
        rule = "must be a number of seconds, such as 3600.0"
    text = str(value).lower() if isinstance(value, bool) else shown(value)
    return f"{'.'.join(keys)} = {text}: {rule}"


def _choices(kind: Any) -> list[str]:
    """The words that a Literal, or one among others, allows."""
    found: list[str] = []
    for one in get_args(kind):
        found += [one] if isinstance(one, str) else _choices(one)
    return found


def _field_type(kind: Any, key: str) -> Any:
    """The table, or the type, that `key` of table `kind` holds; of `Table | None` the table."""
    types = {field.encode_name: field.type for field in msgspec.structs.fields(kind)}
    return next(
        (one for one in get_args(types[key]) if isinstance(one, type) and issubclass(one, Table)),
        types[key],
    )
