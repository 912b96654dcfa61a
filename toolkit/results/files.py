"""Result folders: result.h5, summary.json and a picture, and their way back."""

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from origins.errors import refuse
from toolkit.results.folders import write_folder
from toolkit.results.opened import RESULT, opened
from toolkit.results.records import (
    OWN_UNIT,
    AgeingRecord,
    CoupledRecord,
    Result,
    SimulatedRecord,
    SoftRecord,
    SolvedRecord,
    ThresholdCurve,
)
from toolkit.results.sealed import write_sealed
from toolkit.results.summary import summary
from toolkit.scene.interfaces import Number
from toolkit.scene.sweep import SweepRecord

if TYPE_CHECKING:
    import h5py

    from eq_model.histogram import Histogram

SUMMARY, PICTURE, TABLE = "summary.json", "picture.png", "sweep.csv"
BARRIERS = "barriers.png"  # of islands

_HISTOGRAMS, _PER_RANK = "histograms", "breaks_per_rank"
_LENGTHS = (
    *("path", "position", "force", "force_standard_error", "step_error"),
    *("position_standard_error", "positions", "forces"),
    *("x", "atoms", "stretch_edges", "threshold_edges"),
    *(f"slip_{name}" for name in ("drive", "before", "after", "force_before", "force_after")),
)


def save(result: Result, folder: str | os.PathLike[str]) -> None:
    """Write result.h5, summary.json and picture.png into `folder`, of a sweep sweep.csv and of islands barriers.png,
    whole or not at all.

    What this package wrote there earlier and would be taken for this run's is removed: the sweep.csv of a result that
    had a sweep where this has none, and thresholds.json and .png of other contacts.

    result.h5 holds a group per solver, one for the thresholds and, for a rough surface, one for its interface. Each
    array has its unit as the attribute `units`; force is per N_c<k>, so a length. Raises InputError where the folder
    cannot be written.
    """
    from toolkit.pictures.run import save_picture
    from toolkit.results.sweep_table import write_csv
    from toolkit.running.leftovers import left_over

    writers: dict[str, Callable[[Path], None]] = {
        RESULT: lambda path: _write_result(result, path),
        SUMMARY: lambda path: write_json(summary(result), path),
        PICTURE: lambda path: save_picture(result, path),
    }
    if (islands := result.domains) is not None:
        from toolkit.pictures.islands import save_barriers

        writers[BARRIERS] = lambda path: save_barriers(islands, path)
    if (sweep := result.sweep) is not None:
        units = _units("length" if result.thresholds.unit == OWN_UNIT else "m") | {
            "force_error": "<x_s>"
        }
        writers[TABLE] = lambda path: write_csv(sweep, units, path)
    write_folder(folder, writers, left_over(folder, result))


def load(folder: str | os.PathLike[str]) -> Result:
    """The Result that `save`, or the command `run`, wrote into `folder`.

    Its fields, where they were asked for: `master.path`, `.force`, `.force_error`, `.holding`, `.success`; `eq.path`,
    `.force`, `.force_standard_error`, `.breaks`, `.histograms`, each read when it is asked for; `thresholds.x`,
    `.density`, `.survival`, `.unit`; `mean_threshold`; `notes`; `interface["contact_density"].value` and more; `text`,
    the scene. Raises InputError where there is none.
    """
    file = Path(folder) / RESULT
    if Path(folder).is_file():
        refuse("folder", str(folder), f"is a file; give the folder, {str(Path(folder).parent)!r}")
    if not file.is_file():
        refuse(
            "folder",
            str(folder),
            f"holds no {RESULT}; mesofriction run SCENE --out FOLDER writes one",
        )
    with opened(file) as store:
        return Result(
            name=str(store.attrs["name"]),
            title=str(store.attrs["title"]),
            text=str(store.attrs["scene"]),
            version=str(store.attrs["version"]),
            mean_threshold=float(store.attrs["mean_threshold"]),
            thresholds=_read(store["thresholds"], ThresholdCurve),
            master=_read_solved(store["master"]) if "master" in store else None,
            eq=_read_simulated(store["eq"], file) if "eq" in store else None,
            notes=tuple(note.decode() for note in store["notes"][()]) if "notes" in store else (),
            interface=_read_interface(store["interface"]) if "interface" in store else None,
            sweep=_read(store["sweep"], SweepRecord) if "sweep" in store else None,
        )


def write_json(content: dict[str, Any], path: Path) -> None:
    """Write `content` as indented JSON; what is not finite becomes null, since JSON has no word for it."""
    path.write_text(
        json.dumps(_speakable(content), indent=2, allow_nan=False) + "\n", encoding="utf-8"
    )


def _speakable(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _speakable(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_speakable(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _write_result(result: Result, path: Path) -> None:
    """In memory first: a signal, or a disk that refuses, within HDF5 would take the process down."""
    import h5py

    with h5py.File(path.name, "w", driver="core", backing_store=False) as store:
        _fill(result, store)
        store.flush()
        contents = store.id.get_file_image()
    write_sealed(path, contents)


def _fill(result: Result, store: "h5py.File") -> None:
    store.attrs.update(
        name=result.name,
        title=result.title,
        scene=result.text,
        version=result.version,
        mean_threshold=result.mean_threshold,
    )
    unit = result.thresholds.unit
    _write(store.create_group("thresholds"), result.thresholds, ThresholdCurve, unit)
    if result.asked.drive is not None:
        store["time"] = result.time
        store["time"].attrs["units"] = "time" if unit == OWN_UNIT else "s"
    if result.notes:
        store["notes"] = list(result.notes)
        store["notes"].attrs["units"] = "text"
    if result.interface is not None:
        _write_interface(store.create_group("interface"), result.interface)
    if result.master is not None:
        _write(
            store.create_group("master"), result.master, _kind_of(result.master, SolvedRecord), unit
        )
    if result.sweep is not None:
        _write(store.create_group("sweep"), result.sweep, SweepRecord, unit)
    if result.eq is not None and result.asked.eq is not None:
        store.attrs["seed"] = result.asked.eq.seed
        group = store.create_group("eq")
        _write(group, result.eq, _kind_of(result.eq, SimulatedRecord), unit)
        _write_histograms(group, result.eq.histograms, unit)


def _kind_of(answer: object, plain: type) -> type:
    """The record that an answer is, or else `plain`, whose fields it has."""
    return type(answer) if isinstance(answer, plain) else plain


def _write(group: "h5py.Group", answer: object, record: type[Any], unit: str) -> None:
    """The fields of `record`, as found on `answer`: arrays as data sets, the rest as attributes."""
    units = _units(unit)
    for field in fields(record):
        value = getattr(answer, field.name)
        if isinstance(value, np.ndarray) or field.name == _PER_RANK:
            group[field.name] = value
            group[field.name].attrs["units"] = units.get(field.name, "1")
        elif field.name != _HISTOGRAMS and value is not None:
            group.attrs[field.name] = value


def _units(unit: str) -> dict[str, str]:
    """Of all arrays that have one, by name; `unit` is that of lengths."""
    clock = "s" if unit == "m" else "time"
    units = {
        "density": f"1 / {unit}",
        **dict.fromkeys(_LENGTHS, unit),
        "delay": clock,
        "kelvin": "K",
    }
    return units | {
        "velocity": f"{unit} / {clock}",
        "temperature": f"({unit})^2",
        "rate": f"({unit})^2 / {clock}",
    }


def _write_interface(group: "h5py.Group", numbers: dict[str, Number]) -> None:
    for name, number in numbers.items():
        group[name] = number.value
        group[name].attrs["units"] = number.unit or "1"
        if number.error is not None:
            group[name].attrs["error"] = number.error


def _read_interface(group: "h5py.Group") -> dict[str, Number]:
    numbers = {}
    for name, data in group.items():
        error, unit = data.attrs.get("error"), str(data.attrs["units"])
        numbers[name] = Number(
            float(data[()]), None if error is None else float(error), "" if unit == "1" else unit
        )
    return numbers


def _read_solved(group: "h5py.Group") -> SolvedRecord:
    if "mass_defect" in group:
        return _read(group, AgeingRecord)
    return _read(group, SoftRecord) if "position" in group else _read(group, SolvedRecord)


def _write_histograms(group: "h5py.Group", histograms: Sequence["Histogram"], unit: str) -> None:
    """One group each, so that each can be read by itself."""
    for index, histogram in enumerate(histograms):
        one = group.create_group(f"{_HISTOGRAMS}/{index}")
        for field in fields(histogram):
            value = getattr(histogram, field.name)
            if isinstance(value, np.ndarray):
                one.create_dataset(field.name, data=value, compression="gzip", shuffle=True)
                one[field.name].attrs["units"] = unit if field.name in _LENGTHS else f"1 / {unit}"
            else:
                one.attrs[field.name] = value


def _read_simulated(group: "h5py.Group", file: Path) -> SimulatedRecord:
    from eq_model.histogram import Histogram, Made

    size = len(group[_HISTOGRAMS]) if _HISTOGRAMS in group else 0
    seen = _seen(file)

    def read(index: int) -> Histogram:
        if not file.is_file() or _seen(file) != seen:
            refuse(
                "folder",
                str(file.parent),
                f"its {RESULT} is another one since it was loaded; load it again",
            )
        with opened(file, checked=True) as store:
            return _read(store[f"{group_name}/{_HISTOGRAMS}/{index}"], Histogram)

    group_name = group.name
    record = CoupledRecord if "positions" in group else SimulatedRecord
    return _read(group, record, {_HISTOGRAMS: Made(size, read)})


def _seen(file: Path) -> tuple[int, int, int]:
    """What tells a file from one in its place."""
    status = file.stat()
    return status.st_ino, status.st_mtime_ns, status.st_size


def _read(
    group: "h5py.Group", record: type[Any], given: Mapping[str, Any] = MappingProxyType({})
) -> Any:
    """The fields of `record`, but for those `given`."""
    values: dict[str, Any] = {name: data[()] for name, data in group.items() if name not in given}
    for name, value in group.attrs.items():
        plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
        values[name] = tuple(plain) if isinstance(plain, list) else plain
    if _PER_RANK in values:
        values[_PER_RANK] = tuple(
            values[_PER_RANK].tolist()
        )  # of thousands of ranks: too many for an attribute
    values |= given
    optional = {
        field.name: field.default for field in fields(record) if field.default is not MISSING
    }
    values = optional | values
    return record(**{field.name: values[field.name] for field in fields(record)})
