"""Results of every kind of ensemble, to the last bit, which may not depend on the number of ranks."""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

import eq_model
import origins

wide, mixed = (
    origins.gaussian(1.0, 0.2),
    origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]),
)
soft, loop = origins.Thermal("soft", 0.05), np.array([0.6, 1.4, 0.2, -1.1, 0.3])
ageing = origins.Ageing(origins.gaussian(1.2, 0.1), 0.01)
start, path = origins.gaussian_start(mean=0.05, std=0.1), np.linspace(0.0, 6.0, 31)


def told(comm: Any) -> Iterator[Any]:
    """Every kind of ensemble, with some laws, as what is gathered is the same for all; islands, whose sampling is
    shared; what one rank refuses, which all refuse."""
    for contacts, drive, number, more in (
        (origins.Contacts(mixed, start), path, 5001, {}),
        (
            origins.Contacts(wide, start, soft, None, origins.Delay(0.1), 0.1, "linked"),
            loop,
            1001,
            {"histograms": [2]},
        ),
        (origins.Contacts(wide, start, ageing=ageing), loop, 3001, {"histograms": [4]}),
        (origins.Contacts(origins.strengthening(wide, 0.1, 2.0), start), loop, 301, {}),
        (origins.Contacts(wide, delay=origins.Delay(0.1)), 3.0 * loop, 300, {"spring": 0.7}),
        (origins.Contacts(wide, thermal=soft), path, 300, {"spring": 0.7}),
        (
            origins.Contacts(wide, delay=origins.Delay(0.1)),
            path,
            300,
            {"spring": 0.3, "mass": 0.05, "damping": 0.01},
        ),
    ):
        run = eq_model.simulate(
            contacts, drive, n_contacts=number, n_replicas=3, seed=9, comm=comm, **more
        )
        rows = [run.force, run.force_standard_error, run.holding]
        rows += [
            row for one in getattr(run, "histograms", ()) for row in (one.stretches, one.thresholds)
        ]
        rows += [run.slips.drive, *run.forces] if more.get("spring") else []
        if more.get("mass"):
            rows += [
                *run.velocities,
                *run.energy.released,
                *run.energy.contacts,
                run.slips.duration,
            ]
        assert sum(run.breaks_per_rank) == run.breaks
        assert comm is None or (
            len(run.breaks_per_rank) == comm.Get_size() and min(run.breaks_per_rank) > 0
        )
        yield [[float(x).hex() for x in row if x] for row in rows]
    law = origins.domains(3.88, mean_atoms=30.0, stiffness=1.0, samples=3000, comm=comm)
    yield [float(x).hex() for x in law.domains.barriers[::30]]
    try:
        sizes = {"sizes": [(1, 1), (3000, 3000)], "weights": [1.0, 1e-3]}
        origins.domains(1.0, **sizes, temperature=1e-9, stiffness=1.0, comm=comm)
    except origins.InputError as error:
        yield str(error)


def print_gathered() -> None:
    """On each of several ranks: what all of them have, printed by the first."""
    from mpi4py import MPI

    every = MPI.COMM_WORLD.gather(list(told(MPI.COMM_WORLD)))
    if MPI.COMM_WORLD.Get_rank() == 0:
        print(json.dumps(every))
