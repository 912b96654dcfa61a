"""Thresholds through samples: a scene's own values, or a column of a text file, with header, weights and unit."""

import math
import re
from collections.abc import Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from textwrap import shorten
from typing import Any
from unicodedata import normalize

import numpy as np

import origins
from origins.errors import InputError, finite_array, one_of, refuse, whole
from origins.roughness.surface import METRES
from toolkit.scene.files import read_file, read_text
from toolkit.scene.tables import did_you_mean

# of a file of samples; one with more, and no header, may be another one
FEW_COLUMNS = 4
# part of a stiffness by which the same, given twice, may differ, as one of them is rounded
SAME_STIFFNESS = 1e-3
NEWTONS = {"N": 1.0, "mN": 1e-3, "µN": 1e-6, "uN": 1e-6, "nN": 1e-9, "pN": 1e-12}


def from_samples(
    folder: Path,
    x_s: Sequence[float] | None = None,
    f_s: Sequence[float] | None = None,
    file: str | None = None,
    quantity: str = "x_s",
    column: int | str | None = None,
    weight_column: int | str | None = None,
    decimal: str = ".",
    unit: str | None = None,
    coefficient: float | None = None,
    stiffness: float | None = None,
    weights: Sequence[float] | None = None,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds through samples; see origins.from_samples.

    `file` is relative to the scene's folder; its columns, separated by semicolons, or by blanks or commas, count from
    1: `column` has the values, x_s or f_s by `quantity`, and may be left out if it is the only one; `weight_column` has
    the weights. With semicolons or blanks as separators "1,5" is 1.5, a decimal comma. # begins a comment, and the
    first line may be a header of text, whose words name columns, too. `decimal = ","`: every comma is a decimal one.
    `unit`, such as "nm" or "nN": x_s or f_s are in it, and become metres or newtons. Raises InputError.
    """
    given: dict[str, Any] = {"x_s": x_s, "f_s": f_s, "weights": weights}
    if file is None:
        if (column, weight_column, quantity, decimal) != (None, None, "x_s", "."):
            hint = "quantity, column, weight_column and decimal say what a file holds; leave them out without one"
            raise InputError(f"from_samples: {hint}")
    else:
        if any(values is not None for values in given.values()):
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        one_of("quantity", quantity, ("x_s", "f_s"))
        one_of("decimal", decimal, (".", ","))
        lines = read_file("file", file, folder, comm, read_text).splitlines()
        place = _place("column", column, lines)
        given[quantity] = _column(file, lines, quantity, place, decimal)
        if weight_column is not None:
            other = _place("weight_column", weight_column, lines)
            if other == (place or 1):
                refuse("weight_column", weight_column, "is that of the samples; name another")
            given["weights"] = _column(file, lines, "weights", other, decimal)
    if unit is not None:
        name = "x_s" if given["x_s"] is not None else "f_s"
        values = finite_array(name, given[name])
        given[name] = values * in_si(unit, METRES if name == "x_s" else NEWTONS)
    law = origins.from_samples(**given, coefficient=coefficient, stiffness=stiffness)
    law.in_metres = unit is not None
    return law


def _place(key: str, column: int | str | None, lines: list[str]) -> int | None:
    """The number of a column that is named by the header, which may begin with #; InputError where it names no such
    column."""
    if not isinstance(column, str):
        return column
    names = _names(lines)
    if not names:
        hint = "names no column, as no header stands before the numbers; write its number, as"
        refuse(key, column, f"{hint} {key} = 1")
    if column not in names:
        hint = f"is no column of the header; {did_you_mean(column, names)}it names"
        refuse(key, column, f"{hint} {shorten(', '.join(names), 100, placeholder=' ...')}")
    return names.index(column) + 1


def _names(lines: list[str]) -> list[str]:
    """The words of the last line before the numbers, of one that is no comment where there is one: names of columns
    where it is a header."""
    above = list(takewhile(lambda line: not _has_numbers(line), filter(str.strip, lines)))
    plain = [line for line in above if not line.lstrip().startswith("#")]
    header = (plain or above or [""])[-1].strip().lstrip("#").strip()
    names = [word.strip().strip("\"'") for word in re.split(r"[;,\t]", header)]
    return names if len(names) > 1 else header.split()


def _has_numbers(line: str) -> bool:
    """Whether a line has a number that is no part of a comment."""
    return bool(np.isfinite(_words(line.partition("#")[0])).any())


def _column(file: str, lines: list[str], name: str, place: int | None, decimal: str) -> list[float]:
    """The values of this column, counted from 1 (None: of the only one)."""
    if decimal == ",":
        lines = [line.replace(",", ".") for line in lines]
    numbered = enumerate((_words(line.partition("#")[0]) for line in lines), start=1)
    rows = [(number, row) for number, row in numbered if row]
    if rows and np.isnan(rows[0][1]).all() and not re.match(r"\W*\d", lines[rows[0][0] - 1]):
        del rows[0]  # a header, and no mistyped number
    if not rows:
        refuse("file", file, "holds no numbers; write one value a line")
    width = len(rows[0][1])
    parted = re.compile(r"\s*[-+]?\d+,\d+(?:[eE][-+]?\d+)?\s*")
    if place is None and all(parted.fullmatch(lines[n - 1]) for n, _ in rows):
        hint = """a decimal comma? write decimal = ","; two columns? say which, as column = 2"""
        refuse("file", file, f"holds two numbers a line, parted by a comma: {hint}")
    if place is None and width > 1:
        _refuse_many(file, name, width, _names(lines))
    if (column := whole("column", 1 if place is None else place, 1)) > width:
        listed = _listed(_names(lines), width)
        of = f", {listed}" * bool(listed)
        refuse("file", file, f"there is no column {place} of {width}{of}")
    for number, row in rows:
        # do not show the line itself: the file may be private
        if len(row) != width:
            refuse("file", file, f"line {number} has {len(row)} columns, the first has {width}")
        if not 0.0 < row[column - 1] < np.inf:
            refuse("file", file, f"line {number}: {name} must be a number > 0; else leave it out")
    return [row[column - 1] for _, row in rows]


def _refuse_many(file: str, name: str, width: int, names: list[str]) -> None:
    """Refuse to choose among columns, which are named where the header names as many."""
    listed = _listed(names, width)
    which = f"1 to {width}" if not listed else f'"{name}"' if name in names else listed
    other = "; or is it another file, as of heights or atoms?" * (
        not listed and width > FEW_COLUMNS
    )
    hint = f"say which has {name}, as column = {which}"
    refuse("file", file, f"holds {width} columns; {hint}{other}")


def _listed(names: list[str], width: int) -> str:
    """The names of the columns, as many as a line takes; "" where the file has no header of as many words."""
    if len(names) != width or not any(map(str.isidentifier, names)):
        return ""
    return shorten(" or ".join(f'"{one}"' for one in names), 100, placeholder=" ...")


def _words(line: str) -> list[float]:
    """The columns of a line, separated by semicolons, or by blanks or commas; nan for words that are not numbers.

    A comma between two digits is a decimal comma where something else separates the columns.
    """
    if re.search(r"\d,\d", line) and (";" in line or (len(line.split()) > 1 and ", " not in line)):
        line = line.replace(",", ".")
    found = []
    for word in re.split(r"[;,\s]+", line.strip()):
        try:
            found.append(float(word))
        except ValueError:
            found += [np.nan] if word else []
    return found


def in_si(unit: str, units: dict[str, float]) -> float:
    """What one of this unit is in SI units; InputError for a unit that is not known."""
    if unit not in units:  # letters that look alike are one to the reader
        one_of("unit", unit, tuple(dict.fromkeys(normalize("NFKC", one) for one in units)))
    return units[unit]


def check_units(law: Mapping[str, Any], interface: Mapping[str, Any] | None) -> None:
    """Refuse what is in SI units by one key of the thresholds' table, and by another is not."""
    _check_energy(law, interface)
    _check_one_stiffness(law, interface)


def _check_energy(law: Mapping[str, Any], interface: Mapping[str, Any] | None) -> None:
    """Refuse islands in SI units on a substrate without an amplitude: its default of 1 would be a joule an atom, and
    all forces are proportional to it. Elsewhere 1 is the unit of energy."""
    island, substrate = law.get("island"), law.get("substrate", {})
    in_metres = interface is not None or (isinstance(island, dict) and "unit" in island)
    if law.get("kind") != "domains" or not in_metres or not isinstance(substrate, dict):
        return
    if substrate.get("kind") != "fourier" and "amplitude" not in substrate:
        raise InputError(
            "contacts.thresholds.substrate.amplitude: is missing; where lengths are in metres it is an energy in J for "
            "each atom, such as 3.2e-21 (20 meV), and has no default"
        )


def _check_one_stiffness(law: Mapping[str, Any], interface: Mapping[str, Any] | None) -> None:
    """Refuse an interface whose <k> is not the stiffness by which forces of the law, or islands, became lengths: forces
    of the answer would be off by their ratio. Where it hangs on the island the two are not compared; forces without a
    `unit` may be in nN, mN or the like, and their stiffness with them."""
    forces = "f_s" in law or law.get("quantity") == "f_s"
    alike = forces or (law.get("kind"), law.get("law")) == ("domains", "equal")
    stated, given = (interface or {}).get("mean_stiffness"), law.get("stiffness")
    if not (alike and isinstance(stated, float | int) and isinstance(given, float | int)):
        return
    if not (given > 0.0 and 1e-30 < stated / given < 1e30):
        return
    unit = 1e3 ** round(math.log(stated / given, 1e3)) if forces and "unit" not in law else 1.0
    if abs(stated - unit * given) > SAME_STIFFNESS * unit * given:
        hint = f"thresholds.stiffness = {given:g} N/m turned forces into lengths; give the same <k>"
        refuse("contacts.interface.mean_stiffness", stated, hint)
