"""The barrier of one island against its angle: polynomials on panels, where it stands still and where it bends.

b(angle) is smooth but for bends, where another wave or another saddle begins to decide, as where
min(|S_x|, |S_y|) changes sides, and where it is zero. Panels are halved towards these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

Whole = npt.NDArray[np.intp]

_NODES = 17  # Chebyshev nodes on a panel
_PHASE = 2.0  # radians by which the outermost atoms move over a first panel
_MOST_FIRST = 400  # panels to begin with: larger islands are left to samples
_MOST_OPEN = 4000  # unresolved panels: b is noise there
_SMOOTH = 1e-12  # of the greatest barrier: what a resolved panel leaves out
_NARROWEST = 1e-8  # of a full circle: a panel so narrow that is not smooth holds a bend
_START = (
    0.1234567  # radians: symmetric islands have their extrema at 0, which is to be within a panel
)
_SAMPLES = 33  # of the slope on a panel, to find where it changes sign
_HALVINGS = 50

_x = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)[::-1]
_FIT = np.linalg.inv(np.polynomial.chebyshev.chebvander(_x, _NODES - 1)).T


@dataclass(frozen=True)
class Features:
    """Where the density of barriers is not smooth, arrays of shape (n,).

    values are barriers. The share of angles with a barrier within d of a value where b stands still
    grows as peaks d^(1/2), on one side; where b bends the density jumps by `jumps`, per energy.
    """

    values: Array
    peaks: Array
    jumps: Array


@dataclass(frozen=True)
class BarrierCurve:
    """b on consecutive panels of one period of the angle.

    widths (radians) and coefficients (Chebyshev's, energies) have shape (panels,) and (panels, 17);
    `bent` are pairs of straight panels, some 1e-8 of a circle wide, that meet at a bend.
    """

    widths: Array
    coefficients: Array
    bent: npt.NDArray[np.bool_]

    @property
    def period(self) -> float:
        return float(self.widths.sum())

    def at(self, panel: Whole, t: Array) -> Array:
        """b on panels at t, from -1 to 1 along each, all of one shape."""
        return series(self.coefficients, panel, t)

    def slope(self, panel: Whole, t: Array) -> Array:
        """db/dangle, energy per radian."""
        return series(self._slopes, panel, t) * 2.0 / self.widths[panel]

    @property
    def _slopes(self) -> Array:
        return np.polynomial.chebyshev.chebder(self.coefficients, axis=1).astype(float)

    def mean(self, function: Callable[[Array], Array]) -> float:
        """Mean of function(b) over all angles."""
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        panel = np.repeat(np.arange(self.widths.size), nodes.size).reshape(-1, nodes.size)
        values = function(np.maximum(self.at(panel, np.broadcast_to(nodes, panel.shape)), 0.0))
        return float(self.widths @ (values @ weights)) / (2.0 * self.period)


def series(coefficients: Array, panel: Whole, t: Array) -> Array:
    """Chebyshev series of panels, coefficients of shape (panels, n), at t of the shape of panel, by Clenshaw's rule."""
    rows = np.ascontiguousarray(coefficients.T)
    twice = 2.0 * t
    last = before = np.zeros(np.shape(t))
    for row in rows[:0:-1]:
        last, before = row.take(panel) + twice * last - before, last
    return rows[0].take(panel) + t * last - before


def barrier_curve(barrier: Callable[[Array], Array], fastest: float) -> BarrierCurve | None:
    """b(angle) of one island; `fastest` is the rate of its phases, the greatest |G| times the reach.

    None where the island is so large, or b so noisy, that there would be too many panels.
    """
    period = 2.0 * np.pi / _folds(barrier)
    count = int(np.ceil(period * fastest / _PHASE)) + 1
    if count > _MOST_FIRST:
        return None
    edges = _START + period * np.arange(count + 1) / count
    left, right = edges[:-1], edges[1:]
    found: list[tuple[Array, Array, Array, npt.NDArray[np.bool_]]] = []
    scale = 0.0
    while left.size:
        if left.size > _MOST_OPEN:
            return None
        nodes = 0.5 * (left + right)[:, None] + 0.5 * (right - left)[:, None] * _x
        values = barrier(nodes.ravel()).reshape(nodes.shape)
        scale = max(scale, float(values.max()))
        coefficients = values @ _FIT
        smooth = np.abs(coefficients[:, -3:]).max(-1) <= _SMOOTH * scale
        bent = ~smooth & (right - left < 2.0 * np.pi * _NARROWEST)
        done = smooth | bent
        found.append((left[done], (right - left)[done], coefficients[done], bent[done]))
        left, right = left[~done], right[~done]
        middle = 0.5 * (left + right)
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
    first, widths, coefficients, bent = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.argsort(first)
    return _with_bends(BarrierCurve(widths[order], coefficients[order], bent[order]))


def _with_bends(curve: BarrierCurve) -> BarrierCurve:
    """The curve with two straight panels at each bend, which meet where the tangents from both sides do."""
    # begin behind a smooth panel, so that no run of bent ones is cut
    start = -int(np.flatnonzero(~curve.bent)[0])
    widths, bent = np.roll(curve.widths, start), np.roll(curve.bent, start)
    curve = BarrierCurve(widths, np.roll(curve.coefficients, start, axis=0), bent)
    first = np.flatnonzero(bent & ~np.roll(bent, 1))
    last = np.flatnonzero(bent & ~np.roll(bent, -1))
    one, other = first - 1, (last + 1) % widths.size
    ahead, behind = np.ones(first.size), -np.ones(first.size)
    before, after = curve.at(one, ahead), curve.at(other, behind)
    rise, fall = curve.slope(one, ahead), curve.slope(other, behind)
    across = np.array([widths[a : b + 1].sum() for a, b in zip(first, last, strict=True)])
    with np.errstate(divide="ignore", invalid="ignore"):
        place = (after - fall * across - before) / (rise - fall)
    place = np.where((place > 0.0) & (place < across), place, 0.5 * across)
    top = np.maximum(before + rise * place, 0.0)
    keys = [np.flatnonzero(~bent).astype(float), first - 0.2, first - 0.1]
    straight = np.zeros((2, first.size, _NODES))
    straight[:, :, 0] = 0.5 * (before + top), 0.5 * (top + after)
    straight[:, :, 1] = 0.5 * (top - before), 0.5 * (after - top)
    order = np.argsort(np.concatenate(keys))
    return BarrierCurve(
        np.concatenate([widths[~bent], place, across - place])[order],
        np.concatenate([curve.coefficients[~bent], *straight])[order],
        np.concatenate([np.zeros(len(keys[0]), dtype=bool), np.ones(2 * first.size, dtype=bool)])[
            order
        ],
    )


def _folds(barrier: Callable[[Array], Array]) -> int:
    """How often b repeats in a full circle: by the symmetry of substrate and island together."""
    angles = np.array([0.3, 0.77, 1.31, 1.9, 2.4, 2.95, 3.6])
    values = barrier(angles)
    for folds in (12, 6, 4, 3, 2):
        if np.abs(barrier(angles + 2.0 * np.pi / folds) - values).max() <= 1e-10 * values.max():
            return folds
    return 1


@dataclass(frozen=True)
class Pieces:
    """Stretches of angles over which b rises or falls, one panel each: from t to t (columns), with b there."""

    panel: Whole
    ends: Array
    values: Array


def pieces_of(curve: BarrierCurve) -> tuple[Pieces, Features]:
    """The curve cut where it stands still, and where its density is not smooth."""
    count = curve.widths.size
    t = np.broadcast_to(np.linspace(-1.0, 1.0, _SAMPLES), (count, _SAMPLES))
    every = np.repeat(np.arange(count), _SAMPLES).reshape(t.shape)
    sign = np.sign(curve.slope(every, t))
    panel, place = np.nonzero((sign[:, 1:] * sign[:, :-1] < 0.0) & ~curve.bent[:, None])
    low, high, before = t[panel, place], t[panel, place + 1], sign[panel, place]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        same = np.sign(curve.slope(panel, middle)) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    still = 0.5 * (low + high)
    cuts = np.concatenate([np.full(count, -1.0), still, np.full(count, 1.0)])
    owner = np.concatenate([np.arange(count), panel, np.arange(count)])
    order = np.lexsort((cuts, owner))
    cuts, owner = cuts[order], owner[order]
    inside = owner[:-1] == owner[1:]
    ends = np.column_stack([cuts[:-1], cuts[1:]])[inside]
    owner = owner[:-1][inside]
    values = curve.at(np.column_stack([owner, owner]), ends)
    bends = np.abs(_second(curve, panel, still))
    peaks = 2.0 * np.sqrt(2.0 / bends) / curve.period
    known = Features(curve.at(panel, still), peaks, np.zeros(still.size))
    return Pieces(owner, ends, values), _and_bends(curve, known)


def _second(curve: BarrierCurve, panel: Whole, t: Array) -> Array:
    """d²b/dangle², energy per radian²."""
    second = np.polynomial.chebyshev.chebder(curve.coefficients, 2, axis=1).astype(float)
    return series(second, panel, t) * (2.0 / curve.widths[panel]) ** 2


def _and_bends(curve: BarrierCurve, known: Features) -> Features:
    """The features and those of the bends, between two straight panels each."""
    one = np.flatnonzero(curve.bent)[::2]
    before, behind = (curve.slope(one + k, np.zeros(one.size)) for k in (0, 1))
    with np.errstate(divide="ignore"):
        # contacts gather on both sides below a ridge, and on one side of a bend in a rise
        turns = before * behind < 0.0
        jumps = np.abs(1.0 / np.abs(before) + np.where(turns, 1.0, -1.0) / np.abs(behind))
    return Features(
        np.concatenate([known.values, curve.at(one, np.ones(one.size))]),
        np.concatenate([known.peaks, np.zeros(one.size)]),
        np.concatenate([known.jumps, jumps / curve.period]),
    )
