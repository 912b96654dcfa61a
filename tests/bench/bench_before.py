"""CPU times of master beside those of an older commit, by kind of call.

    python tests/bench/bench_before.py [--commit f1a81316] [kind ...]

Unless one is named the commit is ee6a1b9, from before master was rebuilt. Both trees answer the
same calls of tests/oracle in turn, each in a process of its own that has compiled and imported
what it needs, so that what else the machine does slows both alike. A line a kind: the median and
the worst ratio of the shortest times, this tree's to the older one's, 2 means twice as slow; how
many calls both answer; and which is the worst. Below 2 ms both count as 2 ms. Without a kind some
calls of each are asked.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PER_KIND, RUNS = 8, 4  # calls of a kind where none is named, and runs of each in each tree
LONGEST = 3.0  # s that a kept answer took, of those that are asked
SERVE = """
import sys
import time
from oracle.judge import give
for call in sys.stdin:
    begin = time.process_time()
    found = give("", call.rstrip("\\n"))
    print(time.process_time() - begin if found.success else "nan", flush=True)
"""


def serve(tree: Path) -> subprocess.Popen[str]:
    """A process that answers calls by a tree: a line with the CPU seconds for each call."""
    environment = {**os.environ, "PYTHONPATH": f"{tree}:{ROOT / 'tests'}", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", SERVE]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=tree, env=environment, stdin=pipe, stdout=pipe, text=True)


def seconds(process: subprocess.Popen[str], call: str) -> float:
    """CPU time of a call; nan where it is not answered."""
    assert process.stdin and process.stdout
    print(call, file=process.stdin, flush=True)
    return max(float(process.stdout.readline()), 2e-3)


def main(commit: str, kinds: list[str]) -> None:
    """Print the table."""
    sys.path.insert(0, str(ROOT / "tests"))
    from oracle.judge import load

    kept = {name: one for name, one in load().items() if one.success and one.seconds < LONGEST}
    with tempfile.TemporaryDirectory() as folder:
        older = Path(folder) / "older"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(older), commit], check=True)
        try:
            trees = [serve(ROOT), serve(older)]
            for kind in kinds or sorted({one.kind for one in kept.values()}):
                names = [name for name, one in kept.items() if one.kind == kind]
                ratios, every = {}, 1 if kinds else -(-len(names) // PER_KIND)
                for name in names[::every]:
                    runs = [[seconds(tree, kept[name].call) for tree in trees] for _ in range(RUNS)]
                    ours, theirs = np.min(runs[1:], axis=0)
                    if np.isfinite(ours / theirs):
                        ratios[name] = ours / theirs
                if not ratios:
                    print(f"{kind:16s} 0 calls", flush=True)
                    continue
                worst = max(ratios, key=ratios.__getitem__)
                told = f"{np.median([*ratios.values()]):6.2f} median {ratios[worst]:6.2f} worst"
                print(f"{kind:16s} {len(ratios)} calls {told} {worst}", flush=True)
            for tree in trees:
                tree.terminate()
        finally:
            subprocess.run([*git, "remove", "--force", str(older)], check=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--commit", default="ee6a1b9")
    parser.add_argument("kinds", nargs="*", metavar="kind")
    asked = parser.parse_args()
    main(asked.commit, asked.kinds)
