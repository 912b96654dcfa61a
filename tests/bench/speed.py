"""Speed of the master equation beside the paper's scheme, and of the command's start.

    python tests/bench/speed.py

Times are wall clock of warm calls, the best of several: run it on an idle machine. Kinds of ensembles are rows of
ratios.py. Every kind of call of master beside an older version: bench_before.py.
"""

import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import master
import origins
from master.paper.explicit import explicit

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from phase_type import gaussian_force

FRESH, WIDE = (
    origins.gaussian(1.0, 0.05),
    origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]),
)
SOFT = origins.Thermal("soft", 0.05)
LONG = np.linspace(0.0, 100.0, 501)
TURNING = np.concatenate([LONG / 2.0, LONG[::-1] / 2.0])
ENSEMBLES: dict[str, tuple[origins.Contacts, np.ndarray, int]] = {
    "gaussian, X = 100": (origins.Contacts(FRESH), LONG, 3_000_000),
    "mixture with a gap, X = 100": (origins.Contacts(WIDE), LONG, 3_000_000),
    "gaussian, X = 5": (origins.Contacts(FRESH), LONG / 20.0, 4_000_000),
    "soft contacts": (origins.Contacts(FRESH, thermal=SOFT), LONG, 1_000_000),
    "delay": (origins.Contacts(FRESH, delay=origins.Delay(0.2)), LONG, 300_000),
    "turning, soft": (origins.Contacts(FRESH, thermal=SOFT), TURNING, 100_000),
    "growing grains": (origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0)), LONG, 3_000),
    "ageing": (
        origins.Contacts(FRESH, ageing=origins.Ageing(origins.gaussian(1.2, 0.05), 1e-3)),
        LONG,
        10_000,
    ),
}


LOOPS = np.interp(np.linspace(0.0, 10.0, 201), np.arange(11), [0.0, 2.0] * 5 + [0.0])
ENSEMBLES |= {
    f"{name}, {kind}": (origins.Contacts(FRESH, **laws), path, 300_000)
    for name, laws in {
        "cold": {},
        "linked": {"stiffness": "linked"},
        "delay 0.2": {"delay": origins.Delay(0.2)},
    }.items()
    for kind, path in {"one turn": TURNING / 5.0, "nine turns 2 <x_s> apart": LOOPS}.items()
}


def best(call: Callable[[], Any], times: int = 5) -> float:
    """The shortest of the times of a call, seconds, after one that compiles and imports."""
    call()
    found = []
    for _ in range(times):
        began = time.perf_counter()
        call()
        found.append(time.perf_counter() - began)
    return min(found)


def main() -> None:
    """Print the tables."""
    print("master equation, Fig. 2 (A02a), 501 points to X = 5: ms, claimed and true error")
    path = np.linspace(0.0, 5.0, 501)
    scene = origins.Contacts(FRESH, origins.gaussian_start(0.0, 0.025))
    exact = gaussian_force(path, 1.0, 0.05, 0.0, 0.025)
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        call = partial(master.solve, scene, path, tolerance)
        true, claimed = np.abs(call().force - exact).max(), call().force_error
        name = f"solve, tolerance {tolerance:.0e}"
        print(f"{name:34s}{1e3 * best(call):10.2f}{claimed:12.1e}{true:12.1e}")
    for step in (0.01, 0.005, 0.0025):
        call = partial(explicit, scene, path, step, "survival")
        name, true = f"explicit, step {step}", np.abs(call().force - exact).max()
        print(f"{name:34s}{1e3 * best(call):10.2f}{'':12s}{true:12.1e}")
    words = [sys.executable, "-c", "from toolkit.command import main; main()", "--help"]
    start = best(partial(subprocess.run, words, check=True, stdout=subprocess.DEVNULL), 10)
    print(f"\nmesofriction --help: {start:.3f} s, goal 0.15 s")


if __name__ == "__main__":
    main()
