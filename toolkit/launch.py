"""What the launcher's environment says: how many ranks it started, and which one this is."""

import os
from collections.abc import Mapping
from dataclasses import dataclass

# (number of ranks, own rank) as each launcher's processes see them. SLURM_NTASKS is not among them: a batch script
# sees it too, alone. PMI: mpich, Intel MPI, srun --mpi=pmi2; MV2: mvapich; the step's variables: any srun.
_VARIABLES = (
    ("PMI_SIZE", "PMI_RANK"),
    ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    ("MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"),
    ("MPI_LOCALNRANKS", "MPI_LOCALRANKID"),
    ("SLURM_STEP_NUM_TASKS", "SLURM_PROCID"),
)


@dataclass(frozen=True)
class Launch:
    """What the launcher's environment says of this process."""

    size: int = 1
    rank: int = 0


def read_environment(environment: Mapping[str, str] = os.environ) -> Launch:
    """The largest launch named; inner launchers inherit the variables of outer ones."""
    launches = [Launch()]
    for size, rank in _VARIABLES:
        if environment.get(size, "").isdecimal() and environment.get(rank, "").isdecimal():
            launches.append(Launch(int(environment[size]), int(environment[rank])))
    return max(launches, key=lambda launch: launch.size)
