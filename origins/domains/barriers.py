"""Barriers of rigid islands: what it takes to slide one over a substrate at a fixed angle (paper, Sec. VI C).

An island at R has the energy U(R) = sum_n c_n S(G_n) exp(i G_n·R). Its barrier is the least height over the lowest
minimum of U at which a path leads to a copy of that minimum, in whichever direction is easiest. On two waves, as in
sin x + sin y, that is exactly 2 min(|c_1 S_1|, |c_2 S_2|).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins.domains.landscapes import Landscapes
from origins.domains.lowest_saddle import Climbs, lowest_of_parallel, lowest_saddles
from origins.domains.structure_factors import (
    Complex,
    Whole,
    angles_of,
    checked_island,
    structure_factors,
    triangular_magnitude,
    triangular_structure_factors,
)
from origins.domains.substrates import Substrate, square_substrate
from origins.errors import refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

_BLOCK = 1 << 13  # islands at once, to stay in the cache
_NOTHING = 1e-13  # against the largest wave, smaller ones count as none
_FULL_CIRCLE = 2.0 * np.pi * (1.0 + 1e-12)  # as rounded by whoever wrote it


def barrier(atoms: ase.Atoms, angle: npt.ArrayLike, substrate: Substrate | None = None) -> Array:
    """Barrier of any rigid island turned by `angle` about its centre of mass, an energy.

    Parameters
    ----------
    atoms : ase.Atoms
        The island; only x and y of its atoms count, and all feel the substrate alike.
    angle : float or array
        Radians.
    substrate : Substrate
        sin x + sin y when left out.

    Returns
    -------
    array of the shape of angle
        Zero where the island slides freely: on a substrate that varies in one direction only, and where its
        structure factors vanish. The atoms are summed over once for each angle and wave. Two waves are exact; for
        more the lowest saddle is known to about 1e-11 of the largest |c_n S(G_n)|, and in valleys that rounding
        makes level to about 1e-3 of it, the accuracy of a grid.

    Raises InputError for other input, for angles beyond a full circle, which look like degrees, and for a substrate of
    more than two waves that never repeats.
    """
    substrate, angle = checked_substrate(substrate), radians(angle)
    if substrate.rank == 1:
        structure_factors(atoms, angle)
        return np.zeros(np.shape(angle))[()]
    return barriers_and_depths(atoms, angle, substrate)[0][()]


def triangular_barrier(
    lattice_constant: float,
    n_i: npt.ArrayLike,
    n_j: npt.ArrayLike,
    angle: npt.ArrayLike,
    substrate: Substrate | None = None,
) -> Array:
    """barrier(triangular_island(lattice_constant, n_i, n_j), angle, substrate) without atoms, at a cost free of N_a.

    n_i, n_j and angle (radians) broadcast to the shape of the result. Raises InputError as barrier does, and unless
    lattice_constant is above zero and n_i, n_j are whole numbers of at least 1.
    """
    substrate, angle = checked_substrate(substrate), radians(angle)
    if substrate.rank == 1:
        _, rows, columns, turned = checked_island(lattice_constant, n_i, n_j, angle)
        return np.zeros(np.broadcast_shapes(rows.shape, columns.shape, turned.shape))[()]
    return triangular_barriers_and_depths(lattice_constant, n_i, n_j, angle, substrate)[0][()]


def barriers_and_depths(
    atoms: ase.Atoms, angle: npt.ArrayLike, substrate: Substrate
) -> tuple[Array, Array]:
    """Barrier and lowest energy (less N_a times the substrate's constant), of the shape of angle."""
    return _solved(substrate, structure_factors(atoms, angle, substrate.wavevectors))


def triangular_barriers_and_depths(
    lattice_constant: float,
    n_i: npt.ArrayLike,
    n_j: npt.ArrayLike,
    angle: npt.ArrayLike,
    substrate: Substrate,
) -> tuple[Array, Array]:
    """The same by closed sums."""
    a, columns, rows, turned = checked_island(lattice_constant, n_i, n_j, angle)
    if len(substrate.coefficients) > 2:
        return _solved(
            substrate, triangular_structure_factors(a, columns, rows, turned, substrate.wavevectors)
        )
    shape = np.broadcast_shapes(columns.shape, rows.shape, turned.shape)
    size = int(np.prod(shape))
    parts = [
        np.broadcast_to(part, shape).ravel() if part.size != 1 else part.ravel()
        for part in (columns, rows)
    ]
    turned = np.broadcast_to(turned, shape).ravel()
    barriers, depths = np.empty(size), np.empty(size)
    for first in range(0, size, _BLOCK):
        block = slice(first, first + _BLOCK)
        n_i, n_j = (part[block] if part.size != 1 else part for part in parts)
        cos, sin = np.cos(turned[block]), np.sin(turned[block])
        one, other = (
            abs(c)
            * triangular_magnitude(a, n_i, n_j, cos * g[0] + sin * g[1], cos * g[1] - sin * g[0])
            for c, g in zip(substrate.coefficients, substrate.wavevectors, strict=True)
        )
        barriers[block] = 2.0 * np.minimum(one, other)
        depths[block] = -one - other
    return barriers.reshape(shape), depths.reshape(shape)


def radians(angle: npt.ArrayLike, name: str = "angle") -> Array:
    """`angle` as a float array of its own shape; InputError beyond a full circle, where it looks like degrees."""
    angles = angles_of(angle, name)
    beyond = np.flatnonzero(np.abs(angles) > _FULL_CIRCLE)
    if beyond.size:
        first = float(angles.flat[beyond[0]])
        rule = f"angles are in radians, 2 pi at most; write {np.radians(first):.6g} for {first:g} degrees"
        refuse(f"{name}[{beyond[0]}]" if angles.ndim else name, first, rule)
    return angles


def checked_substrate(substrate: Substrate | None) -> Substrate:
    """`substrate`, or sin x + sin y for None; InputError for anything else."""
    if substrate is None:
        return square_substrate()
    if not isinstance(substrate, Substrate):
        refuse("substrate", substrate, "must be a Substrate, such as origins.hexagonal_substrate()")
    return substrate


def _solved(substrate: Substrate, factors: Complex) -> tuple[Array, Array]:
    """Barrier and lowest energy for structure factors of shape (..., n), the substrate of rank 2."""
    shape = factors.shape[:-1]
    amplitudes = (substrate.coefficients * factors).reshape(-1, factors.shape[-1])
    sizes = np.abs(amplitudes)
    if sizes.shape[1] == 2:
        return 2.0 * sizes.min(-1).reshape(shape), -sizes.sum(-1).reshape(shape)
    climbs = climbs_of(substrate.indices, amplitudes)
    return climbs.barriers.reshape(shape), climbs.depths.reshape(shape)


def climbs_of(indices: Whole, amplitudes: Complex) -> Climbs:
    """Barriers of U = Re sum_n c_n exp(i K_n·t): whole numbers K (n, 2) and c (landscapes, n), energies.

    Waves below 1e-13 of the largest count as none. Where the rest are parallel the barrier is zero.
    """
    count, waves = len(amplitudes), indices.astype(float)
    sizes = np.abs(amplitudes)
    scale = sizes.max(-1)
    sizes = sizes / np.where(scale > 0.0, scale, 1.0)[:, None]
    out = Climbs(*np.zeros((3, count)), *np.zeros((2, count, 2)))
    there = sizes > _NOTHING
    for pattern in np.unique(there, axis=0):
        if not pattern.any():
            continue
        own = np.flatnonzero((there == pattern).all(-1))
        land = Landscapes(
            waves[pattern], sizes[own][:, pattern], np.angle(amplitudes[own][:, pattern])
        )
        first = land.waves[0]
        crossed = (land.waves[:, 0] * first[1] != land.waves[:, 1] * first[0]).any()
        found = lowest_saddles(land) if crossed else lowest_of_parallel(land)
        for name in ("barriers", "errors", "depths"):
            getattr(out, name)[own] = scale[own] * getattr(found, name)
        out.minima[own], out.saddles[own] = found.minima, found.saddles
    out.errors[:] += 2.0 * _NOTHING * scale * len(indices)
    return out
