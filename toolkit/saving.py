"""Saving of a result: its files and its pictures, all or none."""

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from toolkit.results.files import (
    RESULT,
    another,
    earlier,
    summary,
    units_of,
    write_json,
    write_result,
)
from toolkit.results.folders import write_folder
from toolkit.results.points import PointsRecord, write_points_csv
from toolkit.results.records import Result
from toolkit.results.spreadsheets import has_force, has_slips, write_force, write_slips, write_sweep

_OF_THRESHOLDS = ("thresholds.json", "thresholds.png")  # what the command `thresholds` writes


def save(result: Result, folder: str | os.PathLike[str]) -> None:
    """Write result.h5, summary.json and picture.png into `folder`, for a path force.csv, for a slider on a spring
    slips.csv, for a sweep sweep.csv and for islands barriers.png, all or none. Another scene's thresholds.json,
    thresholds.png and barriers.png, or the CSV files of an earlier run, are removed.

    result.h5 holds a group per solver, one for the thresholds and, for a rough surface, one for its interface. Each
    array has its unit as the attribute `units`; force is per N_c<k>, so a length. Raises InputError where the folder
    cannot be written.
    """
    from toolkit.pictures.run import save_picture  # matplotlib only where a picture is drawn

    writers: dict[str, Callable[[Path], None]] = {
        RESULT: lambda path: write_result(result, path),
        "summary.json": lambda path: write_json(summary(result), path),
        "picture.png": lambda path: save_picture(result, path),
    }
    if has_force(result):
        writers["force.csv"] = partial(write_force, result)
    if has_slips(result):
        writers["slips.csv"] = partial(write_slips, result)
    if (islands := result.domains) is not None:
        from toolkit.pictures.thresholds import save_barriers

        writers["barriers.png"] = lambda path: save_barriers(islands, path)
    sweep = result.sweep
    if isinstance(sweep, PointsRecord):
        writers["sweep.csv"] = partial(write_points_csv, sweep)
    elif sweep is not None:
        units = units_of(result, short=True) | {"force_error": "<x_s>"}
        writers["sweep.csv"] = partial(write_sweep, sweep, units)
    gone = earlier(folder).get("tables", [])
    if another(folder, result.name, result.text) is not None:
        gone += [*_OF_THRESHOLDS, "barriers.png"]
    write_folder(folder, writers, [name for name in gone if name not in writers])
