"""What the files of a verdict hold: verdict.json and friction.csv."""

from dataclasses import asdict, fields
from typing import Any

import numpy as np

from toolkit.results.rarer import Rarer
from toolkit.results.slips import Spread
from toolkit.scene.scale import Scale, told_contacts
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.legend import KEYS, UNITS
from toolkit.verdict.mean_force import mean_of_contacts, mean_over_slips
from toolkit.verdict.of_area import finite_told_apart
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.sliders.slips_in_time import SlipsOfMass
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
            "damping": scale.damping_unit,
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
    """What so many contacts do, in the units of the own reading, without what the behaviours have of it."""
    scale, mean = verdict.own.scale, mean_of_contacts(finite)
    out = _in_units(finite, scale, {"in_time"})
    out["mean_force"] = mean and {
        "value": mean.force * scale.force,
        "error": mean.error * scale.force,
    }
    return out


def _of_behaviour(behaviour: Behaviour, scale: Scale, mean: float) -> dict[str, Any]:
    """What the slider does under one rule, in units of `scale`, forces with their error; `error`, `heat_left_out` and
    `heat_on_the_way` stay in mean thresholds, one of which is `mean`. Of the contacts of the area "finite" tells."""
    out, mean_force = _in_units(behaviour, scale, {"finite", "left"}), mean_over_slips(behaviour)
    out["mean_force"] = mean_force and mean_force * scale.force
    return out | {"force_error": behaviour.error * mean * scale.force}


def _in_units(record: Behaviour | Finite | SlipsOfMass, scale: Scale, left_out: set[str]) -> Any:
    """What a teller's record holds, each number in its unit, see UNITS; without traces, which friction.csv has."""
    factors, out = {"force": scale.force, "spring": scale.spring}, dict[str, Any]()
    for name in (one.name for one in fields(record)):
        value, factor = getattr(record, name), factors.get(UNITS.get(name, ""), 1.0)
        if isinstance(value, SlipsOfMass) and name not in left_out:
            out |= _in_units(value, scale, {"first_slip"})
        elif not (name in left_out or isinstance(value, np.ndarray)):
            out[name] = _times(value, factor)
    return out


def _times(value: Any, factor: float) -> Any:
    """A value of a record in another unit; numbers of a tuple, and of a spread, each."""
    if isinstance(value, Spread | Rarer):
        return asdict(value.times(factor) if isinstance(value, Spread) else value)
    if isinstance(value, tuple):
        return [one * factor for one in value]
    return value * factor if isinstance(value, float) else value


def friction(verdict: Verdict) -> dict[str, list[Any]]:
    """The columns of friction.csv: the trace of the scene's own reading under each rule, a row a point; slips at their
    own places have two rows, and below them the first slip of a mass has its own; then that of one slider of the area's
    contacts, where these do something else. The slider is where the spring's force says, F = K (X_T - X)."""
    scale, own, machine = verdict.own.scale, verdict.own.behaviours, verdict.own.machine
    if not own or machine is None:
        return {}
    parts = [(one.rule + ", without heat" * one.without_heat, one.drive, one.force) for one in own]
    parts += [(f"{one.rule}, its first slip", one.slip_drive, one.slip_force) for one in own]
    shown = [one.finite for one in own]  # in place of infinitely many
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
