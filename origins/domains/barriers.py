"""Barriers of rigid islands: the energy needed to slide one over a substrate at a fixed angle (paper, Sec. VI C).

An island at R has the energy U(R) = sum_n c_n S(G_n) exp(i G_n·R) on the substrate sum_n c_n exp(i G_n·r), with the
structure factor S(G) = sum_j exp(i G·r_j), r_j its atoms about their centre of mass. To turn the island by an angle,
turn the wavevectors by its opposite. Its barrier is the least height over the lowest minimum of U at which a path leads
to a copy of that minimum: on two waves, as in sin x + sin y, exactly 2 min(|c_1 S_1|, |c_2 S_2|).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from origins.domains.calculators import harmonic_bonds, substrate_calculator
from origins.domains.islands import Atoms, positions_of
from origins.domains.lowest_saddle import Complex, lowest_saddles
from origins.domains.relaxed_barrier import relaxed_barrier
from origins.domains.substrates import Substrate, checked_substrate, vectors
from origins.errors import InputError, finite_array, positive, refuse, whole
from origins.thresholds.law import Array

SQUARE = np.eye(2)  # wavevectors of sin x + sin y


def barrier(atoms: Atoms, angle: npt.ArrayLike, substrate: Substrate | None = None) -> Array:
    """Barrier of a rigid island turned by `angle` (radians, any shape) about its centre of mass, energies.

    Only x and y of `atoms` matter, and the substrate, sin x + sin y when left out, acts on all of them equally. The
    barrier is zero where the island slides freely: on a substrate that varies in one direction only, and where its
    structure factors vanish. For two waves it is exact, for more known to about 1e-11 of the largest |c_n S(G_n)|.
    Raises InputError for other input, for angles beyond a full circle, which look like degrees, and for a
    substrate of more than two waves that never repeats.
    """
    substrate, angle = checked_substrate(substrate), radians(angle)
    factors = structure_factors(atoms, angle, substrate.wavevectors)
    return barriers_and_depths(substrate, factors)[0][()]


def triangular_barrier(
    lattice_constant: float,
    n_i: npt.ArrayLike,
    n_j: npt.ArrayLike,
    angle: npt.ArrayLike,
    substrate: Substrate | None = None,
) -> Array:
    """barrier(triangular_island(lattice_constant, n_i, n_j), angle, substrate), at a cost independent of N_a.
    n_i, n_j and angle (radians) broadcast to the shape of the result. Raises InputError as these two do."""
    substrate, angle = checked_substrate(substrate), radians(angle)
    factors = triangular_structure_factors(lattice_constant, n_i, n_j, angle, substrate.wavevectors)
    return barriers_and_depths(substrate, factors)[0][()]


def barriers_and_depths(substrate: Substrate, factors: Complex) -> tuple[Array, Array]:
    """Barriers and lowest energies, less N_a times the constant, shapes (...), for structure factors (..., n)."""
    amplitudes = substrate.coefficients * factors
    sizes = np.abs(amplitudes)
    if substrate.rank == 1:
        return np.zeros(sizes.shape[:-1]), -sizes.sum(-1)
    if sizes.shape[-1] == 2:
        return 2.0 * sizes.min(-1), -sizes.sum(-1)
    found = lowest_saddles(substrate.indices, amplitudes.reshape(-1, sizes.shape[-1]))
    return found.barriers.reshape(sizes.shape[:-1]), found.depths.reshape(sizes.shape[:-1])


class Island(NamedTuple):
    """One kind of island on a substrate: number of atoms, largest derivative of their phases with the angle, structure
    factors at angles, of their shape + (n,); where its atoms relax, barrier and lowest energy at each angle."""

    substrate: Substrate
    atoms: int
    phase_slope: float
    factors: Callable[[Array], Complex]
    relaxed: dict[float, tuple[float, float]] | None = None

    @classmethod
    def triangular(cls, substrate: Substrate, a: float, n_i: int, n_j: int) -> Island:
        """triangular_island(a, n_i, n_j), without its atoms."""
        G, furthest = substrate.wavevectors, 0.5 * a * np.hypot(n_i - 0.5, sqrt(0.75) * (n_j - 1.0))
        factors = partial(triangular_structure_factors, a, n_i, n_j, wavevectors=G)
        return cls(substrate, n_i * n_j, float(furthest * np.hypot(*G.T).max()), factors)

    @classmethod
    def of_atoms(cls, substrate: Substrate, atoms: Atoms) -> Island:
        """The rigid island of these atoms."""
        G, furthest = substrate.wavevectors, np.hypot(*positions_of(atoms).T).max()
        factors = partial(structure_factors, atoms, wavevectors=G)
        return cls(substrate, len(atoms), float(furthest * np.hypot(*G.T).max()), factors)

    def relaxing(self, atoms: Atoms, bonds: float, angles: Array) -> Island:
        """This island of `atoms` with harmonic bonds of a stiffness; it takes seconds for each of the angles."""
        from ase.calculators.mixing import SumCalculator

        relaxed = {}
        for angle in np.unique(angles).tolist():
            turned = atoms.copy()
            turned.rotate(np.degrees(angle), "z", center="COM")
            parts = [substrate_calculator(self.substrate), harmonic_bonds(turned, bonds)]
            found = relaxed_barrier(turned, SumCalculator(parts), rigid=False)
            lowest = float(found.minimum.get_potential_energy())
            if found.barrier_error > 1e-3 * max(found.barrier, -1e-6 * lowest):
                refuse("bonds", bonds, f"lets the island's shape jump at {angle:.6g}; stiffen them")
            relaxed[angle] = found.barrier, lowest
        return self._replace(relaxed=relaxed)

    @property
    def largest_energy(self) -> float:
        """Upper bound of its energy."""
        return self.atoms * float(np.abs(self.substrate.coefficients).sum())

    def barriers_and_depths(self, angle: Array) -> tuple[Array, Array]:
        """Barriers, 0 for those that are only rounding, and lowest energies at angles (m,)."""
        if self.relaxed is None:
            barriers, depths = barriers_and_depths(self.substrate, self.factors(angle))
        else:
            barriers, depths = np.array([self.relaxed[each] for each in angle.tolist()]).T
        return np.where(barriers <= 1e-12 * self.largest_energy, 0.0, barriers), depths

    def angles_needed(self, temperature: float) -> int:
        """How many equidistant angles resolve exp(-U_min/k_BT): near its minimum U_min/k_BT, and everywhere the
        outermost atoms' phase, changes by at most about a quarter between them. InputError for too many."""
        per_radian = max(4.0, 2.0 * np.sqrt(self.largest_energy / temperature))
        count, most = 2.0 * np.pi * self.phase_slope * per_radian, 4_000_000
        if not count <= most:
            fault = f"needs {count:.2g} angles, more than {most}"
            raise InputError(f"temperature: {fault}; list angles, such as [0.0, 0.1], or heat more")
        return max(64, round(count))


def radians(angle: npt.ArrayLike, name: str = "angle", most: float = 2.0 * pi) -> Array:
    """`angle` as a float array of its own shape; InputError beyond `most`, where it looks like degrees."""
    given = np.asarray(angle)
    angles: Array = finite_array(name, given.ravel()).reshape(given.shape)
    if (far := np.abs(angles) > most * (1.0 + 1e-12)).any():
        first, at = float(angles[far].flat[0]), f"[{np.flatnonzero(far)[0]}]" if angles.ndim else ""
        write = f"write {np.radians(first):.6g} for {first:g} degrees"
        refuse(name + at, first, f"angles are in radians, 2 pi at most; {write}")
    return angles


def structure_factors(
    atoms: Atoms, angle: npt.ArrayLike, wavevectors: npt.ArrayLike = SQUARE
) -> Complex:
    """S(G) of any island turned by `angle` (radians) about its centre of mass, summed over x and y of the atoms;
    wavevectors (n, 2) per length. The result has the shape of angle + (n,). InputError for other input."""
    points = positions_of(atoms)
    turned = _turned(radians(angle, most=inf), wavevectors)
    waves = np.stack([turned.real.ravel(), turned.imag.ravel()], axis=-1)
    # few waves at once, so that the phases of all atoms stay in the cache
    parts = np.array_split(waves, 1 + len(waves) * len(points) // (1 << 17))
    sums = [np.exp(1j * (part @ points.T)).sum(-1) for part in parts]
    return np.concatenate(sums).reshape(turned.shape)


def triangular_structure_factors(
    lattice_constant: float,
    n_i: npt.ArrayLike,
    n_j: npt.ArrayLike,
    angle: npt.ArrayLike,
    wavevectors: npt.ArrayLike = SQUARE,
) -> Complex:
    """structure_factors of triangular_island(lattice_constant, n_i, n_j), at a cost independent of N_a; n_i, n_j and
    angle broadcast. The error is that of an angle rounded to floating point. Raises InputError as these two do."""
    a, angle = positive("lattice_constant", lattice_constant), radians(angle, most=inf)
    numbers = np.vectorize(lambda name, n: whole(name, n, 1), otypes=[int])
    columns, rows = numbers("n_i", n_i)[..., None], numbers("n_j", n_j)[..., None]
    turned = _turned(angle, wavevectors)
    even, odd = (rows + 1) // 2, rows // 2
    along, up = a * turned.real, 0.5 * sqrt(3.0) * a * turned.imag
    # distances of the centres of the even and odd rows from the island's centre
    sideways = 0.5 * along / rows
    upwards = np.where(even == odd, 0.5 * up, 0.0)
    total = np.exp(-1j * (sideways * odd + upwards)) * row_sum(even, 2.0 * up)
    total = total + np.exp(1j * (sideways * even + upwards)) * row_sum(odd, 2.0 * up)
    return row_sum(columns, along) * total


def row_sum(n: npt.NDArray[np.int_], theta: Array) -> Array:
    """sin(n theta/2)/sin(theta/2): the sum of n waves with phases theta apart, symmetric about 0."""
    turns = np.rint(theta / (2.0 * pi))
    half = 0.5 * (theta - 2.0 * pi * turns)  # scipy's diric loses its digits near 2 pi
    sign = np.where((turns * (n - 1)) % 2.0 == 0.0, 1.0, -1.0)
    below = np.sin(half)
    with np.errstate(invalid="ignore"):
        return sign * np.where(below == 0.0, n, np.sin(n * half) / below)


def _turned(angle: Array, wavevectors: npt.ArrayLike) -> Complex:
    """Wavevectors, as x + iy, in the frame of an island turned by `angle`; shape of angle + (n,)."""
    return np.asarray(vectors(wavevectors) @ [1.0, 1j] * np.exp(-1j * angle)[..., None])
