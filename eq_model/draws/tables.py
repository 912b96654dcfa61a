"""Quantiles of thresholds and stretches as tables of fixed cells, certified when they are built.

Probability is counted from both ends, v = min(u, 1 - u), so that tails are as accurate as the middle.
Each octave of v from 2^-12 to 1/2 is divided in 32 quadratic cells, for kernels in up to 512, found from
the bits of a random word. Where a cell fails its certificate, as at kinks and jumps, a tree of halved cells
replaces it, and kernels have smaller quick cells: beside a gap many fail. A tree also covers v < 2^-12;
its cells are quadratic in -log2 v, so that even a deep tail takes few of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from origins.errors import InputError
from origins.thresholds.law import Array

Flags = npt.NDArray[np.bool_]

OCTAVES, CELL_BITS = 11, 5  # of the quick cells
MOST_BITS = 9  # of the quick cells of kernels: their table, of 180 kB, is well within an L2 cache
SIDE = (OCTAVES << CELL_BITS) + 1  # cells of one side; the first is its tail, v < 2^-12
FAR = 1 << 58  # whole length beyond every path; in a quick cell it refers to the tree
DEEPEST = 2.0**-64  # smallest v that 64 random bits resolve
# cells beyond which quantiles may be off by this probability: a law of so many is no more accurate itself, as one of
# series between its peaks, and no run draws as many contacts as would show it
MANY, UNSEEN = 20_000, 1e-12


class QuantileTable(NamedTuple):
    """Quantiles for kernels: SIDE cells from below, then their trees, and the same from above.

    A cell's value is c0 + t (c1 + t c2), with t the share of the cell below v; in the tail, the first
    cell of each side, the share below -log2 v.
    """

    hot: Whole  # (2 sides, cells, 2), flat: c0 + 1/2, and the upper halves of c1 and c2; see in_units
    bits: np.int64  # 2^bits quick cells an octave
    child: npt.NDArray[np.int32]  # (nodes,): the lower half, the upper half follows it; -1: a leaf
    cells: Array  # (nodes, 5): lower edge, width, c0, c1, c2
    above: np.int64  # first cell of the side from above

    def in_units(self, unit: float) -> QuantileTable:
        """This table in units of a length, with quick cells for draws, halved while trees remain."""
        cells = self.cells.copy()
        cells[:, 2:] /= unit
        node = np.stack([np.arange(1, SIDE), self.above + np.arange(1, SIDE)])
        c, bits = cells[node, 2:], CELL_BITS
        while (slow := self.child[node] >= 0).any() and bits < MOST_BITS:
            upper = np.arange(2 * slow.shape[1]) % 2
            node, c, slow = (np.repeat(a, 2, axis=1) for a in (node, c * [1.0, 0.5, 0.25], slow))
            # c(t) = c0 + c1 t + c2 t² as a polynomial over the upper half: c0 and c1 at its beginning
            c[..., 0] += upper * (c[..., 1] + c[..., 2])
            c[..., 1] += upper * 2.0 * c[..., 2]
            node = np.where(slow, self.child[node] + upper, node)
            c, bits = np.where(slow[..., None], cells[node, 2:], c), bits + 1
        # values beyond all paths, and the tails, each side's first cell, are left to trees, too
        slow |= np.abs(c).sum(axis=2) >= FAR
        c[..., 0] += 0.5
        c = np.where(slow[..., None], [2.0 * FAR, 0.0, 0.0], c)
        hot = np.full((2, node.shape[1] + 1, 2), [2.0 * FAR, 0.0])
        hot[:, 1:, 0] = c[..., 0]
        slopes = np.ascontiguousarray(c[..., [2, 1]])
        hot.view(np.uint32)[:, 1:, 2:] = slopes.view(np.uint32)[..., 1::2]
        return self._replace(cells=cells, hot=hot.view(np.int64).ravel(), bits=np.int64(bits))

    @property
    def largest(self) -> float:
        """The largest value that is drawn, but for a share of some 1e-19."""
        return float(np.abs(self.cells[:, 2:4]).max())


def make_table(law: Any, deepest: float = DEEPEST, name: str = "thresholds") -> QuantileTable:
    """The table of a law, in its lengths, down to v = `deepest` from above: |cdf(Q(u)) - u| <= 1e-6 min(u, 1 - u).

    law : with cdf, sf, ppf and isf, as Thresholds, Start and distributions of scipy.stats have them. It is certified at
    ten points of every cell. A value within 4 units in the last place of the exact one also passes, and, of a
    law that takes MANY cells, one with |cdf(Q(u)) - u| <= UNSEEN.

    Raises InputError, with `name`, where cdf, sf, ppf and isf do not agree well enough for that, as
    where values underflow.
    """
    below, lower = _side(law.cdf, law.ppf, DEEPEST, name)
    above, upper = _side(law.sf, law.isf, min(deepest, DEEPEST), name)
    upper += len(below) * (upper >= 0)
    child = np.append(lower, upper).astype(np.int32)
    cells = np.concatenate([below, above])
    return QuantileTable(
        np.zeros(0, np.int64), np.int64(CELL_BITS), child, cells, np.int64(len(below))
    )


def _side(
    tail_of: Callable[[Any], Any], quantile: Callable[[Any], Any], deepest: float, name: str
) -> tuple[Array, Whole]:
    """Cells of one side of a law, halved where they fail their certificate, and their children; SIDE are quick."""
    octaves = np.outer(2.0 ** np.arange(OCTAVES), 1.0 + np.arange(0.0, 1.0, 0.5**CELL_BITS))
    edge = 2.0 ** -(OCTAVES + 1) * np.append(octaves, 2.0**OCTAVES)
    left, right = np.append(OCTAVES + 1.0, edge[:-1]), np.append(-np.log2(deepest), edge[1:])
    logarithmic = np.arange(SIDE) == 0
    rows, children, total, jumps, failure = [], [], 0, 0.0, ""
    while left.size and not failure:
        total += left.size
        row = _fit(quantile, left, right, logarithmic)
        if not np.isfinite(row).all():
            failure = "they are not finite"
            break
        good = _certified(tail_of, row, logarithmic, UNSEEN if total > MANY else 0.0)
        thin = ~good & (right - left <= 2.0**-50 * right)
        jumps += float(np.abs(_v(right, logarithmic) - _v(left, logarithmic))[thin].sum())
        row[thin, 2] = row[thin, 2:].sum(axis=1)  # constant, with the value at the far end
        row[thin, 3:] = 0.0
        split = ~good & ~thin
        child = np.full(left.size, -1)
        child[split] = total + 2 * np.arange(split.sum())
        rows.append(row)
        children.append(child)
        ends = np.stack([left, 0.5 * (left + right), right], axis=1)[split]
        left, right = ends[:, :2].ravel(), ends[:, 1:].ravel()
        logarithmic = np.repeat(logarithmic[split], 2)
        if total + left.size > 100_000:
            failure = "it would take more than 100,000 cells"
        elif jumps > 1e-11:
            failure = f"a weight of {jumps:.2g} is left over at its jumps"
    if failure:
        raise InputError(
            f"{name}: the quantiles cannot be tabulated to 1e-6 ({failure}); make the distribution's "
            "cdf, sf, ppf and isf agree"
        )
    return np.concatenate(rows), np.concatenate(children)


def _fit(quantile: Callable[[Any], Any], left: Array, right: Array, logarithmic: Flags) -> Array:
    """Rows of cells: lower edge, width and the parabola through three values of the law."""
    width = right - left
    # a law may jump at an edge: take values slightly inside the cell
    inset = np.minimum(2.0**-49 * right, width / 16.0)[:, None]
    nodes = left[:, None] + inset + (width[:, None] - 2.0 * inset) * np.array([0.0, 0.5, 1.0])
    y = np.asarray(quantile(_v(nodes, logarithmic[:, None])), float)
    c1, c2 = -3.0 * y[:, 0] + 4.0 * y[:, 1] - y[:, 2], 2.0 * (y[:, 0] - 2.0 * y[:, 1] + y[:, 2])
    return np.stack([left, width, y[:, 0], c1, c2], axis=1)


def _certified(
    tail_of: Callable[[Any], Any], row: Array, logarithmic: Flags, unseen: float
) -> Flags:
    """Whether the values of each cell have the tail probabilities that they should, to `unseen` at least."""
    left, width, c0, c1, c2 = (column[:, None] for column in row.T)
    within = (np.arange(10) + 0.5) / 10.0
    v, first, last = (_v(left + width * t, logarithmic[:, None]) for t in (within, 0.0, 1.0))
    # the limit 0.01 of its width makes a cell fail that contains a jump, however thin it is
    slack = np.minimum(1e-6 * np.minimum(v, 1.0 - v), 0.01 * np.abs(last - first))
    x = c0 + within * (c1 + within * c2)
    slack = np.maximum(slack, unseen)
    good = np.abs(tail_of(x) - v) <= slack
    off = np.flatnonzero(~good.all(axis=1))
    x, v, slack = x[off], v[off], slack[off]
    ulps = 4.0 * np.finfo(float).eps * np.abs(x)
    beside = np.stack([tail_of(x - ulps), tail_of(x + ulps)])
    good[off] |= (beside.min(axis=0) <= v + slack) & (beside.max(axis=0) >= v - slack)
    return np.asarray(good.all(axis=1))


def _v(place: Array, logarithmic: Flags) -> Array:
    """The v of places in cells, which are -log2 v in tails."""
    return np.where(logarithmic, np.exp2(-place), place)
