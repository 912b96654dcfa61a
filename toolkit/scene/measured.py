"""Your own thresholds in scenes: as a list, or from a text file with one sample a line."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

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
        lines = read_text("file", folder / file, comm, file).splitlines()
        names = {quantity: column} | (
            {} if weight_column is None else {"the weight": weight_column}
        )
        table = _read(file, lines, names)
        given[quantity] = table[:, 0].tolist()
        weights = table[:, 1].tolist() if weight_column is not None else None
    elif quantity != "x_s":
        refuse("quantity", quantity, "says what a file holds; leave it out without one")
    return origins.from_samples(
        **given, coefficient=coefficient, stiffness=stiffness, weights=weights
    )


def _read(file: str, lines: list[str], columns: dict[str, int | None]) -> np.ndarray:
    """The values of these columns, counted from 1 (None: of the only one), a row for each line."""
    rows: list[list[float]] = []
    width = 0
    for number, line in enumerate(lines, start=1):
        words = _words(line.partition("#")[0])
        values = [_number(word) for word in words]
        # a file of words alone may be no table, and not meant to be shown
        told = shown(line.strip()) if rows or not all(map(np.isnan, values)) else "no number"

        def bad(rule: str, here: str = f"line {number} holds {told}") -> NoReturn:
            refuse("file", file, f"{here}; {rule}")

        if not words:
            continue
        if not width:
            width = len(words)
            if all(np.isnan(value) for value in values) and "nan" not in words:
                continue  # a header
        if len(words) != width:
            bad(f"all lines must have as many columns as the first, {width}")
        rows.append([])
        for name, place in columns.items():
            if place is None and width > 1:
                bad(f"say which of the {width} columns holds {name}, such as column = {width}")
            if (place or 1) > width:
                bad(f"there is no column {place}")
            value = values[(place or 1) - 1]
            if not (np.isfinite(value) and value > 0.0):
                bad(
                    f"{name} must be a number, finite and above zero, one a line, or a header first"
                )
            rows[-1].append(value)
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


def _number(word: str) -> float:
    """nan for what is no number."""
    try:
        return float(word)
    except ValueError:
        return float("nan")
