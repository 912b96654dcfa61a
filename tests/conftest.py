"""What several test files share: the command in a process of its own, alone and under mpirun."""

import gc
import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import pytest

# what runs tests in the background ignores interrupts, and so would all that these start
signal.signal(signal.SIGINT, signal.default_int_handler)

# read when numpy is first imported: every worker has a core of its own, and idle BLAS threads would keep it busy
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

HANGS = 600.0  # s after which a process of its own is given up: far longer than any takes on a slow machine
ROOT = Path(__file__).parent.parent
LAUNCHER_VARIABLES = ("PMI_", "PMIX_", "OMPI_", "MPI_", "MV2_", "SLURM_", "HYDI_")
Runner = Callable[..., subprocess.CompletedProcess[str]]


def slow(*values: object, when: bool = True, **named: str) -> Any:
    """A case of a test that takes long, or that does `when` this holds."""
    return pytest.param(*values, marks=[pytest.mark.slow] * when, **named)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is collected stays, some 250,000 objects: looking through them for garbage takes 2 s of 10, and again more
    while tests run."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        # objects, of 700 by default: to look for garbage so often takes 1 % of the time of all tests
        gc.set_threshold(20_000)
        gc.enable()


def clean_environment(**extra: str) -> dict[str, str]:
    """This process's environment without any launcher's variables, the repository importable and compiled once."""
    left_out = (*LAUNCHER_VARIABLES, "PYTHONDONTWRITEBYTECODE")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(left_out)}
    return {**kept, "PYTHONPATH": str(ROOT), **extra}


@pytest.fixture(autouse=True, scope="session")
def _compiled_before() -> Generator[None, None, None]:
    """What commands say does not tell whether they are the first to compile, nor how fast the machine is."""
    with pytest.MonkeyPatch.context() as patch:
        # s; an event can wait no infinite time
        patch.setattr("toolkit.running.progress.PATIENCE", 1e6)
        patch.setattr("toolkit.running.rules.SECONDS", 1e6)
        yield


@pytest.fixture(autouse=True, scope="session")
def _compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Generator[None, None, None]:
    """Workers that need a kernel at the same time wait for the one that compiles it, and take it from disk: else each
    compiles it, and of two kernels of one function that are kept at once, one is lost and compiled again."""
    if sys.platform == "win32":  # where files have other locks
        yield
        return
    import fcntl

    from numba.core.dispatcher import Dispatcher

    alone, shared = Dispatcher.compile, tmp_path_factory.getbasetemp().parent
    held = set[str]()  # a function that calls itself does not wait for itself

    def in_turn(self: Any, signature: Any) -> Any:
        name = f"{self.py_func.__module__}.{self.py_func.__qualname__}"
        if not hasattr(self._cache, "_cache_file") or name in held:
            return alone(self, signature)
        with (shared / f"{name}.compiling").open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            held.add(name)
            try:
                return alone(self, signature)
            finally:
                held.discard(name)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Dispatcher, "compile", in_turn)
        yield


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are composed, but not rendered, which often takes longer than all the rest: where no test looks at the
    file. Those of each kind are rendered in test_pictures and test_verdict."""
    from matplotlib.figure import Figure

    def save(_: Figure, path: Path, **__: object) -> None:
        path.write_bytes(b"composed")

    monkeypatch.setattr(Figure, "savefig", save)


@pytest.fixture
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A test works in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def ended(command: list[str], folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """A process of its own in a folder; it does not say that it compiles either."""
    own = clean_environment(**environment)
    asked = {"cwd": folder, "env": own, "timeout": HANGS, "stdin": subprocess.DEVNULL}
    done = subprocess.run(command, capture_output=True, text=True, **asked)
    slow = r"^mesofriction: .*, after \d+:\d\d:\d\d\n"
    done.stderr = re.sub(slow, "", done.stderr, flags=re.MULTILINE)
    return done


@pytest.fixture
def python(tmp_path: Path) -> Runner:
    """python(code, *words, **environment): run code in a fresh interpreter, in an empty folder."""

    def run(code: str, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
        return ended([sys.executable, "-c", code, *words], tmp_path, **environment)

    return run


@pytest.fixture
def mpirun(tmp_path: Path) -> Runner:
    """mpirun(ranks, code, *words): the same on several ranks, oversubscribed where need be."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    launcher = shutil.which("mpiexec", path=path)
    if launcher is None or importlib.util.find_spec("mpi4py") is None:
        pytest.skip("needs the extra [mpi]")
    more = {"OMPI_MCA_rmaps_base_oversubscribe": "1"}
    more |= {"PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe"}

    def run(ranks: int, code: str, *words: str) -> subprocess.CompletedProcess[str]:
        words = (launcher, "-n", str(ranks), sys.executable, "-c", code, *words)
        return ended([*words], tmp_path, **more)

    return run
