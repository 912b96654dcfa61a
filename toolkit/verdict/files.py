"""What the files of a verdict hold: verdict.json and friction.csv."""

from dataclasses import asdict
from typing import Any

import numpy as np

from toolkit.scene.scale import Scale, told_contacts
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.legend import KEYS
from toolkit.verdict.mean_force import mean_of_contacts, mean_over_slips
from toolkit.verdict.of_area import finite_told_apart
from toolkit.verdict.sliders.machine import Behaviour, Finite
from toolkit.verdict.text.doubts import warnings
from toolkit.verdict.text.hangs_on import dependence
from toolkit.verdict.text.of_delay import would_swing
from toolkit.verdict.text.words import details, sentence, turned


def plain(verdict: Verdict) -> dict[str, Any]:
    """The verdict as plain values, in the units that each answer's `scale` names; numerical errors in full."""
    return {
        "name": verdict.name,
        "title": verdict.title,
        "do_not_trust": warnings(verdict),
        "verdict": sentence(verdict),
        "would_turn": [*turned(verdict), *would_swing(verdict)],
        "numbers": details(verdict),
        "hangs_on": dependence(verdict),
        "velocity": verdict.velocity,
        "success": verdict.success,
        **({"interrupted": True} if verdict.stopped is not None else {}),
        "run_time": verdict.run_time,
        "finite": [_of_finite(one, verdict) for one in verdict.finite],
        "left_out": verdict.left_out,
        "readings": [_of_answer(answer) for answer in verdict.answers],
        "keys": KEYS,
    }


def _of_answer(answer: Answer) -> dict[str, Any]:
    """One reading: its numbers in the units of its scale."""
    scale = answer.scale
    out: dict[str, Any] = {"reading": answer.name}
    out |= {
        "units": {
            "force": scale.force_unit,
            "spring": scale.spring_unit,
            "length": scale.length_unit,
            "time": scale.time_unit,
            "damping": f"{scale.spring_unit} {scale.time_unit}",
            "error": "mean thresholds <x_s>",
        }
    }
    out |= {"load": scale.load, "contacts": scale.contacts}
    factors = {"kinetic": scale.force, "static": scale.force, "critical_spring": scale.spring}
    for name, factor in factors.items():
        quantity = getattr(answer, name)
        scaled = {key: value and value * factor for key, value in asdict(quantity).items()}
        out[name] = scaled | {"resampled": quantity.resampled}
    if answer.smoothed:
        out["critical_spring"]["hangs_on"] = "the smoothing of P_c: no number of the islands"
    out["spring"] = answer.machine and answer.machine.spring * scale.spring
    mean = answer.contacts.mean_threshold
    out["behaviours"] = [_of_behaviour(one, scale, mean) for one in answer.behaviours]
    out["extremes"] = [_of_behaviour(one, scale, mean) for one in answer.extremes]
    return out


def _of_finite(finite: Finite, verdict: Verdict) -> dict[str, Any]:
    """What so many contacts do, forces in the unit of the own reading."""
    not_written = ("drive", "force", "in_time")  # friction.csv and the behaviours have them
    out = {name: one for name, one in asdict(finite).items() if name not in not_written}
    force = verdict.own.scale.force
    forces = ("before", "before_error", "after", "after_error", "late", "late_error", "fluctuation")
    spreads = {name: getattr(finite, name) for name in ("befores", "drops")}
    out |= {name: one and asdict(one.times(force)) for name, one in spreads.items()}
    out |= {name: out[name] * force for name in forces}
    mean = mean_of_contacts(finite)
    out["mean_force"] = mean and {"value": mean.force * force, "error": mean.error * force}
    return out | {"still_changing": [one * force for one in finite.still_changing]}


def _of_behaviour(behaviour: Behaviour, scale: Scale, mean: float) -> dict[str, Any]:
    """What the slider does under one rule, in units of `scale`, without its trace, which friction.csv has: forces with
    their error; `error`, `heat_left_out` and `heat_on_the_way` stay in mean thresholds."""
    # traces are in friction.csv, and of the sliders "finite" tells
    not_written = ("drive", "force", "slip_drive", "slip_force", "first_slip", "sliders", "left")
    out = {name: value for name, value in asdict(behaviour).items() if name not in not_written}
    force = scale.force
    out |= {name: out[name] * force for name in ("before", "after", "first_error")}
    for name, factor in (("unstable_below", scale.spring), ("damping", scale.spring)):
        out[name] = None if out[name] is None else out[name] * factor
    for name in ("swings", "first_forces"):
        out[name] = [one * force for one in out[name] or ()] or None
    mean_force = mean_over_slips(behaviour)
    out["mean_force"] = mean_force and mean_force * force
    return out | {"force_error": behaviour.error * mean * force}


def friction(verdict: Verdict) -> dict[str, list[Any]]:
    """The columns of friction.csv: the trace of the scene's own reading under each rule, a row a point; slips at their
    own places have two rows, and below them the first slip of a mass has its own; then that of one slider of the area's
    contacts, where these do something else. The slider is where the spring's force says, F = K (X_T - X)."""
    scale, own, machine = verdict.own.scale, verdict.own.behaviours, verdict.own.machine
    if not own or machine is None:
        return {}
    parts = [(one.rule + ", without heat" * one.without_heat, one.drive, one.force) for one in own]
    parts += [(f"{one.rule}, its first slip", one.slip_drive, one.slip_force) for one in own]
    shown = [one.sliders for one in own]  # in place of infinitely many
    few = [
        one for one in finite_told_apart(verdict).values() if all(one is not each for each in shown)
    ]
    parts += [(f"{one.rule}, {told_contacts(one.contacts)}", one.drive, one.force) for one in few]
    drive, force = (np.concatenate([part[k] for part in parts]) for k in (1, 2))
    return {
        "slip rule": [part[0] for part in parts for _ in part[1]],
        f"drive [{scale.length_unit}]": drive.tolist(),
        f"spring force [{scale.force_unit}]": (force * scale.force).tolist(),
        f"slider [{scale.length_unit}]": (drive - force / machine.spring).tolist(),
        f"time [{scale.time_unit}]": (drive / verdict.velocity).tolist(),
    }
