"""Scenes side by side: how prone to stick-slip each is, by the master equation, with the ensemble's evidence beside."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.judge.deviation import why_not_compared, worst_deviation
from toolkit.results.describe import conditions
from toolkit.results.records import Result, SimulatedRecord
from toolkit.running.ranks import on_root
from toolkit.running.runner import run
from toolkit.scene.interfaces import HEIGHT_INTEGRALS, remarks, why_infinite, with_error
from toolkit.scene.sampling import RESAMPLES, sampling_errors, unseen
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


def compare(
    scenes: Sequence[Scene], comm: Any = None, progress: Callable[[int, int], None] | None = None
) -> list[Verdict]:
    """A verdict per scene, the one most prone to stick-slip (largest K*) first.

    Parameters
    ----------
    scenes : checked scenes; their own [master] and [eq] are run too, for the picture and the evidence, but where a
        spring pulls or the slider turns: forces along such paths are not compared, and a caution says so.
    comm, progress : as for toolkit.run.

    Raises InputError, with the name of the scene, for thresholds of infinite <x_s^2>: there is no kinetic force to
    compare with.
    """
    verdicts = []
    for scene in scenes:
        with naming(scene.name):
            verdicts.append(_judge(scene, comm, progress))
    return sorted(
        verdicts, key=lambda verdict: (-verdict.critical_spring, -verdict.static_to_kinetic)
    )


@contextmanager
def naming(scene: str) -> Iterator[None]:
    """Put the name of one scene of many before any InputError raised within, unless it says it already."""
    try:
        yield
    except InputError as error:
        if str(error).startswith("scene = "):
            raise
        raise InputError(f"{scene}: {error}") from error


def _judge(scene: Scene, comm: Any, progress: Callable[[int, int], None] | None) -> Verdict:
    import master

    speed = scene.sliding

    def measures() -> tuple[Any, Any, dict[str, float]]:
        found = master.propensity(scene.contacts, velocity=speed.value)
        return (
            found,
            master.steady_state(scene.contacts, velocity=speed.value),
            sampling_errors(scene.contacts),
        )

    found, steady, sampled = on_root(comm, measures)

    def with_sampling(name: str, error: float) -> float:
        return float(np.hypot(error, sampled.get(name, 0.0)))

    apart = _not_drawn(scene)
    result = run(
        replace(scene, master=None, eq=None) if apart else scene, comm=comm, progress=progress
    )
    unit = scene.contacts.mean_threshold
    interface = scene.contacts.interface
    friction = None if interface is None else interface.friction_coefficient
    relative = steady.force_error * unit / steady.force
    infinite = [why_infinite(scene.contacts)] if np.isinf(found.critical_spring) else []
    return Verdict(
        name=scene.name,
        title=scene.title or scene.name,
        onset_power=found.onset_power,
        onset_power_error=found.onset_power_error,
        critical_spring=found.critical_spring,
        critical_spring_error=with_sampling("critical_spring", found.critical_spring_error),
        static_to_kinetic=found.static_to_kinetic,
        static_to_kinetic_error=with_sampling("static_to_kinetic", found.static_to_kinetic_error),
        decoherence_length=found.decoherence_length / unit,
        decoherence_length_error=with_sampling("decoherence_length", found.decoherence_length_error)
        / unit,
        kinetic_force=steady.force / unit,
        kinetic_force_error=with_sampling("kinetic_force", steady.force_error * unit) / unit,
        friction_coefficient=friction,
        friction_coefficient_error=None
        if friction is None
        else friction * (relative + HEIGHT_INTEGRALS),
        mean_threshold=unit,
        unit=result.thresholds.unit,
        sampled=bool(sampled),
        cautions=(
            *apart,
            *infinite,
            *unseen(sampled, found.critical_spring),
            *remarks(scene.contacts.thresholds),
        ),
        velocity=speed.value,
        conditions=tuple(conditions(scene.contacts, speed.value, speed.chosen)),
        run_time=found.run_time,
        evidence=None if result.eq is None else _evidence(result, result.eq, steady.force),
        result=result,
    )


def _not_drawn(scene: Scene) -> list[str]:
    """Why this scene's force is not drawn among the others' in words; nothing where it is."""
    if scene.given_drive is None:
        return []
    try:
        scene.only_forward("the picture of forces")
    except InputError as error:
        return [f"F(X) is left out: {error}"]
    return []


def _evidence(result: Result, eq: SimulatedRecord, kinetic: float) -> Evidence:
    curve = eq if result.master is None else result.master
    at = int(np.argmax(curve.force))
    expected = deviation = reason = None
    if result.master is not None:
        expected = float(result.master.force[at] / kinetic)
        deviation, reason = worst_deviation(result), why_not_compared(result)
    return Evidence(
        static_to_kinetic=float(eq.force[at] / kinetic),
        static_to_kinetic_error=float(eq.force_standard_error[at] / kinetic),
        expected=expected,
        worst_deviation=deviation,
        not_compared=reason,
        run_time=eq.run_time,
        contacts=eq.contacts,
    )


def table(verdicts: Sequence[Verdict]) -> list[str]:
    """The comparison as lines of text, every number with its error and what it took to compute."""
    names = max([len("scene"), *(len(verdict.name) for verdict in verdicts)])
    head = (
        f"   {'scene':{names}}  {'onset m':>15}  {'K*/(N<k>)':>17}  {'F_s/F_k':>17}  {'X*/<x_s>':>17}  "
        f"{'F_k/<x_s>':>17}  {'F_k/load':>17}  {'time':>7}  "
        f"{'EQ at the peak':>16}  {'ME there':>8}  {'max |z|':>7}  {'EQ time':>7}"
    )
    lines = [head, "-" * len(head)]
    for rank, verdict in enumerate(verdicts, start=1):
        friction = ""
        if (
            verdict.friction_coefficient is not None
            and verdict.friction_coefficient_error is not None
        ):
            friction = _with_error(verdict.friction_coefficient, verdict.friction_coefficient_error)
        line = (
            f"{rank:2d} {verdict.name:{names}}  {_with_error(verdict.onset_power, verdict.onset_power_error, 4):>15}  "
            f"{_with_error(verdict.critical_spring, verdict.critical_spring_error):>17}  "
            f"{_with_error(verdict.static_to_kinetic, verdict.static_to_kinetic_error):>17}  "
            f"{_with_error(verdict.decoherence_length, verdict.decoherence_length_error):>17}  "
            f"{_with_error(verdict.kinetic_force, verdict.kinetic_force_error):>17}  {friction:>17}  "
            f"{_seconds(verdict.run_time):>7}"
        )
        if verdict.evidence is not None:
            evidence = verdict.evidence
            measured = with_error(evidence.static_to_kinetic, evidence.static_to_kinetic_error, 6)
            deviation = "none" if evidence.not_compared is not None else ""
            deviation = (
                deviation if evidence.worst_deviation is None else f"{evidence.worst_deviation:.1f}"
            )
            there = "" if evidence.expected is None else f"{evidence.expected:.5f}"
            line += (
                f"  {measured:>16}  {there:>8}  {deviation:>7}  {_seconds(evidence.run_time):>7}"
            )
        lines.append(line.rstrip())
    lines += _notes(verdicts)
    return lines


def _notes(verdicts: Sequence[Verdict]) -> list[str]:
    notes = []
    if any(verdict.evidence is not None for verdict in verdicts):
        notes.append(
            "EQ at the peak, ME there: both solvers' F/F_k where the master's is largest on the path;"
        )
        notes.append(
            "max |z|: their largest difference over the path in standard errors, about 3 by chance"
        )
    if any(verdict.friction_coefficient is not None for verdict in verdicts):
        notes.append(
            "F_k/load: k and x taken as uncorrelated (paper, Eq. Q6), load and <k> as at rest"
        )
    named: dict[str, list[str]] = {}
    for verdict in verdicts:
        evidence = verdict.evidence
        apart = [] if evidence is None or evidence.not_compared is None else [evidence.not_compared]
        apart = [f"EQ and ME not compared: {reason}" for reason in apart]
        for note in (*verdict.conditions, *apart, *verdict.cautions):
            named.setdefault(note, []).append(verdict.name)
    everyone = len(verdicts) if len(verdicts) > 1 else 0
    notes += [
        f"{'all' if len(names) == everyone else ', '.join(names)}: {note}"
        for note, names in named.items()
    ]
    if any(verdict.sampled for verdict in verdicts):
        names = ", ".join(verdict.name for verdict in verdicts if verdict.sampled)
        notes.append(
            f"{names}: thresholds from samples; errors are sampling errors, by {RESAMPLES} resampled laws"
        )
    return notes


def _with_error(value: float, error: float, digits: int = 6) -> str:
    return with_error(value, error, digits) if np.isfinite(value) else "infinite"


def _seconds(time: float) -> str:
    return f"{1e3 * time:.0f} ms" if time < 1.0 else f"{time:.1f} s"
