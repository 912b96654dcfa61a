"""What a scene does not name is not imported."""

import inspect
import json
import re
import subprocess
import sys

import pytest
from conftest import HANGS, clean_environment

import eq_model
import master
import origins
import toolkit
from toolkit.scene.scene import shipped_scenes

HEAVY = ["numba", "ase", "mpi4py", "matplotlib", "SurfaceTopography", "scipy.stats", "h5py"]


@pytest.fixture(scope="module")
def told() -> dict[str, tuple[float, list[str]]]:
    """By scene: the largest force of the master equation, and what is imported once it has been solved, after those
    before it in one process."""
    code = """
import json, sys, tomllib
import toolkit
from toolkit.scene.scene import SHIPPED, shipped_scenes
told = {}
for name in shipped_scenes():
    tables = tomllib.loads((SHIPPED / f"{name}.toml").read_text())
    tables.pop("eq", None)
    result = toolkit.run(tables)
    told[name] = float((result.master or result.sweep).force.max()), sorted(sys.modules)
print(json.dumps(told))
"""
    words = [sys.executable, "-c", code]
    done = subprocess.run(
        words, env=clean_environment(), capture_output=True, text=True, timeout=HANGS
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", shipped_scenes())
def test_master_alone_needs_no_heavy_package(
    name: str, told: dict[str, tuple[float, list[str]]]
) -> None:
    force, modules = told[name]
    assert 0.0 < force < 2.0
    assert not set(HEAVY) & set(modules)


def test_importing_a_room_imports_no_heavy_package(python) -> None:
    for room in ["origins", "master", "eq_model", "toolkit"]:
        done = python(f"import sys, {room}; print(*sorted(sys.modules))")
        assert done.returncode == 0, done.stderr
        assert not set(HEAVY) & set(done.stdout.split())


@pytest.mark.parametrize("words", ["--help", "--version", "run --help"])
def test_help_imports_no_package_at_all(words: str, python) -> None:
    done = python(
        """
import sys
from toolkit.command import main
try:
    main(sys.argv[1:])
except SystemExit as end:
    print(*sorted(sys.modules))
    sys.exit(end.code)
""",
        *words.split(),
    )
    assert done.returncode == 0, done.stderr
    assert "mesofriction" in done.stdout
    modules = done.stdout.splitlines()[-1].split()
    assert not {*HEAVY, "numpy", "scipy", "msgspec", "origins"} & set(modules)


def test_rooms_keep_their_arrows(python) -> None:
    rooms = {"origins", "master", "eq_model", "toolkit"}
    for room, allowed in {"origins": set(), "master": {"origins"}, "eq_model": {"origins"}}.items():
        done = python(
            f"""
import importlib, pkgutil, sys, {room}
for module in pkgutil.walk_packages({room}.__path__, "{room}."):
    importlib.import_module(module.name)
print(*sorted(sys.modules))
"""
        )
        assert done.returncode == 0, done.stderr
        assert rooms & set(done.stdout.split()) <= {room, *allowed}


def test_help_of_the_public_face_is_readable() -> None:
    """numpy's aliases are unions of protocols, which help() writes out unless annotations stay as written."""
    unreadable = []
    unions = re.compile(r"_Supports|_Nested|dtype\[|_Buffer")

    def visit(name: str, thing: object) -> None:
        if inspect.isclass(thing):
            for key, member in vars(thing).items():
                if key == "__init__" or not key.startswith("_"):
                    visit(f"{name}.{key}", member.fget if isinstance(member, property) else member)
        elif inspect.isfunction(thing) and unions.search(str(inspect.signature(thing))):
            unreadable.append(name)

    for room in (origins, master, eq_model, toolkit):
        for name in room.__all__:
            visit(f"{room.__name__}.{name}", getattr(room, name))
    assert unreadable == []
