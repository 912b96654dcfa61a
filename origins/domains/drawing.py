"""Islands drawn at random, with angle and barrier; each sample depends on the seed and its own number only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.barriers import (
    Climb,
    climb,
    structure_factors,
    triangular_structure_factors,
)
from origins.domains.islands import positions_of
from origins.domains.lowest_saddle import Complex
from origins.domains.substrates import Substrate
from origins.errors import InputError
from origins.streams import key_of
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Whole = npt.NDArray[np.int64]

_BLOCK = 4096  # samples computed together, always by one rank
_PHASE = 0.25  # radians: change of the outermost atoms' phase between neighbouring trial angles
_EXPONENT = 0.5  # U_min/k_BT near its minimum changes by about the square of this between them
_MOST_ANGLES = 4_000_000


@dataclass(frozen=True)
class Island:
    """One kind of island on a substrate: its number of atoms, the distance of the outermost from the centre (a
    length), and its structure factors (m, n) at angles (m,) in radians; where its atoms relax, barrier and lowest
    energy at each angle."""

    substrate: Substrate
    atoms: int
    reach: float
    factors: Callable[[Array], Complex]
    relaxed: dict[float, tuple[float, float]] | None = None

    @property
    def energy(self) -> float:
        """Upper bound of its energy."""
        return self.atoms * float(np.abs(self.substrate.coefficients).sum())

    @property
    def phase(self) -> float:
        """Largest derivative of the outermost atoms' phase with the angle."""
        return self.reach * float(np.hypot(*self.substrate.wavevectors.T).max())

    def sizes(self, angle: Array) -> Array:
        """|c_n S(G_n)| at angles (m,), energies of shape (m, n)."""
        return np.abs(self.substrate.coefficients * self.factors(angle))

    def climb(self, angle: Array) -> Climb:
        """Barriers and lowest energies at angles (m,)."""
        if self.relaxed is not None:
            return Climb(*np.array([self.relaxed[one] for one in angle.tolist()]).T)
        return climb(self.substrate, self.factors(angle))


def triangular(substrate: Substrate, a: float, n_i: int, n_j: int) -> Island:
    """triangular_island(a, n_i, n_j), without its atoms."""

    def factors(angle: Array) -> Complex:
        return triangular_structure_factors(a, n_i, n_j, angle, substrate.wavevectors)

    reach = 0.5 * a * float(np.hypot(n_i - 0.5, np.sqrt(0.75) * (n_j - 1.0)))
    return Island(substrate, n_i * n_j, reach, factors)


def of_atoms(
    substrate: Substrate, atoms: ase.Atoms, bonds: float | None, angles: Array | None
) -> Island:
    """An island of these atoms: rigid, or with harmonic bonds, which takes seconds for each of the angles."""
    points = positions_of(atoms)

    def factors(angle: Array) -> Complex:
        return structure_factors(atoms, angle, substrate.wavevectors)

    reach = float(np.hypot(*points.T).max())
    if bonds is None or angles is None:
        return Island(substrate, len(points), reach, factors)
    from ase.calculators.mixing import SumCalculator

    from origins.domains.calculators import harmonic_bonds, substrate_calculator
    from origins.domains.relaxed_barrier import relaxed_barrier

    known = {}
    for angle in angles.tolist():
        turned = atoms.copy()
        turned.rotate(np.degrees(angle), "z", center="COM")
        parts = [substrate_calculator(substrate), harmonic_bonds(turned, bonds)]
        found = relaxed_barrier(turned, SumCalculator(parts), rigid=False)
        known[angle] = found.barrier, float(found.minimum.get_potential_energy())
    return Island(substrate, len(points), reach, factors, known)


@dataclass(frozen=True)
class Islands:
    """Islands to draw from: `pick` gives a row of whole numbers for each quantile in [0, 1), shape (m,), and
    `make` makes the island of a row. `rows` and `shares` list the islands where there are few."""

    pick: Callable[[Array], Whole]
    make: Callable[..., Island]
    mean_atoms: float
    rows: list[tuple[int, ...]]
    shares: Array


def draw(
    islands: Islands,
    angles: Array | None,
    temperature: float | None,
    samples: int,
    seed: int,
    comm: Any = None,
) -> Array:
    """Barrier (0 where there is none), angle and N_a of each sample, shape (3, samples), on every rank the
    same to the last bit.

    Angles are taken from the list in turn, or from the full circle; with a temperature they are weighted by
    exp(-U_min/k_BT). The ranks of the communicator `comm` share the work; an InputError of one is raised on all.
    """
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    low, high = key_of(seed)
    blocks = -(-samples // _BLOCK)
    own: list[Array] = []
    refused = None
    try:
        # whole blocks: arrays have the same length on any rank, so each number has the same bits
        for block in range(blocks * rank // size, blocks * (rank + 1) // size):
            numbers = np.arange(block * _BLOCK, min((block + 1) * _BLOCK, samples))
            stream = np.random.Philox(key=high << 32 | low, counter=[0, 0, 0, block])
            uniform = np.random.Generator(stream).random((numbers.size, 3)).T
            own.append(_drawn(islands, angles, temperature, numbers, uniform))
    except InputError as error:
        refused = str(error)
    everyone = [(own, refused)] if comm is None else comm.allgather((own, refused))
    for _, message in everyone:
        if message is not None:
            raise InputError(message)
    return np.concatenate([part for theirs, _ in everyone for part in theirs], axis=1)


def _drawn(
    islands: Islands,
    listed: Array | None,
    temperature: float | None,
    numbers: Whole,
    uniform: Array,
) -> Array:
    """The samples `numbers`, from three numbers within [0, 1) for each, shape (3, m); see draw."""
    which, at, within = uniform
    out = np.empty((3, numbers.size))
    kinds, kind = np.unique(islands.pick(which), axis=0, return_inverse=True)
    for number, row in enumerate(kinds.tolist()):
        own = np.flatnonzero(kind.ravel() == number)
        island = islands.make(*row)
        if temperature is not None:
            choice = _resolving(island, temperature) if listed is None else listed
            depths = island.climb(choice).depths
            bounds = np.cumsum(np.exp((depths.min() - depths) / temperature))
            chosen = np.searchsorted(bounds[:-1], at[own] * bounds[-1], side="right")
            width = 0.0 if listed is not None else 2.0 * np.pi / choice.size
            turned = choice[chosen] + width * (within[own] - 0.5)
        elif listed is not None:
            turned = listed[numbers[own] % listed.size]
        else:
            turned = 2.0 * np.pi * at[own]
        # many samples may be the same island at the same angle
        different, back = np.unique(turned, return_inverse=True)
        barriers = island.climb(different).barriers[back]
        none = barriers <= 1e-12 * island.energy  # rounding
        out[:, own] = np.where(none, 0.0, barriers), turned, np.full(own.size, island.atoms)
    return out


def _resolving(island: Island, temperature: float) -> Array:
    """Equidistant angles that resolve exp(-U_min/k_BT) of the island."""
    steep = _PHASE / _EXPONENT * np.sqrt(island.energy / temperature)
    count = 2.0 * np.pi * island.phase / _PHASE * max(1.0, steep)
    if not count <= _MOST_ANGLES:
        raise InputError(
            f"temperature: {count:.2g} angles would be needed to resolve exp(-U_min/k_BT) of the largest "
            f"island, more than {_MOST_ANGLES}; list the angles to choose from, such as "
            "angles = [0.0, 0.1], or take a higher one"
        )
    count = max(64, round(count))
    return 2.0 * np.pi * np.arange(count) / count
