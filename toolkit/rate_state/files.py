"""The numbers of rate and state as they are written: rate-state.json, and the columns of rate-state.csv."""

from dataclasses import asdict
from typing import Any

import numpy as np

from master.rate_state.result import Parameter
from toolkit.rate_state.judge import Judged

# numbers without readings of their own, by the factor of the scale that gives them their unit
_PLAIN = {
    "kinetic_force": "force",
    "kinetic_force_error": "force",
    "critical_spring": "spring",
    "critical_spring_error": "spring",
    "critical_spring_solved": "spring",
    "critical_spring_solved_error": "spring",
}


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


def answers(judged: Judged) -> dict[str, Any]:
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
    return columns
