"""The ASE calculators behind origins.calculators. Importing this file imports ase, so only functions do."""

from typing import Any

import ase
import numpy as np
import numpy.typing as npt
from ase.calculators.calculator import Calculator, all_changes

from origins.domains.substrates import Substrate
from origins.errors import refuse
from origins.thresholds.law import Array


class _OfPositions(Calculator):
    """Energy, energies and forces that positions alone decide."""

    def __init__(self, **keywords: Any) -> None:
        self.implemented_properties = ["energy", "energies", "forces"]
        super().__init__(**keywords)

    def check_state(self, atoms: ase.Atoms, tol: float = 0.0) -> list[str]:
        # ASE's own comparison takes longer than the calculation, and overlooks steps below 1e-15
        same = self.atoms is not None and np.array_equal(self.atoms.positions, atoms.positions)
        return [] if same else list(all_changes)

    def of_positions(self, points: Array) -> tuple[Array, Array]:
        """Energies of the atoms at points of shape (n, 3), shape (n,), and the forces on them, shape (n, 3)."""
        raise NotImplementedError

    def calculate(
        self,
        atoms: ase.Atoms | None = None,
        properties: list[str] | None = None,
        system_changes: list[str] = all_changes,
    ) -> None:
        super().calculate(atoms, properties, system_changes)
        assert self.atoms is not None  # ASE's own copy
        energies, forces = self.of_positions(self.atoms.positions)
        self.results = {"energy": float(energies.sum()), "energies": energies, "forces": forces}


class SubstrateCalculator(_OfPositions):
    """Atoms on a Substrate; made by substrate_calculator."""

    def __init__(self, substrate: Substrate, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.substrate = substrate

    @property
    def periods(self) -> Array:
        """Translations that leave all energies as they are, shape (2, 2); InputError where substrate.cell has none."""
        return self.substrate.cell

    def of_positions(self, points: Array) -> tuple[Array, Array]:
        flat = points[:, :2]
        energies = self.substrate.energy(flat)
        forces = np.zeros((len(flat), 3))
        forces[:, :2] = self.substrate.forces(flat)
        return np.asarray(energies, dtype=float), forces


class HarmonicBonds(_OfPositions):
    """Springs between given pairs of atoms; made by harmonic_bonds."""

    def __init__(
        self, stiffness: float, pairs: npt.NDArray[np.intp], lengths: Array, **keywords: Any
    ) -> None:
        super().__init__(**keywords)
        self.stiffness, self.pairs, self.lengths = stiffness, pairs, lengths

    def of_positions(self, points: Array) -> tuple[Array, Array]:
        count = len(points)
        first, second = self.pairs.T
        if self.pairs.max() >= count:
            refuse(
                "atoms",
                self.atoms,
                f"must hold at least the {self.pairs.max() + 1} atoms that were bonded",
            )
        apart = points[second] - points[first]
        length = np.sqrt((apart * apart).sum(-1))
        stretch = length - self.lengths
        # atoms in one place push along no direction
        pull = (self.stiffness * stretch / np.where(length > 0.0, length, 1.0))[:, None] * apart
        half = 0.25 * self.stiffness * stretch**2
        energies = np.bincount(first, half, count).astype(float) + np.bincount(second, half, count)
        forces = np.column_stack(
            [np.bincount(first, axis, count) - np.bincount(second, axis, count) for axis in pull.T]
        )
        return np.asarray(energies, dtype=float), forces
