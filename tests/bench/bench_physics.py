"""Temperature, ageing, delay, re-forming, loops and F_k(v): error against run time, beside the paper's explicit scheme.

    python tests/bench/bench_physics.py

Run times are wall clock of warm calls. True errors are against a solve at tolerance 1e-11 (loops: 1e-10), in mean
thresholds. The explicit scheme is run with two steps; its error falls with the step and its time grows with the inverse
square, which tells when it would reach the tolerance ("as good in"), and how good it is in the time that `solve` takes.
"""

import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

import master
from master.paper.explicit import explicit
from master.paper.explicit_loop import explicit_loop
from origins import Ageing, Contacts, Delay, Thermal, boltzmann_reforming, gaussian, gaussian_start

Array = npt.NDArray[np.float64]

PATH = np.linspace(0.0, 5.0, 501)
LAW, START = gaussian(1.0, 0.05), gaussian_start(0.1, 0.025)
ROW = "{:44s} {:>9} {:>9} {:>9}  {}"


def best_of(call: Callable[[], Any], budget: float = 0.5) -> tuple[Any, float]:
    """Answer of a warm call, and the best of as many times as fit the budget."""
    answer, times = call(), []
    while not times or (sum(times) < budget and len(times) < 30):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return answer, min(times)


def head(title: str) -> None:
    print(f"\n{title}")
    print(ROW.format("", "ms", "claimed", "true", ""))


def show(name: str, seconds: float, claimed: float, true: float, goal: float, remark: str = "") -> None:
    remarks = [] if seconds <= goal else [f"over {1e3 * goal:g} ms"]
    remarks += [remark] if remark else []
    print(ROW.format(name, f"{1e3 * seconds:.1f}", f"{claimed:.1e}", f"{true:.1e}", "; ".join(remarks)), flush=True)


def beside(scheme: Callable[[float], Any], exact: Array, seconds: float, error: float) -> None:
    """The explicit scheme at equal error and at equal time, from two steps of it."""
    steps, errors, times = (0.01, 0.005), [], []
    for step in steps:
        answer, taken = best_of(partial(scheme, step), 0.05)
        errors.append(float(np.abs(answer.force - exact).max()))
        times.append(taken)
    as_good = times[1] * (errors[1] / error) ** 2
    step = steps[1] * np.sqrt(times[1] / seconds)
    then = float(np.abs(scheme(step).force - exact).max()) if step < 0.2 else np.nan
    words = f"as good in {as_good:.1e} s; in the same time {then:.1e}"
    print(ROW.format("    explicit, step 0.005", f"{1e3 * times[1]:.1f}", "", f"{errors[1]:.1e}", words), flush=True)


def steady_speeds() -> None:
    head("rigid slider at a steady speed, 501 points to X = 5, tolerance 1e-8; goal: 50 ms, exact ageing 1 s")
    warm: dict[str, Contacts] = {}
    for closure in ("exact", "paper"):
        for law, temperatures in (("soft", (0.03, 0.1, 0.3, 1.0)), ("stiff", (0.1, 1.0))):
            for t in temperatures:
                thermal = Thermal(law, t, closure=closure)  # type: ignore[arg-type]
                warm[f"{law}, T = {t}, {closure} closure"] = Contacts(LAW, START, thermal=thermal)
    soft = Thermal("soft", 0.1)
    scenes = {
        "relaxed, soft, T = 0.1": Contacts(LAW, thermal=soft),
        **warm,
        "delay 0.2": Contacts(LAW, START, delay=Delay(0.2)),
        "delay 0.2, soft, T = 0.1": Contacts(LAW, START, delay=Delay(0.2), thermal=soft),
        "delay 0.2, soft, T = 0.1, paper closure": Contacts(
            LAW, START, delay=Delay(0.2), thermal=Thermal("soft", 0.1, closure="paper")
        ),
        "re-forming, Boltzmann, T = 0.01": Contacts(LAW, START, reforming=boltzmann_reforming(0.01)),
        "the same, soft contacts": Contacts(
            LAW, START, reforming=boltzmann_reforming(0.01), thermal=Thermal("soft", 0.01)
        ),
        **{
            f"re-forming and {law} contacts, T = {t}": Contacts(
                LAW, START, reforming=boltzmann_reforming(min(t, 0.05)), thermal=Thermal(law, t)  # type: ignore[arg-type]
            )
            for law, t in (("soft", 0.03), ("soft", 0.1), ("stiff", 0.03), ("stiff", 0.1))
        },
        "linked stiffness": Contacts(LAW, START, stiffness="linked"),
        "linked stiffness, soft, T = 0.1": Contacts(LAW, START, stiffness="linked", thermal=soft),
    }
    for name, contacts in scenes.items():
        solution, seconds = best_of(partial(master.solve, contacts, PATH, 1e-8))
        exact = master.solve(contacts, PATH, 1e-11).force
        true = float(np.abs(solution.force - exact).max())
        show(name, seconds, solution.force_error, true, 0.05, "" if solution.success else "NOT REACHED")
        as_printed = contacts.reforming is None and contacts.stiffness == "independent"
        if as_printed and (contacts.thermal is None or contacts.thermal.closure == "paper"):
            beside(partial(explicit, contacts, PATH), exact, seconds, 1e-8)


def ageing() -> None:
    head("ageing: Fig. A05's laws, D_X = 1e-3; exact closure: F(X); both: the steady state")
    fresh, final = gaussian(0.5, 0.1), gaussian(1.0, 0.01)
    exact = Contacts(fresh, ageing=Ageing(final, rate=1e-3))
    path = np.linspace(0.0, 2.5, 251)
    solution, seconds = best_of(lambda: master.solve(exact, path, 1e-8), 1.0)
    finer = master.solve(exact, path, 1e-10)
    off = float(np.abs(solution.force - finer.force).max())
    show("exact closure, solve, 1e-8", seconds, solution.force_error, off, 1.0)
    for closure in ("exact", "paper"):
        contacts = Contacts(fresh, ageing=Ageing(final, rate=1e-3, closure=closure))  # type: ignore[arg-type]
        steady, seconds = best_of(partial(master.steady_state, contacts), 1.0)
        show(f"{closure} closure, steady state", seconds, steady.force_error, np.nan, 1.0)


def loops() -> None:
    head("three turns, T = 0, tolerance 1e-6; goal: 200 ms")
    contacts = Contacts(LAW, START)
    for turn in (3.0, 0.9):
        turns = np.array([0.0, turn, -turn, turn, -turn])
        path = np.concatenate([np.linspace(a, b, 100) for a, b in pairwise(turns)])
        solution, seconds = best_of(partial(master.solve, contacts, path, 1e-6))
        exact = master.solve(contacts, path, 1e-10).force
        true = float(np.abs(solution.force - exact).max())
        show(f"turning at ±{turn}", seconds, solution.force_error, true, 0.2, "" if solution.success else "NOT REACHED")
        # the paper's closure is another model beyond the first turn: what is measured is its own convergence
        finest = explicit_loop(contacts, path, 0.00125).force
        limit = 2.0 * finest - explicit_loop(contacts, path, 0.0025).force
        beside(partial(explicit_loop, contacts, path), limit, seconds, 1e-6)


def speeds() -> None:
    head("F_k at 200 speeds from 1e-6 to 1e4 in one call; goal: 200 ms")
    velocity = np.geomspace(1e-6, 1e4, 200)
    for law in ("soft", "stiff"):
        for t in (0.001, 0.1):
            contacts = Contacts(LAW, thermal=Thermal(law, t))  # type: ignore[arg-type]
            curve, seconds = best_of(partial(master.kinetic_curve, contacts, velocity))
            at = range(0, 200, 20)
            known = np.array([master.steady_state(contacts, velocity=float(velocity[i])).force for i in at])
            true = float(np.abs(curve.force[::20] - known).max())
            show(f"{law}, T = {t}", seconds, float(curve.force_error.max()), true, 0.2)
    for law, t in (("soft", 0.01), ("stiff", 0.1)):
        again = boltzmann_reforming(min(t, 0.05))
        contacts = Contacts(LAW, thermal=Thermal(law, t), reforming=again)  # type: ignore[arg-type]
        curve, seconds = best_of(partial(master.kinetic_curve, contacts, velocity))
        show(f"re-forming, {law}, T = {t}", seconds, float(curve.force_error.max()), np.nan, 0.2)
        _, seconds = best_of(partial(master.steady_state, contacts))
        show("    one steady state", seconds, float(curve.force_error.max()), np.nan, 0.05)
    paper = Contacts(LAW, thermal=Thermal("soft", 0.1, closure="paper"))
    known = np.array([master.steady_state(paper).force])
    _, seconds = best_of(partial(master.kinetic_curve, paper, velocity[100:101]))
    print("    one speed by the explicit scheme, run to its steady state at X = 20:")
    beside(partial(explicit, paper, [20.0]), known, seconds, 1e-9)


def main() -> None:
    steady_speeds()
    ageing()
    loops()
    speeds()


if __name__ == "__main__":
    main()
