"""Whole numbers for lengths, and the bins in which breaks are summed along the path.

Every length is a whole number of `unit`, a power of two far below the mean threshold: sums are then exact and
do not depend on their order. The path is covered by lattice cells, each a power of two wide; a cell holds at
most one path point, or is crowded and has bins of its own.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

BLOCK = 1 << 16  # contacts summed before the sums are split in two limbs
SUM_BITS = 61
_PATH_BITS = 57
_MOST_BITS = 44  # 2^-44 of the scale is below the table's own error
_LEAST_BITS = 24
TIE = 1 << 10  # units of rounding through which ties of exact thresholds with path points and turns are kept
_LIMB = 32
_FINEST = 2.0**-20  # width of a cell, in scales


@dataclass(frozen=True)
class Lattice:
    """The path in whole numbers.

    path : array (n,), lengths; origin : length, the zero of whole positions; unit : length.
    square : whole second moments are this times unit^-2.
    offset, shift : position b lies in cell (b + offset) >> shift; end : last position at which a break counts.
    points : path points, sorted; place : of each entry of path its point.
    bound : empty where points are the last positions of their cells, and each cell is a bin. Else for each cell its
    point, the largest number where it has none, and -1 - row of `crowds` where it has several; and the cell is two
    bins. crowds : rows (first bin, first point, one past the last point).
    bin_cell, bin_point : of each bin the cell, and the first of `points` not before it.
    """

    path: Array
    origin: float
    unit: float
    square: float
    offset: int
    shift: int
    end: int
    points: Whole
    place: npt.NDArray[np.intp]
    bound: Whole
    crowds: Whole
    bin_cell: Whole
    bin_point: npt.NDArray[np.intp]

    @property
    def for_kernel(self) -> tuple[int, int, int, int, float, Whole, Whole, Whole]:
        """The part that the kernel needs."""
        top = self.bin_cell.size
        return self.offset, self.shift, self.end, top, self.square, self.bound, self.crowds, self.points


def make_lattice(path: Array, origin: float, scale: float, reach: float, exact: bool) -> Lattice:
    """Lattice for a checked `path` (lengths).

    origin : where position 0 lies; scale : a power of two near the thresholds' size; reach : the longest stretch that
    counts, start included; exact : whether P_c holds exact values, so that breaks may fall on path points.
    Raises InputError where the path is longer than 2^33 times the scale, or the reach than 2^20 times.
    """
    length = max(float(path[-1]) - origin, scale * _FINEST)
    most_cells = 4 * path.size + 1024
    spacing, even = _spacing(path, scale)
    halvings = max(np.ceil(np.log2(spacing / scale)), 0.0) if even else 0.0
    if even:
        halvings = min(halvings, np.floor(np.log2(max(most_cells * spacing / length, 1.0))))
        even = length / spacing <= most_cells
    width = spacing * 2.0**-halvings
    if not even:
        width = max(min(width, scale, length), length / most_cells, scale * _FINEST)
    # a bin's sum over one block is at most BLOCK (width + reach), its second moment twice the square of that
    room = int(np.ceil(np.log2((width + reach) / scale)))
    bits = min(_MOST_BITS, SUM_BITS - 16 - room, _PATH_BITS - int(np.ceil(np.log2(length / scale))))
    if reach / scale > 2.0 ** (SUM_BITS - 16 - _LEAST_BITS):
        raise InputError(
            f"thresholds: stretches may reach {reach / scale:.2g} mean thresholds, linked stiffness counted in; the "
            "ensemble sums up to some 1e6 of them: use thresholds with a shorter tail"
        )
    if bits < _LEAST_BITS:
        raise InputError(
            f"path[-1] = {path[-1]:g}: lies {length / scale:.2g} mean thresholds away; the ensemble follows contacts "
            "along a path of at most 8e9 of them"
        )
    shift = int(np.floor(np.log2(width / scale))) + bits
    unit = width * 2.0**-shift if even else scale * 2.0**-bits
    square = 2.0 ** (SUM_BITS - 17 - 2 * (room + bits))
    places = np.rint((path - origin) / unit).astype(np.int64) + (TIE if exact else 0)
    points, place = np.unique(places, return_inverse=True)
    if even:
        points = points[0] + np.arange(points.size) * (1 << (shift + int(halvings)))
    offset = -(int(points[0]) + 1) & ((1 << shift) - 1) if even else 0
    end = int(points[-1])
    cells = max((end + offset) >> shift, 0) + 1
    bound, crowds = np.empty(0, np.int64), np.empty((0, 3), np.int64)
    bin_cell = np.arange(cells)
    bin_point = np.searchsorted(points, ((bin_cell + 1) << shift) - 1 - offset)
    if not even:
        bound, crowds, bin_cell, bin_point = _bins(points, cells, shift)
    return Lattice(
        path, origin, unit, square, offset, shift, end, points, place.reshape(-1), bound, crowds, bin_cell, bin_point
    )


def _spacing(path: Array, scale: float) -> tuple[float, bool]:
    """The least distance of different path points, and whether, to rounding, it is that of all."""
    steps = np.diff(np.unique(path))
    if steps.size == 0:
        return scale, False
    spacing = (float(path[-1]) - float(path[0])) / (path.size - 1)
    off = np.abs(path - (path[0] + spacing * np.arange(path.size))).max()
    even = bool(off <= 64.0 * np.finfo(float).eps * path[-1])
    return (spacing, True) if even else (float(steps.min()), False)


def _bins(points: Whole, cells: int, shift: int) -> tuple[Whole, Whole, Whole, npt.NDArray[np.intp]]:
    """bound, crowds, bin_cell, bin_point of points that lie anywhere in their cells."""
    none = np.iinfo(np.int64).max
    bound = np.full(cells, none)
    ahead = int(np.searchsorted(points, 0))
    home, first, count = np.unique(points[ahead:] >> shift, return_index=True, return_counts=True)
    first = first + ahead
    many = count > 1
    bound[home[~many]] = points[first[~many]]
    bound[home[many]] = -1 - np.arange(many.sum())
    bins = 2 * cells + np.concatenate([[0], np.cumsum(count[many] + 1)])
    crowds = np.stack([bins[:-1], first[many], first[many] + count[many]], axis=-1).astype(np.int64).reshape(-1, 3)
    before = np.searchsorted(points, np.arange(cells) << shift)
    bin_cell = np.concatenate([np.repeat(np.arange(cells), 2), np.repeat(home[many], count[many] + 1)])
    ordinary = np.stack([before, before + (bound < none)], axis=-1).ravel()
    return bound, crowds, bin_cell, np.concatenate([ordinary, *(np.arange(low, high + 1) for _, low, high in crowds)])


def split(sums: Whole) -> Whole:
    """Whole sums as two limbs, shape (2, ...), high and low; limbs of many blocks and ranks may be added up."""
    return np.stack([sums >> _LIMB, sums & ((1 << _LIMB) - 1)])


def carried(limbs: Whole) -> Whole:
    """Added-up limbs with the low one below 2^32 again."""
    return np.stack([limbs[0] + (limbs[1] >> _LIMB), limbs[1] & ((1 << _LIMB) - 1)])


def joined(limbs: Whole) -> Array:
    """Limbs as floats."""
    return limbs[0] * 2.0**_LIMB + limbs[1]


def force(lattice: Lattice, n: int, births: Whole, moved: Whole) -> Array:
    """Mean stretch of n contacts at each path point (lengths, shape (n_points,)).

    births : limbs (2,) of the sum of the starting positions; moved : limbs (2, bins) of the thresholds broken in each
    bin.
    """
    order, last = order_of(lattice)
    total = joined(carried(np.cumsum(carried(moved)[:, order], axis=1) + births[:, None]))
    position = np.concatenate([joined(carried(births))[None], total])
    return (lattice.path - lattice.origin) - lattice.unit * (position[last] / n)[lattice.place]


def variance(
    lattice: Lattice, n: int, births: Whole, square_births: float, moved: Whole, moments: Whole, unseen: Array
) -> Array:
    """Variance of the stretch between n contacts at each path point (lengths^2, shape (n_points,)); inf for n = 1.

    births, moved : as for `force`; square_births : sum of the squared distances of the starting positions from their
    mean, in units^2; moments : limbs (2, bins) of the second moments of the thresholds broken in each bin,
    (b - r)^2 - (b - x - r)^2 with r the last position of the bin's cell.
    unseen : where it is above zero, the variance is at least this and that of the start, lengths^2.
    """
    if n == 1:
        return np.full(lattice.path.shape, np.inf)
    order, last = order_of(lattice)
    total = carried(np.cumsum(carried(moved)[:, order], axis=1) + births[:, None])
    # the bins in the order of the path: b is the sum of all births before each bin, relative to its cell
    before = joined(np.concatenate([carried(births)[:, None], total[:, :-1]], axis=1))
    reference = (lattice.bin_cell[order] + 1.0) * 2.0**lattice.shift - 1.0 - lattice.offset
    start = before - n * reference
    change = joined(carried(moved))[order]
    spread = joined(carried(moments))[order] / lattice.square - change * (2.0 * start + change) / n
    spread = np.concatenate([[square_births], square_births + np.cumsum(spread)])
    scale = lattice.unit**2 / (n - 1)
    least = np.where(unseen > 0.0, square_births * scale + unseen, 0.0)
    return np.maximum(np.maximum(spread[last], 0.0)[lattice.place] * scale, least)


def order_of(lattice: Lattice) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """The bins in the order of the path, and how many of them lie up to each path point."""
    order = np.lexsort((lattice.bin_point, lattice.bin_cell))
    return order, np.searchsorted(lattice.bin_point[order], np.arange(lattice.points.size), side="right")
