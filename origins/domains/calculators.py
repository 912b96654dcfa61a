"""What atoms of an island feel, as ASE calculators: a substrate under them, harmonic bonds between them.

Energies are in the substrate's unit (without dimension by default) and lengths in that of its period; ASE's own eV
and Å are not assumed. ASE's SumCalculator adds a substrate to any other calculator.
"""

from typing import TYPE_CHECKING

import numpy as np

from origins.domains.substrates import Substrate
from origins.errors import positive, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

    from origins.domains.ase_calculators import OfPositions

_REACH = 1.2  # between the first and the second neighbours of every plane lattice


def substrate_calculator(substrate: Substrate) -> "OfPositions":
    """A Calculator with the energy, energies and forces of atoms on `substrate`, each by its own x and y.

    There is no force along z, and cell and boundary conditions of the atoms play no part. The calculator's `periods`
    are substrate.cell. Raises InputError unless given a Substrate, such as square_substrate().
    """
    if not isinstance(substrate, Substrate):
        refuse("substrate", substrate, "must be a Substrate, such as origins.square_substrate()")
    from origins.domains.ase_calculators import OfPositions

    def energies_and_forces(points: Array) -> tuple[Array, Array]:
        forces = np.zeros_like(points)
        forces[:, :2] = substrate.forces(points[:, :2])
        return substrate.energy(points[:, :2]), forces

    return OfPositions(energies_and_forces, substrate)


def harmonic_bonds(
    atoms: "ase.Atoms", stiffness: float, *, reach: float | None = None
) -> "OfPositions":
    """A Calculator of sum over bonds (stiffness/2)(length - length in `atoms`)², free of strain in `atoms` as given.

    Parameters
    ----------
    atoms : ase.Atoms
        The island at rest; boundary conditions play no part.
    stiffness : float
        Energy per length squared, above zero.
    reach : float
        Atoms at most this far apart are bonded; when left out, 1.2 times the shortest distance: nearest neighbours.
        A square lattice needs a reach beyond its diagonal to withstand shear.

    Raises InputError for other values, for atoms in one place and where no two atoms are bonded.
    """
    stiffness = positive("stiffness", stiffness)
    try:
        points = np.asarray(atoms.get_positions(), dtype=float)
    except AttributeError:
        refuse(
            "atoms", atoms, "must be an ase.Atoms, such as origins.triangular_island(2.5, 10, 9)"
        )
    if len(points) < 2:
        refuse("atoms", atoms, "must hold at least two atoms, else there is nothing to bond")
    if not np.isfinite(points).all():
        refuse("atoms", atoms, "must stand at finite positions")
    from scipy.spatial import KDTree

    tree = KDTree(points)
    shortest = tree.query(points, k=2)[0][:, 1].min()
    if shortest == 0.0:
        refuse("atoms", atoms, "must not hold two atoms in one place")
    reach = _REACH * shortest if reach is None else positive("reach", reach)
    pairs = tree.query_pairs(reach, output_type="ndarray")
    if len(pairs) == 0:
        refuse("reach", reach, f"bonds no atoms; the nearest are {shortest:.6g} apart")
    from origins.domains.ase_calculators import OfPositions

    first, second = pairs.T
    lengths = np.linalg.norm(points[second] - points[first], axis=1)

    def energies_and_forces(points: Array) -> tuple[Array, Array]:
        count = len(points)
        if pairs.max() >= count:
            refuse(
                "atoms", points, f"must hold at least the {pairs.max() + 1} atoms that were bonded"
            )
        apart = points[second] - points[first]
        length = np.sqrt((apart * apart).sum(-1))
        stretch = length - lengths
        # atoms in one place push along no direction
        pull = (stiffness * stretch / np.where(length > 0.0, length, 1.0))[:, None] * apart
        half, forces = 0.25 * stiffness * stretch**2, np.zeros_like(points)
        np.add.at(forces, first, pull)
        np.add.at(forces, second, -pull)
        energies = np.bincount(pairs.ravel(), np.repeat(half, 2), count).astype(float)
        return energies, forces

    return OfPositions(energies_and_forces)
