"""The tables in docs/scenes.md: every kind, every key and every default is the code's own."""

import inspect
import re
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import msgspec
import pytest

import origins
from toolkit.scene import laws, tables

PAGE = Path(__file__).parents[1] / "docs" / "scenes.md"
GIVEN = ("folder", "comm")  # not for a scene to say

STRUCTS = {
    "The file": tables.SceneTable,
    "[contacts]": tables.ContactsTable,
    "[drive]": tables.DriveTable,
    "[master]": tables.MasterTable,
    "[eq]": tables.EqTable,
    "[sweep]": tables.SweepTable,
    "[sweep.velocity]": tables.RangeTable,
}
KINDS = {
    "[contacts.start]": laws.START,
    "[contacts.reforming]": laws.REFORMING,
    "[contacts.thresholds]": laws.THRESHOLDS,
    "[contacts.thresholds.surface]": laws.SURFACES,
    "[contacts.thresholds.material.contact_stiffness]": laws.STIFFNESSES,
    "[contacts.thresholds.island]": laws.ISLANDS,
    "[contacts.thresholds.substrate]": laws.SUBSTRATES,
}
CALLS = {
    "[contacts.thermal]": origins.Thermal,
    "[contacts.ageing]": origins.Ageing,
    "[contacts.delay]": origins.Delay,
    "[contacts.thresholds.material]": origins.Material,
}


def sections() -> dict[str, list[list[str]]]:
    """The rows of each table, cells without their backticks, by the heading above it."""
    found: dict[str, list[list[str]]] = {}
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            rows = found.setdefault(line.removeprefix("## ").strip("`"), [])
        elif re.match(r"\| (`|\|)", line):
            rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return found


def told(cells: list[str]) -> tuple[str, Any]:
    """A row's key and default; a key that is needed has inspect's empty one."""
    key, _, default, _ = cells
    value = {"needed": inspect.Parameter.empty, "left out": None}.get(default, default)
    if isinstance(value, str):
        value = tomllib.loads(f"it = {value.strip('`')}")["it"]
    return key.strip("`"), value


def of_function(function: Any) -> dict[str, Any]:
    parameters = inspect.signature(function).parameters
    return {name: parameter.default for name, parameter in parameters.items() if name not in GIVEN}


def test_page_has_a_section_for_every_table() -> None:
    assert set(sections()) == {*STRUCTS, *KINDS, *CALLS}


@pytest.mark.parametrize("heading", STRUCTS)
def test_table_of_fixed_keys(heading: str) -> None:
    fields = msgspec.structs.fields(STRUCTS[heading])
    code = {field.encode_name: inspect.Parameter.empty if field.required else field.default for field in fields}
    assert dict(map(told, sections()[heading])) == code


@pytest.mark.parametrize("heading", CALLS)
def test_table_of_one_function(heading: str) -> None:
    assert dict(map(told, sections()[heading])) == of_function(CALLS[heading])


@pytest.mark.parametrize("heading", KINDS)
def test_table_of_kinds(heading: str) -> None:
    page: dict[str, dict[str, Any]] = {}
    for kind, *cells in sections()[heading]:
        if kind:
            page[kind.strip("`")] = row = {}
        row.update([told(cells)])
    code = {}
    for kind, place in KINDS[heading].items():
        module, name = place.split(":")
        code[kind] = of_function(getattr(import_module(module), name))
    assert page == code
