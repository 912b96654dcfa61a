"""P_c of one rigid island over all angles, from its barrier b(angle) itself (paper, Sec. VI C).

On two waves b = 2 min(|c_1 S_1|, |c_2 S_2|). The circle is cut where db/dangle = 0, as an inverse square root of which
P_c diverges, and where the two are equal, where it jumps: on each piece b rises or falls, and one root gives the share
of angles below x. Between these values it is a Chebyshev series in s, x = lower + (upper - lower) sin²(pi s/2).
"""

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
# of the greatest barrier: where a panel is narrower, what is left moves no contact by more. Positions in files are
# rounded, so that values that a symmetry makes equal differ by some 1e-9, and no series resolves the law between them
_NARROW = 1e-8
_NODES = 24  # Chebyshev nodes of a series, including both ends


def _cuts(waves: Function, count: int) -> Array:
    """Angles of half a turn, in order, between which b is smooth and monotonic; `waves` gives |c_1 S_1| and |c_2 S_2|
    of angles, shape (2, ...), in any unit; `count` angles resolve them."""
    from scipy.optimize.elementwise import find_minimum, find_root

    def wave(angle: Array, which: Array, sign: Array) -> Array:
        return sign * np.choose(which.astype(int), waves(angle))

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
    between = tested[k], tested[k + 1]
    crossings = find_root(difference, between, tolerances=tight).x if k.size else np.empty(0)
    there = waves(extrema)
    extrema = extrema[there[which, np.arange(which.size)] <= there.min(0) + near]
    return np.sort(np.append(crossings, extrema))


def _along(t: Array) -> Array:
    """Share of a panel's width at t = 2s - 1, from -1 to 1."""
    return np.sin(0.25 * np.pi * (1.0 + t)) ** 2


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
        heights = barrier(cuts)
        order, least = np.argsort(heights), _SAME * heights.max()
        apart = np.diff(heights[order], prepend=-np.inf) > least  # else equal but for rounding
        edges = heights[order][apart]
        edges[0] *= edges[0] >= least
        heights[order] = edges[np.cumsum(apart) - 1]
        ends = np.array([cuts, np.append(cuts[1:], cuts[0] + np.pi)])
        sides = np.array([heights, np.roll(heights, -1)])
        bottom, top = np.where(sides[0] < sides[1], ends, ends[::-1])
        low, high = np.sort(sides, axis=0)

        def below(x: Array) -> Array:
            """Share of angles with a barrier of at most x."""
            k, i = np.nonzero((low[:, None] < x) & (x < high[:, None]))
            between = bottom[k], top[k]
            angle = find_root(lambda angle, x: barrier(angle) - x, between, args=(x[i],)).x
            # beside an end that rounding hides
            nearer = np.where(x[i] - low[k] < high[k] - x[i], *between)
            angle = np.where(np.isfinite(angle), angle, nearer)
            total = np.bincount(i, np.abs(angle - bottom[k]), x.size)
            return (total + np.abs(top - bottom) @ (high[:, None] <= x)) / np.pi

        self._fit_panels(edges, below)
        # a peak is where dC/dt is not 0 at the end of a panel, as x - lower ~ (1 + t)²
        steep = np.pad(np.abs(chebyshev.chebval([-1.0, 1.0], self._slopes)), ((1, 1), (0, 0)))
        at = np.searchsorted(self._lower, edges)
        around = 0.01 * self._moment(1.0) * np.array([[-1.0], [0.0], [1.0]])
        declared = np.abs(np.diff(self._cdf(edges + around), 2, axis=0)[0]) > _WEIGHT
        self._peaks = edges[declared & (steep[at + 1, 0] + steep[at, 1] > _WEIGHT)]
        declared[[0, -1]] = True
        self.breakpoints, self._support = edges[declared], (float(edges[0]), float(edges[-1]))
        self.onset_power = -0.5 if edges[0] in self._peaks else 0.0

    def _fit_panels(self, edges: Array, below: Function) -> None:
        """Keep panels between edges: both ends, the law C at the lower one, and the Chebyshev series in t of what is
        above it, shape (24, panels), with its derivative. Panels that a series does not resolve are halved."""
        lower, upper = edges[:-1], edges[1:]
        done, nodes = [], chebyshev.chebpts2(_NODES)
        for split in range(25):
            x = lower[:, None] + (upper - lower)[:, None] * _along(nodes)
            x[:, -1] = upper
            law = below(x.ravel()).reshape(x.shape).T
            rises = chebyshev.chebfit(nodes, law - law[0], _NODES - 1)
            least = 1e-9 * np.maximum(law[-1] - law[0], _WEIGHT)
            good = (np.abs(rises[-3:]).max(0) < least) | (split == 24)
            good |= upper - lower < _NARROW * edges[-1]
            done.append(np.vstack([lower, upper, law[0], rises])[:, good])
            middle = 0.5 * (lower + upper)[~good]
            lower, upper = np.append(lower[~good], middle), np.append(middle, upper[~good])
            if not lower.size:
                break
        table = np.concatenate(done, axis=1)
        table = table[:, np.argsort(table[0])]
        self._lower, self._upper, self._before = table[:3]
        self._rises, self._slopes = table[3:], chebyshev.chebder(table[3:])

    def _place(self, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        """Panel and place t of each x, to the last bit at both ends."""
        panel = np.clip(np.searchsorted(self._lower, x, side="right") - 1, 0, self._lower.size - 1)
        from_lower = np.sqrt(np.maximum(x - self._lower[panel], 0.0))
        to_upper = np.sqrt(np.maximum(self._upper[panel] - x, 0.0))
        return panel, 4.0 / np.pi * np.arctan2(from_lower, to_upper) - 1.0

    def _cdf(self, x: Array) -> Array:
        panel, t = self._place(x)
        rise = chebyshev.chebval(t, self._rises[:, panel], tensor=False)
        return np.clip(self._before[panel] + rise, 0.0, 1.0)

    def _sf(self, x: Array) -> Array:
        return 1.0 - self._cdf(x)

    def _pdf(self, x: Array) -> Array:
        panel, t = self._place(x)
        # at an edge without a peak both dC/dt and dx/dt vanish: evaluate beside the edge
        t = np.clip(t, 2e-6 - 1.0, 1.0 - 2e-6)
        slope = chebyshev.chebval(t, self._slopes[:, panel], tensor=False)
        widths = (self._upper - self._lower)[panel]
        per_length = widths * 0.25 * np.pi * np.cos(0.5 * np.pi * t)
        on_peak = np.isin(np.asarray(x), self._peaks)
        return np.where(on_peak, np.inf, np.maximum(slope / per_length, 0.0))

    def _moment(self, n: float, centre: float = 0.0) -> float:
        """By Gauss's sums over t on each panel."""
        t, weights = legendre.leggauss(_NODES)
        x = self._lower[:, None] + (self._upper - self._lower)[:, None] * _along(t)
        return float((weights * chebyshev.chebval(t, self._slopes) * (x - centre) ** n).sum())


def angle_thresholds(island: Island, scale: float) -> Thresholds:
    """The law of scale * b(angle) of one rigid island on two waves, all angles equally likely."""

    def waves(angle: Array) -> Array:
        amplitudes = island.substrate.coefficients * island.factors(angle)
        return scale * np.moveaxis(np.abs(amplitudes), -1, 0)

    lower = waves(np.array([0.3, 0.77, 1.31, 1.9, 2.4, 2.95, 3.6])).min(0)
    if np.ptp(lower) <= 1e-6 * lower.max():  # one atom
        return identical(2.0 * float(lower[0]))
    # zeros of a wave may lie close together: 64 angles evaluated per radian of the outermost atoms' phase
    return AngleThresholds(waves, int(64.0 * np.pi * island.phase_slope) + 64)
