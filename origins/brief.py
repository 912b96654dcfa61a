"""A result in a line or two, however many points it has."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

_FEW, _LONGEST = 3, 100


def brief(record: Any) -> str:
    """The `__repr__` of a dataclass, with the shape and range of arrays in place of values, and long texts cut."""
    shown = (field.name for field in fields(record) if field.repr)
    values = (f"{name}={_short(getattr(record, name))}" for name in shown)
    return f"{type(record).__name__}({', '.join(values)})"


def _short(value: object) -> str:
    """One field in a few words: of a long array its shape and range, also in a tuple, of a mapping its keys, of other
    values their repr."""
    if type(value) is tuple:
        return f"({', '.join(map(_short, value))})"
    if isinstance(value, list):
        return f"<{len(value)}>" if value else "<none>"
    if isinstance(value, np.ndarray) and value.size > _FEW:
        shape = "x".join(map(str, value.shape))
        finite = value[np.isfinite(value)] if value.dtype.kind in "fiu" else np.empty(0)
        extent = f"from {finite.min():.6g} to {finite.max():.6g}" if finite.size else value.dtype
        return f"<{shape} {extent}>"
    text = " ".join(repr(value).split())
    if isinstance(value, Mapping):
        text = f"<{', '.join(map(str, value)) or 'none'}>"
    cut = isinstance(value, str | Mapping) and len(text) > _LONGEST
    return f"{text[: _LONGEST - 3]}..." if cut else text
