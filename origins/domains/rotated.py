"""Thresholds of rotated domains: islands of a crystal, at all angles, on another one (paper, Sec. VI C)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.domains.angle_thresholds import angle_thresholds
from origins.domains.barriers import radians
from origins.domains.drawing import DomainSamples, Island, draw, of_atoms, triangular
from origins.domains.substrates import Substrate, checked_substrate
from origins.errors import InputError, between, finite_array, one_of, positive, refuse, whole
from origins.samples.from_samples import from_samples
from origins.streams import key_of
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import mixture
from origins.thresholds.powered import Powered, PowerLaw

if TYPE_CHECKING:
    import ase

LAWS = ("area", "equal", "paper")
_MOST_ATOMS = 1e12


def domains(
    lattice_constant: float | None = None,
    *,
    sizes: npt.ArrayLike | None = None,
    mean_atoms: float | None = None,
    islands: Sequence[ase.Atoms] | None = None,
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

    The paper prints neither lattice constant nor sizes nor angles.

    Parameters
    ----------
    lattice_constant : float
        Of triangular islands, a length; together with
    sizes : array of shape (m, 2)
        (n_i, n_j) of triangular_island, drawn with `weights`; or
    mean_atoms : float
        Decay N of the weight exp(-N_a/N) over N_a = 1, 2, ...; the islands are as high as wide, like the
        paper's: n_j is N_a^(1/2) (4/3)^(1/4) and n_i is N_a/n_j, both rounded.
    islands : sequence of ase.Atoms
        Instead of these three, islands of your own, drawn with `weights`. The time for their barriers grows
        with the number of atoms.
    weights : array of shape (m,)
        Shares of `sizes` or `islands`, above zero; equal when left out.
    bonds : float
        Makes `islands` flexible: the stiffness of harmonic_bonds between neighbours, energy per length².
        Their barriers are those of relaxed_barrier and take seconds for each island and angle, so the
        angles must be listed. Left out, islands are rigid.
    angles : array
        Radians, from -2 pi to 2 pi. Taken in turn, sample by sample; left out, all angles of the full circle
        are possible.
    temperature : float
        k_BT, an energy: angles are weighted by exp(-U_min/k_BT) for each size of island, U_min the lowest
        energy at that angle; left out, all angles are equally likely.
    substrate : Substrate
        sin x + sin y when left out.
    law : "area", "equal" or "paper"
        From f_s = epsilon_a/a_s to x_s = f_s/k, a_s the substrate's shortest period:
        "area": k = stiffness (N_a/<N_a>)^(1/2), the k ~ A^(1/2) of the laws "amontons" and "strength" of
        rough surfaces; for islands of one size x_s ~ f_s;
        "equal": k = stiffness for islands of every size;
        "paper": f_s = coefficient x_s², so that k ~ x_s (paper, Eqs. PxPf and Pcrotateh).
    stiffness : float
        Force per length; "area" and "equal" only, and needed there.
    coefficient : float
        Force per length²; "paper" only, and needed there.
    samples, seed : int
        Islands drawn; the same seed gives the same islands.
    comm : mpi4py communicator, optional
        Its ranks, all of which must call, share the work and get the same bits at any number of them.

    Returns
    -------
    thresholds : Thresholds
        As from_samples makes them of x_s, with their sampling error, and with `.domains`, a DomainSamples. Force
        and holding fraction of a run count only the islands that resist.

        One or two rigid islands on two waves, at any angle and without a temperature, have no sampling error:
        P_c comes from b(angle) itself. It diverges where db/dangle = 0, so that K* is infinite, and jumps
        where |S_x| = |S_y|. In all other cases, and for islands of some hundred periods across, P_c comes
        from samples, which smooth such peaks. Samples are drawn in any case, for `.domains`.

    Raises InputError for values outside these, for a substrate that varies in one direction only, and where
    no island resists.
    """
    substrate = checked_substrate(substrate)
    if substrate.rank == 1:
        rule = "varies in one direction only, and every island slides freely across it"
        raise InputError(f"substrate: {rule}")
    strength = _checked_law(law, stiffness, coefficient)
    if bonds is not None and (islands is None or angles is None):
        refuse("bonds", bonds, "makes islands of your own flexible, at listed angles; give both")
    if sum(way is not None for way in (sizes, mean_atoms, islands)) != 1:
        ways = "sizes, such as [(10, 9)], mean_atoms, such as 100, and islands, a list of ase.Atoms"
        raise InputError(f"domains: give exactly one of {ways}")
    listed = None if angles is None else radians(finite_array("angles", angles), "angles")
    heat = None if temperature is None else positive("temperature", temperature)
    low, high = key_of(seed)
    generator = np.random.Generator(np.random.Philox(key=high << 32 | low))
    quantiles = generator.random(whole("samples", samples, 1))
    if islands is not None:
        if lattice_constant is not None:
            refuse("lattice_constant", lattice_constant, "islands have their own; leave it out")
        if hasattr(islands, "get_positions") or len(islands) == 0:
            refuse("islands", islands, "must be a list of at least one ase.Atoms, such as [atoms]")
        firm = None if bonds is None else positive("bonds", bonds)
        given = [of_atoms(substrate, atoms, firm, listed) for atoms in islands]
        family = _listed(given, weights, quantiles)
    elif lattice_constant is None:
        rule = "triangular islands need it; give a length, such as lattice_constant = 2.5"
        refuse("lattice_constant", None, rule)
    else:
        make = partial(triangular, substrate, positive("lattice_constant", lattice_constant))
        if sizes is not None:
            family = _listed([make(*pair) for pair in _pairs(sizes)], weights, quantiles)
        elif weights is None:
            family = _decaying(mean_atoms, make, quantiles)
        else:
            refuse("weights", weights, "exp(-N_a/mean_atoms) are the weights; leave it out")
    barriers, turned = draw(family.islands, family.kinds, listed, heat, generator, comm)
    resisting = barriers > 0.0
    if not resisting.any():
        rule = "no contact resists; change the angles, the sizes or the lattice constant"
        raise InputError(f"domains: none of {samples} islands has a barrier: {rule}")
    period = float(np.hypot(*substrate.cell[0]))
    atoms = np.array([island.atoms for island in family.islands])
    relative = np.sqrt(atoms / family.mean_atoms) if law == "area" else np.ones(atoms.size)
    gains, exponent = 1.0 / (period * strength * relative), 0.5 if law == "paper" else 1.0
    lengths = (barriers * gains[family.kinds])[resisting] ** exponent
    laws: list[Thresholds] = []
    two_waves = len(substrate.coefficients) == 2 and listed is None and heat is None
    # of three islands solvers would take half a minute for the peaks
    if two_waves and resisting.all() and mean_atoms is None and atoms.size <= 2:
        pairs = zip(family.islands, gains.tolist(), strict=True)
        laws = [known for pair in pairs if (known := angle_thresholds(*pair)) is not None]
    if len(laws) == atoms.size:
        thresholds = laws[0] if len(laws) == 1 else mixture(laws, family.shares)
        if exponent != 1.0:
            thresholds = Powered(thresholds, PowerLaw(1.0, exponent))
    else:
        thresholds = from_samples(lengths)
    mean_stiffness = float((barriers[resisting] / period / lengths).mean())
    n_atoms = atoms[family.kinds]
    thresholds.domains = DomainSamples(barriers, turned, n_atoms, period, mean_stiffness)
    return thresholds


class _Family(NamedTuple):
    """Islands and their shares, the number of the one that each sample is, and their mean number of atoms."""

    islands: list[Island]
    shares: Array
    kinds: npt.NDArray[np.intp]
    mean_atoms: float


def _checked_law(law: str, stiffness: object, coefficient: object) -> float:
    """The stiffness, or the coefficient, as the law needs it."""
    given = {"stiffness": stiffness, "coefficient": coefficient}
    paper = one_of("law", law, LAWS) == "paper"
    needed, other = ("coefficient", "stiffness") if paper else ("stiffness", "coefficient")
    if given[other] is not None:
        refuse(other, given[other], f'has no part in law = "{law}"; leave it out')
    if given[needed] is None:
        rule = f'law = "{law}" needs it; for lengths in units of your own write {needed} = 1.0'
        refuse(needed, None, rule)
    return positive(needed, given[needed])


def _listed(islands: list[Island], weights: npt.ArrayLike | None, quantiles: Array) -> _Family:
    """Islands drawn with weights, equal when left out; InputError for other weights."""
    shares = np.full(len(islands), 1.0) if weights is None else finite_array("weights", weights)
    if shares.shape != (len(islands),) or not (shares > 0.0).all():
        rule = f"must be {len(islands)} numbers above zero, one for each island"
        refuse("weights", weights, rule)
    shares = shares / shares.sum()
    kinds = np.searchsorted(np.cumsum(shares)[:-1], quantiles, "right")
    return _Family(islands, shares, kinds, float(shares @ [island.atoms for island in islands]))


def _pairs(sizes: npt.ArrayLike) -> list[list[int]]:
    """(n_i, n_j) of each size; InputError for other values."""
    try:
        pairs = np.asarray(sizes)
    except ValueError:  # rows of different lengths
        pairs = np.empty(0)
    right = pairs.ndim == 2 and pairs.shape[1] == 2 and pairs.size and pairs.dtype.kind in "iu"
    if not right or pairs.min() < 1 or pairs.prod(-1, dtype=float).max() > _MOST_ATOMS:
        rule = f"must be pairs of whole numbers of at least 1, such as [[10, 9]], {_MOST_ATOMS:g} atoms at most"
        refuse("sizes", sizes, rule)
    return pairs.tolist()


def _decaying(mean_atoms: object, make: Callable[..., Island], quantiles: Array) -> _Family:
    """Islands of N atoms, P(N) ~ exp(-N/mean_atoms), N = 1, 2, ..., about as high as wide: n_j is (2N/sqrt(3))^(1/2)
    and n_i is N/n_j, both rounded to whole numbers of at least 1."""
    decay = between("mean_atoms", mean_atoms, 0.0, _MOST_ATOMS, "take fewer atoms")
    count = 1.0 + np.floor(-decay * np.log1p(-quantiles))
    rows = np.maximum(np.rint(np.sqrt(count * (2.0 / np.sqrt(3.0)))), 1.0)
    columns = np.maximum(np.rint(count / rows), 1.0)
    pairs = np.column_stack([columns, rows]).astype(int)
    different, kinds, times = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    islands = [make(*pair) for pair in different.tolist()]
    mean = float(-1.0 / np.expm1(-1.0 / decay))
    return _Family(islands, times / times.sum(), kinds.ravel(), mean)
