"""What the launcher's environment says: how many ranks it started, and which one this is."""

import os
from collections.abc import Mapping
from dataclasses import dataclass

_STEP = "SLURM_STEP_NUM_TASKS"
# (number of ranks, own rank) as each launcher's processes see them. SLURM_NTASKS is not among them: a batch script
# sees it too, alone. PMI: mpich, Intel MPI, srun --mpi=pmi2; MV2: mvapich; the step's variables: any srun.
_VARIABLES = (
    ("PMI_SIZE", "PMI_RANK"),
    ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"),
    ("MV2_COMM_WORLD_SIZE", "MV2_COMM_WORLD_RANK"),
    ("MPI_LOCALNRANKS", "MPI_LOCALRANKID"),
    (_STEP, "SLURM_PROCID"),
)
_MPIRUNS = _VARIABLES[1:4]  # an mpirun within a step of Slurm's sets these


@dataclass(frozen=True)
class Launch:
    """What the launcher's environment says of this process; `by` is its name."""

    size: int = 1
    rank: int = 0
    by: str = "mpirun"


def read_environment(environment: Mapping[str, str] = os.environ) -> Launch:
    """The largest launch named; inner launchers inherit the variables of outer ones."""
    launches = [(1, 0)]
    for size, rank in _VARIABLES:
        if environment.get(size, "").isdecimal() and environment.get(rank, "").isdecimal():
            launches.append((int(environment[size]), int(environment[rank])))
    size_found, own = max(launches, key=lambda launch: launch[0])
    by_slurm = size_found > 1 and environment.get(_STEP) == str(size_found)
    by_slurm = by_slurm and not any(size in environment for size, _ in _MPIRUNS)
    return Launch(size_found, own, "srun" if by_slurm else "mpirun")
