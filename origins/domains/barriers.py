"""Barriers of rigid islands: the energy needed to slide one over a substrate at a fixed angle (paper, Sec. VI C).

An island at R has the energy U(R) = sum_n c_n S(G_n) exp(i G_n·R). Its barrier is the least height over
the lowest minimum of U at which a path leads to a copy of that minimum, in whichever direction is easiest.
On two waves, as in sin x + sin y, that is exactly 2 min(|c_1 S_1|, |c_2 S_2|).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins.domains.lowest_saddle import Complex, lowest_saddles
from origins.domains.structure_factors import (
    angles_of,
    structure_factors,
    triangular_structure_factors,
)
from origins.domains.substrates import Substrate, square_substrate
from origins.errors import refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

_FULL_CIRCLE = 2.0 * np.pi * (1.0 + 1e-12)  # radians, with room for rounding


def barrier(atoms: ase.Atoms, angle: npt.ArrayLike, substrate: Substrate | None = None) -> Array:
    """Barrier of any rigid island turned by `angle` about its centre of mass, an energy.

    Parameters
    ----------
    atoms : ase.Atoms
        The island; only x and y of its atoms matter, and the substrate acts on all atoms equally.
    angle : float or array
        Radians.
    substrate : Substrate
        sin x + sin y when left out.

    Returns
    -------
    array of the shape of angle
        Zero where the island slides freely: on a substrate that varies in one direction only, and where
        its structure factors vanish. For two waves it is exact; for more it is known to about 1e-11 of the
        largest |c_n S(G_n)|, and to about 1e-3 of it in valleys too flat or too narrow for a grid, where one
        wave is far larger than the others. The time is proportional to atoms times angles times waves.

    Raises InputError for other input, for angles beyond a full circle, which look like degrees, and for a
    substrate of more than two waves that never repeats.
    """
    substrate, angle = checked_substrate(substrate), radians(angle)
    return climb(substrate, structure_factors(atoms, angle, substrate.wavevectors)).barriers[()]


def triangular_barrier(
    lattice_constant: float,
    n_i: npt.ArrayLike,
    n_j: npt.ArrayLike,
    angle: npt.ArrayLike,
    substrate: Substrate | None = None,
) -> Array:
    """barrier(triangular_island(lattice_constant, n_i, n_j), angle, substrate) without atoms, at a cost
    that does not grow with N_a.

    n_i, n_j and angle (radians) broadcast to the shape of the result. Raises InputError as barrier does,
    and unless lattice_constant is above zero and n_i, n_j are whole numbers of at least 1.
    """
    substrate, angle = checked_substrate(substrate), radians(angle)
    waves = substrate.wavevectors
    factors = triangular_structure_factors(lattice_constant, n_i, n_j, angle, waves)
    return climb(substrate, factors).barriers[()]


@dataclass(frozen=True)
class Climb:
    """Barriers and lowest energies (less N_a times the substrate's constant), arrays of one shape."""

    barriers: Array
    depths: Array


def climb(substrate: Substrate, factors: Complex) -> Climb:
    """Barriers and lowest energies of islands with structure factors (..., n); arrays of shape (...)."""
    amplitudes = substrate.coefficients * factors
    sizes = np.abs(amplitudes)
    if substrate.rank == 1:
        return Climb(np.zeros(sizes.shape[:-1]), -sizes.sum(-1))
    if sizes.shape[-1] == 2:
        return Climb(2.0 * sizes.min(-1), -sizes.sum(-1))
    found = lowest_saddles(substrate.indices, amplitudes.reshape(-1, sizes.shape[-1]))
    shape = sizes.shape[:-1]
    return Climb(found.barriers.reshape(shape), found.depths.reshape(shape))


def radians(angle: npt.ArrayLike, name: str = "angle") -> Array:
    """`angle` as a float array of its own shape; InputError beyond a full circle, where it looks like degrees."""
    angles = angles_of(angle, name)
    beyond = np.flatnonzero(np.abs(angles) > _FULL_CIRCLE)
    if beyond.size:
        first = float(angles.flat[beyond[0]])
        write = f"write {np.radians(first):.6g} for {first:g} degrees"
        where = f"{name}[{beyond[0]}]" if angles.ndim else name
        refuse(where, first, f"angles are in radians, 2 pi at most; {write}")
    return angles


def checked_substrate(substrate: Substrate | None) -> Substrate:
    """`substrate`, or sin x + sin y for None; InputError for anything else."""
    if substrate is None:
        return square_substrate()
    if not isinstance(substrate, Substrate):
        refuse("substrate", substrate, "must be a Substrate, such as origins.hexagonal_substrate()")
    return substrate
