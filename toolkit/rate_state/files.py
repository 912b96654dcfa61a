"""The files of rate and state: rate-state.txt, .json, .csv and .png, all or none."""

import os
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from master.rate_state.result import Parameter
from toolkit.rate_state.judge import Judged
from toolkit.rate_state.picture import save_rate_state_picture
from toolkit.rate_state.words import page
from toolkit.results.files import write_json
from toolkit.results.folders import write_folder
from toolkit.results.spreadsheets import write_rows
from toolkit.saving import pictures, stale

# numbers without readings of their own, by the factor of the scale that gives them their unit
_PLAIN = {
    "kinetic_force": "force",
    "kinetic_force_error": "force",
    "critical_spring": "spring",
    "critical_spring_error": "spring",
    "critical_spring_solved": "spring",
    "critical_spring_solved_error": "spring",
}


def save_rate_state(
    judged: Judged, folder: str | os.PathLike[str], formats: Sequence[str] = ()
) -> None:
    """Write the four files into `folder`, the picture in `formats`, too. Raises InputError where that fails."""
    text = "\n".join([*page(judged), ""])
    writers: dict[str, Any] = {
        "rate-state.txt": lambda path: path.write_text(text, encoding="utf-8"),
        "rate-state.json": lambda path: write_json(plain(judged), path),
        "rate-state.csv": partial(write_answers, judged),
        **pictures("rate-state", partial(save_rate_state_picture, judged), formats),
    }
    write_folder(folder, writers, stale(["rate-state"], writers))


def plain(judged: Judged) -> dict[str, Any]:
    """All numbers as plain values in the units of the scale, with their errors in full."""
    found, scale = judged.found, judged.scale
    forces, scan = ("a", "b", "a_minus_b"), found.scan
    units = {name: getattr(scale, f"{name}_unit") for name in ("force", "spring", "length", "time")}
    numbers = {name: _of_parameter(getattr(found, name), scale.force) for name in forces}
    numbers["slip_distance"] = _of_parameter(found.slip_distance, 1.0)
    if found.healing is not None:
        numbers["healing_per_decade"] = _of_parameter(found.healing, scale.force)
    speeds = {"velocity": scan.velocity, "slip_distance": scan.slip_distance}
    speeds |= {name: getattr(scan, name) * scale.force for name in forces}
    return {
        "name": judged.name,
        "title": judged.title,
        "units": units,
        "load": scale.load,
        "velocity": found.velocity,
        **numbers,
        **{name: getattr(found, name) * getattr(scale, unit) for name, unit in _PLAIN.items()},
        "critical_spring_from_start": judged.critical_spring * scale.spring,
        "critical_spring_from_start_error": judged.critical_spring_error * scale.spring,
        "direct_slip": found.direct_slip,
        "law": found.law.evolution,
        "misfit": asdict(found.misfit),
        "misfit_later": asdict(found.misfit_later),
        "rests": [_of_rest(judged, number) for number in range(len(found.rests))],
        "speeds": {name: each.tolist() for name, each in speeds.items()},
        "success": found.success,
        "message": found.message,
        "run_time": found.run_time,
    }


def _of_parameter(number: Parameter, factor: float) -> dict[str, Any]:
    """A number with its errors by a factor, and the speeds or rests between which it is constant."""
    out = {name: getattr(number, name) * factor for name in ("value", "error", "definition")}
    return out | {"constant_from": number.low, "constant_to": number.high}


def _of_rest(judged: Judged, number: int) -> dict[str, Any]:
    """One rest, and the force by the ageing law."""
    rest, force = judged.found.rests[number], judged.scale.force
    scaled = {name: getattr(rest, name) * force for name in ("relaxed", "peak", "error")}
    by_law = float(judged.found.law_rests[number]) * force
    return {"time": rest.time, "peak_slip": rest.peak_slip, **scaled, "law_peak": by_law}


def write_answers(judged: Judged, path: Path) -> None:
    """The solved answers and the law's: a row for each slip after the two steps, beside them a row for each rest."""
    found, scale = judged.found, judged.scale
    force, unit = scale.force, scale.force_unit
    columns: dict[str, Any] = {f"slip [{scale.length_unit}]": found.steps[0].slip}
    for name, step, law in zip(("up", "down"), found.steps, found.law_steps, strict=True):
        columns[f"force after the step {name} [{unit}]"] = step.force * force
        columns[f"law after the step {name} [{unit}]"] = law * force
    columns[f"rest [{scale.time_unit}]"] = [one.time for one in found.rests]
    columns[f"relaxed force [{unit}]"] = [one.relaxed * force for one in found.rests]
    columns[f"peak force [{unit}]"] = [one.peak * force for one in found.rests]
    columns[f"peak by the ageing law [{unit}]"] = np.asarray(found.law_rests) * force
    write_rows(columns, path)
