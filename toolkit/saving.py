"""Saving of a result, and of a judgement: files and pictures, all or none."""

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from origins.errors import refuse
from toolkit.results.files import RESULT, another, earlier, summary, write_json, write_result
from toolkit.results.folders import write_folder
from toolkit.results.points import write_sweep
from toolkit.results.records import Result
from toolkit.results.spreadsheets import has_force, has_slips, write_force, write_rows, write_slips

FORMATS = ("pdf", "svg")  # of pictures, beside PNG

Writers = dict[str, Callable[[Path], None]]


def read_formats(text: str | None) -> tuple[str, ...]:
    """The formats of a list such as "pdf,svg"; "png" may be in it. Raises InputError for others."""
    names = [name.strip().lower() for name in (text or "").split(",") if name.strip()]
    for name in names:
        if name not in ("png", *FORMATS):
            refuse("format", name, "must be among png, pdf and svg, such as --format pdf,svg")
    return tuple(dict.fromkeys(name for name in names if name != "png"))


def pictures(name: str, draw: Callable[[Path], None], formats: Sequence[str] = ()) -> Writers:
    """Writers of the picture `name`, which `draw` draws into a path by its suffix: as PNG, and in these formats."""
    return {f"{name}.{suffix}": draw for suffix in ("png", *formats)}


def stale(names: Sequence[str], writers: Writers) -> list[str]:
    """Pictures of these names in formats that are not written now: of an earlier call."""
    files = [f"{name}.{suffix}" for name in names for suffix in FORMATS]
    return [file for file in files if file not in writers]


def save(result: Result, folder: str | os.PathLike[str], formats: Sequence[str] = ()) -> None:
    """Write result.h5, summary.json and picture.png into `folder`, for a path force.csv, for a slider on a spring
    slips.csv, for a sweep sweep.csv and for islands barriers.png, all or none; pictures in `formats` such as
    ("pdf", "svg"), too. Another scene's thresholds.json and pictures, the CSV files of an earlier run and its pictures
    in other formats are removed.

    result.h5 holds a group per solver, one for the thresholds and, for a rough surface, one for its interface. Each
    array has its unit as the attribute `units`; force is per N_c<k>, so a length. Raises InputError where the folder
    cannot be written.
    """
    from toolkit.pictures.run import save_picture  # matplotlib only where a picture is drawn

    writers: Writers = {
        RESULT: lambda path: write_result(result, path),
        "summary.json": lambda path: write_json(summary(result), path),
        **pictures("picture", partial(save_picture, result), formats),
    }
    if has_force(result):
        writers["force.csv"] = partial(write_force, result)
    if has_slips(result):
        writers["slips.csv"] = partial(write_slips, result)
    if (islands := result.domains) is not None:
        from toolkit.pictures.thresholds import save_barriers

        writers |= pictures("barriers", partial(save_barriers, islands), formats)
    if result.sweep is not None:
        writers["sweep.csv"] = partial(write_sweep, result)
    gone = [*earlier(folder).get("tables", []), *stale(["picture", "barriers"], writers)]
    if another(folder, result.name, result.text) is not None:
        gone += ["thresholds.json", "thresholds.png", "barriers.png"]
        gone += stale(["thresholds"], writers)
    write_folder(folder, writers, [name for name in gone if name not in writers])


def save_judgement(
    folder: str,
    name: str,
    draw: Any,
    lines: list[str],
    numbers: dict[str, Any],
    rows: Mapping[str, Sequence[Any]],
    formats: Sequence[str] = (),
    table: str = "",
) -> None:
    """Write name.png, .txt, .json and .csv, the last as table.csv if that is given; `rows` are its columns, by their
    heads, and without any there is none. The picture is written in `formats`, too. Raises InputError where that
    fails."""
    text, figure = "\n".join([*lines, ""]), draw()
    writers: dict[str, Any] = {
        **pictures(name, partial(_save_figure, figure), formats),
        f"{name}.txt": lambda path: path.write_text(text, encoding="utf-8"),
        f"{name}.json": lambda path: write_json(numbers, path),
    }
    if rows:
        writers[f"{table or name}.csv"] = partial(write_rows, rows)
    write_folder(folder, writers, stale([name], writers))


def _save_figure(figure: Any, path: Path) -> None:
    figure.savefig(path, dpi=150, format=path.suffix[1:])
