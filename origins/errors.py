"""The one error type for bad input, and the checks that raise it."""

import math
import re
from collections.abc import Iterable
from typing import NoReturn

import numpy as np

TEMPERATURE = "k_BT/<k>, a length squared in the thresholds' unit; for T = 0 leave the law out"


class InputError(ValueError):
    """A value that cannot be used; the message gives its name, the value, what holds, and what to write instead."""


class NothingInTimeError(InputError):
    """The wall time was over before anything was known."""


def refuse(name: str, value: object, hint: str) -> NoReturn:
    """Raise InputError as one line: ``name = value: hint``."""
    raise InputError(f"{name} = {shown(value)}: {hint}")


def shown(value: object) -> str:
    """`value` as a message shows it, in at most 60 characters; of an object without a repr of its own the class, as
    its address tells nothing."""
    text = repr(value)
    if type(value).__repr__ is object.__repr__:
        text = f"{type(value).__name__}(...)"
    elif isinstance(value, np.ndarray):
        text = f"array of shape {value.shape}"
    elif isinstance(value, np.generic):
        text = repr(value.item())
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


def with_point(value: object) -> str:
    """What to write in place of text with a decimal comma; "" for other values."""
    comma = isinstance(value, str) and re.fullmatch(r"\s*[-+]?\d+,\d+(?:[eE][-+]?\d+)?\s*", value)
    return f"write {str(value).strip().replace(',', '.')}, with a point" if comma else ""


def finite(name: str, value: object, instead: str = "such as 1.0") -> float:
    """`value` as a finite float; else the message ends in what to write `instead`."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        refuse(name, value, f"must be a number, {with_point(value) or instead}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        refuse(name, value, f"must be finite, {instead}")
    return number


def positive(name: str, value: object, instead: str = "") -> float:
    """`value` as a finite float above zero; else the message ends in what to write `instead`."""
    number = finite(name, value, instead or "such as 1.0")
    if number <= 0.0:
        refuse(name, value, ", ".join(filter(None, ["must be above zero", instead])))
    return number


def between(
    name: str, value: object, least: float, most: float, instead: str = "choose another unit"
) -> float:
    """`value` as a float above zero from `least` to `most`; else the message ends in what to do `instead`."""
    number = positive(name, value)
    if not least <= number <= most:
        refuse(name, value, f"must lie between {least:g} and {most:g}; {instead}")
    return number


def check_tolerance(name: str, value: object) -> float:
    """`value` as a tolerance in mean thresholds: a finite float above zero and below 1, the size of a force."""
    number = positive(name, value, "such as 1e-8")
    if number >= 1.0:
        refuse(name, value, "must be below 1, in mean thresholds, such as 1e-8")
    return number


def non_negative(name: str, value: object) -> float:
    """`value` as a finite float of at least zero."""
    number = finite(name, value)
    if number < 0.0:
        refuse(name, value, "must be zero or above")
    return number


def whole(name: str, value: object, least: int) -> int:
    """`value` as an int of at least `least`."""
    hint = f"must be a whole number of at least {least}"
    if isinstance(value, int | np.integer) and not isinstance(value, bool) and value >= least:
        return int(value)
    if isinstance(value, float) and least <= value < 1e16 and value % 1 == 0:
        hint += f"; write {int(value)}"  # 100000 for 1e5
    refuse(name, value, hint)


def check_seed(value: object) -> int:
    """`value` as a seed: an int of at least 0 and below 2^64."""
    if (seed := whole("seed", value, 0)) >= 1 << 64:
        refuse("seed", value, "must be below 2^64")
    return seed


def finite_array(name: str, value: object) -> np.ndarray:
    """`value` as a one-dimensional, non-empty float array without NaN or infinity."""
    try:
        array = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError, OverflowError):
        refuse(name, value, "must be an array of numbers")
    # asarray would read numbers in quotes as numbers
    if np.asarray(value).dtype.kind not in "iufO":
        refuse(name, value, "must be an array of numbers")
    if array.size == 0:
        refuse(name, [], "is empty: give one number at least")
    if array.ndim != 1:
        refuse(name, array, "must be one-dimensional")
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        refuse(f"{name}[{bad[0]}]", array[bad[0]], "must be finite")
    return array


def positive_array(name: str, value: object) -> np.ndarray:
    """`value` as such an array of numbers above zero."""
    array = finite_array(name, value)
    for bad in np.flatnonzero(array <= 0.0):
        refuse(f"{name}[{bad}]", array[bad], "must be above zero")
    return array


def pair(name: str, value: object) -> tuple[object, object]:
    """`value`, one number or a pair of them, as a pair."""
    given = value if isinstance(value, tuple | list | np.ndarray) else (value, value)
    if len(given) != 2:
        refuse(name, value, "must be one number or a pair")
    return given[0], given[1]


def one_of(name: str, value: object, names: tuple[str, ...]) -> str:
    """`value` as one of these names."""
    if not isinstance(value, str) or value not in names:
        refuse(name, value, must_be(names))
    return value


def must_be(names: Iterable[str]) -> str:
    """For a message: that the value must be one of these names."""
    *others, last = [f'"{one}"' for one in names]
    return f"must be {', '.join(others)} or {last}"
