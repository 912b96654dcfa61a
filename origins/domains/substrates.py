"""Substrates: the energy of one atom above a flat crystal, as a finite Fourier series (paper, Sec. VI C)."""

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np
import numpy.typing as npt

from origins.errors import finite, positive, refuse
from origins.thresholds.law import Array

_LARGEST_DENOMINATOR = 64  # shortest wavevector/(the shortest one of the reciprocal lattice)
_AGREEMENT = 1e-9  # of the longest wavevector: distance at which two wavevectors count as equal


@dataclass(frozen=True, eq=False)
class Substrate:
    """V(r) = constant + Re sum_n c_n exp(i G_n·r), the energy of one atom at r.

    wavevectors : G_n, per length, shape (n, 2); not zero, no two equal or opposite.
    coefficients : c_n, complex energies, shape (n,); not zero.
    constant : energy; no barrier depends on it.

    Made by fourier_substrate, square_substrate or hexagonal_substrate, which check their arguments.
    """

    wavevectors: Array
    coefficients: npt.NDArray[np.complex128]
    constant: float = 0.0

    def energy(self, positions: npt.ArrayLike) -> Array:
        """V at positions of shape (..., 2), lengths; shape (...)."""
        return self.constant + self._waves(positions).real.sum(-1)

    def forces(self, positions: npt.ArrayLike) -> Array:
        """-grad V at positions of shape (..., 2); the same shape, energy per length."""
        return self._waves(positions).imag @ self.wavevectors

    def _waves(self, positions: npt.ArrayLike) -> npt.NDArray[np.complex128]:
        phases = np.asarray(positions, dtype=float) @ self.wavevectors.T
        return self.coefficients * np.exp(1j * phases)

    @cached_property
    def rank(self) -> int:
        """2 for a potential that varies in both directions, 1 where all wavevectors are parallel."""
        largest = float(np.abs(self.wavevectors).max())
        return int(np.linalg.matrix_rank(self.wavevectors, tol=_AGREEMENT * largest))

    @cached_property
    def cell(self) -> Array:
        """The two shortest translations that do not change V, as rows, lengths. Raises InputError where all wavevectors
        are parallel and where they are not whole multiples of two of them, so that V never repeats."""
        if self.rank == 1:
            refuse("wavevectors", self.wavevectors, "are all parallel: there is no cell")
        # the dual of the two shortest wavevectors are the two shortest translations, in the other order
        return np.asarray(2.0 * pi * np.linalg.inv(_shortest_basis(self.wavevectors)).T[::-1])

    @cached_property
    def indices(self) -> npt.NDArray[np.int64]:
        """Whole numbers (n, 2): G_n = indices @ reciprocal basis, that of `cell`; raises InputError as `cell` does."""
        return np.rint(self.wavevectors @ self.cell.T / (2.0 * pi)).astype(np.int64)


def fourier_substrate(
    wavevectors: npt.ArrayLike, coefficients: npt.ArrayLike, constant: float = 0.0
) -> Substrate:
    """V(r) = constant + Re sum_n c_n exp(i G_n·r).

    wavevectors are the G_n, shape (n, 2), per length: equal and opposite ones are combined, G = 0 is added to the
    constant. coefficients are the c_n, real or complex, shape (n,), energies: c_n = A gives A cos(G_n·r), c_n = -1j*A
    gives A sin(G_n·r). Raises InputError for other shapes, values that are not finite, and where V is constant.
    """
    G = vectors(wavevectors)
    try:
        c = np.asarray(coefficients, dtype=complex)
    except (TypeError, ValueError):
        c = np.empty(0, dtype=complex)
    if c.shape != G.shape[:1] or not np.isfinite(c).all():
        refuse("coefficients", coefficients, f"must be {len(G)} finite numbers, one for each wave")
    unit = _AGREEMENT * np.abs(G).max()
    equal, opposite = (np.abs(G[:, None] - sign * G).max(-1) <= unit for sign in (1.0, -1.0))
    # all that belongs to one wave is added to the first of its wavevectors
    first, sums = (equal | opposite).argmax(axis=1), np.zeros_like(c)
    np.add.at(sums, first, np.where(equal[np.arange(len(G)), first], c, c.conj()))
    level = np.abs(G).max(-1) <= unit
    constant = finite("constant", constant) + float(c[level].real.sum())
    # where waves cancel only rounding remains
    kept = ~level & (np.abs(sums) > 1e-15 * np.abs(c).max())
    if not kept.any():
        refuse("wavevectors", G, "leave nothing but a constant; give a wave that is not zero")
    return Substrate(G[kept], sums[kept], constant)


def vectors(value: object, name: str = "wavevectors", such: str = "[[1.0, 0], [0, 1.0]]") -> Array:
    """`value` as an array of shape (n, 2), n >= 1; unless they are finite, InputError says what to write, `such`."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != 2 or not array.size or not np.isfinite(array).all():
        refuse(name, value, f"must be finite and of shape (n, 2), such as {such}")
    return array


def checked_substrate(substrate: Substrate | None) -> Substrate:
    """`substrate`, or sin x + sin y for None; InputError for anything else."""
    if substrate is None:
        return square_substrate()
    if not isinstance(substrate, Substrate):
        refuse("substrate", substrate, "must be a Substrate, such as origins.hexagonal_substrate()")
    return substrate


def square_substrate(amplitude: float = 1.0, period: float = 2.0 * pi) -> Substrate:
    """V = amplitude [sin(2 pi x/period) + sin(2 pi y/period)] (paper, Sec. VI C); amplitude, an energy, and period, a
    length, are above zero, else InputError."""
    amplitude, q = positive("amplitude", amplitude), 2.0 * pi / positive("period", period)
    return fourier_substrate([[q, 0.0], [0.0, q]], [-1j * amplitude, -1j * amplitude])


def hexagonal_substrate(amplitude: float = 1.0, period: float = 2.0 * pi) -> Substrate:
    """V = amplitude sum of three cos(G·r), G of length 4 pi/(sqrt(3) period) at 120° from one another.

    It repeats by `period`, a length above zero, along x. amplitude is an energy and not zero: above zero V peaks at
    3 amplitude over a triangular lattice of atoms with two hollows of -1.5 amplitude per cell; below zero there is one
    well per cell instead. InputError otherwise.
    """
    amplitude, q = finite("amplitude", amplitude), 2.0 * pi / positive("period", period)
    if amplitude == 0.0:
        refuse("amplitude", amplitude, "must not be zero, such as 1.0")
    across = q / sqrt(3.0)
    return fourier_substrate([[q, -across], [0.0, 2.0 * across], [-q, -across]], [amplitude] * 3)


def _shortest_basis(vectors: Array) -> Array:
    """The two shortest of all whole combinations of the vectors (n, 2), as rows, the shortest first (Gauss and Euclid).

    InputError where there is no shortest one: the substrate then never repeats.
    """
    lengths = np.hypot(*vectors.T)
    nothing, least = _AGREEMENT * lengths.max(), lengths.min() / _LARGEST_DENOMINATOR
    pool = vectors
    while True:
        first = pool[np.argmin(np.hypot(*pool.T))]
        if np.hypot(*first) < least:
            refuse("wavevectors", vectors, "never repeat; write whole multiples of two vectors")
        # Gauss's step: less whole multiples of the shortest
        rest = pool - np.rint(pool @ first / (first @ first) * (1.0 - 1e-12))[:, None] * first
        rest = rest[np.hypot(*rest.T) > nothing]
        basis = np.array([first, rest[np.argmin(np.hypot(*rest.T))]])
        # a shorter second vector may be parallel to the first
        if np.hypot(*basis[1]) >= np.hypot(*first) * (1.0 - 1e-12):
            rest = rest - np.rint(rest @ np.linalg.inv(basis)) @ basis
            rest = rest[np.hypot(*rest.T) > nothing]
            if not len(rest):
                return basis
        pool = np.vstack([basis, rest])
