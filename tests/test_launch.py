"""Ranks: who is counted, who speaks, and how all of them end."""

import json
import os
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import toolkit
from origins.errors import InputError
from toolkit.running.launch import Launch, read_environment
from toolkit.running.ranks import communicator, on_root

SCRIPT = "import sys; from toolkit.command import main; sys.exit(main())"
SMALL = """
title = "small"
[contacts.thresholds]
kind = "gaussian"
mean = 1.0
std = 0.05
[drive]
to = 2.0
points = 21
[master]
[eq]
contacts = 200
replicas = 4
"""


@pytest.fixture
def scene(tmp_path: Path) -> str:
    (tmp_path / "small.toml").write_text(SMALL)
    return "small.toml"


@pytest.mark.parametrize(
    ("environment", "launch"),
    [
        ({}, Launch(1, 0)),
        ({"PMI_SIZE": "4", "PMI_RANK": "3"}, Launch(4, 3)),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "1", "PMIX_RANK": "1"}, Launch(2, 1)),
        ({"SLURM_STEP_NUM_TASKS": "8", "SLURM_PROCID": "5"}, Launch(8, 5, "srun")),
        # with --mpi=pmi2; and mpirun, whose own daemons are a step, one a node
        ({"SLURM_STEP_NUM_TASKS": "4", "SLURM_PROCID": "1", "PMI_SIZE": "4", "PMI_RANK": "1"}, Launch(4, 1, "srun")),
        ({"SLURM_STEP_NUM_TASKS": "2", "SLURM_PROCID": "1", "PMI_SIZE": "8", "PMI_RANK": "5"}, Launch(8, 5)),
        # a batch script, alone on a machine given for 8 tasks
        ({"SLURM_NTASKS": "8", "SLURM_PROCID": "0"}, Launch(1, 0)),
        # mpirun inside a step of one task
        ({"SLURM_STEP_NUM_TASKS": "1", "SLURM_PROCID": "0", "PMI_SIZE": "4", "PMI_RANK": "2"}, Launch(4, 2)),
        # ranks of this node only: the whole launch counts
        ({"PMI_SIZE": "8", "PMI_RANK": "6", "MPI_LOCALNRANKS": "4", "MPI_LOCALRANKID": "2"}, Launch(8, 6)),
        ({"PMI_SIZE": "4"}, Launch(1, 0)),
        ({"PMI_SIZE": "four", "PMI_RANK": "0"}, Launch(1, 0)),
    ],
)
def test_environment_is_read(environment: dict[str, str], launch: Launch) -> None:
    assert read_environment(environment) == launch


def test_one_rank_needs_no_communicator() -> None:
    assert communicator(Launch(1, 0)) is None
    assert on_root(None, lambda: 3) == 3


def test_one_rank_under_mpirun_imports_no_mpi4py(mpirun, scene) -> None:
    planted = "import sys, toolkit.command; toolkit.command.main(); print('mpi4py' in sys.modules)"
    done = mpirun(1, planted, "run", scene)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "False"


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory):
    """The same scene in this process."""
    path = tmp_path_factory.mktemp("alone") / "small.toml"
    path.write_text(SMALL)
    return toolkit.run(path)


@pytest.mark.parametrize("ranks", [2])
def test_ranks_share_one_run_and_one_voice(ranks: int, mpirun, scene, alone, tmp_path: Path) -> None:
    done = mpirun(ranks, SCRIPT, "run", scene, "--out", "many")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["small", "master", "eq", "eq", "written"]
    many, one = toolkit.load(tmp_path / "many").eq, alone.eq
    assert many is not None and one is not None
    assert len(many.breaks_per_rank) == ranks and min(many.breaks_per_rank) > 0
    assert sum(many.breaks_per_rank) == many.breaks == one.breaks
    assert np.array_equal(many.force, one.force)
    assert np.array_equal(many.force_standard_error, one.force_standard_error)
    assert sorted(os.listdir(tmp_path)) == ["many", scene]


# several commands in one process after another, their words apart by "then"; each one's status and what it says
IN_TURN = """
import contextlib, io, json, sys
from toolkit.command import main
from toolkit.running.launch import read_environment
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
SPOKEN = ["scenes", "thresholds gaussian", "--help", "run --help"]
REFUSED = ["run nowhere.toml", "run small.toml --out small.toml/below", "run", "fly"]


def test_one_rank_speaks_for_all(mpirun, python, scene, tmp_path: Path) -> None:
    """Also of bad input, which is said once and leaves nothing behind."""
    words = " then ".join([*SPOKEN, *REFUSED])
    alone, together = python(IN_TURN, words), mpirun(2, IN_TURN, words)
    assert alone.returncode == together.returncode == 0 and together.stderr == ""
    told, _ = json.loads(alone.stdout)
    first, others = json.loads(together.stdout)
    assert first == told
    for status, out, error in told[: len(SPOKEN)]:
        assert status == 0 and len(out) > 1 and error == ""
    for status, out, error in told[len(SPOKEN) :]:
        assert status == 2 and out == [] and error != ""
    assert others == [[[status, [], ""] for status, _, _ in told]]
    assert sorted(os.listdir(tmp_path)) == ["gaussian-output", scene]


PLANTED = """
import sys
from mpi4py import MPI
import master, toolkit.command, toolkit.running.ranks
from origins.errors import InputError
real = master.solve
def solve(*arguments, **named):
    if MPI.COMM_WORLD.Get_rank() == 1:
        raise {}
    return real(*arguments, **named)
master.solve = solve
toolkit.running.ranks._PATIENCE = 0.3
sys.exit(toolkit.command.main())
"""


def test_bug_on_one_rank_ends_all(mpirun, scene, tmp_path: Path) -> None:
    done = mpirun(3, PLANTED.format("ZeroDivisionError('planted')"), "run", scene)
    assert done.returncode == 1
    assert done.stderr.count("Traceback (most recent call last)") == 1 and "ZeroDivisionError: planted" in done.stderr
    assert os.listdir(tmp_path) == [scene]


def test_bad_input_seen_by_one_rank_ends_all(mpirun, scene, tmp_path: Path) -> None:
    done = mpirun(2, PLANTED.format("InputError('only here')"), "run", scene)
    assert done.returncode == 2
    assert done.stderr.count("mesofriction: master: only here") == 1 and "Traceback" not in done.stderr
    assert os.listdir(tmp_path) == [scene]


def test_full_disk_on_rank_0_ends_all_alike(mpirun, scene, tmp_path: Path) -> None:
    planted = """
import sys, toolkit.command, toolkit.results.files
def full(result, path):
    raise OSError(28, "No space left on device")
toolkit.results.files._write_result = full
sys.exit(toolkit.command.main())
"""
    (tmp_path / scene).write_text(SMALL.partition("[eq]")[0])
    done = mpirun(2, planted, "run", scene)
    assert done.returncode == 2
    assert done.stderr == "mesofriction: out = 'small-output': cannot be written: No space left on device\n"
    assert os.listdir(tmp_path) == [scene]


def test_missing_mpi4py_is_one_line_in_total(mpirun, scene, tmp_path: Path) -> None:
    done = mpirun(3, f"import sys; sys.modules['mpi4py'] = None; {SCRIPT}", "run", scene)
    assert done.returncode == 2 and done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("mesofriction: mpirun: started 3 ranks, but mpi4py cannot be imported")
    assert os.listdir(tmp_path) == [scene]


def test_ranks_that_cannot_meet_are_not_lone_runs(python, scene, tmp_path: Path) -> None:
    # what a launcher of another MPI leaves behind: each process alone in its communicator
    pytest.importorskip("mpi4py")
    told = [
        python(SCRIPT, "run", scene, OMPI_COMM_WORLD_SIZE="2", OMPI_COMM_WORLD_RANK=str(rank)) for rank in (0, 1)
    ]
    assert [done.returncode for done in told] == [2, 2]
    assert told[0].stderr.startswith("mesofriction: mpirun: started 2 ranks, but mpi4py's MPI connects 1; ")
    assert len(told[0].stderr.splitlines()) == 1 and told[1].stderr == ""
    assert [done.stdout for done in told] == ["", ""] and os.listdir(tmp_path) == [scene]


def test_slurm_is_told_how_to_connect_ranks(monkeypatch: pytest.MonkeyPatch) -> None:
    alone = SimpleNamespace(COMM_WORLD=SimpleNamespace(Get_size=lambda: 1))
    monkeypatch.setitem(sys.modules, "mpi4py", SimpleNamespace(MPI=alone))
    with pytest.raises(InputError, match=r"^srun: started 8 ranks, but .* connects 1; .* --mpi=pmix or --mpi=pmi2"):
        communicator(Launch(8, 3, "srun"))


def test_root_refusal_reaches_every_rank(mpirun) -> None:
    done = mpirun(
        2,
        """
from mpi4py import MPI
from origins.errors import InputError
from toolkit.running.ranks import on_root
comm = MPI.COMM_WORLD
assert on_root(comm, lambda: comm.Get_rank() + 7) == 7
def refuse():
    raise InputError("no")
try:
    on_root(comm, refuse)
except InputError as error:
    everyone = comm.gather(str(error), root=0)
    if comm.Get_rank() == 0:
        print(everyone)
""",
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "['no', 'no']\n"
