"""Scenes side by side: how prone to stick-slip each is, by the master equation, with the ensemble's evidence beside."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.judge.describe import PROPENSITY, Description, conditions, describe
from toolkit.judge.deviation import why_not_compared, worst_deviation
from toolkit.results.records import Result, Simulated
from toolkit.running.ranks import on_root
from toolkit.running.runner import solve, until
from toolkit.scene.interfaces import with_error
from toolkit.scene.sampling import RESAMPLES
from toolkit.scene.scene import Scene


@dataclass(frozen=True)
class Evidence:
    """What the ensemble measured of the same scene.

    static_to_kinetic, static_to_kinetic_error : its force over the exact F_k, and one standard error, at the point of
        the path where the master equation's force is largest (its own, where the scene has no [master]).
    expected : that ratio from the master equation, at that point.
    worst_deviation : largest |z| between the two over the path, where enough contacts have broken to tell. Both are
        None where the scene has no [master], and worst_deviation where no point tells.
    not_compared : why no point tells, in words; None where one does, or the scene has no [master].
    run_time : s; contacts : number of contacts.
    """

    static_to_kinetic: float
    static_to_kinetic_error: float
    expected: float | None
    worst_deviation: float | None
    not_compared: str | None
    run_time: float
    contacts: int


@dataclass(frozen=True)
class Verdict:
    """One scene's line of the comparison; lengths in units of the mean threshold <x_s>, times in s.

    sampled says whether the thresholds come from samples; cautions are why K* is infinite, where samples, surface or
    load strain the law, and of errors that are not shown; velocity is the scene's, of its first sliding leg; conditions
    say at which speed, temperature and more K*, F_s, X* and F_k hold, where laws of contacts make that tell;
    friction_coefficient is F_k/load where the thresholds come from a surface, else None.
    """

    name: str
    title: str
    onset_power: float
    onset_power_error: float
    critical_spring: float
    critical_spring_error: float
    static_to_kinetic: float
    static_to_kinetic_error: float
    decoherence_length: float
    decoherence_length_error: float
    kinetic_force: float
    kinetic_force_error: float
    friction_coefficient: float | None
    friction_coefficient_error: float | None
    mean_threshold: float
    unit: str
    sampled: bool
    cautions: tuple[str, ...]
    velocity: float
    conditions: tuple[str, ...]
    run_time: float
    evidence: Evidence | None
    result: Result


def compare(scenes: Sequence[Scene], comm: Any = None, told: bool = False) -> list[Verdict]:
    """A verdict per scene, the one most prone to stick-slip (largest K*) first.

    Parameters
    ----------
    scenes : checked scenes; their own [master] and [eq] are run too, for the picture and the evidence, but where a
        spring pulls or the slider turns: forces along such paths are not compared, and a caution says so.
    comm : as for toolkit.run.
    told : whether progress is told on stderr.

    Raises InputError, with the name of the scene, for thresholds of infinite <x_s^2>: there is no kinetic force to
    compare with.
    """
    verdicts = []
    for scene in scenes:
        with naming(scene.name):
            verdicts.append(_judge(scene, comm, told))
    return sorted(verdicts, key=lambda one: (-one.critical_spring, -one.static_to_kinetic))


@contextmanager
def naming(scene: str) -> Iterator[None]:
    """Put the name of one scene of many before any InputError raised within, unless it says it already."""
    try:
        yield
    except InputError as error:
        if str(error).startswith("scene = "):
            raise
        raise InputError(f"{scene}: {error}") from error


def _judge(scene: Scene, comm: Any, told: bool) -> Verdict:
    contacts, speed, unit = scene.contacts, scene.sliding, scene.contacts.mean_threshold

    def measure() -> Description:
        with until(scene.deadline(), scene, "K*"):
            return describe(contacts, speed.value, speed.chosen)

    found = on_root(comm, measure)
    if "critical_spring" not in found.numbers:
        raise InputError("; ".join(found.notes))
    numbers: dict[str, Any] = {"friction_coefficient": None, "friction_coefficient_error": None}
    for name in ("onset_power", "kinetic_force", *PROPENSITY, "friction_coefficient"):
        if (number := found.numbers.get(name)) is not None:
            scale = unit if number.unit else 1.0
            numbers[name] = number.value / scale
            numbers[f"{name}_error"] = (number.error or 0.0) / scale
    held = tuple(conditions(contacts, speed.value, speed.chosen))
    apart = _not_drawn(scene)
    result = solve(replace(scene, master=None, eq=None) if apart else scene, comm, told=told)[0]
    kinetic = numbers["kinetic_force"] * unit
    return Verdict(
        name=scene.name,
        title=scene.title or scene.name,
        **numbers,
        mean_threshold=unit,
        unit=result.thresholds.unit,
        sampled=found.sampled,
        cautions=(*apart, *(note for note in found.notes if note not in held)),
        velocity=speed.value,
        conditions=held,
        run_time=found.run_time,
        evidence=None if result.eq is None else _evidence(result, result.eq, kinetic),
        result=result,
    )


def _not_drawn(scene: Scene) -> list[str]:
    """Why this scene's force is not drawn among the others' in words; nothing where it is."""
    try:
        if scene.given_drive is not None:
            scene.only_forward("the picture of forces")
    except InputError as error:
        return [f"F(X) is left out: {error}"]
    return []


def _evidence(result: Result, eq: "Simulated", kinetic: float) -> Evidence:
    solved = result.master
    at = int(np.argmax((eq if solved is None else solved).force))
    return Evidence(
        static_to_kinetic=float(eq.force[at] / kinetic),
        static_to_kinetic_error=float(eq.force_standard_error[at] / kinetic),
        expected=None if solved is None else float(solved.force[at] / kinetic),
        worst_deviation=None if solved is None else worst_deviation(result),
        not_compared=None if solved is None else why_not_compared(result),
        run_time=eq.run_time,
        contacts=eq.contacts,
    )


def plain_numbers(verdicts: Sequence[Verdict]) -> list[dict[str, Any]]:
    """What a file keeps of the verdicts: all but the results."""
    names = [field.name for field in fields(Verdict) if field.name not in ("result", "evidence")]
    return [
        {name: getattr(verdict, name) for name in names}
        | {"evidence": None if verdict.evidence is None else asdict(verdict.evidence)}
        for verdict in verdicts
    ]


_HEADS = "onset m,K*/(N<k>),F_s/F_k,X*/<x_s>,F_k/<x_s>,F_k/load,time,EQ at the peak,ME there,max |z|,EQ time"
_WIDTHS = (15, 17, 17, 17, 17, 17, 7, 16, 8, 7, 7)
_SHOWN = "critical_spring static_to_kinetic decoherence_length kinetic_force friction_coefficient"


def table(verdicts: Sequence[Verdict]) -> list[str]:
    """The comparison as lines of text, every number with its error and what it took to compute."""
    names = max([len("scene"), *(len(verdict.name) for verdict in verdicts)])

    def line(begin: str, cells: Sequence[str]) -> str:
        shown = (f"{cell:>{width}}" for cell, width in zip(cells, _WIDTHS, strict=False))
        return "  ".join([begin, *shown]).rstrip()

    head = line(f"   {'scene':{names}}", _HEADS.split(","))
    lines = [head, "-" * len(head)]
    for rank, verdict in enumerate(verdicts, start=1):
        cells = [_with_error(verdict.onset_power, verdict.onset_power_error, 4)]
        for name in _SHOWN.split():
            cells.append(_with_error(getattr(verdict, name), getattr(verdict, f"{name}_error")))
        cells.append(_seconds(verdict.run_time))
        if (seen := verdict.evidence) is not None:
            apart = "none" if seen.not_compared is not None else ""
            cells += [
                with_error(seen.static_to_kinetic, seen.static_to_kinetic_error, 6),
                "" if seen.expected is None else f"{seen.expected:.5f}",
                apart if seen.worst_deviation is None else f"{seen.worst_deviation:.1f}",
                _seconds(seen.run_time),
            ]
        lines.append(line(f"{rank:2d} {verdict.name:{names}}", cells))
    return lines + _notes(verdicts)


def _notes(verdicts: Sequence[Verdict]) -> list[str]:
    notes = []
    if any(verdict.evidence is not None for verdict in verdicts):
        notes += [
            "EQ at the peak, ME there: both solvers' F/F_k where the master's is largest on the path;",
            "max |z|: their largest difference over the path in standard errors, about 3 by chance",
        ]
    if any(verdict.friction_coefficient is not None for verdict in verdicts):
        notes.append(
            "F_k/load: k and x taken as uncorrelated (paper, Eq. Q6), load and <k> as at rest"
        )
    named: dict[str, list[str]] = {}
    for verdict in verdicts:
        reason = None if verdict.evidence is None else verdict.evidence.not_compared
        apart = [] if reason is None else [f"EQ and ME not compared: {reason}"]
        for note in (*verdict.conditions, *apart, *verdict.cautions):
            named.setdefault(note, []).append(verdict.name)
    for note, names in named.items():
        everyone = len(names) == len(verdicts) > 1
        notes.append(f"{'all' if everyone else ', '.join(names)}: {note}")
    if sampled := ", ".join(verdict.name for verdict in verdicts if verdict.sampled):
        from_samples = "thresholds from samples; errors are sampling errors"
        notes.append(f"{sampled}: {from_samples}, by {RESAMPLES} resampled laws")
    return notes


def _with_error(value: float | None, error: float | None, digits: int = 6) -> str:
    if value is None or error is None:
        return ""
    return with_error(value, error, digits) if np.isfinite(value) else "infinite"


def _seconds(time: float) -> str:
    return f"{1e3 * time:.0f} ms" if time < 1.0 else f"{time:.1f} s"
