"""The tables of a scene file: their keys, types and defaults; and a scene given as a dict, written as TOML text."""

import inspect
import json
import re
import sys
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta

import origins
from origins.errors import InputError, refuse, with_point
from origins.laws.proportional import ProportionalGrowth

# nan and infinities lie outside of these
Finite = Annotated[float, Meta(ge=-sys.float_info.max, le=sys.float_info.max)]
Positive = Annotated[float, Meta(gt=0.0, le=sys.float_info.max)]
NonNegative = Annotated[float, Meta(ge=0.0, le=sys.float_info.max)]
Count = Annotated[int, Meta(ge=1)]


QUOTED = "'table.key'"  # the name of a key that stands for all those in quotes


class KeyTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A table of the scene file: its fields are the keys it may hold."""


# laws by which thresholds grow, those of the face of origins: tables of [contacts], and the functions of P_c and of
# numbers that they call, named as their laws with _ for spaces; without such a function scenes do not know the law
GROWTHS = {
    name: f"origins:{name}"
    for own in vars(origins).values()
    if inspect.isclass(own)
    and issubclass(own, ProportionalGrowth)
    and own is not ProportionalGrowth
    and inspect.isfunction(getattr(origins, name := own.law.replace(" ", "_"), None))
}


class _OfThresholds(KeyTable, frozen=True):
    thresholds: dict[str, Any]


_OfGrowths = msgspec.defstruct(
    "_OfGrowths", [(law, dict[str, Any] | None, None) for law in GROWTHS], bases=(_OfThresholds,)
)


class ContactsTable(_OfGrowths, frozen=True):  # type: ignore[valid-type,misc,call-arg]
    start: dict[str, Any] | None = None
    thermal: dict[str, Any] | None = None
    ageing: dict[str, Any] | None = None
    delay: dict[str, Any] | None = None
    reforming: dict[str, Any] | None = None
    stiffness: str = "independent"
    interface: dict[str, Any] | None = None


class DriveTable(KeyTable, frozen=True):
    points: Annotated[int, Meta(ge=2, le=10_000_000)] = 501
    to: Positive | None = None
    begin: Finite | None = msgspec.field(default=None, name="from")
    turns: list[Finite] | None = None
    times: list[Finite] | None = None
    hold_scale: Positive | None = None
    velocity: Positive = 1.0
    spring: Positive | str | None = None
    mass: Positive | str | None = None
    damping: NonNegative | str = 0.0
    slip: str | None = None
    area: Positive | None = None


class MasterTable(KeyTable, frozen=True):
    tolerance: Annotated[float, Meta(gt=0.0, lt=1.0)] = 1e-8


class EqTable(KeyTable, frozen=True):
    contacts: Count = 100_000
    replicas: Count = 16
    seed: Annotated[int, Meta(ge=0)] = 1
    tolerance: Positive | None = None
    wall_time: Positive | None = None
    threads: Annotated[int, Meta(ge=1, le=1024)] | None = None
    slip_fraction: float | None = None
    histograms: list[Finite] | None = None
    histogram_times: list[Finite] | None = None


class RangeTable(KeyTable, frozen=True):
    begin: float = msgspec.field(name="from")
    to: float
    points: Annotated[int, Meta(ge=2, le=100_000)]
    spacing: str = "log"
    unit: str | None = None


Values = NonNegative | Annotated[list[NonNegative], Meta(min_length=1)] | RangeTable


class SweepTable(KeyTable, frozen=True):
    velocity: Positive | Annotated[list[Positive], Meta(min_length=1)] | RangeTable | None = None
    temperature: Values | None = None
    kelvin: Values | None = None
    rate: Values | None = None
    delay: Values | None = None
    critical_spring: bool = False
    # any key of the scene in quotes, such as "drive.spring", with its values; toolkit/scene/grid.py checks them
    keys: dict[str, Any] | None = msgspec.field(default=None, name=QUOTED)


class VerdictTable(KeyTable, frozen=True):
    readings: Annotated[list[str], Meta(min_length=1, max_length=20)] | None = None
    steps: Annotated[list[Count], Meta(min_length=1, max_length=10)] | None = None
    rules: Annotated[list[str], Meta(min_length=1, max_length=3)] | None = None


class SceneTable(KeyTable, frozen=True):
    contacts: ContactsTable
    drive: DriveTable | None = None
    title: Annotated[str, Meta(max_length=1000, pattern=r"^[^\x00-\x08\x0b-\x1f\x7f]*$")] = ""
    master: MasterTable | None = None
    eq: EqTable | None = None
    sweep: SweepTable | None = None
    verdict: VerdictTable | None = None
    wall_time: Positive | None = None
    units: str = "SI"


_TABLES = {"": SceneTable, "contacts": ContactsTable, "drive": DriveTable, "eq": EqTable}
_TABLES |= {"master": MasterTable, "sweep": SweepTable, "verdict": VerdictTable}
_COUNTS = ("points", "contacts", "replicas", "seed", "samples", "threads")

# the units of numbers, of keys by their last name: those of every scene, and lengths, whose unit is that of the scene
_PASCALS = "pressure contact_modulus shear_modulus hardness shear_strength force_coefficient"
FIXED_UNITS = dict.fromkeys(_PASCALS.split(), "Pa") | {"kelvin": "K", "wall_time": "s"}
FIXED_UNITS |= {"area": "m²", "patch_area": "m²"}
_EXAMPLES = {"pressure": "1e6", "contact_modulus": "2e9", "mean_stiffness": "10.0"}
# where a temperature is no number of kelvins above zero
CELSIUS = "0 °C is kelvin = 273.15"
FIXED_UNITS |= {"mean_stiffness": "N/m", "contact_density": "1/m²"}
_OF_LENGTH = "to from mean std value lower upper scale centre lattice_constant"
LENGTHS = _OF_LENGTH.split()
# how a message names them to somebody who wrote a unit
_UNITS = FIXED_UNITS | dict.fromkeys(LENGTHS, "the scene's unit of length, m of a surface")
_UNITS |= {"time": "s where speeds are in m/s", "velocity": "m/s where lengths are in m"}


# keys that others may look for, with the one that is meant, and how it follows
_MODULUS = "contact_modulus", "E* = E/(1 - nu²) on a rigid flat, half of that for two equal bodies"
_ALSO_CALLED = dict.fromkeys(["youngs_modulus", "elastic_modulus", "modulus", "E"], _MODULUS)


def read_table(tables: Mapping[str, Any]) -> SceneTable:
    """The tables with their types checked and defaults filled in. Raises InputError with the path of the bad key."""
    try:
        return msgspec.convert(_with_quoted_keys(_counted(tables)), SceneTable)
    except msgspec.ValidationError as error:
        # such as: Expected `float | null`, got `str` - at `$.drive.to`
        expected, _, place = str(error).replace("object", "table").partition(" - at ")
        where = place.strip("`$").lstrip(".")
        if "field" in expected:
            key = f"{where}.{expected.split('`')[1]}".lstrip(".")
            names = _TABLES.get(where, RangeTable).__struct_encode_fields__
            meant = what_is_meant(key.rpartition(".")[2], names)
            said = f"unknown key; {meant}known here: {', '.join(names)}"
            raise InputError(f"{key}: {'is missing' if 'missing' in expected else said}") from error
        value: Any = tables
        for key in where.replace("]", "").replace("[", ".").split("."):
            value = value[int(key) if key.isdigit() else key]
        said = expected.partition(", got")[0].replace(" | null", "").replace("`", "")
        said = said.replace(f" <= {sys.float_info.max}", ", finite").replace("str", "text")
        said = said.replace("int", "a whole number").replace("float", "a number")
        if said == "Expected table":
            said = f"must be a table, [{where}] or {key} = {{ ... }}"
        above, unit = re.fullmatch(r"Expected (.*) > 0\.0(.*)", said), _UNITS.get(key)
        if above:
            said = f"must be {above[1]} above 0{above[2]}" + f", in {unit}" * (unit is not None)
        point = f"; {with_point(value)}" * bool(with_point(value))
        refuse(where, value, f"{said[0].lower()}{said[1:]}{point}")


def _with_quoted_keys(tables: Any) -> Any:
    """The same tables, with the keys of [sweep] that have a dot, which are keys of the scene, in a table of their own.
    One that is written without quotes, sweep.drive.spring, is a table in a table to TOML."""
    sweep = tables.get("sweep") if isinstance(tables, Mapping) else None
    if not isinstance(sweep, Mapping):
        return tables
    for name in _TABLES:
        if name and name in sweep:
            hint = f'write a key of the scene in quotes, as "{name}.spring" = [0.5, 1.0]'
            raise InputError(f"sweep.{name}: {hint}")
    own = {name: value for name, value in sweep.items() if "." not in name}
    quoted = {name: value for name, value in sweep.items() if "." in name}
    return {**tables, "sweep": own | ({QUOTED: quoted} if quoted else {})}


def keys_of_tables() -> dict[str, tuple[str, ...]]:
    """The keys of each table of a scene, by its name."""
    return {name: table.__struct_encode_fields__ for name, table in _TABLES.items() if name}


# keys of a contact's laws, which [sweep] has, too
_OF_LAWS = {"kelvin": "temperature = { kelvin = 300.0 } stands in [contacts.thermal]; "}
_OF_LAWS |= {
    "temperature": "it stands in [contacts.thermal]; ",
    "rate": "it stands in [contacts.ageing]; ",
}


def what_is_meant(key: str, names: Iterable[str]) -> str:
    """For a message on an unknown key: the table that has it, if one does; else the known key nearest to it."""
    tables = [
        name for name, table in _TABLES.items() if name and key in table.__struct_encode_fields__
    ]
    if ContactsTable.__annotations__.get(key) == dict[str, Any] | None:
        return f"it is a table of its own, [contacts.{key}]; "
    if (other := _ALSO_CALLED.get(key)) and other[0] in names:
        return f"give {other[0]}, {other[1]}; "
    if key in _OF_LAWS:
        return _OF_LAWS[key]
    if tables and key in SceneTable.__struct_encode_fields__:
        return "it stands before all tables; "
    return f"it stands in [{tables[0]}]; " if len(tables) == 1 else did_you_mean(key, names)


def with_unit(key: str) -> str:
    """For a message on a missing key: that it is a number in this unit, with an example; "" where none is known."""
    unit = FIXED_UNITS.get(key)
    if unit is None:
        return ""
    example = _EXAMPLES.get(key)
    return f"give a number in {unit}{f', such as {key} = {example}' if example else ''}; "


def did_you_mean(word: object, names: Iterable[str]) -> str:
    """A question that names the known word nearest to this one, for a message; "" where none is near."""
    close = get_close_matches(str(word), list(names), 1)
    return f"did you mean {close[0]}? " if close else ""


def _counted(value: Any, where: str = "") -> Any:
    """The same tables, with counts written as 1e5 as whole numbers. Raises InputError for text such as "1 MPa" where a
    number is meant."""
    if isinstance(value, Mapping):
        return {name: _counted(item, f"{where}.{name}".lstrip(".")) for name, item in value.items()}
    key = where.rpartition(".")[2]
    if key in _UNITS and isinstance(value, str) and re.search(r"\d", value):
        hint = "only drive.spring, mass and damping take text with a unit"
        hint = CELSIUS if key == "kelvin" else hint
        hint = with_point(value) or hint
        refuse(where, value, f"must be a number alone, in {_UNITS[key]}; {hint}")
    whole = key in _COUNTS and isinstance(value, float) and value.is_integer()
    return int(value) if whole else value


def to_toml(tables: Mapping[str, Any]) -> str:
    """TOML text, a line for each key, that reads back as `tables`; keys whose value is None are left out. Raises
    InputError for a value that TOML cannot represent."""
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
