"""Cost of precision: true error against run time, for each solver the scene names and for the paper's algorithms."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from origins.contacts import Contacts, check_contacts
from origins.errors import InputError
from origins.start import GaussianStart
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Array
from toolkit.scene.scene import Scene

RUNGS: dict[str, tuple[float, ...]] = {  # the settings of each method, the cheapest first
    "master": tuple(10.0**-n for n in range(2, 13)),  # tolerances
    "explicit": (25.0, 50.0, 100.0, 200.0, 400.0, 800.0),  # steps per mean threshold
    "ensemble": (1e2, 1e3, 1e4, 1e5, 1e6, 1e7),  # contacts
    "closest": (1e2, 3e2, 1e3, 3e3, 1e4),
}


def precision(scene: Scene, say: Callable[[str], None]) -> dict[str, Any]:
    """Measure the master equation and the paper's explicit scheme (scenes with [master]), the ensemble and the paper's
    closest-contact algorithm (scenes with [eq]), each at its RUNGS; `say` is given a line for each as it is measured.

    Returns what precision.json holds: name, title, `reference_error`, `notes`, and `points`, each with its `method`,
    `setting`, largest `error` over the path and `claimed_error` (mean thresholds; None where nothing is claimed),
    `run_time` in s, the shortest of `runs` warm ones. Raises InputError where F is not known in closed form.
    """
    scene.only_forward("precision")
    check_contacts(scene.contacts, "precision")  # no closed form has a law
    exact, reference_error = closed_form(scene.contacts, scene.path)
    points: list[dict[str, Any]] = []
    notes = [
        f"true error: largest over {scene.path.size} positions, in units of <x_s>, from the closed form for Gaussian "
        f"thresholds, good to {reference_error:.0e}",
        "run time: wall time, best of the warm runs; compilation is not in it",
        "explicit (Eqs. (Q2)-(Q4)) and closest are the paper's, and claim no error; ensemble and closest are of one "
        "seed, and the ensemble claims its largest standard error, which the worst of many positions exceeds",
    ]
    for method, work in _methods(scene).items():
        work(RUNGS[method][0])  # so that nothing is imported or compiled while timed
        if not points:
            say(_line(["method", "at", "error", "claimed", "time", "runs"]))
        for setting in RUNGS[method]:
            times: list[float] = []
            while len(times) < 5 and (not times or times[-1] < 1.0):  # long runs are not repeated
                began = time.perf_counter()
                force, claimed = work(setting)
                times.append(time.perf_counter() - began)
            error = float(np.abs(force - exact).max()) / scene.contacts.mean_threshold
            point = {"method": method, "setting": setting, "error": error}
            point |= {"claimed_error": claimed, "run_time": min(times), "runs": len(times)}
            points.append(point)
            say(_line(point.values()))
            if min(times) > 3.0:
                notes.append(f"{method}: no further, as a run took more than 3 s")
                break
    return {
        "reference": "the closed form for Gaussian thresholds",
        "name": scene.name,
        "title": scene.title or scene.name,
        "reference_error": reference_error,
        "points": points,
        "notes": notes,
    }


def _line(cells: Any) -> str:
    texts = (f"{cell:.3g}" if isinstance(cell, float) else str(cell or "") for cell in cells)
    return "  ".join(f"{cell:>9}" for cell in texts)


def _methods(scene: Scene) -> dict[str, Callable[[float], tuple[Array, float | None]]]:
    """By each method's name its force (a length) at a setting, and the error that it claims, in mean thresholds."""
    import eq_model
    import master
    from eq_model.closest import closest
    from master.paper.explicit import explicit

    contacts, path, unit = scene.contacts, scene.path, scene.contacts.mean_threshold
    seed = 0 if scene.eq is None else scene.eq.seed

    def solve(tolerance: float) -> tuple[Array, float]:
        solved: Any = master.solve(contacts, path, tolerance=tolerance)
        return solved.force, float(solved.force_error)

    def step(number: float) -> tuple[Array, None]:
        return explicit(contacts, path, step=unit / number).force, None

    def simulate(size: float) -> tuple[Array, float]:
        found: Any = eq_model.simulate(contacts, path, n_contacts=int(size), seed=seed)
        return found.force, float(found.force_standard_error.max()) / unit

    def follow(size: float) -> tuple[Array, None]:
        return closest(contacts, path, n_contacts=int(size), seed=seed)[0], None

    own: Any = {"master": solve, "explicit": step} if scene.master is not None else {}
    return own | ({} if scene.eq is None else {"ensemble": simulate, "closest": follow})


def closed_form(contacts: Contacts, path: Array) -> tuple[Array, float]:
    """F/(N_c<k>) of Gaussian thresholds from one stretch or a Gaussian of them, and a bound on its round-off in mean
    thresholds. Raises InputError for other contacts, and where the cut of a law at 0 matters.

    With thresholds of mean m and width s, and starts of mean x_0 and width s_0, the n-th break of a contact comes at
    X_n, normal with mean n m - x_0 and variance n s^2 + s_0^2, and then the n-th threshold is released, so that
    F = x_0 + X - sum over n of E[threshold n; X_n < X].
    """
    law, start = contacts.thresholds, contacts.start
    if isinstance(law, CutGaussian) and (start.is_single or isinstance(start, GaussianStart)):
        mean, width, first = law.parent_mean, law.parent_std, start.mean()
        spread = 0.0 if start.is_single else 1.0 / (np.sqrt(2.0 * np.pi) * float(start.pdf(first)))
        narrowest, reach = float(np.hypot(width, spread)), float(path[-1]) + abs(first) + abs(mean)
        cut = scipy.special.ndtr((np.array([first, -first]) - mean) / narrowest).sum()
        cut += (reach / abs(mean) + 1.0) * scipy.special.ndtr(-mean / width)
        # the error for a contact that the cut affects, in any generation, is at most its travel
        if mean > 0.0 and cut * reach <= 1e-16 * mean:
            force, count, z = first + path, 0, np.zeros(1)
            while z[-1] >= -10.0:
                count += 1
                scatter = np.sqrt(count * width**2 + spread**2)
                z = (path - count * mean + first) / scatter
                bell = np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
                force -= mean * scipy.special.ndtr(z) - width**2 / scatter * bell
            # each term and its argument are rounded, and the latter matters more the narrower the laws are
            return force, float(2.0**-53 * (count + 4.0 + mean / narrowest) * reach / mean)
    hint = "needs F in closed form: Gaussian thresholds far from 0, from one stretch or a Gaussian"
    raise InputError(f"precision: {hint} of them")


def draw_picture(found: dict[str, Any]) -> Any:
    """True error in units of <x_s> against run time in s, hollow marks for the errors that are claimed."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6), layout="constrained")
    axes, colours = figure.subplots(), ("#1f4e79", "#5dade2", "#c0392b", "#e59866")
    for method, marker, colour in zip(RUNGS, "os^v", colours, strict=True):
        points = [point for point in found["points"] if point["method"] == method]
        run_time = [point["run_time"] for point in points]
        # an error of 0 has no place on a logarithmic axis
        error = [max(point["error"], 1e-17) for point in points]
        claimed = [point["claimed_error"] or np.nan for point in points]
        if points:
            axes.plot(run_time, error, marker + "-", color=colour, lw=1, label=method)
        if np.isfinite(claimed).any():
            label = f"{method}: its claim"
            axes.plot(run_time, claimed, marker, mfc="none", mec=colour, label=label)
    axes.set(xscale="log", yscale="log", xlabel="run time (s)")
    axes.set_ylabel(r"largest error of $F$ over the path, in $\langle x_s\rangle$")
    axes.set_title(f"against the closed form, good to {found['reference_error']:.0e}")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return figure
