"""An island that is moved through the energy of any ASE calculator: by translations alone, or atom by atom.

ASE's tools see it as Atoms of their own: one for the centre of a rigid island, each of its atoms for a flexible one.
Importing this file imports ase, so only functions do.
"""

from typing import Any

import ase
import numpy as np
from ase.calculators.calculator import BaseCalculator, PropertyNotImplementedError
from ase.calculators.singlepoint import SinglePointCalculator
from ase.constraints import FixAtoms

from origins.errors import refuse
from origins.thresholds.law import Array


class MovingIsland:
    """Energy and forces as functions of `points`: the centre of the island, shape (1, 3), or its atoms, (N_a, 3).

    Atoms held by FixAtoms are the surroundings and stay; all others are the island. A planar island keeps its
    heights. A flexible one keeps its orientation: sum_i r_i0 x u_i = 0 along z, r_i0 its atoms at rest about their
    centre, u_i their displacements.
    """

    def __init__(self, atoms: ase.Atoms, calculator: Any, rigid: bool, planar: bool) -> None:
        self.given, self.calculator = atoms, calculator
        fixed = np.zeros(len(atoms), dtype=bool)
        for constraint in atoms.constraints:
            if not isinstance(constraint, FixAtoms):
                refuse(
                    "atoms.constraints",
                    constraint,
                    "must be FixAtoms, which tells the surroundings of the island",
                )
            fixed[constraint.index] = True
        if fixed.all():
            refuse(
                "atoms", atoms, "must hold atoms that FixAtoms does not fix: these are the island"
            )
        self.moving = np.flatnonzero(~fixed)
        self.rigid, self.planar = rigid, planar
        self.evaluations = 0
        self.strongest = 0.0  # force on one atom so far
        self._all = atoms.copy()
        self._all.set_constraint()
        self._all.calc = calculator
        self._rest = atoms.get_positions()[self.moving]
        centre = self._rest.mean(axis=0)
        self.points = centre[None] if rigid else self._rest
        turn = np.zeros_like(self._rest)
        turn[:, 0], turn[:, 1] = centre[1] - self._rest[:, 1], self._rest[:, 0] - centre[0]
        size = np.linalg.norm(turn)
        self._turn = None if rigid or size == 0.0 else turn / size

    @property
    def reach(self) -> Array:
        """Where the atoms of the island stand, of shape (N_a, 3), as given."""
        return self._rest

    def evaluate(self, points: Array) -> tuple[float, Array]:
        """Energy, and the force on `points` along what is left to them, of their shape."""
        self._all.positions[self.moving] = self._rest + (points - self.points)
        try:
            forces = self._all.get_forces()[self.moving]
            energy = float(self._all.get_potential_energy())
        except Exception as error:
            said = f"{type(error).__name__}: {error}".splitlines()[0]
            refuse("calculator", said, "must give energies and forces wherever the island goes")
        if not (np.isfinite(energy) and np.isfinite(forces).all()):
            refuse(
                "calculator",
                energy,
                "must give finite energies and forces wherever the island goes",
            )
        self.evaluations += 1
        self.strongest = max(self.strongest, float(np.linalg.norm(forces, axis=1).max()))
        if self.rigid:
            forces = forces.sum(axis=0, keepdims=True)
        if self.planar:
            forces[:, 2] = 0.0
        if self._turn is not None:
            forces -= (forces * self._turn).sum() * self._turn
        return energy, forces

    def energy_at(self, points: Array) -> float:
        return self.evaluate(points)[0]

    def basis(self) -> Array:
        """Orthonormal directions left to the points, as columns, shape (3 len(points), m)."""
        size = self.points.size
        axes = np.arange(size).reshape(-1, 3)[:, : 2 if self.planar else 3].ravel()
        free = np.eye(size)[:, axes]
        if self._turn is None:
            return free
        return free @ np.linalg.qr(self._turn.ravel()[axes, None], mode="complete")[0][:, 1:]

    def unturned(self, points: Array) -> Array:
        """The points without the turn that rounding has let in, which stiff bonds make much of."""
        if self._turn is None:
            return points
        return points - ((points - self.points) * self._turn).sum() * self._turn

    def atoms_at(self, points: Array) -> ase.Atoms:
        """A copy of the atoms as given, the island at `points`, their energy and forces with them."""
        self.evaluate(points)
        atoms = self.given.copy()
        atoms.positions[self.moving] = self._all.positions[self.moving]
        energy, forces = self._all.get_potential_energy(), self._all.get_forces()
        atoms.calc = SinglePointCalculator(atoms, energy=energy, forces=forces)
        return atoms


class IslandCalculator(BaseCalculator):
    """The island for ASE's optimizers and bands, in units of a length and an energy of its own."""

    def __init__(self, island: MovingIsland, length: float, energy: float) -> None:
        self.implemented_properties = ["energy", "forces"]
        super().__init__()
        self.island, self.length, self.energy = island, length, energy
        self._points: Array | None = None

    def calculate(
        self, atoms: ase.Atoms, properties: list[str], system_changes: list[str]
    ) -> None:
        self._points = atoms.positions.copy()
        points = self.island.unturned(self._points * self.length)
        energy, forces = self.island.evaluate(points)
        forces = forces * (self.length / self.energy)
        self.results = {"energy": energy / self.energy, "forces": forces}

    def get_property(
        self, name: str, atoms: ase.Atoms | None = None, allow_calculation: bool = True
    ) -> Any:
        # ASE compares cells, masses and more as well, which takes longer than most substrates
        if atoms is not None and (
            self._points is None or not np.array_equal(atoms.positions, self._points)
        ):
            self.calculate(atoms, [name], [])
        if name not in self.results:
            raise PropertyNotImplementedError(name)
        result = self.results[name]
        return result.copy() if isinstance(result, np.ndarray) else result
