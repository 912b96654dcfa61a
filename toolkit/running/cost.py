"""What a scene costs beside its answer: imports, memory and time of each stage, told by a fresh process, and what the
scene left out. `python -m toolkit.running.cost SCENE CHANGES` is that process; it prints a Cost as JSON."""

import json
import os
import re
import resource
import subprocess
import sys
import time
import tomllib
from collections.abc import Mapping
from importlib import import_module, metadata
from pathlib import Path
from typing import Any

ROOMS = ("origins", "master", "eq_model", "toolkit")
_EXTRAS = re.compile(r"extra == .(?!mpi|topography|xarray)")  # what tests, lint and pages need
_IN_MB = 1e3 if sys.platform != "darwin" else 1e6  # units of the system's peak memory in a MB

Cost = dict[str, Any]


def cost(scene: str, changes: Mapping[str, Any] | None = None) -> Cost:
    """Run the scene once in a process of its own, writing nothing.

    Returns `title`; `stages`, each with its `name`, `seconds` on the clock, `cpu_seconds`, with those of worker
    processes, which are `by_workers`, peak `memory` in MB by its end of that process which held most, and the
    third-party `packages` that it imported; `rooms`, of each the
    numbers of its files that were imported and of all, which of eq_model are more where numba's cache holds kernels of
    other laws, whose files it imports; what it `builds` and `runs`, the latter by its run time in s; and, left out,
    `no_laws`, `no_solvers`, `no_packages`.
    Raises InputError as a run does.
    """
    from origins.errors import InputError

    # -P: no folder named as one of the rooms in the current folder takes its place
    words = [sys.executable, "-P", "-m", "toolkit.running.cost", scene, json.dumps(changes or {})]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True)
    found: Cost = json.loads(done.stdout.splitlines()[-1])
    if "refused" in found:
        raise InputError(found["refused"])
    return found


def cost_lines(found: Cost) -> list[str]:
    """The cost as lines of text."""
    lines = [found["title"]]
    for stage in found["stages"]:
        packages = ", ".join(stage["packages"]) or "no further package"
        told = [f"{stage['seconds']:.2f} s", f"{stage['memory']:.0f} MB at most"]
        if stage["by_workers"]:
            told.insert(1, f"{stage['cpu_seconds']:.2f} CPU-seconds with those of worker processes")
        lines.append(f"{stage['name']:9}{', '.join(told)}; imports {packages}")
    rooms = [f"{room} {some} of {all_} files" for room, (some, all_) in found["rooms"].items()]
    runs = [f"{name} {seconds:.2g} s" for name, seconds in found["runs"].items()]
    unused = [*found["no_solvers"], *found["no_laws"], *found["no_packages"]]
    lines += [f"code     imported of {', '.join(rooms)}", f"builds   {', '.join(found['builds'])}"]
    rest = "; the rest of the run is imports, and compilation of what no run has compiled yet"
    if found["stages"][-1]["by_workers"]:
        rest = " by the clock, in all processes together, which work beside each other"
    lines += [f"runs     {', '.join(runs)}{rest}", f"left out {', '.join(unused) or 'nothing'}"]
    return [*lines, "the scene ran once in a process of its own; nothing was written"]


def _measured(scene: str, changes: Mapping[str, Any]) -> Cost:
    """Run the scene here; see `cost`."""
    homes, stages, seen = metadata.packages_distributions(), list[Any](), set[str]()
    wanted = [line for line in metadata.requires("mesofriction") or [] if not _EXTRAS.search(line)]
    required = {match[0].lower() for line in wanted if (match := re.match(r"[\w.-]+", line))}
    # modules of the distributions that are asked for; such as mpich have none
    wanted_by = {name: of[0] for name, of in homes.items() if of[0].lower() in required}
    began, used = time.perf_counter(), os.times()

    def done(name: str) -> None:
        nonlocal began, used
        now, whose = os.times(), (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        stage: dict[str, Any] = {"name": name, "seconds": time.perf_counter() - began}
        stage["cpu_seconds"] = sum(now[:4]) - sum(used[:4])
        stage["by_workers"] = sum(now[2:4]) - sum(used[2:4])
        stage["memory"] = max(resource.getrusage(one).ru_maxrss for one in whose) / _IN_MB
        there = {of for name, of in wanted_by.items() if name in sys.modules}
        stages.append(stage | {"packages": sorted(there - seen)})
        seen.update(there)
        began, used = time.perf_counter(), os.times()

    import_module("toolkit.commands")  # as `mesofriction run` does
    from toolkit.running.runner import solve
    from toolkit.scene.laws import CONTACTS
    from toolkit.scene.scene import load_scene

    done("start-up")
    loaded = load_scene(scene, changes=changes)
    done("scene")
    result, _ = solve(loaded, None)
    done("run")
    tables = tomllib.loads(loaded.text)["contacts"]
    builds = [f"{name} {_kind(table)}".strip() for name, table in tables.items()]
    answers = {name: getattr(result, name) for name in ("master", "eq", "sweep")}
    return {
        "title": loaded.title or loaded.name,
        "stages": stages,
        "rooms": {room: _files_of(room) for room in ROOMS},
        "builds": builds,
        "runs": {name: one.run_time for name, one in answers.items() if one is not None},
        "no_solvers": [f"[{name}]" for name in ("master", "eq") if answers[name] is None],
        "no_laws": [law for law in CONTACTS if law not in ("start", *tables)],
        "no_packages": sorted({*wanted_by.values()} - seen),
    }


def _kind(table: Any) -> str:
    """What a table of the contacts names: its kind or its law; or the value of a key."""
    return str(table.get("kind", table.get("law", "")) if isinstance(table, dict) else table)


def _files_of(room: str) -> tuple[int, int]:
    """How many files of a room are imported, and how many it has."""
    here = Path(__file__).parents[2] / room
    some = sum(name.partition(".")[0] == room for name in sys.modules)
    return some, sum(1 for _ in here.rglob("*.py"))


if __name__ == "__main__":
    from origins.errors import InputError

    try:
        result = _measured(sys.argv[1], json.loads(sys.argv[2]))
    except InputError as error:
        result = {"refused": str(error)}
    print(json.dumps(result))
