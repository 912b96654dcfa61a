"""P_c of one rigid island over all angles, from its barrier b(angle) itself (paper, Sec. VI C).

On two waves b = 2 min(|c_1 S_1|, |c_2 S_2|). The circle is cut where db/dangle = 0 and where the two are
equal: on each piece b rises or falls, and each piece has an inverse. P_c diverges as an inverse square root
where db/dangle = 0, and jumps where the two are equal. Between these the share of angles below x is smooth
in s, x = lower + (upper - lower) sin²(pi s/2). All smooth functions are Chebyshev series.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

from origins.thresholds.families import identical
from origins.thresholds.law import Array, Thresholds

Sizes = Callable[[Array], Array]

_PER_RADIAN = 16  # angles evaluated per radian of the outermost atoms' phase
_MOST = 12_000  # angles at most: P_c of larger islands comes from samples
_START = 0.1234567  # radians; symmetric islands have extrema at 0, which must not be an end
_NODES = 24  # Chebyshev nodes of a series, including both ends
_SMOOTH = 1e-9  # largest of a series' last three coefficients, over the panel's share (or 1e-3)
_SPLITS = 10  # most halvings of a panel that a series does not resolve
_SAME = 1e-10  # of the greatest barrier: values closer than this count as equal
_LEVEL = 1e-6  # of the greatest barrier: with less variation (one atom) b counts as constant
_WEIGHT = 1e-3  # least share of thresholds within _BESIDE of a peak or jump that is declared
_BESIDE = 0.01  # mean thresholds
_TIGHT = {"xatol": 1e-15, "xrtol": 4e-16, "fatol": 0.0, "frtol": 0.0}

_u = 0.5 - 0.5 * np.cos(np.pi * np.arange(_NODES) / (_NODES - 1))  # on (0, 1)
_FIT = np.linalg.inv(chebyshev.chebvander(2.0 * _u - 1.0, _NODES - 1)).T


def _series(coefficients: Array, panel: npt.NDArray[np.intp], u: Array) -> Array:
    """Chebyshev series of panels, coefficients of shape (panels, n), at u of (0, 1), by Clenshaw's rule."""
    rows, t = np.ascontiguousarray(coefficients.T), 2.0 * u - 1.0
    last = before = np.zeros(np.shape(t))
    for row in rows[:0:-1]:
        last, before = row.take(panel) + 2.0 * t * last - before, last
    return rows[0].take(panel) + t * last - before


def _place(x: Array, low: Array, high: Array) -> Array:
    """s in [0, 1] for x = low + (high - low) sin²(pi s/2), to the last bit at both ends."""
    below, above = np.maximum(x - low, 0.0), np.maximum(high - x, 0.0)
    return 2.0 / np.pi * np.arctan2(np.sqrt(below), np.sqrt(above))


class _Pieces:
    """Pieces of the circle on which b is monotonic, stored from their lower to their upper end.

    Attributes
    ----------
    values : array
        Barriers where P_c is not smooth, sorted, the least and the greatest among them.
    bends : bool array
        Whether the two waves are equal there.
    """

    def __init__(self, sizes: Sizes, fastest: float, period: float) -> None:
        from scipy.optimize.elementwise import find_minimum, find_root

        def each(angle: Array) -> Array:
            """|c_1 S_1|, |c_2 S_2| and the difference of the two, shape (3, ...)."""
            if not angle.size:
                return np.ones((3, 0))
            one, other = sizes(angle.ravel()).T.reshape(2, *angle.shape)
            return np.stack([one, other, one - other])

        def barrier(angle: Array) -> Array:
            return 2.0 * each(angle)[:2].min(0)

        def turn(angle: Array, which: Array, sign: Array) -> Array:
            return sign * np.take_along_axis(each(angle), which.astype(int)[None], 0)[0]

        self._barrier, self._find_root = barrier, find_root
        count = int(period * fastest * _PER_RADIAN) + 64
        step = period / count
        angle: Array = _START + step * np.arange(count + 2.0)
        values = each(angle)
        near = _SAME * values.max()
        alike = np.abs(values[2]).max() <= near  # as for square islands on squares
        falls = np.diff(values[: 2 if alike else 3]) < 0.0
        which, k = np.nonzero(falls[:, 1:] != falls[:, :-1])
        middle, sign = angle[k + 1], np.where(falls[which, k], 1.0, -1.0)
        still = find_minimum(
            turn, (middle - step, middle, middle + step), args=(which, sign), tolerances=_TIGHT
        ).x
        which, still = which[np.isfinite(still)], still[np.isfinite(still)]
        still = _START + (still - _START) % period
        # near an angle where one wave vanishes it is the smaller one on a short interval: evaluate there, too
        looked = np.unique(np.concatenate([angle[:-1], still]))
        ahead = (each(looked)[2] < 0.0) & (not alike)
        k = np.flatnonzero(ahead[1:] != ahead[:-1])
        bends = find_root(lambda a: each(a)[2], (looked[k], looked[k + 1]), tolerances=_TIGHT).x
        there, own = each(still), np.arange(which.size)
        still = still[(which < 2) & (there[which, own] <= there[:2].min(0) + near)]
        # where the two waves are equal b has a kink, not a zero derivative
        still = still[np.abs(still[:, None] - bends).min(-1, initial=np.inf) > 1e-9]
        cuts = np.append(bends, still)
        order = np.argsort(cuts)
        cuts, bent = cuts[order], order < bends.size
        self.values, known = _together(barrier(cuts))
        self.bends = np.isin(self.values, known[bent])
        pieces = np.array([cuts, np.append(cuts[1:], cuts[0] + period), known, np.roll(known, -1)])
        falls = pieces[2] > pieces[3]
        pieces[:, falls] = pieces[[1, 0, 3, 2]][:, falls]
        self._invert(pieces[:, pieces[2] < pieces[3]])

    def _invert(self, ends: Array) -> None:
        """Fit the share of each piece that has barriers up to x; halve pieces that a series does not resolve.

        ends : array (4, pieces), angles of the lower and the upper end and the barriers there.
        """
        done = []
        for split in range(_SPLITS + 1):
            bottom, top, low, high = ends[..., None]
            goals = low + (high - low) * np.sin(0.5 * np.pi * _u[1:-1]) ** 2
            found = self._find_root(
                lambda a, goal: self._barrier(a) - goal,
                (bottom + 0.0 * goals, top + 0.0 * goals),
                args=(goals,),
            ).x
            share = np.ones((bottom.size, _NODES))
            share[:, :1], share[:, 1:-1] = 0.0, (found - bottom) / (top - bottom)
            fits = share @ _FIT
            good = (np.abs(fits[:, -3:]).max(-1) < _SMOOTH) | (split == _SPLITS)
            done.append(np.concatenate([ends[:, good], fits[good].T]))
            bottom, top, low, high = ends[:, ~good]
            if not bottom.size:
                break
            middle = 0.5 * (bottom + top)
            level = self._barrier(middle)
            ends = np.concatenate([[bottom, middle, low, level], [middle, top, level, high]], 1)
        pieces = np.concatenate(done, axis=1)
        self._ends, self._fits = pieces[:4], pieces[4:].T
        widths = np.abs(self._ends[1] - self._ends[0])
        self._shares = widths / widths.sum()

    def below(self, x: Array) -> Array:
        """Share of angles with a barrier of at most x, for sorted x; shape as x."""
        total = np.zeros(x.shape)
        for low, high, share, fit in zip(*self._ends[2:], self._shares, self._fits, strict=True):
            first, last = np.searchsorted(x, [low, high])
            place = _place(x[first:last], low, high)
            total[first:last] += share * chebyshev.chebval(2.0 * place - 1.0, fit)
            total[last:] += share
        return total

    def mean(self, function: Callable[[Array], Array]) -> float:
        """Mean of function(b) over all angles."""
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        # nodes in this variable, in which a power of b is smooth even where b vanishes
        place, weights = np.sin(0.25 * np.pi * (1.0 + nodes)) ** 2, 0.25 * np.pi * weights
        bottom, top = self._ends[:2, :, None]
        values = function(np.maximum(self._barrier(bottom + (top - bottom) * place), 0.0))
        return float(self._shares @ values @ (weights * np.cos(0.5 * np.pi * nodes)))


def _together(values: Array) -> tuple[Array, Array]:
    """Sorted distinct values, those equal but for rounding merged; and for each value the merged one."""
    order, greatest = np.argsort(values), values.max()
    starts = np.diff(values[order], prepend=-np.inf) > _SAME * greatest
    distinct = values[order][starts]
    if distinct[0] < _SAME * greatest:
        distinct[0] = 0.0
    known = np.empty(values.size)
    known[order] = distinct[np.cumsum(starts) - 1]
    return distinct, known


class AngleThresholds(Thresholds):
    """Law of scale * b(angle), all angles of the full circle equally likely.

    `breakpoints` are the ends of the support and the peaks and jumps that hold more than 1e-3 of the
    thresholds within 1e-2 mean thresholds; smaller ones exist, but are not declared.
    """

    knows_breakpoints = False

    def __init__(self, pieces: _Pieces, scale: float) -> None:
        self._pieces, self._scale, edges = pieces, scale, pieces.values
        self._mean = pieces.mean(lambda b: b)
        self._tabulate(edges)
        # dC/ds at both ends of each panel, 0 except at peaks, and d²C/ds²: as x - low ~ s², these give
        # the weight of a peak and the density beside it
        slopes, bows = (chebyshev.chebder(self._fits.T, n) * 2.0**n for n in (1, 2))
        ends, roots = np.array([-1.0, 1.0]), 0.5 * np.pi * np.sqrt(self._widths)[:, None]
        peaks = np.abs(chebyshev.chebval(ends, slopes)) / roots
        levels = np.abs(chebyshev.chebval(ends, bows)) / (2.0 * roots**2)
        distance = _BESIDE * self._mean
        at = np.searchsorted(self._edges, edges)
        above, below = np.append(peaks[:, 0], 0.0)[at], np.append(0.0, peaks[:, 1])[at]
        right, left = np.append(levels[:, 0], 0.0)[at], np.append(0.0, levels[:, 1])[at]
        heavy = (above + below) * np.sqrt(distance) > _WEIGHT
        declared = heavy | pieces.bends & (np.abs(right - left) * distance > _WEIGHT)
        declared[[0, -1]] = True
        self._peaks, self._declared = scale * edges[heavy], scale * edges[declared]
        self.onset_power = -0.5 if heavy[0] else 0.0

    def _tabulate(self, edges: Array) -> None:
        """Fit series to the share of angles up to b between the edges; halve panels that they do not resolve."""
        left, right, done = edges[:-1], edges[1:], []
        for split in range(_SPLITS + 1):
            x = left[:, None] + (right - left)[:, None] * np.sin(0.5 * np.pi * _u) ** 2
            x[:, -1] = right
            order = np.argsort(x, axis=None)
            shares = np.empty(x.size)
            shares[order] = self._pieces.below(x.ravel()[order])
            shares = shares.reshape(x.shape)
            fits = (shares - shares[:, :1]) @ _FIT
            whole = np.maximum(shares[:, -1] - shares[:, 0], _WEIGHT)
            good = (np.abs(fits[:, -3:]).max(-1) < _SMOOTH * whole) | (split == _SPLITS)
            done.append(np.column_stack([left, right, shares[:, 0], fits])[good])
            left, right = left[~good], right[~good]
            middle = 0.5 * (left + right)
            left, right = np.append(left, middle), np.append(middle, right)
            if not left.size:
                break
        table = np.concatenate(done)
        table = table[np.argsort(table[:, 0])]
        self._edges, self._widths = np.append(table[:, 0], edges[-1]), table[:, 1] - table[:, 0]
        self._before, self._fits = np.append(table[:, 2], 1.0), table[:, 3:]

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

    def _cdf(self, x: Array) -> Array:
        panel, s = self._panel(x)
        return np.clip(self._before[panel] + _series(self._fits, panel, s), 0.0, 1.0)

    def _sf(self, x: Array) -> Array:
        panel, s = self._panel(x)
        rest = 1.0 - self._before[panel] - _series(self._fits, panel, s)
        return np.clip(rest, 0.0, 1.0)

    def _pdf(self, x: Array) -> Array:
        panel, s = self._panel(x)
        # at an edge without a peak both dC/ds and dx/ds vanish: evaluate beside the edge
        s = np.clip(s, 1e-6, 1.0 - 1e-6)
        slope = 2.0 * _series(chebyshev.chebder(self._fits, axis=1), panel, s)
        per_length = self._scale * self._widths[panel] * 0.5 * np.pi * np.sin(np.pi * s)
        on_peak = np.isin(np.asarray(x), self._peaks)
        return np.where(on_peak, np.inf, np.maximum(slope / per_length, 0.0))

    def _moment(self, n: float) -> float:
        return self._scale**n * self._pieces.mean(lambda b: b**n)

    def _variance(self) -> float:
        return self._scale**2 * self._pieces.mean(lambda b: (b - self._mean) ** 2)


def angle_thresholds(sizes: Sizes, fastest: float, scale: float) -> Thresholds | None:
    """The law of scale * b(angle) of one island.

    sizes : |c_1 S_1|, |c_2 S_2| of angles (m,), shape (m, 2), energies.
    fastest : the largest derivative of its phases with the angle: the greatest |G| times the reach.

    None where the island is so large that its barrier has too many peaks.
    """
    some = np.array([0.3, 0.77, 1.31, 1.9, 2.4, 2.95, 3.6])
    known = sizes(some).min(-1)
    period = 2.0 * np.pi  # b repeats by the symmetry of substrate and island together
    for folds in (2, 3, 4, 6, 12):
        turned = sizes(some + 2.0 * np.pi / folds).min(-1)
        if np.abs(turned - known).max() <= 1e-10 * known.max():
            period = 2.0 * np.pi / folds
    if period * fastest * _PER_RADIAN > _MOST:
        return None
    if np.ptp(known) <= _LEVEL * known.max():
        return identical(scale * 2.0 * float(known[0]))
    return AngleThresholds(_Pieces(sizes, fastest, period), scale)
