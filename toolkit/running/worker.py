"""A process that solves points of a sweep: `python -m toolkit.running.worker` reads one a line, and answers each.

A process of its own, and no thread or fork: the solvers hold Python's lock, and a fork of a process with threads may
hang. It ends with its input, so also where the process that gives it work is killed.
"""

import json
import os
import signal
import sys


def main() -> None:
    """Answer until the input ends; Ctrl-C is for the process that gives the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers, sys.stdout = sys.stdout, sys.stderr  # what a library prints is no answer
    from toolkit.running.point import solve_point

    for line in sys.stdin:
        answer = json.dumps(solve_point(*json.loads(line)))
        try:
            print(answer, file=answers, flush=True)
        except BrokenPipeError:  # nobody is left to answer
            os._exit(1)


if __name__ == "__main__":
    main()
