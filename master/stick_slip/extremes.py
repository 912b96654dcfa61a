"""The steepest fall and the largest value of F(X) on a slider that moves forward at one speed."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from master.motion import Motion
from master.numerics import polynomials
from master.renewal.budget import SMALLEST_TOLERANCE
from master.renewal.march import March
from master.renewal.panel_width import WIDE
from master.rigid import ROUND_OFF, longest_stretch, march_of
from master.steady.cycle import Cycle
from master.survival.life import COEFFICIENT_LIMIT
from master.survival.make import steady_life
from origins import Contacts
from origins.thresholds.law import Array

# How far F is followed, in units of `unit_of`: for UNITS, and to one unit beyond the longest distance that more than
# the share OLD of the contacts in steady sliding have lived through, but for at most MOST_UNITS.
UNITS, OLD, MOST_UNITS = 10.0, 1e-6, 1000.0
# Accuracies of F, in that asked for, with which slopes are tried until they are good.
FINER = 1.0, 1e-2, 1e-4
# A slope is asked for to this part of its tolerance in F: an error e of a polynomial of degree n on a panel of width w
# makes errors of up to 2 n² e/w. Beside a density that diverges F is solved to no better than LEAST_ASKED, in units of
# `unit_of`, as more takes long and the slope is infinite anyhow.
FOR_SLOPE, LEAST_ASKED = 1e-3, 1e-6
# Accuracy of the table of E in the tolerance of slopes, which lose some four digits; and the finest one.
FOR_TABLE, FINEST_TABLE = 1e-6, 1e-13
# Least largest force of a contact, in mean thresholds: less would make the march's tolerance finer than rounding.
LEAST_FORCE = 0.1
# Round-off of the number of breaks on a panel, a share of the contacts.
BREAKS_ROUNDED = 2e-15
# Width of a panel, in typical lives, below which the change of F on it is rounding, and so would be its slope.
NARROW = 1e-6
# The largest value on a panel is searched by so many rounds of so many points, each between the neighbours of the best
# one: then its place is known to 1e-6 of a panel.
ROUNDS, LOOKED_AT = 5, 33
# F is followed by this part of a mean threshold beyond the last break of a generation.
BEYOND_BREAKS = 0.01


class Largest(NamedTuple):
    """The largest value of a function of X, its error, and X there (a length)."""

    value: float
    error: float
    position: float


class Extremes(NamedTuple):
    """The largest -dF/dX, K*/(N_c <k>): 0 where F never falls, inf where it drops or its slope diverges; F_s, the
    largest F (a length); their errors are absolute. And E and K of contacts that re-form, in steady sliding."""

    fall: Largest
    force: Largest
    cycle: Cycle


def extremes(contacts: Contacts, speed: float, tolerance: float, until: float = np.inf) -> Extremes:
    """K* to a tolerance relative to 1 + K*, and F_s to one in units of `unit_of`; unknown where they are not found by
    the reading `until` of time.monotonic()."""
    cycle = cycle_table(contacts, speed, tolerance)
    horizon, followed = _horizon(cycle)
    unit, diverges = unit_of(cycle), _diverges(contacts, cycle.life.bends)
    asked = max(tolerance, LEAST_ASKED) if diverges else FOR_SLOPE * tolerance
    asked *= unit / contacts.mean_threshold
    solved_to = np.inf
    for finer in FINER:
        march = forward_march(cycle, horizon, finer * asked, until)
        if march.tolerance >= solved_to:  # the finest already
            break
        solved_to = march.tolerance
        if march.run().unfinished:
            unknown = Largest(np.nan, np.inf, np.nan)
            return Extremes(unknown, unknown, cycle)
        fall, force = _steepest_and_highest(march, cycle)
        good = fall.error <= tolerance * (1.0 + fall.value) and force.error <= tolerance * unit
        if good or diverges:
            break
    fall = Largest(np.inf, 0.0, fall.position) if diverges else fall
    # F decays to the kinetic force, so that F_s is at least this
    force = force._replace(value=max(force.value, cycle.force()[0]))
    if not followed:
        steepest, highest = _beyond(cycle, horizon)
        fall = fall._replace(error=max(fall.error, steepest - fall.value))
        force = force._replace(error=max(force.error, highest - force.value))
    return Extremes(fall, force, cycle)


def cycle_table(contacts: Contacts, velocity: float, tolerance: float) -> Cycle:
    """The table of E and K, as accurate as a march needs for slopes of F to this tolerance."""
    accuracy = max(FOR_TABLE * tolerance, FINEST_TABLE)
    # never coarser than where no tolerance is known: a march that is asked for more, as slopes turn out to be bad,
    # would narrow its panels without end in the noise of averages over the start
    life = steady_life(contacts, velocity, min(FOR_SLOPE * tolerance, COEFFICIENT_LIMIT))
    return Cycle(contacts, life, velocity, accuracy)


def forward_march(cycle: Cycle, horizon: float, tolerance: float, until: float = np.inf) -> March:
    """The march of contacts with this `cycle_table` from their start to X = `horizon` (a length), not yet run;
    the tolerance of the force, in mean thresholds, is limited by the error of the survival."""
    contacts, life, mean = cycle.contacts, cycle.life, cycle.contacts.mean_threshold
    motion = Motion(np.array([0.0, horizon / cycle.velocity]), np.array([0.0, horizon]))
    # with heat contacts break long before they reach the longest stretch
    most = max(max(abs(end) for end in contacts.start.span) + cycle.most, LEAST_FORCE * mean)
    least_error = cycle.survival_error + (0.0 if life.quick else float(cycle.table.tails.max()))
    # rounded positions make steps of the survival of narrow laws, which no panel resolves: a tenth of those, and ten
    # times the error of a survival, can be met
    finest = max(
        SMALLEST_TOLERANCE, 10.0 * least_error, 0.1 * np.spacing(horizon) / cycle.resolution_length
    )
    finest *= min(longest_stretch(contacts, motion, life), most) / mean
    march = march_of(contacts, motion, life, max(tolerance, finest), until, most)
    if not life.quick:
        # an error of the force divided by the panel's width is one of the slope: avoid narrow panels
        march.guess = WIDE * cycle.resolution_length
    return march


def unit_of(cycle: Cycle) -> float:
    """The unit of the tolerance of F_s, a length: the mean threshold, or with heat the mean travel C, which is no
    measure where contacts of the start are older and live far longer."""
    contacts = cycle.contacts
    plain = contacts.thermal is None or contacts.older_at_start
    return contacts.mean_threshold if plain else cycle.length


def _steepest_and_highest(march: March, cycle: Cycle) -> tuple[Largest, Largest]:
    """The steepest fall and F_s (paper, Eq. Q6b) from F on the panels; `cycle` as in `forward_march`."""
    solved = march.solved
    begin, width = cycle.velocity * solved.begin, cycle.velocity * solved.width
    series = solved.force @ polynomials.TO_LEGENDRE.T
    errors = (np.maximum(solved.error, BREAKS_ROUNDED) + march.unseen_error) * march.longest_stretch
    # births that earlier panels got wrong shift F later, by as much as their panel is wide beside the length
    # over which contacts break: conservation puts the number right at the panel's end
    shifted = np.maximum.accumulate(errors * np.minimum(width / cycle.resolution_length, 1.0))
    force = _largest(series, np.maximum(errors, shifted), begin, width)
    rounding = ROUND_OFF * (march.longest_stretch + float(march.motion.positions[-1]))
    force = force._replace(error=force.error + rounding)
    if len(march.lumps) > 1:
        return Largest(np.inf, 0.0, march.lumps[1].birth * cycle.velocity), force
    wide = width > min(NARROW * cycle.typical, 0.5 * width.max())
    slopes = legendre.legder(series[wide].T).T * (-2.0 / width[wide, None])
    errors = 2.0 * polynomials.DEGREE**2 * errors / width + shifted / cycle.resolution_length
    fall = _largest(slopes, errors[wide], begin[wide], width[wide])
    return fall._replace(value=max(fall.value, 0.0)), force


def _largest(series: Array, errors: Array, begin: Array, width: Array) -> Largest:
    """The largest value of all panels' Legendre series, which have these errors."""
    low, high, rows = -np.ones(begin.size), np.ones(begin.size), np.arange(begin.size)
    for _ in range(ROUNDS):
        z = np.linspace(low, high, LOOKED_AT, axis=1)
        values = polynomials.legendre_sum(series, z)
        at = values.argmax(axis=1)
        low, high = z[rows, np.maximum(at - 1, 0)], z[rows, np.minimum(at + 1, LOOKED_AT - 1)]
    best = values.max(axis=1)
    k = int(best.argmax())
    error = max(float((best + errors).max() - best[k]), float(best[k] - (best - errors).max()))
    return Largest(float(best[k]), error, float(begin[k] + 0.5 * width[k] * (1.0 + z[k, at[k]])))


def _horizon(cycle: Cycle) -> tuple[float, bool]:
    """How far to follow F (a length), and if its extremes surely lie before. If generations of breaks do not overlap,
    the first is the sharpest, or the second if contacts re-form elsewhere than relaxed: else three delays more then.
    Never beyond where F is `_renewed`."""
    life, contacts, elsewhere = cycle.life, cycle.contacts, any(cycle.born.span)
    low, high = contacts.start.span
    if life.largest_stretch - low < 2.0 * life.safe_stretch - high - max(cycle.born.span[1], 0.0):
        # the last contact breaks before any breaks for the second time
        second = life.largest_stretch - cycle.born.span[0] + cycle.wait if elsewhere else 0.0
        last_break = life.largest_stretch - min(low, 0.0) + second
        return last_break + BEYOND_BREAKS * contacts.mean_threshold, True
    unit, begin, end = unit_of(cycle), cycle.table.begin, cycle.table.end
    old = end[cycle.table(begin)[0] * end > OLD * cycle.length].max(initial=0.0)
    furthest = max(UNITS * unit, old + unit)
    horizon = min(furthest, MOST_UNITS * unit)
    # contacts that re-form relaxed fall most steeply in the first generation
    horizon, followed = horizon - min(low, 0.0) + 3.0 * cycle.wait * elsewhere, furthest <= horizon
    return min(horizon, renewed := _renewed(cycle)), bool(followed or renewed <= horizon)


def _renewed(cycle: Cycle) -> float:
    """The travel (a length) beyond which F and F' are means of their values over the longest cycle before, and do not
    exceed these: once no contact of the start is left, nor those born of their breaks, the renewal equation says
    F(X) = integral of p(s) F(X - s - delay). inf where lives change with time."""
    contacts = cycle.contacts
    if contacts.changing is not None:
        return np.inf
    largest, start = cycle.life.largest_stretch, contacts.start
    longest = min(cycle.longest, largest - min(cycle.born.span[0], 0.0))
    # the last of them may break together
    longest += cycle.wait + BEYOND_BREAKS * contacts.mean_threshold
    if start.is_single and start.span == cycle.born.span and not contacts.older_at_start:
        return longest
    return longest + cycle.wait + largest - min(start.span[0], 0.0)


def _beyond(cycle: Cycle, horizon: float) -> tuple[float, float]:
    """Bounds of the slope -dF/dX and of F (a length) beyond the horizon. In -dF/dX = integral of x p (u - 1), u
    is C times the rate of breaks; u - 1 has an integral of about F_k, and decays to the contribution of lives longer
    than the horizon. Both bounds are doubled for safety."""
    distances = np.append(0.5 * horizon, cycle.table.end[cycle.table.end > 0.5 * horizon])
    middle = np.sqrt(distances[1:] * distances[:-1])
    survival, kinetic = cycle.table(middle)[0], cycle.area / cycle.length
    broken = np.maximum(
        -np.diff(cycle.table(distances)[0]) / np.log(distances[1:] / distances[:-1]), 0.0
    )
    older = float(survival @ np.diff(distances)) / cycle.length
    steepest = kinetic / cycle.length * float(broken.max(initial=0.0)) + older
    excess = float((survival * middle).max(initial=0.0)) / cycle.length + older
    return 2.0 * steepest, kinetic * (1.0 + 2.0 * excess)


def _diverges(contacts: Contacts, bends: Array) -> bool:
    """Whether P_c diverges at a stretch that all contacts reach together: so does F's slope there."""
    if not contacts.start.is_single:
        return False
    points = np.append(bends, contacts.thresholds.support()[1])
    points = points[np.isfinite(points) & (points > abs(contacts.start.mean()))]
    # a density that still grows from 1e-10 to 1e-12 of the stretch before or after it
    sides = 1.0 + np.multiply.outer([1e-12, 1e-10], [-1.0, 1.0])
    near, far = contacts.thresholds.pdf(points[:, None, None] * sides).swapaxes(0, 1)
    # by 2 %, where even x^-0.01 grows by 5 %; and is no rounding beside the mean density
    grows = (near > 1.02 * far) & (far > 0.0)
    return bool(((near * contacts.mean_threshold > 1e-3) & grows).any())
