"""Points of a sweep solved by all ranks, and by as many processes of each as it has cores."""

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import suppress
from queue import Empty, Queue
from typing import Any, NamedTuple

from origins.errors import InputError
from toolkit.processes.ranks import cores_of
from toolkit.processes.signals import Terminated
from toolkit.running.point import Column, solve_point

# s of work left from which other processes are started: each imports for a second or two
WORTH = 6.0
# shares in which a rank of several cores gets what is its part of the points: a kill loses those that are begun
SHARES = 4
# What ended the work of this rank: the pool of ranks tells it to rank 0 alone, and all of them have to end.
_ended = list[BaseException]()

Answer = dict[str, Column]


class Job(NamedTuple):
    """A point to solve, for this process or another: the scene there, its text and its tables, the folder to which its
    files are relative, and whether the critical spring is asked for, too."""

    name: str
    text: str
    tables: dict[str, Any]
    folder: str
    springs: bool


class Solved(NamedTuple):
    """The job of this number: its answer, and the time that it took in s."""

    number: int
    answer: Answer
    seconds: float


def solve_by_ranks(jobs: list[Job], comm: Any, tell: Callable[[Solved], None]) -> None:
    """Solve all jobs, and tell of each as it is done on rank 0; on the others nothing is told.

    The pool of mpi4py.futures deals jobs from the first on to the other ranks as they are free; rank 0 withdraws the
    last ones that nobody has begun, and solves them itself.
    """
    cores, size = cores_of(comm), 1 if comm is None else comm.Get_size()
    if size == 1:
        for one in _solved(jobs, cores):
            tell(one)
        return
    from mpi4py.futures import MPICommExecutor

    # a rank with several cores gets many jobs at once, as its processes start anew for each share
    even = -(-len(jobs) // size)
    share = 1 if cores == 1 else min(max(cores, even // SHARES), even)
    dealing: Any = MPICommExecutor(comm, root=0)
    with dealing as pool:
        if pool is not None:
            _deal(pool, jobs, share, cores, tell)
    if _ended:
        raise _ended.pop()


def _deal(
    pool: Any, jobs: list[Job], share: int, cores: int, tell: Callable[[Solved], None]
) -> None:
    """Let the pool's ranks and this one solve the jobs, so many at a time."""
    failed = threading.Event()

    def tell_all(ready: Future[list[Solved]]) -> None:
        """Called by a thread of the pool, also while this rank solves a job of its own."""
        if ready.cancelled():
            return
        if ready.exception() is not None:
            failed.set()
            return
        for one in ready.result():
            tell(one)

    dealt = dict[Future[list[Solved]], int]()
    try:
        for first in range(0, len(jobs), share):
            given = pool.submit(_share, jobs[first : first + share], first, cores)
            given.add_done_callback(tell_all)
            dealt[given] = first
        for given, first in reversed(dealt.items()):
            if not failed.is_set() and given.cancel():
                for one in _solved(jobs[first : first + share], cores, first):
                    tell(one)
        for given in dealt:
            if not given.cancelled():
                given.result()
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise


def _share(jobs: list[Job], first: int, cores: int) -> list[Solved]:
    """What another rank solves for rank 0: these jobs, the first of which has the number `first` among all."""
    try:
        return list(_solved(jobs, cores, first))
    except (InputError, KeyboardInterrupt, Terminated) as end:
        _ended.append(end)
        raise


def _solved(jobs: list[Job], cores: int, first: int = 0) -> Iterator[Solved]:
    """Each job as it is done: here, and by other processes too where that pays; they are numbered from `first` on."""
    began = time.monotonic()
    for k, job in enumerate(jobs):
        remaining = (time.monotonic() - began) / max(k, 1) * (len(jobs) - k)
        if k and cores > 1 and remaining > WORTH:
            for one in _by_processes(jobs, k, min(cores, len(jobs) - k)):
                yield one._replace(number=first + one.number)
            return
        started = time.monotonic()
        yield Solved(first + k, solve_point(*job), time.monotonic() - started)


def _by_processes(jobs: list[Job], first: int, count: int) -> Iterator[Solved]:
    """The jobs from the first on, by so many processes, each of which takes the next one once it is free."""
    waiting, answers = Queue[int](), Queue[Any]()
    for k in range(first, len(jobs)):
        waiting.put(k)
    command = [sys.executable, "-m", "toolkit.running.worker"]
    environment = {
        **os.environ,
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    workers = [subprocess.Popen(command, env=environment, **pipes) for _ in range(count)]

    def next_one() -> int | None:
        with suppress(Empty):
            return waiting.get_nowait()
        return None

    def serve(worker: Any) -> None:
        with suppress(OSError, ValueError):  # where it was killed, at the end
            while (k := next_one()) is not None:
                started = time.monotonic()
                worker.stdin.write(json.dumps(jobs[k]) + "\n")
                worker.stdin.flush()
                cells = json.loads(worker.stdout.readline())
                answer = {name: Column(*cell) for name, cell in cells.items()}
                answers.put(Solved(k, answer, time.monotonic() - started))
            return
        answers.put(None)

    try:
        for worker in workers:
            threading.Thread(target=serve, args=[worker], daemon=True).start()
        for _ in range(first, len(jobs)):
            if (answer := answers.get()) is None:
                raise RuntimeError("a process that solves points of the sweep has ended; see above")
            yield answer
    finally:
        for worker in workers:
            worker.kill()
            worker.wait()
