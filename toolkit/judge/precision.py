"""Cost of precision: true error against run time, for each solver the scene names and for the paper's algorithms."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from origins.contacts import Contacts
from origins.errors import InputError
from origins.start import GaussianStart
from origins.thresholds.gaussian import CutGaussian
from toolkit.scene import laws
from toolkit.scene.scene import Scene

Array = npt.NDArray[np.float64]
Work = Callable[[float], tuple[Array, float | None]]
"""Force, and the error that the method claims (both lengths), at a rung of its ladder."""

_RUNS, _LONG = 5, 1.0  # runs, of which the fastest counts; s of a run that is not repeated
_ROUND_OFF = 2.0**-53
_NEGLIGIBLE = 1e-16  # of the mean threshold: allowed effect of the cut at 0 on a closed form
_ROOT_TWO_PI = np.sqrt(2.0 * np.pi)


@dataclass(frozen=True)
class Ladders:
    """Settings at which each method is measured, the cheapest first.

    tolerances : of the master equation; steps : per mean threshold, of the paper's explicit scheme; sizes : contacts
    of the ensemble; closest_sizes : contacts of the paper's closest-contact algorithm; longest : s of a run, after
    which its method is not continued.
    """

    tolerances: Sequence[float] = tuple(10.0**-n for n in range(2, 13))
    steps: Sequence[float] = (25.0, 50.0, 100.0, 200.0, 400.0, 800.0)
    sizes: Sequence[float] = (1e2, 1e3, 1e4, 1e5, 1e6, 1e7)
    closest_sizes: Sequence[float] = (1e2, 3e2, 1e3, 3e3, 1e4)
    longest: float = 3.0


class Reference(NamedTuple):
    """F/(N_c<k>) on a path (a length), and a bound on its largest error in mean thresholds."""

    force: Array
    error: float


@dataclass(frozen=True)
class Point:
    """One `method` ("master", "explicit", "ensemble", "closest") at one rung, its `setting`; errors in mean thresholds.

    error : largest difference from the closed form over the path; claimed_error : the error that the method states,
    None where it states none; run_time : s, the shortest of `runs` warm runs.
    """

    method: str
    setting: float
    error: float
    claimed_error: float | None
    run_time: float
    runs: int


@dataclass(frozen=True)
class Precision:
    """All points of a scene, the error of the reference, and notes on how to read them."""

    name: str
    title: str
    reference_error: float
    points: list[Point]
    notes: list[str]


def precision(
    scene: Scene, ladders: Ladders | None = None, report: Callable[[Point], None] | None = None
) -> Precision:
    """Measure the master equation and the paper's explicit scheme (scenes with [master]), the ensemble and the paper's
    closest-contact algorithm (scenes with [eq]), at the rungs of `ladders` (None: the command's).

    `report` is called with each point as soon as it is measured. The scene's seed is used, its tolerance and its number
    of contacts are not. Raises InputError, before any report, for a scene that a method refuses, and where F is not
    known in closed form.
    """
    scene.only_forward("precision")
    ladders = ladders or Ladders()
    unit = scene.contacts.mean_threshold
    against = closed_form(scene.contacts, scene.path)
    if against is None:
        rule = (
            "needs F in closed form: Gaussian thresholds far from 0, from one stretch or a Gaussian"
        )
        raise InputError(f"precision: {rule} of them")
    methods = list(_methods(scene, ladders))
    for _, rungs, work in methods:
        work(rungs[0])  # so that nothing is imported or compiled while timed
    points: list[Point] = []
    notes = [
        f"true error: largest over {scene.path.size} positions, in units of <x_s>, from the closed form for Gaussian "
        f"thresholds, good to {against.error:.0e}",
        "run time: wall time, best of the warm runs; compilation is not in it",
    ]
    if scene.master is not None:
        notes.append("explicit: the paper's scheme, Eqs. (Q2)-(Q4), which claims no error")
    if scene.eq is not None:
        notes.append(
            f"ensemble, closest: of the one seed {scene.eq.seed}; the ensemble claims its largest standard error, "
            "which the worst of many positions exceeds"
        )
    for method, rungs, work in methods:
        for setting in rungs:
            run_time, runs, (force, claimed) = _time(work, setting)
            error = float(np.abs(force - against.force).max()) / unit
            claimed = None if claimed is None else float(claimed) / unit
            points.append(Point(method, setting, error, claimed, run_time, runs))
            if report is not None:
                report(points[-1])
            if run_time > ladders.longest and setting != rungs[-1]:
                notes.append(f"{method}: no further, as a run took more than {ladders.longest:g} s")
                break
    return Precision(scene.name, scene.title or scene.name, against.error, points, notes)


def _methods(scene: Scene, ladders: Ladders) -> Iterator[tuple[str, Sequence[float], Work]]:
    """Each method's name, rungs and work; errors name the key of the scene."""
    contacts, path, unit = scene.contacts, scene.path, scene.contacts.mean_threshold
    if scene.master is not None:
        import master
        from master.paper.explicit import explicit

        def solve(tolerance: float) -> tuple[Array, float]:
            solved = master.solve(contacts, path, tolerance=tolerance)
            return solved.force, float(solved.force_error) * unit

        def step(number: float) -> tuple[Array, None]:
            return explicit(contacts, path, step=unit / number).force, None

        yield "master", ladders.tolerances, solve
        yield "explicit", ladders.steps, step
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
    """Shortest wall time of several runs (of one run if it is long), their number, and their result."""
    times: list[float] = []
    while True:
        began = time.perf_counter()
        answer = work(setting)
        times.append(time.perf_counter() - began)
        if len(times) == _RUNS or times[-1] > _LONG:
            return min(times), len(times), answer


def closed_form(contacts: Contacts, path: Array) -> Reference | None:
    """Gaussian thresholds from one stretch or a Gaussian of them; None for others, and where weight is cut at 0.

    With thresholds of mean m and width s, and starts of mean x_0 and width s_0, the n-th break of a contact comes at
    X_n, normal with mean n m - x_0 and variance n s^2 + s_0^2, and then the n-th threshold is released, so that
    F = x_0 + X - sum over n of E[threshold n; X_n < X]. The error is a bound for round-off.
    """
    thresholds, start = contacts.thresholds, contacts.start
    if not isinstance(thresholds, CutGaussian):
        return None
    if not (start.is_single or isinstance(start, GaussianStart)):
        return None
    mean, width, first = thresholds.parent_mean, thresholds.parent_std, start.mean()
    spread = 0.0 if start.is_single else 1.0 / (_ROOT_TWO_PI * float(start.pdf(first)))
    narrowest = float(np.hypot(width, spread))
    reach = float(path[-1]) + abs(first) + mean
    cut = float(ndtr(-mean / width))
    cut_at_start = float(ndtr((first - mean) / narrowest) + ndtr((-first - mean) / narrowest))
    # the error for a contact that the cut affects, in any generation, is at most its travel
    if mean <= 0.0 or (cut_at_start + (reach / mean + 1.0) * cut) * reach > _NEGLIGIBLE * mean:
        return None
    force, count, z = first + path, 0, np.zeros(1)
    while z[-1] >= -10.0:
        count += 1
        scatter = np.sqrt(count * width**2 + spread**2)
        z = (path - count * mean + first) / scatter
        force -= mean * ndtr(z) - width**2 / scatter * np.exp(-0.5 * z * z) / _ROOT_TWO_PI
    # each term and its argument are rounded, and the latter matters more the narrower the laws are
    error = float(_ROUND_OFF * (count + 4.0 + mean / narrowest) * reach / mean)
    return Reference(force, error)


def table_head() -> list[str]:
    """Heading of the table."""
    head = f"{'method':9} {'at':>19}  {'true error':>10}  {'claimed':>8}  {'run time':>10}  {'runs':>4}"
    return [head, "-" * len(head)]


def table_line(point: Point) -> str:
    """One point as a line of the table."""
    setting = f"{point.setting:,.0f} contacts"
    if point.method == "master":
        setting = f"tolerance {point.setting:.0e}"
    elif point.method == "explicit":
        setting = f"<x_s>/{point.setting:g}"
    claimed = "" if point.claimed_error is None else f"{point.claimed_error:.1e}"
    run_time = f"{1e3 * point.run_time:.2f} ms"
    return f"{point.method:9} {setting:>19}  {point.error:10.1e}  {claimed:>8}  {run_time:>10}  {point.runs:4d}"
