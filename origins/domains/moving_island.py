"""An island that is moved through the energy of any ASE calculator, and its easiest way on where its atoms or
height follow: ASE's climbing-image elastic bands.
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

_KNOWN = 1e-9  # in scales.energy: minima nearer than this are the same
_STEPS = ((1, 0), (0, 1), (1, 1), (1, -1))  # periods that bands lead over
_IMAGES = 11
_SHAKE = 0.02  # radians
_LOOSE, _TIGHT = 1e-2, 1e-10  # of the greatest force: left by ASE, and by Newton's method after it
_MOST_STEPS, _BAND_STEPS = 2000, 300  # of a relaxation, of a band: Newton's method does the rest
_DENSE = 90  # coordinates up to which Newton's method takes a whole matrix
_MOST_MINIMA = 10


@dataclass(frozen=True)
class Scales:
    """radian, the shorter period over 2 pi; force, the greatest on one atom; noise, rounding of energies."""

    radian: float
    force: float
    noise: float

    @property
    def energy(self) -> float:
        return self.radian * self.force


@dataclass(frozen=True)
class Ends:
    """Shifts of the atoms (N_a, 3) to the minimum and the saddle, and what is not known of their energies."""

    minimum: Array
    saddle: Array
    error: float


class MovingIsland:
    """Atoms that FixAtoms holds are the surroundings and stay; all others are the island.

    A rigid island is shifted as a whole, a planar one keeps its heights. A flexible one keeps its
    orientation: sum_i r_i0 x u_i = 0 along z, r_i0 its atoms at rest about their centre, u_i their shifts.
    For ASE's tools this is a constraint of the atoms.
    """

    def __init__(self, atoms: ase.Atoms, calculator: Any, rigid: bool, planar: bool) -> None:
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
        self.given, self.calculator = atoms, calculator
        self.rest = atoms.get_positions()[self.moving]
        turn = self.rest.mean(axis=0) - self.rest
        turn = np.column_stack([turn[:, 1], -turn[:, 0], np.zeros(len(turn))])
        # atoms above one another do not turn, but for rounding
        size = max(float(np.linalg.norm(turn)), 1e-12 * float(np.abs(self.rest).max()), 1e-300)
        self._turn = turn / size
        self._here = self.placed(np.zeros_like(self.rest))

    def free(self, shifts: Array) -> Array:
        """What of shifts, or forces, (N_a, 3) is left to the atoms."""
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

    def shifts_of(self, atoms: ase.Atoms) -> Array:
        return np.asarray(atoms.positions[self.moving] - self.rest)

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

    # -- what ASE asks of a constraint -----------------------------------------------------------------
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


def by_bands(island: MovingIsland, scales: Scales, periods: Array) -> Ends:
    """The lowest minimum found from 16 places and along the bands, and the lowest top of four bands."""
    nowhere = np.zeros_like(island.rest)
    starts = [np.array([i, j]) / 4.0 @ periods for i in range(4) for j in range(4)]
    found = (_relaxed(island, scales, nowhere + flat(shift)) for shift in starts)
    lowest = _level(island, scales, min(found, key=island.energy))
    for _ in range(_MOST_MINIMA):
        tops = []
        for step in np.array(_STEPS) @ periods:
            band = _band(island, scales, lowest, flat(step))
            heights = [island.energy(shifts) for shifts in band]
            low = int(np.argmin(heights))
            if heights[low] < heights[0] - _KNOWN * scales.energy and 0 < low < _IMAGES - 1:
                lowest = _level(island, scales, _relaxed(island, scales, band[low]))
                break
            tops.append(_level(island, scales, band[int(np.argmax(heights[1:-1])) + 1]))
        else:
            return Ends(lowest, min(tops, key=island.energy), 0.0)
    raise InputError(
        "atoms: bands lead to ever lower minima; take rigid=True or atoms that hold together more stiffly"
    )


def _relaxed(island: MovingIsland, scales: Scales, shifts: Array) -> Array:
    """The minimum that L-BFGS leads to from `shifts`."""
    from scipy.optimize import minimize

    def energy_and_slope(q: Array) -> tuple[float, Array]:
        there = scales.radian * q.reshape(shifts.shape)
        slope = -island.free(island.forces(there)).ravel() / scales.force
        return island.energy(there) / scales.energy, slope

    options = {"gtol": _LOOSE, "ftol": 0.0, "maxiter": _MOST_STEPS}
    start = (shifts / scales.radian).ravel()
    found = minimize(energy_and_slope, start, jac=True, method="L-BFGS-B", options=options)
    if np.abs(found.jac).max() > _LOOSE:
        raise RuntimeError("the forces on the island do not vanish: no minimum was found")
    return island.free(scales.radian * found.x.reshape(shifts.shape))


def _level(island: MovingIsland, scales: Scales, shifts: Array) -> Array:
    """Where the forces vanish, beside `shifts`; these themselves where none is found."""
    from scipy.linalg import orth
    from scipy.optimize import root

    def forces(q: Array) -> Array:
        there = shifts + scales.radian * island.free(q.reshape(shifts.shape))
        return (island.free(island.forces(there)) / scales.force).ravel()

    nowhere = np.zeros(shifts.size)
    if shifts.size <= _DENSE:
        every = np.eye(shifts.size).reshape(-1, *shifts.shape)
        basis = orth(np.array([island.free(one).ravel() for one in every]))
        found = root(lambda q: forces(basis @ q) @ basis, nowhere @ basis, options={"xtol": 1e-15})
        moved = basis @ found.x
    else:
        options = {"fatol": _TIGHT, "maxiter": 200}
        moved = root(forces, nowhere, method="krylov", options=options).x
    settled = np.abs(forces(moved)).max() <= 1e-8 and np.abs(moved).max() <= 0.5
    moved = scales.radian * island.free(moved.reshape(shifts.shape))
    return shifts + moved if settled else shifts


def _band(island: MovingIsland, scales: Scales, minimum: Array, step: Array) -> list[Array]:
    """Shifts along the way over one step, by ASE's climbing-image NEB."""
    from ase.mep import NEB
    from ase.optimize import FIRE

    class Band(NEB):
        """FIRE asks three times for the forces at each step; images share one calculator, which forgets them."""

        asked = answer = np.zeros(0)

        def get_forces(self) -> Array:
            here = self.get_positions()
            if not np.array_equal(here, self.asked):
                self.asked, self.answer = here, super().get_forces()
            return self.answer

    shake = np.random.default_rng(0)
    images = []
    for share in np.linspace(0.0, 1.0, _IMAGES):
        # a band of one symmetry could not leave it
        noise = _SHAKE * scales.radian * shake.standard_normal(minimum.shape)
        inner = 0.0 if share in (0.0, 1.0) else 1.0
        images.append(island.placed(minimum + share * step + inner * noise))
    stiffness = 0.1 * scales.force / scales.radian
    settings: dict[str, Any] = {"climb": True, "method": "improvedtangent"}
    band = Band(images, k=stiffness, allow_shared_calculator=True, **settings)
    clock = float(np.sqrt(scales.radian / scales.force))  # of unit masses
    steps = {"dt": 0.1 * clock, "dtmax": clock, "maxstep": 0.2 * scales.radian}
    FIRE(band, logfile=os.devnull, **steps).run(fmax=_LOOSE * scales.force, steps=_BAND_STEPS)
    return [island.shifts_of(image) for image in images]


def flat(shift: Array) -> Array:
    """A shift along x and y as one in space."""
    return np.append(shift, 0.0)
