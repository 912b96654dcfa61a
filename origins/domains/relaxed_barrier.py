"""The barrier of an island on any ASE calculator, by a Fourier series, or by relaxation and bands.

Where the closed form of a rigid island (triangular_barrier) or the exact search on a Fourier substrate (barrier)
is valid, this gives the same number; for other calculators and for flexible islands it is the only method.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.islands import points_of
from origins.domains.lowest_saddle import Complex, Whole, lowest_saddles
from origins.domains.moving_island import Ends, MovingIsland, by_bands
from origins.errors import refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

_MOST_FLEXIBLE = 1500  # atoms of a flexible island
_GRIDS = (16, 32, 64, 128)  # places along each period at which a rigid island's energy is computed
_FORCES = 1e-3  # of the greatest force: largest difference between forces and the energy's slopes
_POLISHED = 1e-9  # of the largest wave: with a smaller error the search found the saddle itself
_NOTHING = 2e-13  # of the largest wave: smaller waves are ignored
_LEAST_CURVATURE = 1e-6  # of force over radian; at flatter places the stated error is too small


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
    run_time : float
        Seconds.
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

    Energies are in the unit of the calculator, lengths in that of the atoms. For a rigid planar island the energy over
    one cell becomes a Fourier series, on which the search is as exact as `barrier`. Otherwise minima are sought from 16
    places by L-BFGS, and ASE's climbing-image bands lead over four steps of the lattice: the barrier is the lowest of
    the ways tried.

    Both the minimum and the saddle of a flexible island lie no higher than those of the rigid one, since its paths
    include the rigid ones; the barrier, their difference, may be higher or lower.

    Raises InputError for input that cannot be used, RuntimeError where forces do not vanish.
    """
    started = perf_counter()
    for name, value in (("rigid", rigid), ("planar", planar)):
        if not isinstance(value, bool):
            refuse(name, value, "must be True or False")
    points_of(atoms)
    if not hasattr(calculator, "get_forces"):
        rule = "must be an ASE calculator, such as origins.substrate_calculator(substrate)"
        refuse("calculator", type(calculator).__name__, rule)
    cell = _periods(atoms, calculator, periods)
    island = MovingIsland(atoms, calculator, rigid, planar, cell)
    count = len(island.moving)
    if not rigid and count > _MOST_FLEXIBLE:
        rule = f"may hold at most {_MOST_FLEXIBLE} atoms that move by themselves; take rigid=True"
        refuse("atoms", atoms, rule)
    noise = _checked(island)
    ends = _by_search(island, noise) if rigid and planar else by_bands(island)
    minimum, saddle = island.finished(ends.minimum), island.finished(ends.saddle)
    height = float(saddle.get_potential_energy() - minimum.get_potential_energy())
    # forces that remain displace a stationary point by their size over its curvature
    left = [island.free(island.forces(shifts)) for shifts in (ends.minimum, ends.saddle)]
    remain = (count if rigid else 1) * np.abs(left).max() / island.force
    unsure = island.radian * island.force * remain**2 / _LEAST_CURVATURE
    error = float(ends.error + 2.0 * noise + unsure)
    seconds = perf_counter() - started
    return RelaxedBarrier(max(height, 0.0), error, minimum, saddle, island.evaluations, seconds)


def _periods(atoms: ase.Atoms, calculator: Any, given: npt.ArrayLike | None) -> Array:
    """The periods as given, or those of the calculator or of the atoms."""
    if given is None:
        parts = (calculator, *getattr(getattr(calculator, "mixer", None), "calcs", ()))
        known = [getattr(part, "periods", None) for part in parts]
        found = [np.asarray(one) for one in known if one is not None]
        cell = np.asarray(atoms.cell)[np.asarray(atoms.pbc)]
        flat = cell[np.abs(cell[:, 2]) <= 1e-9 * np.linalg.norm(cell, axis=1)][:, :2]
        if not found and len(flat) == 2:
            found = [flat]
        if not found:
            rule = "must be given, such as [[2.5, 0.0], [0.0, 2.5]]: no atoms or calculator tell"
            refuse("periods", None, rule)
        if any((one != found[0]).any() for one in found):
            rule = "must be given, as the parts of the calculator have different ones"
            refuse("periods", None, rule)
        given = found[0]
    try:
        periods: Array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        periods = np.empty(0)
    right = periods.shape == (2, 2) and np.isfinite(periods).all()
    if not right or not abs(np.linalg.det(periods)) > 1e-6 * (periods**2).sum():
        rule = "must be two vectors that are not parallel, such as [[2.5, 0.0], [0.0, 2.5]]"
        refuse("periods", given, rule)
    return periods


def _checked(island: MovingIsland) -> float:
    """Rounding of energies; InputError where there are no forces, or where the periods change the energy."""
    force, radian = island.force, island.radian
    if force == 0.0:
        rule = "must give forces that change as the island moves"
        refuse("calculator", "no force anywhere", rule)
    count, far = len(island.moving), float(np.abs(island.rest).max())
    most = np.abs(island.energies).max() + count * force * (radian + far)
    noise = 8.0 * float(np.finfo(float).eps * most)
    for number, period in enumerate(island.periods):
        moved = island.places + island.shifted(np.eye(2)[number])
        off = np.abs([island.energy(at) for at in moved] - island.energies).max()
        if off > 1e-9 * force * radian + 4.0 * noise:
            shown = f"({period[0]:.6g}, {period[1]:.6g})"
            rule = f"must leave energies as they are; moved by {shown} they change by {off:.2g}"
            refuse("periods", island.periods, rule)
    return noise


def _series(island: MovingIsland, noise: float) -> tuple[Whole, Complex]:
    """Energy of the shifted island as a Fourier series: U = Re sum_n c_n exp(2 pi i K_n·share).

    Returns whole numbers K (n, 2) and c (n,), from the first grid whose unresolved part is only rounding.
    """

    @cache
    def energy(i: int, j: int) -> float:
        island.evaluations += 1
        return island.energy(island.shifted([i / _GRIDS[-1], j / _GRIDS[-1]]))

    for count in _GRIDS:
        places = range(0, _GRIDS[-1], _GRIDS[-1] // count)
        energies = [[energy(i, j) for j in places] for i in places]
        waves = np.fft.fft2(energies) / count**2
        numbers = np.rint(np.fft.fftfreq(count, 1.0 / count)).astype(int)
        K = np.stack(np.meshgrid(numbers, numbers, indexing="ij"), axis=-1).reshape(-1, 2)
        sizes = np.abs(waves.ravel())
        if sizes[np.abs(K).max(-1) > count // 3].max() <= noise:
            break
    # one of each pair of opposite waves, without those of the edge, which are their own opposites
    kept = ((K[:, 0] > 0) | ((K[:, 0] == 0) & (K[:, 1] > 0))) & (np.abs(K).max(-1) < count // 2)
    kept &= sizes > noise / count
    return K[kept], 2.0 * waves.ravel()[kept]


def _by_search(island: MovingIsland, noise: float) -> Ends:
    """Minimum and saddle of a rigid island, by the exact search on a Fourier series."""
    nowhere = np.zeros_like(island.rest)
    K, c = _series(island, noise)
    if not len(K):
        return Ends(nowhere, nowhere, noise)
    share = np.array([0.123, 0.456])
    force = island.forces(island.shifted(share)).sum(axis=0)[:2]
    slopes = -(c * np.exp(2j * np.pi * (K @ share))).imag @ (2.0 * np.pi * K)
    expected = -np.linalg.solve(island.periods, slopes)
    if np.abs(force - expected).max() > _FORCES * island.force:
        name = type(island.calculator).__name__
        refuse("calculator", name, "forces must be those of its energy")
    climbs = lowest_saddles(K, c[None])
    size = float(np.abs(c).max())
    on_grid = float(climbs.error[0]) if climbs.error[0] > _POLISHED * size else 0.0
    minimum, saddle = (
        island.shifted(t[0] / (2.0 * np.pi)) for t in (climbs.minimum, climbs.saddle)
    )
    return Ends(minimum, saddle, on_grid + _NOTHING * size)
