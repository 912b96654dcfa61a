"""Rotated domains in scenes: islands and the substrate they lie on as tables."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import origins
from origins.errors import InputError, finite_array, refuse
from toolkit.running.ranks import on_root
from toolkit.scene import laws
from toolkit.scene.given_files import check_regular

if TYPE_CHECKING:
    import ase

ISLANDS = {
    "triangular": "origins:triangular_island",
    "square": "origins:square_island",
    "rectangular": "origins:rectangular_island",
    "hexagonal": "origins:hexagonal_island",
    "circular": "origins:circular_island",
    "irregular": "origins:irregular_island",
    "file": "toolkit.scene.islands:island_of_file",
}
SUBSTRATES = {
    "square": "origins:square_substrate",
    "hexagonal": "origins:hexagonal_substrate",
    "fourier": "toolkit.scene.islands:fourier_substrate",
}


def domains(
    folder: Path,
    lattice_constant: float | None = None,
    sizes: Sequence[Sequence[int]] | None = None,
    mean_atoms: float | None = None,
    island: Mapping[str, Any] | None = None,
    weights: Sequence[float] | None = None,
    bonds: float | None = None,
    angles: Sequence[float] | None = None,
    temperature: float | None = None,
    substrate: Mapping[str, Any] | None = None,
    law: str = "area",
    stiffness: float | None = None,
    coefficient: float | None = None,
    samples: int = 20_000,
    seed: int = 0,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds of rotated domains, drawn by all ranks of `comm`; see origins.domains.

    `angles` are radians; `island` is a table with a kind of ISLANDS, for one island of your own, `bonds` makes it
    flexible; `substrate` is a table with a kind of SUBSTRATES, sin x + sin y when left out. Raises InputError.
    """
    if sum(given is not None for given in (sizes, mean_atoms, island)) != 1:
        raise InputError(
            "domains: give exactly one of sizes, such as [[10, 9]], mean_atoms, such as 100, and island, a "
            f"table with a kind of {', '.join(ISLANDS)}"
        )
    islands = None
    if island is not None:
        if lattice_constant is not None:
            refuse(
                "lattice_constant", lattice_constant, "the table island has its own; leave it out"
            )
        islands = [laws.build(ISLANDS, laws.as_table("island", island), "island", folder, comm)]
    if substrate is not None:
        substrate = laws.build(
            SUBSTRATES, laws.as_table("substrate", substrate), "substrate", folder
        )
    return origins.domains(
        lattice_constant,
        sizes=sizes,
        mean_atoms=mean_atoms,
        islands=islands,
        weights=weights,
        bonds=bonds,
        angles=angles,
        temperature=temperature,
        substrate=substrate,  # type: ignore[arg-type]
        law=law,
        stiffness=stiffness,
        coefficient=coefficient,
        samples=samples,
        seed=seed,
        comm=comm,
    )


def island_of_file(folder: Path, file: str, comm: Any = None) -> "ase.Atoms":
    """The atoms of a structure file, of any format that ASE reads; InputError where it reads none."""
    if not isinstance(file, str):
        refuse("file", file, 'must be a name, such as "island.xyz"')

    def read() -> "ase.Atoms":
        from ase.io import read as read_atoms

        check_regular("file", folder / file, file)
        try:
            return read_atoms(folder / file)  # type: ignore[return-value]  # the last of several
        except Exception as error:  # each format has errors of its own
            refuse("file", file, f"is no structure that ASE reads: {type(error).__name__}")

    return on_root(comm, read)


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
