"""Rotated domains in scenes: an island of your own, and the substrate it lies on."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import origins
from origins.errors import InputError, finite_array, refuse
from toolkit.scene.laws import ISLANDS
from toolkit.scene.measured import read_file

if TYPE_CHECKING:
    import ase


def domains(
    lattice_constant: float | None = None,
    sizes: Sequence[Sequence[int]] | None = None,
    mean_atoms: float | None = None,
    island: "ase.Atoms | None" = None,
    weights: Sequence[float] | None = None,
    bonds: float | None = None,
    angles: Sequence[float] | None = None,
    temperature: float | None = None,
    substrate: origins.Substrate | None = None,
    law: str = "area",
    stiffness: float | None = None,
    coefficient: float | None = None,
    samples: int = 20_000,
    seed: int = 0,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds of rotated domains, drawn by all ranks of `comm`; see origins.domains, whose keywords these are but
    for `island`, the one of its `islands`. Raises InputError."""
    options = dict(locals())
    del options["island"]
    if sum(given is not None for given in (sizes, mean_atoms, island)) != 1:
        raise InputError(
            "domains: give exactly one of sizes, such as [[10, 9]], mean_atoms, such as 100, and island, a "
            f"table with a kind of {', '.join(ISLANDS)}"
        )
    if island is not None and lattice_constant is not None:
        refuse("lattice_constant", lattice_constant, "the table island has its own; leave it out")
    return origins.domains(**options, islands=None if island is None else [island])


def island_of_file(folder: Path, file: str, comm: Any = None) -> "ase.Atoms":
    """The atoms of a structure file, of any format that ASE reads; InputError where it reads none."""

    def read(path: Path) -> "ase.Atoms":
        from ase.io import read as read_atoms

        try:
            return read_atoms(path)  # type: ignore[return-value]  # the last of several
        except Exception as error:  # each format has errors of its own
            refuse("file", file, f"is no structure that ASE reads: {type(error).__name__}")

    return read_file("file", file, folder, comm, read)


def fourier_substrate(
    wavevectors: npt.ArrayLike,
    cosines: npt.ArrayLike | None = None,
    sines: npt.ArrayLike | None = None,
) -> origins.Substrate:
    """sum of cosines cos(G·r) + sines sin(G·r), one of each for every wavevector, zero when left out."""
    count = len(wavevectors) if isinstance(wavevectors, list) else 0
    parts = []
    for name, value in (("cosines", cosines), ("sines", sines)):
        part = np.zeros(count) if value is None else finite_array(name, value)
        if part.size != count:
            refuse(name, value, f"must be {count} numbers, one for each wavevector")
        parts.append(part)
    return origins.fourier_substrate(wavevectors, parts[0] - 1j * parts[1])
