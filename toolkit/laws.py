"""Named laws: a scene's table with a `kind` becomes the call of one function.

A kind is one entry here. Its keys are the function's own parameters, so a scene cannot drift from the function.
"""

import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from origins.errors import InputError, finite, refuse

THRESHOLDS = {
    "identical": "origins:identical",
    "gaussian": "origins:gaussian",
    "rectangular": "origins:rectangular",
    "mixture": "origins:mixture",
    "gw-elastic": "origins:gw_elastic",
    "gw-plastic": "origins:gw_plastic",
    "persson": "origins:persson",
    "lubricated": "origins:lubricated",
}

START = {
    "identical": "toolkit.laws:identical_start",
    "gaussian": "origins:gaussian_start",
}


def identical_start(value: float) -> float:
    """All contacts start at one stretch (a length)."""
    return finite("value", value)


def build(kinds: Mapping[str, str], table: Mapping[str, Any], where: str) -> Any:
    """What the table's kind makes of the table's other keys.

    Tables with a kind of their own inside lists, such as the components of a mixture, are built first.
    Raises InputError with the path of the bad key, counted from `where`.
    """
    kind = table.get("kind")
    if kind is None:
        raise InputError(f"{where}.kind: is missing; must be one of {', '.join(kinds)}")
    if not isinstance(kind, str) or kind not in kinds:
        refuse(f"{where}.kind", kind, f"must be one of {', '.join(kinds)}")
    function = _function(kinds[kind])
    parameters = inspect.signature(function).parameters
    arguments = {key: value for key, value in table.items() if key != "kind"}
    for key, value in arguments.items():
        if key not in parameters:
            refuse(f"{where}.{key}", value, f"unknown key; {kind} takes {', '.join(parameters)}")
    for key, parameter in parameters.items():
        if parameter.default is parameter.empty and key not in arguments:
            raise InputError(f"{where}.{key}: is missing; {kind} takes {', '.join(parameters)}")
    for key, value in arguments.items():
        if isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            arguments[key] = [build(kinds, item, f"{where}.{key}[{index}]") for index, item in enumerate(value)]
    with inside(where):
        return function(**arguments)


@contextmanager
def inside(where: str) -> Iterator[None]:
    """Put `where` before the name of the bad value in any InputError raised within."""
    try:
        yield
    except InputError as error:
        named = re.match(r"\w+(\[\d+\])?( = |: )", str(error))
        raise InputError(f"{where}{'.' if named else ': '}{error}") from error


def _function(address: str) -> Callable[..., Any]:
    module, name = address.split(":")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found
