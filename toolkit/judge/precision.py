"""Cost of precision: true error against run time of every method that can follow the scene's slider along its path."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import fmean, median
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.judge.frontier import ONE_SEED, as_words, cheapest, of_claims, of_threads, slope
from toolkit.judge.reference import (
    MethodAnswer,
    Reference,
    TimedAnswer,
    compared,
    exact_force,
    finest,
    largest_error,
    of_witness,
    unbroken,
    with_error_in,
    witness_of,
)
from toolkit.judge.rigid import on_rigid_slider
from toolkit.judge.slips import REMARK, SLIDERS, alike, check_one_way, slips_so_far
from toolkit.processes.ranks import cores_of
from toolkit.processes.signals import TooMuchWork, no_longer_than
from toolkit.running.solvers import follow, make_ensemble, solve_master
from toolkit.scene.scene import Scene
from toolkit.scene.tables import EqTable

RUNGS: dict[str, tuple[float, ...]] = {  # the settings of each method, the cheapest first
    "master": tuple(10.0**-n for n in range(2, 13)),  # tolerances
    "explicit": (25.0, 50.0, 100.0, 200.0, 400.0, 800.0),  # steps per mean threshold
    "ensemble": (1e2, 1e3, 1e4, 1e5, 1e6, 1e7),  # contacts
    "closest": (1e2, 3e2, 1e3, 3e3, 1e4),
}
# CPU-s for the runs of one method, so that the four of them take less than half a minute
_SECONDS = 6.0
_WARM = 30.0  # CPU-s for its first run: a slow machine compiles a kernel in 25
_FEWEST = 0.5  # of the points at which the reference tells: where fewer can be compared, a run tells little
_LONG = 1000.0  # mean thresholds, along which the quickest run of either of the paper's methods takes a second or two
REPEATED = 0.5  # s: runs are repeated, up to 5 times, until they took so long together
_REMARKS = {
    "explicit": "explicit: the paper's scheme, Eqs. (Q2)-(Q4); it claims no error",
    "ensemble": "ensemble: of one seed; claims its largest standard error, and the worst of many positions exceeds it",
    "closest": "closest: the paper's algorithm, of one seed; it claims no error",
}


def precision(scene: Scene, say: Callable[[str], None]) -> dict[str, Any]:
    """Measure the master equation, the paper's explicit scheme, the ensemble and the paper's closest-contact algorithm,
    each at its RUNGS where it takes the scene; `say` is given a line for each run.

    Returns what precision.json holds: name, title, `reference` in words with its `reference_error`, `notes`,
    `slopes`, `slope_errors` and `cheapest` (see toolkit.judge.frontier), `warm_up` of each method in s (imports and
    compilation), `witness`, the ensemble beside a reference by the master equation, and `points`, each with its
    `method`, `setting`, largest `error` over the path (None of the reference itself), `claimed_error` (None where
    nothing is claimed), and `run_time` in s, the median of `runs`; `threads`, the same ensemble on 1, 2, ... of them,
    each with its `run_time` on the clock in s and whether its force has the `same_bits`. Errors are in `error_unit`:
    newtons or pascals of a surface whose units are SI, else mean thresholds.

    A sweep is left out; where there is no path, the force of a rigid slider is measured, and a note says so.
    Raises InputError where neither the master equation nor the ensemble has an answer.
    """
    notes, warm_up, mean = list[str](), dict[str, float](), scene.contacts.mean_threshold
    unit = scene.scale.of_errors(mean)
    scene = _with_path(scene, notes)
    methods, exact = _methods(scene, notes), exact_force(scene)
    runs = {"master": _climb("master", methods.pop("master"), notes, warm_up)}
    if exact is None and not runs["master"] and "ensemble" in methods:
        runs["ensemble"] = _climb("ensemble", methods["ensemble"], notes, warm_up)
    if exact is None and not any(runs.values()):
        why = [note for note in notes if note.startswith(("master", "ensemble"))]
        raise InputError(f"precision: {'; '.join(why)}")
    reference = exact or finest(scene, runs["master"], runs.get("ensemble", []))
    reference = with_error_in(unit.size, reference, mean)
    points: list[dict[str, Any]] = []

    def tell(method: str) -> None:
        for run in runs[method]:
            claimed = None if run.answer.claimed is None else run.answer.claimed / unit.size
            error = largest_error(run.answer, reference, unit.size)
            point = {"method": method, "setting": run.setting, "error": error}
            point |= {"claimed_error": claimed, "run_time": run.run_time, "runs": run.runs}
            points.append(point)
            resolved = error is None or error >= reference.error
            say(
                _line(
                    (point if resolved else point | {"error": f"<{reference.error:.1e}"}).values()
                )
            )

    told = f"{unit.name} (of master, at a tolerance in <x_s>)"
    if unit.size == mean:
        told = "mean thresholds <x_s>"
    say(f"errors in {told}, time in CPU-s of one thread")
    say(_line(["method", "at", "error", "claimed", "time", "runs"]))
    tell("master")
    for method, work in methods.items():
        if method not in runs:
            runs[method] = _climb(method, work, notes, warm_up)
        runs[method] = _comparable(method, runs[method], reference, notes)
        tell(method)
    solved, sampled = runs["master"], runs.get("ensemble", [])
    threads = _on_threads(methods["ensemble"], sampled) if sampled else []
    witness = None
    if exact is None and solved and sampled and not reference.soft:
        witness = witness_of(sampled[-1], solved, mean, unit.size)
    measured = {point["method"] for point in points}
    said = [
        *unbroken(scene),
        f"true error: largest over {reference.counted.sum()} positions, in {unit.name}, from {reference.words}, "
        f"good to {reference.error:.0e}, below which it tells no error",
        *([] if exact else of_witness(witness, solved, sampled, unit.name)),
        *of_threads(threads),
        "run time: CPU time of one thread, median of the warm runs; imports and compilation are told apart: "
        + ", ".join(f"{method} {seconds:.2g} s" for method, seconds in warm_up.items()),
    ]
    said += of_claims(points, reference.error)
    remarks = _REMARKS | ({"ensemble": REMARK} if reference.soft else {})
    said += [words for method, words in remarks.items() if method in measured]
    slopes = {method: slope(points, method, reference.error) for method in RUNGS}
    by_size = {method: slope(points, method, reference.error, "setting") for method in ONE_SEED}
    spans = cheapest(points, reference.error)
    return {
        "reference": reference.words,
        "name": scene.name,
        "title": scene.title or scene.name,
        "error_unit": unit.name,
        "reference_error": reference.error,
        "witness": witness,
        "points": points,
        "slopes": {method: one and one.value for method, one in slopes.items()},
        "slope_errors": {method: one and one.error for method, one in slopes.items()},
        "cheapest": spans,
        "threads": threads,
        "warm_up": warm_up,
        "notes": [*as_words(slopes, spans, unit.name, by_size), *said, *notes],
    }


def _comparable(
    method: str, runs: list[TimedAnswer], reference: Reference, notes: list[str]
) -> list[TimedAnswer]:
    """The runs but those whose sliders slip at so different places that little is left to compare, which are noted."""
    least = _FEWEST * reference.counted.sum()
    kept = [run for run in runs if compared(run.answer, reference).sum() >= least]
    if gone := [f"{run.setting:.3g}" for run in runs if run not in kept]:
        notes.append(f"{method}: at {', '.join(gone)} its slips come elsewhere: not compared")
    return kept


def _with_path(scene: Scene, notes: list[str]) -> Scene:
    """The scene, or in place of a sweep what is measured of it, which is noted."""
    if scene.grid is not None:
        notes.append("sweep: left out; measured is the scene without it")
    if scene.given_drive is not None and (scene.master is not None or scene.eq is not None):
        return replace(scene, grid=None)
    notes.append(
        f"no path: measured is F(X) of a rigid slider from X = 0 on, at a speed of {scene.sliding:.3g}"
    )
    return on_rigid_slider(scene)


def _on_threads(work: Callable[..., MethodAnswer], runs: list[TimedAnswer]) -> list[dict[str, Any]]:
    """The largest ensemble that takes no longer than REPEATED, on one thread and on up to as many as there are cores,
    twice as many each time."""
    small = [run for run in runs if run.run_time <= REPEATED]
    if not small:
        return []
    setting, cores = small[-1].setting, cores_of(None)
    found = list[dict[str, Any]]()
    for threads in sorted({*(2**n for n in range(cores.bit_length())), cores}):
        run = _timed(partial(work, threads=threads), setting, time.perf_counter)
        same = np.array_equal(run.answer.force, small[-1].answer.force)
        row = {"threads": threads, "contacts": int(setting), "run_time": run.run_time}
        found.append(row | {"same_bits": bool(same)})
    return found


def _line(cells: Any) -> str:
    texts = (f"{cell:.3g}" if isinstance(cell, float) else str(cell or "") for cell in cells)
    return "  ".join(f"{cell:>9}" for cell in texts)


def _methods(scene: Scene, notes: list[str]) -> dict[str, Callable[..., MethodAnswer]]:
    """What finds the force at a setting, by the name of each method that takes the scene; those that are left out are
    noted."""
    import master
    from eq_model.closest import closest

    contacts, path, unit = scene.contacts, scene.path, scene.contacts.mean_threshold
    asked = scene.eq or EqTable()

    def solve(tolerance: float) -> MethodAnswer:
        solved: Any = solve_master(scene, tolerance)
        return MethodAnswer(solved.force, float(solved.force_error) * unit, solved)

    def step(number: float) -> MethodAnswer:
        return MethodAnswer(master.explicit(contacts, path, step=unit / number).force, None)

    def simulate(size: float, threads: int = 1) -> MethodAnswer:
        small: dict[str, Any] = {"n_contacts": int(size), "n_replicas": 1, "histograms": ()}
        small |= {"tolerance": None, "wall_time": None, "threads": threads}
        if scene.drive.spring is None:
            found: Any = follow(make_ensemble(scene, asked, None, **small))
            error = found.force_standard_error + found.step_error
            return MethodAnswer(found.force, float(error.max()), found)
        check_one_way(scene.drive)
        found = follow(make_ensemble(scene, asked, None, **small | {"n_replicas": SLIDERS}))
        slips = slips_so_far(found, scene.drive)
        scatter = found.force_standard_error[alike(slips, slips)]
        return MethodAnswer(found.force, float(scatter.max(initial=0.0)), found, slips)

    def pick(size: float) -> MethodAnswer:
        return MethodAnswer(closest(contacts, path, n_contacts=int(size), seed=asked.seed)[0], None)

    methods = {"master": solve, "explicit": step, "ensemble": simulate, "closest": pick}
    why = "" if scene.drive.forward else "they take a path that does not turn round"
    if not why and path[-1] > _LONG * unit:
        why = f"a path of over {_LONG:.0f} mean thresholds takes them too long"
    if scene.drive.spring is not None:
        why = "they take a rigid slider"
    if why:
        notes.append(f"explicit, closest: left out; {why}")
        del methods["explicit"], methods["closest"]
    if contacts.each_by_itself() is not contacts:
        notes.append("ensemble: left out; single contacts do not follow the paper's closure")
        del methods["ensemble"]
    return methods


def _climb(
    method: str, work: Callable[[float], MethodAnswer], notes: list[str], warm_up: dict[str, float]
) -> list[TimedAnswer]:
    """The runs of a method, rung by rung while CPU time is left. One that refuses the scene has none, and is noted."""
    runs, spent = list[TimedAnswer](), 0.0
    setting, limit, began = RUNGS[method][0], _WARM, time.process_time()
    try:
        with no_longer_than(limit, TooMuchWork):
            work(setting)  # so that nothing is imported or compiled while timed
        warm_up[method], limit = time.process_time() - began, _SECONDS
        for setting in RUNGS[method]:
            last = [run.run_time for run in runs[-2:]]
            # the next run is as much longer again, and half as long once more to be safe
            foreseen = 1.5 * last[-1] * max(last[-1] / last[0], 1.0) if last else 0.0
            if spent + foreseen > _SECONDS:
                notes.append(f"{method}: no further than {runs[-1].setting:.3g}, for want of time")
                break
            run = _timed(work, setting)
            answer, spent = run.answer, spent + run.run_time * run.runs
            if not np.isfinite(answer.force).all() or answer.claimed == np.inf:
                why = f"; {answer.found.message}" if answer.claimed == np.inf else ""
                notes.append(f"{method}: no answer at {setting:.3g}{why}")
                break
            missed = method == "master" and answer.found.force_error > setting
            if method == "master" and runs and _is_same(answer, runs[-1].answer):
                before = runs.pop()  # the tightest tolerance that is met tells of all
                run = run._replace(setting=before.setting if missed else setting)
            runs.append(run)
            if missed:
                notes.append(f"{method}: no finer than {setting:.3g}; {answer.found.message}")
                break
    except TooMuchWork:
        notes.append(f"{method}: no answer at {setting:.3g} in {limit:.0f} CPU-seconds")
    except InputError as error:
        notes.append(f"{method}: {f'no further; {error}' if runs else f'left out; {error}'}")
    return runs


def _is_same(one: MethodAnswer, other: MethodAnswer) -> bool:
    """Whether two tolerances gave one answer, as where each lets the solver take the same panels or steps."""
    return one.claimed == other.claimed and np.array_equal(one.force, other.force)


def _timed(
    work: Callable[[float], MethodAnswer],
    setting: float,
    clock: Callable[[], float] = time.process_time,
) -> TimedAnswer:
    """The answer at a setting, and the median of its run times, repeated where it takes little. CPU time of the one
    thread hardly hangs on what else the machine does. Raises TooMuchWork beyond _SECONDS."""
    began = clock()
    # within, the system counts CPU time in steps of some ms
    with no_longer_than(_SECONDS, TooMuchWork):
        answer = work(setting)
    if (took := clock() - began) >= REPEATED:
        return TimedAnswer(setting, answer, took, 1)
    times = list[float]()
    # a system that counts in steps may tell 0 of a short run, and of most of five: then their mean is told
    while (len(times) < 5 and sum(times) < REPEATED) or sum(times) <= 0.0:
        began = clock()
        answer = work(setting)
        times.append(clock() - began)
    return TimedAnswer(setting, answer, median(times) or fmean(times), len(times))
