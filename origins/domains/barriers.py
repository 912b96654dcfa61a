"""Barriers of rigid islands: the energy needed to slide one over a substrate at a fixed angle (paper, Sec. VI C).

An island at R has the energy U(R) = sum_n c_n S(G_n) exp(i G_n·R) on the substrate sum_n c_n exp(i G_n·r), with the
structure factor S(G) = sum_j exp(i G·r_j), r_j its atoms about their centre of mass: it depends on the atoms through S
only. To turn the island by an angle, turn the wavevectors by its opposite. Its barrier is the least height over
the lowest minimum of U at which a path leads to a copy of that minimum, in whichever direction is easiest.
On two waves, as in sin x + sin y, that is exactly 2 min(|c_1 S_1|, |c_2 S_2|).
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins.domains.islands import positions_of
from origins.domains.lowest_saddle import Complex, lowest_saddles
from origins.domains.substrates import Substrate, square_substrate
from origins.errors import InputError, finite_array, positive, refuse, whole
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Whole = npt.NDArray[np.int64]

SQUARE = np.eye(2)  # wavevectors of sin x + sin y
_BATCH = 1 << 17  # atoms times waves at once, to stay in the cache
# 2 pi in two parts, the first with few enough bits that its multiples are exact
_TURN, _TURN_REST = 6.28125, 0.0019353071795864769


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
        largest |c_n S(G_n)|. The time is proportional to atoms times angles times waves.

    Raises InputError for other input, for angles beyond a full circle, which look like degrees, and for a
    substrate of more than two waves that never repeats.
    """
    substrate, angle = checked_substrate(substrate), radians(angle)
    return climb(substrate, structure_factors(atoms, angle, substrate.wavevectors))[0][()]


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
    return climb(substrate, factors)[0][()]


def climb(substrate: Substrate, factors: Complex) -> tuple[Array, Array]:
    """Barriers and lowest energies (less N_a times the substrate's constant), each of shape (...), of islands with
    structure factors (..., n)."""
    amplitudes = substrate.coefficients * factors
    sizes = np.abs(amplitudes)
    if substrate.rank == 1:
        return np.zeros(sizes.shape[:-1]), -sizes.sum(-1)
    if sizes.shape[-1] == 2:
        return 2.0 * sizes.min(-1), -sizes.sum(-1)
    found = lowest_saddles(substrate.indices, amplitudes.reshape(-1, sizes.shape[-1]))
    return found.barrier.reshape(sizes.shape[:-1]), found.depth.reshape(sizes.shape[:-1])


def radians(angle: npt.ArrayLike, name: str = "angle") -> Array:
    """`angle` as a float array of its own shape; InputError beyond a full circle, where it looks like degrees."""
    angles = angles_of(angle, name)
    for place in np.flatnonzero(np.abs(angles) > 2.0 * pi * (1.0 + 1e-12)):
        first = float(angles.flat[place])
        write = f"write {np.radians(first):.6g} for {first:g} degrees"
        where = f"{name}[{place}]" if angles.ndim else name
        refuse(where, first, f"angles are in radians, 2 pi at most; {write}")
    return angles


def checked_substrate(substrate: Substrate | None) -> Substrate:
    """`substrate`, or sin x + sin y for None; InputError for anything else."""
    if substrate is None:
        return square_substrate()
    if not isinstance(substrate, Substrate):
        refuse("substrate", substrate, "must be a Substrate, such as origins.hexagonal_substrate()")
    return substrate


def structure_factors(
    atoms: ase.Atoms, angle: npt.ArrayLike, wavevectors: npt.ArrayLike = SQUARE
) -> Complex:
    """S(G) of any island turned by `angle` about its centre of mass, summed over the atoms.

    Only x and y of `atoms` count, and their masses for the centre; angle is in radians, wavevectors (n, 2) per length
    (those of sin x + sin y when left out). The result is complex and has the shape of angle + (n,). Raises InputError
    for other input.
    """
    points = positions_of(atoms)
    turned = _turned(angles_of(angle), wavevectors)
    waves = turned.reshape(-1, 2)
    few = max(1, _BATCH // len(points))
    sums = [
        np.exp(1j * (waves[first : first + few] @ points.T)).sum(-1)
        for first in range(0, len(waves), few)
    ]
    return np.concatenate(sums).reshape(turned.shape[:-1])


def triangular_structure_factors(
    lattice_constant: float,
    n_i: npt.ArrayLike,
    n_j: npt.ArrayLike,
    angle: npt.ArrayLike,
    wavevectors: npt.ArrayLike = SQUARE,
) -> Complex:
    """S(G) of triangular_island(lattice_constant, n_i, n_j) turned by `angle`, by geometric sums at a cost
    that does not grow with N_a.

    n_i, n_j and angle (radians) broadcast; the result is complex and has their shape + (n,), n wavevectors
    (those of sin x + sin y when left out). The error is that of an angle rounded to floating point. Raises
    InputError unless lattice_constant is above zero and n_i, n_j are whole numbers of at least 1.
    """
    a = positive("lattice_constant", lattice_constant)
    angle = angles_of(angle)
    columns, rows = _counts("n_i", n_i)[..., None], _counts("n_j", n_j)[..., None]
    try:
        np.broadcast_shapes(columns.shape[:-1], rows.shape[:-1], angle.shape)
    except ValueError as error:
        raise InputError(f"n_i, n_j, angle: {error}") from error
    turned = _turned(angle, wavevectors)
    even, odd = (rows + 1) // 2, rows // 2
    along, up = a * turned[..., 0], 0.5 * sqrt(3.0) * a * turned[..., 1]
    # distances of the centres of the even and odd rows from the island's centre
    sideways = 0.5 * along / rows
    upwards = np.where(even == odd, 0.5 * up, 0.0)
    total = np.exp(-1j * (sideways * odd + upwards)) * row_sum(even, 2.0 * up)
    total = total + np.exp(1j * (sideways * even + upwards)) * row_sum(odd, 2.0 * up)
    return row_sum(columns, along) * total


def row_sum(n: Whole, theta: Array) -> Array:
    """sin(n theta/2)/sin(theta/2): the sum of n waves with phases theta apart, symmetric about 0."""
    turns = np.rint(theta * (0.5 / pi))
    # theta less whole turns, to the last bit
    half = 0.5 * ((theta - turns * _TURN) - turns * _TURN_REST)
    below = np.sin(half)
    flat = below == 0.0
    sign = np.where((turns * (n - 1)) % 2.0 == 0.0, 1.0, -1.0)
    return sign * np.where(flat, n, np.sin(n * half) / np.where(flat, 1.0, below))


def _turned(angle: Array, wavevectors: npt.ArrayLike) -> Array:
    """Wavevectors in the frame of an island turned by `angle`; shape of angle + (n, 2)."""
    G = np.asarray(wavevectors, dtype=float)
    if G.ndim != 2 or G.shape[1] != 2 or not np.isfinite(G).all():
        rule = "must be finite and of shape (n, 2), such as [[1.0, 0.0], [0.0, 1.0]]"
        refuse("wavevectors", G, rule)
    cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.stack([cos * G[:, 0] + sin * G[:, 1], cos * G[:, 1] - sin * G[:, 0]], axis=-1)


def angles_of(angle: npt.ArrayLike, name: str = "angle") -> Array:
    """`angle` (radians) as a float array of its own shape; InputError unless finite numbers."""
    given = np.asarray(angle)
    return finite_array(name, given.ravel()).reshape(given.shape)


def _counts(name: str, value: npt.ArrayLike) -> Whole:
    """Whole numbers of at least 1, in the shape of `value`."""
    return np.vectorize(lambda n: whole(name, n, 1), otypes=[np.int64])(value)
