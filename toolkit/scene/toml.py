"""A scene given as a dict, written as TOML text: the standard library only reads it."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from origins.errors import refuse


def to_toml(tables: Mapping[str, Any]) -> str:
    """TOML text, a line for each key, that reads back as `tables`; keys whose value is None are left out.

    Raises InputError for a value TOML has no form for.
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
