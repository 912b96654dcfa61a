"""Thresholds of rotated domains: islands of a crystal, at all angles, on another one (paper, Sec. VI C)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.domains.angle_thresholds import angle_thresholds
from origins.domains.barriers import checked_substrate, radians
from origins.domains.domain_samples import DomainSamples
from origins.domains.drawing import Angles, Islands, decaying, draw, given, listed, triangular
from origins.domains.substrates import Substrate
from origins.errors import InputError, finite_array, positive, refuse, whole
from origins.roughness.power_law import PowerLaw
from origins.samples.from_samples import from_samples
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import mixture
from origins.thresholds.powered import Powered

if TYPE_CHECKING:
    import ase

LAWS = ("area", "equal", "paper")
_MOST_SAMPLES = 100_000_000
_MOST_ATOMS = 1e12
_FEW = 2  # sizes whose curves of barriers are followed: solvers take half a minute for the peaks of three


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

    The paper prints neither lattice constant nor sizes nor angles: none of them has a default here but the
    angles, and all other defaults are this package's own.

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
        Instead of all that, islands of your own, drawn with `weights`. Their barriers cost a sum over the
        atoms.
    weights : array of shape (m,)
        Shares of `sizes` or `islands`, above zero; equal when left out.
    bonds : float
        Makes `islands` flexible: the stiffness of harmonic_bonds between neighbours, energy per length².
        Their barriers are those of relaxed_barrier and take seconds for each island and angle, so the
        angles must be listed. Left out, islands are rigid.
    angles : array
        Radians, from -2 pi to 2 pi. Taken in turn, sample by sample; left out, each island lies at any
        angle of the full circle.
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
        barriers, histogram, the weight of islands that slide freely, and how well exp(-f_s/f) fits. Force
        and holding fraction of a run count the islands that resist only.

        One or two rigid islands on two waves, at any angle and without a temperature, have no sampling error:
        P_c comes from b(angle) itself. It diverges where b stands still, so that K* is infinite, and jumps
        where min(|S_x|, |S_y|) changes sides. Elsewhere, and for islands of some hundred periods across,
        samples smooth such peaks away.

    Raises InputError for values outside these, for a substrate that varies in one direction only, and where
    no island resists.
    """
    substrate = checked_substrate(substrate)
    if substrate.rank == 1:
        raise InputError(
            "substrate: varies in one direction only, and every island slides freely across it"
        )
    scale = _checked_law(law, stiffness, coefficient)
    if bonds is not None:
        bonds = positive("bonds", bonds)
        if islands is None or angles is None:
            refuse(
                "bonds", bonds, "makes islands of your own flexible, at listed angles; give both"
            )
    family = _islands(lattice_constant, sizes, mean_atoms, islands, weights, bonds, substrate)
    choice = Angles(
        None if angles is None else radians(finite_array("angles", angles), "angles"),
        None if temperature is None else positive("temperature", temperature),
        float(np.hypot(*substrate.wavevectors.T).max()),
    )
    samples = whole("samples", samples, 1)
    if samples > _MOST_SAMPLES:
        refuse("samples", samples, f"must be at most {_MOST_SAMPLES}")
    drawn = draw(family, choice, samples, seed, comm)
    if not drawn.resists.any():
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

    resisting = drawn.barriers[drawn.resists]
    forces = resisting / period
    lengths = (resisting * per_energy(drawn.n_atoms[drawn.resists])) ** exponent
    thresholds = None
    waves = len(substrate.coefficients)
    if waves == 2 and angles is None and temperature is None and drawn.resists.all():
        thresholds = _of_curves(family, choice.fastest, per_energy, exponent)
    thresholds = from_samples(lengths) if thresholds is None else thresholds
    mean, distance, ratios = _exponential(np.sort(forces))
    thresholds.domains = DomainSamples(
        barriers=drawn.barriers,
        angles=drawn.angles,
        n_atoms=drawn.n_atoms,
        period=period,
        superlubric_weight=1.0 - forces.size / samples,
        mean_stiffness=float((forces / lengths).mean()),
        mean_force=mean,
        exponential_distance=distance,
        exponential_ratios=ratios,
    )
    return thresholds


def _of_curves(
    family: Islands, fastest: float, per_energy: Callable[[int], Array], exponent: float
) -> Thresholds | None:
    """The law of few islands from b(angle) itself; None where one of them has too many peaks to follow."""
    if not 0 < len(family.all) <= _FEW:
        return None
    laws = []
    for _, numbers in family.all:
        island = family.make(*numbers)
        gain = float(per_energy(island.atoms))
        law = angle_thresholds(island.climb, fastest * island.reach, gain)
        if law is None:
            return None
        laws.append(law if exponent == 1.0 else Powered(law, PowerLaw(1.0, exponent)))
        laws[-1].knows_breakpoints = law.knows_breakpoints
    return mixture(laws, [share for share, _ in family.all]) if len(laws) > 1 else laws[0]


def _exponential(forces: Array) -> tuple[float, float, tuple[float, float]]:
    """Mean of the sorted forces, and how far they are from an exponential law of that mean: distance, moments."""
    mean = float(forces.mean())
    fitted = -np.expm1(-forces / mean)
    steps = np.arange(forces.size + 1) / forces.size
    distance = float(max((steps[1:] - fitted).max(), (fitted - steps[:-1]).max()))
    scaled = forces / mean
    return mean, distance, (float((scaled**2).mean() / 2.0), float((scaled**3).mean() / 6.0))


def _checked_law(law: str, stiffness: object, coefficient: object) -> float:
    if law not in LAWS:
        refuse("law", law, 'must be "area", "equal" or "paper"')
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
    substrate: Substrate,
) -> Islands:
    """What to draw from; InputError unless it is told in one way."""
    if sum(way is not None for way in (sizes, mean_atoms, islands)) != 1:
        raise InputError(
            "domains: give exactly one of sizes, such as [(10, 9)], mean_atoms, such as 100, and islands, a "
            "list of ase.Atoms"
        )
    if islands is not None:
        if lattice_constant is not None:
            refuse("lattice_constant", lattice_constant, "islands have their own; leave it out")
        if hasattr(islands, "get_positions"):
            refuse("islands", islands, "is one island, and they are a list; write [atoms]")
        if len(islands) == 0:
            refuse("islands", islands, "must hold at least one ase.Atoms")
        numbers = np.arange(len(islands))[:, None]
        return listed(numbers, _shares(weights, len(islands)), given(islands, substrate, bonds))
    if lattice_constant is None:
        rule = "triangular islands need it; give a length, such as lattice_constant = 2.5"
        refuse("lattice_constant", None, rule)
    make = triangular(positive("lattice_constant", lattice_constant), substrate)
    if sizes is None:
        if weights is not None:
            refuse("weights", weights, "exp(-N_a/mean_atoms) are the weights; leave it out")
        decay = positive("mean_atoms", mean_atoms)
        if decay > _MOST_ATOMS:
            refuse("mean_atoms", mean_atoms, f"must be at most {_MOST_ATOMS:g}")
        return decaying(decay, make)
    try:
        pairs = np.asarray(sizes)
    except ValueError:  # rows of different lengths
        pairs = np.empty(0)
    right = pairs.ndim == 2 and pairs.shape[1] == 2 and pairs.size and pairs.dtype.kind in "iu"
    if not right or pairs.min() < 1:
        rule = "must be pairs (n_i, n_j) of whole numbers of at least 1, such as [[10, 9]]"
        refuse("sizes", sizes, rule)
    if pairs.prod(-1, dtype=float).max() > _MOST_ATOMS:
        refuse("sizes", sizes, f"must have n_i n_j of at most {_MOST_ATOMS:g}")
    return listed(pairs.astype(np.int64), _shares(weights, len(pairs)), make)


def _shares(weights: npt.ArrayLike | None, count: int) -> Array:
    """Weights of `count` islands as shares that add up to 1; equal when left out. InputError unless above zero."""
    if weights is None:
        return np.full(count, 1.0 / count)
    shares = np.asarray(weights, dtype=float)
    if shares.shape != (count,) or not np.isfinite(shares).all() or not (shares > 0.0).all():
        rule = f"must be {count} finite numbers above zero, one for each island"
        refuse("weights", weights, rule)
    return shares / shares.sum()
