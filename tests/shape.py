"""The shape that the rooms keep: small files in small folders, imports that go down, few constants.

    python tests/shape.py       # part of `make lint`; exit status 1 where a limit is passed

Lines are counted after `ruff format` at 100 columns, on a copy. Imports for type checking and
those of a folder's __init__ count. A room that is larger than it shall be in the end may only shrink.
"""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from shutil import copytree
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
LINES, FILES = 300, 20  # of a file, and in a folder


class Room(NamedTuple):
    """Lines of a room, and names in capital letters that its modules set: in the end, and at most today."""

    lines: int
    lines_today: int
    constants: int
    constants_today: int


ROOMS = {
    "master": Room(7500, 7500, 200, 143),
    "eq_model": Room(2200, 3161, 60, 43),
    "origins": Room(4500, 5801, 120, 68),
    "toolkit": Room(4000, 4000, 100, 63),
}
Graph = dict[str, set[str]]


def trees(room: Path) -> dict[str, tuple[str, ast.Module]]:
    """Text and syntax of all files, by their place in the repository."""
    found = {}
    for file in sorted(room.rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        found[file.relative_to(room.parent).as_posix()] = text, ast.parse(text)
    return found


def module_of(file: str) -> str:
    """The name by which a file is imported."""
    return file.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def imports(files: dict[str, tuple[str, ast.Module]]) -> Graph:
    """Which modules of the room each one imports; to import from a folder imports its __init__."""
    modules = {module_of(file) for file in files}
    graph: Graph = {}
    for file, (_, tree) in files.items():
        found: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                found.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                found |= inner & modules
                found |= {node.module} if inner - modules else set()
            elif isinstance(node, ast.ImportFrom):
                raise SystemExit(f"{file}: {ast.unparse(node)}: imports name the whole path")
        graph[module_of(file)] = (found & modules) - {module_of(file)}
    return graph


def circles(graph: Graph) -> list[set[str]]:
    """Sets of modules that import one another, each once."""
    reach = {name: set(to) for name, to in graph.items()}
    for middle in graph:
        for name in graph:
            if middle in reach[name]:
                reach[name] |= reach[middle]
    round_trips = {name: {to for to in reach[name] if name in reach[to]} for name in graph}
    return [set(names) for names in {frozenset(names) for names in round_trips.values() if names}]


def constants(tree: ast.Module) -> int:
    """Names of a module in capital letters that it sets."""
    found = 0
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        names = [name for target in targets for name in ast.walk(target)]
        found += sum(isinstance(name, ast.Name) and name.id.isupper() for name in names)
    return found


def faults(files: dict[str, tuple[str, ast.Module]], room: Room) -> Iterator[str]:
    """What passes a limit, a line each."""
    for file, (text, _) in files.items():
        lines = len(text.splitlines())
        if lines > LINES:
            yield f"{file}: {lines} lines, at most {LINES}"
    for folder, count in Counter(Path(file).parent.as_posix() for file in files).items():
        if count > FILES:
            yield f"{folder}: {count} files, at most {FILES}"
    for circle in circles(imports(files)):
        yield f"import one another: {', '.join(sorted(circle))}"
    lines, count = lines_and_constants(files)
    if lines > room.lines_today:
        yield f"{lines} lines, at most {room.lines_today}"
    if count > room.constants_today:
        yield f"{count} constants, at most {room.constants_today}"


def lines_and_constants(files: dict[str, tuple[str, ast.Module]]) -> tuple[int, int]:
    """Of all files together."""
    lines = sum(len(text.splitlines()) for text, _ in files.values())
    return lines, sum(constants(tree) for _, tree in files.values())


def main() -> int:
    """Print lines, constants and faults of each room; 1 where there are any faults."""
    found: list[str] = []
    for name, limits in ROOMS.items():
        with tempfile.TemporaryDirectory() as folder:
            room = Path(copytree(ROOT / name, Path(folder) / name))
            ruff = [sys.executable, "-m", "ruff", "format", "--quiet", "--line-length", "100"]
            subprocess.run([*ruff, str(room)], check=True)
            files = trees(room)
        lines, count = lines_and_constants(files)
        print(
            f"{name}: {lines} lines ({limits.lines} in the end), {count} constants ({limits.constants})"
        )
        found += [f"{name}: {fault}" for fault in faults(files, limits)]
    print(*found, sep="\n", end="\n" if found else "")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
