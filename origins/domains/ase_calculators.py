"""The ASE calculator behind origins.domains.calculators. Importing this file imports ase, so only functions do."""

from collections.abc import Callable
from typing import Any

import ase
import numpy as np
from ase.calculators.calculator import Calculator, all_changes

from origins.domains.substrates import Substrate
from origins.thresholds.law import Array


class OfPositions(Calculator):
    """Energies of the atoms at points (n, 3), shape (n,), and the forces on them, shape (n, 3), by one function.

    Where the points lie on a substrate, `periods` are translations that leave all energies as they are.
    """

    def __init__(
        self, function: Callable[[Array], tuple[Array, Array]], substrate: Substrate | None = None
    ) -> None:
        self.implemented_properties = ["energy", "energies", "forces"]
        super().__init__()
        self.function, self.substrate = function, substrate

    @property
    def periods(self) -> Array | None:
        """Shape (2, 2); None without a substrate, InputError where substrate.cell has none."""
        return None if self.substrate is None else self.substrate.cell

    def check_state(self, atoms: ase.Atoms, tol: float = 0.0) -> list[str]:
        # ASE's own comparison takes longer than the calculation, and overlooks steps below 1e-15
        same = self.atoms is not None and np.array_equal(self.atoms.positions, atoms.positions)
        return [] if same else list(all_changes)

    def calculate(
        self,
        atoms: ase.Atoms | None = None,
        properties: Any = None,
        system_changes: Any = all_changes,
    ) -> None:
        super().calculate(atoms, properties, system_changes)
        assert self.atoms is not None  # ASE's own copy
        energies, forces = self.function(self.atoms.positions)
        self.results = {"energy": float(energies.sum()), "energies": energies, "forces": forces}
