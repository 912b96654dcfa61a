"""Islands drawn at random: which one, at what angle, with what barrier; each sample by its own number alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins import streams
from origins.domains.barriers import Climb, climb
from origins.domains.islands import positions_of
from origins.domains.structure_factors import structure_factors, triangular_structure_factors
from origins.domains.substrates import Substrate
from origins.errors import InputError
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Whole = npt.NDArray[np.int64]

_BLOCK = 4096  # samples worked on together, whoever does it
_LEAST_ANGLES = 64
_PHASE = 0.25  # radians by which the outermost atoms' phase changes between angles to choose from
_EXPONENT = 0.5  # U_min/k_BT changes by about the square of this between them near its lowest
_MOST_ANGLES = 4_000_000


@dataclass(frozen=True)
class Island:
    """One kind of island: its number of atoms, the distance of the outermost from the centre, what it
    climbs at angles (radians), and the most that its energy can be; a barrier that is less than `rounding`
    of that is none."""

    atoms: int
    reach: float
    sizes: Callable[[Array], Array]
    climb: Callable[[Array], Climb]
    energy: float
    rounding: float


@dataclass(frozen=True)
class Islands:
    """Islands to draw from, each told by whole numbers: `pick` gives those at quantiles in (0, 1), shape
    (m, k), and `make` the island. `all` lists (share, numbers) where they are few."""

    mean_atoms: float
    pick: Callable[[Array], Whole]
    make: Callable[..., Island]
    all: Sequence[tuple[float, tuple[int, ...]]]


def listed(numbers: Whole, shares: Array, make: Callable[..., Island]) -> Islands:
    """Islands told by the rows of `numbers`, drawn with `shares`, which add up to 1."""
    bounds = np.cumsum(shares)[:-1]
    rows = [tuple(row) for row in numbers.tolist()]
    return Islands(
        float(sum(share * make(*row).atoms for share, row in zip(shares, rows, strict=True))),
        lambda quantile: numbers[np.searchsorted(bounds, quantile, side="right")],
        make,
        list(zip(shares.tolist(), rows, strict=True)),
    )


def decaying(decay: float, make: Callable[..., Island]) -> Islands:
    """P(N) ~ exp(-N/decay), N = 1, 2, ..., made as nearly as high as wide: n_j the whole number next to
    (2N/sqrt(3))^(1/2), n_i the one next to N/n_j, both at least 1."""

    def pick(quantile: Array) -> Whole:
        count = 1.0 + np.floor(-decay * np.log(quantile))
        rows = np.maximum(np.rint(np.sqrt(count * (2.0 / np.sqrt(3.0)))), 1.0)
        columns = np.maximum(np.rint(count / rows), 1.0)
        return np.column_stack([columns, rows]).astype(np.int64)

    return Islands(float(-1.0 / np.expm1(-1.0 / decay)), pick, make, [])


def triangular(a: float, substrate: Substrate) -> Callable[..., Island]:
    """What makes triangular_island(a, n_i, n_j) from n_i and n_j, without its atoms."""
    energy = float(np.abs(substrate.coefficients).sum())

    def make(n_i: int, n_j: int) -> Island:
        def factors(angle: Array) -> Array:
            return triangular_structure_factors(a, n_i, n_j, angle, substrate.wavevectors)

        reach = 0.5 * a * float(np.hypot(n_i - 0.5, np.sqrt(0.75) * (n_j - 1.0)))
        return Island(
            n_i * n_j,
            reach,
            lambda a: np.abs(substrate.coefficients * factors(a)),
            lambda a: climb(substrate, factors(a)),
            n_i * n_j * energy,
            1e-14,
        )

    return make


def given(
    islands: Sequence[ase.Atoms], substrate: Substrate, bonds: float | None
) -> Callable[..., Island]:
    """What makes an island from its number in the list, rigid or with harmonic bonds of stiffness `bonds`."""
    energy = float(np.abs(substrate.coefficients).sum())

    def make(number: int) -> Island:
        atoms = islands[number]
        points = positions_of(atoms)

        def factors(angle: Array) -> Array:
            return structure_factors(atoms, angle, substrate.wavevectors)

        def rigid(angle: Array) -> Climb:
            return climb(substrate, factors(angle))

        found = rigid if bonds is None else _flexible(atoms, substrate, bonds)
        reach = float(np.hypot(*points.T).max())
        return Island(
            len(points),
            reach,
            lambda a: np.abs(substrate.coefficients * factors(a)),
            found,
            len(points) * energy,
            1e-12,
        )

    return cache(make)


def _flexible(atoms: ase.Atoms, substrate: Substrate, bonds: float) -> Callable[[Array], Climb]:
    """What an island climbs whose atoms follow; seconds for each angle."""

    @cache
    def at(angle: float) -> tuple[float, float]:
        from ase.calculators.mixing import SumCalculator

        from origins.domains.calculators import harmonic_bonds, substrate_calculator
        from origins.domains.relaxed_barrier import relaxed_barrier

        turned = atoms.copy()
        turned.rotate(np.degrees(angle), "z", center="COM")
        parts = [substrate_calculator(substrate), harmonic_bonds(turned, bonds)]
        found = relaxed_barrier(turned, SumCalculator(parts), rigid=False)
        return found.barrier, float(found.minimum.get_potential_energy())

    def climbs(angle: Array) -> Climb:
        barriers, depths = np.array([at(float(one)) for one in angle]).T
        return Climb(barriers, depths)

    return climbs


@dataclass(frozen=True)
class Angles:
    """Angles to draw from: those listed, or any of the full circle; equally likely, or by exp(-U_min/k_BT)
    where temperature is given. `fastest` is the greatest |G| of the substrate."""

    listed: Array | None
    temperature: float | None
    fastest: float

    def candidates(self, island: Island) -> Array:
        """Angles that resolve exp(-U_min/k_BT) of the island, at one distance where none are listed."""
        if self.listed is not None or self.temperature is None:
            return np.zeros(0) if self.listed is None else self.listed
        steep = _PHASE / _EXPONENT * np.sqrt(island.energy / self.temperature)
        count = 2.0 * np.pi * self.fastest * island.reach / _PHASE * max(1.0, steep)
        if not count <= _MOST_ANGLES:
            raise InputError(
                f"temperature: {count:.2g} angles would be needed to resolve exp(-U_min/k_BT) of the largest "
                f"island, more than {_MOST_ANGLES}; list the angles to choose from, such as "
                "angles = [0.0, 0.1], or take a higher one"
            )
        count = max(_LEAST_ANGLES, round(count))
        return 2.0 * np.pi * np.arange(count) / count


@dataclass(frozen=True)
class Drawn:
    """Barrier, angle and N_a of each sample, and whether it resists, shape (samples,)."""

    barriers: Array
    angles: Array
    n_atoms: Whole
    resists: npt.NDArray[np.bool_]


def draw(islands: Islands, angles: Angles, samples: int, seed: int, comm: Any = None) -> Drawn:
    """The samples, on every rank the same to the last bit.

    The ranks of the communicator `comm` share the work; an InputError of one is raised on all.
    """
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    key, blocks = streams.key_of(seed), -(-samples // _BLOCK)
    own: list[list[npt.NDArray]] = []
    refused = None
    try:
        # whole blocks: an array has the same length, and each number the same bits, whoever computes it
        for block in range(blocks * rank // size, blocks * (rank + 1) // size):
            numbers = np.arange(block * _BLOCK, min((block + 1) * _BLOCK, samples))
            chance = np.concatenate([_uniform(key, numbers, 0), _uniform(key, numbers, 1)])
            own.append(_draw(islands, angles, numbers, chance))
    except InputError as error:
        refused = str(error)
    everyone = [(own, refused)] if comm is None else comm.allgather((own, refused))
    for _, message in everyone:
        if message is not None:
            raise InputError(message)
    parts = [part for theirs, _ in everyone for part in theirs]
    return Drawn(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _draw(islands: Islands, angles: Angles, numbers: Whole, chance: Array) -> list[npt.NDArray]:
    """The columns of Drawn for the samples `numbers`, by random numbers in (0, 1), shape (4, samples)."""
    barriers, turned = np.empty((2, numbers.size))
    n_atoms, free = np.empty(numbers.size, dtype=np.int64), np.empty(numbers.size)
    kinds, kind = np.unique(islands.pick(chance[0]), axis=0, return_inverse=True)
    for number, row in enumerate(kinds.tolist()):
        own = np.flatnonzero(kind.ravel() == number)
        island = islands.make(*row)
        choice = angles.candidates(island)
        if angles.temperature is not None:
            depths = island.climb(choice).depths
            bounds = np.cumsum(np.exp((depths.min() - depths) / angles.temperature))
            chosen = np.searchsorted(bounds[:-1], chance[1, own] * bounds[-1], side="right")
            width = 0.0 if angles.listed is not None else 2.0 * np.pi / choice.size
            turned[own] = choice[chosen] + width * (chance[2, own] - 0.5)
        elif choice.size:
            turned[own] = choice[numbers[own] % choice.size]
        else:
            turned[own] = 2.0 * np.pi * chance[1, own]
        # many samples may be the same island at the same angle
        different, back = np.unique(turned[own], return_inverse=True)
        barriers[own] = island.climb(different).barriers[back]
        n_atoms[own], free[own] = island.atoms, island.rounding * island.energy
    return [np.where(barriers > free, barriers, 0.0), turned, n_atoms, barriers > free]


def _uniform(key: tuple[int, int], numbers: Whole, block: int) -> Array:
    """Two numbers within (0, 1) of 52 bits for each sample, shape (2, samples)."""
    words = streams.words(key, streams.DOMAINS, 0, numbers, block).astype(np.uint64)
    whole = (words[::2] << np.uint64(32) | words[1::2]) >> np.uint64(12)
    return np.asarray((whole + 0.5) * 2.0**-52)
