"""Scenes side by side: propensity to stick-slip by the master equation, with evidence from the ensemble."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.judge.describe import PROPENSITY, RESAMPLES, Description, conditions, describe
from toolkit.judge.rigid import RIGID, on_rigid_slider
from toolkit.processes.ranks import on_root
from toolkit.results.beside import NOT_COMPARED, deviation
from toolkit.results.records import Result
from toolkit.running.runner import solve
from toolkit.running.solvers import within
from toolkit.scene.drive import has_path
from toolkit.scene.interfaces import Number, with_error
from toolkit.scene.laws import inside
from toolkit.scene.scale import SHARED, Scale
from toolkit.scene.scene import Scene, load_scene, read_scene
from toolkit.scene.tables import read_table

_SHOWN = ("onset_power", *PROPENSITY, "kinetic_force", "friction_coefficient")
_HEADS = "onset m,K*/(N<k>),F_s/F_k,X*/<x_s>,F_k/<x_s>,F_k/load,time,EQ at the peak,ME there,max |z|,EQ time"


@dataclass(frozen=True)
class Verdict:
    """One scene's line of the comparison.

    `numbers` are onset_power, critical_spring and more by name, friction_coefficient (F_k/load) for a surface only,
    lengths in mean thresholds; `conditions` the speed, temperature and more on which they depend; `cautions` say why
    K* is infinite, and what is at the limits of the law; `found` describes the law. `evidence` is the ensemble's: its
    force over the exact F_k, with one standard error, where the master equation's force is largest (its own, without
    [master]), the master's there, and the largest difference of both over the path in standard errors, or why there is
    none; None without [eq]. `scale` are the units of the scene's forces and springs, `per_area` N_c<k> of a surface per
    nominal area in N/m³, None of other thresholds.
    """

    name: str
    numbers: dict[str, Number]
    conditions: list[str]
    cautions: list[str]
    evidence: dict[str, Any] | None
    found: Description
    result: Result
    scale: Scale = field(default_factory=Scale)
    per_area: float | None = None

    def value(self, name: str) -> float:
        return self.numbers[name].value

    def spring(self, unit: str) -> Number:
        """K* in "N/m" of the area, in "N/m³", per area, or in "N_c<k>"."""
        own, factor = self.numbers["critical_spring"], self.spring_unit(unit)
        return Number(own.value * factor, (own.error or 0.0) * factor, unit)

    def spring_unit(self, unit: str) -> float:
        """N_c<k> in "N/m" of the area, or in "N/m³", per area; 1 where it is the unit."""
        return {"N/m": self.scale.spring, "N/m³": self.per_area or 1.0, SHARED: 1.0}[unit]

    def plain(self) -> dict[str, Any]:
        """The content of a file; times in s."""
        result = self.result
        kept: dict[str, Any] = {"name": self.name, "title": result.title or self.name}
        kept |= {"mean_threshold": result.mean_threshold, "unit": result.thresholds.unit}
        kept |= {name: getattr(self, name) for name in ("conditions", "cautions", "evidence")}
        kept |= {"sampled": self.found.sampled, "run_time": self.found.run_time}
        for name in _SHOWN:
            number = self.numbers.get(name, Number(np.nan, None, ""))
            kept |= {name: number.value, f"{name}_error": number.error}
        there = {"newtons": self.scale.spring_unit == "N/m", "per_area": self.per_area is not None}
        for name, unit in (("newtons", "N/m"), ("per_area", "N/m³")):
            if there[name]:
                spring = self.spring(unit)
                kept |= {f"critical_spring_{name}": spring.value}
                kept |= {f"critical_spring_{name}_error": spring.error}
        return kept


def common_unit(verdicts: Sequence[Verdict]) -> str:
    """The unit in which K* is ranked: "N/m" where each scene is of a surface with drive.area, "N/m³", per nominal area,
    where each is of a surface, else "N_c<k>". N_c<k> differs between surfaces, so that springs in its units may be in
    another order."""
    units = {verdict.scale.spring_unit for verdict in verdicts}
    if SHARED in units or not verdicts:
        return SHARED
    return "N/m" if units == {"N/m"} else "N/m³"


def compare(scenes: Sequence[Scene], comm: Any = None, progress: bool = False) -> list[Verdict]:
    """A verdict per scene, the one most prone to stick-slip (largest K*, in the `common_unit`) first.

    The scenes' own [master] and [eq] are run too, for the picture and the evidence. Where a spring pulls, the slider
    turns or there is no path, the force is that of a rigid slider from X = 0 on instead, and a caution says so. `comm`
    is as for toolkit.run;
    `progress` shows progress on stderr. Raises InputError, with the name of the scene, for thresholds of infinite
    <x_s^2>: there is no kinetic force to compare with.
    """
    verdicts = []
    for scene in scenes:
        with inside(scene.name, {}):
            verdicts.append(_judge(scene, comm, progress))
    unit, ratio = common_unit(verdicts), PROPENSITY[1]
    return sorted(verdicts, key=lambda one: [-one.spring(unit).value, -one.value(ratio)])


def read(scene: str, comm: Any, changes: Mapping[str, Any]) -> Scene:
    """The scene to be compared, by file or name; one that names a machine, without a path for its drive, needs no
    solver. Raises InputError as load_scene does."""
    table = read_table(read_scene(scene, comm, changes).tables)
    machine = table.drive is not None and not has_path(table.drive) and table.sweep is None
    return load_scene(scene, not machine, comm, changes)


def _judge(scene: Scene, comm: Any, progress: bool) -> Verdict:
    """F_k, K* and what the run of one scene showed."""
    contacts, speed, unit = scene.contacts, scene.sliding, scene.contacts.mean_threshold

    def measure() -> Description:
        with within(scene.deadline(), scene, "K*"):
            return describe(contacts, speed)

    found = on_root(comm, measure)
    if "critical_spring" not in found.numbers:
        raise InputError("; ".join(found.notes))
    numbers = {}
    for name in _SHOWN:
        if (own := found.numbers.get(name)) is not None:
            scale = unit if own.unit in ("m", "length") else 1.0
            numbers[name] = Number(own.value / scale, (own.error or 0.0) / scale, "")
    held = conditions(contacts, speed)
    cautions = [note for note in found.notes if note not in held]
    try:
        if scene.given_drive is not None:
            scene.only_forward("the picture of forces")
        elif scene.drive_table is not None:
            raise InputError("drive: names no path")
    except InputError as error:
        scene = on_rigid_slider(scene)
        cautions = [f"F(X) is that of a rigid slider from X = 0 on: {error}", *cautions]
    try:
        result = solve(scene, comm, show_progress=progress)[0]
    except InputError as error:
        if scene.master is not RIGID:
            raise
        cautions = [f"F(X) is left out: {error}", *cautions]
        result = solve(replace(scene, master=None), comm)[0]
    evidence = _evidence(result, numbers["kinetic_force"].value * unit)
    surface = contacts.interface
    return Verdict(
        *(scene.name, numbers, held, cautions, evidence, found, result),
        scale=scene.scale,
        per_area=None
        if surface is None or surface.contact_density is None
        else float(surface.per_area(1.0)),
    )


def _evidence(result: Result, kinetic: float) -> dict[str, Any] | None:
    solved, eq = result.master, result.eq
    if eq is None:
        return None
    at = int(np.argmax((eq if solved is None else solved).force))
    return {
        "static_to_kinetic": float(eq.force[at] / kinetic),
        "static_to_kinetic_error": float(eq.force_standard_error[at] / kinetic),
        "expected": None if solved is None else float(solved.force[at] / kinetic),
        "worst_deviation": deviation(result).worst,
        "not_compared": NOT_COMPARED if solved and deviation(result).worst is None else None,
        "run_time": eq.run_time,
        "contacts": eq.contacts,
    }


def table(verdicts: Sequence[Verdict]) -> list[str]:
    """The comparison as lines of text, every number with its error, and run times; then the notes of each scene."""
    heads, unit = _HEADS.split(","), common_unit(verdicts)
    if unit != SHARED:
        heads.insert(heads.index("time"), f"K* ({unit})")
    rows, notes = [["", "scene", *heads]], list[str]()
    for rank, verdict in enumerate(verdicts, start=1):
        cells, own = [str(rank), verdict.name], [*verdict.conditions, *verdict.cautions]
        for name in _SHOWN:
            number = verdict.numbers.get(name, Number(np.nan, 0.0, ""))
            text = with_error(number.value, number.error or 0.0, 4 if name == "onset_power" else 6)
            cells.append({"inf": "infinite", "nan": ""}.get(text, text))
        if unit != SHARED:
            spring = verdict.spring(unit)
            cells.append(
                with_error(spring.value, spring.error or 0.0, 6).replace("inf", "infinite")
            )
        cells.append(f"{verdict.found.run_time:.2g} s")
        if (seen := verdict.evidence) is not None:
            worst, expected = seen["worst_deviation"], seen["expected"]
            cells.append(with_error(seen["static_to_kinetic"], seen["static_to_kinetic_error"], 6))
            cells.append("" if expected is None else f"{expected:.5f}")
            cells += ["" if worst is None else f"{worst:.1f}", f"{seen['run_time']:.2g} s"]
            if seen["not_compared"] is not None:
                own.append(f"EQ and ME not compared: {seen['not_compared']}")
        if verdict.found.sampled:
            own.append(f"errors are those of the samples, by {RESAMPLES} resampled laws")
        rows.append(cells)
        notes += [f"{verdict.name}: {note}" for note in own]
    started = {one.name: one.result.asked.contacts.start for one in verdicts}
    if any(start != started[verdicts[0].name] for start in started.values()):
        names = ", ".join(name for name, start in started.items() if start is not None)
        hint = "K* and F_s/F_k depend on it; compare scenes of one start"
        notes.append(f"starts differ, and contacts of {names} do not start relaxed: {hint}")
    if unit == "N/m³":
        notes.append(
            "ranked by K* per nominal area (N/m³); give each drive.area, and K* is ranked in N/m of these areas"
        )
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    padded = ([f"{cell:>{n}}" for cell, n in zip(row, widths, strict=False)] for row in rows)
    head, *lines = ("  ".join(row).rstrip() for row in padded)
    return [head, "-" * len(head), *lines, *notes]
