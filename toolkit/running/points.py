"""A sweep over keys of the scene: its points spread over ranks and over processes, and kept for a run that goes on."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.processes.ranks import on_root
from toolkit.results.points import SweepRecord
from toolkit.running.point import Column
from toolkit.running.pool import Answer, Job, Solved, solve_by_ranks
from toolkit.scene.scene import Scene, read_scene
from toolkit.scene.tables import to_toml
from toolkit.version import __version__

_ROWS = "points.jsonl"


def solve_points(
    scene: Scene,
    comm: Any = None,
    kept: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SweepRecord:
    """Solve every point of the scene's sweep. All ranks of `comm` must call; each gets the whole record.

    Ranks take points from a pool as they are free; each has as many processes as its share of the node's cores.
    A point's numbers are those of the same solve wherever it is done. In the folder `kept` rank 0 keeps finished points
    as they come, by what they depend on: another launch, on any number of ranks, solves those that are missing.
    """
    grid: Any = scene.grid
    given = read_scene(scene).tables
    jobs, keys = list[Job](), list[str]()
    for point in grid.points:
        tables = grid.tables(given, point)
        folder = str(scene.folder.resolve())
        jobs.append(Job(scene.name, to_toml(tables), tables, folder, grid.critical_spring))
        keys.append(_identity(jobs[-1]))
    done: dict[str, Any] = on_root(comm, lambda: {} if kept is None else earlier_points(kept))
    missing = [k for k, key in enumerate(keys) if key not in done]
    one_at_a_time = threading.Lock()  # points of other ranks are told by a thread of the pool
    with _keeping(kept if comm is None or comm.Get_rank() == 0 else None) as keep:

        def tell(one: Solved) -> None:
            with one_at_a_time:
                done[key := keys[missing[one.number]]] = [one.answer, one.seconds]
                keep(key, one.answer, one.seconds)
                if progress is not None:
                    progress(len(done), len(jobs))

        solve_by_ranks([jobs[k] for k in missing], comm, tell)
    done = on_root(comm, lambda: done)
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
    text = ""
    with suppress(FileNotFoundError):
        text = (home / _ROWS).read_text(encoding="utf-8", errors="replace")
    for line in text.splitlines():
        with suppress(ValueError, TypeError):
            key, answer, seconds = json.loads(line)
            found[key] = [{name: Column(*cell) for name, cell in answer.items()}, seconds]
    return found


def forget_points(home: Path) -> None:
    """Remove the points that are kept, once the result is written."""
    with suppress(OSError):
        (home / _ROWS).unlink(missing_ok=True)
        home.rmdir()


@contextmanager
def _keeping(home: Path | None) -> Iterator[Callable[[str, Answer, float], None]]:
    """A function that adds a finished point to the file of them; whatever ends the work is told where points are."""
    if home is None:
        yield lambda key, answer, seconds: None
        return
    home.mkdir(parents=True, exist_ok=True)
    try:
        with (home / _ROWS).open("a", encoding="utf-8") as stream:
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
