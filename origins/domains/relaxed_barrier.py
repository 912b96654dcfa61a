"""The barrier of an island on any ASE calculator: its energy over the cell, all else relaxed, as a Fourier series."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from origins.domains.islands import Atoms, points_of
from origins.domains.lowest_saddle import lowest_saddles
from origins.domains.substrates import vectors
from origins.errors import refuse
from origins.thresholds.law import Array

_SMALL = 1e-7  # of the largest wave: smaller waves are left out of the search
_RELAXED = 1e-3  # of the greatest force on an atom: forces that a relaxation leaves, and differences from slopes


@dataclass(frozen=True, eq=False)
class RelaxedBarrier:
    """What relaxed_barrier found.

    barrier : energy of the saddle above the minimum, at least zero.
    barrier_error : error due to remaining forces and rounding. Where an island is so soft that its energy jumps as it
        is moved, the whole range of that energy: lower ways may exist.
    minimum, saddle : copies of the atoms there, with their energy and forces.
    evaluations, run_time : calls of the calculator, and seconds.
    """

    barrier: float
    barrier_error: float
    minimum: Atoms
    saddle: Atoms
    evaluations: int
    run_time: float


def relaxed_barrier(
    atoms: Atoms,
    calculator: Any,
    *,
    rigid: bool = True,
    planar: bool = True,
    periods: npt.ArrayLike | None = None,
) -> RelaxedBarrier:
    """Lowest energy an island must climb to leave its lowest minimum for a copy of it, one period or more away.

    atoms : the island, ase.Atoms already turned (atoms.rotate). Atoms fixed by FixAtoms are not part of it but of its
        surroundings, such as a slab. The object is not changed.
    calculator : of ASE, in the units of the result: substrate_calculator, a SumCalculator or any other with forces.
    rigid : True moves the island as a whole, without turning it. False lets every atom move; the calculator must then
        hold the island together. It cannot rotate, as if the crystal around prevented that: sum_i r_i0 x u_i = 0, r_i0
        the given atoms about their centre, u_i their displacements along the plane.
    planar : True keeps all heights z; False relaxes them.
    periods : two translations along x and y that change no energy, shape (2, 2). When left out: those of a
        substrate_calculator, also within a SumCalculator; else the cell vectors along which the atoms are periodic.

    The island's centre is moved over one cell, what may relax is relaxed by L-BFGS at each place, and the energy
    becomes a Fourier series, whose lowest minimum and saddle are found as in `barrier`, and then by Newton's method.

    Raises InputError for input that cannot be used.
    """
    started = perf_counter()
    points_of(atoms)
    if not hasattr(calculator, "get_forces"):
        refuse("calculator", calculator, "must be an ASE calculator, as substrate_calculator(...)")
    island = _MovingIsland(atoms, calculator, rigid, planar, _periods(atoms, calculator, periods))
    noise = _checked(island)
    starts, missed = _minimum_and_saddle(island, noise)
    (minimum, force), (saddle, force_there) = map(island.without_force, starts)
    height = float(saddle.get_potential_energy() - minimum.get_potential_energy())
    # forces that remain displace a stationary point by their size divided by its curvature, here 1e-6 of force/radian;
    # at flatter places the stated error is too small
    remain = max(force, force_there) / island.force
    error = missed + 2.0 * noise + island.radian * island.force * remain**2 / 1e-6
    seconds = perf_counter() - started
    return RelaxedBarrier(max(height, 0.0), error, minimum, saddle, island.evaluations, seconds)


class _MovingIsland:
    """The atoms that move, all but those fixed by FixAtoms, and how they may, as relaxed_barrier says.

    Units are the `radian`, the shorter period divided by 2 pi, and the greatest `force` on one atom at nine places.
    """

    def __init__(
        self, atoms: Atoms, calculator: Any, rigid: bool, planar: bool, periods: Array
    ) -> None:
        """Find the atoms that move, and the units; InputError where none, or too many, do."""
        from ase.constraints import FixAtoms

        fixed = [each.index for each in atoms.constraints if isinstance(each, FixAtoms)]
        self.moving = np.delete(np.arange(len(atoms)), np.concatenate([[], *fixed]).astype(int))
        if len(fixed) < len(atoms.constraints) or not self.moving.size:
            refuse("atoms", atoms, "needs some that FixAtoms does not fix, and no other constraint")
        if not rigid and self.moving.size > 1500:
            refuse("atoms", atoms, "may hold at most 1500 that move by themselves; take rigid=True")
        self.rigid, self.planar = rigid, planar
        self.periods, self.evaluations = periods, 0
        self.rest = atoms.positions[self.moving]
        turn = np.cross([0.0, 0.0, 1.0], self.rest - self.rest.mean(axis=0))
        # atoms on one vertical line have no rotation, except by rounding
        size = max(float(np.linalg.norm(turn)), 1e-12 * float(np.abs(self.rest).max()), 1e-300)
        self._turn, self.atoms = turn / size, atoms.copy()
        self.atoms.calc = calculator
        self.radian = float(np.linalg.norm(periods, axis=1).min() / (2.0 * np.pi))
        places = (np.indices((3, 3)).reshape(2, 9).T + np.array([0.37, 0.21])) / 3.0
        forces = [self.energy_and_forces(self.shifted(fraction))[1] for fraction in places]
        self.force = float(np.linalg.norm(forces, axis=-1).max())

    def shifted(self, fraction: npt.ArrayLike) -> Array:
        """Shifts of all atoms by `fraction` (2,) of the periods."""
        return np.broadcast_to(np.append(np.asarray(fraction) @ self.periods, 0.0), self.rest.shape)

    def permitted(self, shifts: Array, centred: bool = False) -> Array:
        """The part of shifts, or forces, (N_a, 3) that the island's motion permits; `centred`: keeping x, y of its
        centre."""
        out = shifts.reshape(self.rest.shape) * [1.0, 1.0, 0.0 if self.planar else 1.0]
        middle = out.mean(axis=0)
        out = middle + 0.0 * out if self.rigid else out - (out * self._turn).sum() * self._turn
        return out - middle * [1.0, 1.0, 0.0] if centred else out

    def energy_and_forces(self, shifts: Array) -> tuple[float, Array]:
        """The energy, and the forces on each atom (N_a, 3); InputError where they are not finite."""
        self.atoms.positions[self.moving] = self.rest + shifts
        energy = float(self.atoms.get_potential_energy())
        forces = self.atoms.get_forces(apply_constraint=False)[self.moving]
        self.evaluations += 1
        if not (np.isfinite(energy) and np.isfinite(forces).all()):
            refuse("calculator", energy, "must give finite energies and forces everywhere")
        return energy, forces

    def relaxed(self, fraction: npt.ArrayLike, change: Array) -> tuple[float, Array]:
        """Energy, and what is added to the shifts by `fraction` of the periods, at the minimum that L-BFGS finds from a
        `change` of them, the centre kept along x and y."""
        place = self.shifted(fraction)
        if self.rigid and self.planar:
            return self.energy_and_forces(place)[0], change

        def scaled(q: Array) -> tuple[float, Array]:
            moved = place + change + self.radian * self.permitted(q, centred=True)
            energy, forces = self.energy_and_forces(moved)
            slopes = -self.permitted(forces, centred=True) / self.force
            return energy / (self.radian * self.force), slopes.ravel()

        options, start = {"gtol": _RELAXED, "ftol": 0.0, "maxiter": 2000}, np.zeros(place.size)
        found = scipy.optimize.minimize(scaled, start, jac=True, method="L-BFGS-B", options=options)
        change = change + self.radian * self.permitted(found.x, centred=True)
        return float(found.fun) * self.radian * self.force, change

    def without_force(self, shifts: Array) -> tuple[Atoms, float]:
        """A copy of all atoms with energy and forces, the island at nearby shifts at which its forces vanish, or at
        `shifts` themselves where none is found; and the force that remains."""
        from ase.calculators.singlepoint import SinglePointCalculator

        def forces(q: Array) -> Array:
            moved = shifts + self.radian * self.permitted(q)
            return (self.permitted(self.energy_and_forces(moved)[1]) / self.force).ravel()

        q, options = np.zeros(shifts.size), {"fatol": 1e-10, "maxiter": 200}
        if np.abs(forces(q)).max() > 1e-10:
            found = scipy.optimize.root(forces, q, method="krylov", options=options).x
            if np.abs(forces(found)).max() <= 1e-8 and np.abs(found).max() <= 0.5:
                q = found
        remaining = self.force * np.abs(forces(q)).max() * (len(self.rest) if self.rigid else 1)
        atoms, of_all = self.atoms.copy(), self.atoms.get_forces(apply_constraint=False)
        energy = self.atoms.get_potential_energy()
        atoms.calc = SinglePointCalculator(atoms, energy=energy, forces=of_all)
        return atoms, float(remaining)


def _periods(atoms: Atoms, calculator: Any, given: npt.ArrayLike | None) -> Array:
    """The periods as given, or those of the calculator or of the atoms."""
    if given is None:
        parts = (calculator, *getattr(getattr(calculator, "mixer", None), "calcs", ()))
        tiled = [each for part in parts if (each := getattr(part, "periods", None)) is not None]
        cell = np.asarray(atoms.cell)[atoms.pbc]
        flat = cell[np.abs(cell[:, 2]) <= 1e-9 * np.linalg.norm(cell, axis=1)][:, :2]
        given = tiled[0] if tiled else flat if len(flat) == 2 else None
    such = "such as [[2.5, 0.0], [0.0, 2.5]]"
    if given is None:
        refuse("periods", None, f"must be given, {such}: no atoms or calculator tell")
    periods = vectors(given, "periods")
    if len(periods) != 2 or not abs(np.linalg.det(periods)) > 1e-6 * (periods**2).sum():
        refuse("periods", given, f"must be two vectors that are not parallel, {such}")
    return periods


def _checked(island: _MovingIsland) -> float:
    """Rounding of energies; InputError where forces are not those of the energy, or periods change the energy."""
    unit, fraction = island.force * island.radian, np.array([0.123, 0.456])
    if unit == 0.0:
        refuse("calculator", "no force anywhere", "must give forces that change with the place")
    energy, forces = island.energy_and_forces(island.shifted(fraction))
    most = abs(energy) + len(forces) * (unit + island.force * float(np.abs(island.rest).max()))
    noise = 8.0 * float(np.finfo(float).eps) * most
    for axis, period in zip(np.eye(2), island.periods, strict=True):
        places = (island.shifted(fraction + step * axis) for step in (1.0, -1e-5, 1e-5))
        there, behind, ahead = (island.energy_and_forces(place)[0] for place in places)
        change, work = abs(there - energy), 2e-5 * forces.sum(axis=0)[:2] @ period
        if change > 1e-9 * unit + 4.0 * noise:
            refuse("periods", period, f"must leave energies equal, and change them by {change:.2g}")
        allowed = 2e-5 * _RELAXED * island.force * np.hypot(*period) + 2.0 * noise
        if abs(behind - ahead - work) > allowed:
            refuse("calculator", island.atoms.calc, "forces must be those of its energy")
    return noise


def _minimum_and_saddle(island: _MovingIsland, noise: float) -> tuple[list[Array], float]:
    """Shifts near the lowest minimum and the saddle, and the search's own error, an energy."""
    for count in (16, 32, 64) if island.rigid and island.planar else (16,):
        places = np.indices((count, count)).reshape(2, -1).T
        energies, change = np.empty(len(places)), np.zeros(island.rest.shape)
        for k, place in enumerate(places):  # the change at the last place is a good first guess
            energies[k], change = island.relaxed(place / count, change)
        waves = np.fft.fft2(energies.reshape(count, count)).ravel() / count**2
        K = (places + count // 2) % count - count // 2
        sizes, highest = np.abs(waves), np.abs(K).max(-1)
        shortest, largest = sizes[highest > count // 3].max(), sizes[1:].max()
        if shortest <= _SMALL * largest:
            break
    # small waves move the stationary points only a little
    kept = (highest > 0) & (highest < count // 2) & (sizes > max(_SMALL * largest, noise / count))
    lowest = lowest_saddles(K[kept], waves[kept][None])
    found = []
    for fraction in np.vstack([lowest.minima, lowest.saddles]) / (2.0 * np.pi):
        _, change = island.relaxed(fraction, change)
        found.append(island.shifted(fraction) + change)
    # where short waves are larger than a hundredth of the largest one the relaxed energy jumps
    return found, 0.0 if shortest <= 1e-2 * largest else float(np.ptp(energies))
