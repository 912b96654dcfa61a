"""What precision costs: true error against run time, for each solver the scene names and for its plain twin."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolkit.judge.references import Reference, reference
from toolkit.scene import laws
from toolkit.scene.scene import Scene

Array = npt.NDArray[np.float64]
Work = Callable[[float], tuple[Array, float | None]]
"""Force, and the error that the method claims (both lengths), at a rung of its ladder."""

TELLING = 10.0
_LONG = 1.0
_FEWEST_RUNS, _MOST_RUNS, _ENOUGH = 3, 20, 0.2


@dataclass(frozen=True)
class Ladders:
    """At what each method is measured, the cheapest first.

    tolerances : of the master equation; steps : per mean threshold, of the paper's explicit scheme; sizes : contacts
    of the ensemble; closest_sizes : contacts of the paper's closest-contact algorithm; longest : s of a run, beyond
    which its method is taken no further.
    """

    tolerances: Sequence[float] = tuple(10.0**-n for n in range(2, 13))
    steps: Sequence[float] = (25.0, 50.0, 100.0, 200.0, 400.0, 800.0)
    sizes: Sequence[float] = (1e2, 1e3, 1e4, 1e5, 1e6, 1e7)
    closest_sizes: Sequence[float] = (1e2, 3e2, 1e3, 3e3, 1e4)
    longest: float = 3.0


@dataclass(frozen=True)
class Point:
    """One method at one rung; errors in units of the mean threshold.

    method : "master", "explicit", "ensemble" or "closest".
    setting : tolerance, steps per mean threshold, or number of contacts.
    error : largest difference from the reference over the path. Of the ensemble and the closest contact it is that of
        one seed.
    claimed_error : what the method says of itself: the master equation's bound, the ensemble's largest standard
        error; None where it says nothing.
    run_time : s, the best of `runs` warm runs.
    at_reference : whether the error is below ten times the reference's own, which then is part of it.
    """

    method: str
    setting: float
    error: float
    claimed_error: float | None
    run_time: float
    runs: int
    at_reference: bool


@dataclass(frozen=True)
class Precision:
    """All points of a scene, what they were measured against, and what to know when reading them."""

    name: str
    title: str
    reference: Reference
    points: list[Point]
    notes: list[str]


def precision(
    scene: Scene, ladders: Ladders | None = None, report: Callable[[Point], None] | None = None
) -> Precision:
    """Measure the master equation and the paper's explicit scheme (scenes with [master]), the ensemble and the paper's
    closest-contact algorithm (scenes with [eq]).

    Parameters
    ----------
    scene : a checked scene; its tolerance and number of contacts are left aside, its seed is used.
    ladders : what to measure at; None: the command's.
    report : called with each point as soon as it is measured.

    A ladder ends early after a run of more than `ladders.longest`. Raises InputError for a scene that a method refuses,
    before anything is reported.
    """
    scene.only_forward("precision")
    ladders = ladders or Ladders()
    unit = scene.contacts.mean_threshold
    against = reference(scene.contacts, scene.path)
    methods = list(_methods(scene, ladders))
    for _, rungs, work in methods:
        work(rungs[0])  # so that nothing is imported or compiled while timed
    points: list[Point] = []
    notes = _notes(scene, against)
    for method, rungs, work in methods:
        for setting in rungs:
            run_time, runs, (force, claimed) = _time(work, setting)
            error = float(np.abs(force - against.force).max()) / unit
            claimed = None if claimed is None else float(claimed) / unit
            at_reference = error < TELLING * against.error
            points.append(Point(method, setting, error, claimed, run_time, runs, at_reference))
            if report is not None:
                report(points[-1])
            if run_time > ladders.longest and setting != rungs[-1]:
                notes.append(f"{method}: no further, as a run took more than {ladders.longest:g} s")
                break
    return Precision(scene.name, scene.title or scene.name, against, points, notes)


def _methods(scene: Scene, ladders: Ladders) -> Iterator[tuple[str, Sequence[float], Work]]:
    """Each method's name, rungs and work; the name and place of a bad key are the scene's."""
    contacts, path, unit = scene.contacts, scene.path, scene.contacts.mean_threshold
    if scene.master is not None:
        import master
        from master.paper.explicit import explicit

        def solve(tolerance: float) -> tuple[Array, float]:
            solved = master.solve(contacts, path, tolerance=tolerance)
            return solved.force, float(solved.force_error) * unit

        yield "master", ladders.tolerances, solve
        yield (
            "explicit",
            ladders.steps,
            lambda n: (explicit(contacts, path, step=unit / n).force, None),
        )
    if (eq := scene.eq) is not None:
        import eq_model
        from eq_model.closest import closest

        def simulate(size: float) -> tuple[Array, float]:
            with laws.inside("eq", {"seed": "seed"}):
                found = eq_model.simulate(contacts, path, n_contacts=int(size), seed=eq.seed)
            return found.force, float(found.force_standard_error.max())

        def follow(size: float) -> tuple[Array, None]:
            return closest(contacts, path, n_contacts=int(size), seed=eq.seed)[0], None

        yield "ensemble", ladders.sizes, simulate
        yield "closest", ladders.closest_sizes, follow


def _time(work: Work, setting: float) -> tuple[float, int, tuple[Array, float | None]]:
    """Best wall time of several runs, of one where it is long; their number; and what they give, always the same."""
    times: list[float] = []
    while True:
        began = time.perf_counter()
        answer = work(setting)
        times.append(time.perf_counter() - began)
        enough = len(times) >= _MOST_RUNS or (len(times) >= _FEWEST_RUNS and sum(times) > _ENOUGH)
        if enough or max(times) > _LONG:
            return min(times), len(times), answer


def _notes(scene: Scene, against: Reference) -> list[str]:
    notes = [
        f"true error: largest over {scene.path.size} positions, in units of <x_s>, from {against.source}, "
        f"good to {against.error:.0e}",
        f"* below {TELLING:g} times that: the reference's own error is part of it",
        "run time: wall time, best of the warm runs; compilation is not in it",
    ]
    lowest = scene.contacts.start.span[0]
    if scene.master is not None:
        notes.append("explicit: the paper's scheme, Eqs. (Q2)-(Q4), which claims no error")
        if lowest < 0.0 and float(scene.contacts.thresholds.cdf(-lowest)) > 1e-12:
            notes.append(
                "explicit: as in the paper, contacts that start at x < 0 are under P(x) from x = 0 on, not from |x|, "
                "so it does not tend to the model's force"
            )
    if scene.eq is not None:
        notes += [
            f"ensemble, closest: statistical, of the one seed {scene.eq.seed}; the ensemble claims its largest "
            "standard error, which the worst of many positions exceeds",
            "closest: the paper's algorithm, which claims no error; it errs as an ensemble of as many contacts",
        ]
    return notes


def table_head() -> list[str]:
    """Heading of the table."""
    head = f"{'method':9} {'at':>19}  {'true error':>10}  {'claimed':>8}  {'run time':>10}  {'runs':>4}"
    return [head, "-" * len(head)]


def table_line(point: Point) -> str:
    """One point as a line of the table."""
    settings = {
        "master": f"tolerance {point.setting:.0e}",
        "explicit": f"<x_s>/{point.setting:g}",
    }
    setting = settings.get(point.method, f"{point.setting:,.0f} contacts")
    mark = "*" if point.at_reference else " "
    claimed = "" if point.claimed_error is None else f"{point.claimed_error:.1e}"
    run_time = (
        f"{1e3 * point.run_time:.2f} ms" if point.run_time < 1.0 else f"{point.run_time:.2f} s "
    )
    return f"{point.method:9} {setting:>19}  {point.error:9.1e}{mark}  {claimed:>8}  {run_time:>10}  {point.runs:4d}"


def table(measured: Precision) -> list[str]:
    """All points as lines of text, with the notes."""
    lines = [measured.title, *table_head(), *(table_line(point) for point in measured.points)]
    return [*lines, *measured.notes]
