"""Ranks: who is counted, who speaks, and how all of them end."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

import toolkit
from toolkit.running.signals import Launch, read_environment

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
        (
            {"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "1", "PMIX_RANK": "1"},
            Launch(2, 1),
        ),
        ({"SLURM_STEP_NUM_TASKS": "8", "SLURM_PROCID": "5"}, Launch(8, 5, "srun")),
        # with --mpi=pmi2; and mpirun, whose own daemons are a step, one a node
        (
            {"SLURM_STEP_NUM_TASKS": "4", "SLURM_PROCID": "1", "PMI_SIZE": "4", "PMI_RANK": "1"},
            Launch(4, 1, "srun"),
        ),
        (
            {"SLURM_STEP_NUM_TASKS": "2", "SLURM_PROCID": "1", "PMI_SIZE": "8", "PMI_RANK": "5"},
            Launch(8, 5),
        ),
        # a batch script, alone on a machine given for 8 tasks
        ({"SLURM_NTASKS": "8", "SLURM_PROCID": "0"}, Launch(1, 0)),
        # ranks of this node only: the whole launch counts
        (
            {"PMI_SIZE": "8", "PMI_RANK": "6", "MPI_LOCALNRANKS": "4", "MPI_LOCALRANKID": "2"},
            Launch(8, 6),
        ),
    ],
)
def test_environment_is_read(environment: dict[str, str], launch: Launch) -> None:
    assert read_environment(environment) == launch


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory):
    """The same scene in this process."""
    path = tmp_path_factory.mktemp("alone") / "small.toml"
    path.write_text(SMALL)
    return toolkit.run(path)


@pytest.mark.parametrize("ranks", [2])
def test_ranks_share_one_run_and_one_voice(
    ranks: int, mpirun, scene, alone, tmp_path: Path
) -> None:
    done = mpirun(ranks, SCRIPT, "run", scene, "--out", "many")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert [line.split()[0] for line in done.stdout.splitlines()] == [
        "small",
        "master",
        "eq",
        "eq",
        "written",
    ]
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
from toolkit.running.signals import read_environment
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
    assert done.stderr.count("Traceback (most recent call last)") == 1
    assert "ZeroDivisionError: planted" in done.stderr
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
        python(SCRIPT, "run", scene, OMPI_COMM_WORLD_SIZE="2", OMPI_COMM_WORLD_RANK=str(rank))
        for rank in (0, 1)
    ]
    assert [done.returncode for done in told] == [2, 2]
    assert told[0].stderr.startswith(
        "mesofriction: mpirun: started 2 ranks, but mpi4py's MPI connects 1; "
    )
    assert len(told[0].stderr.splitlines()) == 1 and told[1].stderr == ""
    assert [done.stdout for done in told] == ["", ""] and os.listdir(tmp_path) == [scene]
