"""How a picture names the keys of a sweep: along an axis by name and symbol, in a legend by the symbol alone."""

import re
from collections.abc import Sequence
from typing import Any

from origins.thresholds.law import Array
from toolkit.pictures.axes import OWN_UNITS
from toolkit.scene.scale import PREFIXED, SHARED, written

# the usual keys: those of smooth sliding, of the drive, of the laws of the contacts
_NAMES = {"velocity": "speed $v$", "temperature": r"temperature $k_BT/\langle k\rangle$"}
_NAMES |= {"kelvin": "temperature $T$", "rate": "rate of ageing", "delay": r"delay $\tau$"}
_NAMES |= {"drive.velocity": "speed of the drive $v$", "drive.area": "nominal area $A$"}
_NAMES |= {"contacts.thermal.temperature": _NAMES["temperature"]}
_NAMES |= {"contacts.thermal.kelvin": _NAMES["kelvin"], "contacts.delay.time": _NAMES["delay"]}
# numbers of the machine, over N_c<k> where they have no unit of their own
_OF_MACHINE = {"drive.spring": "spring $K$", "drive.mass": "mass $M$"}
_OF_MACHINE |= {"drive.damping": r"damping $\gamma$"}


def axis_of_key(key: str, unit: str) -> tuple[str, str]:
    """Name and unit of an axis of a key that is swept."""
    if key not in _OF_MACHINE:
        return _NAMES.get(key, key), unit
    if unit in ("", SHARED):
        return _OF_MACHINE[key].removesuffix("$") + r"/(N_c\langle k\rangle)$", ""
    return _OF_MACHINE[key], unit


def last_words(keys: Sequence[str]) -> dict[str, str]:
    """The last words of the keys, such as "area" of "drive.area", where these tell them apart; else the keys."""
    last = {key: key.rpartition(".")[2] for key in keys}
    return last if len({*last.values()}) == len(last) else {key: key for key in keys}


def symbol_of_key(key: str, words: str, values: Array) -> str:
    """The symbol that an axis of the key has, such as $T$ of "temperature $T$"; without one these words."""
    # texts have their units with them
    named, _ = axis_of_key(key, "a text's own" if values.dtype.kind == "U" else "")
    symbol = re.search(r"\$.+\$", named)
    return symbol[0] if symbol else words


def value_of_key(value: Any, unit: str) -> str:
    """The value of a key that tells a line from others."""
    if isinstance(value, str) or not unit:
        return str(value)
    return written(value, unit) if unit in PREFIXED else f"{value:.3g} {OWN_UNITS.get(unit, unit)}"
