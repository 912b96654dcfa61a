"""The steepest fall and the largest value of F(X) on a slider that moves forward at one speed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.lives.make import steady_life
from master.motion.motion import Motion
from master.renewal import rule
from master.renewal.births import reforming_law
from master.renewal.march import March
from master.rigid import FINEST, GRAINS, longest_stretch, march_of
from master.rigid import ROUND_OFF as ROUND_OFF_OF_FORCE
from master.steady.travel import Travel
from origins import Contacts

Array = npt.NDArray[np.float64]

# F is followed for LIVES typical lives, and one more than those of all but the share FEW of the
# contacts in steady sliding, but for at most MOST_LIVES.
LIVES, FEW, MOST_LIVES = 10.0, 1e-6, 1000.0
# Most marches, each to a hundredth of the tolerance of the one before, to reach that of K* and F_s.
TRIALS, BETTER = 3, 1e-2
# Points at which a panel's polynomial is evaluated to find its maximum, and repetitions around the
# largest value: its place is then known to 1e-6 of a panel, the value to the square of that.
POINTS, ZOOMS = 33, 4
# A density counts as divergent at a point if it grows by this factor from the distance FAR to NEAR
# (in units of the stretch).
GROWTH, NEAR, FAR = 1.02, 1e-12, 1e-10
# Factor on estimates of F beyond the end of the march.
SAFETY = 2.0

# Accuracy of the tables in units of the tolerance of K*, and the finest: a slope loses some four
# digits.
FINEST_TABLE, ACCURACY = 1e-13, 1e-6
# Smallest value, in mean thresholds, that is taken for the longest stretch: a smaller one would make
# the march's tolerance finer than rounding.
LEAST_STRETCH = 0.1
# Finest tolerance of a march, in units of the error of the survival.
TOLD = 10.0


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
    # an error e of a polynomial of degree n on a panel of width w makes errors of up to 2 n^2 e / w of
    # its slope: panels are solved to a hundredth of the slope's tolerance; beside densities that
    # diverge, tolerances below 1e-6 would take long
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
    # F decays to the kinetic force, so that F_s is at least this
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


def births_table(contacts: Contacts, life: Life, velocity: float, tolerance: float) -> Travel:
    """The table of E and K, as accurate as a march needs for slopes of F to this tolerance."""
    accuracy = max(ACCURACY * tolerance, FINEST_TABLE)
    return Travel(contacts, life, reforming_law(contacts), velocity, accuracy)


def forward_march(
    contacts: Contacts, births: Travel, velocity: float, horizon: float, tolerance: float
) -> March:
    """The march of contacts from their start to X = `horizon` (a length), not yet run.

    births : from `births_table`
    tolerance : of the force, in mean thresholds; limited by the error of the survival
    """
    life, mean = births.life, contacts.mean_threshold
    motion = Motion(np.array([0.0, horizon / velocity]), np.array([0.0, horizon]))
    first = max(abs(end) for end in contacts.start.span)
    # with heat contacts break long before they reach the longest stretch
    most = max(first + births.most, LEAST_STRETCH * mean)
    # some lives know their error only after they were evaluated for the stretches of the start
    life.left(contacts.start, motion.history(motion.times[None, 1:], np.zeros((1, 1))))
    told = max(FINEST, TOLD * (life.error + (0.0 if life.quick else births.table.error)))
    finest = told * min(longest_stretch(contacts, motion, life), most) / mean
    march = march_of(contacts, motion, life, max(tolerance, finest), most=most)
    if not life.quick:
        # an error of the force divided by the panel's width is one of the slope: avoid narrow panels
        march.grain = GRAINS * births.grain
    return march


def unit_of(contacts: Contacts, travel: Travel) -> float:
    """The unit of the tolerance of F_s, a length: the mean threshold, or with heat the mean travel C.

    With growing grains C is no measure: contacts of the start are older and live far longer.
    """
    plain = contacts.thermal is None or contacts.grains is not None
    return contacts.mean_threshold if plain else travel.length


def _of(march: March, velocity: float, typical: float) -> Extremes:
    """K* and F_s (paper, Eq. Q6b) from F on the panels; `typical` is the travel to a break."""
    width = velocity * np.array(march.width)
    series = np.array(march.force) @ rule.TO_LEGENDRE.T
    # 2e-15: round-off of the number of breaks on a panel
    wrong = np.maximum(march.wrong, 2e-15) + march.life_error
    off = wrong * march.stretch
    static, static_error = _largest(series, off)
    static_error += ROUND_OFF_OF_FORCE * (march.stretch + float(march.motion.positions[-1]))
    if len(march.lumps) > 1:
        return Extremes(np.inf, 0.0, static, static_error)
    # on panels narrower than this the change of F is rounding, and so would be its slope
    wide = width > 1e-6 * typical
    slopes = np.polynomial.legendre.legder(series[wide].T).T * (-2.0 / width[wide, None])
    spring, spring_error = _largest(slopes, 2.0 * rule.DEGREE**2 * (off / width)[wide])
    return Extremes(max(spring, 0.0), spring_error, static, static_error)


def _largest(series: Array, off: Array) -> tuple[float, float]:
    """The largest value of all panels' Legendre series, and its error; `off` is that of the series."""
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
    """How far to follow F (a length), and whether its extremes surely lie before that.

    Where generations of breaks do not overlap, only the first is followed: it is the sharpest.
    """
    life, (low, high) = travel.life, contacts.start.span
    again = 0.0 if contacts.reforming is None else max(contacts.reforming.law.span[1], 0.0)
    if life.reach - low < 2.0 * life.quiet - high - again:
        # F is followed for 0.01 mean thresholds beyond the last break of the first generation
        return life.reach - min(low, 0.0) + 0.01 * contacts.mean_threshold, True
    unit = unit_of(contacts, travel)
    ways = travel.table.begin
    many = ways[travel.table(ways)[0] * ways > FEW * travel.length].max(initial=0.0)
    furthest = max(LIVES * unit, many + unit)
    horizon = min(furthest, MOST_LIVES * unit)
    return horizon - min(low, 0.0), bool(furthest <= horizon)


def _beyond(travel: Travel, horizon: float) -> tuple[float, float]:
    """Largest slope -dF/dX and largest excess of F over F_k (a length) beyond the horizon.

    From -dF/dX = integral of x p (u - 1), with u = C times the rate of breaks: u - 1 has an
    integral of about F_k, and decays to the contribution of lives longer than the horizon.
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
    """Whether P_c diverges at a stretch that all contacts reach together: F then drops there."""
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
