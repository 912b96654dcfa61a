"""An island that moves through the energy of any ASE calculator, and its lowest saddle where atoms or heights
relax, by ASE's climbing-image elastic bands.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from origins.errors import InputError, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

_KNOWN = 1e-9  # of force times radian: energies of minima closer than this count as equal
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))  # periods between the two ends of a band
_IMAGES = 11
_SHAKE = 0.02  # radians
_LOOSE, _TIGHT = 1e-2, 1e-10  # forces over the greatest one: after ASE, and after Newton's method
_MOST_STEPS, _BAND_STEPS = 2000, 300  # of a relaxation, of a band; Newton's method then refines
_MOST_MINIMA = 10


@dataclass(frozen=True)
class Ends:
    """Shifts of the atoms (N_a, 3) to the minimum and the saddle, and the error of the energy difference."""

    minimum: Array
    saddle: Array
    error: float = 0.0


class MovingIsland:
    """The atoms that move: all but those fixed by FixAtoms, which are the surroundings.

    A rigid island is shifted as a whole, a planar one keeps its heights. A flexible one keeps its
    orientation: sum_i r_i0 x u_i = 0 along z, r_i0 its given atoms about their centre, u_i their shifts.
    For ASE's tools this object is a constraint of the atoms.

    Attributes
    ----------
    rest : array (N_a, 3)
        Given positions of the island's atoms.
    radian, force : float
        The shorter period over 2 pi; the greatest force on one atom at nine places of the cell.
    places, energies : arrays (9, N_a, 3), (9,)
        Shifts to these places, and the energies there.
    """

    def __init__(
        self, atoms: ase.Atoms, calculator: Any, rigid: bool, planar: bool, periods: Array
    ) -> None:
        """Find the atoms that move, and energies and forces at nine places of a cell."""
        from ase.constraints import FixAtoms

        fixed = np.zeros(len(atoms), dtype=bool)
        for constraint in atoms.constraints:
            if not isinstance(constraint, FixAtoms):
                rule = "must be FixAtoms, which tells the surroundings of the island"
                refuse("atoms.constraints", constraint, rule)
            fixed[constraint.index] = True
        if fixed.all():
            rule = "must hold atoms that FixAtoms does not fix: these are the island"
            refuse("atoms", atoms, rule)
        self.moving = np.flatnonzero(~fixed)
        self.rigid, self.planar, self.evaluations = rigid, planar, 0
        self.given, self.calculator, self.periods = atoms, calculator, periods
        self.rest = atoms.get_positions()[self.moving]
        turn = self.rest.mean(axis=0) - self.rest
        turn = np.column_stack([turn[:, 1], -turn[:, 0], np.zeros(len(turn))])
        # atoms on one vertical line have no rotation, except by rounding
        size = max(float(np.linalg.norm(turn)), 1e-12 * float(np.abs(self.rest).max()), 1e-300)
        self._turn = turn / size
        self._here = self.placed(np.zeros_like(self.rest))
        self.radian = float(np.linalg.norm(periods, axis=1).min() / (2.0 * np.pi))
        thirds = [[(i + 0.37) / 3.0, (j + 0.21) / 3.0] for i in range(3) for j in range(3)]
        self.places = np.array([self.shifted(share) for share in thirds])
        self.force = max(np.linalg.norm(self.forces(at), axis=1).max() for at in self.places)
        self.energies = np.array([self.energy(at) for at in self.places])

    def shifted(self, share: Any) -> Array:
        """Shifts of all atoms by `share` (2,) of the periods."""
        return np.broadcast_to(np.append(share @ self.periods, 0.0), self.rest.shape)

    def free(self, shifts: Array) -> Array:
        """The part of shifts, or forces, (N_a, 3) that the constraints allow."""
        left = shifts * [1.0, 1.0, 0.0] if self.planar else shifts
        if self.rigid:
            return np.broadcast_to(left.mean(axis=0), left.shape)
        return left - (left * self._turn).sum() * self._turn

    def placed(self, shifts: Array) -> ase.Atoms:
        """The atoms, shifted, with calculator and constraint."""
        atoms = self.given.copy()
        atoms.set_constraint(self)
        atoms.calc = self.calculator
        atoms.positions[self.moving] = self.rest + self.free(shifts)
        return atoms

    def energy(self, shifts: Array) -> float:
        self._here.positions[self.moving] = self.rest + self.free(shifts)
        return float(self._here.get_potential_energy())

    def forces(self, shifts: Array) -> Array:
        """On each atom (N_a, 3); InputError where the calculator fails."""
        try:
            energy = self.energy(shifts)
            forces = self._here.get_forces(apply_constraint=False)[self.moving]
        except Exception as error:
            said = f"{type(error).__name__}: {error}".splitlines()[0]
            refuse("calculator", said, "must give energies and forces wherever the island goes")
        self.evaluations += 1
        if not (np.isfinite(energy) and np.isfinite(forces).all()):
            rule = "must give finite energies and forces wherever the island goes"
            refuse("calculator", energy, rule)
        return np.asarray(forces)

    def finished(self, shifts: Array) -> ase.Atoms:
        """A copy of the atoms as given, the island shifted, their energy and forces with them."""
        from ase.calculators.singlepoint import SinglePointCalculator

        atoms, energy = self.given.copy(), self.energy(shifts)
        atoms.positions[self.moving] = self._here.positions[self.moving]
        forces = self._here.get_forces(apply_constraint=False)
        atoms.calc = SinglePointCalculator(atoms, energy=energy, forces=forces)
        return atoms

    # -- the methods of an ASE constraint ---------------------------------------------------------------
    def adjust_positions(self, atoms: ase.Atoms, new: Array) -> None:
        shifts = self.free(new[self.moving] - self.rest)
        new[:] = self.given.positions
        new[self.moving] = self.rest + shifts

    def adjust_forces(self, atoms: ase.Atoms, forces: Array) -> None:
        self.evaluations += 1
        free = self.free(forces[self.moving])
        forces[:] = 0.0
        forces[self.moving] = free

    def __deepcopy__(self, memo: dict[int, object]) -> MovingIsland:
        return self


def by_bands(island: MovingIsland) -> Ends:
    """The lowest minimum found from 16 places and along the bands, and the lowest saddle of four bands."""
    starts = [island.shifted([i / 4.0, j / 4.0]) for i in range(4) for j in range(4)]
    found = (_relaxed(island, start) for start in starts)
    lowest = _level(island, min(found, key=island.energy))
    for _ in range(_MOST_MINIMA):
        tops = []
        for step in _STEPS:
            band = _band(island, lowest, island.shifted(step))
            heights = [island.energy(shifts) for shifts in band]
            low = int(np.argmin(heights))
            deeper = heights[low] < heights[0] - _KNOWN * island.force * island.radian
            if deeper and 0 < low < _IMAGES - 1:
                lowest = _level(island, _relaxed(island, band[low]))
                break
            tops.append(_level(island, band[int(np.argmax(heights[1:-1])) + 1]))
        else:
            return Ends(lowest, min(tops, key=island.energy))
    raise InputError(
        "atoms: bands lead to ever lower minima; take rigid=True or atoms that hold together more stiffly"
    )


def _relaxed(island: MovingIsland, shifts: Array) -> Array:
    """The minimum that L-BFGS finds from `shifts`."""
    from scipy.optimize import minimize

    def energy_and_slope(q: Array) -> tuple[float, Array]:
        there = island.radian * q.reshape(shifts.shape)
        slope = -island.free(island.forces(there)).ravel() / island.force
        return island.energy(there) / (island.radian * island.force), slope

    options = {"gtol": _LOOSE, "ftol": 0.0, "maxiter": _MOST_STEPS}
    start = (shifts / island.radian).ravel()
    found = minimize(energy_and_slope, start, jac=True, method="L-BFGS-B", options=options)
    if np.abs(found.jac).max() > _LOOSE:
        raise RuntimeError("the forces on the island do not vanish: no minimum was found")
    return island.free(island.radian * found.x.reshape(shifts.shape))


def _level(island: MovingIsland, shifts: Array) -> Array:
    """The nearby shifts at which the forces vanish; `shifts` themselves where none is found."""
    from scipy.optimize import root

    def forces(q: Array) -> Array:
        there = shifts + island.radian * island.free(q.reshape(shifts.shape))
        return (island.free(island.forces(there)) / island.force).ravel()

    options = {"fatol": _TIGHT, "maxiter": 200}
    moved = root(forces, np.zeros(shifts.size), method="krylov", options=options).x
    settled = np.abs(forces(moved)).max() <= 1e-8 and np.abs(moved).max() <= 0.5
    return shifts + island.radian * island.free(moved.reshape(shifts.shape)) * settled


def _band(island: MovingIsland, minimum: Array, step: Array) -> list[Array]:
    """Shifts along the band from `minimum` to its copy at `step`, by ASE's climbing-image NEB."""
    from ase.mep import NEB
    from ase.optimize import FIRE

    class Band(NEB):
        """Keeps the last forces: FIRE requests them three times per step, and a shared calculator forgets them."""

        asked = answer = np.zeros(0)

        def get_forces(self) -> Array:
            here = self.get_positions()
            if not np.array_equal(here, self.asked):
                self.asked, self.answer = here, super().get_forces()
            return self.answer

    shake = np.random.default_rng(0)
    images = []
    for share in np.linspace(0.0, 1.0, _IMAGES):
        # without noise a symmetric band would stay symmetric
        noise = _SHAKE * island.radian * shake.standard_normal(minimum.shape)
        inner = 0.0 if share in (0.0, 1.0) else 1.0
        images.append(island.placed(minimum + share * step + inner * noise))
    stiffness = 0.1 * island.force / island.radian
    settings: dict[str, Any] = {"climb": True, "method": "improvedtangent"}
    band = Band(images, k=stiffness, allow_shared_calculator=True, **settings)
    clock = float(np.sqrt(island.radian / island.force))  # of unit masses
    steps = {"dt": 0.1 * clock, "dtmax": clock, "maxstep": 0.2 * island.radian}
    FIRE(band, logfile=os.devnull, **steps).run(fmax=_LOOSE * island.force, steps=_BAND_STEPS)
    return [image.positions[island.moving] - island.rest for image in images]
