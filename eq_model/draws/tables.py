"""Quantiles of thresholds and stretches as tables of fixed cells, certified when they are built.

Probability is counted from both ends, v = min(u, 1 - u), so that tails are as accurate as the middle.
Each octave of v from 2^-12 to 1/2 is divided in 32 quadratic cells, which kernels find from the bits
of a random word. Where a cell fails its certificate, as at kinks and jumps, a tree of halved cells
replaces it. A tree also covers v < 2^-12; its cells are quadratic in -log2 v, so that even a deep tail
takes few of them. For a mixture the component is drawn first; each has its own cells, so that gaps
and steps between components cost nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from origins.errors import InputError
from origins.thresholds.mixture import Mixture

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

OCTAVES, CELL_BITS = 11, 5  # of the quick cells
CELLS = 1 << CELL_BITS
SIDE = OCTAVES * CELLS + 1  # cells of one side; the first is its tail, v < 2^-12
FAR = 1 << 58  # whole length beyond every path; in a quick cell it refers to the tree
DEEPEST = 2.0**-64  # smallest v that 64 random bits resolve

_TOLERANCE = 1e-6  # of |cdf - u|, relative to min(u, 1 - u)
_MOST_PARTS = 8  # most components that are drawn first; a mixture of more is one table
_CHECKS = (np.arange(10) + 0.5) / 10.0
_THINNEST = 2.0**-50  # relative width of a cell in v that is not halved further
_MOST_LEFT = 1e-11  # largest total weight of such cells
_MOST_CELLS = 200_000
_SMALLEST = 1e-300  # over a typical value: smaller values underflow
# a law of the user may compute one tail as 1 minus the other, with the round-off of 1
_GRAINY, _GRAIN = np.array([3e-15, 1e-14, 3e-14]), 4e-16


class Table(NamedTuple):
    """Quantiles for kernels: of each part SIDE cells from below and SIDE from above, then their trees.

    A cell's value is c0 + t (c1 + t c2), with t the share of the cell below v; in the tail, the first
    cell of each side, the share below -log2 v.
    """

    hot: Whole  # (parts 2 SIDE 2,): c0, and c1 and c2 in single precision; see in_units
    child: npt.NDArray[np.int32]  # (nodes,): the lower half, the upper half follows it; -1: a leaf
    cells: Array  # (nodes, 5): lower edge, width, c0, c1, c2
    first: Whole  # (parts,): node of each part's first cell
    begins: Whole  # (parts,): first of the 2^32 words that select this part
    spreads: npt.NDArray[np.uint64]  # (parts,): 2^64 over the number of these words
    weights: Array  # (parts,)

    def in_units(self, unit: float) -> Table:
        """This table in units of a length, with the quick cells that draws need."""
        cells = self.cells.copy()
        cells[:, 2:] /= unit
        quick = (self.first[:, None] + np.arange(2 * SIDE)).ravel()
        # tails, halved cells, and values beyond all paths are left to the tree
        slow = (np.arange(quick.size) % SIDE == 0) | (self.child[quick] >= 0)
        slow |= np.abs(cells[quick, 2:]).sum(axis=1) >= FAR
        hot = np.zeros((quick.size, 2))
        hot[:, 0] = np.where(slow, 2.0 * FAR, cells[quick, 2])
        hot.view(np.float32)[:, 2:] = np.where(slow[:, None], 0.0, cells[quick, 3:])
        return self._replace(cells=cells, hot=hot.view(np.int64).ravel())

    @property
    def largest(self) -> float:
        """The largest value that may be drawn."""
        return float(np.abs(self.cells[:, 2:4]).max())


def make_table(law: Any, deepest: float = DEEPEST, name: str = "thresholds") -> Table:
    """The table of a law, in its lengths, down to v = `deepest` from above: |cdf(Q(u)) - u| <= 1e-6 min(u, 1 - u).

    law : with cdf, sf, ppf and isf, as Thresholds, Start and distributions of scipy.stats have them. Each part is
    certified at ten points of every cell. A value within 4 units in the last place of the exact one also passes, and
    so does an error of v up to 4e-16 below v = 1e-9 where the law's own tail is no more accurate.

    Raises InputError, with `name`, where cdf, sf, ppf and isf do not agree well enough for that, and
    where more weight than 2^-54 lies so near to 0 that values underflow.
    """
    typical = max(abs(float(law.ppf(0.5))), float(law.isf(0.25)) - float(law.ppf(0.25)))
    lost = float(np.diff(law.cdf(_SMALLEST * typical * np.array([-1.0, 1.0])))[0])
    if lost > 2.0**-54:
        raise InputError(
            f"{name}: a weight of {lost:.2g} lies below {_SMALLEST:g} of a typical value, where numbers "
            "end, so that contacts cannot draw from there; take a law with an onset power above -0.94"
        )
    laws: list[Any] = [law]
    weights = np.ones(1)
    if isinstance(law, Mixture) and len(law.components) <= _MOST_PARTS:
        laws, weights = list(law.components), law.weights
    built = [_halved(part, min(deepest, DEEPEST), name) for part in laws]
    first = np.cumsum([0, *(len(cells) for cells, _ in built)])[:-1]
    trees = (np.where(c >= 0, c + at, -1) for (_, c), at in zip(built, first, strict=True))
    child = np.concatenate(list(trees))
    cells = np.concatenate([cells for cells, _ in built])
    ends = np.rint(np.cumsum(np.append(0.0, weights)) * 2.0**32).astype(np.int64)
    ends[-1] = 1 << 32
    spreads = [((1 << 64) - 1) // max(int(many), 1) for many in np.diff(ends)]
    parts = ends[:-1], np.array(spreads, np.uint64), weights
    return Table(np.zeros(0, np.int64), child.astype(np.int32), cells, first, *parts)


def _halved(law: Any, deepest: float, name: str) -> tuple[Array, Whole]:
    """Cells of one part, halved where they fail their certificate, and their children; the first 2 SIDE are quick."""
    octaves = np.outer(2.0 ** np.arange(OCTAVES), 1.0 + np.arange(CELLS) / CELLS).ravel()
    edge = 2.0 ** -(OCTAVES + 1) * np.append(octaves, 2.0**OCTAVES)
    left, right = np.tile(np.append(OCTAVES + 1.0, edge[:-1]), 2), np.tile(edge, 2)
    right[[0, SIDE]] = -np.log2([DEEPEST, deepest])
    above, tail = np.repeat([False, True], SIDE), np.tile(np.arange(SIDE) == 0, 2)
    rows, children, total, left_over, why = [], [], 0, 0.0, ""
    pairs = (law.cdf, law.ppf), (law.sf, law.isf)
    off = [np.abs(of_x(inverse(_GRAINY)) / _GRAINY - 1.0).max() for of_x, inverse in pairs]
    grain = np.where(np.array(off) > _TOLERANCE, _GRAIN, 0.0)
    while left.size and not why:
        total += left.size
        row = _fit(law, left, right, above, tail)
        if not np.isfinite(row).all():
            why = "they are not finite"
            break
        good = _certified(law, row, above, tail, grain)
        thin = ~good & (right - left <= _THINNEST * right)
        left_over += float(np.abs(_v(right, tail) - _v(left, tail))[thin].sum())
        row[thin, 2] = row[thin, 2:].sum(axis=1)  # constant, with the value at the far end
        row[thin, 3:] = 0.0
        split = ~good & ~thin
        child = np.full(left.size, -1)
        child[split] = total + 2 * np.arange(split.sum())
        rows.append(row)
        children.append(child)
        ends = np.stack([left, 0.5 * (left + right), right], axis=1)[split]
        left, right = ends[:, :2].ravel(), ends[:, 1:].ravel()
        above, tail = np.repeat(above[split], 2), np.repeat(tail[split], 2)
        if total + left.size > _MOST_CELLS:
            why = "it would take more than 200,000 cells"
        elif left_over > _MOST_LEFT:
            why = f"a weight of {left_over:.2g} is left over at its jumps"
    if why:
        raise InputError(
            f"{name}: the quantiles cannot be tabulated to 1e-6 ({why}); make the distribution's "
            "cdf, sf, ppf and isf agree"
        )
    return np.concatenate(rows), np.concatenate(children)


def _fit(law: Any, left: Array, right: Array, above: Flags, tail: Flags) -> Array:
    """Rows of cells: lower edge, width and the parabola through three values of the law."""
    width = right - left
    # a law may jump at an edge: take values slightly inside the cell
    inset = np.minimum(2.0**-49 * right, width / 16.0)[:, None]
    nodes = left[:, None] + inset + (width[:, None] - 2.0 * inset) * np.array([0.0, 0.5, 1.0])
    v, y = _v(nodes, tail[:, None]), np.empty(nodes.shape)
    y[~above], y[above] = law.ppf(v[~above]), law.isf(v[above])
    c1, c2 = -3.0 * y[:, 0] + 4.0 * y[:, 1] - y[:, 2], 2.0 * (y[:, 0] - 2.0 * y[:, 1] + y[:, 2])
    return np.stack([left, width, y[:, 0], c1, c2], axis=1)


def _certified(law: Any, row: Array, above: Flags, tail: Flags, grain: Array) -> Flags:
    """Whether the values of each cell have the tail probabilities that they should."""
    left, width, c0, c1, c2 = (column[:, None] for column in row.T)
    v = _v(left + width * _CHECKS, tail[:, None])
    apart = np.abs(_v(left + width, tail[:, None]) - _v(left, tail[:, None]))
    # the limit 0.01 of its width makes a cell fail that contains a jump, however thin it is
    slack = np.minimum(_TOLERANCE * np.minimum(v, 1.0 - v), 0.01 * apart)
    slack += grain[above.astype(int)][:, None] * (v < 1e-9)
    x = c0 + _CHECKS * (c1 + _CHECKS * c2)
    good = np.abs(_tail(law, x, above) - v) <= slack
    off = np.flatnonzero(~good.all(axis=1))
    x, v, slack, above = x[off], v[off], slack[off], above[off]
    ulps = 4.0 * np.finfo(float).eps * np.abs(x) * np.where(above, 1.0, -1.0)[:, None]
    low, high = _tail(law, x + ulps, above), _tail(law, x - ulps, above)
    good[off] |= (low <= v + slack) & (high >= v - slack)
    return np.asarray(good.all(axis=1))


def _tail(law: Any, x: Array, above: Flags) -> Array:
    """The probability of a value below each x, or above it."""
    out = np.empty(x.shape)
    out[~above], out[above] = law.cdf(x[~above]), law.sf(x[above])
    return out


def _v(place: Array, tail: Flags) -> Array:
    """The v of places in cells, which in tails are -log2 v."""
    return np.where(tail, np.exp2(-np.where(tail, place, 0.0)), place)
