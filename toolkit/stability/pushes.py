"""The numbers of a scene, and the values that a map gives each of them: its own pushed up and down by decades."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from origins.errors import shown
from toolkit.scene.scene import Scene
from toolkit.scene.tables import LENGTHS, EqTable, MasterTable
from toolkit.stability.case import LONGEST

DECADES = 6  # how far a number is pushed, each way
FEWEST = 5_000  # contacts that a spring couples: fewer are not near enough to infinitely many
MOST_COUPLED = 25_000_000  # of 40 bytes each, which a replica on a spring keeps: 1 GB
# the first value of a zero, in its natural unit: a decade below the smallest that is asked
_TINY = 10.0 ** -(DECADES + 1)
_TABLES = ("contacts", "drive", "master", "eq")
_COUNTS = "eq.contacts", "eq.replicas"
# a number with a unit, such as "50 N/m"; no name of a file, as no unit has a dot
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(\s+[^\s.][^.]*)")
# why a number is not pushed, by the last name of its key
_FINELY = "how finely, or over which area, is asked"
_WHERE = "where stretches are counted"
_WHY_NOT = dict.fromkeys(
    ["points", "number", "step", "area", "degree", "resamples", "shape"], _FINELY
)
_WHY_NOT |= dict.fromkeys(["histograms", "histogram_times"], _WHERE)
_WHY_NOT |= {
    "seed": "a seed has no size",
    "weights": "shares have no size as a whole",
    "threads": "the answer is the same on any number of threads",
    "wall_time": f"a map has its own limit, {LONGEST:g} CPU-seconds an answer",
    "slip_fraction": "it tells slips, and sliders are compared up to their first",
}
_ALL_ZERO = "a list of zeros has no decades"
_COPIES = "the mean over coupled contacts is near to that of infinitely many in N, not in copies"


class NaturalUnit(NamedTuple):
    """What a zero is measured in: its name, and its size in the scene's own unit."""

    name: str
    size: float


@dataclass(frozen=True)
class Push:
    """A value in place of a number, and its name in the map."""

    name: str
    value: Any


def searches(key: str, value: Any, scene: Scene) -> list[list[Push]]:
    """The values in place of a number, in one list for each way in which it is pushed; a map ends each list at the
    first that is not answered. A zero is pushed to small parts of its natural unit, a list as a whole; of an ensemble
    its numbers as they are come first, as the scene as it is has an ensemble of FEWEST contacts."""
    if _is_zero(value):
        decades = range(1, DECADES + 1)
        unit = _natural_unit(key, scene)
        parts = [_TINY * 10.0**decade for decade in decades]
        values = [times(unit.size, part) for part in parts]
        names = [f"{part:.0e} {unit.name}".rstrip() for part in parts]
        pairs = zip(names, values, strict=True)
        return [[Push(f"{name}: {other:.6g}", other) for name, other in pairs]]
    both = list[list[Push]]()
    for sign in (-1, 1):
        way = list[Push]()
        both.append(way)
        for decade in range(0 if sign > 0 and is_of_ensemble(key) else 1, DECADES + 1):
            other = times(value, 10.0 ** (sign * decade))
            if key in _COUNTS:
                other = max(round(other), 1)
                if _is_unasked(key, other, scene) or (way and other == way[-1].value):
                    continue
            as_text = f"{other:.6g}" if isinstance(other, float) else shown(other)
            way.append(Push(f"x 1e{sign * decade:+d}: {as_text}", other))
    return both


def is_of_ensemble(key: str) -> bool:
    """Whether a number says how the ensemble is followed, so that its answer alone depends on it."""
    return key.startswith("eq.")


def _is_unasked(key: str, value: int, scene: Scene) -> bool:
    """Whether a number of coupled contacts is too small to stand beside infinitely many, or too large to be kept."""
    coupled = key == "eq.contacts" and scene.drive.spring is not None
    return coupled and not FEWEST <= value <= MOST_COUPLED


def column(case: str) -> int:
    """The column of the map in which a case of this name stands: by how many decades its number is pushed; where it is
    a zero, by how many above 1e-7 of its natural unit."""
    found = re.match(r"(x )?1e([-+]\d+)", case)
    if found is None:  # as it is
        return 0
    return int(found[2]) + (0 if found[1] else DECADES + 1)


def factor_of(case: str) -> str:
    """By what a number is multiplied in the case of this name; of a zero its new value, in its natural unit."""
    head = case.partition(":")[0]
    return f"{10.0 ** column(case):g}" if head.startswith("x ") else head


def label(key: str, case: str) -> str:
    """The name of a key in the picture, of whose cases one is given: of a zero with the unit of its decades."""
    head = case.partition(":")[0]
    unit = head.partition(" ")[2]
    return key if head.startswith("x ") else f"{key} (0; in {_TINY:.0e} {unit})".replace(" )", ")")


def numbers(tables: Mapping[str, Any], coupled: bool = False) -> Iterator[tuple[str, Any]]:
    """Keys of [contacts], [drive], [master] and [eq] that are pushed, such as "contacts.thresholds.std", with their
    numbers, texts of a number with its unit, or lists of numbers; `coupled`: on a spring."""
    for key, value in _numbers_of(tables):
        if not _why_not(key, value, coupled):
            yield key, value


def not_pushed(tables: Mapping[str, Any], coupled: bool = False) -> Iterator[str]:
    """Which numbers of a scene a map leaves as they are, and why, a line for each reason."""
    kept = dict[str, list[str]]()
    for key, value in _numbers_of(tables):
        if why := _why_not(key, value, coupled):
            kept.setdefault(why, []).append(key)
    for why, keys in kept.items():
        yield f"not pushed: {', '.join(keys)}: {why}"


def _why_not(key: str, value: Any, coupled: bool) -> str:
    """Why a number is not pushed; "" where it is."""
    if key == "eq.replicas" and coupled:
        return _COPIES
    if isinstance(value, list) and not np.any(_flat(value)):
        return _ALL_ZERO
    return _WHY_NOT.get(key.rsplit(".", 1)[-1], "")


def _numbers_of(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """All keys with numbers, or with lists of numbers, and where [master] and [eq] stand those they have by default."""
    defaults = {
        "master": {"tolerance": MasterTable().tolerance},
        "eq": {"contacts": EqTable().contacts, "replicas": EqTable().replicas},
    }
    for table in _TABLES:
        if table in tables:
            yield from _numbers_in(table, defaults.get(table, {}) | tables[table])


def _numbers_in(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _numbers_in(f"{key}.{name}", inner)
    elif isinstance(value, list) and any(isinstance(inner, Mapping) for inner in value):
        for place, inner in enumerate(value):
            yield from _numbers_in(f"{key}[{place}]", inner)
    elif isinstance(value, list):
        if _flat(value):
            yield key, value
    elif _is_number(value) or _QUANTITY.fullmatch(str(value)):
        yield key, value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _flat(values: list[Any]) -> list[float]:
    """The numbers of a list and of the lists in it."""
    out = list[float]()
    for value in values:
        out += _flat(value) if isinstance(value, list) else [value] * _is_number(value)
    return out


def _is_zero(value: Any) -> bool:
    """Whether a number, or that of a text with its unit, is zero."""
    if isinstance(value, str):
        return float(_QUANTITY.fullmatch(value)[1]) == 0.0  # type: ignore[index]
    return not isinstance(value, list) and value == 0.0


def _natural_unit(key: str, scene: Scene) -> NaturalUnit:
    """Of a length <x_s>; of a time the one in which the slider moves as far; of a damping that with which mass and
    spring hardly swing; of any other number 1."""
    name, length, drive = key.rsplit(".", 1)[-1], scene.contacts.mean_threshold, scene.drive
    if name in LENGTHS:
        return NaturalUnit("<x_s>", length)
    if name in ("time", "age"):
        return NaturalUnit("<x_s>/v", length / scene.sliding)
    if name == "damping" and drive.spring is not None:
        return NaturalUnit("(K M)^(1/2)", float(np.sqrt(drive.spring * (drive.mass or 0.0))))
    return NaturalUnit("", 1.0)


def times(value: Any, factor: float) -> Any:
    """A number, the number of a text with its unit, or all numbers of a list, times the factor."""
    if isinstance(value, list):
        return [times(inner, factor) for inner in value]
    if isinstance(value, str):
        found = _QUANTITY.fullmatch(value)
        return value if found is None else f"{float(found[1]) * factor:.12g}{found[2]}"
    if not _is_number(value):
        return value
    other = float(f"{value * factor:.12g}")
    return int(other) if isinstance(value, int) and other.is_integer() else other
