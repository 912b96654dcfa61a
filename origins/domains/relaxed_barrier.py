"""The barrier an island must climb to move on, for any ASE calculator: a Fourier series, or relaxation and bands.

Where the closed form of a rigid island (triangular_barrier) or the exact search on a Fourier substrate (barrier)
holds, this is a second road to the same number; for other calculators and for flexible islands it is the only one.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.lowest_saddle import lowest_saddles
from origins.domains.moving_island import Ends, MovingIsland, Scales, by_bands, flat
from origins.domains.structure_factors import Complex, Whole
from origins.errors import refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

_MOST_FLEXIBLE = 1500  # atoms that move by themselves
_GRIDS = (16, 32, 64, 128)  # places along each period where a rigid island's energy is asked
_FORCES = 1e-3  # of the greatest force: where forces belong to another energy they are further off
_POLISHED = 1e-9  # of the largest wave: the search found the saddle itself
_NOTHING = 2e-13  # of the largest wave: waves below do not count
_LEAST_CURVATURE = 1e-6  # of force over radian: flatter places are known less well than is said


@dataclass(frozen=True, eq=False)
class RelaxedBarrier:
    """What relaxed_barrier found.

    Attributes
    ----------
    barrier : float
        Energy of the saddle above the minimum, at least zero.
    barrier_error : float
        How far it may be off by forces that remain and by rounding; it does not know of ways that were not found.
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
        The island, turned as it shall stand (atoms.rotate). Atoms that FixAtoms holds are not part of it but of its
        surroundings, such as a slab. Left as they are.
    calculator : ASE calculator
        Energy and forces of all atoms: substrate_calculator, any other, or ASE's SumCalculator of several. Its units
        are those of the result.
    rigid : bool
        True moves the island as a whole, without turning it. False lets every atom move; the calculator must then
        hold the island together. Its orientation is held as by the crystal around it: sum_i r_i0 x u_i = 0, r_i0
        the atoms as given about their centre, u_i their displacements along the plane.
    planar : bool
        True keeps all heights z; False lets them follow the forces.
    periods : array of shape (2, 2)
        Two translations along x and y that change no energy. When left out: those a substrate_calculator knows, also
        within a SumCalculator; else the cell vectors of the atoms along which they are periodic.

    Energies are in the unit of the calculator, lengths in that of the atoms. For a rigid planar island the energy over
    one cell becomes a Fourier series, on which the search is as exact as `barrier`. Otherwise minima are sought from 16
    places by L-BFGS, and ASE's climbing-image bands lead over four steps of the lattice: the barrier is the lowest of
    the ways tried.

    With its atoms free both the minimum and the saddle of an island lie no higher than those of the rigid one, as its
    paths hold the rigid ones; the barrier, their difference, may lie on either side.

    Raises InputError for input that cannot be used, RuntimeError where forces do not vanish.
    """
    started = perf_counter()
    for name, value in (("rigid", rigid), ("planar", planar)):
        if not isinstance(value, bool):
            refuse(name, value, "must be True or False")
    for method in ("get_positions", "constraints", "cell"):
        if not hasattr(atoms, method):
            rule = "must be an ase.Atoms, such as origins.triangular_island(2.5, 10, 9)"
            refuse("atoms", atoms, rule)
    if not hasattr(calculator, "get_forces"):
        rule = "must be an ASE calculator, such as origins.substrate_calculator(substrate)"
        refuse("calculator", type(calculator).__name__, rule)
    if len(atoms) == 0 or not np.isfinite(atoms.get_positions()).all():
        refuse("atoms", atoms, "must hold at least one atom, all at finite positions")
    cell = _periods(atoms, calculator, periods)
    island = MovingIsland(atoms, calculator, rigid, planar)
    if not rigid and len(island.moving) > _MOST_FLEXIBLE:
        rule = f"may hold at most {_MOST_FLEXIBLE} atoms that move by themselves; take rigid=True"
        refuse("atoms", atoms, rule)
    scales = _scales(island, cell)
    ends = (_rigid if rigid and planar else by_bands)(island, scales, cell)
    minimum, saddle = island.finished(ends.minimum), island.finished(ends.saddle)
    height = float(saddle.get_potential_energy() - minimum.get_potential_energy())
    # forces that remain move a point that is level by themselves over its curvature
    left = [island.free(island.forces(shifts)) for shifts in (ends.minimum, ends.saddle)]
    together = len(island.moving) if rigid else 1
    remain = together * np.abs(left).max() / scales.force
    error = ends.error + 2.0 * scales.noise + scales.energy * remain**2 / _LEAST_CURVATURE
    seconds = perf_counter() - started
    return RelaxedBarrier(
        max(height, 0.0), float(error), minimum, saddle, island.evaluations, seconds
    )


def _periods(atoms: ase.Atoms, calculator: Any, given: npt.ArrayLike | None) -> Array:
    if given is None:
        found = _known_periods(calculator)
        if found is None:
            cell = np.asarray(atoms.cell)[np.asarray(atoms.pbc)]
            flat = cell[np.abs(cell[:, 2]) <= 1e-9 * np.linalg.norm(cell, axis=1)][:, :2]
            found = flat if len(flat) == 2 else None
        if found is None:
            rule = "must be given, such as [[2.5, 0.0], [0.0, 2.5]]: no atoms or calculator tell"
            refuse("periods", None, rule)
        given = found
    try:
        periods: Array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        periods = np.empty(0)
    right = periods.shape == (2, 2) and np.isfinite(periods).all()
    if not right or not abs(np.linalg.det(periods)) > 1e-6 * (periods**2).sum():
        rule = "must be two vectors that are not parallel, such as [[2.5, 0.0], [0.0, 2.5]]"
        refuse("periods", given, rule)
    return periods


def _known_periods(calculator: Any) -> Array | None:
    """Periods of the calculator or of one within a sum of calculators."""
    if getattr(calculator, "periods", None) is not None:
        return np.asarray(calculator.periods)
    parts = getattr(getattr(calculator, "mixer", None), "calcs", ())
    known = [found for found in map(_known_periods, parts) if found is not None]
    if len(known) > 1 and any(
        found.shape != known[0].shape or (found != known[0]).any() for found in known[1:]
    ):
        refuse("periods", None, "must be given, as the parts of the calculator have different ones")
    return known[0] if known else None


def _scales(island: MovingIsland, periods: Array) -> Scales:
    """Scales of length, force and rounding; InputError where the periods change the energy."""
    nowhere = np.zeros_like(island.rest)
    places = [np.array([i + 0.37, j + 0.21]) / 3.0 @ periods for i in range(3) for j in range(3)]
    moved = [nowhere + flat(place) for place in places]
    force = max(float(np.linalg.norm(island.forces(shifts), axis=1).max()) for shifts in moved)
    energies = [island.energy(shifts) for shifts in moved]
    if force == 0.0:
        rule = "must give forces that change as the island moves"
        refuse("calculator", "no force anywhere", rule)
    radian = float(np.linalg.norm(periods, axis=1).min() / (2.0 * np.pi))
    count, far = len(island.moving), float(np.abs(island.rest).max())
    eps = float(np.finfo(float).eps)
    noise = 8.0 * eps * (np.abs(energies).max() + count * force * (radian + far))
    for period in periods:
        off = max(
            abs(island.energy(shifts + flat(period)) - was)
            for shifts, was in zip(moved, energies, strict=True)
        )
        if off > 1e-9 * force * radian + 4.0 * noise:
            shown = f"({period[0]:.6g}, {period[1]:.6g})"
            rule = f"must leave energies as they are; moved by {shown} they change by {off:.2g}"
            refuse("periods", periods, rule)
    return Scales(radian, force, noise)


def _series(island: MovingIsland, scales: Scales, periods: Array) -> tuple[Whole, Complex]:
    """Energy of the shifted island as waves of whole numbers: U = Re sum_n c_n exp(2 pi i K_n·share).

    Returns K (n, 2) and c (n,). The grid is refined until what it does not resolve is rounding.
    """
    energies = np.empty((0, 0))
    for count in _GRIDS:
        known, energies = energies, np.empty((count, count))
        energies[::2, ::2] = known if len(known) else np.nan
        for i, j in np.ndindex(count, count):
            if not len(known) or i % 2 or j % 2:
                shift = flat(np.array([i, j]) / count @ periods)
                energies[i, j] = island.energy(np.broadcast_to(shift, island.rest.shape))
                island.evaluations += 1
        waves = np.fft.fft2(energies) / count**2
        numbers = np.rint(np.fft.fftfreq(count, 1.0 / count)).astype(int)
        K = np.stack(np.meshgrid(numbers, numbers, indexing="ij"), axis=-1).reshape(-1, 2)
        sizes = np.abs(waves.ravel())
        if sizes[np.abs(K).max(-1) > count // 3].max() <= scales.noise:
            break
    # one of each pair of opposite waves, without those of the edge, which are their own opposites
    kept = ((K[:, 0] > 0) | ((K[:, 0] == 0) & (K[:, 1] > 0))) & (np.abs(K).max(-1) < count // 2)
    kept &= sizes > scales.noise / count
    return K[kept], 2.0 * waves.ravel()[kept]


def _rigid(island: MovingIsland, scales: Scales, periods: Array) -> Ends:
    """The lowest minimum and the saddle of the easiest way, by the exact search on a Fourier series."""
    nowhere = np.zeros_like(island.rest)
    K, c = _series(island, scales, periods)
    if not len(K):
        return Ends(nowhere, nowhere, scales.noise)
    share = np.array([0.123, 0.456])
    force = island.forces(nowhere + flat(share @ periods)).sum(axis=0)[:2]
    slopes = -(c * np.exp(2j * np.pi * (K @ share))).imag @ (2.0 * np.pi * K)
    expected = -np.linalg.solve(periods, slopes)
    if np.abs(force - expected).max() > _FORCES * scales.force:
        name = type(island.calculator).__name__
        refuse("calculator", name, "forces must be those of its energy")
    climbs = lowest_saddles(K, c[None])
    size = float(np.abs(c).max())
    on_grid = float(climbs.errors[0]) if climbs.errors[0] > _POLISHED * size else 0.0
    minimum, saddle = (
        nowhere + flat(t[0] / (2.0 * np.pi) @ periods) for t in (climbs.minima, climbs.saddles)
    )
    return Ends(minimum, saddle, on_grid + _NOTHING * size)
