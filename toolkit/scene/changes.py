"""Single keys of a scene, given a new value: what `--set drive.spring=0.5` and a sweep over any number do."""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from typing import Any

from origins.errors import InputError, refuse, shown
from toolkit.scene.laws import THRESHOLDS, with_defaults
from toolkit.scene.tables import SceneTable, keys_of_tables

_EXAMPLE = """write such as --set drive.spring='"50 N/m"' or --set contacts.thresholds.std=0.1"""


def read_changes(words: Sequence[str]) -> dict[str, Any]:
    """Values by key, of words such as 'drive.spring="50 N/m"', whose values are TOML. Raises InputError."""
    changes: dict[str, Any] = {}
    for word in words:
        key, equals, value = word.partition("=")
        key = key.strip()
        if not equals or not key:
            refuse("--set", word, f"must be KEY=VALUE: {_EXAMPLE}")
        try:
            read = tomllib.loads(f"value = {value}")
        except (ValueError, RecursionError) as error:
            text = value.strip()
            hint = f"the value is not TOML; text needs quotes within the shell's: --set {key}='\"{text}\"'"
            if re.fullmatch(r"[+-]?\d+,\d+", text):
                hint = f"write a decimal point: --set {key}={text.replace(',', '.')}"
            raise InputError(f"--set = {shown(word)}: {hint}") from error
        if set(read) != {"value"}:
            refuse("--set", word, f"must be one value: {_EXAMPLE}")
        if key in changes:
            refuse("--set", word, f"{key} is set twice; leave one out")
        changes[key] = read["value"]
    return changes


def changed(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a scene's tables with these values at their keys, such as "contacts.thresholds.components[0].std";
    tables that are missing on the way are added. Raises InputError for a way through what is no table."""
    out: dict[str, Any] = deepcopy(dict(tables))
    for key, value in changes.items():
        _put(out, key, value)
    return out


def _put(tables: dict[str, Any], key: str, value: object) -> None:
    """Put the value at its key."""
    steps: list[str | int] = []
    for word in key.split("."):
        found = re.fullmatch(r"([\w-]+)((?:\[\d+\])*)", word)
        if found is None:
            refuse("key", key, "must be names between dots, as drive.spring, or drive.turns[1]")
        steps += [found[1], *map(int, re.findall(r"\d+", found[2]))]
    whole = SceneTable.__struct_encode_fields__
    if steps[0] not in whole and (full := _full_keys(tables, key)):
        refuse("key", key, f"is no whole key; write {' or '.join(full)}")
    place: Any = tables
    for step, after in zip(steps, [*steps[1:], None], strict=True):
        if isinstance(step, int):
            if not isinstance(place, list) or step >= len(place):
                count = len(place) if isinstance(place, list) else "no"
                refuse("key", key, f"[{step}] counts from 0 in a list, and there are {count} items")
        elif not isinstance(place, dict):
            refuse("key", key, f"{step} is a key of a table, and before it stands none")
        if after is None:
            place[step] = value
        else:
            place = place[step] if isinstance(step, int) else place.setdefault(step, {})


def _full_keys(tables: Mapping[str, Any], end: str) -> list[str]:
    """The keys of a scene of these tables that end so, such as contacts.thresholds.pressure for "pressure"; of its
    thresholds those that it leaves out, too."""
    every: dict[str, Any] = {name: dict.fromkeys(keys) for name, keys in keys_of_tables().items()}
    if "sweep" not in tables:  # whose keys are those of other tables
        del every["sweep"]
    contacts = tables.get("contacts")
    if isinstance(contacts, Mapping):
        every["contacts"] |= contacts
        with suppress(InputError):
            law = with_defaults(THRESHOLDS, contacts.get("thresholds"), "contacts.thresholds")
            every["contacts"]["thresholds"] = law
    return [key for key in _keys_in(every, "") if f".{key}".endswith(f".{end}")]


def _keys_in(table: Mapping[str, Any], before: str) -> Iterator[str]:
    """All keys of a table and of the tables within it, each with the way to it."""
    for name, value in table.items():
        yield f"{before}{name}"
        if isinstance(value, Mapping):
            yield from _keys_in(value, f"{before}{name}.")
