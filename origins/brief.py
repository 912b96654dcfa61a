"""A result in a line or two, however many points it has."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

_FEW, _LONGEST = 3, 100


def brief(record: Any) -> str:
    """The repr of a dataclass, with the shape and range of arrays in place of their values, and with long texts cut:
    set it as `__repr__` in the class."""
    told = (
        f"{field.name}={_short(getattr(record, field.name))}"
        for field in fields(record)
        if field.repr
    )
    return f"{type(record).__name__}({', '.join(told)})"


def _short(value: object) -> str:
    """One field in a few words: of a long array its shape and range, of other values their repr."""
    if isinstance(value, np.ndarray) and value.size > _FEW:
        shape = "x".join(map(str, value.shape))
        known = value[np.isfinite(value)] if value.dtype.kind == "f" else value
        if value.dtype.kind not in "fiu" or not known.size:
            return f"<{shape} {value.dtype}>"
        return f"<{shape} from {known.min():.6g} to {known.max():.6g}>"
    if isinstance(value, Mapping) or (
        isinstance(value, Sequence) and not isinstance(value, str | tuple)
    ):
        return f"<{len(value)}>" if len(value) > 0 else "<none>"
    text = " ".join(repr(value).split())
    return (
        text
        if not isinstance(value, str) or len(text) <= _LONGEST
        else f"{text[: _LONGEST - 3]}..."
    )
