"""P_c of one rigid island over all angles, from its barrier b(angle) itself (paper, Sec. VI C).

On two waves b = 2 min(|c_1 S_1|, |c_2 S_2|). The circle is cut where db/dangle = 0 and where the two are equal: on each
piece b rises or falls, so that the share of angles below x follows from one root for each piece. P_c diverges as an
inverse square root where db/dangle = 0, and jumps where the two are equal. Between these values the share is smooth
in s, x = lower + (upper - lower) sin²(pi s/2): a Chebyshev series.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, legendre

from origins.domains.barriers import Island
from origins.thresholds.families import identical
from origins.thresholds.law import Array, Thresholds

Function = Callable[[Array], Array]

_SAME = 1e-10  # of the greatest barrier: values closer than this count as equal
_WEIGHT = 1e-3  # least share of thresholds beside a peak or jump that is declared
_NODES = 24  # Chebyshev nodes of a series, including both ends
_u = 0.5 - 0.5 * np.cos(np.pi * np.arange(_NODES) / (_NODES - 1))  # on (0, 1)
_FIT = np.linalg.inv(chebyshev.chebvander(2.0 * _u - 1.0, _NODES - 1)).T


def _cuts(waves: Function, count: int) -> Array:
    """Angles of half a turn, in order, between which b is smooth and monotonic; `waves` gives |c_1 S_1| and |c_2 S_2|
    of angles, shape (2, ...), in any unit; `count` angles resolve them."""
    from scipy.optimize.elementwise import find_minimum, find_root

    def wave(angle: Array, which: Array, sign: Array) -> Array:
        return sign * np.take_along_axis(waves(angle), which.astype(int)[None], 0)[0]

    def difference(angle: Array) -> Array:
        return -np.diff(waves(angle), axis=0)[0]

    # symmetric islands have extrema at 0, which must not be an end
    begin, step = 0.1234567, np.pi / count
    angle = begin + step * np.arange(count + 2.0)
    values = waves(angle)
    near = _SAME * values.max()
    falls = np.diff(values) < 0.0
    which, k = np.nonzero(falls[:, 1:] != falls[:, :-1])
    middle, sign = angle[k + 1], np.where(falls[which, k], 1.0, -1.0)
    tight = {"xatol": 1e-15, "xrtol": 4e-16, "fatol": 0.0, "frtol": 0.0}
    around = middle - step, middle, middle + step
    extrema = find_minimum(wave, around, args=(which, sign), tolerances=tight).x
    which, extrema = which[np.isfinite(extrema)], extrema[np.isfinite(extrema)]
    extrema = begin + (extrema - begin) % np.pi
    # near an angle where one wave vanishes it is the smaller one on a short interval: evaluate there, too
    tested = np.unique(np.concatenate([angle[:-1], extrema]))
    # the two waves of square islands on squares are equal at all angles
    second_larger = (difference(tested) < 0.0) & bool(np.abs(np.subtract(*values)).max() > near)
    k = np.flatnonzero(second_larger[1:] != second_larger[:-1])
    crossings = (
        find_root(difference, (tested[k], tested[k + 1]), tolerances=tight).x if k.size else k
    )
    there = waves(extrema)
    extrema = extrema[there[which, np.arange(which.size)] <= there.min(0) + near]
    # where the two waves are equal b has a kink, not a zero derivative
    extrema = extrema[np.abs(extrema[:, None] - crossings).min(-1, initial=np.inf) > 1e-9]
    return np.sort(np.append(crossings, extrema))


def _series(edges: Array, below: Function) -> Array:
    """Chebyshev series in s of below(x) between edges; panels that a series does not resolve are halved.

    Result, shape (3 + 24, panels), sorted: lower and upper end, the value at the lower end, and the coefficients of
    what is above it.
    """
    lower, upper, done = edges[:-1], edges[1:], []
    for split in range(25):
        x = lower[:, None] + (upper - lower)[:, None] * np.sin(0.5 * np.pi * _u) ** 2
        x[:, -1] = upper
        share = below(x.ravel()).reshape(x.shape)
        fits = (share - share[:, :1]) @ _FIT
        rise = np.maximum(share[:, -1] - share[:, 0], _WEIGHT)
        good = (np.abs(fits[:, -3:]).max(-1) < 1e-9 * rise) | (split == 24)
        done.append(np.vstack([lower, upper, share[:, 0], fits.T])[:, good])
        middle = 0.5 * (lower + upper)[~good]
        lower, upper = np.append(lower[~good], middle), np.append(middle, upper[~good])
        if not lower.size:
            break
    table = np.concatenate(done, axis=1)
    return table[:, np.argsort(table[0])]


class AngleThresholds(Thresholds):
    """Law of b(angle) = 2 min(waves), all angles of the full circle equally likely.

    `breakpoints` are the ends of the support and the peaks and jumps that hold more than 1e-3 of the
    thresholds within 1e-2 mean thresholds; smaller ones exist, but are not declared.
    """

    def __init__(self, waves: Function, count: int) -> None:
        """`waves` and `count` as _cuts takes them; |S(-G)| = |S(G)|, so that b repeats after half a turn."""
        from scipy.optimize.elementwise import find_root

        def barrier(angle: Array) -> Array:
            return 2.0 * waves(angle).min(0)

        cuts = _cuts(waves, count)
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
            angle = find_root(lambda angle, x: barrier(angle) - x, ends, args=(x[i],)).x
            # beside an end that rounding hides
            nearer = np.where(x[i] - low[k] < high[k] - x[i], *ends)
            angle = np.where(np.isfinite(angle), angle, nearer)
            total = np.bincount(i, np.abs(angle - ends[0]), x.size)
            return (total + np.abs(top - bottom) @ (high[:, None] <= x)) / np.pi

        table = _series(edges, below)
        self._edges, self._widths = np.append(table[0], edges[-1]), table[1] - table[0]
        self._before, self._fits = table[2], table[3:]
        # a peak is where dC/ds is not 0 at the end of a panel, as x - low ~ s²
        slopes = np.abs(chebyshev.chebval([-1.0, 1.0], chebyshev.chebder(self._fits)))
        slopes, at = np.pad(slopes, ((1, 1), (0, 0))), np.searchsorted(self._edges, edges)
        around = 0.01 * self._moment(1.0) * np.array([[-1.0], [0.0], [1.0]])
        beside = self._cdf(edges + around)
        declared = np.abs(np.diff(beside, 2, axis=0)[0]) > _WEIGHT
        self._peaks = edges[declared & (slopes[at + 1, 0] + slopes[at, 1] > _WEIGHT)]
        declared[[0, -1]] = True
        self._declared = edges[declared]
        self.onset_power = -0.5 if self._declared[0] in self._peaks else 0.0

    def support(self) -> tuple[float, float]:
        return float(self._declared[0]), float(self._declared[-1])

    @property
    def breakpoints(self) -> Array:
        return self._declared

    def _panel(self, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        """Panel and place s of each x, to the last bit at both ends."""
        panel = np.clip(np.searchsorted(self._edges, x, side="right") - 1, 0, self._widths.size - 1)
        from_lower = np.maximum(x - self._edges[panel], 0.0)
        to_upper = np.maximum(self._edges[panel + 1] - x, 0.0)
        return panel, 2.0 / np.pi * np.arctan2(np.sqrt(from_lower), np.sqrt(to_upper))

    def _cdf(self, x: Array) -> Array:
        panel, s = self._panel(x)
        rise = chebyshev.chebval(2.0 * s - 1.0, self._fits[:, panel], tensor=False)
        return np.clip(self._before[panel] + rise, 0.0, 1.0)

    def _sf(self, x: Array) -> Array:
        return 1.0 - self._cdf(x)

    def _pdf(self, x: Array) -> Array:
        panel, s = self._panel(x)
        # at an edge without a peak both dC/ds and dx/ds vanish: evaluate beside the edge
        s = np.clip(s, 1e-6, 1.0 - 1e-6)
        slopes = chebyshev.chebder(self._fits)[:, panel]
        slope = 2.0 * chebyshev.chebval(2.0 * s - 1.0, slopes, tensor=False)
        per_length = self._widths[panel] * 0.5 * np.pi * np.sin(np.pi * s)
        on_peak = np.isin(np.asarray(x), self._peaks)
        return np.where(on_peak, np.inf, np.maximum(slope / per_length, 0.0))

    def _moment(self, n: float, centre: float = 0.0) -> float:
        """By Gauss's sums over s on each panel."""
        t, weights = legendre.leggauss(_NODES)
        x = self._edges[:-1, None] + self._widths[:, None] * np.sin(0.25 * np.pi * (1.0 + t)) ** 2
        shares = weights * chebyshev.chebval(t, chebyshev.chebder(self._fits))
        return float((shares * (x - centre) ** n).sum())


def angle_thresholds(island: Island, scale: float) -> Thresholds:
    """The law of scale * b(angle) of one rigid island on two waves, all angles equally likely."""

    def waves(angle: Array) -> Array:
        return scale * island.amplitudes(angle.ravel()).T.reshape(2, *angle.shape)

    lower = waves(np.array([0.3, 0.77, 1.31, 1.9, 2.4, 2.95, 3.6])).min(0)
    if np.ptp(lower) <= 1e-6 * lower.max():  # one atom
        return identical(2.0 * float(lower[0]))
    # zeros of a wave may lie close together: 64 angles evaluated per radian of the outermost atoms' phase
    return AngleThresholds(waves, int(64.0 * np.pi * island.phase_slope) + 64)
