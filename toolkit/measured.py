"""Your own thresholds in scenes: as a list, or from a text file of one value, or one value and its weight, a line."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import origins
from origins.errors import InputError, refuse

QUANTITIES = ("x_s", "f_s")


def from_samples(
    folder: Path,
    x_s: Sequence[float] | None = None,
    f_s: Sequence[float] | None = None,
    file: str | None = None,
    quantity: str = "x_s",
    coefficient: float | None = None,
    stiffness: float | None = None,
    weights: Sequence[float] | None = None,
) -> origins.Thresholds:
    """Thresholds through samples; see origins.from_samples.

    `file` counts from the scene's folder; its lines hold a value, x_s or f_s as `quantity` says, and where there is a
    second column its weight; # begins a comment. Raises InputError.
    """
    given = {"x_s": x_s, "f_s": f_s}
    if file is not None:
        if x_s is not None or f_s is not None or weights is not None:
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        if quantity not in QUANTITIES:
            refuse("quantity", quantity, 'must be "x_s" or "f_s"')
        table = _read(folder, file)
        given[quantity] = table[:, 0].tolist()
        weights = table[:, 1].tolist() if table.shape[1] == 2 else None
    elif quantity != "x_s":
        refuse("quantity", quantity, "says what a file holds; leave it out without one")
    return origins.from_samples(**given, coefficient=coefficient, stiffness=stiffness, weights=weights)


def _read(folder: Path, file: str) -> np.ndarray:
    if not isinstance(file, str):
        refuse("file", file, 'must be a file name, such as "thresholds.txt"')
    try:
        lines = (folder / file).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"file = {file!r}: cannot be read as text ({error}); name a file beside the scene") from error
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if not 1 <= len(row) <= 2 or (rows and len(row) != len(rows[0])):
            rule = "write one value a line, or a value and its weight"
            refuse("file", file, f"line {number} holds {line.strip()!r}; {rule}")
        rows.append(row)
    if not rows:
        refuse("file", file, "holds no numbers; write one value a line")
    return np.array(rows)
