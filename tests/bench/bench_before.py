"""Run times of master beside those of commit ee6a1b9, from before it was rebuilt, by kind of call.

    python tests/bench/bench_before.py [kind ...]

Both trees answer the same calls of tests/oracle in turn, each in a process of its own that has
compiled and imported what it needs, so that what else the machine does slows both alike. A line a
kind: the median and the worst ratio of the shortest times, this tree's to the older one's; 2 means
twice as slow. Below 2 ms both count as 2 ms. Without a kind some calls of each are asked.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
COMMIT = "ee6a1b9"
PER_KIND, RUNS = 8, 4  # calls of a kind where none is named, and runs of each in each tree
LONGEST = 3.0  # s that a kept answer took, of those that are asked
SERVE = """
import sys
from oracle.judge import give
for call in sys.stdin:
    found = give("", call.rstrip("\\n"))
    print(found.seconds if found.success else "nan", flush=True)
"""


def serve(tree: Path) -> subprocess.Popen[str]:
    """A process that answers calls by a tree: a line with the seconds for each line with a call."""
    environment = {**os.environ, "PYTHONPATH": f"{tree}:{ROOT / 'tests'}", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", SERVE]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=tree, env=environment, stdin=pipe, stdout=pipe, text=True)


def seconds(process: subprocess.Popen[str], call: str) -> float:
    """Run times of a call."""
    assert process.stdin and process.stdout
    print(call, file=process.stdin, flush=True)
    return max(float(process.stdout.readline()), 2e-3)


def main(kinds: list[str]) -> None:
    """Print the table."""
    sys.path.insert(0, str(ROOT / "tests"))
    from oracle.judge import load

    kept = [one for one in load().values() if one.success and one.seconds < LONGEST]
    with tempfile.TemporaryDirectory() as folder:
        older = Path(folder) / "older"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(older), COMMIT], check=True)
        try:
            trees = [serve(ROOT), serve(older)]
            for kind in kinds or sorted({one.kind for one in kept}):
                calls = [one.call for one in kept if one.kind == kind]
                ratios, every = [], 1 if kinds else -(-len(calls) // PER_KIND)
                for call in calls[::every]:
                    runs = [[seconds(tree, call) for tree in trees] for _ in range(RUNS)]
                    ours, theirs = np.min(runs[1:], axis=0)
                    ratios.append(ours / theirs)
                told = f"{np.nanmedian(ratios):6.2f} median {np.nanmax(ratios):6.2f} worst"
                print(f"{kind:16s} {len(ratios)} calls {told}", flush=True)
            for tree in trees:
                tree.terminate()
        finally:
            subprocess.run([*git, "remove", "--force", str(older)], check=True)


if __name__ == "__main__":
    main(sys.argv[1:])
