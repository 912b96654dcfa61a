"""Thresholds of rotated domains: islands of a crystal, at all angles, on another one (paper, Sec. VI C)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.domains.angle_thresholds import angle_thresholds
from origins.domains.barriers import Island, radians
from origins.domains.islands import Atoms, Layers, layers_of
from origins.domains.lowest_saddle import Whole
from origins.domains.substrates import Substrate, checked_substrate, vectors
from origins.errors import (
    InputError,
    between,
    check_seed,
    finite_array,
    one_of,
    positive,
    refuse,
    whole,
)
from origins.samples.from_samples import from_samples
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import mixture
from origins.thresholds.powered import Powered, PowerLaw

_MOST_ATOMS = 1e12


def domains(
    lattice_constant: float | None = None,
    *,
    sizes: npt.ArrayLike | None = None,
    mean_atoms: float | None = None,
    islands: Sequence[Atoms] | None = None,
    weights: npt.ArrayLike | None = None,
    bonds: float | None = None,
    angles: npt.ArrayLike | None = None,
    temperature: float | None = None,
    substrate: Substrate | None = None,
    law: str = "area",
    stiffness: float | None = None,
    coefficient: float | None = None,
    samples: int = 20_000,
    seed: int = 0,
    comm: Any = None,
) -> Thresholds:
    """Thresholds of islands that lie on a substrate at random angles (paper, Sec. VI C).

    lattice_constant : of triangular islands, a length; together with
    sizes : (n_i, n_j) of triangular_island, shape (m, 2), drawn with `weights`; or
    mean_atoms : decay N of the weight exp(-N_a/N) over N_a = 1, 2, ...; n_j is N_a^(1/2) (4/3)^(1/4), so that islands
        are as high as wide, and n_i is N_a/n_j, both rounded to whole numbers of at least 1.
    islands : instead of these three, a sequence of ase.Atoms, drawn with `weights`.
    weights : shares of `sizes` or `islands`, shape (m,), above zero; equal when left out.
    bonds : makes `islands` flexible, at listed `angles`: the stiffness of harmonic_bonds, energy per length².
    angles : radians, from -2 pi to 2 pi, taken in turn, sample by sample; the full circle when left out.
    temperature : k_BT, an energy: angles are weighted by exp(-U_min/k_BT) for each size of island, U_min the lowest
        energy at that angle; left out, all are equally likely.
    substrate : sin x + sin y when left out.
    law : from f_s = epsilon_a/a_s to x_s = f_s/k, a_s the substrate's shortest period: "area" with
        k = stiffness (N_a/<N_a>)^(1/2), "equal" with k = stiffness for all, "paper" with f_s = coefficient x_s², so
        that k ~ x_s (paper, Eqs. PxPf and Pcrotateh).
    stiffness, coefficient : force per length, not for "paper"; force per length², for "paper" only; needed there.
    samples, seed : islands drawn; the same seed gives the same islands.
    comm : mpi4py communicator; its ranks, all of which must call, share the work and get the same bits at any number.

    Returns thresholds as from_samples makes them of x_s, with their sampling error, and with `.domains`, a
    DomainSamples. One or two rigid islands on two waves, at any angle and without a temperature, have no sampling
    error: P_c comes from b(angle) itself, and K* is infinite (docs/islands.md). Raises InputError for other values, for
    a substrate that varies in one direction only, and where no island resists.
    """
    substrate = checked_substrate(substrate)
    if substrate.rank == 1:
        raise InputError("substrate: varies in one direction only: every island slides freely")
    strength = _checked_law(law, stiffness, coefficient)
    if bonds is not None and (islands is None or angles is None):
        refuse("bonds", bonds, "makes islands of your own flexible, at listed angles; give both")
    if sum(each is not None for each in (sizes, mean_atoms, islands)) != 1:
        raise InputError("domains: give exactly one of sizes = [(10, 9)], mean_atoms and islands")
    listed = None if angles is None else radians(finite_array("angles", angles), "angles")
    heat = None if temperature is None else positive("temperature", temperature)
    generator = np.random.Generator(np.random.Philox(key=check_seed(seed)))
    quantiles = generator.random(whole("samples", samples, 1))
    if islands is not None:
        if lattice_constant is not None:
            refuse("lattice_constant", lattice_constant, "islands have their own; leave it out")
        if hasattr(islands, "get_positions") or len(islands) == 0:
            refuse("islands", islands, "must be a list of at least one ase.Atoms, such as [atoms]")
        made = [Island.of_atoms(substrate, atoms) for atoms in islands]
        if bonds is not None and listed is not None:
            each, firm = zip(made, islands, strict=True), positive("bonds", bonds)
            made = [island.relaxing(atoms, firm, listed) for island, atoms in each]
    else:
        a = positive("lattice_constant", lattice_constant, "such as 2.5, for triangular islands")
        if mean_atoms is None:
            given = vectors(sizes, "sizes", "[[10, 9]]")
            if (given % 1.0).any() or given.min() < 1.0 or given.prod(axis=1).max() > _MOST_ATOMS:
                refuse("sizes", sizes, f"must be whole numbers, {_MOST_ATOMS:g} atoms at most")
            pairs = given.astype(int).tolist()
        else:
            pairs, kinds = _decaying(mean_atoms, quantiles)
        made = [Island.triangular(substrate, a, *pair) for pair in pairs]
    n_atoms = np.array([island.atoms for island in made])
    if mean_atoms is None:
        fractions = np.ones(len(made)) if weights is None else finite_array("weights", weights)
        if fractions.shape != n_atoms.shape or not (fractions > 0.0).all():
            refuse("weights", weights, f"must be {len(made)} numbers above zero, one an island")
        fractions = fractions / fractions.sum()
        kinds, mean = (
            np.searchsorted(np.cumsum(fractions)[:-1], quantiles, "right"),
            fractions @ n_atoms,
        )
    elif weights is None:
        mean = -1.0 / np.expm1(-1.0 / mean_atoms)
    else:
        refuse("weights", weights, "exp(-N_a/mean_atoms) are the weights; leave it out")
    barriers, turned = _drawn(made, kinds, listed, heat, generator, comm)
    resisting = barriers > 0.0
    if not resisting.any():
        raise InputError(f"domains: none of {samples} islands has a barrier; change their sizes")
    period = float(np.hypot(*substrate.cell[0]))
    relative = np.sqrt(n_atoms / mean) if law == "area" else np.ones(n_atoms.size)
    gains, exponent = 1.0 / (period * strength * relative), 0.5 if law == "paper" else 1.0
    lengths = (barriers * gains[kinds])[resisting] ** exponent
    two_waves = len(substrate.coefficients) == 2 and listed is None and heat is None
    # of three islands, or where the barrier has more peaks, solvers would take half a minute and more
    few_peaks = len(made) <= 2 and max(island.phase_slope for island in made) < 477.0
    if two_waves and few_peaks and mean_atoms is None and resisting.all():
        laws = [angle_thresholds(*each) for each in zip(made, gains.tolist(), strict=True)]
        thresholds = laws[0] if len(laws) == 1 else mixture(laws, fractions)
        if exponent != 1.0:
            thresholds = Powered(thresholds, PowerLaw(1.0, exponent))
    else:
        thresholds = from_samples(lengths)
    mean_stiffness = float((barriers[resisting] / period / lengths).mean())
    layers = tuple(map(layers_of, islands or ()))
    thresholds.domains = DomainSamples(
        barriers, turned, n_atoms[kinds], period, mean_stiffness, layers
    )
    return thresholds


def _checked_law(law: str, stiffness: object, coefficient: object) -> float:
    """The stiffness, or the coefficient, as the law needs it."""
    given = {"stiffness": stiffness, "coefficient": coefficient}
    paper = one_of("law", law, ("area", "equal", "paper")) == "paper"
    needed, other = ("coefficient", "stiffness") if paper else ("stiffness", "coefficient")
    if given[other] is not None:
        refuse(other, given[other], f'has no part in law = "{law}"; leave it out')
    if given[needed] is None:
        hint = f'law = "{law}" needs it; for lengths in units of your own write {needed} = 1.0'
        refuse(needed, None, hint)
    return positive(needed, given[needed])


def _decaying(mean_atoms: object, quantiles: Array) -> tuple[list[list[int]], Whole]:
    """All sizes (n_i, n_j) of islands by the rule that `domains` states, and which of them each sample is."""
    decay = between("mean_atoms", mean_atoms, 0.0, _MOST_ATOMS, "take fewer atoms")
    count = 1.0 + np.floor(-decay * np.log1p(-quantiles))
    rows = np.maximum(np.rint(np.sqrt(count * (2.0 / np.sqrt(3.0)))), 1.0)
    columns = np.maximum(np.rint(count / rows), 1.0)
    pairs = np.column_stack([columns, rows]).astype(int)
    different, kinds = np.unique(pairs, axis=0, return_inverse=True)
    return different.tolist(), kinds.ravel()


def _drawn(
    islands: list[Island],
    kinds: Whole,
    listed: Array | None,
    temperature: float | None,
    generator: np.random.Generator,
    comm: Any,
) -> Array:
    """Barrier (0 where there is none) and angle of each sample, shape (2, samples), the same bits on every rank of
    `comm`, which share the work. Sample i is the island kinds[i]."""
    uniform, counts = generator.random((2, kinds.size)), [0] * len(islands)
    if temperature is not None and listed is None:
        counts = [island.angles_needed(temperature) for island in islands]
    # blocks of samples of one kind, each always computed by one rank, so that each number has the same bits
    order = np.argsort(kinds, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(kinds[order])) + 1)
    blocks = [group[k : k + 4096] for group in groups for k in range(0, group.size, 4096)]
    rank, size = (0, 1) if comm is None else (comm.Get_rank(), comm.Get_size())
    out = np.zeros((2, kinds.size))
    for block in blocks[rank::size]:
        kind, (at, within) = kinds[block[0]], uniform[:, block]
        island, count = islands[kind], counts[kind]
        if temperature is None:
            turned = 2.0 * np.pi * at if listed is None else listed[block % listed.size]
        else:
            choice = 2.0 * np.pi * np.arange(count) / count if listed is None else listed
            _, depths = island.barriers_and_depths(choice)
            bounds = np.cumsum(np.exp((depths.min() - depths) / temperature))
            turned = choice[np.searchsorted(bounds[:-1], at * bounds[-1], side="right")]
            if listed is None:
                turned = turned + 2.0 * np.pi / count * (within - 0.5)
        # many samples may be the same island at the same angle
        different, back = np.unique(turned, return_inverse=True)
        out[:, block] = island.barriers_and_depths(different)[0][back], turned
    return out if comm is None else comm.allreduce(out)


@dataclass(frozen=True, eq=False)
class DomainSamples:
    """The islands from which thresholds of rotated domains were computed.

    barriers, angles, n_atoms : epsilon_a, energies, 0 for islands that slide freely; radians; N_a; shape (samples,).
    period, mean_stiffness : a_s, the substrate's shortest period, a length; <k> of those that resist, force per length.
    layers : of `islands` that are given as atoms, one each, how these lie one above the other; else none.
    """

    barriers: Array
    angles: Array
    n_atoms: npt.NDArray[np.int64]
    period: float
    mean_stiffness: float
    layers: tuple[Layers, ...] = ()

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
