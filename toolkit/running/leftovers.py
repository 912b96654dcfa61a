"""What this package wrote earlier into a folder and of another scene, which must not be taken for a new run's."""

import json
import os
import tomllib
from pathlib import Path

from origins.errors import InputError, refuse
from toolkit.results.files import TABLE, load
from toolkit.results.records import Result
from toolkit.scene.tables import read_table

THRESHOLDS = ("thresholds.json", "thresholds.png")


def left_over(folder: str | os.PathLike[str], result: Result) -> list[str]:
    """Names of the files in `folder` that `run` must take away as it writes `result`, and only such as are known to be
    of this package: the table of a sweep that the old result holds and the new one does not, and what `thresholds` told
    of other contacts."""
    path, out = Path(folder), []
    before = _result(path)
    if before is not None and before.sweep is not None and result.sweep is None:
        out.append(TABLE)
    told = _told(path / THRESHOLDS[0])
    if told is not None and not _same(told, (result.name, result.text)):
        out += THRESHOLDS
    return [name for name in out if (path / name).is_file()]


def check_beside(folder: str | os.PathLike[str], name: str, text: str) -> None:
    """InputError where `folder` holds the result of another scene than that of this name and TOML text: what a run may
    have taken hours for is not taken away for a table."""
    if (whose := another(folder, name, text)) is not None:
        refuse(
            "out",
            str(folder),
            f"holds the result of {whose}; choose another, or run this scene there",
        )


def another(folder: str | os.PathLike[str], name: str, text: str) -> str | None:
    """In words, whose result `folder` holds; None where that is of this scene, by name and TOML text, or none is."""
    before = _result(Path(folder))
    if before is None or _same((before.name, before.text), (name, text)):
        return None
    return (
        f"another scene, {before.name}" if before.name != name else "this scene with other contacts"
    )


def _same(one: tuple[str, str], other: tuple[str, str]) -> bool:
    """Whether two scenes, by name and text, have the same name and contacts."""
    return one[0] == other[0] and _contacts(one[1]) == _contacts(other[1])


def _contacts(text: str) -> object:
    try:
        return read_table(tomllib.loads(text)).contacts
    except (InputError, tomllib.TOMLDecodeError):
        return None  # of an older package


def _result(folder: Path) -> Result | None:
    """The result in a folder; None where there is none, or none that can be read."""
    try:
        return load(folder)
    except InputError:
        return None


def _told(file: Path) -> tuple[str, str] | None:
    """Name and text of the scene that `thresholds` told of; None where this is no file of its."""
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        return str(record["name"]), str(record["scene"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
