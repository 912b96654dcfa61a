"""P_c of one rigid island over all angles, from its barrier b(angle) itself (paper, Sec. VI C).

P_c diverges as an inverse square root where b stands still, and jumps where b bends. Between these the
share of angles below x is smooth in t, x = lower + (upper - lower) sin²(t/2): polynomials in t.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from origins.domains.barrier_curve import (
    BarrierCurve,
    Features,
    Pieces,
    barrier_curve,
    pieces_of,
    series,
)
from origins.domains.barriers import Climb
from origins.thresholds.identical import identical
from origins.thresholds.law import Array, Thresholds

_NODES = 24  # Chebyshev nodes in t on each panel
_SMOOTH = 1e-9  # of a panel's share: what a resolved panel leaves out
_LEAST = 1e-3  # share of a panel below which it need not be resolved as well
_SPLITS = 10  # halvings of a panel that is not resolved
_SAME = 1e-10  # of the greatest barrier: values nearer than this are one
_LEVEL = 1e-6  # of the greatest barrier: the barrier of one atom is the same at all angles
_WEIGHT = 1e-3  # share of thresholds above which a peak or jump is declared, counted
_BESIDE = 0.01  # within this distance, in mean thresholds
_ROUNDING = 1e-11  # of the greatest barrier: what is known of a bend
_NEWTON_STEPS = 8
_HALVINGS = 12

_u = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)[::-1]
_t = 0.5 * np.pi * (1.0 + _u)
_FIT = np.linalg.inv(np.polynomial.chebyshev.chebvander(_u, _NODES - 1)).T


@dataclass(frozen=True)
class _Table:
    """Shares between the edges (energies, n + 1): polynomials of degree 23 on each of the n panels.

    From an edge up to t the share of angles grows by t below(t); from t to the next edge it is
    (pi - t) above(t); their slope in t is slope(t). shares (n,) are those of whole panels.
    """

    edges: Array
    below: Array
    above: Array
    slope: Array
    shares: Array


class AngleThresholds(Thresholds):
    """Law of scale * b(angle), all angles of the full circle equally likely.

    `breakpoints` are the ends of the support and the peaks and jumps that hold more than 1e-3 of the
    thresholds within 1e-2 mean thresholds; lesser ones are there, but not declared.
    """

    knows_breakpoints = False

    def __init__(self, curve: BarrierCurve, scale: float) -> None:
        self._curve, self._scale = curve, scale
        pieces, features = pieces_of(curve)
        known = _clustered(features, pieces)
        self._mean = curve.mean(lambda b: b)
        distance = _BESIDE * self._mean
        self._table = _tabulated(curve, pieces, known.values)
        heavy = known.peaks * np.sqrt(distance) > _WEIGHT
        declared = heavy | (known.jumps * distance > _WEIGHT)
        declared[[0, -1]] = True
        self._peaks = known.values[heavy]
        self._declared = scale * known.values[declared]
        self._from_below = np.concatenate([[0.0], np.cumsum(self._table.shares)])
        self._from_above = np.concatenate([np.cumsum(self._table.shares[::-1])[::-1], [0.0]])
        self.onset_power = -0.5 if heavy[0] else 0.0

    def support(self) -> tuple[float, float]:
        return float(self._declared[0]), float(self._declared[-1])

    @property
    def breakpoints(self) -> Array:
        return self._declared

    def _place(self, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        """Panel and t of each x; both ends of the panel know their distance from x to the last bit."""
        edges, b = self._table.edges, np.asarray(x) / self._scale
        panel = np.clip(np.searchsorted(edges, b, side="right") - 1, 0, edges.size - 2)
        low, high = np.maximum(b - edges[panel], 0.0), np.maximum(edges[panel + 1] - b, 0.0)
        return panel, 2.0 * np.arctan2(np.sqrt(low), np.sqrt(high))

    def _read(self, polynomials: Array, panel: npt.NDArray[np.intp], t: Array) -> Array:
        return series(polynomials, panel, t * (2.0 / np.pi) - 1.0)

    def _cdf(self, x: Array) -> Array:
        panel, t = self._place(x)
        return np.clip(
            self._from_below[panel] + t * self._read(self._table.below, panel, t), 0.0, 1.0
        )

    def _sf(self, x: Array) -> Array:
        panel, t = self._place(x)
        rest = (np.pi - t) * self._read(self._table.above, panel, t)
        return np.clip(self._from_above[panel + 1] + rest, 0.0, 1.0)

    def _pdf(self, x: Array) -> Array:
        panel, t = self._place(x)
        # at an edge that is no peak the slope vanishes with dx/dt: read it beside the edge
        t = np.clip(t, 1e-6, np.pi - 1e-6)
        widths = self._scale * np.diff(self._table.edges)
        density = self._read(self._table.slope, panel, t) / (0.5 * widths[panel] * np.sin(t))
        on_peak = np.isin(np.asarray(x), self._scale * self._peaks)
        return np.where(on_peak, np.inf, np.maximum(density, 0.0))

    def _moment(self, n: float) -> float:
        if n == round(n):
            return self._scale**n * self._curve.mean(lambda b: b**n)
        # in t a root of b is smooth where b vanishes, too
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        edges, t = self._table.edges, 0.5 * np.pi * (1.0 + nodes)
        panel = np.repeat(np.arange(edges.size - 1), _NODES).reshape(-1, _NODES)
        b = edges[:-1, None] + np.diff(edges)[:, None] * np.sin(0.5 * t) ** 2
        slope = self._read(self._table.slope, panel, np.broadcast_to(t, panel.shape))
        return self._scale**n * float((0.5 * np.pi * weights * slope * b**n).sum())

    def _variance(self) -> float:
        return self._scale**2 * self._curve.mean(lambda b: (b - self._mean) ** 2)


def angle_thresholds(
    climb: Callable[[Array], Climb], fastest: float, scale: float
) -> Thresholds | None:
    """The law of scale * barrier(angle); `fastest` is the greatest |G| times the island's reach.

    None where the island is so large that its barrier has too many peaks to be followed.
    """
    curve = barrier_curve(lambda angle: climb(angle).barriers, fastest)
    if curve is None:
        return None
    level = curve.coefficients[:, 0]
    if np.ptp(level) <= _LEVEL * level.max():
        return identical(scale * float(climb(np.zeros(1)).barriers[0]))
    return AngleThresholds(curve, scale)


def _clustered(features: Features, pieces: Pieces) -> Features:
    """Features of one value put together, sorted, the least and the greatest barrier among them."""
    least, greatest = max(float(pieces.values.min()), 0.0), float(pieces.values.max())
    if least <= _SAME * greatest:
        least = 0.0
    values = np.concatenate([features.values, [least, greatest]])
    peaks, jumps = (np.append(part, [0.0, 0.0]) for part in (features.peaks, features.jumps))
    order = np.argsort(values)
    values, peaks, jumps = values[order], peaks[order], jumps[order]
    starts = np.flatnonzero(np.diff(values, prepend=-np.inf) > _SAME * greatest)
    bounds = np.append(starts, values.size)
    middle = np.array([values[a:b].mean() for a, b in pairwise(bounds.tolist())])
    middle[0], middle[-1] = least, greatest
    return Features(middle, np.add.reduceat(peaks, starts), np.add.reduceat(jumps, starts))


def _tabulated(curve: BarrierCurve, pieces: Pieces, edges: Array) -> _Table:
    """The table; panels that polynomials do not resolve are halved."""
    left, right = edges[:-1], edges[1:]
    finished: list[tuple[Array, Array, Array, Array, Array]] = []
    for split in range(_SPLITS + 1):
        below, above, slope, whole = _shares(curve, pieces, left, right)
        fits = [values @ _FIT for values in (below / _t, above / (np.pi - _t), slope)]
        missed = np.max([np.abs(fit[:, -3:]).max(-1) for fit in fits], axis=0)
        done = (missed <= _SMOOTH * np.maximum(whole, _LEAST)) | (split == _SPLITS)
        finished.append((left[done], *(fit[done] for fit in fits), whole[done]))
        left, right = left[~done], right[~done]
        if not left.size:
            break
        middle = 0.5 * (left + right)
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
    starts, fit_below, fit_above, fit_slope, shares = (
        np.concatenate(part) for part in zip(*finished, strict=True)
    )
    order = np.argsort(starts)
    return _Table(
        np.append(starts[order], edges[-1]),
        fit_below[order],
        fit_above[order],
        fit_slope[order],
        shares[order] / shares.sum(),
    )


def _shares(
    curve: BarrierCurve, pieces: Pieces, left: Array, right: Array
) -> tuple[Array, Array, Array, Array]:
    """At the nodes of panels [left, right] of b: shares of angles below and above within the panel, and
    the slope of the former in t, shape (panels, 24); shares of the whole panels, shape (panels,)."""
    low, high = pieces.values.min(-1), pieces.values.max(-1)
    panel, piece = np.nonzero((low < right[:, None]) & (high > left[:, None]))
    x = left[:, None] + (right - left)[:, None] * np.sin(0.5 * _t) ** 2
    # t of the piece where b reaches the panel's ends and its nodes
    goals = np.column_stack([left[panel], x[panel], right[panel]])
    bottom, top = low[piece, None], high[piece, None]
    # b has the values of one cluster at the panel's end itself, but for rounding
    near = _ROUNDING * high.max()
    goals = np.where(goals <= bottom + near, bottom, np.where(goals >= top - near, top, goals))
    place = _inverse(curve, pieces, piece, goals)
    share = 0.5 * curve.widths[pieces.panel[piece], None] / curve.period
    gains = (
        np.abs(np.stack([place[:, 1:-1] - place[:, :1], place[:, -1:] - place[:, 1:-1]])) * share
    )
    whole = np.abs(place[:, -1] - place[:, 0]) * share[:, 0]
    inside = (goals > bottom) & (goals < top)
    owner = np.broadcast_to(pieces.panel[piece, None], place.shape)
    with np.errstate(divide="ignore"):
        density = np.where(inside, 1.0 / np.abs(curve.slope(owner, place)), 0.0)[:, 1:-1]
    per_angle = density / curve.period
    count = left.size
    sums = np.zeros((3, count, _NODES))
    for total, part in zip(sums, (gains[0], gains[1], per_angle), strict=True):
        np.add.at(total, panel, part)
    slope = sums[2] * 0.5 * (right - left)[:, None] * np.sin(_t)
    return sums[0], sums[1], slope, np.bincount(panel, whole, count).astype(float)


def _inverse(
    curve: BarrierCurve, pieces: Pieces, piece: npt.NDArray[np.intp], goals: Array
) -> Array:
    """Where on each piece b has the values `goals`, which it has, shape (m, n): from -1 to 1 along its panel."""
    ends, values = pieces.ends[piece], pieces.values[piece]
    rises = (values[:, 1] > values[:, 0])[:, None]
    owner = np.broadcast_to(pieces.panel[piece, None], goals.shape)
    low, high = (np.broadcast_to(ends[:, [k]], goals.shape) for k in (0, 1))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        ahead = (curve.at(owner, middle) < goals) == rises
        low, high = np.where(ahead, middle, low), np.where(ahead, high, middle)
    t = 0.5 * (low + high)
    half = 0.5 * curve.widths[owner]
    for _ in range(_NEWTON_STEPS):
        with np.errstate(divide="ignore", invalid="ignore"):
            step = (curve.at(owner, t) - goals) / (curve.slope(owner, t) * half)
        t = np.clip(np.where(np.isfinite(step), t - step, t), low, high)
    # the ends of a piece are reached exactly
    t = np.where(goals == values[:, [0]], ends[:, [0]], t)
    return np.where(goals == values[:, [1]], ends[:, [1]], t)
