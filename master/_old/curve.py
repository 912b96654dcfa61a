"""The load along a straight move of a soft slider, and where on it the slider lets go and is caught again.

A spring K pulls the slider; with y the travel of the slider and F the force of the contacts along the motion,

    load(y) = F(y) + K y = K (travel of the drive),    slope(y) = F'(y) + K.

The slider follows the drive as long as the load rises. Where its slope falls below zero it slips, and it stops at the
first y that carries the same load again. As the force grows by no more than the stretch does, F' <= 1: the load
cannot rise faster than by 1 + K, and so no earlier root is ever stepped over.
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_SECTIONS = np.linspace(0.0, 1.0, 9)
_ROUNDS = 60
_DEEPEST = 8
_NEAR = np.geomspace(1e-8, 0.5, 40)
_DONE = 4e-16
_FINEST = 1e-14
_COARSE, _MARGIN = 1, 1.5


class Curve(Protocol):
    """Load and slope over travels y up to `end`; `points` are dense enough that between two of them neither does
    anything unforeseen but one swing; `drops` are travels at which the load falls at once."""

    spring: float
    end: float

    @property
    def points(self) -> Array: ...

    @property
    def drops(self) -> Array: ...

    def load(self, y: Array) -> Array: ...

    def slope(self, y: Array) -> Array: ...


def onset(curve: Curve, begin: float) -> tuple[float, float]:
    """First travel beyond `begin` at which the load stops rising, inf if none; and the least slope seen up to there."""
    y = curve.points[(curve.points > begin) & (curve.points <= curve.end)]
    y = np.concatenate([[begin], y])
    slope = curve.slope(y)
    drops = curve.drops[curve.drops > begin]
    drop = float(drops[0]) if drops.size else np.inf
    falling = np.flatnonzero(slope < 0.0)
    last = int(falling[0]) if falling.size else y.size
    inner = np.arange(1, min(last, y.size - 1))
    lowest = inner[(slope[inner] <= slope[inner - 1]) & (slope[inner] <= slope[inner + 1])]
    lowest = np.sort(lowest[np.argsort(slope[lowest])][:_DEEPEST])
    left, right = (y[last - 1], y[last]) if 0 < last < y.size else (begin, np.inf)
    if last == 0:
        return min(begin, drop), float(slope[0])
    least = float(slope[:last].min())
    for i in lowest:
        at, value = _least(curve.slope, float(y[i - 1]), float(y[i + 1]))
        least = min(least, value)
        if value < 0.0:
            left, right = float(y[i - 1]), at
            break
    if not np.isfinite(right):
        return drop, least
    deepest = float(slope[falling].min(initial=0.0))
    return min(_crossing(curve.slope, float(left), float(right)), drop), min(least, deepest)


def landing(curve: Curve, begin: float, level: float, dropped: bool = False) -> float:
    """First travel beyond the slip's beginning at which the load is back at `level`; inf if that is beyond the end.

    `dropped` says that the load fell at once at the beginning: then it may rise from there on.
    """
    near = begin + _NEAR * np.diff(curve.points).max(initial=curve.end)
    y = np.unique(np.concatenate([near, curve.points[curve.points > begin], [curve.end]]))
    y = y[(y > begin) & (y <= curve.end)]
    if not y.size:
        return np.inf
    load, slope = curve.load(y), curve.slope(y)
    falling = np.flatnonzero(slope < 0.0)
    first = 0
    if not dropped:
        if not falling.size:
            return begin
        rising = np.flatnonzero(slope[falling[0] :] >= 0.0)
        if not rising.size:
            return np.inf
        # while the load falls nothing is crossed; where it turns, between two points, is where to begin
        first = int(falling[0] + rising[0]) - 1
    y, load = y[first:], load[first:]
    if load[0] >= level:
        return float(y[0])
    left, right, at_left, at_right = y[:-1], y[1:], load[:-1], load[1:]
    steepest = np.full(left.size, 1.0 + curve.spring)
    for round_ in range(_ROUNDS):
        reached = np.flatnonzero(at_right >= level)
        upto = int(reached[0]) + 1 if reached.size else left.size
        may = (at_left + steepest * (right - left))[:upto] >= level
        may[upto - 1] |= reached.size > 0
        left, right = left[:upto][may], right[:upto][may]
        if not left.size:
            return np.inf
        if (right - left).max() <= _FINEST * (1.0 + right[-1]):
            break
        grid = left[:, None] + (right - left)[:, None] * _SECTIONS
        grid[:, -1] = right
        value = curve.load(grid.ravel()).reshape(grid.shape)
        left, right = grid[:, :-1].ravel(), grid[:, 1:].ravel()
        at_left, at_right = value[:, :-1].ravel(), value[:, 1:].ravel()
        steepest = np.full(left.size, 1.0 + curve.spring)
        if round_ >= _COARSE:
            # so far below the distance of the points the slope swings no more: the larger of two ends bounds it
            slope = curve.slope(grid.ravel()).reshape(grid.shape)
            larger = np.maximum(slope[:, :-1], slope[:, 1:]).ravel()
            steepest = np.minimum(steepest, _MARGIN * np.maximum(larger, 0.0))
    return float(right[0])


def inverse(curve: Curve, load: Array, low: float, high: float) -> Array:
    """Travels between low and high, where the load rises, that carry the loads asked for."""
    inner = curve.points[(curve.points > low) & (curve.points < high)]
    y = np.concatenate([[low], inner, [high]])
    known = np.maximum.accumulate(curve.load(y))
    cell = np.clip(np.searchsorted(known, load, side="right") - 1, 0, y.size - 2)
    left, right = y[cell], y[cell + 1]
    rise = known[cell + 1] - known[cell]
    share = np.where(rise > 0.0, (load - known[cell]) / np.where(rise > 0.0, rise, 1.0), 0.0)
    out = left + (right - left) * np.clip(share, 0.0, 1.0)
    open_ = np.arange(load.size)
    for _ in range(_ROUNDS):
        at = out[open_]
        miss = curve.load(at) - load[open_]
        left[open_] = np.where(miss < 0.0, at, left[open_])
        right[open_] = np.where(miss >= 0.0, at, right[open_])
        slope = curve.slope(at)
        step = np.where(slope > 0.0, miss / np.where(slope > 0.0, slope, 1.0), np.inf)
        better = at - step
        inside = (better >= left[open_]) & (better <= right[open_])
        out[open_] = np.where(inside, better, 0.5 * (left[open_] + right[open_]))
        moving = np.abs(out[open_] - at) > _DONE * (1.0 + np.abs(at))
        open_ = open_[moving & (right[open_] - left[open_] > _DONE * (1.0 + np.abs(at)))]
        if not open_.size:
            break
    return out


def _crossing(function: Callable[[Array], Array], left: float, right: float) -> float:
    """Where the function falls below zero, between a left end where it is not and a right end where it is."""
    for _ in range(_ROUNDS):
        grid = left + (right - left) * _SECTIONS
        first = int(np.argmax(function(grid[1:-1]) < 0.0)) if (function(grid[1:-1]) < 0.0).any() else 7
        left, right = float(grid[first]), float(grid[first + 1])
        if right - left <= _DONE * (1.0 + abs(right)):
            break
    return 0.5 * (left + right)


def _least(function: Callable[[Array], Array], left: float, right: float) -> tuple[float, float]:
    """Where between left and right the function is least, and how small."""
    best, value = left, np.inf
    for _ in range(14):
        grid = left + (right - left) * _SECTIONS
        values = function(grid)
        i = int(values.argmin())
        if values[i] < value:
            best, value = float(grid[i]), float(values[i])
        if value < 0.0:
            break
        left, right = float(grid[max(i - 1, 0)]), float(grid[min(i + 1, 8)])
    return best, value
