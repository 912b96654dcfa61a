"""The files of a result folder but for its pictures: result.h5, summary.json and a sweep's table."""

import json
import math
import os
import tomllib
from contextlib import suppress
from dataclasses import MISSING, asdict, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from origins.errors import InputError, refuse
from toolkit.results.beside import slips_beside
from toolkit.results.folders import opened, write_sealed
from toolkit.results.kinds import (
    OVER_STIFFNESS,
    QUANTITIES,
    is_coupled,
    is_heavy,
    is_precise,
    units_of,
)
from toolkit.results.legend import keys_of
from toolkit.results.numbers import numbers_of
from toolkit.results.points import fill_sweep, read_sweep
from toolkit.results.records import Result, SolvedRecord, ThresholdCurve, mean_energies
from toolkit.results.verdicts import contradiction
from toolkit.scene.interfaces import Number
from toolkit.scene.tables import read_table

RESULT = "result.h5"
# what begins the names of numbers of a record's parts
_PARTS = {"slips": "slip_", "regime": "", "energy": "energy_", "energy_error": "energy_error_"}
_HISTOGRAMS, _PER_RANK = "histograms", "breaks_per_rank"
# numbers of the master equation's answer that nobody knows where its force is not known
_OF_FORCE = {"last_force", "largest_force", "period", "slips", "trend"}


def load(folder: str | os.PathLike[str]) -> Result:
    """The Result that `save`, or the command `run`, wrote into `folder`: `.master.path`, `.force`, `.force_error`;
    `.eq.force_standard_error`, `.breaks`, `.histograms`; `.thresholds.x`, `.density`; `.interface`, `.notes`, `.text`,
    and more, see Result. Raises InputError where there is none."""
    file = Path(folder) / RESULT
    if Path(folder).is_file():
        refuse("folder", str(folder), f"is a file; give the folder, {str(Path(folder).parent)!r}")
    if not file.is_file():
        refuse("folder", str(folder), f"holds no {RESULT}; mesofriction run SCENE writes one")
    with opened(file) as store:
        return _read(
            store,
            Result,
            text=str(store.attrs["scene"]),
            thresholds=_read(store["thresholds"], ThresholdCurve),
            master=_read_master(store["master"]) if "master" in store else None,
            eq=_read_eq(store["eq"]) if "eq" in store else None,
            notes=tuple(note.decode() for note in store["notes"][()]) if "notes" in store else (),
            interface=_read_interface(store["interface"]) if "interface" in store else None,
            sweep=read_sweep(store["sweep"]) if "sweep" in store else None,
        )


def earlier(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Name and text of the scene whose result or thresholds `folder` holds, and the CSV files that it may have as
    `tables`; {} for none."""
    with suppress(InputError, OSError), opened(Path(folder) / RESULT) as store:
        scene = {name: str(store.attrs[name]) for name in ("name", "scene")}
        sliding = "slip_drive" in store.get("master", ()) or "positions" in store.get("eq", ())
        there = {"force.csv": "master" in store or "eq" in store, "slips.csv": sliding}
        there["sweep.csv"] = "sweep" in store
        return scene | {"tables": [name for name, has_table in there.items() if has_table]}
    with suppress(OSError, ValueError, KeyError, TypeError):
        before = json.loads((Path(folder) / "thresholds.json").read_text(encoding="utf-8"))
        return {name: str(before[name]) for name in ("name", "scene")}
    return {}


def another(folder: str | os.PathLike[str], name: str, text: str) -> str | None:
    """In words, whose result is in `folder`; None if it is this scene's, by name and contacts, or there is none."""
    before = earlier(folder)
    if before.get("name", name) != name:
        return f"another scene, {before['name']}"
    with suppress(ValueError):  # the scene of an older package
        texts = (before.get("scene", text), text)
        one, other = (read_table(tomllib.loads(own)).contacts for own in texts)
        if one == other:
            return None
    return "this scene with other contacts"


def summary(result: Result) -> dict[str, Any]:
    """The most important numbers of a run; lengths in the unit of the thresholds, run times in seconds; of a surface
    those that the report tells, too, each with its error and its unit. `keys` say what the names mean."""
    asked, sweep = result.asked, result.sweep
    solved, eq = result.master, result.eq
    content: dict[str, Any] = {"name": result.name, "title": result.title}
    content |= {"version": result.version, "mean_threshold": result.mean_threshold}
    content |= {"success": result.success, "unit": result.thresholds.unit}
    if solved is not None and solved.regime is not None:
        content["verdict"] = contradiction(result) or solved.regime.verdict
    if solved is not None and asked.master is not None:
        content["master"] = {"tolerance": asked.master.tolerance, **_numbers(solved)}
        if solved.slips is not None:
            content["master"]["period_error"] = float(solved.slips.period_error)
        if not is_precise(solved):
            content["master"] |= dict.fromkeys(_OF_FORCE & content["master"].keys())
    if eq is not None and asked.eq is not None:
        own = _numbers(eq) | {"followed": int(eq.contacts)}
        own |= {"largest_standard_error": own.pop("largest_force_standard_error")}
        for name in ("contacts", "replicas", "seed", "tolerance"):
            own[name] = getattr(asked.eq, name)
        if is_coupled(eq):
            own["slips"] = eq.slips.number.size
            own["slips_beside"] = slips_beside(result)
            if is_heavy(eq):
                own["energy"] = mean_energies(eq)
                own["energy_imbalance"] = float(np.abs(eq.energy.imbalance).max())
                if own["slips"]:
                    own["mean_slip_duration"] = float(eq.slips.duration.mean())
                    own["slip_top_speed"] = float(eq.slips.top_speed.max())
        content["eq"] = own
    if sweep is not None:
        own = {name: getattr(sweep, name) for name in ("run_time", "success", "message")}
        errors = [name for name in sweep.columns if sweep.smooth and name.endswith("error")]
        own |= {f"largest_{name}": float(np.abs(sweep[name]).max()) for name in errors}
        content["sweep"] = own | {"points": sweep.size, "along": list(sweep.along)}
    if result.interface is not None:
        content["interface"] = {name: asdict(number) for name, number in result.interface.items()}
        found = numbers_of(result).items()
        content["numbers"] = {name: asdict(number) for name, number in found}
    content["notes"] = list(result.notes)
    return {"keys": keys_of(content)} | content


def _flat(answer: Any) -> dict[str, Any]:
    """The fields of a record, those of slips, regimes and energies too."""
    values = {field.name: getattr(answer, field.name) for field in fields(answer)}
    for name, prefix in _PARTS.items():
        if is_dataclass(part := values.pop(name, None)):
            values |= {f"{prefix}{field.name}": getattr(part, field.name) for field in fields(part)}
    return {name: value for name, value in values.items() if value is not None}


def _numbers(answer: Any) -> dict[str, Any]:
    """The fields of a record that are not arrays, as JSON types; the largest of arrays of errors and defects, and the
    last and the largest of a path's force."""
    numbers: dict[str, Any] = {}
    for name, value in _flat(answer).items():
        if not isinstance(value, np.ndarray):
            value = list(value) if isinstance(value, tuple) else value
            numbers[name] = value.item() if isinstance(value, np.generic) else value
        elif name.endswith(("error", "defect")):
            numbers[f"largest_{name}"] = float(np.abs(value).max(initial=0.0))
        elif name == "force" and hasattr(answer, "path"):
            numbers |= {"last_force": float(value[-1]), "largest_force": float(value.max())}
    numbers.pop(_HISTOGRAMS, None)
    return numbers


def write_json(content: dict[str, Any], path: Path) -> None:
    """Write `content` as indented JSON; numbers that are not finite become null, since JSON has none."""

    def speakable(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: speakable(item) for key, item in value.items()}
        if isinstance(value, list):
            return [speakable(item) for item in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    text = json.dumps(speakable(content), indent=2, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def write_result(result: Result, path: Path) -> None:
    """Build the file in memory, then write it: a signal or a full disk while HDF5 writes would abort the process."""
    import h5py

    with h5py.File(path.name, "w", driver="core", backing_store=False) as store:
        _fill(result, store)
        store.flush()
        contents = store.id.get_file_image()
    write_sealed(path, contents)


def _fill(result: Result, store: Any) -> None:
    """Write all fields of a result into an open HDF5 file, with their units."""
    units = units_of(result) | {"notes": "text"}
    store.attrs["scene"] = result.text
    for name in ("name", "title", "version", "mean_threshold"):
        store.attrs[name] = getattr(result, name)
    for name, values in (("time", result.time), ("notes", list(result.notes))):
        if len(values):
            store[name] = values
            store[name].attrs["units"] = units[name]
    for name, number in (result.interface or {}).items():
        own = store.create_dataset(f"interface/{name}", data=number.value)
        own.attrs["units"] = number.unit or "1"
        if number.error is not None:
            own.attrs["error"] = number.error
    if (sweep := result.sweep) is not None:
        fill_sweep(store.create_group("sweep"), sweep, units if sweep.smooth else sweep.units)
    for name in ("thresholds", "master", "eq"):
        if (answer := getattr(result, name)) is not None:
            _write(store.create_group(name), answer, units)
    if result.eq is not None and result.asked.eq is not None:
        store.attrs["seed"] = result.asked.eq.seed
        for index, histogram in enumerate(result.eq.histograms):
            own = store.create_group(f"eq/{_HISTOGRAMS}/{index}")
            _write(own, histogram, units, compression="gzip", shuffle=True)


def _write(group: Any, answer: Any, units: dict[str, str], **how: Any) -> None:
    """A record: arrays as data sets, the rest as attributes."""
    for name, value in _flat(answer).items():
        if isinstance(value, np.ndarray) or name == _PER_RANK:
            group.create_dataset(name, data=value, **how)
            group[name].attrs["units"] = units.get(name.removeprefix("slip_"), "1")
            if QUANTITIES.get(name.removeprefix("slip_")) == "force":
                group[name].attrs["quantity"] = OVER_STIFFNESS
        elif name != _HISTOGRAMS:
            group.attrs[name] = value


def _read_interface(group: Any) -> dict[str, Number]:
    numbers = {}
    for name, data in group.items():
        error = float(data.attrs["error"]) if "error" in data.attrs else None
        unit = str(data.attrs["units"])
        numbers[name] = Number(float(data[()]), error, "" if unit == "1" else unit)
    return numbers


def _read_master(group: Any) -> SolvedRecord:
    """The record of the master equation in this group of a file: with slips and a regime where a spring pulls the
    slider, and with energies where it has a mass."""
    if "position" not in group:
        return _read(group, SolvedRecord)
    from master.soft.inertia.energy_errors import EnergyError
    from master.soft.inertia.run import SlipsInTime
    from master.soft.regime import Regime
    from master.soft.slips import Slips
    from origins.energy import Energy

    heavy = "energy_drive" in group
    slips = _read(group, SlipsInTime if heavy else Slips, "slip_")
    energies = {}
    if heavy:
        energies["energy"] = _read(group, Energy, "energy_")
        energies["energy_error"] = _read(group, EnergyError, "energy_error_")
    regime = _read(group, Regime, slips=int(slips.drive.size), trend=group.attrs.get("trend"))
    return _read(group, SolvedRecord, slips=slips, regime=regime, **energies)


def _read_eq(group: Any) -> Any:
    import eq_model
    from eq_model import CoupledResult, CoupledSlips, EnsembleResult
    from eq_model.result import Histogram

    if "energy_work" in group:
        raise InputError("folder: its energies are those of an older build; run the scene again")
    if "energy_drive" in group:  # a slider with mass
        slips = _read(group, eq_model.HeavySlips, "slip_")
        energy = _read(group, eq_model.Energy, "energy_")
        return _read(group, eq_model.HeavyResult, slips=slips, energy=energy)
    if "positions" in group:
        return _read(group, CoupledResult, slips=_read(group, CoupledSlips, "slip_"))
    size = len(group[_HISTOGRAMS]) if _HISTOGRAMS in group else 0
    found = [_read(group[f"{_HISTOGRAMS}/{index}"], Histogram) for index in range(size)]
    return _read(group, EnsembleResult, histograms=found)


def _read(group: Any, kind: type[Any], prefix: str = "", **given: Any) -> Any:
    """A record of this kind with the fields that the group holds under their names, and those `given`."""
    values = {field.name: field.default for field in fields(kind) if field.default is not MISSING}
    for name in (field.name for field in fields(kind)):
        if (stored := f"{prefix}{name}") in group.attrs:
            value = group.attrs[stored]
            plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
            values[name] = tuple(plain) if isinstance(plain, list) else plain
        elif stored in group and name not in given:
            values[name] = group[stored][()]
    if _PER_RANK in values:  # with thousands of ranks it is too long for an attribute
        values[_PER_RANK] = values[_PER_RANK].tolist()
    return kind(**values | given)
