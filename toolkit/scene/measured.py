"""Your own thresholds in scenes: as a list, or from a text file with one sample a line."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import origins
from origins.errors import InputError, refuse, whole

QUANTITIES = ("x_s", "f_s")


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
) -> origins.Thresholds:
    """Thresholds through samples; see origins.from_samples.

    `file` counts from the scene's folder; its columns, parted by blanks or commas, count from 1: `column` holds the
    values, x_s or f_s as `quantity` says, `weight_column` how much each counts, left out, all alike. `column` may be
    left out where there is one. # begins a comment, and the first line may be a header of text. Raises InputError.
    """
    given = {"x_s": x_s, "f_s": f_s}
    for name, value in (("column", column), ("weight_column", weight_column)):
        if value is not None:
            whole(name, value, 1)
            if file is None:
                refuse(name, value, "says where in a file the samples are; leave it out without one")
    if file is not None:
        if x_s is not None or f_s is not None or weights is not None:
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        if quantity not in QUANTITIES:
            refuse("quantity", quantity, 'must be "x_s" or "f_s"')
        table = _read(folder, file, quantity, column, weight_column)
        given[quantity] = table[:, 0].tolist()
        weights = table[:, 1].tolist() if weight_column is not None else None
    elif quantity != "x_s":
        refuse("quantity", quantity, "says what a file holds; leave it out without one")
    return origins.from_samples(**given, coefficient=coefficient, stiffness=stiffness, weights=weights)


def _read(folder: Path, file: str, quantity: str, column: int | None, weight_column: int | None) -> np.ndarray:
    """The values and, where asked for, their weights as columns."""
    if not isinstance(file, str):
        refuse("file", file, 'must be a file name, such as "thresholds.txt"')
    try:
        lines = (folder / file).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"file = {file!r}: cannot be read as text ({error}); name a file beside the scene") from error
    rows: list[list[float]] = []
    width = first = 0
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        first = first or number
        if number == first and not any(_number(word) is not None for word in words):
            continue  # a header
        here = f"line {number} holds {line.strip()!r}"
        width = width or len(words)
        if len(words) != width:
            refuse("file", file, f"{here}; all lines must have as many columns as the first, {width}")
        if column is None and width > 1:
            refuse("file", file, f"{here}; say which of the {width} columns holds {quantity}, such as column = {width}")
        row = []
        for name, place in ((quantity, column or 1), ("the weight", weight_column)):
            if place is None:
                continue
            if place > width:
                refuse("file", file, f"{here}; there is no column {place}")
            value = _number(words[place - 1])
            if value is None:
                rule = "is no number, write one value a line, or a header first"
                refuse("file", file, f"{here}; {words[place - 1]!r} {rule}")
            if not (np.isfinite(value) and value > 0.0):
                refuse("file", file, f"{here}; {name} = {value:g} must be finite and above zero")
            row.append(value)
        rows.append(row)
    if not rows:
        refuse("file", file, "holds no numbers; write one value a line")
    return np.array(rows)


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
