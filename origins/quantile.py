"""Quantiles as a certified table that compiled kernels sample.

Two layers. *Hot* cells, quadratics found from the bits of u, see hot_cells.py. *Fine* cells, cubics found by
bisection: probability is counted from both ends, v = min(u, 1 - u) in (0, 1/2], with a side, and cells divide each
octave of v, so tails are as sharp as the middle, down to `deepest`; they are split further wherever P_c makes it
necessary. A hot cell that fails its certificate is left to the fine ones.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from origins.errors import InputError
from origins.hot_cells import CHECKS, HotCells, hot_cells

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

TOLERANCE = 1e-6
_DEEP = 1e-9
_GRAINY = np.array([3e-15, 1e-14, 3e-14])
FINE_BITS = 3  # 8 fine cells per octave, before splitting
DEEPEST = 2.0**-54

_THINNEST = 2.0**-50  # relative to v: what cannot be split further holds that little weight
_INSET = 2.0**-49
_MOST_CELLS = 200_000
_HALVINGS = 4
_MOST_LEFT = 1e-11
_SMALLEST = 1e-300
_NODES = np.array([0.0, 0.25, 0.75, 1.0])
_TO_CUBIC = np.linalg.inv(np.vander(_NODES, 4, increasing=True)[1:, 1:])


class Law(Protocol):
    """What is needed of a distribution; Thresholds and Start both have it."""

    @property
    def breakpoints(self) -> Array: ...
    def cdf(self, x: npt.ArrayLike) -> Array: ...
    def sf(self, x: npt.ArrayLike) -> Array: ...
    def ppf(self, q: npt.ArrayLike) -> Array: ...
    def isf(self, q: npt.ArrayLike) -> Array: ...


@dataclass(frozen=True)
class Side:
    """Fine cells of one side: [edges[k], edges[k+1]) in v, value = clip(cubic in the cell's own t in [0, 1]).

    edges : shape (n + 1,); cubics : shape (n, 6), columns c0 c1 c2 c3 least greatest, in units of the scale.
    """

    edges: Array
    cubics: Array

    def __call__(self, v: npt.ArrayLike) -> Array:
        """Values at v, shape as v; outside the edges the nearest end."""
        cell, t = self._find(np.asarray(v, dtype=float))
        c = np.moveaxis(self.cubics[cell], -1, 0)
        return np.minimum(np.maximum(c[0] + t * (c[1] + t * (c[2] + t * c[3])), c[4]), c[5])

    def corrected(self, v: Array, tail: Callable[[Array], Array]) -> Array:
        """Values at v after one step of Newton's, with the cells' own slope, towards tail(value) = v."""
        cell, t = self._find(v)
        c = np.moveaxis(self.cubics[cell], -1, 0)
        slope = (c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])) / (self.edges[cell + 1] - self.edges[cell])
        y = np.minimum(np.maximum(c[0] + t * (c[1] + t * (c[2] + t * c[3])), c[4]), c[5])
        return np.minimum(np.maximum(y + slope * (v - tail(y)), c[4]), c[5])

    def _find(self, v: Array) -> tuple[npt.NDArray[np.intp], Array]:
        cell = np.clip(np.searchsorted(self.edges, v, side="right") - 1, 0, len(self.cubics) - 1)
        return cell, (v - self.edges[cell]) / (self.edges[cell + 1] - self.edges[cell])

    def jumps(self) -> Array:
        """The v at which the quantile jumps."""
        before, after = self.cubics[:-1, :4].sum(axis=1), self.cubics[1:, 0]
        return self.edges[1:-1][np.abs(after - before) > 1e-9 * np.abs(before)]

    def steepness(self) -> Array:
        """How steep the quantile is around each inner edge; jumps are the steepest."""
        middle = self.cubics[:, :4] @ 0.5 ** np.arange(4)
        return np.abs(np.diff(middle)) / (self.edges[2:] - self.edges[:-2])


@dataclass(frozen=True)
class QuantileTable:
    """Quantiles of a law in units of `scale`, a power of two near its median's size.

    hot : hot cells of all u.
    lower, upper : the fine cells of the two sides, lower counting v = u, upper v = 1 - u.
    left_over : probability of the slivers at jumps that cannot be split further; their value is a quantile
        inside them.
    """

    scale: float
    hot: HotCells
    lower: Side
    upper: Side
    left_over: float

    def value(self, v: npt.ArrayLike, from_above: npt.ArrayLike) -> Array:
        """Quantile (a length) at u = v, or at u = 1 - v where `from_above`; v in (0, 1/2]."""
        return self.scale * np.where(from_above, self.upper(v), self.lower(v))


def quantile_table(law: Law, deepest: float = DEEPEST, name: str = "thresholds") -> QuantileTable:
    """Tabulate the quantiles of `law`, certified: |cdf(Q(u)) - u| <= 1e-6 min(u, 1 - u) at ten points of every cell.

    A value that differs from the exact one by 4 units in its last place also passes: there floating point is
    the limit. So does, below v = 1e-9, one within 4e-16 where the law knows that tail to no better than the
    round-off of 1, as some of scipy.stats do. Cells end at jumps, gaps and atoms, and no value lies inside a
    gap. The upper side reaches down to v = min(deepest, 2^-54).

    Raises InputError, with `name`, where cdf, sf, ppf and isf do not agree well enough to be certified, and where more
    weight than 2^-54 lies so near to 0 that no number does.
    """
    middle = float(law.ppf(0.5))
    spread = float(law.isf(0.25)) - float(law.ppf(0.25))
    scale = 2.0 ** np.floor(np.log2(max(abs(middle), spread)))
    lost = float(np.diff(law.cdf(_SMALLEST * scale * np.array([-1.0, 1.0])))[0])
    if lost > DEEPEST:
        raise InputError(
            f"{name}: a weight of {lost:.2g} lies below {_SMALLEST:g} of a typical value, where numbers end, so that "
            "contacts cannot draw from there; take a law with an onset power above -0.94"
        )
    below, above = _Sided(law, False, scale, name), _Sided(law, True, scale, name)
    left_over = below.tabulate(DEEPEST) + above.tabulate(min(deepest, DEEPEST))
    if left_over > _MOST_LEFT:
        raise _uncertified(name, f"a weight of {left_over:.2g} is left over at its jumps")
    below.meet(above)
    above.meet(below)
    lower, upper = below.cells, above.cells
    edges = np.concatenate([lower.edges[1:-1], 1.0 - upper.edges[1:-1]])
    hot = hot_cells(below, above, edges, np.concatenate([lower.steepness(), upper.steepness()]))
    return QuantileTable(scale, hot, lower, upper, left_over)


def _uncertified(name: str, why: str) -> InputError:
    return InputError(
        f"{name}: the quantiles cannot be tabulated to 1e-6 ({why}); make the distribution's cdf, sf, ppf and isf agree"
    )


class _Sided:
    """One side of a law: its tail probability, the inverse of that, and its fine cells."""

    cells: Side
    jumps: Array
    _other: "_Sided"

    def __init__(self, law: Law, above: bool, scale: float, name: str) -> None:
        self.tail = law.sf if above else law.cdf
        self.inverse = law.isf if above else law.ppf
        # a foreign law may know a tail as 1 less the other only, to the round-off of 1
        seen = self.tail(self.inverse(_GRAINY))
        self.grain = 4e-16 if (np.abs(seen - _GRAINY) > TOLERANCE * _GRAINY).any() else 0.0
        self.above, self.scale, self.name = above, scale, name
        # where the quantile is not smooth: at each breakpoint and just before it, for the atoms
        points = np.asarray(law.breakpoints, dtype=float)
        points = np.concatenate([points, np.nextafter(points, -np.inf)])
        self.cuts = np.unique(self.tail(points)) if points.size else points
        self.cuts = self.cuts[(self.cuts > 0.0) & (self.cuts < 0.5)]

    def at(self, v: Array) -> Array:
        """Quantiles in units of the scale."""
        y = np.asarray(self.inverse(v), dtype=float) / self.scale
        if not np.isfinite(y).all():
            raise _uncertified(self.name, f"its quantile at probability {v[~np.isfinite(y)].flat[0]:.3g} is not finite")
        return y

    def certified(self, y: Array, v: Array, width: Array) -> Flags:
        """Whether every row of values y at v, shape (n, 10), has the tail probability it should."""
        # a cell that straddles a gap never passes, however thin: its error is a part of its own width
        slack = np.minimum(TOLERANCE * np.minimum(v, 1.0 - v), 0.01 * width[:, None]) + self.grain * (v < _DEEP)
        x = y * self.scale
        good = np.abs(self.tail(x) - v) <= slack
        if not good.all():
            rows = np.flatnonzero(~good.all(axis=1))
            x, v, slack = x[rows], v[rows], slack[rows]
            ulps = 4.0 * np.finfo(float).eps * np.abs(x)
            low, high = (x + ulps, x - ulps) if self.above else (x - ulps, x + ulps)
            good[rows] |= (self.tail(low) <= v + slack) & (self.tail(high) >= v - slack)
        return np.asarray(good.all(axis=1))

    def meet(self, other: "_Sided") -> None:
        """Know the jumps of the other side too, for cells that reach beyond the middle."""
        self._other, self.jumps = other, np.union1d(self.cells.jumps(), 1.0 - other.cells.jumps())

    def known(self, p: Array) -> Array:
        """Quantiles in units of the scale, p beyond 1/2 too, from the fine cells: closer than these are."""
        y, beyond = np.empty(p.shape), p > 0.5
        for side, q, here in ((self, p, ~beyond), (self._other, 1.0 - p, beyond)):
            if here.any():
                y[here] = side.cells.corrected(q[here], side.tail_of)
        return y

    def tail_of(self, y: Array) -> Array:
        """Tail probability of values in units of the scale."""
        return self.tail(y * self.scale)

    def jumps_inside(self, low: Array, high: Array) -> Flags:
        """Whether the quantile jumps between low and high, past the rounding of the probabilities."""
        place = np.searchsorted(self.jumps, low * (1.0 + 2.0 * _INSET))
        return np.append(self.jumps, np.inf)[place] < high * (1.0 - 2.0 * _INSET)

    def tabulate(self, deepest: float) -> float:
        """Make the fine cells; the weight of those that could not be certified because nothing is left to split."""
        octaves = 2.0 ** np.arange(np.floor(np.log2(deepest)), -1.0)
        grid = (octaves[:, None] * (1.0 + np.arange(1 << FINE_BITS) / (1 << FINE_BITS))).ravel()
        edges = np.unique(np.concatenate([grid, self.cuts[self.cuts > grid[0]], [0.5]]))
        a, b = edges[:-1], edges[1:]
        done_a: list[Array] = []
        done: list[Array] = []
        left_over, total, rounds = 0.0, 0, 0
        while a.size:
            total += a.size
            if total > _MOST_CELLS:
                raise _uncertified(self.name, "it would take more than 200,000 cells")
            width = b - a
            inset = np.minimum(_INSET * b, width / 16.0)
            y = self.at(a[:, None] + inset[:, None] + (width - 2.0 * inset)[:, None] * _NODES)
            cubic = np.empty((a.size, 6))
            cubic[:, 0] = y[:, 0]
            cubic[:, 1:4] = (y[:, 1:] - y[:, :1]) @ _TO_CUBIC.T
            cubic[:, 4], cubic[:, 5] = y[:, [0, 3]].min(axis=1), y[:, [0, 3]].max(axis=1)
            c = cubic[:, :, None]
            values = c[:, 0] + CHECKS * (c[:, 1] + CHECKS * (c[:, 2] + CHECKS * c[:, 3]))
            good = self.certified(np.clip(values, c[:, 4], c[:, 5]), a[:, None] + width[:, None] * CHECKS, width)
            thin = ~good & (width <= _THINNEST * b)
            cubic[thin, 1:4] = 0.0
            left_over += float(width[thin].sum())
            good |= thin
            done_a.append(a[good])
            done.append(cubic[good])
            # what halving does not mend is a jump, to be closed in on
            parts, rounds = 2 if rounds < _HALVINGS else 8, rounds + 1
            corners = a[~good, None] + (b - a)[~good, None] * (np.arange(parts + 1) / parts)
            corners[:, -1] = b[~good]
            a, b = corners[:, :-1].ravel(), corners[:, 1:].ravel()
        starts = np.concatenate(done_a)
        order = np.argsort(starts)
        self.cells = Side(np.append(starts[order], 0.5), np.concatenate(done)[order])
        return left_over
