"""Scenes of rotated domains under mpirun: the ranks share the sampling, and the bits are those of one process."""

import json
from collections.abc import Callable
from typing import Any

import pytest

import toolkit
from toolkit.scene.toml import to_toml

SCENE = {
    "contacts": {
        "thresholds": {
            "kind": "mixture",
            "components": [
                {"kind": "domains", "lattice_constant": 3.88, "mean_atoms": 30.0, "stiffness": 1.0, "samples": 20_000},
                {"kind": "rectangular", "lower": 0.5, "upper": 1.0},
            ],
            "weights": [0.5, 0.5],
        }
    },
    "drive": {"to": 1.0, "points": 11},
    "eq": {"contacts": 300, "replicas": 2, "seed": 3},
}

PROGRAM = """
import json, sys
from mpi4py import MPI
import toolkit
from toolkit.scene.toml import to_toml
from origins import streams

drawn, real = [], streams.words
def counted(key, purpose, replica, contact, block):
    if purpose == streams.DOMAINS and block == 0:
        drawn.append(contact.size)
    return real(key, purpose, replica, contact, block)
streams.words = counted
comm = MPI.COMM_WORLD
run = toolkit.run(json.loads(sys.argv[1]), comm=comm)
bits = [float(x).hex() for x in (run.mean_threshold, *run.thresholds.survival[::10], *run.eq.force)]
every = comm.gather([bits, sum(drawn)])
if comm.Get_rank() == 0:
    print(json.dumps(every))
"""


@pytest.mark.parametrize("ranks", [2])
def test_ranks_share_the_domains_and_agree(ranks: int, mpirun: Callable[..., Any]) -> None:
    alone = toolkit.run(SCENE)
    assert alone.eq is not None
    numbers = (alone.mean_threshold, *alone.thresholds.survival[::10], *alone.eq.force)
    done = mpirun(ranks, PROGRAM, json.dumps(SCENE))
    assert done.returncode == 0, done.stderr
    every = json.loads(done.stdout)
    assert len(every) == ranks and sum(drawn for _, drawn in every) == 20_000
    assert all(bits == [float(x).hex() for x in numbers] for bits, _ in every)
    # whole blocks of 4,096 are shared
    assert all(drawn >= 4096 for _, drawn in every) and max(drawn for _, drawn in every) <= 20_000 / ranks + 4096


COMMAND = """
import toolkit.command, toolkit.judge.compare, toolkit.judge.describe
# the sampling errors of 20 resampled laws take long
toolkit.judge.compare.sampling_errors = toolkit.judge.describe.sampling_errors = lambda contacts: {}
from mpi4py import MPI
from origins import streams

drawn, real = [], streams.words
def counted(key, purpose, replica, contact, block):
    if purpose == streams.DOMAINS and block == 0:
        drawn.append(contact.size)
    return real(key, purpose, replica, contact, block)
streams.words = counted
for word in ("compare", "thresholds"):
    status = toolkit.command.main([word, "domains.toml", "--out", word])
    every = MPI.COMM_WORLD.gather((status, sum(drawn)))
    drawn.clear()
    if MPI.COMM_WORLD.Get_rank() == 0:
        print(every)
"""


@pytest.mark.slow  # K* of each of 20 resampled laws takes seconds
def test_commands_share_the_domains(mpirun: Callable[..., Any], tmp_path: Any) -> None:
    thresholds = SCENE["contacts"]["thresholds"]["components"][0] | {"samples": 8192}  # type: ignore[index]
    tables = SCENE | {"contacts": {"thresholds": thresholds}}
    (tmp_path / "domains.toml").write_text(to_toml(tables))
    done = mpirun(2, COMMAND)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines().count("[(0, 4096), (0, 4096)]") == 2
    assert (tmp_path / "compare").is_dir() and (tmp_path / "thresholds").is_dir()
