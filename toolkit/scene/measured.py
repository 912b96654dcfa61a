"""Your own thresholds in scenes: as a list, or from a text file with one sample a line."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import origins
from origins.errors import refuse, shown, whole
from toolkit.scene.given_files import read_text

QUANTITIES = ("x_s", "f_s")
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
    blanks or commas, count from 1: `column` holds the
    values, x_s or f_s as `quantity` says, `weight_column` how much each counts, left out, all alike. `column` may be
    left out where there is one. Beside semicolons or blanks as separators "1,5" is 1.5, a decimal comma. # begins a
    comment, and the first line may be a header of text. Raises InputError.
    """
    given = {"x_s": x_s, "f_s": f_s}
    for name, value in (("column", column), ("weight_column", weight_column)):
        if value is not None:
            whole(name, value, 1)
            if file is None:
                refuse(
                    name, value, "says where in a file the samples are; leave it out without one"
                )
    if file is not None:
        if not isinstance(file, str):
            refuse("file", file, 'must be a file name, such as "thresholds.txt"')
        if x_s is not None or f_s is not None or weights is not None:
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        if quantity not in QUANTITIES:
            refuse("quantity", quantity, 'must be "x_s" or "f_s"')
        table = _read(folder, file, quantity, column, weight_column, comm)
        given[quantity] = table[:, 0].tolist()
        weights = table[:, 1].tolist() if weight_column is not None else None
    elif quantity != "x_s":
        refuse("quantity", quantity, "says what a file holds; leave it out without one")
    return origins.from_samples(
        **given, coefficient=coefficient, stiffness=stiffness, weights=weights
    )


def _read(
    folder: Path, file: str, quantity: str, column: int | None, weight_column: int | None, comm: Any
) -> np.ndarray:
    """The values and, where asked for, their weights as columns."""
    if not isinstance(file, str):
        refuse("file", file, 'must be a file name, such as "thresholds.txt"')
    lines = read_text("file", folder / file, comm, file).splitlines()
    rows: list[list[float]] = []
    width = first = 0
    for number, line in enumerate(lines, start=1):
        words = _words(line.partition("#")[0])
        if not words:
            continue
        first = first or number
        if number == first and not any(map(_is_number, words)):
            continue  # a header
        # a file of words alone may be no table, and not meant to be shown
        told = bool(rows) or any(map(_is_number, words))
        here = f"line {number} holds {shown(line.strip()) if told else 'no number'}"
        width = width or len(words)
        if len(words) != width:
            refuse(
                "file", file, f"{here}; all lines must have as many columns as the first, {width}"
            )
        if column is None and width > 1:
            refuse(
                "file",
                file,
                f"{here}; say which of the {width} columns holds {quantity}, such as column = {width}",
            )
        row = []
        for name, place in ((quantity, column or 1), ("the weight", weight_column)):
            if place is None:
                continue
            if place > width:
                refuse("file", file, f"{here}; there is no column {place}")
            value = _number(words[place - 1])
            if value is None:
                which = f"{words[place - 1]!r} is no number, " if told else ""
                refuse("file", file, f"{here}; {which}write one value a line, or a header first")
            if not (np.isfinite(value) and value > 0.0):
                refuse("file", file, f"{here}; {name} = {value:g} must be finite and above zero")
            row.append(value)
        rows.append(row)
    if not rows:
        refuse("file", file, "holds no numbers; write one value a line")
    return np.array(rows)


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


def _is_number(word: str) -> bool:
    return _number(word) is not None


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
