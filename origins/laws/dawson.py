"""G(y), the integral of exp(t²) from 0 to y, in logarithms, and its inverse: thermal breaking of soft contacts."""

from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

Array = npt.NDArray[np.float64]

_STEPS = 20  # five do
_LOWEST, _BETWEEN, _COUNT = -24.0, 0.02, 16_000  # tabled levels
_LAST = 1e-8  # Newton squares what is missing: a step from this close is the last


def log_growth(y: npt.ArrayLike) -> Array:
    """ln G(y) = y² + ln D(y) for y >= 0, D being Dawson's integral; -inf at 0. Finite where exp(y²) overflows."""
    y = np.asarray(y, dtype=float)
    with np.errstate(divide="ignore", over="ignore"):
        return y * y + np.log(dawsn(y))


def inverse_log_growth(level: npt.ArrayLike) -> Array:
    """The y >= 0 at which ln G(y) = level, for any level; shape as level. To a relative 1e-14."""
    level = np.asarray(level, dtype=float)
    flat = level.ravel()
    place = (flat - _LOWEST) / _BETWEEN
    tabled = (place >= 0.0) & (place < _COUNT - 1.0)
    if tabled.all():
        return _tabled(place).reshape(level.shape)[()]
    out = np.empty_like(flat)
    out[tabled] = _tabled(place[tabled])
    out[~tabled] = _by_newton(flat[~tabled])
    return out.reshape(level.shape)[()]


def _tabled(place: Array) -> Array:
    """By quintics between levels, of which value, slope and curvature are known."""
    cell = place.astype(np.intp)
    t, series = place - cell, _table()
    out = series[5].take(cell)
    for k in (4, 3, 2, 1, 0):
        out *= t
        out += series[k].take(cell)
    return out


@cache
def _table() -> Array:
    """Coefficients of the quintics, rows by powers of the share of the way from one level to the next."""
    y = _by_newton(np.asarray(_LOWEST + _BETWEEN * np.arange(_COUNT), dtype=np.float64))
    growth = dawsn(y)
    slope, bend = _BETWEEN * growth, 0.5 * _BETWEEN**2 * growth * (1.0 - 2.0 * y * growth)
    # what value, slope and curvature at the far end leave to the powers 3, 4, 5
    rise = np.diff(y) - slope[:-1] - bend[:-1]
    turn = np.diff(slope) - 2.0 * bend[:-1]
    more = np.diff(bend)
    return np.array(
        [
            y[:-1],
            slope[:-1],
            bend[:-1],
            10.0 * rise - 4.0 * turn + more,
            -15.0 * rise + 7.0 * turn - 2.0 * more,
            6.0 * rise - 3.0 * turn + more,
        ]
    )


def _by_newton(level: Array) -> Array:
    """ln G is convex in ln y, so that Newton's steps from above never overshoot."""
    out = np.where(level > 0.0, np.inf, 0.0)
    place = np.flatnonzero(np.isfinite(level))
    goal = level[place]
    with np.errstate(over="ignore"):
        # G(y) > y below, and G(y) > exp(y²)/(2y + 1) above
        rough = np.sqrt(np.maximum(goal, 0.0) + 1.0)
        y = np.minimum(np.exp(goal), np.sqrt(np.maximum(goal, 0.0) + np.log(2.0 * rough + 3.0)))
    for _ in range(_STEPS):
        # what underflows is where the logarithm of y is below that of any float: y = exp(level) = 0
        alive = y > 0.0
        out[place[~alive]] = 0.0
        place, goal, y = place[alive], goal[alive], y[alive]
        if not place.size:
            break
        growth = dawsn(y)
        step = (y * y + np.log(growth) - goal) * growth / y
        y = y * np.exp(-step)
        settled = np.abs(step) < _LAST
        out[place] = y
        place, goal, y = place[~settled], goal[~settled], y[~settled]
    return out
