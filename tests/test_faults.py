"""Faults that users met: wrong verdicts, results lost at the very end, tracebacks, work without an end in sight."""

import dataclasses
import os
import shutil
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

import master
import toolkit
from origins.errors import InputError
from toolkit.command import main
from toolkit.pictures.run import plot_force
from toolkit.pictures.thresholds import plain
from toolkit.results.folders import only_writer
from toolkit.running.progress import Progress
from toolkit.running.ranks import communicator
from toolkit.running.signals import Launch, Terminated, terminable
from toolkit.scene.interfaces import remarks
from toolkit.scene.kinds import from_samples
from toolkit.scene.tables import to_toml

GAUSSIAN = {"kind": "gaussian", "mean": 1.0, "std": 0.05}
SCENE: dict[str, Any] = {
    "contacts": {"thresholds": GAUSSIAN},
    "drive": {"to": 2.0, "points": 21},
    "master": {},
}
EQ = {"contacts": 400, "replicas": 2}


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(name: str = "mine", **tables: Any) -> str:
    Path(f"{name}.toml").write_text(to_toml(SCENE | tables))
    return f"{name}.toml"


def no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "toolkit.pictures.run.save_picture", lambda _, path: path.write_bytes(b"drawn")
    )


# -- what a scene says ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "column", "values"),
    [
        ("1;1.5\n2;1.7\n", 2, [1.5, 1.7]),
        ("1,5 2,5\n1,7 2,7\n", 1, [1.5, 1.7]),
        ("1,1.5\n2,1.7\n", 2, [1.5, 1.7]),
    ],
)
def test_decimal_commas_are_read_beside_another_separator(
    text: str, column: int, values: list[float], tmp_path: Path
) -> None:
    Path("own.txt").write_text(text)
    assert from_samples(tmp_path, file="own.txt", column=column).samples.tolist() == values


def test_a_far_drive_is_for_the_master_equation_alone() -> None:
    far = SCENE | {"drive": {"to": 5e6, "points": 3}}
    found = toolkit.run(far)
    assert found.success and "5e+06 mean thresholds" in found.notes[0]
    with pytest.raises(InputError, match=r"1e6 mean thresholds at most, or leave \[eq\] out"):
        toolkit.load_scene(far | {"eq": {}})


@pytest.mark.parametrize(
    ("table", "error", "status"),
    [({}, 3e-5, 0), ({}, 3e-2, 1), ({"tolerance": 1e-8}, 3e-5, 1)],
)
def test_a_tolerance_nobody_asked_for_is_not_missed(
    table: dict[str, float], error: float, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_picture(monkeypatch)
    real = master.solve

    def missing(*arguments: Any, **named: Any) -> Any:
        return dataclasses.replace(real(*arguments, **named), success=False, force_error=error)

    monkeypatch.setattr(master, "solve", missing)
    assert main(["run", write(master=table), "--out", "out"]) == status
    found = toolkit.load("out").master
    assert found is not None and found.success == (status == 0) and found.force_error == error


def test_missing_points_of_a_scan_are_told_with_their_rule() -> None:
    heights = np.random.default_rng(1).normal(size=(64, 64)) * 1e-9
    heights[::9, ::9] = np.nan
    import origins

    steel = origins.Material(contact_modulus=1e11, local_friction=0.1, shear_modulus=4e10)
    law = origins.from_topography(
        heights, 1e-8, model="gw", law="amontons", material=steel, pressure=1e6
    )
    (note,) = [one for one in remarks(law) if "missing" in one]
    assert note.startswith("1.6% of the scan's points are missing: a slope counts where")


def test_slips_are_drawn_where_they_are() -> None:
    from matplotlib.figure import Figure

    found = toolkit.run(SCENE | {"drive": {"to": 6.0, "points": 7, "spring": 1.0}})
    solved: Any = found.master
    line = plot_force(Figure().subplots(), found).get_lines()[0]
    x, y = line.get_data()
    assert solved.slips.drive.size >= 1
    for place, before, after in zip(
        solved.slips.drive, solved.slips.force_before, solved.slips.force_after, strict=True
    ):
        assert y[x == place].tolist() == [before, after]


# -- nothing is lost at the end -------------------------------------------------------------------------------


def test_no_damage_of_a_result_goes_unseen(monkeypatch: pytest.MonkeyPatch) -> None:
    no_picture(monkeypatch)
    toolkit.run(SCENE | {"eq": EQ}, folder="out")
    whole, draws = Path("out/result.h5").read_bytes(), np.random.default_rng(3)
    with h5py.File("out/result.h5") as store:  # any program of HDF5 reads it
        assert store.attrs["version"] == toolkit.__version__
    for place in [0, 20, 500, *draws.integers(0, len(whole), 50)]:
        flipped = bytes([whole[place] ^ 1 << draws.integers(8)])
        Path("out/result.h5").write_bytes(whole[:place] + flipped + whole[place + 1 :])
        with pytest.raises(InputError, match=r"its result\.h5 is not one of mesofriction"):
            toolkit.load("out")
    Path("out/result.h5").write_bytes(whole[:-40])
    with pytest.raises(InputError):
        toolkit.load("out")
    # and in the way of a new run it is replaced
    assert main(["run", write(), "--out", "out"]) == 0 and toolkit.load("out").name == "mine"


@pytest.mark.parametrize("kind", ["link", "storage"])
def test_data_in_other_files_are_not_read(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    no_picture(monkeypatch)
    toolkit.run(SCENE, folder="out")
    with h5py.File("out/result.h5") as store, h5py.File("old.h5", "w") as old:
        old.attrs.update(store.attrs)
        for name in store:
            store.copy(name, old)
        del old["master/force"]
        Path("secret").write_bytes(np.arange(21.0).tobytes())
        if kind == "link":
            old["master/force"] = h5py.ExternalLink("secret.h5", "/a")
        else:
            old["master"].create_dataset(
                "force", (21,), "f8", external=[("secret", 0, h5py.h5f.UNLIMITED)]
            )
    shutil.move("old.h5", "out/result.h5")
    with pytest.raises(InputError, match=r"are in another file"):
        toolkit.load("out")


def test_titles_that_are_no_formulas_are_drawn_as_they_are() -> None:
    assert plain("x^ $a_{$") == r"x^ \$a_{\$" and plain("$x_s$ of 3") == "$x_s$ of 3"
    assert main(["run", write(title="x^ $a_{$"), "--out", "out"]) == 0
    with pytest.raises(InputError, match=r"title = .*: holds"):
        toolkit.load_scene(SCENE | {"title": "a\x00b"})


def test_a_disk_that_refuses_is_found_out_before_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    real = Path.write_bytes

    def full(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    def never(*arguments: Any, **named: Any) -> None:
        raise AssertionError("it has begun")

    monkeypatch.setattr(Path, "write_bytes", full)
    monkeypatch.setattr(master, "solve", never)
    with pytest.raises(InputError, match="cannot be written: No space left"):
        toolkit.run(SCENE, folder="out")
    monkeypatch.setattr(Path, "write_bytes", real)
    assert os.listdir() == []


def test_a_finished_ensemble_stays_where_its_result_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:

    def refused(*arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    scene = write(master=None, eq=EQ)
    with monkeypatch.context() as patch:
        patch.setattr("toolkit.results.files.write_json", refused)
        assert main(["run", scene, "--out", "out"]) == 2 and os.listdir("out") == ["checkpoint"]
    assert main(["run", scene, "--out", "out"]) == 0
    found = toolkit.load("out")
    assert "went on from a checkpoint of 800 contacts" in found.notes[-1] and found.success
    assert not Path("out/checkpoint").exists()


def test_another_scenes_result_is_not_replaced_without_a_word(
    capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_picture(monkeypatch)
    assert (
        main(["run", write("one"), "--out", "out"])
        == 0
        == main(["run", write("one"), "--out", "out"])
    )
    assert capsys.readouterr().err == ""
    assert main(["run", write("two"), "--out", "out"]) == 0
    assert capsys.readouterr().err == (
        "mesofriction: out: holds the result of another scene, one, which this run will replace\n"
    )


def test_two_runs_do_not_write_to_one_folder(tmp_path: Path) -> None:
    with only_writer("out"):
        with pytest.raises(InputError, match="another run is writing there"):
            toolkit.run(SCENE, folder=tmp_path / "out")
        toolkit.run(SCENE, folder="other")
    toolkit.run(SCENE, folder="out")
    assert sorted(os.listdir()) == ["other", "out"]


# -- ranks and signals ----------------------------------------------------------------------------------------


class OtherRank:
    """Rank 1, which is told what rank 0 found."""

    def __init__(self, *found: Any) -> None:
        self.found = list(found)

    def Get_rank(self) -> int:
        return 1

    def Get_size(self) -> int:
        return 2

    def Ibarrier(self) -> Any:
        return SimpleNamespace(Test=lambda: True)

    def bcast(self, own: Any, root: int) -> Any:
        return self.found.pop(0), None


def test_files_are_those_of_rank_0(tmp_path: Path) -> None:
    Path("own.txt").write_text("1.0\n1.1\n")
    law = from_samples(tmp_path, file="own.txt", comm=OtherRank("2.0\n2.5\n"))
    assert law.samples.tolist() == [2.0, 2.5]
    text = to_toml(SCENE | {"title": "of rank 0"})
    scene = toolkit.load_scene(write(), comm=OtherRank(tmp_path / "mine.toml", text))
    assert scene.title == "of rank 0"


def test_sighup_keeps_a_checkpoint(monkeypatch: pytest.MonkeyPatch) -> None:
    def hang_up(done: int, expected: int) -> None:
        signal.raise_signal(signal.SIGHUP)

    with pytest.raises(Terminated) as stop, terminable():
        toolkit.run(
            SCENE | {"master": None, "eq": EQ | {"contacts": 40_000}},
            folder="out",
            progress=hang_up,
        )
    assert stop.value.__notes__ == [f"its finished blocks are kept in {Path('out/checkpoint')}"]
    assert os.listdir("out/checkpoint") == ["000-rank-00000.npz"]


TELLING = """
import json, os, signal, sys, time
from mpi4py import MPI
import eq_model, toolkit.command
real = eq_model.Ensemble.__iter__
def mortal(self):
    for number, found in enumerate(real(self)):
        if number == 3 and MPI.COMM_WORLD.Get_rank() == 1:
            os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)
        yield found
eq_model.Ensemble.__iter__ = mortal
sys.exit(toolkit.command.main(["run", "mine.toml", "--out", "out"]))
"""


def test_a_signal_to_one_rank_ends_all(mpirun: Callable[..., Any]) -> None:
    write(master=None, eq={"contacts": 60 << 14, "replicas": 1})
    done = mpirun(2, TELLING)
    assert done.returncode == 143, done.stderr
    assert (
        done.stderr == "mesofriction: terminated; its finished blocks are kept in out/checkpoint\n"
    )
    assert sorted(os.listdir("out/checkpoint")) == ["000-rank-00000.npz", "000-rank-00001.npz"]


# -- an end in sight ------------------------------------------------------------------------------------------


def test_what_the_ensemble_refuses_is_told_before_the_master_equation_is_solved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def never(*arguments: Any, **named: Any) -> None:
        raise AssertionError("it has begun")

    monkeypatch.setattr(master, "solve", never)
    with pytest.raises(InputError, match=r"^eq\.replicas"):
        toolkit.run(SCENE | {"eq": EQ | {"replicas": 1 << 30}})


@pytest.mark.parametrize("what", ["master", "sweep", "eq"])
def test_the_wall_time_is_that_of_all_solvers(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def for_ever(*arguments: Any, **named: Any) -> None:
        while True:
            pass

    monkeypatch.setattr(master, "solve", for_ever)
    monkeypatch.setattr(master, "kinetic_curve", for_ever)
    tables = {"master": None, "wall_time": 0.01}
    if what == "eq":
        found = toolkit.run(SCENE | tables | {"eq": EQ | {"contacts": 200_000}}).eq
        assert found is not None and not found.success and "stopped before all" in found.message
        return
    asked = {"master": {}, "sweep": {"velocity": [1.0, 2.0]}}[what]
    with pytest.raises(
        InputError, match=rf"^wall_time = 0\.01: is over before \[{what}\] is solved"
    ):
        toolkit.run(SCENE | tables | {what: asked})
    with pytest.raises(InputError, match=r"^wall_time = 0\.0: must be above zero"):
        toolkit.load_scene(SCENE | {"wall_time": 0.0})


class Ticks(threading.Event):
    """What a Progress waits for: as many waits pass as it is given functions, called before each ends."""

    def __init__(self, *turns: Callable[[], object]) -> None:
        super().__init__()
        self.turns, self.waits = list(turns), list[float | None]()

    def wait(self, timeout: float | None = None) -> bool:
        self.waits.append(timeout)
        if self.turns:
            self.turns.pop(0)()
        return not self.turns


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize("total", [1_000, 10])
def test_what_takes_over_a_minute_is_said_early(
    total: int, terminal: bool, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = {"now": 0.0}
    clock = SimpleNamespace(monotonic=lambda: seconds["now"])
    monkeypatch.setattr("toolkit.running.progress.time", clock)
    monkeypatch.setattr("sys.stderr.isatty", lambda: terminal)
    made = threading.Event()

    def work() -> None:
        assert made.wait(60.0)
        for now, done in ((0.5, 1), (2.5, 3)):
            seconds["now"] = now
            bar.count(done, total)

    ticks = Ticks(work, lambda: None)
    bar = Progress("eq", ticks)
    made.set()
    bar.close()
    said = "mesofriction: eq: 3 of 1,000 contacts (0%), 1 a second, 0:16:37 left, after 0:00:02"
    told = capsys.readouterr().err
    assert ticks.waits[0] == (1.0 if terminal else 2.0)
    if terminal:
        assert "3 of" in told and told.endswith("\r\033[K")
    else:
        assert told == (f"{said}\n" if total == 1_000 else "")


@pytest.mark.parametrize("command", ["compare", "thresholds", "precision"])
def test_the_wall_time_ends_other_commands_too(
    command: str, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def for_ever(*arguments: Any, **named: Any) -> None:
        while True:
            pass

    monkeypatch.setattr(master, "propensity", for_ever)
    monkeypatch.setattr(master, "solve", for_ever)
    assert main([command, write(wall_time=0.01)]) == 2 and os.listdir() == ["mine.toml"]
    (line,) = capsys.readouterr().err.splitlines()
    assert "wall_time = 0.01: is over before " in line


# -- no tracebacks --------------------------------------------------------------------------------


def one_line(capsys: Any, *words: str) -> str:
    """What is said of words that cannot be run."""
    assert main(list(words)) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert len(line) < 400
    return line


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
        ("a = " + "1" * 5000, "is not TOML"),
        ('title = "a\x00b"', "is not TOML"),
        ('title = "a\\u0000b"', "title"),
    ],
)
def test_odd_scenes_are_one_line(text: str, says: str, capsys: Any) -> None:
    Path("odd.toml").write_text(f"{text}\n{to_toml(SCENE)}")
    assert says in one_line(capsys, "run", "odd.toml")


@pytest.mark.parametrize("name", ["a" * 300, "a\x00b"])
def test_odd_names_are_one_line(name: str, capsys: Any) -> None:
    one_line(capsys, "run", name)
    one_line(capsys, "run", write(), "--out", name)


@pytest.mark.parametrize("file", ["a\x00b", "/dev/zero", "pipe", "gone.txt"])
@pytest.mark.parametrize("kind", ["samples", "scan"])
def test_odd_files_are_one_line(kind: str, file: str, capsys: Any) -> None:
    os.mkfifo("pipe")
    law: dict[str, Any] = {"kind": "from-samples", "file": file}
    if kind == "scan":
        steel = {"contact_modulus": 1e11, "local_friction": 0.1, "shear_modulus": 4e10}
        surface = {"kind": "scan", "file": file}
        law = {"kind": "from-topography", "model": "gw", "law": "amontons", "pressure": 1e6}
        law |= {"surface": surface, "material": steel}
    assert "file = " in one_line(capsys, "run", write(contacts={"thresholds": law}))


def test_what_is_no_table_is_not_shown(capsys: Any) -> None:
    Path("words.txt").write_text("user:secret:word\nother:secret:word\n")
    law = {"kind": "from-samples", "file": "words.txt"}
    line = one_line(capsys, "run", write(contacts={"thresholds": law}))
    assert "secret" not in line and "line 2 must hold one number" in line


def test_a_decimal_comma_alone_is_not_guessed(tmp_path: Path) -> None:
    Path("own.txt").write_text("1,5\n1,7\n")
    with pytest.raises(InputError, match="say which of the 2 columns"):
        from_samples(tmp_path, file="own.txt")


def test_a_path_that_ends_where_it_begins_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    soft = SCENE | {"drive": {"to": 2.0, "points": 21, "spring": 0.3}}
    real = master.solve

    def cut(*arguments: Any, **named: Any) -> Any:
        found = real(*arguments, **named)
        found.__dict__.update(path=np.empty(0), success=False, message="stopped at the first point")
        return found

    monkeypatch.setattr(master, "solve", cut)
    with pytest.raises(InputError, match="stopped at the first point"):
        toolkit.run(soft)


def test_kelvins_in_place_of_a_length_squared_are_told() -> None:
    import origins

    with pytest.warns(
        UserWarning, match=r"temperature is 299 <x_s\^2>: .* it is k_BT/<k>, a length squared"
    ):
        origins.Contacts(
            origins.gaussian(1.0, 0.05), thermal=origins.Thermal("soft", temperature=300.0)
        )


def test_an_mpi_that_does_not_load_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken:
        def __getattr__(self, name: str) -> Any:
            raise OSError("libmpi.so.12: cannot open shared object file")

    monkeypatch.setitem(sys.modules, "mpi4py", Broken())
    with pytest.raises(InputError, match="mpi4py cannot be imported"):
        communicator(Launch(2, 0))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_lost_terminal_ends_a_run_as_a_scheduler_does(number: int) -> None:
    with pytest.raises(Terminated), terminable():
        signal.raise_signal(number)
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup has it
    try:
        with terminable():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)
