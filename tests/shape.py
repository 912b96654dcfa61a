"""The shape that the rooms keep: small files in small folders, and imports that go one way.

    python tests/shape.py       # part of `make lint`; exit status 1 where a limit is passed

Imports for type checking and those of a folder's __init__ count. What stands in one folder, files
and sub-folders, each taken as a whole, imports one another in one direction; in master that direction
is the one that RANKS names, and `master/paper` is imported by OF_PAPER alone. The lines of a room are
printed, and are no limit: a name, a blank line or a sentence is never saved for them.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LINES, FILES = 300, 20  # of a file, and in a folder

ROOMS = ("origins", "eq_model", "master", "toolkit")

# Files and folders of master from the lowest rank to the highest. A file imports those of its own rank and of lower
# ones. The paper's own schemes come last but one, so that nothing but `solve` is built on them; __init__, the public
# face, imports anything.
RANKS = (
    ("numerics", "motion", "outcome"),
    ("survival",),
    ("renewal",),
    ("solution", "rigid"),
    ("steady", "stick_slip", "soft"),
    ("paper",),
    ("solve",),
    ("rate_state",),
)
# Who imports the paper's own schemes, of all rooms: `solve`, which takes (Q15), and the face, which others ask.
OF_PAPER = ("master", "master.solve")
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


def within(folder: str, graph: Graph, files: dict[str, tuple[str, ast.Module]]) -> Graph:
    """What each file and sub-folder of a folder imports of its other files and sub-folders."""
    child: dict[str, str] = {}
    for file in files:
        if file.startswith(f"{folder}/"):
            child[module_of(file)] = folder + "/" + file[len(folder) + 1 :].split("/")[0]
    between: Graph = {name: set() for name in child.values()}
    for module, name in child.items():
        between[name] |= {child[to] for to in graph[module] if to in child} - {name}
    return between


def upward_imports(graph: Graph) -> Iterator[str]:
    """Imports of a higher rank within master, and files and folders without a rank, a line each."""
    rank = {name: number for number, names in enumerate(RANKS) for name in names}
    inner = {module: module.split(".")[1] for module in graph if module.startswith("master.")}
    for name in sorted(set(inner.values()) - set(rank)):
        yield f"{name}: has no rank; give it one in RANKS of tests/shape.py"
    for module, name in inner.items():
        for imported in sorted(graph[module]):
            lowest = rank.get(inner.get(imported, ""), -1)  # a part without a rank is told above
            if imported == "master" or lowest > rank.get(name, len(RANKS)):
                yield f"{module}: imports {imported}, which ranks above it"


def users_of_paper(files: dict[str, tuple[str, ast.Module]]) -> Iterator[str]:
    """Files outside of master/paper that import a file of it, but those that may, a line each."""
    for file, (_, tree) in files.items():
        module = module_of(file)
        nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
        lines = {ast.unparse(node) for node in nodes if "master.paper" in ast.unparse(node)}
        if module not in OF_PAPER and not module.startswith("master.paper"):
            yield from (f"{module}: {line}: ask the face, master, for it" for line in sorted(lines))


def faults(files: dict[str, tuple[str, ast.Module]]) -> Iterator[str]:
    """What passes a limit, a line each."""
    for file, (text, _) in files.items():
        lines = len(text.splitlines())
        if lines > LINES:
            yield f"{file}: {lines} lines, at most {LINES}"
    for folder, count in Counter(Path(file).parent.as_posix() for file in files).items():
        if count > FILES:
            yield f"{folder}: {count} files, at most {FILES}"
    graph = imports(files)
    for circle in circles(graph):
        yield f"import one another: {', '.join(sorted(circle))}"
    yield from upward_imports(graph)
    yield from users_of_paper(files)
    for folder in {Path(file).parent.as_posix() for file in files}:
        for circle in circles(within(folder, graph, files)):
            if any(not name.endswith(".py") for name in circle):  # circles of files: see above
                yield f"folders that import one another: {', '.join(sorted(circle))}"


def main() -> int:
    """Print the lines, constants and faults of each room; 1 where there are any faults."""
    found: list[str] = []
    for name in ROOMS:
        files = trees(ROOT / name)
        lines = sum(len(text.splitlines()) for text, _ in files.values())
        count = sum(constants(tree) for _, tree in files.values())
        print(f"{name}: {lines} lines, {count} constants")
        found += [f"{name}: {fault}" for fault in faults(files)]
    print(*found, sep="\n", end="\n" if found else "")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
