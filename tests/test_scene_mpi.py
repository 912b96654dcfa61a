"""Scenes of rotated domains under mpirun: the ranks share the sampling, and the bits are those of one process."""

import json
from collections.abc import Callable
from typing import Any

import pytest

import toolkit

SCENE = {
    "contacts": {
        "thresholds": {
            "kind": "mixture",
            "components": [
                {
                    "kind": "domains",
                    "lattice_constant": 3.88,
                    "mean_atoms": 30.0,
                    "stiffness": 1.0,
                    "samples": 20_000,
                },
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
import origins, toolkit
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
share = sum(drawn)
try:
    sizes = dict(sizes=[(1, 1), (3000, 3000)], weights=[1.0, 1e-3])
    origins.domains(1.0, **sizes, temperature=1e-9, stiffness=1.0, comm=comm)
    refused = "no"
except origins.InputError as error:
    refused = str(error)
every = comm.gather([bits, share, refused])
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
    assert len(every) == ranks and sum(drawn for _, drawn, _ in every) == 20_000
    assert all(bits == [float(x).hex() for x in numbers] for bits, _, _ in every)
    # whole blocks of 4,096 are shared
    shares = [drawn for _, drawn, _ in every]
    assert min(shares) >= 4096 and max(shares) <= 20_000 / ranks + 4096
    # one rank's refusal is everyone's
    assert all(refused.startswith("temperature: ") for _, _, refused in every)
