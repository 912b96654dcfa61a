"""Start-up of the command: mesofriction --help in a fresh process, best of ten. Goal: 0.15 s."""

import subprocess
import sys
import time

GOAL = 0.15
COMMAND = [sys.executable, "-c", "from toolkit.command import main; main()", "--help"]


def main() -> None:
    times = []
    for _ in range(10):
        began = time.perf_counter()
        subprocess.run(COMMAND, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - began)
    print(
        f"mesofriction --help: {min(times):.3f} s, goal {GOAL} s: {'met' if min(times) <= GOAL else 'MISSED'}"
    )


if __name__ == "__main__":
    main()
