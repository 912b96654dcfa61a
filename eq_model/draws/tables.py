"""Quantiles of thresholds and stretches as tables of fixed cells, certified when they are built.

Probability is counted from both ends, v = min(u, 1 - u), so that tails are as sharp as the middle.
Each octave of v from 2^-12 to 1/2 is divided in 32 quadratic cells, which kernels find from the bits
of a random word. Where a cell fails its certificate, as at kinks and jumps, a tree of halved cells
takes its place. So it does below 2^-12, where cells are quadratic in -log2 v: however deep, a tail
takes few of them. Of a mixture the component is drawn first, each with cells of its
own, so that gaps and steps between components cost nothing.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from origins.errors import InputError
from origins.thresholds.mixture import Mixture

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

OCTAVES, CELL_BITS = 11, 5  # of the quick cells
CELLS = 1 << CELL_BITS
SIDE = OCTAVES * CELLS + 1  # cells of one side; the first is its tail, v < 2^-12
FAR = 1 << 58  # whole lengths beyond every path; quick cells give more where the tree must be asked
TOLERANCE = 1e-6  # of |cdf - u|, relative to min(u, 1 - u)
LEVEL_UNIT = 2.0**-40  # logarithms of what contacts bear are drawn in whole numbers of this
DEEPEST = 2.0**-64  # a word and the one that continues it tell no smaller v

_MOST_PARTS = 8  # components drawn first; of more of them the sum is tabled as one law
_CHECKS = (np.arange(10) + 0.5) / 10.0
_NODES = np.array([0.0, 0.5, 1.0])
_INSET = 2.0**-49  # of v: cells keep off their edges, where a law may jump, by that much
_THINNEST = 2.0**-50  # of v: what cannot be halved further holds that little weight
_MOST_LEFT = 1e-11  # weight of such cells in all
_MOST_CELLS = 200_000
_SMALLEST = 1e-300  # of a typical value: where numbers end
_DEEP = 1e-9
# a foreign law may know one tail as 1 less the other only, to the round-off of 1
_GRAINY, _GRAIN = np.array([3e-15, 1e-14, 3e-14]), 4e-16


class Law(Protocol):
    """What is needed of a distribution; Thresholds and Start both have it."""

    def cdf(self, x: npt.ArrayLike) -> Array: ...
    def sf(self, x: npt.ArrayLike) -> Array: ...
    def ppf(self, q: npt.ArrayLike) -> Array: ...
    def isf(self, q: npt.ArrayLike) -> Array: ...


class Table(NamedTuple):
    """Quantiles in whole units, as kernels take them; of each part SIDE cells from below, SIDE from above.

    A cell's value is c0 + t (c1 + t c2), t the share of it that lies below v, or in the tail, the first
    cell of each side, the share that lies below -log2 v.
    """

    hot: npt.NDArray[np.int64]  # (parts 2 SIDE 2,): c0, and c1 and c2 in single precision
    child: npt.NDArray[np.int32]  # (nodes,): lower half, the upper one comes next; -1: a leaf
    cells: Array  # (nodes, 5): lower edge, width, c0, c1, c2; the first ones are the quick cells
    begins: npt.NDArray[np.int64]  # (parts,): first of the 2^32 words that draw this part
    spreads: npt.NDArray[np.uint64]  # (parts,): 2^64 over their number
    weights: Array  # (parts,)


@dataclass(frozen=True)
class Cells:
    """A law's cells in lengths; `children`, `cells`, `weights` as of Table."""

    children: npt.NDArray[np.int32]
    cells: Array
    weights: Array

    def table(self, unit: float) -> Table:
        """In units of a length."""
        child, parts = self.children, self.weights.size
        cells = self.cells.copy()
        cells[:, 2:] /= unit
        quick = cells[: 2 * SIDE * parts]
        # the tails, what was halved, and values that no path reaches
        slow = (np.arange(len(quick)) % SIDE == 0) | (child[: len(quick)] >= 0)
        slow |= np.abs(quick[:, 2:]).sum(axis=1) >= FAR
        hot = np.zeros((len(quick), 2))
        hot[:, 0] = np.where(slow, 2.0 * FAR, quick[:, 2])
        with np.errstate(over="ignore"):
            hot.view(np.float32)[:, 2:] = np.where(slow[:, None], 0.0, quick[:, 3:])
        ends = np.rint(np.cumsum(np.append(0.0, self.weights)) * 2.0**32).astype(np.int64)
        ends[-1] = 1 << 32
        count = np.maximum(np.diff(ends), 1)
        spreads = np.array(
            [min(((1 << 64) - 1) // int(many), (1 << 64) - 1) for many in count], np.uint64
        )
        return Table(hot.view(np.int64).ravel(), child, cells, ends[:-1], spreads, self.weights)

    @property
    def largest(self) -> float:
        """The largest length that may be drawn."""
        return float(np.abs(self.cells[:, 2:4]).max())


def make_cells(law: Law, deepest: float = DEEPEST, name: str = "thresholds") -> Cells:
    """Cells of a law, down to v = `deepest` from above: |cdf(Q(u)) - u| <= 1e-6 min(u, 1 - u).

    That is certified for each part at ten points of every cell. A value that differs from the exact
    one by 4 units in its last place also passes, as does below v = 1e-9 one within 4e-16 where the
    law itself knows that tail no better.

    Raises InputError, with `name`, where cdf, sf, ppf and isf do not agree well enough for that, and
    where more weight than 2^-54 lies so near to 0 that no number does.
    """
    typical = max(abs(float(law.ppf(0.5))), float(law.isf(0.25)) - float(law.ppf(0.25)))
    lost = float(np.diff(law.cdf(_SMALLEST * typical * np.array([-1.0, 1.0])))[0])
    if lost > 2.0**-54:
        raise InputError(
            f"{name}: a weight of {lost:.2g} lies below {_SMALLEST:g} of a typical value, where numbers "
            "end, so that contacts cannot draw from there; take a law with an onset power above -0.94"
        )
    laws: list[Law] = [law]
    weights = np.ones(1)
    if isinstance(law, Mixture) and len(law.components) <= _MOST_PARTS:
        laws, weights = list(law.components), law.weights
    built = [_Halving(part, min(deepest, DEEPEST), name).cells() for part in laws]
    quick = 2 * SIDE * len(laws)
    # the quick cells of all parts come first, then the trees of one after the other
    heads, tails, child_heads, child_tails = [], [], [], []
    place = quick - 2 * SIDE
    for cells, child in built:
        child = np.where(child >= 0, child + place, -1)
        heads.append(cells[: 2 * SIDE])
        tails.append(cells[2 * SIDE :])
        child_heads.append(child[: 2 * SIDE])
        child_tails.append(child[2 * SIDE :])
        place += len(cells) - 2 * SIDE
    children = np.concatenate(child_heads + child_tails).astype(np.int32)
    return Cells(children, np.concatenate(heads + tails), weights)


class _Halving:
    """The cells of one smooth part, halved where they fail."""

    def __init__(self, law: Law, deepest: float, name: str) -> None:
        self.law, self.deepest, self.name = law, deepest, name
        pairs = ((law.cdf, law.ppf), (law.sf, law.isf))
        self.grain = np.array(
            [_GRAIN * _is_grainy(tail(inverse(_GRAINY))) for tail, inverse in pairs]
        )

    def cells(self) -> tuple[Array, npt.NDArray[np.int64]]:
        """Cells and their children; the first 2 SIDE are the quick ones."""
        octaves = np.outer(2.0 ** np.arange(OCTAVES), 1.0 + np.arange(CELLS) / CELLS).ravel()
        edge = 2.0 ** -(OCTAVES + 1) * np.append(octaves, 2.0**OCTAVES)
        first, last = np.append(OCTAVES + 1.0, edge[:-1]), edge.copy()
        left, right = np.tile(first, 2), np.tile(last, 2)
        right[[0, SIDE]] = -np.log2([DEEPEST, self.deepest])
        above, tail = np.repeat([False, True], SIDE), np.tile(np.arange(SIDE) == 0, 2)
        rows, children, total, left_over = [], [], 0, 0.0
        while left.size:
            total += left.size
            if total > _MOST_CELLS:
                self._refuse("it would take more than 200,000 cells")
            row, good = self._fit(left, right, above, tail)
            thin = ~good & (right - left <= _THINNEST * right)
            left_over += float(
                np.abs(np.diff(_v(np.stack([left, right])[:, thin], tail[thin]), axis=0)).sum()
            )
            row[thin, 2] = row[thin, 2:].sum(axis=1)  # at the far end
            row[thin, 3:] = 0.0
            rows.append(row)
            split = ~good & ~thin
            child = np.full(left.size, -1)
            child[split] = total + 2 * np.arange(split.sum())
            children.append(child)
            left, right, above, tail = left[split], right[split], above[split], tail[split]
            middle = 0.5 * (left + right)
            left, right = (
                np.stack(pair, axis=1).ravel() for pair in ((left, middle), (middle, right))
            )
            above, tail = np.repeat(above, 2), np.repeat(tail, 2)
        if left_over > _MOST_LEFT:
            self._refuse(f"a weight of {left_over:.2g} is left over at its jumps")
        return np.concatenate(rows), np.concatenate(children)

    def _fit(self, left: Array, right: Array, above: Flags, tail: Flags) -> tuple[Array, Flags]:
        """Rows of cells, and which of them are certified."""
        width = right - left
        inset = np.minimum(_INSET * right, width / 16.0)
        nodes = (left + inset)[:, None] + (width - 2.0 * inset)[:, None] * _NODES
        y = self._inverse(_v(nodes, tail[:, None]), above)
        c1, c2 = -3.0 * y[:, 0] + 4.0 * y[:, 1] - y[:, 2], 2.0 * (y[:, 0] - 2.0 * y[:, 1] + y[:, 2])
        row = np.stack([left, width, y[:, 0], c1, c2], axis=1)
        if left.size == 2 * SIDE:  # quick cells hold their slopes in single precision
            with np.errstate(over="ignore"):
                c1, c2 = (np.where(tail, slope, slope.astype(np.float32)) for slope in (c1, c2))
        value = y[:, :1] + _CHECKS * (c1[:, None] + _CHECKS * c2[:, None])
        v = _v(left[:, None] + width[:, None] * _CHECKS, tail[:, None])
        apart = np.abs(np.diff(_v(np.stack([left, right]), tail), axis=0))[0]
        return row, self._certified(value, v, apart, above)

    def _inverse(self, v: Array, above: Flags) -> Array:
        y = np.empty(v.shape)
        y[~above], y[above] = self.law.ppf(v[~above]), self.law.isf(v[above])
        if not np.isfinite(y).all():
            self._refuse(f"its quantile at probability {v[~np.isfinite(y)][0]:.3g} is not finite")
        return y

    def _tail(self, x: Array, above: Flags) -> Array:
        out = np.empty(x.shape)
        out[~above], out[above] = self.law.cdf(x[~above]), self.law.sf(x[above])
        return out

    def _certified(self, x: Array, v: Array, width: Array, above: Flags) -> Flags:
        """Whether every row of values x at v, shape (n, 10), has the tail probability it should."""
        # a cell that straddles a gap never passes, however thin: its error is a part of its own width
        slack = np.minimum(TOLERANCE * np.minimum(v, 1.0 - v), 0.01 * width[:, None])
        slack += self.grain[above.astype(int)][:, None] * (v < _DEEP)
        good = np.abs(self._tail(x, above) - v) <= slack
        rows = np.flatnonzero(~good.all(axis=1))
        if rows.size:
            x, v, slack, side = x[rows], v[rows], slack[rows], above[rows]
            ulps = 4.0 * np.finfo(float).eps * np.abs(x) * np.where(side, 1.0, -1.0)[:, None]
            low, high = self._tail(x + ulps, side), self._tail(x - ulps, side)
            good[rows] |= (low <= v + slack) & (high >= v - slack)
        return np.asarray(good.all(axis=1))

    def _refuse(self, why: str) -> None:
        raise InputError(
            f"{self.name}: the quantiles cannot be tabulated to 1e-6 ({why}); make the distribution's "
            "cdf, sf, ppf and isf agree"
        )


def _v(place: Array, tail: Flags) -> Array:
    """The v of places in cells, which tails count in -log2 v."""
    return np.where(tail, np.exp2(-np.where(tail, place, 0.0)), place)


def _is_grainy(seen: Array) -> bool:
    return bool((np.abs(seen - _GRAINY) > TOLERANCE * _GRAINY).any())
