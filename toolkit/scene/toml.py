"""A scene given as a dict, written as TOML text: the standard library only reads it."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from origins.errors import refuse


def to_toml(tables: Mapping[str, Any]) -> str:
    """TOML text that reads back as `tables`; keys whose value is None are left out.

    Raises InputError for a value TOML has no form for.
    """
    return "\n".join(_lines(tables, ())) + "\n"


def _lines(table: Mapping[str, Any], where: tuple[str, ...]) -> list[str]:
    lines = [f"[{'.'.join(_key(key) for key in where)}]"] if where else []
    inner = []
    for key, value in table.items():
        if isinstance(value, Mapping):
            inner += _lines(value, (*where, key))
        elif value is not None:
            lines.append(f"{_key(key)} = {_value(value, '.'.join((*where, str(key))))}")
    return lines + inner


def _key(key: object) -> str:
    text = str(key)
    bare = text.isascii() and text.replace("-", "").replace("_", "").isalnum()
    return text if bare else _string(text)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: object, where: str) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        return float.__repr__(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, list | tuple):
        return (
            f"[{', '.join(_value(item, f'{where}[{index}]') for index, item in enumerate(value))}]"
        )
    if isinstance(value, Mapping):
        items = (f"{_key(key)} = {_value(item, f'{where}.{key}')}" for key, item in value.items())
        return f"{{{', '.join(items)}}}"
    refuse(where, value, "a scene holds numbers, strings, lists and tables only")
