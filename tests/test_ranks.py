"""Ranks: who is counted and who speaks, the same bits on any number of them, how all of them end, what they say."""

import json
import os
import pickle
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import slow
from rank_bits import told
from scenes import scene, write

import toolkit
from toolkit.processes.signals import Launch, read_environment
from toolkit.scene.tables import to_toml

GATHERED = "from tests.rank_bits import print_gathered; print_gathered()"
SCRIPT = "import sys; from toolkit.command import main; sys.exit(main())"


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write("small", title="small", eq={"contacts": 200, "replicas": 4})


@pytest.mark.parametrize(
    ("environment", "launch"),
    [
        ("", Launch(1, 0)),
        ("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=1 PMIX_RANK=1", Launch(2, 1)),
        ("SLURM_STEP_NUM_TASKS=8 SLURM_PROCID=5", Launch(8, 5)),
        # mpirun within a step: its own daemons are one, one a node
        ("SLURM_STEP_NUM_TASKS=2 SLURM_PROCID=1 PMI_SIZE=8 PMI_RANK=5", Launch(8, 5)),
        # a batch script, alone on a machine given for 8 tasks
        ("SLURM_NTASKS=8 SLURM_PROCID=0", Launch(1, 0)),
        # ranks of this node only: the whole launch counts
        ("PMI_SIZE=8 PMI_RANK=6 MPI_LOCALNRANKS=4 MPI_LOCALRANKID=2", Launch(8, 6)),
    ],
)
def test_environment_is_read(environment: str, launch: Launch) -> None:
    assert read_environment(dict(one.split("=") for one in environment.split())) == launch


def test_bits_do_not_depend_on_the_number_of_ranks(mpirun: Any) -> None:
    alone = list(told(None))
    assert len(alone) == 9 and alone[-1].startswith("temperature: ")
    done = mpirun(2, GATHERED)
    assert done.returncode == 0, done.stderr
    every = json.loads(done.stdout)
    assert len(every) == 2 and all(one == alone for one in every)


# several commands in one process after another, their words apart by "then"; each one's status and what it says
IN_TURN = """
import contextlib, io, json, sys
import toolkit.pictures.run, toolkit.running.progress
from toolkit.command import main
from toolkit.processes.signals import read_environment
# no picture, which takes longer than all else, and no word on kernels that are compiled
toolkit.pictures.run.save_picture = lambda result, path: path.touch()
toolkit.running.progress.PATIENCE = 1e6
told = []
for words in " ".join(sys.argv[1:]).split(" then "):
    streams = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
        try:
            status = main(words.split())
        except SystemExit as end:
            status = end.code
    # no two run times are the same
    out = [line for line in streams[0].getvalue().splitlines() if "run time" not in line]
    told.append([status, out, streams[1].getvalue()])
if read_environment().size == 1:
    print(json.dumps([told, []]))
else:
    from mpi4py import MPI
    every = MPI.COMM_WORLD.gather(told, root=0)
    if every:
        print(json.dumps([every[0], every[1:]]))
"""
SPOKEN = ["scenes", "thresholds gaussian", "--help", "run small.toml", "run small.toml --dry-run"]
REFUSED = ["run nowhere.toml", "run small.toml --out small.toml/below", "run", "fly"]


@pytest.mark.slow  # quick: bits on ranks, above, and points on ranks in test_points.py
def test_one_rank_speaks_for_all(mpirun: Any) -> None:
    """Also of bad input, which is said once and leaves nothing behind; the run is that of one process."""
    together = mpirun(2, IN_TURN, " then ".join([*SPOKEN, *REFUSED]))
    assert together.returncode == 0 and together.stderr == ""
    first, others = json.loads(together.stdout)
    for status, out, error in first[: len(SPOKEN)]:
        assert status == 0 and len(out) > 1 and error == ""
    for status, out, error in first[len(SPOKEN) :]:
        assert status == 2 and out == [] and error != ""
    assert others == [[[status, [], ""] for status, _, _ in first]]
    assert sorted(os.listdir()) == ["gaussian-output", "small-output", "small.toml"]
    many, one = toolkit.load("small-output").eq, toolkit.run("small.toml").eq
    assert len(many.breaks_per_rank) == 2 and np.array_equal(many.force, one.force)


PLANTED = """
import sys
from mpi4py import MPI
import master, toolkit.command
real = master.solve
def solve(*arguments, **named):
    if MPI.COMM_WORLD.Get_rank() == 1:
        raise ZeroDivisionError("planted")
    return real(*arguments, **named)
master.solve = solve
sys.exit(toolkit.command.main())
"""


@pytest.mark.slow  # quick: a signal to one rank, in test_survives.py
def test_bug_on_one_rank_ends_all(mpirun: Any) -> None:
    done = mpirun(2, PLANTED, "run", "small.toml")
    assert done.returncode == 1 and os.listdir() == ["small.toml"]
    assert done.stderr.count("Traceback (most recent call last)") == 1
    assert "ZeroDivisionError: planted" in done.stderr


@pytest.mark.parametrize(
    "broken",
    ["None", slow("type('Broken', (), {'__getattr__': lambda *_: open('libmpi.so.12')})()")],
)
def test_mpi_that_cannot_be_imported_is_one_line_in_total(broken: str, mpirun: Any) -> None:
    done = mpirun(2, f"import sys; sys.modules['mpi4py'] = {broken}; {SCRIPT}", "run", "small.toml")
    assert done.returncode == 2 and done.stdout == "" and os.listdir() == ["small.toml"]
    (line,) = done.stderr.splitlines()
    assert line.startswith(
        "mesofriction: mpirun or srun: started 2 ranks, but mpi4py cannot be imported"
    )


def test_ranks_that_cannot_meet_are_not_lone_runs(python: Any) -> None:
    # what a launcher of another MPI leaves behind: each process alone in its communicator
    pytest.importorskip("mpi4py")
    rank = {"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "0"}
    done = python(SCRIPT, "run", "small.toml", **rank)
    assert done.returncode == 2 and done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith(
        "mesofriction: mpirun or srun: started 2 ranks, but mpi4py's MPI connects 1; "
    )


# -- what ranks say to each other -----------------------------------------------------------------------


class Counted:
    """Rank 0 among `size` that did all the same: counts its calls, and the bytes it gives or gets in each; rank 1 where
    it is told what rank 0 `found`."""

    def __init__(self, size: int, *found: Any) -> None:
        self.size, self.rank, self.found = size, int(bool(found)), list(found)
        self.calls, self.bytes = Counter[str](), Counter[str]()

    def Get_rank(self) -> int:
        return self.rank

    def Get_size(self) -> int:
        return self.size

    def _count(self, name: str, many: int) -> None:
        self.calls[name] += 1
        self.bytes[name] += many

    def Iprobe(self, tag: int) -> bool:
        """Whether another rank was told to stop: no message leaves this rank."""
        return False

    def Ibarrier(self) -> Any:
        self._count("Ibarrier", 0)
        return SimpleNamespace(Test=lambda: True)

    def Split_type(self, kind: int) -> Any:
        """The ranks of this node, which say on which cores they may run: four of them."""
        self._count("Split_type", 0)
        return SimpleNamespace(allgather=lambda own: [own] * 4, Free=lambda: None)

    def Allreduce(self, own: Any, out: Any) -> None:
        self._count("Allreduce", own.nbytes)
        out[:] = own * self.size

    def allgather(self, own: Any) -> list[Any]:
        self._count("allgather", len(pickle.dumps(own)) * self.size)
        return [own] * self.size

    def bcast(self, own: Any, root: int) -> Any:
        self._count("bcast", len(pickle.dumps(own)))
        return (self.found.pop(0), None) if self.found else own


@pytest.mark.usefixtures("unrendered")
def test_calls_and_bytes_are_as_documented(tmp_path: Path) -> None:
    """In docs/clusters.md; forty times the contacts take as many. A tolerance takes a meeting for each doubling."""
    told = []
    for contacts, more in ((100 << 15, {}), (2000 << 16, {}), (64 << 15, {"tolerance": 1e-9})):
        comm, eq = Counted(100), {"contacts": contacts, "replicas": 1, **more}
        toolkit.run(
            scene(drive={"to": 5.0, "points": 51}, master=None, eq=eq),
            comm=comm,
            folder=tmp_path / "out",
        )
        told.append(comm)
    few, many, wanted = told
    assert (
        few.calls
        == many.calls
        == {
            "Ibarrier": 5,
            "bcast": 3,
            "Split_type": 1,
            "Allreduce": 1,
            "allgather": 2,
        }
    )
    assert few.bytes["Allreduce"] == many.bytes["Allreduce"] and few.bytes["Allreduce"] % 16 == 0
    assert few.bytes["bcast"] < 200 and few.bytes["allgather"] < 500 * 100
    rounds = wanted.calls["Allreduce"] - 1
    assert rounds >= 1
    assert wanted.calls["allgather"] == 2 + 3 * rounds
    assert wanted.calls["Ibarrier"] == 4 + rounds


def test_files_are_those_of_rank_0(tmp_path: Path) -> None:
    """A rank that reads other files than rank 0 would be another run."""
    Path("own.txt").write_text("1.0\n1.1\n")
    file = write("mine", thresholds={"kind": "from-samples", "file": "own.txt"})
    text = to_toml(scene({"kind": "from-samples", "file": "own.txt"}, title="of rank 0"))
    found = toolkit.load_scene(file, comm=Counted(2, tmp_path / "mine.toml", text, "2.0\n2.5\n"))
    assert found.title == "of rank 0" and found.contacts.thresholds.samples.tolist() == [2.0, 2.5]
