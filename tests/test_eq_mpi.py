"""The ensemble under mpirun: the same bits at 1, 2, 3 and 4 ranks, and the work shared."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np

import eq_model
import origins
from eq_model.layout import share

PROGRAM = """
import json
import numpy as np
from mpi4py import MPI
import eq_model, origins

law = origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])
contacts = origins.Contacts(law, start=origins.gaussian_start(mean=0.05, std=0.1))
run = eq_model.simulate(
    contacts, np.linspace(0.0, 6.0, 31), n_contacts=5001, n_replicas=3, seed=9, comm=MPI.COMM_WORLD
)
bits = [[float(x).hex() for x in row] for row in (run.force, run.force_standard_error)]
every = MPI.COMM_WORLD.gather([bits, run.breaks, run.breaks_per_rank, run.run_time])
if MPI.COMM_WORLD.Get_rank() == 0:
    print(json.dumps(every))
"""


def test_bits_do_not_depend_on_the_number_of_ranks(mpirun: Callable[..., Any]) -> None:
    law = origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])
    contacts = origins.Contacts(law, start=origins.gaussian_start(mean=0.05, std=0.1))
    alone = eq_model.simulate(contacts, np.linspace(0.0, 6.0, 31), n_contacts=5001, n_replicas=3, seed=9)
    expected = [[float(x).hex() for x in row] for row in (alone.force, alone.force_standard_error)]
    for ranks in (1, 2, 3, 4):
        done = mpirun(ranks, PROGRAM)
        assert done.returncode == 0, done.stderr
        every = json.loads(done.stdout)
        assert len(every) == ranks
        for bits, breaks, breaks_per_rank, _ in every:
            assert bits == expected
            assert breaks == sum(breaks_per_rank) == alone.breaks and len(breaks_per_rank) == ranks
            # every rank does its share: contacts are alike, so shares differ by little more than chance
            assert max(breaks_per_rank) < 1.05 * min(breaks_per_rank)
        assert len({run_time for *_, run_time in every}) == 1


def test_more_ranks_than_contacts() -> None:
    for total in (1, 3, 4, 1001):
        for size in (1, 2, 3, 4, 7):
            gap = [range(total // 3), range(total // 2, total)]
            for contacts in ([range(total)], [part for part in gap if len(part)]):
                shares = [[i for part in share(contacts, rank, size) for i in part] for rank in range(size)]
                assert [i for part in shares for i in part] == [i for part in contacts for i in part]
                assert max(map(len, shares)) - min(map(len, shares)) <= 1
