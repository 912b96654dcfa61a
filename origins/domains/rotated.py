"""Thresholds of rotated domains: islands of a crystal, at all angles, on another one (paper, Sec. VI C)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.angle_thresholds import angle_thresholds
from origins.domains.barriers import checked_substrate, radians
from origins.domains.domain_samples import DomainSamples
from origins.domains.drawing import Island, Islands, draw, of_atoms, triangular
from origins.domains.substrates import Substrate
from origins.errors import InputError, finite_array, one_of, positive, refuse, whole
from origins.roughness.power_law import PowerLaw
from origins.samples.from_samples import from_samples
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import mixture
from origins.thresholds.powered import Powered

if TYPE_CHECKING:
    import ase

LAWS = ("area", "equal", "paper")
_MOST_ATOMS = 1e12
_FEW = 2  # islands for which P_c comes from b(angle): solvers take half a minute for the peaks of three


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

    The paper prints neither lattice constant nor sizes nor angles: of these only the angles have a default
    here, and all other defaults are this package's own.

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
        As from_samples makes them of x_s, with their sampling error, and with `.domains`, a DomainSamples:
        barriers, the weight of islands that slide freely, and how well exp(-f_s/f) fits. Force
        and holding fraction of a run count only the islands that resist.

        One or two rigid islands on two waves, at any angle and without a temperature, have no sampling error:
        P_c comes from b(angle) itself. It diverges where db/dangle = 0, so that K* is infinite, and jumps
        where |S_x| = |S_y|. In all other cases, and for islands of some hundred periods across, P_c comes
        from samples, which smooth such peaks.

    Raises InputError for values outside these, for a substrate that varies in one direction only, and where
    no island resists.
    """
    substrate = checked_substrate(substrate)
    if substrate.rank == 1:
        rule = "varies in one direction only, and every island slides freely across it"
        raise InputError(f"substrate: {rule}")
    scale = _checked_law(law, stiffness, coefficient)
    if bonds is not None and (islands is None or angles is None):
        refuse("bonds", bonds, "makes islands of your own flexible, at listed angles; give both")
    chosen = None if angles is None else radians(finite_array("angles", angles), "angles")
    family = _islands(
        lattice_constant, sizes, mean_atoms, islands, weights, bonds, chosen, substrate
    )
    heat = None if temperature is None else positive("temperature", temperature)
    samples = whole("samples", samples, 1)
    barriers, turned, atoms = draw(family, chosen, heat, samples, seed, comm)
    resisting = barriers > 0.0
    if not resisting.any():
        raise InputError(
            f"domains: none of {samples} islands has a barrier, so no contact resists and there are no "
            "thresholds; change the angles, the sizes or the lattice constant"
        )
    period = float(np.hypot(*substrate.cell[0]))
    exponent = 0.5 if law == "paper" else 1.0

    def per_energy(atoms: npt.ArrayLike) -> Array:
        """x_s^(1/exponent) over epsilon_a, for islands of so many atoms."""
        relative = np.sqrt(np.asarray(atoms) / family.mean_atoms) if law == "area" else 1.0
        return np.asarray(1.0 / (period * scale * relative))

    lengths = (barriers * per_energy(atoms))[resisting] ** exponent
    known: list[Thresholds | None] = [None]
    two_waves = len(substrate.coefficients) == 2 and chosen is None and heat is None
    if two_waves and resisting.all() and 0 < len(family.rows) <= _FEW:
        kinds = [family.make(*row) for row in family.rows]
        known = [_at_all_angles(kind, float(per_energy(kind.atoms)), exponent) for kind in kinds]
    found = [one for one in known if one is not None]
    if len(found) < len(known):
        thresholds = from_samples(lengths)
    else:
        thresholds = found[0] if len(found) == 1 else mixture(found, family.shares)
    stiffness = float((barriers[resisting] / period / lengths).mean())
    thresholds.domains = DomainSamples(barriers, turned, atoms.astype(np.int64), period, stiffness)
    return thresholds


def _at_all_angles(island: Island, gain: float, exponent: float) -> Thresholds | None:
    """The law of (gain b)^exponent from b(angle) itself; None where the island has too many peaks."""
    law = angle_thresholds(island.sizes, island.phase, gain)
    if law is None or exponent == 1.0:
        return law
    return Powered(law, PowerLaw(1.0, exponent))


def _checked_law(law: str, stiffness: object, coefficient: object) -> float:
    """The stiffness, or the coefficient, as the law needs it."""
    one_of("law", law, LAWS)
    needed, other = ("coefficient", "stiffness") if law == "paper" else ("stiffness", "coefficient")
    values = {"stiffness": stiffness, "coefficient": coefficient}
    if values[other] is not None:
        refuse(other, values[other], f'has no part in law = "{law}"; leave it out')
    if values[needed] is None:
        rule = f'law = "{law}" needs it; for lengths in units of your own write {needed} = 1.0'
        refuse(needed, None, rule)
    return positive(needed, values[needed])


def _islands(
    lattice_constant: object,
    sizes: npt.ArrayLike | None,
    mean_atoms: object,
    islands: Sequence[ase.Atoms] | None,
    weights: npt.ArrayLike | None,
    bonds: float | None,
    angles: Array | None,
    substrate: Substrate,
) -> Islands:
    """The islands to draw from; InputError unless they are given in exactly one way."""
    if sum(way is not None for way in (sizes, mean_atoms, islands)) != 1:
        raise InputError(
            "domains: give exactly one of sizes, such as [(10, 9)], mean_atoms, such as 100, and islands, a "
            "list of ase.Atoms"
        )
    make: Callable[..., Island]
    if islands is not None:
        if lattice_constant is not None:
            refuse("lattice_constant", lattice_constant, "islands have their own; leave it out")
        if hasattr(islands, "get_positions") or len(islands) == 0:
            refuse("islands", islands, "must be a list of at least one ase.Atoms, such as [atoms]")
        stiffness = None if bonds is None else positive("bonds", bonds)
        own = [of_atoms(substrate, atoms, stiffness, angles) for atoms in islands]
        numbers, make = np.arange(len(own))[:, None], own.__getitem__
    else:
        if lattice_constant is None:
            rule = "triangular islands need it; give a length, such as lattice_constant = 2.5"
            refuse("lattice_constant", None, rule)
        make = partial(triangular, substrate, positive("lattice_constant", lattice_constant))
        if sizes is None:
            if weights is not None:
                refuse("weights", weights, "exp(-N_a/mean_atoms) are the weights; leave it out")
            return _decaying(mean_atoms, make)
        numbers = _pairs(sizes)
    shares = np.full(len(numbers), 1.0) if weights is None else finite_array("weights", weights)
    if shares.shape != (len(numbers),) or not (shares > 0.0).all():
        rule = f"must be {len(numbers)} numbers above zero, one for each island"
        refuse("weights", weights, rule)
    shares = shares / shares.sum()
    bounds, rows = np.cumsum(shares)[:-1], [tuple(row) for row in numbers.tolist()]
    mean = float(shares @ [make(*row).atoms for row in rows])
    return Islands(lambda q: numbers[np.searchsorted(bounds, q, "right")], make, mean, rows, shares)


def _pairs(sizes: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """(n_i, n_j) of each size, shape (m, 2); InputError for other values."""
    try:
        pairs = np.asarray(sizes)
    except ValueError:  # rows of different lengths
        pairs = np.empty(0)
    right = pairs.ndim == 2 and pairs.shape[1] == 2 and pairs.size and pairs.dtype.kind in "iu"
    if not right or pairs.min() < 1 or pairs.prod(-1, dtype=float).max() > _MOST_ATOMS:
        rule = f"must be pairs of whole numbers of at least 1, such as [[10, 9]], {_MOST_ATOMS:g} atoms at most"
        refuse("sizes", sizes, rule)
    return pairs.astype(np.int64)


def _decaying(mean_atoms: object, make: Callable[..., Island]) -> Islands:
    """Islands of N atoms, P(N) ~ exp(-N/mean_atoms), N = 1, 2, ..., about as high as wide: n_j is (2N/sqrt(3))^(1/2)
    and n_i is N/n_j, both rounded to whole numbers of at least 1."""
    decay = positive("mean_atoms", mean_atoms)
    if decay > _MOST_ATOMS:
        refuse("mean_atoms", mean_atoms, f"must be at most {_MOST_ATOMS:g}")

    def pick(quantile: Array) -> npt.NDArray[np.int64]:
        count = 1.0 + np.floor(-decay * np.log1p(-quantile))
        rows = np.maximum(np.rint(np.sqrt(count * (2.0 / np.sqrt(3.0)))), 1.0)
        columns = np.maximum(np.rint(count / rows), 1.0)
        return np.column_stack([columns, rows]).astype(np.int64)

    return Islands(pick, make, float(-1.0 / np.expm1(-1.0 / decay)), [], np.empty(0))
