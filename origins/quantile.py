"""Quantiles as a certified table that compiled kernels sample.

Probability is counted from both ends: v = min(u, 1 - u) in (0, 1/2], with a side. Cells divide each octave of v,
so tails are as sharp as the middle. Two layers: *hot* cells, quadratics found from the bits of v, for
v >= 2^-12; *fine* cells, cubics found by bisection, down to `deepest`, split further wherever P_c makes it
necessary. A hot cell that fails its certificate is left to the fine ones.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from origins.errors import InputError

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

TOLERANCE = 1e-6
_DEEP = 1e-9
_GRAINY = np.array([3e-15, 1e-14, 3e-14])
CHECKS = (np.arange(10) + 0.5) / 10.0

HOT_OCTAVES = 11  # 2^-12 <= v < 2^-1
FINE_BITS = 3  # 8 fine cells per octave, before splitting
HOT_MISSING = 2.0**60  # the hot value that sends a draw to the fine cells
DEEPEST = 2.0**-54

# more cells where P_c is rough, the fewest that leave little to the fine ones: a small table stays in the cache
_HOT_BITS = (5, 7, 9)
_HOT_MISSED = 0.005
_THINNEST = 2.0**-50  # relative to v: what cannot be split further holds that little weight
_INSET = 2.0**-49
_MOST_CELLS = 200_000
_MOST_LEFT = 1e-11
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
        v = np.asarray(v, dtype=float)
        cell = np.clip(np.searchsorted(self.edges, v, side="right") - 1, 0, len(self.cubics) - 1)
        t = (v - self.edges[cell]) / (self.edges[cell + 1] - self.edges[cell])
        c = np.moveaxis(self.cubics[cell], -1, 0)
        return np.minimum(np.maximum(c[0] + t * (c[1] + t * (c[2] + t * c[3])), c[4]), c[5])

    def jumps(self) -> Array:
        """The v at which the quantile jumps."""
        before, after = self.cubics[:-1, :4].sum(axis=1), self.cubics[1:, 0]
        return self.edges[1:-1][np.abs(after - before) > 1e-9 * np.abs(before)]


@dataclass(frozen=True)
class QuantileTable:
    """Quantiles of a law in units of `scale`, a power of two near its median's size.

    hot_bits : each octave 2^e <= v < 2^(e + 1) has M = 2^hot_bits hot cells.
    hot_c0, hot_c1, hot_c2 : shape (2 (11 M + 1),); cell k, counted from v = 2^-12, of side s stands at
        2 (k + 1) + s; 0 and 1 mean v < 2^-12. With t = v / 2^e - (1 + m / M), the distance inside cell m of
        the octave, value = c0 + t (c1 + t c2); c1 and c2 are exact in single precision.
    lower, upper : the fine cells of the two sides, lower counting v = u, upper v = 1 - u.
    left_over : probability of the slivers at jumps that cannot be split further; their value is a quantile
        inside them.
    """

    scale: float
    hot_bits: int
    hot_c0: Array
    hot_c1: Array
    hot_c2: Array
    lower: Side
    upper: Side
    left_over: float

    def value(self, v: npt.ArrayLike, from_above: npt.ArrayLike) -> Array:
        """Quantile (a length) at u = v, or at u = 1 - v where `from_above`; v in (0, 1/2]."""
        return self.scale * np.where(from_above, self.upper(v), self.lower(v))

    def hot(self, cell: npt.NDArray[np.integer], t: npt.ArrayLike) -> Array:
        """Value (a length) of hot cells at t; at least HOT_MISSING * scale where the fine cells must be asked."""
        return self.scale * (self.hot_c0[cell] + t * (self.hot_c1[cell] + t * self.hot_c2[cell]))


def quantile_table(law: Law, deepest: float = DEEPEST, name: str = "thresholds") -> QuantileTable:
    """Tabulate the quantiles of `law`, certified: |cdf(Q(u)) - u| <= 1e-6 min(u, 1 - u) at ten points of every cell.

    A value that differs from the exact one by 4 units in its last place also passes: there floating point is
    the limit. So does, below v = 1e-9, one within 4e-16 where the law knows that tail to no better than the
    round-off of 1, as some of scipy.stats do. Cells end at jumps, gaps and atoms, and no value lies inside a
    gap. The upper side reaches down to v = min(deepest, 2^-54).

    Raises InputError, with `name`, where cdf, sf, ppf and isf do not agree well enough to be certified.
    """
    middle = float(law.ppf(0.5))
    spread = float(law.isf(0.25)) - float(law.ppf(0.25))
    scale = 2.0 ** np.floor(np.log2(max(abs(middle), spread)))
    below, above = _Sided(law, False, scale, name), _Sided(law, True, scale, name)
    lower, left_below = below.fine(DEEPEST)
    upper, left_above = above.fine(min(deepest, DEEPEST))
    if left_below + left_above > _MOST_LEFT:
        raise _uncertified(name, f"a weight of {left_below + left_above:.2g} is left over at its jumps")
    for bits in _HOT_BITS:
        (c0, c1, c2), missed = _pair(below.hot(bits, lower.jumps()), above.hot(bits, upper.jumps()))
        if missed <= _HOT_MISSED:
            break
    return QuantileTable(scale, bits, c0, c1, c2, lower, upper, left_below + left_above)


def _pair(below: tuple[Array, Array, Array], above: tuple[Array, Array, Array]) -> tuple[list[Array], float]:
    """Hot cells of both sides taken in turn, and the weight of those that are missing."""
    weight = 2.0 * np.repeat(2.0 ** np.arange(-13.0, -2.0), (len(below[0]) - 1) // HOT_OCTAVES)
    weight /= weight.sum() * 2.0
    missed = sum(float(weight[side[0][1:] == HOT_MISSING].sum()) for side in (below, above))
    return [np.stack(pair, axis=-1).ravel() for pair in zip(below, above, strict=True)], missed


def _uncertified(name: str, why: str) -> InputError:
    return InputError(
        f"{name}: the quantiles cannot be tabulated to 1e-6 ({why}); make the distribution's cdf, sf, ppf and isf agree"
    )


class _Sided:
    """One side of a law: its tail probability and the inverse of that."""

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
        slack = np.minimum(TOLERANCE * v, 0.01 * width[:, None]) + self.grain * (v < _DEEP)
        x = y * self.scale
        good = np.abs(self.tail(x) - v) <= slack
        if not good.all():
            rows = np.flatnonzero(~good.all(axis=1))
            x, v, slack = x[rows], v[rows], slack[rows]
            ulps = 4.0 * np.finfo(float).eps * np.abs(x)
            low, high = (x + ulps, x - ulps) if self.above else (x - ulps, x + ulps)
            good[rows] |= (self.tail(low) <= v + slack) & (self.tail(high) >= v - slack)
        return np.asarray(good.all(axis=1))

    def fine(self, deepest: float) -> tuple[Side, float]:
        """The fine cells, and the weight of those that could not be certified because nothing is left to split."""
        octaves = 2.0 ** np.arange(np.floor(np.log2(deepest)), -1.0)
        grid = (octaves[:, None] * (1.0 + np.arange(1 << FINE_BITS) / (1 << FINE_BITS))).ravel()
        edges = np.unique(np.concatenate([grid, self.cuts[self.cuts > grid[0]], [0.5]]))
        a, b = edges[:-1], edges[1:]
        done_a: list[Array] = []
        done: list[Array] = []
        left_over, total = 0.0, 0
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
            a, b = a[~good], b[~good]
            half = 0.5 * (a + b)
            a, b = np.concatenate([a, half]), np.concatenate([half, b])
        starts = np.concatenate(done_a)
        order = np.argsort(starts)
        return Side(np.append(starts[order], 0.5), np.concatenate(done)[order]), left_over

    def hot(self, bits: int, jumps: Array) -> tuple[Array, Array, Array]:
        """Hot cells in the order of v, the one for v < 2^-12 first; each value exact at both ends of its cell."""
        cells = 1 << bits
        octave = np.repeat(2.0 ** np.arange(-1 - HOT_OCTAVES, -1), cells)
        a = octave * np.tile(1.0 + np.arange(cells) / cells, HOT_OCTAVES)
        width = octave / cells
        first, middle, last = self.at(np.stack([a * (1 + _INSET), a + 0.5 * width, (a + width) * (1 - _INSET)]))
        h = 1.0 / cells
        slope = (last - first) / h
        c1 = _single((4.0 * middle - 3.0 * first - last) / h)
        c2 = _single((slope - c1) / h)
        # rounding to single precision must not carry the cell beyond its end, where a gap may begin
        end = first + h * (c1 + h * c2)
        rising = last > first
        beyond = np.where(rising, end > last, end < last)
        c2 = np.where(beyond, _single(c2, np.where(rising, -np.inf, np.inf)), c2)
        end = first + h * (c1 + h * c2)
        within = np.where(rising, end <= last, end >= last)
        monotone = (c1 * slope >= 0.0) & ((c1 + 2.0 * h * c2) * slope >= 0.0)
        t = h * CHECKS
        values = first[:, None] + t * (c1[:, None] + t * c2[:, None])
        good = within & monotone & self.certified(values, a[:, None] + width[:, None] * CHECKS, width)
        # a jump so near the end of a cell that no check sees it, past the rounding of the probabilities
        place = np.searchsorted(jumps, a * (1.0 + 2.0 * _INSET))
        good &= np.append(jumps, np.inf)[place] >= (a + width) * (1.0 - 2.0 * _INSET)
        c0 = np.append(HOT_MISSING, np.where(good, first, HOT_MISSING))
        return c0, np.append(0.0, np.where(good, c1, 0.0)), np.append(0.0, np.where(good, c2, 0.0))


def _single(values: Array, beyond: Array | None = None) -> Array:
    """Values rounded to single precision; or, where `beyond` is given, the next one in its direction."""
    short = values.astype(np.float32)
    return (short if beyond is None else np.nextafter(short, beyond.astype(np.float32))).astype(float)
