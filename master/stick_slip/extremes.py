"""The steepest fall and the largest value of F(X) on a slider that moves forward at one speed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.lives.make import steady_life
from master.renewal import rule
from master.renewal.march import March
from master.rigid import ROUND_OFF as ROUND_OFF_OF_FORCE
from master.steady.travel import Travel
from master.stick_slip.forward import births_table, forward_march
from origins import Contacts

Array = npt.NDArray[np.float64]

# How far F is followed: so many typical lives, and as far as more than one in a million of those
# that hold at a time have come, but at most so many typical lives or twice the longest.
LIVES, FEW, MOST_LIVES = 10.0, 1e-6, 1000.0
# Marches, each to a hundredth of the error of the one before, until slope and value are known.
TRIALS, BETTER = 3, 1e-2
# Points of a panel at which a polynomial is looked at, and how often the best of them is looked at
# more closely: places are then known to 1e-6 of a panel, and largest values to its square.
POINTS, ZOOMS = 33, 4
# A density that grows by this between these distances (over the stretch) from a point diverges.
GROWTH, NEAR, FAR = 1.02, 1e-12, 1e-10
# Of estimates of what is not followed.
SAFETY = 2.0


class Extremes(NamedTuple):
    """K* and F_s of a start, each with its error.

    spring, spring_error : max of -dF/dX (no unit), 0 where F never falls, inf where it drops
    static, static_error : max of F (a length)
    """

    spring: float
    spring_error: float
    static: float
    static_error: float


def critical_spring(contacts: Contacts, velocity: float, tolerance: float) -> tuple[float, float]:
    """K*/(N_c <k>) of contacts on a rigid slider that moves forward from their start, and its error."""
    life = steady_life(contacts, velocity)
    travel = births_table(contacts, life, velocity, tolerance)
    return extremes(contacts, travel, velocity, tolerance)[:2]


def extremes(contacts: Contacts, travel: Travel, velocity: float, tolerance: float) -> Extremes:
    """K* to a tolerance relative to 1 + K*, and F_s to one in units of `unit_of`."""
    horizon, followed = _horizon(contacts, travel)
    unit, diverges = unit_of(contacts, travel), _diverges(contacts, travel.life)
    # a polynomial of degree n that is off by e on a panel of width w has a slope that is off by
    # up to 2 n^2 e / w: panels are solved to a hundredth of what the slope is asked for; beside
    # densities that diverge finer tolerances than 1e-6 take long
    wanted = max(tolerance, 1e-6) if diverges else 1e-2 * tolerance
    found, last = Extremes(0.0, np.inf, 0.0, np.inf), np.inf
    for trial in range(TRIALS):
        asked = wanted * BETTER**trial * unit / contacts.mean_threshold
        march = forward_march(contacts, travel, velocity, horizon, asked)
        good = np.isinf(found.spring) or found.spring_error <= tolerance * (1.0 + found.spring)
        if (good and found.static_error <= tolerance * unit) or march.tolerance >= last:
            break
        last = march.tolerance
        again = _of(march.run(), velocity, travel.typical)
        if again.spring_error >= found.spring_error and again.static_error >= found.static_error:
            break
        found = again
        if diverges:
            found = found._replace(spring=np.inf, spring_error=0.0)
            break
    # F ends there, if it is not above before
    kinetic = travel.area / (travel.length + velocity * contacts.waiting_time)
    found = found._replace(static=max(found.static, kinetic))
    if followed:
        return found
    fall, excess = _beyond(travel, horizon)
    return Extremes(
        found.spring,
        max(found.spring_error, fall - found.spring),
        found.static,
        max(found.static_error, kinetic + excess - found.static),
    )


def unit_of(contacts: Contacts, travel: Travel) -> float:
    """The length in which F_s is asked for: the mean threshold, or way to a break by a rate.

    Contacts of the start whose grains grow are older and live far longer than those born later.
    """
    plain = contacts.thermal is None or contacts.grains is not None
    return contacts.mean_threshold if plain else travel.length


def _of(march: March, velocity: float, typical: float) -> Extremes:
    """K* and F_s (paper, Eq. Q6b) from F on the panels; `typical` is the way to a break."""
    width = velocity * np.array(march.width)
    series = np.array(march.force) @ rule.TO_LEGENDRE.T
    # round-off of the number of breaks on a panel, the share of contacts
    wrong = np.maximum(march.wrong, 2e-15) + march.life_error
    off = wrong * march.stretch
    static, static_error = _largest(series, off)
    static_error += ROUND_OFF_OF_FORCE * (march.stretch + float(march.motion.positions[-1]))
    if len(march.lumps) > 1:
        return Extremes(np.inf, 0.0, static, static_error)
    # over narrower panels F falls by nothing, and its slope there is rounding
    # panels narrower than this, in typical ways to a break, are not asked for slopes
    wide = width > 1e-6 * typical
    slopes = np.polynomial.legendre.legder(series[wide].T).T * (-2.0 / width[wide, None])
    spring, spring_error = _largest(slopes, 2.0 * rule.DEGREE**2 * (off / width)[wide])
    return Extremes(max(spring, 0.0), spring_error, static, static_error)


def _largest(series: Array, off: Array) -> tuple[float, float]:
    """The largest value of all panels' sums of Legendre polynomials, which are off by so much, and
    its error."""
    grid = -np.cos(np.linspace(0.0, np.pi, POINTS))
    z = np.tile(grid, (series.shape[0], 1))
    rows = np.arange(series.shape[0])
    for _ in range(ZOOMS):
        values = rule.legendre_sum(series, z)
        at = values.argmax(axis=1)
        low, high = z[rows, np.maximum(at - 1, 0)], z[rows, np.minimum(at + 1, POINTS - 1)]
        z = np.linspace(low, high, POINTS, axis=1)
    best = rule.legendre_sum(series, z).max(axis=1)
    value = float(best.max())
    return value, max(float((best + off).max()) - value, value - float((best - off).max()))


def _horizon(contacts: Contacts, travel: Travel) -> tuple[float, bool]:
    """How far to follow F (a length), and whether all that matters comes before.

    Where generations come one after the other, clearly apart, only the first is followed, which is
    the sharpest.
    """
    life, (low, high) = travel.life, contacts.start.span
    again = 0.0 if contacts.reforming is None else max(contacts.reforming.law.span[1], 0.0)
    if life.reach - low < 2.0 * life.quiet - high - again:
        # how far F is followed beyond the last break of a generation, in mean thresholds
        return life.reach - min(low, 0.0) + 0.01 * contacts.mean_threshold, True
    unit = unit_of(contacts, travel)
    ways = travel.table.begin
    many = ways[travel.table(ways)[0] * ways > FEW * travel.length].max(initial=0.0)
    furthest = max(LIVES * unit, many + unit)
    horizon = min(furthest, MOST_LIVES * unit)
    return horizon - min(low, 0.0), bool(furthest <= horizon)


def _beyond(travel: Travel, horizon: float) -> tuple[float, float]:
    """How fast F may fall, and by what it may exceed F_k (a length), where it is not followed.

    From -dF/dX = integral of x p (u - 1), u being the breaks per contact and C: (u - 1) has an
    integral of about F_k, and falls to what the lives beyond make.
    """
    ways = np.append(0.5 * horizon, travel.table.end[travel.table.end > 0.5 * horizon])
    middle = np.sqrt(ways[1:] * ways[:-1])
    held = travel.table(middle)[0]
    broken = np.maximum(-np.diff(travel.table(ways)[0]) / np.log(ways[1:] / ways[:-1]), 0.0)
    older = float(held @ np.diff(ways)) / travel.length
    kinetic = travel.area / travel.length
    fall = kinetic / travel.length * float(broken.max(initial=0.0)) + older
    excess = (float((held * middle).max(initial=0.0)) / travel.length + older) * kinetic
    return SAFETY * fall, SAFETY * excess


def _diverges(contacts: Contacts, life: Life) -> bool:
    """Whether P_c diverges where contacts from one stretch come to: they break at once there."""
    if not contacts.start.is_single:
        return False
    points = np.append(life.bends, contacts.thresholds.support()[1])
    points = points[np.isfinite(points) & (points > abs(contacts.start.mean()))]
    sides = np.array([-1.0, 1.0])
    near, far = (
        contacts.thresholds.pdf(points[:, None] * (1.0 + sides * distance))
        for distance in (NEAR, FAR)
    )
    some = near * contacts.mean_threshold > 1e-3
    return bool((some & (near > GROWTH * far) & (far > 0.0)).any())
