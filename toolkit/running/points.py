"""A sweep over keys of the scene: its points spread over ranks and over processes, and kept for a run that goes on."""

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from queue import Empty, Queue
from typing import Any, NamedTuple

import numpy as np

from toolkit.processes.ranks import cores_of, on_root
from toolkit.results.points import SweepRecord
from toolkit.running.point import Column, solve_point
from toolkit.scene.scene import Scene, read_scene
from toolkit.scene.tables import to_toml
from toolkit.version import __version__

# s of work left from which other processes are started: each imports for a second or two
WORTH = 6.0
_ROWS = "points-rank-{:05d}.jsonl"

Answer = dict[str, Column]


class Job(NamedTuple):
    """A point to solve, for this process or another: the scene there, its text and its tables, the folder to which its
    files are relative, and whether the critical spring is asked for, too."""

    name: str
    text: str
    tables: dict[str, Any]
    folder: str
    springs: bool


def solve_points(
    scene: Scene,
    comm: Any = None,
    kept: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SweepRecord:
    """Solve every point of the scene's sweep. All ranks of `comm` must call; each gets the whole record.

    Rank r takes every size-th point from the r-th on; each rank has as many processes as its share of the node's cores.
    A pool of mpi4py.futures (MPICommExecutor, which needs no spawn) would replace one line of these by ten, as one rank
    still needs the processes, and keeps rank 0 from work, as it deals the points out: on a node of two cores 16 points
    of a slider in heat took 120 s on two ranks and 77 s on three, by such a pool 141 and 108 s.
    A point's numbers are those of the same solve wherever it is done. In the folder `kept` finished points are kept as
    they come, by what they depend on: another launch, on any number of ranks, solves those that are missing.
    """
    grid: Any = scene.grid
    given = read_scene(scene).tables
    jobs, keys = list[Job](), list[str]()
    for point in grid.points:
        tables = grid.tables(given, point)
        folder = str(scene.folder.resolve())
        jobs.append(Job(scene.name, to_toml(tables), tables, folder, grid.critical_spring))
        keys.append(_identity(jobs[-1]))
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    done: dict[str, Any] = on_root(comm, lambda: {} if kept is None else earlier_points(kept))
    missing = [k for k, key in enumerate(keys) if key not in done]
    mine, total = missing[rank::size], len(jobs)
    with ExitStack() as stack:
        keep = stack.enter_context(_keeping(kept, rank))
        for number, (k, answer, seconds) in enumerate(
            _solved([jobs[k] for k in mine], cores_of(comm)), 1
        ):
            done[keys[mine[k]]] = [answer, seconds]
            keep(keys[mine[k]], answer, seconds)
            if progress is not None:
                progress(min(total - len(missing) + number * size, total), total)
    on_root(comm, lambda: None)  # waits without keeping a core busy
    if comm is not None:
        for other in comm.allgather({keys[k]: done[keys[k]] for k in mine}):
            done |= other
    return _record(scene, [done[key] for key in keys])


def _identity(job: Job) -> str:
    """What tells a point's numbers from others': the scene at the point, the files that it names, and the version."""
    whole = sha256(f"{__version__} {job.springs} {job.text}".encode())
    for file in _files(job.tables):
        with suppress(OSError):
            whole.update((Path(job.folder) / file).read_bytes())
    return whole.hexdigest()[:32]


def _files(table: Any) -> Iterator[str]:
    """The files that the tables of a scene name."""
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        if isinstance(value, dict | list):
            yield from _files(value)
        elif key == "file" and isinstance(value, str):
            yield value


def earlier_points(home: Path) -> dict[str, Any]:
    """Answers and times of the points that earlier launches finished, by identity; a line cut short is left out."""
    found = dict[str, Any]()
    for file in sorted(home.glob(_ROWS.format(0).replace("00000", "*"))):
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            with suppress(ValueError, TypeError):
                key, answer, seconds = json.loads(line)
                found[key] = [{name: Column(*cell) for name, cell in answer.items()}, seconds]
    return found


def forget_points(home: Path) -> None:
    """Remove the points that are kept, once the result is written."""
    with suppress(OSError):
        for file in home.glob(_ROWS.format(0).replace("00000", "*")):
            file.unlink(missing_ok=True)
        home.rmdir()


@contextmanager
def _keeping(home: Path | None, rank: int) -> Iterator[Callable[[str, Answer, float], None]]:
    """A function that adds a finished point to this rank's file; whatever ends the work is told where points are."""
    if home is None:
        yield lambda key, answer, seconds: None
        return
    home.mkdir(parents=True, exist_ok=True)
    try:
        with (home / _ROWS.format(rank)).open("a", encoding="utf-8") as stream:
            stream.write("\n")  # after a line cut short

            def keep(key: str, answer: Answer, seconds: float) -> None:
                stream.write(json.dumps([key, answer, seconds]) + "\n")
                stream.flush()

            yield keep
    except BaseException as stop:
        stop.add_note(
            f"its finished points are kept in {home}, from which the same command goes on"
        )
        raise


def _solved(jobs: list[Job], cores: int) -> Iterator[tuple[int, Answer, float]]:
    """Number, answer and seconds of each job as it is done: here, and by other processes too where that pays."""
    began = time.monotonic()
    for k, job in enumerate(jobs):
        remaining = (time.monotonic() - began) / max(k, 1) * (len(jobs) - k)
        if k and cores > 1 and remaining > WORTH:
            yield from _by_processes(jobs, k, min(cores, len(jobs) - k))
            return
        started = time.monotonic()
        yield k, solve_point(*job), time.monotonic() - started


def _by_processes(jobs: list[Job], first: int, count: int) -> Iterator[tuple[int, Answer, float]]:
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
                answers.put((k, answer, time.monotonic() - started))
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


def _record(scene: Scene, found: list[Any]) -> SweepRecord:
    """The table of all points."""
    grid: Any = scene.grid
    points = grid.points
    columns = {key: np.array([point[key] for point in points]) for key in grid.values}
    names = dict.fromkeys(name for answer, _ in found for name in answer if name != "message")
    units = dict[str, str]()
    for name in [*names, "message"]:
        there = next((answer[name] for answer, _ in found if name in answer), Column(""))
        empty = Column("" if isinstance(there.value, str) else np.nan)
        columns[name] = np.array([answer.get(name, empty).value for answer, _ in found])
        units[name] = there.unit
    missed = np.flatnonzero(columns["message"] != "")
    said = (
        f"{missed.size} of {len(found)} points are not as asked, the first at "
        if missed.size
        else ""
    )
    if missed.size:
        where = ", ".join(f"{key} = {value}" for key, value in points[missed[0]].items())
        said += f"{where}: {columns['message'][missed[0]]}"
    seconds = sum(took for _, took in found)
    return SweepRecord(tuple(grid.values), columns, units, seconds, not missed.size, said)
