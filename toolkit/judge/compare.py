"""Scenes side by side: propensity to stick-slip by the master equation, how far it hangs on what was assumed of a
surface, and evidence from the ensemble."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from toolkit.judge.describe import PROPENSITY, Description, conditions, describe
from toolkit.judge.rigid import RIGID, on_rigid_slider
from toolkit.processes.ranks import on_root
from toolkit.results.beside import NOT_COMPARED, deviation
from toolkit.results.records import Result
from toolkit.running.runner import solve
from toolkit.running.solvers import within
from toolkit.scene.drive import has_path, machine_number
from toolkit.scene.interfaces import Number, of_a_scan
from toolkit.scene.laws import inside
from toolkit.scene.of_samples import of_smoothing
from toolkit.scene.scale import SHARED, scale_of
from toolkit.scene.scene import Scene, load_scene, read_scene
from toolkit.scene.tables import DriveTable, read_table
from toolkit.verdict.readings import readings_of

SHOWN = ("onset_power", *PROPENSITY, "kinetic_force", "friction_coefficient")
# the names in a file of K* in each unit
SPRINGS = {"N/m": "critical_spring_newtons", "N/m³": "critical_spring_per_area"}
SPRINGS |= {SHARED: "critical_spring"}
# those of F_k, by the units of K* that go with them
FORCES = {"N/m": "kinetic_force_newtons", "N/m³": "kinetic_stress"}


@dataclass(frozen=True)
class Read:
    """What one reading says: numbers by the names that they have in a file, lengths in mean thresholds, K* in each unit
    that is known, nan for what other thresholds than a surface's do not have.

    springs : N_c<k> by unit: "N_c<k>", "N/m" of drive.area, "N/m³", per nominal area
    softer : whether the machine's spring is softer than K*; None without one, and where K* is not known
    unknown : whether the numerical error of K* is as large as itself, or `smoothed`
    smoothed : whether K*, nan then, hangs on how samples of islands are smoothed, and is no number of theirs
    machine : the machine's spring K/(N_c <k>); None without one
    """

    name: str
    numbers: dict[str, Number]
    springs: dict[str, float]
    softer: bool | None
    unknown: bool = False
    machine: float | None = None
    smoothed: bool = False

    def spring(self, unit: str) -> Number:
        """K* in this unit."""
        return self.numbers[SPRINGS[unit]]

    def plain(self) -> dict[str, Any]:
        """Each number and its error, as a file has them."""
        out = dict[str, Any]()
        for name, number in self.numbers.items():
            out |= {name: number.value, f"{name}_error": number.error}
        return out


@dataclass(frozen=True)
class ComparedScene:
    """One scene's line of the comparison.

    `readings` begin with the scene's own, to which `conditions`, `cautions` and `found` belong: the speed, temperature
    and more on which its numbers depend, why K* is infinite and what is at the limits of the law, and what describes
    it; those `left_out` have a reason. `evidence` is the ensemble's: its force over the exact F_k, with one standard
    error, where the master equation's force is largest (its own, without [master]), the master's there, and the
    largest difference of both over the path in standard errors, or why there is none; None without [eq]. `of_a_scan`
    tells whether its thresholds are those of one patch of a surface, which leave K* two digits; `mass`, whether its
    slider has one, of which K* promises no slip.
    """

    name: str
    readings: tuple[Read, ...]
    left_out: dict[str, str]
    conditions: list[str]
    cautions: list[str]
    evidence: dict[str, Any] | None
    found: Description
    result: Result
    of_a_scan: bool = False
    mass: bool = False

    @property
    def own(self) -> Read:
        """What the scene itself says."""
        return self.readings[0]

    def plain(self) -> dict[str, Any]:
        """The content of a file; times in s."""
        result = self.result
        kept: dict[str, Any] = {"name": self.name, "title": result.title or self.name}
        kept |= {"mean_threshold": result.mean_threshold, "unit": result.thresholds.unit}
        kept |= {name: getattr(self, name) for name in ("conditions", "cautions", "evidence")}
        kept |= {"sampled": self.found.sampled, "run_time": self.found.run_time}
        kept["readings"] = [{"reading": one.name, **one.plain()} for one in self.readings]
        return kept | self.own.plain() | {"left_out": self.left_out}


def common_unit(compared: Sequence[ComparedScene]) -> str:
    """The unit in which K* is ranked: "N/m" where each scene is of a surface with drive.area, "N/m³", per nominal area,
    where each is of a surface, else "N_c<k>". N_c<k> differs between surfaces, so that springs in its units may be in
    another order."""
    units = {one.result.scale.spring_unit for one in compared}
    if SHARED in units or not compared:
        return SHARED
    return "N/m" if units == {"N/m"} else "N/m³"


def compare(
    scenes: Sequence[Scene], comm: Any = None, progress: bool = False
) -> list[ComparedScene]:
    """What is compared of each scene, the one most prone to stick-slip (largest K*, in the `common_unit`) first; those
    whose K* is no number last, by F_s/F_k.

    The scenes' own [master] and [eq] are run too, for the picture and the evidence. Where a spring pulls, the slider
    turns or there is no path, the force is that of a rigid slider from X = 0 on instead, and a caution says so. `comm`
    is as for toolkit.run;
    `progress` shows progress on stderr. Raises InputError, with the name of the scene, for thresholds of infinite
    <x_s^2>: there is no kinetic force to compare with.
    """
    compared = []
    for scene in scenes:
        with inside(scene.name, {}):
            compared.append(_judge(scene, comm, progress))
    unit = common_unit(compared)

    def proneness(one: ComparedScene) -> list[float]:
        spring = -1.0 if one.own.smoothed else one.own.spring(unit).value
        return [spring, one.own.numbers["static_to_kinetic"].value]

    return sorted(compared, key=proneness, reverse=True)


def read(scene: str, comm: Any, changes: Mapping[str, Any]) -> Scene:
    """The scene to be compared, by file or name; one that names a machine, without a path for its drive, needs no
    solver. Raises InputError as load_scene does."""
    table = read_table(read_scene(scene, comm, changes).tables)
    machine = table.drive is not None and not has_path(table.drive) and table.sweep is None
    return load_scene(scene, not machine, comm, changes)


def _judge(scene: Scene, comm: Any, progress: bool) -> ComparedScene:
    """F_k, K*, what they hang on, and what the run of one scene showed."""
    found, readings, left_out = on_root(comm, partial(_measured, scene))
    conditions_met = conditions(scene.contacts, scene.sliding)
    cautions = [note for note in found.notes if note not in conditions_met]
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
    kinetic = readings[0].numbers["kinetic_force"].value * scene.contacts.mean_threshold
    return ComparedScene(
        scene.name,
        tuple(readings),
        left_out,
        conditions=conditions_met,
        cautions=cautions,
        evidence=_evidence(result, kinetic),
        found=found,
        result=result,
        of_a_scan=of_a_scan(scene.contacts.thresholds),
        mass=(scene.drive_table or DriveTable()).mass is not None,
    )


class _Measured(NamedTuple):
    """The description of the scene's own reading, what each reading says, and why others say nothing."""

    own: Description
    readings: list[Read]
    left_out: dict[str, str]


def _measured(scene: Scene) -> _Measured:
    """What the readings of a scene say."""
    deadline, each, left_out = scene.deadline(), list[Read](), dict[str, str]()
    own: Any = None
    for reading in readings_of(scene, quick=True):
        try:
            if reading.contacts is None:
                raise InputError(reading.refused)
            with within(deadline, scene, "K*"):
                found = describe(reading.contacts, scene.sliding)
            if "critical_spring" not in found.numbers:
                raise InputError("; ".join(found.notes))
        except InputError as error:
            if reading.own:
                raise
            left_out[reading.name] = str(error)
            continue
        own = own or found
        each.append(_read(scene, reading.name, reading.contacts, found))
    return _Measured(own, each, left_out)


def _read(scene: Scene, name: str, contacts: Contacts, found: Description) -> Read:
    """The numbers of a reading in mean thresholds, the units of its springs, and whether the machine's is softer."""
    unit, numbers, springs = contacts.mean_threshold, dict[str, Number](), {SHARED: 1.0}
    for key in SHOWN:
        own = found.numbers.get(key, Number(np.nan, None, ""))
        length = unit if own.unit.rpartition("·")[2] in ("m", "length") else 1.0
        error = None if own.error is None else own.error / length
        numbers[key] = Number(own.value / length, error, "")
    for area in (scene.area, None):
        scale = scale_of(contacts, area)
        springs[scale.spring_unit] = scale.spring
        if (kinetic := FORCES.get(scale.spring_unit)) is not None:
            factor, own = scale.force * unit, numbers["kinetic_force"]
            error = None if own.error is None else own.error * factor
            numbers[kinetic] = Number(own.value * factor, error, scale.force_unit)
    if smoothed := of_smoothing(contacts.thresholds):
        numbers["critical_spring"] = Number(np.nan, None, "")
    critical = numbers["critical_spring"]
    for its_unit, factor in springs.items():
        error = (critical.error or 0.0) * factor
        numbers[SPRINGS[its_unit]] = Number(critical.value * factor, error, its_unit)
    machine = machine_number("spring", scene.drive_table or DriveTable(), contacts)
    unknown = smoothed or (critical.lost and not found.sampled)
    softer = None if machine is None or smoothed else machine < critical.value
    if unknown and not smoothed and machine is not None:
        softer = None if machine < critical.value + (critical.error or 0.0) else False
    return Read(name, numbers, springs, softer, unknown, machine, smoothed)


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
