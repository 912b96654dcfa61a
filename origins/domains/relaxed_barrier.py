"""The barrier of an island on any ASE calculator, whose atoms or heights may relax.

U(R), the least energy of the island with its centre at R, repeats with the substrate: from its values on a grid it
becomes a Fourier series, on which the exact search of rigid islands finds the lowest minimum and the lowest saddle.
All coordinates then move together to where the forces vanish.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.islands import points_of
from origins.domains.lowest_saddle import lowest_saddles
from origins.errors import InputError, finite_array, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

# places of the centre along each period; False: where shape or heights relax
_GRIDS = {True: (16, 32, 64, 128), False: (12, 24)}
_OFFSET = np.array([0.37, 0.21])  # grid steps: the island is nowhere symmetric, so that it relaxes
_RESOLVED = 0.03  # of the largest wave: unresolved part of U(R) above which the shape jumps as the centre moves
_SETTLED = 1e-8  # of the greatest force: forces that count as 0


@dataclass(frozen=True, eq=False)
class RelaxedBarrier:
    """What relaxed_barrier found.

    Attributes
    ----------
    barrier : float
        Energy of the saddle above the minimum, at least zero.
    barrier_error : float
        Error due to remaining forces and rounding; it does not include lower ways that were not found.
    minimum, saddle : ase.Atoms
        Copies of the atoms there, with their energy and forces.
    evaluations : int
        Calls of the calculator.
    run_time : float, seconds
    """

    barrier: float
    barrier_error: float
    minimum: ase.Atoms
    saddle: ase.Atoms
    evaluations: int
    run_time: float


def relaxed_barrier(
    atoms: ase.Atoms,
    calculator: Any,
    *,
    rigid: bool = True,
    planar: bool = True,
    periods: npt.ArrayLike | None = None,
) -> RelaxedBarrier:
    """Lowest energy an island must climb to leave its lowest minimum for a copy of it, one period or more away.

    Parameters
    ----------
    atoms : ase.Atoms
        The island, already turned (atoms.rotate). Atoms fixed by FixAtoms are not part of it but of its
        surroundings, such as a slab. The object is not changed.
    calculator : ASE calculator
        Energy and forces of all atoms: substrate_calculator, any other, or ASE's SumCalculator of several. Its units
        are those of the result.
    rigid : bool
        True moves the island as a whole, without turning it. False lets every atom move; the calculator must then
        hold the island together. It cannot rotate, as if the crystal around prevented that: sum_i r_i0 x u_i = 0,
        r_i0 the given atoms about their centre, u_i their displacements along the plane.
    planar : bool
        True keeps all heights z; False relaxes them.
    periods : array of shape (2, 2)
        Two translations along x and y that change no energy. When left out: those of a substrate_calculator, also
        within a SumCalculator; else the cell vectors of the atoms along which they are periodic.

    Energies are in the unit of the calculator, lengths in that of the atoms. A rigid planar island is moved to up to
    128 x 128 places of one cell, on which the search is as exact as `barrier`. One that relaxes does so from its given
    shape with its centre at each of 12 x 12 places, or 24 x 24, and at minimum and saddle in all coordinates.

    Raises InputError for input that cannot be used, and where bonds are so soft that the island jumps from shape to
    shape as its centre moves.
    """
    started = perf_counter()
    points_of(atoms)
    if not hasattr(calculator, "get_forces"):
        rule = "must be an ASE calculator, such as origins.substrate_calculator(substrate)"
        refuse("calculator", type(calculator).__name__, rule)
    island = _Island(atoms, calculator, rigid, planar, _periods(atoms, calculator, periods))
    if not rigid and len(island.rest) > 1500:  # some hours
        refuse("atoms", atoms, "may be at most 1500 that move by themselves; take rigid=True")
    noise = _rounding(island)
    ends, on_grid = _ends(island, noise)
    minimum, saddle = (island.finished(shifts) for shifts in ends)
    height = float(saddle.get_potential_energy() - minimum.get_potential_energy())
    # forces that remain displace a stationary point by their size over its curvature, taken as 1e-6
    remain = max(map(island.unsettled, ends)) * (1 if rigid else len(island.rest))
    unsure = island.radian * island.force * remain**2 / 1e-6
    error, calls = float(on_grid + 2.0 * noise + unsure), island.evaluations
    seconds = perf_counter() - started
    return RelaxedBarrier(max(height, 0.0), error, minimum, saddle, calls, seconds)


def _periods(atoms: ase.Atoms, calculator: Any, given: npt.ArrayLike | None) -> Array:
    """The periods as given, or those of the calculator or of the atoms."""
    if given is None:
        parts = (calculator, *getattr(getattr(calculator, "mixer", None), "calcs", ()))
        found = [part.periods for part in parts if getattr(part, "periods", None) is not None]
        cell = np.asarray(atoms.cell)[np.asarray(atoms.pbc)]
        flat = cell[np.abs(cell[:, 2]) <= 1e-9 * np.linalg.norm(cell, axis=1)][:, :2]
        found += [flat] * (len(flat) == 2)
        if not found:
            rule = "must be given, such as [[2.5, 0.0], [0.0, 2.5]]: no atoms or calculator tell"
            refuse("periods", None, rule)
        given = found[0]
    periods = finite_array("periods", np.ravel(np.asarray(given, dtype=object)))
    area = abs(np.linalg.det(periods.reshape(2, 2))) if periods.size == 4 else 0.0
    if not area > 1e-6 * (periods @ periods):
        rule = "must be two vectors that are not parallel, such as [[2.5, 0.0], [0.0, 2.5]]"
        refuse("periods", given, rule)
    return periods.reshape(2, 2)


class _Island:
    """The atoms that move: all but those fixed by FixAtoms, which are the surroundings. Shifts have shape (N_a, 3).

    Attributes
    ----------
    rest : array (N_a, 3)
        Given positions of the island's atoms.
    radian, force : float
        The shorter period over 2 pi; the greatest force on one atom at nine places of the cell.
    """

    def __init__(
        self, atoms: ase.Atoms, calculator: Any, rigid: bool, planar: bool, periods: Array
    ) -> None:
        from ase.constraints import FixAtoms

        moving = np.ones(len(atoms), dtype=bool)
        for constraint in atoms.constraints:
            if not isinstance(constraint, FixAtoms):
                rule = "must be FixAtoms, which tells the surroundings of the island"
                refuse("atoms.constraints", constraint, rule)
            moving[constraint.index] = False
        if not moving.any():
            refuse("atoms", atoms, "must hold atoms that FixAtoms does not fix: the island")
        self.given, self.periods, self._moving, self.evaluations = atoms, periods, moving, 0
        self.rigid, self.planar = rigid, planar
        self.rest = atoms.positions[moving]
        turn = np.cross(self.rest - self.rest.mean(axis=0), [0.0, 0.0, -1.0])
        # atoms on one vertical line have no rotation, except by rounding
        least = 1e-12 * float(np.abs(self.rest).max()) or 1.0
        self._turn = turn / max(float(np.linalg.norm(turn)), least)
        self._here = atoms.copy()
        self._here.set_constraint()
        self._here.calc = self.calculator = calculator
        self.radian = float(np.linalg.norm(periods, axis=1).min() / (2.0 * np.pi))
        places = [self.shifted((one + _OFFSET) / 3.0) for one in np.ndindex(3, 3)]
        self.force = max(np.linalg.norm(self.forces(at), axis=1).max() for at in places)

    def shifted(self, share: Any) -> Array:
        """Shifts of all atoms by `share` (2,) of the periods."""
        return np.broadcast_to(np.append(share @ self.periods, 0.0), self.rest.shape)

    def free(self, shifts: Array) -> Array:
        """The part of shifts, or forces, that the island may follow."""
        left = shifts * [1.0, 1.0, 0.0] if self.planar else shifts
        if self.rigid:
            return np.broadcast_to(left.mean(axis=0), left.shape)
        return left - (left * self._turn).sum() * self._turn

    def inner(self, shifts: Array) -> Array:
        """The part of it that leaves the centre where it is along the plane."""
        left = self.free(shifts)
        return left - left.mean(axis=0) * [1.0, 1.0, 0.0]

    def energy(self, shifts: Array) -> float:
        """The energy there; InputError where it is no number."""
        self._here.positions[self._moving] = self.rest + shifts
        energy = float(self._here.get_potential_energy())
        if not np.isfinite(energy):
            rule = "must give finite energies and forces wherever the island goes"
            refuse("calculator", energy, rule)
        return energy

    def forces(self, shifts: Array) -> Array:
        """On each atom (N_a, 3)."""
        self.evaluations += 1
        self._here.positions[self._moving] = self.rest + shifts
        return np.asarray(self._here.get_forces()[self._moving])

    def unsettled(self, shifts: Array) -> float:
        """The largest force that the island may follow there, over the greatest one."""
        return float(np.abs(self.free(self.forces(shifts))).max() / self.force)

    def relaxed(self, share: Array) -> Array:
        """The shifts of least energy with the centre at `share` of the periods, by L-BFGS from the given shape."""
        from scipy.optimize import minimize

        centre = self.shifted(share)
        if self.rigid and self.planar:
            return centre

        def energy_and_slope(q: Array) -> tuple[float, Array]:
            there = centre + self.radian * self.inner(q.reshape(centre.shape))
            slope = -self.inner(self.forces(there)).ravel() / self.force
            return self.energy(there) / (self.radian * self.force), slope

        options = {"gtol": 1e-6, "ftol": 0.0}
        start = np.zeros(centre.size)
        found = minimize(energy_and_slope, start, jac=True, method="L-BFGS-B", options=options)
        return centre + self.radian * self.inner(found.x.reshape(centre.shape))

    def settled(self, share: Array) -> Array:
        """The shifts near those of `relaxed` at which all forces vanish; where none are found, these themselves."""
        from scipy.optimize import root

        near = self.relaxed(share)
        if self.unsettled(near) <= 1e-2 * _SETTLED:
            return near

        def forces(q: Array) -> Array:
            there = near + self.radian * self.free(q.reshape(near.shape))
            return (self.free(self.forces(there)) / self.force).ravel()

        options = {"fatol": 1e-2 * _SETTLED, "maxiter": 200}
        with np.errstate(all="ignore"):
            moved = root(forces, np.zeros(near.size), method="krylov", options=options).x
        there = near + self.radian * self.free(moved.reshape(near.shape))
        good = self.unsettled(there) <= _SETTLED and np.abs(moved).max() <= 0.5
        return there if good else near

    def finished(self, shifts: Array) -> ase.Atoms:
        """A copy of the atoms as given, the island shifted, their energy and forces with them."""
        from ase.calculators.singlepoint import SinglePointCalculator

        atoms, energy = self.given.copy(), self.energy(shifts)
        atoms.positions = self._here.positions
        atoms.calc = SinglePointCalculator(atoms, energy=energy, forces=self._here.get_forces())
        return atoms


def _rounding(island: _Island) -> float:
    """Rounding of energies; InputError where forces are none or not the energy's slopes, and for wrong periods."""
    force, radian = island.force, island.radian
    if force == 0.0:
        refuse("calculator", island.calculator, "must give forces that change as the island moves")
    at, far = island.shifted(_OFFSET), float(np.abs(island.rest).max())
    most = abs(island.energy(at)) + len(island.rest) * force * (radian + far)
    noise = 8.0 * float(np.finfo(float).eps * most)
    for share in np.eye(2):
        off = abs(island.energy(at + island.shifted(share)) - island.energy(at))
        if off > 1e-9 * force * radian + 4.0 * noise:
            rule = f"must leave energies as they are; moved by one they change by {off:.2g}"
            refuse("periods", island.periods, rule)
    step = 1e-4 * radian * np.array([0.6, 0.8, 0.0])
    rise = island.energy(at + step) - island.energy(at - step)
    off = abs(rise + 2.0 * float((island.forces(at) @ step).sum()))
    if off > 2e-7 * force * radian + 4.0 * noise:
        refuse("calculator", island.calculator, "forces must be those of its energy")
    return noise


def _ends(island: _Island, noise: float) -> tuple[list[Array], float]:
    """Shifts to minimum and saddle, from the first grid that resolves U(R); the error of the search."""
    stiff = island.rigid and island.planar
    for count in _GRIDS[stiff]:
        shares = (np.array([*np.ndindex(count, count)]) + _OFFSET) / count
        energies = np.array([island.energy(island.relaxed(share)) for share in shares])
        waves = np.fft.fft2(energies.reshape(count, count)).ravel() / count**2
        numbers = np.rint(np.fft.fftfreq(count, 1.0 / count)).astype(int)
        K = np.stack(np.meshgrid(numbers, numbers, indexing="ij"), axis=-1).reshape(-1, 2)
        waves *= np.exp(-2j * np.pi * (K @ _OFFSET) / count)
        sizes, order = np.abs(waves), np.abs(K).max(-1)
        size, unresolved = sizes[1:].max(), sizes[order > count // 3].max()
        if unresolved > (noise if stiff else _RESOLVED * size) and count < _GRIDS[True][-1]:
            continue
        # one of each pair of opposite waves, without those of the edge, which are their own opposites
        kept = ((K[:, 0] > 0) | ((K[:, 0] == 0) & (K[:, 1] > 0))) & (order < count // 2)
        kept &= sizes > (noise / count if stiff else max(noise, 0.1 * unresolved))
        if not kept.any():
            return [np.zeros_like(island.rest)] * 2, noise
        found = lowest_saddles(K[kept], 2.0 * waves[kept][None])
        ends = [island.settled(t[0] / (2.0 * np.pi)) for t in (found.minima, found.saddles)]
        bottom, top = map(island.energy, ends)
        alike = abs(top - bottom - found.barriers[0]) <= _RESOLVED * size
        if stiff or (alike and max(map(island.unsettled, ends)) <= _SETTLED):
            # with a smaller error the search found the saddle itself
            return ends, float(found.errors[0]) if found.errors[0] > 1e-9 * size else 0.0
    rule = "take rigid=True or atoms that hold together more stiffly"
    raise InputError(f"atoms: jump from shape to shape as their centre moves; {rule}")
