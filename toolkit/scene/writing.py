"""A scene written out: all its tables and keys, those that have a default with it, as TOML that runs."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from toolkit.scene import laws
from toolkit.scene.tables import QUOTED, read_table, to_toml

# what a key that is left out stands for, where something else decides whether it is needed
MEANING = {"drive.slip": ' ("reset" on a spring without a mass)'}


def written_out(tables: Mapping[str, Any], folder: Path) -> str:
    """The scene of these tables as TOML text, every default filled in; comments name the keys that are left out.

    Names of files, which are relative to `folder`, become relative to the current one. Raises InputError for keys that
    no table has; values are checked when the scene is loaded.
    """
    return "\n".join(_section(with_defaults(_from_here(dict(tables), folder)), "")).strip() + "\n"


def with_defaults(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables with all defaults, None for a key that is left out, in the order of docs/scenes.md."""
    out: dict[str, Any] = msgspec.to_builtins(read_table(tables))
    contacts = out["contacts"]
    contacts["thresholds"] = laws.with_defaults(
        laws.THRESHOLDS, contacts["thresholds"], "contacts.thresholds"
    )
    for name, kinds in laws.CONTACTS.items():
        if contacts[name] is not None:
            contacts[name] = laws.with_defaults(kinds, contacts[name], f"contacts.{name}")
    if out["sweep"] is not None:
        out["sweep"] |= out["sweep"].pop(QUOTED) or {}
    # a tolerance that a scene names is a stricter promise than the same number by default
    if out["master"] is not None and "tolerance" not in tables["master"]:
        out["master"]["tolerance"] = None
    return out


def _from_here(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The table, and those within it, with relative names of files made relative to the current folder."""
    out = dict(table)
    for key, value in table.items():
        if isinstance(value, Mapping):
            out[key] = _from_here(dict(value), folder)
        elif isinstance(value, list):
            out[key] = [_from_here(one, folder) if isinstance(one, dict) else one for one in value]
        elif key == "file" and isinstance(value, str) and folder.resolve() != Path.cwd():
            out[key] = value if Path(value).is_absolute() else os.path.relpath(folder / value)
    return out


def _section(table: Mapping[str, Any], where: str) -> list[str]:
    """The lines of a table: its keys, those left out as a comment, then the tables within it."""
    lines, inner, absent = list[str](), list[str](), list[str]()
    for key, value in table.items():
        place = f"{where}.{key}".lstrip(".")
        if value is None:
            absent.append(key + MEANING.get(place, ""))
        elif isinstance(value, Mapping) and not _short(value, where):
            inner += ["", f"[{place}]", *_section(value, place)]
        else:
            lines += to_toml({key: value}).splitlines()
    if absent:
        lines.append(f"# left out: {', '.join(absent)}")
    return [*lines, *inner]


def _short(value: Mapping[str, Any], where: str) -> bool:
    """Whether a table is written within a line, as a range of a sweep, or kelvins of a temperature."""
    return where == "sweep" or set(value) == {"kelvin"}
