"""Islands drawn at random with an angle each, and their barriers; MPI ranks share the work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.barriers import climb, structure_factors, triangular_structure_factors
from origins.domains.islands import positions_of
from origins.domains.lowest_saddle import Complex
from origins.domains.substrates import Substrate
from origins.errors import InputError, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Whole = npt.NDArray[np.intp]

_BLOCK = 4096  # samples computed together, always by one rank
_PHASE = 0.25  # radians: change of the outermost atoms' phase between neighbouring trial angles
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

    def climb(self, angle: Array) -> tuple[Array, Array]:
        """Barriers and lowest energies at angles (m,)."""
        if self.relaxed is None:
            return climb(self.substrate, self.factors(angle))
        barriers, depths = np.array([self.relaxed[each] for each in angle.tolist()]).T
        return barriers, depths


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

    rigid = Island(substrate, len(points), float(np.hypot(*points.T).max()), factors)
    if bonds is None or angles is None:
        return rigid
    from ase.calculators.mixing import SumCalculator

    from origins.domains.calculators import harmonic_bonds, substrate_calculator
    from origins.domains.relaxed_barrier import relaxed_barrier

    known = {}
    for angle in np.unique(angles).tolist():
        turned = atoms.copy()
        turned.rotate(np.degrees(angle), "z", center="COM")
        parts = [substrate_calculator(substrate), harmonic_bonds(turned, bonds)]
        found = relaxed_barrier(turned, SumCalculator(parts), rigid=False)
        lowest = float(found.minimum.get_potential_energy())
        if found.barrier_error > 1e-3 * max(found.barrier, -1e-6 * lowest):
            rule = f"lets the island's shape jump at the angle {angle:.6g}; take stiffer bonds"
            refuse("bonds", bonds, rule)
        known[angle] = found.barrier, lowest
    return replace(rigid, relaxed=known)


def draw(
    islands: list[Island],
    kinds: Whole,
    listed: Array | None,
    temperature: float | None,
    generator: np.random.Generator,
    comm: Any = None,
) -> Array:
    """Barrier (0 where there is none) and angle of each sample, shape (2, samples), the same bits on every rank.

    Sample i is the island kinds[i]. Angles are taken from the list in turn, or from the full circle; with a
    temperature they are weighted by exp(-U_min/k_BT). The ranks of the communicator `comm` share the work.
    """
    uniform = generator.random((2, kinds.size))
    trials = [0] * len(islands)
    if temperature is not None and listed is None:
        trials = [_resolving(island, temperature) for island in islands]

    def drawn(some: Whole) -> Array:
        """Barriers and angles (2, m) of samples of one kind."""
        island, (at, within) = islands[kinds[some[0]]], uniform[:, some]
        if temperature is not None:
            count = trials[kinds[some[0]]]
            choice = 2.0 * np.pi * np.arange(count) / count if listed is None else listed
            _, depths = island.climb(choice)
            bounds = np.cumsum(np.exp((depths.min() - depths) / temperature))
            turned = choice[np.searchsorted(bounds[:-1], at * bounds[-1], side="right")]
            if listed is None:
                turned = turned + 2.0 * np.pi / count * (within - 0.5)
        else:
            turned = 2.0 * np.pi * at if listed is None else listed[some % listed.size]
        # many samples may be the same island at the same angle
        different, back = np.unique(turned, return_inverse=True)
        barriers = island.climb(different)[0][back]
        return np.stack([np.where(barriers <= 1e-12 * island.energy, 0.0, barriers), turned])

    # whole blocks: arrays have the same length on any number of ranks, so each number has the same bits
    order = np.argsort(kinds, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(kinds[order])) + 1)
    jobs = [group[k : k + _BLOCK] for group in groups for k in range(0, group.size, _BLOCK)]
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    own = [drawn(some) for some in jobs[rank::size]]
    everyone = [own] if comm is None else comm.allgather(own)
    out = np.empty((2, kinds.size))
    for number, some in enumerate(jobs):
        out[:, some] = everyone[number % size][number // size]
    return out


def _resolving(island: Island, temperature: float) -> int:
    """How many equidistant angles resolve exp(-U_min/k_BT) of the island.

    U_min/k_BT near its minimum changes by at most about a quarter between them.
    """
    per_radian = max(1.0 / _PHASE, 2.0 * np.sqrt(island.energy / temperature))
    count = 2.0 * np.pi * island.phase * per_radian
    if not count <= _MOST_ANGLES:
        raise InputError(
            f"temperature: {count:.2g} angles would be needed to resolve exp(-U_min/k_BT) of the largest "
            f"island, more than {_MOST_ANGLES}; list the angles to choose from, such as "
            "angles = [0.0, 0.1], or take a higher one"
        )
    return max(64, round(count))


@dataclass(frozen=True, eq=False)
class DomainSamples:
    """The islands from which thresholds of rotated domains were computed.

    Attributes
    ----------
    barriers : array of shape (samples,)
        epsilon_a, energies; 0 for islands that slide freely.
    angles : array of shape (samples,)
        Radians.
    n_atoms : array of shape (samples,)
        N_a.
    period : float
        a_s, the shortest period of the substrate, a length.
    mean_stiffness : float
        <k> over the islands that resist, force per length.
    """

    barriers: Array
    angles: Array
    n_atoms: npt.NDArray[np.int64]
    period: float
    mean_stiffness: float

    @property
    def forces(self) -> Array:
        """f_s = epsilon_a/a_s of the islands that resist, sorted."""
        return np.sort(self.barriers[self.barriers > 0.0]) / self.period

    @property
    def superlubric_weight(self) -> float:
        """Share of islands without a barrier, which are left out of P_c, of N_c and of the properties below."""
        return float((self.barriers == 0.0).mean())

    @property
    def mean_force(self) -> float:
        """f of the fit exp(-f_s/f) of maximum likelihood: the mean of f_s."""
        return float(self.forces.mean())

    @property
    def exponential_distance(self) -> float:
        """Largest distance of that fit's cdf from that of the forces (Kolmogorov and Smirnov), to be compared with
        the sampling error 1.36/samples^(1/2)."""
        fitted = -np.expm1(-self.forces / self.mean_force)
        steps = np.arange(fitted.size + 1) / fitted.size
        return float(max((steps[1:] - fitted).max(), (fitted - steps[:-1]).max()))
