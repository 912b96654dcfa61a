"""The ensemble under mpirun: the same bits at 1, 2, 3 and 4 ranks, and the work shared."""

import json
from collections.abc import Callable
from typing import Any

SCENES = """
import json
import numpy as np
import eq_model, origins

gaussian, mixed = origins.gaussian(1.0, 0.2), origins.mixture(
    [origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]
)
soft, loop = origins.Thermal("soft", 0.05), np.array([0.6, 1.4, 0.2, -1.1, 0.3])
ageing = origins.Ageing(origins.gaussian(1.2, 0.1), 0.01)
start, path = origins.gaussian_start(mean=0.05, std=0.1), np.linspace(0.0, 6.0, 31)

def runs(comm):
    for contacts, drive, number, points in (
        (origins.Contacts(mixed, start), path, 5001, ()),
        (origins.Contacts(gaussian, start, soft), path, 5001, ()),
        (origins.Contacts(gaussian, start, soft, None, origins.Delay(0.1), 0.1, "linked"), loop, 1001, (2, 4)),
        (origins.Contacts(gaussian, start, ageing=ageing), loop, 3001, (4,)),
        (origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0), thermal=soft), loop, 301, (4,)),
    ):
        yield eq_model.simulate(
            contacts, drive, n_contacts=number, n_replicas=3, seed=9, histograms=np.array(points, int), comm=comm
        )

def bits(run):
    rows = [run.force, run.force_standard_error, run.step_error, run.holding]
    rows += [row for one in run.histograms for row in (one.stretches, one.thresholds)]
    return [[float(x).hex() for x in row if x] for row in rows]
"""
PROGRAM = (
    SCENES
    + """
from mpi4py import MPI

every = MPI.COMM_WORLD.gather(
    [[bits(run), run.breaks, run.breaks_per_rank, run.run_time] for run in runs(MPI.COMM_WORLD)]
)
if MPI.COMM_WORLD.Get_rank() == 0:
    print(json.dumps(every))
"""
)


def test_bits_do_not_depend_on_the_number_of_ranks(mpirun: Callable[..., Any]) -> None:
    """Of any scene: contacts without laws, at a temperature, with all but ageing on a loop, ageing, growing grains."""
    here: dict[str, Any] = {}
    exec(SCENES, here)
    alone = [(run.breaks, here["bits"](run)) for run in here["runs"](None)]
    ranks = 3
    done = mpirun(ranks, PROGRAM)
    assert done.returncode == 0, done.stderr
    every = json.loads(done.stdout)
    assert len(every) == ranks
    for told in every:
        for (bits, breaks, breaks_per_rank, _), (expected_breaks, expected) in zip(told, alone, strict=True):
            assert bits == expected
            assert breaks == sum(breaks_per_rank) == expected_breaks and len(breaks_per_rank) == ranks
        # every rank does its share: contacts are alike, so shares differ by little more than chance
        shares = told[0][2]
        assert max(shares) < 1.05 * min(shares)
    for scene in range(len(alone)):
        assert len({told[scene][3] for told in every}) == 1
