"""The files of a verdict: verdict.txt, verdict.json, friction.csv and verdict.png, all or none."""

import csv
import os
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from toolkit.results.files import write_json
from toolkit.results.folders import write_folder
from toolkit.saving import pictures, stale
from toolkit.verdict.finite import Finite
from toolkit.verdict.hangs_on import dependence
from toolkit.verdict.judge import Answer, Verdict
from toolkit.verdict.picture import save_verdict_picture
from toolkit.verdict.words import details, page, sentence, warnings


def save_verdict(
    verdict: Verdict, folder: str | os.PathLike[str], formats: Sequence[str] = ()
) -> None:
    """Write the four files into `folder`, the picture in `formats`, too. Raises InputError where that fails."""
    text = "\n".join([*page(verdict), ""])
    writers: dict[str, Any] = {
        "verdict.txt": lambda path: path.write_text(text, encoding="utf-8"),
        "verdict.json": lambda path: write_json(plain(verdict), path),
        **pictures("verdict", partial(save_verdict_picture, verdict), formats),
    }
    if verdict.own.behaviours:
        writers["friction.csv"] = partial(write_friction, verdict)
    write_folder(folder, writers, stale(["verdict"], writers))


def plain(verdict: Verdict) -> dict[str, Any]:
    """The verdict as plain values, in the units that each answer's `scale` names; numerical errors in full."""
    return {
        "name": verdict.name,
        "title": verdict.title,
        "do_not_trust": warnings(verdict),
        "verdict": sentence(verdict),
        "numbers": details(verdict),
        "hangs_on": dependence(verdict),
        "velocity": verdict.velocity,
        "success": verdict.success,
        "run_time": verdict.run_time,
        "finite": [_of_finite(one, verdict) for one in verdict.finite],
        "left_out": verdict.left_out,
        "readings": [_of_answer(answer) for answer in verdict.answers],
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
            "error": "mean thresholds <x_s>",
        }
    }
    out |= {"load": scale.load, "contacts": scale.contacts}
    factors = {"kinetic": scale.force, "static": scale.force, "critical_spring": scale.spring}
    for name, factor in factors.items():
        quantity = getattr(answer, name)
        out[name] = {key: value and value * factor for key, value in asdict(quantity).items()}
    if answer.smoothed:
        out["critical_spring"]["hangs_on"] = "the smoothing of P_c: no number of the islands"
    out["spring"] = answer.machine and answer.machine.spring * scale.spring
    mean = answer.contacts.mean_threshold
    out["behaviours"] = [_of_behaviour(one, scale.force, mean) for one in answer.behaviours]
    return out


def _of_finite(finite: Finite, verdict: Verdict) -> dict[str, Any]:
    """What so many contacts do, forces in the unit of the own reading."""
    out = {name: one for name, one in asdict(finite).items() if name not in ("drive", "force")}
    force = verdict.own.scale.force
    forces = ("before", "before_error", "after", "after_error")
    return out | {name: out[name] * force for name in forces}


def _of_behaviour(behaviour: Any, force: float, mean: float) -> dict[str, Any]:
    """What the slider does under one rule, without its trace, which friction.csv has: forces with their error; `error`
    and `heat_left_out` stay in mean thresholds."""
    out = {
        name: value for name, value in asdict(behaviour).items() if name not in ("drive", "force")
    }
    out |= {name: out[name] * force for name in ("before", "after")}
    return out | {"force_error": behaviour.error * mean * force}


def write_friction(verdict: Verdict, path: Path) -> None:
    """The friction trace of the scene's own reading, a row a point; slips at their own places have two rows."""
    scale = verdict.own.scale
    with path.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream)
        rows.writerow(
            ["slip rule", f"drive ({scale.length_unit})", f"spring force ({scale.force_unit})"]
        )
        for behaviour in verdict.own.behaviours:
            for drive, force in zip(behaviour.drive, behaviour.force, strict=True):
                rows.writerow(
                    [behaviour.rule, repr(float(drive)), repr(float(force * scale.force))]
                )
