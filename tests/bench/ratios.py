"""CPU times beside what a user would pick instead: one table of ratios, where the toolkit is behind first.

    python tests/bench/ratios.py

The calls of a row are made in turn, so that what else the machine does slows all alike; a time is the median of CPU
times of one thread, without imports and compilation. A ratio above 1 says how many times longer the other takes.
Mesa, voles and FLAKE (flake-rigid) are the extra [bench].
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
import rivals
import scipy
from phase_type import gaussian_force
from speed import ENSEMBLES

import eq_model
import master
import origins
from eq_model.closest import closest
from master.paper.explicit import explicit

PATH = np.linspace(0.0, 5.0, 501)
LAW, RELAXED = origins.gaussian(1.0, 0.05), origins.Contacts(origins.gaussian(1.0, 0.05))
SPREAD = origins.Contacts(LAW, origins.gaussian_start(0.0, 0.025))
ROUNDS, ENOUGH = 7, 0.3  # runs of a call at most, and s of CPU time after which no other is made


class Way(NamedTuple):
    """A way to an answer: who, the call, its error from the answer, and what the time is divided by (breaks)."""

    who: str
    call: Callable[[], Any]
    error: Callable[[Any], float]
    share: Callable[[Any], float] = lambda found: 1.0


class Line(NamedTuple):
    """Times in s of the toolkit and of another way, and errors of both."""

    task: str
    who: str
    ours: float
    theirs: float
    our_error: float
    their_error: float

    @property
    def ratio(self) -> float:
        return self.theirs / self.ours


def measured(task: str, ours: Way, others: list[Way]) -> list[Line]:
    """A line for each other way; one that is not installed is told and left out."""
    ways, kept = [ours], dict[str, tuple[float, float]]()
    errors, shares = {}, {}
    for way in [ours, *others]:
        try:
            found = way.call()
        except ImportError as missing:
            print(f"left out: {way.who} ({missing}); pip install -e '.[bench]'")
            continue
        errors[way.who], shares[way.who] = way.error(found), way.share(found)
        ways += [way] if way is not ours else []
    times: dict[str, list[float]] = {way.who: [] for way in ways}
    for _ in range(ROUNDS):
        for way in ways:
            if sum(times[way.who]) < ENOUGH or len(times[way.who]) < 1:
                began = time.process_time()
                way.call()
                times[way.who].append(time.process_time() - began)
    for way in ways:
        kept[way.who] = float(np.median(times[way.who])) / shares[way.who], errors[way.who]
    own, our_error = kept[ours.who]
    return [
        Line(task, way.who, own, kept[way.who][0], our_error, kept[way.who][1]) for way in ways[1:]
    ]


def forces() -> list[Line]:
    """F(X) of Fig. 2 (A02a) at 501 points."""
    exact = gaussian_force(PATH, 1.0, 0.05, 0.0, 0.025)

    def off(force: Any) -> float:
        return float(np.abs(getattr(force, "force", force) - exact).max())

    ours = Way("master", partial(master.solve, SPREAD, PATH, 1e-3), off)
    others = [
        Way("voles, 501 points", partial(rivals.by_voles, PATH, 1), off),
        Way("voles, 2,001 points", partial(rivals.by_voles, PATH, 4), off),
        Way("the paper's scheme, 800 steps", partial(explicit, SPREAD, PATH, 1.0 / 800), off),
        Way("solve_ivp, 800 upwind cells", partial(rivals.upwind, PATH, 800), off),
        Way("solve_ivp, 3,200 upwind cells", partial(rivals.upwind, PATH, 3200), off),
        Way("the closed form by hand", partial(gaussian_force, PATH, 1.0, 0.05, 0.0, 0.025), off),
    ]
    return measured("F(X), Fig. 2 (A02a)", ours, others)


def crowds() -> list[Line]:
    """A break of single contacts on a rigid slider, relaxed at first: time per break."""
    exact = gaussian_force(PATH, 1.0, 0.05)

    def off(found: Any) -> float:
        return float(np.abs((found[0] if isinstance(found, tuple) else found.force) - exact).max())

    simulate = partial(eq_model.simulate, RELAXED, PATH, seed=1, threads=1)
    ours = Way("ensemble", partial(simulate, n_contacts=1_000_000), off, lambda one: one.breaks)
    others = [
        Way("numba heap", partial(rivals.heap, PATH, 100_000), off, lambda one: one.breaks),
        Way("Mesa", partial(rivals.agents, PATH, 300), off, lambda one: one.breaks),
        Way(
            "the paper's algorithm, 1,000 contacts",
            partial(closest, RELAXED, PATH, n_contacts=1_000, seed=1),
            off,
            lambda found: 1_000 * float(PATH[-1]),
        ),
    ]
    return measured("a break", ours, others)


def numbers() -> list[Line]:
    """F_k and K* of relaxed contacts at T = 0, by scipy from their definitions, and barriers of islands."""

    def quadrature() -> float:
        return scipy.integrate.quad(lambda x: x**2 * LAW.pdf(x), 0.5, 1.5, epsabs=1e-10)[0] / 2.0

    def steepest() -> float:
        asked = {"bounds": (0.8, 1.2), "options": {"xatol": 1e-10}}
        return -scipy.optimize.minimize_scalar(lambda x: -x * LAW.pdf(x), **asked).fun - 1.0

    kinetic, stiffness = 0.5 * (1.0 + 0.05**2), steepest()
    found = measured(
        "F_k at T = 0",
        Way("master", lambda: master.steady_state(RELAXED).force, lambda f: abs(f - kinetic)),
        [Way("scipy's quad", quadrature, lambda f: abs(f - kinetic))],
    )
    found += measured(
        "K* at T = 0",
        Way(
            "master",
            lambda: master.propensity(RELAXED).critical_spring,
            lambda k: abs(k - stiffness),
        ),
        [Way("scipy's minimum of -x P_c(x)", steepest, lambda k: abs(k - stiffness))],
    )
    for long, wide in ((30, 20), (1000, 700)):
        island = 1.0, long, wide, 0.3
        exact = rivals.atomic_sums(*island)
        ours = partial(origins.triangular_barrier, *island)
        sums = Way("sums over atoms", partial(rivals.atomic_sums, *island), lambda b: 0.0)
        task = f"barrier of {long * wide:,} atoms"
        found += measured(task, Way("origins", ours, lambda b, e=exact: abs(b - e) / e), [sums])
    return found + maps()


def maps() -> list[Line]:
    """The barrier of an island on a hexagonal substrate, three waves, from a map of its energy over a cell."""
    island = 1.0, 30, 20, 0.3
    exact = float(origins.triangular_barrier(*island, origins.hexagonal_substrate()))

    def off(barrier: float) -> float:
        return abs(barrier - exact) / exact

    ours = partial(origins.triangular_barrier, *island, origins.hexagonal_substrate())
    others = [
        Way(f"FLAKE's map of {n} x {n} places", partial(rivals.by_flake, *island, n), off)
        for n in (30, 60)
    ]
    return measured("barrier of 600, 3 waves", Way("origins", ours, off), others)


def laws() -> list[Line]:
    """A break of contacts of every kind, beside a heap that knows none of their laws."""
    heap = Way(
        "numba heap, no law", partial(rivals.heap, PATH, 100_000), untold, lambda one: one.breaks
    )
    found = list[Line]()
    for name, (contacts, path, number) in ENSEMBLES.items():
        call = partial(eq_model.simulate, contacts, path, n_contacts=number, threads=1)
        ours = Way("ensemble", call, untold, lambda one: one.breaks)
        found += measured(f"a break: {name}", ours, [heap])
    return found


def untold(found: Any) -> float:
    """The error of what is compared for its time alone."""
    return float("nan")


def limits() -> list[str]:
    """What the machine can do at best, beside a break."""
    block, words = np.zeros(2**25), np.random.Generator(np.random.Philox(1))

    def seconds(call: Callable[[], Any]) -> float:
        call()
        found = []
        for _ in range(5):
            began = time.process_time()
            call()
            found.append(time.process_time() - began)
        return float(np.median(found))

    copied = 2.0 * block.nbytes / seconds(block.copy)
    word = seconds(partial(words.bit_generator.random_raw, 10**7)) / 1e7
    draw = seconds(partial(words.standard_normal, 10**7)) / 1e7
    found = eq_model.simulate(RELAXED, PATH, n_contacts=1_000_000, seed=1, threads=1)
    took = seconds(
        partial(eq_model.simulate, RELAXED, PATH, n_contacts=1_000_000, seed=1, threads=1)
    )
    each = took / found.breaks
    return [
        f"memory is copied at {copied / 1e9:.1f} GB/s, so that a contact of 16 bytes is read and written in "
        f"{32.0 / copied * 1e9:.1f} ns",
        f"numpy's Philox makes a 64-bit word in {word * 1e9:.2f} ns and a normal number in {draw * 1e9:.1f} ns",
        f"a break of the ensemble takes {each * 1e9:.1f} ns: {each / word:.1f} words",
    ]


def main() -> None:
    """Print the table, where the toolkit is behind first, then the limits of the machine."""
    lines = sorted([*forces(), *crowds(), *laws(), *numbers()], key=lambda line: line.ratio)
    behind = [line for line in lines if line.ratio < 1.0]
    print(f"the toolkit is behind in {len(behind)} of {len(lines)} rows, which stand first")
    print(
        f"{'':7}{'ratio':>9}  {'task':46}{'beside':38}{'ours':>9}{'theirs':>9}{'error':>9}{'theirs':>9}"
    )
    for line in lines:
        mark = "behind" if line.ratio < 1.0 else ""
        errors = f"{line.our_error:9.0e}{line.their_error:9.0e}"
        times = f"{line.ours:9.1e}{line.theirs:9.1e}"
        print(f"{mark:7}{line.ratio:9.3g}  {line.task:46}{line.who:38}{times}{errors}")
    print(
        "times in CPU-seconds (of a break: per break); errors in mean thresholds, of barriers relative"
    )
    print("\n".join(limits()))
    print(
        "FLAKE publishes no time of its maps (its paper: 10 to 50 times faster than an interpreted loop): measured here"
    )


if __name__ == "__main__":
    main()
