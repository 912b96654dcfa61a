"""The master equation beside commit ee6a1b9, from before it was rebuilt: ratios of run times by kind.

    python tests/bench/bench_before.py [all] [kind ...]

Both trees answer the same calls (tests/oracle, and those of `single_calls`) in turn, each in a
process of its own that has compiled and imported what it needs, so that what else the machine does
slows both alike. The older tree is a `git worktree` in a temporary folder, run by this interpreter.
Of each kind up to a dozen cases are asked, or `all`. A line a kind: the median and the worst ratio
of the shortest times, this tree's to the older one's; 2 means twice as slow. Below 2 ms both count
as 2 ms. Of an answer that fails there is no ratio.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

COMMIT = "ee6a1b9"
ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
PER_KIND = 12  # cases of a kind
RUNS = 5  # of a call in each tree, and at least two
BUDGET = 3.0  # s for the runs of one call in one tree
LONGEST = 20.0  # s that a kept answer may have taken, to be among the dozen
MOST = 120  # s after which a call has failed
MEDIAN, WORST = 1.5, 10.0  # ratios that a kind is to keep to


class Single(NamedTuple):
    """A call that has a limit of its own: ratio to the older tree, or seconds."""

    case: Any
    ratio: float
    seconds: float = np.inf


def single_calls() -> dict[str, Single]:
    """Calls that are asked to be fast one by one."""
    from oracle.case import Answer, Case, along_turns, force_along, steady_force

    import master
    import origins

    law, wide = origins.gaussian(mean=1.0, std=0.05), origins.gaussian(mean=1.0, std=0.2)
    start = origins.gaussian_start(mean=0.0, std=0.025)
    path = np.linspace(0.0, 5.0, 501)
    soft = origins.Contacts(law, thermal=origins.Thermal("soft", temperature=0.1))
    stiff = origins.Contacts(law, thermal=origins.Thermal("stiff", temperature=0.1))
    speeds = np.geomspace(1e-6, 1e4, 200)
    rates = np.random.default_rng(1).uniform(0.2, 3.0, 300)
    steps = np.linspace(0.0, 6.0, 301)

    def curve() -> Answer:
        found = master.kinetic_curve(soft, speeds)
        return Answer(found.force, found.force_error, True)

    def named(name: str, answer: Any, ratio: float, seconds: float = np.inf) -> Single:
        return Single(Case(name, "single", answer), ratio, seconds)

    calls = [
        named("plain, 1e-10", force_along(lambda: origins.Contacts(law), path, 1e-10), 2.5),
        named("Gaussian", force_along(lambda: origins.Contacts(law, start), path, 1e-10), 2.5),
        named("200 speeds of F_k", curve, 2.5),
        named("one steady state", steady_force(lambda: soft), MEDIAN),
        named(
            "300 velocity steps, soft",
            force_along(
                lambda: origins.Contacts(wide, thermal=origins.Thermal("soft", temperature=0.1)),
                steps,
                time=np.append(0.0, (np.diff(steps) / rates).cumsum()),
            ),
            WORST,
            5.0,
        ),
        named(
            "stiff, three turns",
            force_along(lambda: stiff, along_turns([0.0, 1.6, -0.7, 1.2, -1.0], 81), 1e-8),
            WORST,
            5.0,
        ),
    ]
    return {single.case.name: single for single in calls}


def answer_loop() -> None:
    """In each tree: read the names of cases, answer them, and print the seconds."""
    import warnings

    from oracle.cases import all_cases
    from oracle.judge import give

    import master

    tree = Path(sys.argv[2]).resolve()
    if tree not in Path(master.__file__).resolve().parents:
        raise SystemExit(f"{master.__file__} is not of {tree}")
    warnings.simplefilter("ignore")
    cases = {case.name: case for case in all_cases()}
    cases |= {name: single.case for name, single in single_calls().items()}
    print("ready", flush=True)
    for line in sys.stdin:
        begin = time.perf_counter()
        answer = give(cases[line.rstrip("\n")], longest=MOST)
        print(answer.seconds if answer.success else "nan", time.perf_counter() - begin, flush=True)


class Tree:
    """One tree, that answers cases in a process of its own."""

    def __init__(self, folder: Path) -> None:
        environment = {
            **os.environ,
            "PYTHONPATH": f"{folder}{os.pathsep}{TESTS}",
            "OMP_NUM_THREADS": "1",
        }
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).resolve()), "--answer", str(folder)],
            cwd=folder,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        if self._read() != ["ready"]:
            raise SystemExit(f"{folder}: its cases could not be read")

    def _read(self) -> list[str]:
        assert self._process.stdout is not None
        return self._process.stdout.readline().split()

    def seconds(self, name: str) -> tuple[float, float]:
        """How long the case took, nan where it failed; and how long that took."""
        assert self._process.stdin is not None
        print(name, file=self._process.stdin, flush=True)
        answered, took = self._read()
        return float(answered), float(took)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


@contextmanager
def older_tree() -> Iterator[Path]:
    """The older commit in a folder of its own; ends with a word where the history lacks it."""
    git = ["git", "-C", str(ROOT)]
    known = subprocess.run([*git, "cat-file", "-e", f"{COMMIT}^{{commit}}"], capture_output=True)
    if known.returncode:
        raise SystemExit(
            f"commit {COMMIT} is not in this history, which may be shallow; `git fetch --unshallow` "
            "brings it"
        )
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "older"
        subprocess.run([*git, "worktree", "add", "--detach", "--quiet", tree, COMMIT], check=True)
        try:
            yield tree
        finally:
            subprocess.run([*git, "worktree", "remove", "--force", tree], check=True)


def best_times(name: str, trees: tuple[Tree, Tree]) -> tuple[float, float]:
    """The shortest time in each tree, one run after the other; the first warms up."""
    first = [tree.seconds(name) for tree in trees]
    slow = max(took for _, took in first)
    if slow > BUDGET or np.isnan([answered for answered, _ in first]).any():
        return first[0][0], first[1][0]
    times = [[tree.seconds(name)[0] for tree in trees] for _ in range(max(2, RUNS))]
    return min(before for before, _ in times), min(here for _, here in times)


def asked(words: list[str]) -> dict[str, list[str]]:
    """Names of the cases to ask, by kind."""
    from oracle.judge import load

    found: dict[str, list[str]] = {}
    kinds = [word for word in words if word != "all"]
    for name, given in load(TESTS / "oracle" / "answers.npz").answers.items():
        if given.success and (given.seconds < LONGEST or "all" in words):
            found.setdefault(given.kind, []).append(name)
    if "all" not in words:
        found = {kind: names[:: -(-len(names) // PER_KIND)] for kind, names in found.items()}
    return {kind: names for kind, names in found.items() if not kinds or kind in kinds}


def main(words: list[str]) -> None:
    """Print a line for each kind, and for each single call."""
    sys.path.insert(0, str(TESTS))
    from oracle.judge import LEAST_TIME

    singles = single_calls()
    with older_tree() as folder:
        trees = Tree(folder), Tree(ROOT)
        try:
            if not words or "single" in words:
                print(f"{'call':28s} {COMMIT:>9s} {'here':>9s}  ratio")
                for name, single in singles.items():
                    before, here = best_times(name, trees)
                    ratio = max(here, LEAST_TIME) / max(before, LEAST_TIME)
                    kept = ratio <= single.ratio and here <= single.seconds
                    limit = f"at most {single.ratio:g} times"
                    limit += f" and {single.seconds:g} s" if np.isfinite(single.seconds) else ""
                    told = limit if kept or np.isnan(ratio) else f"OVER: {limit}"
                    print(
                        f"{name:28s} {before:8.3f}s {here:8.3f}s {ratio:6.2f}  {told}", flush=True
                    )
            print(f"{'kind':18s} cases  median  worst")
            for kind, names in asked(words).items():
                ratios = {}
                for name in names:
                    before, here = np.maximum(best_times(name, trees), LEAST_TIME)
                    ratios[name] = here / before
                told = {name: ratio for name, ratio in ratios.items() if not np.isnan(ratio)}
                if not told:
                    continue
                worst, median = max(told, key=lambda name: told[name]), np.median([*told.values()])
                over = "OVER " if median > MEDIAN or told[worst] > WORST else ""
                numbers = f"{len(told):5d} {median:7.2f} {told[worst]:6.2f}"
                print(f"{kind:18s} {numbers}  {over}{worst}", flush=True)
        finally:
            for tree in trees:
                tree.close()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--answer"]:
        answer_loop()
    else:
        main(sys.argv[1:])
