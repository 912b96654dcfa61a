"""Islands: rigid domains of a crystal as ase.Atoms, flat in the plane z = 0 (paper, Sec. VI C).

A barrier depends on the outline, so the outline is an input. Any other ase.Atoms serves as an island too.
"""

from dataclasses import dataclass
from math import ceil, sqrt
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from origins.errors import non_negative, one_of, positive, refuse, whole
from origins.thresholds.law import Array

if TYPE_CHECKING:
    import ase

Atoms: TypeAlias = "ase.Atoms"

# in lattice constants: the shift of odd rows, and the distance of rows
LATTICES = {"triangular": (0.5, 0.5 * sqrt(3.0)), "square": (0.0, 1.0)}
_MOST_ATOMS = 100_000_000
# of the shortest distance of two atoms: a gap in z beyond which another layer begins
_GAP = 0.5


@dataclass(frozen=True)
class Layers:
    """How the atoms of an island lie one above the other, which no barrier of a rigid one sees.

    atoms, formula : their number, and their elements, such as "C103Au289"
    layers : how many there are, along z
    apart : from below, the formulas of parts of other elements that no bond joins, such as a flake and a slab below it:
        the nearest neighbour of each atom is in its own part; one formula where there is but one part
    """

    atoms: int
    formula: str
    layers: int
    apart: tuple[str, ...]


def triangular_island(lattice_constant: float, n_i: int, n_j: int) -> Atoms:
    """n_i n_j atoms of a triangular lattice in n_j close-packed rows of n_i (paper, Sec. VI C).

    Atom (i, j) is at x = (i + j/2) a, y = j a sqrt(3)/2, with j = 0, ..., n_j - 1 and i = -(j//2), ...,
    -(j//2) + n_i - 1, j//2 rounded down: odd rows are shifted by a/2 against even ones.
    lattice_constant is a length above zero, n_i and n_j are whole numbers of at least 1, else InputError.
    """
    return _rows(lattice_constant, n_i, n_j, "triangular")


def square_island(lattice_constant: float, n_i: int, n_j: int) -> Atoms:
    """n_j rows of n_i atoms of a square lattice; parameters as triangular_island."""
    return _rows(lattice_constant, n_i, n_j, "square")


def _rows(lattice_constant: float, n_i: int, n_j: int, lattice: str) -> Atoms:
    a, (shift, row) = positive("lattice_constant", lattice_constant), LATTICES[lattice]
    if whole("n_i", n_i, 1) * whole("n_j", n_j, 1) > _MOST_ATOMS:
        refuse("n_i", n_i, f"n_i n_j is {_MOST_ATOMS} at most; triangular_barrier needs no atoms")
    j, i = np.indices((n_j, n_i))
    return _atoms((i + shift * (j % 2)) * a, row * a * j)


def rectangular_island(
    lattice_constant: float, width: float, height: float, *, lattice: str = "triangular"
) -> Atoms:
    """The atoms within width x height (lengths, at least zero) about one atom, close-packed rows along the width.
    lattice is "triangular" or "square". Raises InputError for other values and above 10^8 atoms."""
    half = 0.5 * non_negative("width", width), 0.5 * non_negative("height", height)
    x, y = _lattice(lattice_constant, lattice, *half)
    return _cut(x, y, np.maximum(abs(x) - half[0], abs(y) - half[1]), lattice_constant)


def hexagonal_island(
    lattice_constant: float, radius: float, *, lattice: str = "triangular"
) -> Atoms:
    """The atoms within a regular hexagon about one atom, its corners at `radius` (a length), one of them along x: on
    the triangular lattice 3n(n + 1) + 1 for radius = n lattice_constant. Otherwise as rectangular_island."""
    flat, radius = 0.5 * sqrt(3.0), non_negative("radius", radius)
    x, y = _lattice(lattice_constant, lattice, radius, radius)
    beyond = np.maximum(abs(y), flat * abs(x) + 0.5 * abs(y)) - flat * radius
    return _cut(x, y, beyond, lattice_constant)


def circular_island(
    lattice_constant: float, radius: float, *, lattice: str = "triangular"
) -> Atoms:
    """The atoms at most `radius` (a length, at least zero) from one atom; otherwise as rectangular_island."""
    radius = non_negative("radius", radius)
    x, y = _lattice(lattice_constant, lattice, radius, radius)
    return _cut(x, y, np.hypot(x, y) - radius, lattice_constant)


def irregular_island(
    lattice_constant: float,
    radius: float,
    *,
    roughness: float = 0.2,
    seed: int = 0,
    lattice: str = "triangular",
) -> Atoms:
    """The atoms within a rough outline r(theta) = radius exp[roughness g(theta)], about a random place of the lattice.

    g is a random wave of variance 1 on average, its harmonics m = 1, ..., 6 falling off as 1/m; the same seed gives
    the same island. roughness is between 0 and 3, seed a whole number of at least 0; otherwise as rectangular_island.
    At least one atom remains, the nearest to the middle.
    """
    radius = positive("radius", radius)
    if non_negative("roughness", roughness) > 3.0:
        refuse("roughness", roughness, "must be at most 3.0")
    generator = np.random.default_rng(whole("seed", seed, 0))
    m = np.arange(1, 7)
    waves = generator.standard_normal((2, m.size)) / m / np.sqrt((1.0 / m**2).sum())
    offset = generator.random(2)
    furthest = radius * float(np.exp(roughness * np.hypot(*waves).sum()))
    x, y = _lattice(lattice_constant, lattice, furthest, furthest)
    x = x + offset[0] * lattice_constant
    y = y + offset[1] * lattice_constant * LATTICES[lattice][1]
    phase, distance = np.arctan2(y, x)[..., None] * m, np.hypot(x, y)
    swell = np.cos(phase) @ waves[0] + np.sin(phase) @ waves[1]
    beyond = distance - radius * np.exp(roughness * swell)
    return _cut(x, y, np.where(distance == distance.min(), 0.0, beyond), lattice_constant)


def _lattice(a: float, lattice: str, width: float, height: float) -> tuple[Array, Array]:
    """x and y of a lattice, at least within `width` and `height`, and a period more, of an atom in the middle."""
    shift, row = LATTICES[one_of("lattice", lattice, tuple(LATTICES))]
    columns, rows = width / positive("lattice_constant", a) + 2.0, height / (row * a) + 2.0
    if not 4.0 * columns * rows <= _MOST_ATOMS:
        refuse("lattice_constant", a, f"gives more than {_MOST_ATOMS} atoms; take a smaller island")
    j, i = np.mgrid[1 - ceil(rows) : ceil(rows), -ceil(columns) : ceil(columns)]
    return (i + shift * (j % 2)) * a, j * row * a


def _cut(x: Array, y: Array, beyond: Array, lattice_constant: float) -> Atoms:
    """The atoms whose distance `beyond` an outline (a length) is at most rounding."""
    kept = beyond <= 1e-9 * lattice_constant
    return _atoms(x[kept], y[kept])


def _atoms(x: np.ndarray, y: np.ndarray) -> Atoms:
    import ase

    # element 0 is ASE's own dummy, of mass 1
    positions = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=-1)
    return ase.Atoms(numbers=np.zeros(x.size, dtype=int), positions=positions)


def points_of(atoms: object) -> Array:
    """Positions of atoms, lengths, shape (N_a, 3); InputError unless `atoms` is an ase.Atoms with finite positions."""
    if not hasattr(atoms, "get_positions"):
        refuse("atoms", atoms, "must be ase.Atoms, such as origins.triangular_island(2.5, 10, 9)")
    points: Array = np.array(atoms.get_positions())
    if len(points) == 0 or not np.isfinite(points).all():
        refuse("atoms", atoms, "must hold at least one atom, all at finite positions")
    return points


def positions_of(atoms: Atoms) -> Array:
    """x and y of atoms about their centre of mass, lengths, shape (N_a, 2); InputError also for masses of 0."""
    points, masses = points_of(atoms), atoms.get_masses()
    if not masses.sum() > 0.0:
        refuse("atoms", atoms, "must have masses above zero: the island turns about their centre")
    flat = points[:, :2] - points[:, :2].mean(axis=0)
    centred: Array = flat - (masses / masses.sum()) @ flat
    return centred


def layers_of(atoms: Atoms) -> Layers:
    """The layers of the atoms of an island, and its parts of other elements, one above the other."""
    order = np.argsort(atoms.positions[:, 2], kind="stable")
    points, formula = atoms.positions[order], atoms.get_chemical_formula()
    steps = np.diff(points[:, 2])
    if not steps.any():
        return Layers(len(points), formula, 1, (formula,))
    import scipy

    distances, nearest = scipy.spatial.cKDTree(points).query(points, k=2)
    gaps = steps > _GAP * distances[:, 1].min()
    # how many atoms have their nearest neighbour on the other side of each step in z
    own, other = np.arange(len(points)), nearest[:, 1]
    begins, ends = (
        np.bincount(each(own, other), minlength=len(points)) for each in (np.minimum, np.maximum)
    )
    joined = np.cumsum(begins - ends)[:-1] > 0
    parts = [order[:0]]
    for part in np.split(order, np.flatnonzero(gaps & ~joined) + 1):
        if {*atoms.numbers[parts[-1]]} == {*atoms.numbers[part]}:
            part = np.concatenate([parts.pop(), part])
        parts.append(part)
    apart = tuple(atoms[part].get_chemical_formula() for part in parts[1:])
    return Layers(len(points), formula, int(gaps.sum()) + 1, apart)
