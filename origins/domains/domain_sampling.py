"""Islands drawn at random: which one, at what angle, with what barrier; each sample by its own number alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from origins import streams
from origins.domains.barriers import barriers_and_depths, triangular_barriers_and_depths
from origins.domains.islands import positions_of
from origins.domains.substrates import Substrate
from origins.errors import InputError, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Whole = npt.NDArray[np.int64]

_BLOCK = 4096  # samples worked on together, whoever does it
_LEAST_ANGLES = 64
_PHASE = 0.25  # between neighbouring candidate angles the phase of the outermost atoms changes by this at most,
_EXPONENT = 0.5  # and near the lowest energy U_min/k_BT by about the square of this
_MOST_ANGLES = 4_000_000


class Family(Protocol):
    """The islands to draw from; one of them is a row of whole numbers."""

    mean_atoms: float
    only: (
        Whole | None
    )  # the island, where there is one and the substrate has two waves, so that b is closed
    rounding: float  # barriers below this part of N_a times the substrate's amplitudes are none

    def pick(self, share: Array) -> Whole:
        """Islands at the quantiles `share`, shape (m, keys)."""

    def atoms(self, islands: Whole) -> Whole:
        """N_a, shape (m,)."""

    def reach(self, island: Whole) -> float:
        """Distance of the outermost atom from the centre."""

    def solve(self, islands: Whole, angle: Array) -> tuple[Array, Array]:
        """Barriers and lowest energies, shape (m,)."""


class TriangularFamily:
    """triangular_island(lattice_constant, n_i, n_j), an island being (n_i, n_j).

    Either the listed sizes with their shares, or P(N) ~ exp(-N/decay), N = 1, 2, ..., made as nearly as high as wide:
    n_j the whole number next to (2N/sqrt(3))^(1/2), n_i the one next to N/n_j, both at least 1.
    """

    rounding = 1e-14

    def __init__(
        self,
        lattice_constant: float,
        substrate: Substrate,
        sizes: Whole,
        shares: Array,
        decay: float | None,
    ) -> None:
        self._a, self._substrate, self._sizes, self._decay = (
            lattice_constant,
            substrate,
            sizes,
            decay,
        )
        self._bounds = np.cumsum(shares)
        self.only = sizes[0] if len(sizes) == 1 and len(substrate.coefficients) == 2 else None
        self.mean_atoms = (
            float(shares @ sizes.prod(-1))
            if decay is None
            else float(-1.0 / np.expm1(-1.0 / decay))
        )

    def pick(self, share: Array) -> Whole:
        if self._decay is None:
            return self._sizes[np.searchsorted(self._bounds[:-1], share, side="right")]
        count = 1.0 + np.floor(-self._decay * np.log(share))
        rows = np.maximum(np.rint(np.sqrt(count * (2.0 / np.sqrt(3.0)))), 1.0)
        return np.column_stack([np.maximum(np.rint(count / rows), 1.0), rows]).astype(np.int64)

    def atoms(self, islands: Whole) -> Whole:
        return islands.prod(-1)

    def reach(self, island: Whole) -> float:
        return 0.5 * self._a * float(np.hypot(island[0] - 0.5, np.sqrt(0.75) * (island[1] - 1.0)))

    def solve(self, islands: Whole, angle: Array) -> tuple[Array, Array]:
        return triangular_barriers_and_depths(
            self._a, islands[:, 0], islands[:, 1], angle, self._substrate
        )


class ListedFamily:
    """Islands of the user's own, an island being its number in the list."""

    rounding = 1e-12

    def __init__(self, islands: "Sequence[ase.Atoms]", substrate: Substrate, shares: Array) -> None:
        self._islands, self._substrate, self._bounds = islands, substrate, np.cumsum(shares)
        self.only = (
            np.zeros(1, dtype=np.int64)
            if len(islands) == 1 and len(substrate.coefficients) == 2
            else None
        )
        self._counts = np.array([len(positions_of(atoms)) for atoms in islands])
        self.mean_atoms = float(shares @ self._counts)

    def pick(self, share: Array) -> Whole:
        return np.searchsorted(self._bounds[:-1], share, side="right")[:, None]

    def atoms(self, islands: Whole) -> Whole:
        return self._counts[islands[:, 0]]

    def reach(self, island: Whole) -> float:
        return float(np.hypot(*positions_of(self._islands[island[0]]).T).max())

    def solve(self, islands: Whole, angle: Array) -> tuple[Array, Array]:
        barriers, depths = np.empty((2, len(islands)))
        for number in np.unique(islands):
            own = np.flatnonzero(islands[:, 0] == number)
            barriers[own], depths[own] = barriers_and_depths(
                self._islands[number], angle[own], self._substrate
            )
        return barriers, depths


@dataclass(frozen=True)
class Angles:
    """Angles to draw from: those listed, or any; equally likely, or by exp(-U_min/k_BT) where temperature is given."""

    listed: Array | None
    temperature: float | None


def draw(
    family: Family, angles: Angles, fastest: float, samples: int, seed: int, comm: Any = None
) -> tuple[Array, Array, Whole]:
    """Barrier, angle and N_a of each sample, shape (samples,), on every rank the same to the last bit.

    `fastest` is the greatest |G| of the substrate. The ranks of the communicator `comm` share the work; an
    InputError of one is raised on all.
    """
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    key = streams.key_of(seed)
    blocks = -(-samples // _BLOCK)
    own: list[tuple[Array, Array, Whole]] = []
    refused = None
    try:
        # whole blocks: an array has the same length, and each number the same bits, whoever computes it
        for block in range(blocks * rank // size, blocks * (rank + 1) // size):
            numbers = np.arange(block * _BLOCK, min((block + 1) * _BLOCK, samples), dtype=np.uint64)
            own.append(_draw(family, angles, fastest, key, numbers))
    except InputError as error:
        refused = str(error)
    everyone = [(own, refused)] if comm is None else comm.allgather((own, refused))
    for _, message in everyone:
        if message is not None:
            raise InputError(message)
    parts = [part for theirs, _ in everyone for part in theirs]
    barriers, turned, atoms = (np.concatenate(column) for column in zip(*parts, strict=True))
    return barriers, turned, atoms


def _draw(
    family: Family,
    angles: Angles,
    fastest: float,
    key: tuple[int, int],
    numbers: npt.NDArray[np.uint64],
) -> tuple[Array, Array, Whole]:
    which, where = _uniform(key, numbers, 0)
    islands = family.pick(which)
    if angles.temperature is None:
        if angles.listed is None:
            turned = 2.0 * pi * where
        else:
            turned = angles.listed[(numbers % np.uint64(angles.listed.size)).astype(np.intp)]
    else:
        within, _ = _uniform(key, numbers, 1)
        turned = np.empty(numbers.size)
        kinds, kind = np.unique(islands, axis=0, return_inverse=True)
        for number, island in enumerate(kinds):
            own = np.flatnonzero(kind.ravel() == number)
            candidates, depths, width = _candidates(
                family, island, angles.listed, angles.temperature, fastest
            )
            bounds = np.cumsum(np.exp((depths.min() - depths) / angles.temperature))
            chosen = np.searchsorted(bounds[:-1], where[own] * bounds[-1], side="right")
            turned[own] = candidates[chosen] + width * (within[own] - 0.5)
    barriers = (
        _distinct(family, islands, turned)
        if angles.listed is not None
        else family.solve(islands, turned)[0]
    )
    return barriers, turned, family.atoms(islands)


def _distinct(family: Family, islands: Whole, angle: Array) -> Array:
    """Barriers where many samples are the same island at the same angle, each solved once."""
    _, first, back = np.unique(
        np.column_stack([islands, angle]), axis=0, return_index=True, return_inverse=True
    )
    return family.solve(islands[first], angle[first])[0][back.ravel()]


def _candidates(
    family: Family, island: Whole, listed: Array | None, temperature: float, fastest: float
) -> tuple[Array, Array, float]:
    """Angles for one island to choose from, its lowest energy at each, and how far apart they are."""
    if listed is not None:
        return listed, _depths(family, island, listed), 0.0
    # enough for the outermost atoms, and then for the depth found
    count = max(_LEAST_ANGLES, round(2.0 * pi * fastest * family.reach(island) / _PHASE))
    grid = _circle(count)
    depths = _depths(family, island, grid)
    finer = _PHASE / _EXPONENT * float(np.sqrt((depths.max() - depths.min()) / temperature))
    if finer > 1.0:
        grid = _circle(count * finer)
        depths = _depths(family, island, grid)
    return grid, depths, 2.0 * pi / grid.size


def _circle(count: float) -> Array:
    if not count <= _MOST_ANGLES:
        raise InputError(
            f"temperature: {count:.2g} angles would be needed to resolve exp(-U_min/k_BT) of the largest island, more "
            f"than {_MOST_ANGLES}; list the angles to choose from, such as angles = [0.0, 0.1], or take a higher one"
        )
    return 2.0 * pi * np.arange(round(count)) / round(count)


def _depths(family: Family, island: Whole, candidates: Array) -> Array:
    return family.solve(np.broadcast_to(island, (candidates.size, island.size)), candidates)[1]


def _uniform(
    key: tuple[int, int], numbers: npt.NDArray[np.uint64], block: int
) -> tuple[Array, Array]:
    """Two numbers within (0, 1) of 52 bits for each sample."""
    words = streams.words(key, streams.DOMAINS, 0, numbers, block).astype(np.uint64)
    first, second = ((words[k] << np.uint64(32) | words[k + 1]) >> np.uint64(12) for k in (0, 2))
    return (first + 0.5) * 2.0**-52, (second + 0.5) * 2.0**-52


def shares_of(weights: npt.ArrayLike | None, count: int) -> Array:
    """Weights of `count` islands as shares that add up to 1; equal when left out. InputError unless above zero."""
    if weights is None:
        return np.full(count, 1.0 / count)
    shares = np.asarray(weights, dtype=float)
    if shares.shape != (count,) or not np.isfinite(shares).all() or not (shares > 0.0).all():
        refuse(
            "weights", weights, f"must be {count} finite numbers above zero, one for each island"
        )
    return shares / shares.sum()
