"""The master equation: error against run time, beside the paper's scheme and the library voles.

    python tests/bench/bench_master.py

Run times are wall clock of warm calls, best and median. True errors are against the closed form, in
units of the mean threshold. Every kind of scene beside an older version: bench_before.py.
"""

import importlib.util
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

import master
import origins
from master.paper.explicit import explicit

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from phase_type import gaussian_force

Array = npt.NDArray[np.float64]
PATH = np.linspace(0.0, 5.0, 501)
MEAN, STD, START_STD = 1.0, 0.05, 0.025
GOAL_TIME, GOAL_ERROR = 5e-3, 1e-10
ROW = "{:44s} {:>9} {:>9} {:>10} {:>10}  {}"


def timed(call: Callable[[], Any], budget: float = 0.4) -> tuple[Any, float, float]:
    """Answer of a warm call, best and median seconds of as many as fit the budget; of one where that takes seconds."""
    began = time.perf_counter()
    answer = call()
    fewest = 3 if time.perf_counter() - began < 1.0 else 1
    times: list[float] = []
    while len(times) < fewest or (sum(times) < budget and len(times) < 200):
        began = time.perf_counter()
        answer = call()
        times.append(time.perf_counter() - began)
    return answer, min(times), median(times)


def show(
    name: str, times: list[float], claimed: float | None, true: float, remark: str = ""
) -> None:
    best, middle = (f"{1e3 * seconds:.2f}" for seconds in times)
    print(
        ROW.format(
            name, best, middle, "" if claimed is None else f"{claimed:.1e}", f"{true:.1e}", remark
        )
    )


def head(title: str) -> None:
    print(f"\n{title}")
    print(ROW.format("", "best/ms", "median/ms", "claimed", "true", ""))


def gaussian_contacts() -> origins.Contacts:
    return origins.Contacts(origins.gaussian(MEAN, STD), origins.gaussian_start(0.0, START_STD))


def scene() -> None:
    """Fig. A02: the ladder of tolerances, the paper's scheme, voles."""
    head(f"Fig. A02: gaussian({MEAN}, {STD}), start gaussian(0, {START_STD}), 501 points to X = 5")
    contacts, exact = gaussian_contacts(), gaussian_force(PATH, MEAN, STD, 0.0, START_STD)
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12):
        solution, *times = timed(partial(master.solve, contacts, PATH, tolerance))
        true = float(np.abs(solution.force - exact).max())
        goal = "goal met" if times[0] <= GOAL_TIME and true <= GOAL_ERROR else ""
        show(f"solve, tolerance {tolerance:.0e}", times, solution.force_error, true, goal)
    for breaking in ("printed", "survival"):
        for step in (0.01, 0.005, 0.0025, 0.00125):
            twin, *times = timed(partial(explicit, contacts, PATH, step, breaking))
            true = float(np.abs(twin.force - exact).max())
            show(f"explicit, step {step}, {breaking}", times, None, true)
    voles_scene(exact)


def voles_scene(exact: Array) -> None:
    """b = b_0 + p * b by voles, then F = M_0 + (x S) * b; it is given b_0 and M_0 in closed form, `solve` is not."""
    if importlib.util.find_spec("voles") is None:
        print("voles is not installed (pip install voles): its rows are left out")
        return
    from scipy.interpolate import CubicSpline
    from scipy.signal import fftconvolve

    voles: Any = importlib.import_module("voles")
    width = np.hypot(STD, START_STD)

    def force(step: float, settings: dict[str, Any]) -> Array:
        x = step * np.arange(round(PATH[-1] / step) + 1)
        z, first = (x - MEAN) / STD, (x - MEAN) / width
        density = np.exp(-0.5 * z * z) / (STD * np.sqrt(2.0 * np.pi))
        bell = np.exp(-0.5 * first * first) / np.sqrt(2.0 * np.pi)
        births = voles.solve_VIE_2(
            kernel_values=density, g_values=bell / width, time_step=step, **settings
        )
        held = x * ndtr(-first) - START_STD**2 / width * bell
        # trapezoidal sums, with their end term of order step^2 at age 0; all else vanishes at both ends
        young = step * fftconvolve(x * ndtr(-z), births)[: x.size] + step**2 / 12.0 * births
        if step <= PATH[1]:
            return (held + young)[:: round(PATH[1] / step)]
        return CubicSpline(x, held + young)(PATH)

    for quadrature in ("product", "collocation"):
        for nodes in ([0, 1, 2], [0, 1, 2, 3, 4]):
            settings = {"quadrature": quadrature, "coll_divs": nodes[-1], "coll_choices": nodes}
            for step in (0.02, 0.01, 0.005, 0.0025):
                answer, *times = timed(partial(force, step, settings))
                name = (
                    f"voles {voles.version('voles')}, step {step}, {quadrature}, {len(nodes)} nodes"
                )
                show(name, times, None, float(np.abs(answer - exact).max()))


if __name__ == "__main__":
    scene()
