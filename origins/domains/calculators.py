"""ASE calculators for the atoms of an island: a substrate under them, harmonic bonds between them, in its units.

ASE's own eV and Å are not assumed. ASE's SumCalculator adds a substrate to any other calculator.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from origins.domains.islands import Atoms, points_of
from origins.domains.substrates import Substrate, checked_substrate
from origins.errors import positive, refuse
from origins.thresholds.law import Array


def substrate_calculator(substrate: Substrate) -> Any:
    """A Calculator with the energy and forces of atoms on `substrate`, each by its own x and y; `periods` is its cell.
    Cell and boundary conditions of the atoms are ignored. Raises InputError unless given a Substrate."""
    substrate = checked_substrate(substrate)

    def energy_and_forces(points: Array) -> tuple[float, Array]:
        forces = np.pad(substrate.forces(points[:, :2]), ((0, 0), (0, 1)))
        return float(substrate.energy(points[:, :2]).sum()), forces

    return _calculator(energy_and_forces, substrate)


def harmonic_bonds(atoms: Atoms, stiffness: float, *, reach: float | None = None) -> Any:
    """A Calculator of sum over bonds (stiffness/2)(length - length in `atoms`)², free of strain in `atoms` as given.

    stiffness is an energy per length squared, above zero. Atoms at most `reach` (a length) apart are bonded; when left
    out, 1.2 times the shortest distance: nearest neighbours. A square lattice needs a reach beyond its diagonal to
    withstand shear. Boundary conditions are ignored. Raises InputError for other values, for atoms in one place and
    where no two atoms are bonded.
    """
    stiffness, points = positive("stiffness", stiffness), points_of(atoms)
    tree = scipy.spatial.KDTree(points)
    shortest = tree.query(points, k=2)[0][:, 1].min()
    if shortest == 0.0:
        refuse("atoms", atoms, "must not hold two atoms in one place")
    # between the first and the second neighbours of every plane lattice
    reach = 1.2 * shortest if reach is None else positive("reach", reach)
    # a single atom has its nearest neighbour at infinity
    pairs = tree.query_pairs(reach, output_type="ndarray")
    if len(pairs) == 0:
        refuse("reach", reach, f"bonds no atoms; the nearest are {shortest:.6g} apart")
    first, second = pairs.T
    lengths = np.linalg.norm(points[second] - points[first], axis=1)

    def energy_and_forces(points: Array) -> tuple[float, Array]:
        apart = points[second] - points[first]
        length = np.sqrt((apart * apart).sum(-1))
        stretch, forces = length - lengths, np.zeros_like(points)
        # the force on two atoms in one place has no direction: it is 0
        pull = (stiffness * stretch / np.where(length > 0.0, length, 1.0))[:, None] * apart
        np.add.at(forces, first, pull)
        np.add.at(forces, second, -pull)
        return float(0.5 * stiffness * (stretch @ stretch)), forces

    return _calculator(energy_and_forces)


def _calculator(
    function: Callable[[Array], tuple[float, Array]], substrate: Substrate | None = None
) -> Any:
    """The ASE calculator of a function from points (n, 3) to the energy of atoms there and the forces on each."""
    from ase.calculators.calculator import Calculator, all_changes

    class OfPositions(Calculator):
        implemented_properties = ["energy", "forces"]  # noqa: RUF012
        # a property, as `cell` raises InputError for substrates that never repeat
        periods = property(lambda self: None if substrate is None else substrate.cell)

        def check_state(self, atoms: Atoms, tol: float = 0.0) -> list[str]:
            # ASE's own comparison takes longer than the calculation, and overlooks steps below 1e-15
            same = self.atoms is not None and np.array_equal(self.atoms.positions, atoms.positions)
            return [] if same else list(all_changes)

        def calculate(self, atoms: Any = None, *properties_and_changes: Any) -> None:
            super().calculate(atoms, *properties_and_changes)
            energy, forces = function(atoms.positions)
            self.results = {"energy": energy, "forces": forces}

    return OfPositions()
