"""Islands drawn at random with an angle each, and their barriers; MPI ranks share the work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.domains.barriers import (
    barriers_and_depths,
    structure_factors,
    triangular_structure_factors,
)
from origins.domains.islands import positions_of
from origins.domains.lowest_saddle import Complex
from origins.domains.substrates import Substrate
from origins.errors import InputError, refuse
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Whole = npt.NDArray[np.intp]


class Island(NamedTuple):
    """One kind of island on a substrate: its number of atoms, the distance of the outermost from the centre (a
    length), and its structure factors (m, n) at angles (m,) in radians; where its atoms relax, barrier and lowest
    energy at each angle."""

    substrate: Substrate
    atoms: int
    reach: float
    factors: Callable[[Array], Complex]
    relaxed: dict[float, tuple[float, float]] | None = None

    @property
    def largest_energy(self) -> float:
        """Upper bound of its energy."""
        return self.atoms * float(np.abs(self.substrate.coefficients).sum())

    @property
    def phase_slope(self) -> float:
        """Largest derivative of the outermost atoms' phase with the angle."""
        return self.reach * float(np.hypot(*self.substrate.wavevectors.T).max())

    def amplitudes(self, angle: Array) -> Array:
        """|c_n S(G_n)| at angles (m,), energies of shape (m, n)."""
        return np.abs(self.substrate.coefficients * self.factors(angle))

    def barriers_and_depths(self, angle: Array) -> tuple[Array, Array]:
        """Barriers and lowest energies at angles (m,)."""
        if self.relaxed is None:
            return barriers_and_depths(self.substrate, self.factors(angle))
        barriers, depths = np.array([self.relaxed[each] for each in angle.tolist()]).T
        return barriers, depths


def triangular(substrate: Substrate, a: float, n_i: int, n_j: int) -> Island:
    """triangular_island(a, n_i, n_j), without its atoms."""
    reach = 0.5 * a * float(np.hypot(n_i - 0.5, np.sqrt(0.75) * (n_j - 1.0)))
    waves = substrate.wavevectors
    return Island(
        substrate, n_i * n_j, reach, lambda at: triangular_structure_factors(a, n_i, n_j, at, waves)
    )


def of_atoms(
    substrate: Substrate, atoms: ase.Atoms, bonds: float | None, angles: Array | None
) -> Island:
    """An island of these atoms: rigid, or with harmonic bonds, which takes seconds for each of the angles."""
    points, waves = positions_of(atoms), substrate.wavevectors
    reach = float(np.hypot(*points.T).max())
    rigid = Island(substrate, len(points), reach, lambda at: structure_factors(atoms, at, waves))
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
    return rigid._replace(relaxed=known)


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
        trials = [_trial_angles(island, temperature) for island in islands]

    def drawn(block: Whole) -> Array:
        """Barriers and angles (2, m) of samples of one kind."""
        island, (at, within) = islands[kinds[block[0]]], uniform[:, block]
        if temperature is None:
            turned = 2.0 * np.pi * at if listed is None else listed[block % listed.size]
        else:
            count = trials[kinds[block[0]]]
            choice = 2.0 * np.pi * np.arange(count) / count if listed is None else listed
            _, depths = island.barriers_and_depths(choice)
            bounds = np.cumsum(np.exp((depths.min() - depths) / temperature))
            turned = choice[np.searchsorted(bounds[:-1], at * bounds[-1], side="right")]
            if listed is None:
                turned = turned + 2.0 * np.pi / count * (within - 0.5)
        # many samples may be the same island at the same angle
        different, back = np.unique(turned, return_inverse=True)
        barriers = island.barriers_and_depths(different)[0][back]
        slides_freely = barriers <= 1e-12 * island.largest_energy
        return np.stack([np.where(slides_freely, 0.0, barriers), turned])

    # blocks of samples of one kind, each always computed by one rank, so that each number has the same bits
    order = np.argsort(kinds, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(kinds[order])) + 1)
    blocks = [group[k : k + 4096] for group in groups for k in range(0, group.size, 4096)]
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    mine = [drawn(block) for block in blocks[rank::size]]
    everyone = [mine] if comm is None else comm.allgather(mine)
    out = np.empty((2, kinds.size))
    for number, block in enumerate(blocks):
        out[:, block] = everyone[number % size][number // size]
    return out


def _trial_angles(island: Island, temperature: float) -> int:
    """How many equidistant angles resolve exp(-U_min/k_BT) of the island: near its minimum U_min/k_BT, and everywhere
    the outermost atoms' phase, changes by at most about a quarter between them."""
    per_radian = max(4.0, 2.0 * np.sqrt(island.largest_energy / temperature))
    count, most = 2.0 * np.pi * island.phase_slope * per_radian, 4_000_000
    if not count <= most:
        rule = f"{count:.2g} angles would resolve exp(-U_min/k_BT) of the largest island, more than {most}; "
        rule += "list the angles to choose from, such as angles = [0.0, 0.1], or take a higher one"
        raise InputError(f"temperature: {rule}")
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
