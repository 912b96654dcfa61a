"""Files that a scene names, read by rank 0 for all ranks; and your own thresholds, as a list or from a text file."""

import re
import stat
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import origins
from origins.errors import one_of, refuse, whole
from toolkit.running.ranks import on_root

T = TypeVar("T")

_MOST = 1 << 30  # bytes of a file


def read_file(
    key: str, file: str, folder: Path, comm: Any, read: Callable[[Path], T], what: str = "file"
) -> T:
    """What `read` makes of the file in this folder, the same on all ranks, which must all call.

    `key` is the scene's key that names it. Raises InputError for what is no plain file: a pipe or a device might never
    end.
    """
    if not isinstance(file, str):
        refuse(key, file, f'must be a name of a {what}, such as "own.txt"')

    def checked() -> T:
        path = folder / file
        try:
            status = path.stat()
        except FileNotFoundError:
            refuse(key, file, f"no such file in {path.parent.resolve()}")
        except (OSError, ValueError) as error:  # a name too long for the disk, or with a NUL
            refuse(key, file, f"cannot be read: {getattr(error, 'strerror', None) or error}")
        if not stat.S_ISREG(status.st_mode) or status.st_size > _MOST:
            refuse(key, file, f"must be a plain {what} of at most {_MOST:.0e} bytes")
        return read(path)

    return on_root(comm, checked)


def read_text(key: str, file: str, folder: Path, comm: Any, bad: str = "is no text") -> str:
    """The text of such a file; `bad` is what a message says of one that holds none."""

    def read(path: Path) -> str:
        try:
            return path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            refuse(key, file, f"{bad}: {getattr(error, 'strerror', None) or error}")

    return read_file(key, file, folder, comm, read)


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

    `file` counts from the scene's folder; its columns, parted by semicolons, or by blanks or commas, count from 1:
    `column` holds the values, x_s or f_s as `quantity` says, and may be left out where there is one, `weight_column`
    how much each counts. Beside semicolons or blanks as separators "1,5" is 1.5, a decimal comma. # begins a comment,
    and the first line may be a header of text. Raises InputError.
    """
    given: dict[str, Any] = {"x_s": x_s, "f_s": f_s, "weights": weights}
    of_file = {"column": column, "weight_column": weight_column, "quantity": quantity}
    if file is None:
        for name, value in of_file.items():
            if value not in (None, "x_s"):
                refuse(name, value, "says what a file holds; leave it out without one")
    else:
        if any(values is not None for values in given.values()):
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        one_of("quantity", quantity, ("x_s", "f_s"))
        lines = read_text("file", file, folder, comm).splitlines()
        places = {quantity: column} | ({} if weight_column is None else {"weights": weight_column})
        given |= _read(file, lines, places)
    return origins.from_samples(**given, coefficient=coefficient, stiffness=stiffness)


def _read(file: str, lines: list[str], places: dict[str, int | None]) -> dict[str, list[float]]:
    """The values of these columns by name, counted from 1 (None: of the only one)."""
    words = {number: _words(line.partition("#")[0]) for number, line in enumerate(lines, start=1)}
    rows = {number: [_number(word) for word in line] for number, line in words.items() if line}
    first = next(iter(rows), 0)
    if rows and np.isnan(rows[first]).all():
        del rows[first]  # a header
    width = len(next(iter(rows.values()), []))
    if not width:
        refuse("file", file, "holds no numbers; write one value a line")
    found: dict[str, list[float]] = {}
    for name, place in places.items():
        if place is None and width > 1:
            rule = f"say which of the {width} columns holds {name}, such as column = {width}"
            refuse("file", file, f"holds several columns; {rule}")
        if (column := whole("column", 1 if place is None else place, 1)) > width:
            refuse("file", file, f"there is no column {place}")
        found[name] = [row[column - 1] if len(row) == width else np.nan for row in rows.values()]
        for number, value in zip(rows, found[name], strict=True):
            if not 0.0 < value < np.inf:
                # not the line itself: what is no table may not be meant to be shown
                many = f"{width} columns, as many as the first" if width > 1 else "one number"
                rule = f"line {number} must hold {many}, {name} finite and above zero"
                refuse("file", file, rule)
    return found


def _words(line: str) -> list[str]:
    """The columns of a line: parted by semicolons, or by blanks or commas.

    A comma between two digits is a decimal one where something else parts the columns.
    """
    decimal = re.search(r"\d,\d", line) is not None
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
        return np.nan
