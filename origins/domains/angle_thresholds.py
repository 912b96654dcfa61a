"""P_c of one rigid island over all angles, from its barrier b(angle) itself (paper, Sec. VI C).

On two waves b = 2 min(|c_1 S_1|, |c_2 S_2|). The circle is cut where db/dangle = 0 and where the two are equal: on each
piece b rises or falls, so that the share of angles below x follows from one root for each piece. P_c diverges as an
inverse square root where db/dangle = 0, and jumps where the two are equal. Between these values the share is smooth
in s, x = lower + (upper - lower) sin²(pi s/2): a Chebyshev series.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, legendre

from origins.thresholds.families import identical
from origins.thresholds.law import Array, Thresholds

Sizes = Callable[[Array], Array]

_PER_RADIAN = 64  # angles evaluated per radian of the outermost atoms' phase: zeros of a wave may lie close together
_MOST = 96_000  # angles at most: P_c of larger islands comes from samples
_START = 0.1234567  # radians; symmetric islands have extrema at 0, which must not be an end
_NODES = 24  # Chebyshev nodes of a series, including both ends
_SMOOTH = (
    1e-9  # largest of a series' last three coefficients, over the panel's rise (or 1e-3 of all)
)
_SPLITS = 24  # most halvings of a panel that a series does not resolve
_SAME = 1e-10  # of the greatest barrier: values closer than this count as equal
_WEIGHT = 1e-3  # least share of thresholds within _BESIDE of a peak or jump that is declared
_BESIDE = 0.01  # mean thresholds

_u = 0.5 - 0.5 * np.cos(np.pi * np.arange(_NODES) / (_NODES - 1))  # on (0, 1)
_FIT = np.linalg.inv(chebyshev.chebvander(2.0 * _u - 1.0, _NODES - 1)).T


def _fitted(edges: Array, below: Callable[[Array], Array]) -> Array:
    """Chebyshev series in s of below(x) between edges; panels that a series does not resolve are halved.

    Result, shape (3 + 24, panels), sorted: lower and upper end, the value at the lower end, and the coefficients of
    what is above it.
    """
    ends, done = np.array([edges[:-1], edges[1:]]), []
    for split in range(_SPLITS + 1):
        left, right = ends[..., None]
        x = left + (right - left) * np.sin(0.5 * np.pi * _u) ** 2
        x[:, -1:] = right
        found = below(x.ravel()).reshape(x.shape)
        fits = (found - found[:, :1]) @ _FIT
        rise = np.maximum(found[:, -1] - found[:, 0], _WEIGHT)
        good = (np.abs(fits[:, -3:]).max(-1) < _SMOOTH * rise) | (split == _SPLITS)
        done.append(np.vstack([ends, found[:, 0], fits.T])[:, good])
        left, right = ends[:, ~good]
        if not left.size:
            break
        middle = 0.5 * (left + right)
        ends = np.hstack([[left, middle], [middle, right]])
    table = np.concatenate(done, axis=1)
    return table[:, np.argsort(table[0])]


def _place(x: Array, low: Array, high: Array) -> Array:
    """s in [0, 1] for x = low + (high - low) sin²(pi s/2), to the last bit at both ends."""
    below, above = np.maximum(x - low, 0.0), np.maximum(high - x, 0.0)
    return 2.0 / np.pi * np.arctan2(np.sqrt(below), np.sqrt(above))


def _cuts(each: Callable[[Array], Array], fastest: float) -> Array:
    """Angles of half a turn, in order, between which b is smooth and monotonic."""
    from scipy.optimize.elementwise import find_minimum, find_root

    def turn(angle: Array, which: Array, sign: Array) -> Array:
        return sign * np.take_along_axis(each(angle), which.astype(int)[None], 0)[0]

    count = int(np.pi * fastest * _PER_RADIAN) + 64
    step = np.pi / count
    angle: Array = _START + step * np.arange(count + 2.0)
    values = each(angle)
    near = _SAME * values.max()
    alike = np.abs(values[2]).max() <= near  # as for square islands on squares
    falls = np.diff(values[: 2 if alike else 3]) < 0.0
    which, k = np.nonzero(falls[:, 1:] != falls[:, :-1])
    middle, sign = angle[k + 1], np.where(falls[which, k], 1.0, -1.0)
    tight = {"xatol": 1e-15, "xrtol": 4e-16, "fatol": 0.0, "frtol": 0.0}
    around = middle - step, middle, middle + step
    still = find_minimum(turn, around, args=(which, sign), tolerances=tight).x
    which, still = which[np.isfinite(still)], still[np.isfinite(still)]
    still = _START + (still - _START) % np.pi
    # near an angle where one wave vanishes it is the smaller one on a short interval: evaluate there, too
    looked = np.unique(np.concatenate([angle[:-1], still]))
    ahead = (each(looked)[2] < 0.0) & (not alike)
    k = np.flatnonzero(ahead[1:] != ahead[:-1])
    bends = find_root(lambda a: each(a)[2], (looked[k], looked[k + 1]), tolerances=tight).x
    there, own = each(still), np.arange(which.size)
    still = still[(which < 2) & (there[which, own] <= there[:2].min(0) + near)]
    # where the two waves are equal b has a kink, not a zero derivative
    still = still[np.abs(still[:, None] - bends).min(-1, initial=np.inf) > 1e-9]
    return np.sort(np.append(bends, still))


def _series(rows: npt.NDArray[Any], panel: npt.NDArray[np.intp], s: Array) -> Array:
    """Chebyshev series of panels, coefficients (n, panels), at places s, by Clenshaw's rule row by row."""
    t = 2.0 * s - 1.0
    last = before = np.zeros(np.shape(t))
    for row in rows[:0:-1]:
        last, before = row.take(panel) + 2.0 * t * last - before, last
    return rows[0].take(panel) + t * last - before


class AngleThresholds(Thresholds):
    """Law of scale * b(angle), all angles of the full circle equally likely.

    `breakpoints` are the ends of the support and the peaks and jumps that hold more than 1e-3 of the
    thresholds within 1e-2 mean thresholds; smaller ones exist, but are not declared.
    """

    def __init__(self, sizes: Sizes, fastest: float, scale: float) -> None:
        """`sizes` and `fastest` as in angle_thresholds; |S(-G)| = |S(G)|, so that b repeats after half a turn."""
        from scipy.optimize.elementwise import find_root

        def each(angle: Array) -> Array:
            """|c_1 S_1|, |c_2 S_2| and the difference of the two, shape (3, ...)."""
            if not angle.size:
                return np.ones((3, 0))
            one, other = sizes(angle.ravel()).T.reshape(2, *angle.shape)
            return np.stack([one, other, one - other])

        def barrier(angle: Array) -> Array:
            return 2.0 * each(angle)[:2].min(0)

        cuts = _cuts(each, fastest)
        known = barrier(cuts)
        order, least = np.argsort(known), _SAME * known.max()
        apart = np.diff(known[order], prepend=-np.inf) > least  # else equal but for rounding
        edges = known[order][apart]
        edges[0] *= edges[0] >= least
        known[order] = edges[np.cumsum(apart) - 1]
        pieces = np.array([cuts, np.append(cuts[1:], cuts[0] + np.pi), known, np.roll(known, -1)])
        falls = pieces[2] > pieces[3]
        pieces[:, falls] = pieces[[1, 0, 3, 2]][:, falls]
        bottom, top, low, high = pieces[:, pieces[2] < pieces[3]]

        def below(x: Array) -> Array:
            """Share of angles with a barrier of at most x."""
            k, i = np.nonzero((low[:, None] < x) & (x < high[:, None]))
            ends = bottom[k], top[k]
            found = find_root(lambda angle, x: barrier(angle) - x, ends, args=(x[i],)).x
            # beside an end that rounding hides
            nearer = np.where(x[i] - low[k] < high[k] - x[i], *ends)
            found = np.where(np.isfinite(found), found, nearer)
            total = np.bincount(i, np.abs(found - ends[0]), x.size)
            return (total + np.abs(top - bottom) @ (high[:, None] <= x)) / np.pi

        table, self._scale = _fitted(edges, below), scale
        self._edges, self._widths = np.append(table[0], edges[-1]), table[1] - table[0]
        self._before, self._fits = table[2], table[3:]
        # dC/ds at both ends of each panel, 0 except at peaks: as x - low ~ s², these give the weight of a peak
        slopes, ends = 2.0 * chebyshev.chebder(self._fits), np.array([-1.0, 1.0])
        roots = 0.5 * np.pi * np.sqrt(self._widths)[:, None]
        peaks = np.pad(np.abs(chebyshev.chebval(ends, slopes)) / roots, ((1, 1), (0, 0)))
        at, distance = np.searchsorted(self._edges, edges), _BESIDE * self._moment(1.0)
        heavy = (peaks[at + 1, 0] + peaks[at, 1]) * np.sqrt(distance / scale) > _WEIGHT
        beside = self._cdf(scale * edges + distance * np.array([[-1.0], [0.0], [1.0]]))
        declared = heavy | (np.abs(np.diff(beside, 2, axis=0)[0]) > _WEIGHT)
        declared[[0, -1]] = True
        self._peaks, self._declared = scale * edges[heavy], scale * edges[declared]
        self.onset_power = -0.5 if heavy[0] else 0.0

    def support(self) -> tuple[float, float]:
        return float(self._declared[0]), float(self._declared[-1])

    @property
    def breakpoints(self) -> Array:
        return self._declared

    def _panel(self, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        """Panel and place s of each x."""
        b = np.asarray(x) / self._scale
        panel = np.clip(np.searchsorted(self._edges, b, side="right") - 1, 0, self._widths.size - 1)
        return panel, _place(b, self._edges[panel], self._edges[panel + 1])

    def _below(self, x: Array) -> Array:
        """Share of all angles with a threshold of at most x, but for rounding."""
        panel, s = self._panel(x)
        return self._before[panel] + _series(self._fits, panel, s)

    def _cdf(self, x: Array) -> Array:
        return np.clip(self._below(x), 0.0, 1.0)

    def _sf(self, x: Array) -> Array:
        return np.clip(1.0 - self._below(x), 0.0, 1.0)

    def _pdf(self, x: Array) -> Array:
        panel, s = self._panel(x)
        # at an edge without a peak both dC/ds and dx/ds vanish: evaluate beside the edge
        s = np.clip(s, 1e-6, 1.0 - 1e-6)
        slope = 2.0 * _series(chebyshev.chebder(self._fits), panel, s)
        per_length = self._scale * self._widths[panel] * 0.5 * np.pi * np.sin(np.pi * s)
        on_peak = np.isin(np.asarray(x), self._peaks)
        return np.where(on_peak, np.inf, np.maximum(slope / per_length, 0.0))

    def _central_moment(self, n: float, centre: float) -> float:
        """By Gauss's sums over s on each panel."""
        t, weights = legendre.leggauss(_NODES)
        x = self._edges[:-1, None] + self._widths[:, None] * np.sin(0.25 * np.pi * (1.0 + t)) ** 2
        shares = weights * chebyshev.chebval(t, chebyshev.chebder(self._fits))
        return float((shares * (self._scale * x - centre) ** n).sum())


def angle_thresholds(sizes: Sizes, fastest: float, scale: float) -> Thresholds | None:
    """The law of scale * b(angle) of one island.

    sizes : |c_1 S_1|, |c_2 S_2| of angles (m,), shape (m, 2), energies.
    fastest : the largest derivative of its phases with the angle: the greatest |G| times the reach.

    None where the island is so large that its barrier has too many peaks.
    """
    if np.pi * fastest * _PER_RADIAN > _MOST:
        return None
    some = sizes(np.array([0.3, 0.77, 1.31, 1.9, 2.4, 2.95, 3.6])).min(-1)
    if np.ptp(some) <= 1e-6 * some.max():  # one atom
        return identical(scale * 2.0 * float(some[0]))
    return AngleThresholds(sizes, fastest, scale)
