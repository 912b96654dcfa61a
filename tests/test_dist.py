"""The wheel, made from the sdist and installed without extras, on every Python from 3.11 to 3.13 that is there."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SECONDS = 900.0  # most that one command takes, a slow network among it
ASKED = """
import importlib.util as found, json, pathlib, sys
import eq_model, master, origins, toolkit
rooms = (eq_model, master, origins, toolkit)
extras = [name for name in ("mpi4py", "SurfaceTopography", "pytest", "tests") if found.find_spec(name)]
typed = all((pathlib.Path(room.__file__).parent / "py.typed").is_file() for room in rooms)
result = toolkit.run("gaussian")
force = master.steady_state(toolkit.load_scene("gaussian").contacts).force
print(json.dumps([sys.prefix, toolkit.__file__, extras, typed, force, len(result.eq.path)]))
"""


VERSIONS = ("3.11", "3.12", "3.13")


def python_of(version: str) -> str | None:
    """An interpreter of the version: on the PATH, or kept by pyenv; that of the tests, if it has it, else none."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    places = [*sorted(kept.glob(f"{version}.*/bin/python")), shutil.which(f"python{version}")]
    places += [sys.executable] if sys.version.startswith(f"{version}.") else []
    return next((str(place) for place in places if place and _answers(str(place))), None)


def _answers(python: str) -> bool:
    return (
        subprocess.run([python, "-c", "import ensurepip, venv"], capture_output=True).returncode
        == 0
    )


def call(*words: str | Path, at: Path) -> str:
    """What a command prints; it must end with status 0."""
    clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    done = subprocess.run(
        [str(word) for word in words],
        cwd=at,
        env=clean,
        capture_output=True,
        text=True,
        timeout=SECONDS,
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Made by `make dist` in a copy of what the repository holds, so that nothing that lies about comes in."""
    copy = tmp_path_factory.mktemp("dist") / "copy"
    call("git", "clone", "--quiet", ROOT, copy, at=ROOT)
    own = Path(sys.prefix)  # -o: the environment of these tests is not made anew for the copy
    call("make", "-o", own / ".ready", "dist", f"VENV={own}", at=copy)
    (made,) = (copy / "dist").glob("*.whl")
    assert len(list((copy / "dist").glob("*.tar.gz"))) == 1
    return made


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_wheel_runs_without_extras(version: str, wheel: Path, tmp_path: Path) -> None:
    if (python := python_of(version)) is None:
        pytest.skip(f"no Python {version}")
    call(python, "-m", "venv", "fresh", at=tmp_path)
    own = tmp_path / "fresh" / "bin"
    call(own / "python", "-m", "pip", "install", "--quiet", wheel, at=tmp_path)
    found = json.loads(call(own / "python", "-c", ASKED, at=tmp_path))
    prefix, place, extras, typed, force, points = found
    assert Path(prefix).resolve() == (tmp_path / "fresh").resolve()
    assert Path(place).is_relative_to(prefix) and not extras and typed
    assert force == pytest.approx(0.50125, abs=1e-9) and points == 501
    assert "gaussian" in call(own / "mesofriction", "scenes", at=tmp_path)
    out = call(own / "mesofriction", "run", "A13b", at=tmp_path)
    assert "written to" in out and (tmp_path / "delays-output" / "picture.png").is_file()
