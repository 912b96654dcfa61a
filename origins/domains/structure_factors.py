"""Structure factors S(G) = sum_j exp(i G·r_j) of a rigid island, r_j its atoms about their centre of mass.

An island at R has the energy sum_n c_n S(G_n) exp(i G_n·R) on the substrate sum_n c_n exp(i G_n·r):
it depends on the atoms through S only. To turn the island by an angle, turn the wavevectors by its opposite.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins.domains.islands import positions_of
from origins.errors import finite_array, positive, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Complex = npt.NDArray[np.complex128]
Whole = npt.NDArray[np.int64]

SQUARE = np.eye(2)  # wavevectors of sin x + sin y
_BATCH = 1 << 17  # atoms times waves at once, to stay in the cache
# 2 pi in two parts, the first with few enough bits that its multiples are exact
_TURN, _TURN_REST = 6.28125, 0.0019353071795864769


def structure_factors(
    atoms: ase.Atoms, angle: npt.ArrayLike, wavevectors: npt.ArrayLike = SQUARE
) -> Complex:
    """S(G) of any island turned by `angle` about its centre of mass, summed over the atoms.

    Parameters
    ----------
    atoms : ase.Atoms
        The island; only x and y count, and its masses for the centre.
    angle : float or array
        Radians.
    wavevectors : array of shape (n, 2)
        G, per length; those of sin x + sin y when left out.

    Returns
    -------
    complex array of the shape of angle + (n,)

    Raises InputError for other input.
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
    counts = [_counts(name, value) for name, value in (("n_i", n_i), ("n_j", n_j))]
    try:
        np.broadcast_shapes(counts[0].shape, counts[1].shape, angle.shape)
    except ValueError:
        shapes = f"n_i of shape {counts[0].shape} and n_j of shape {counts[1].shape}"
        refuse("angle", angle, f"must broadcast with {shapes}")
    turned = _turned(angle, wavevectors)
    columns, rows = (count[..., None] for count in counts)
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
    if given.dtype.kind not in "iufO":
        refuse(name, angle, "must be in radians, a number or an array of them, such as 0.3")
    return finite_array(name, given.ravel()).reshape(given.shape)


def _counts(name: str, value: npt.ArrayLike) -> Whole:
    array = np.asarray(value)
    if array.dtype.kind not in "iu" or (array.size and array.min() < 1):
        shown = value if array.dtype.kind not in "iu" else array.min()
        refuse(name, shown, "must be a whole number of at least 1")
    return array.astype(np.int64)
