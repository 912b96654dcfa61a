"""Your own thresholds in scenes: as a list, or from a text file with one sample a line."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import origins
from origins.errors import one_of, refuse, whole
from toolkit.scene.given_files import read_text

_DECIMAL = re.compile(r"\d,\d")


def from_samples(
    folder: Path,
    x_s: Sequence[float] | None = None,
    f_s: Sequence[float] | None = None,
    file: str | None = None,
    quantity: str = "x_s",
    column: int | None = None,
    weight_column: int | None = None,
    coefficient: float | None = None,
    stiffness: float | None = None,
    weights: Sequence[float] | None = None,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds through samples; see origins.from_samples.

    `file` counts from the scene's folder and is read by rank 0 of `comm`; its columns, parted by semicolons, or by
    blanks or commas, count from 1: `column` holds the values, x_s or f_s as `quantity` says, `weight_column` how much
    each counts, left out, all alike. `column` may be left out where there is one. Beside semicolons or blanks as
    separators "1,5" is 1.5, a decimal comma. # begins a comment, and the first line may be a header of text.
    Raises InputError.
    """
    given = {"x_s": x_s, "f_s": f_s}
    for name, value in (("column", column), ("weight_column", weight_column)):
        if value is not None:
            whole(name, value, 1)
            if file is None:
                rule = "says where in a file the samples are; leave it out without one"
                refuse(name, value, rule)
    if file is None and quantity != "x_s":
        refuse("quantity", quantity, "says what a file holds; leave it out without one")
    if file is not None:
        if x_s is not None or f_s is not None or weights is not None:
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        one_of("quantity", quantity, tuple(given))
        lines = read_text("file", file, folder, comm).splitlines()
        columns = {quantity: column}
        if weight_column is not None:
            columns["the weight"] = weight_column
        found = _read(file, lines, columns).T.tolist()
        given[quantity], weights = found[0], found[1] if len(found) > 1 else None
    return origins.from_samples(
        **given, coefficient=coefficient, stiffness=stiffness, weights=weights
    )


def _read(file: str, lines: list[str], columns: dict[str, int | None]) -> np.ndarray:
    """The values of these columns, counted from 1 (None: of the only one), a row for each line."""
    words = {number: _words(line.partition("#")[0]) for number, line in enumerate(lines, start=1)}
    rows = {number: [_number(word) for word in line] for number, line in words.items() if line}
    first = next(iter(rows), 0)
    if rows and all(value is None for value in rows[first]):
        del rows[first]  # a header
    width = len(next(iter(rows.values()), []))
    if not width:
        refuse("file", file, "holds no numbers; write one value a line")
    table = np.empty((len(rows), len(columns)))
    for column, (name, place) in enumerate(columns.items()):
        if place is None and width > 1:
            rule = f"say which of the {width} columns holds {name}, such as column = {width}"
            refuse("file", file, f"holds several columns; {rule}")
        if (place or 1) > width:
            refuse("file", file, f"there is no column {place}")
        for k, (number, row) in enumerate(rows.items()):
            value = row[(place or 1) - 1] if len(row) == width else None
            if value is None or not 0.0 < value < np.inf:
                # not the line itself: what is no table may not be meant to be shown
                many = f"{width} columns, as many as the first" if width > 1 else "one number"
                rule = f"line {number} must hold {many}, {name} finite and above zero"
                refuse("file", file, rule)
            table[k, column] = value
    return table


def _words(line: str) -> list[str]:
    """The columns of a line: parted by semicolons, or by blanks or commas.

    A comma between two digits is a decimal one where something else parts the columns.
    """
    decimal = _DECIMAL.search(line) is not None
    if ";" in line:
        return line.replace(",", "." if decimal else ",").replace(";", " ").split()
    if decimal and len(line.split()) > 1 and ", " not in line:
        return line.replace(",", ".").split()
    return line.replace(",", " ").split()


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
