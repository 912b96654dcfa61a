"""A rigid slider on any path: sets up the march for contacts and drive, reads force and error."""

import time as clock
from copy import copy

import numpy as np
import numpy.typing as npt

from master.motion import Motion
from master.numerics import polynomials
from master.outcome import Progress, outcome, unconserved
from master.renewal.births import Births, Jump, reforming_law, roughly_holding
from master.renewal.budget import ErrorBudget
from master.renewal.edges import ROUNDED, SAME_TIME, edges
from master.renewal.march import March
from master.renewal.panel_width import first_width
from master.solution import Solution
from master.survival.life import Life
from origins import Contacts, Drive, InputError
from origins.errors import refuse
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# Longest path, in mean thresholds, and most lives of a contact on it: squares of lengths stay far from overflow.
FURTHEST = 1e100
# The furthest on a path that turns round, and most lives where it turns or changes its speed: stretches on later legs
# are differences of positions, which lose digits far from 0, and each leg's births are followed on the next.
FURTHEST_TURN, MOST_LIVES_TURN = 1e6, 1e7
# Longest time before a move by a mean threshold, in units of the time that this takes: later its times keep few digits.
LONGEST_BEFORE = 1e11
# Largest error of a panel, a share of the contacts, that its residual tells. Beyond, the panel does not resolve the
# breaks, and its residual bounds nothing: 1.7 mean thresholds were told where 2.0 were true.
RESOLVED = 0.1
# Before a jump of P_c heat breaks contacts in a thin layer, from where the integral A of their rate is e^-25: a hundred
# times the rounding of a survival. Layers that begin below this part of the jump's place are wide enough for panels.
LOG_OF_LAYER, THIN_LAYER = -25.0, 0.8
# Least of the longest stretch, in mean thresholds: the tolerance of the number stays finite where contacts hardly move.
LEAST_STRETCH = 1e-3
# Of the time of a panel's end, by which rounding may put a point of the path behind it.
ROUNDED_END = 1e-12
# A path is followed beyond its end by this part of a mean threshold: contacts that reach an exact threshold just there
# shall have broken.
BEYOND_END = 1e-9
# Instants at which contacts at rest are looked at, a decade apart, in units of the rate law's time; and the shortest
# time beside the delay for which half of them must hold: less is lost in the rounding of the times of re-forming.
LOOKED_AT, SHORTEST_BESIDE_DELAY = np.geomspace(1e-3, 1e50, 54), 1e-12
# How long a start of bins takes; in nine cases of 10 to 200 bins, 12 to 74 s, within a factor 2.2 of what was measured.
# CPU seconds to 1e-3 of averages over a piece of the start, of sums over one of the thresholds, along a whole stretch.
OF_PIECE = 5e-3
# Times as long for each decade below 1e-3, of which at most so many count.
FOR_DECADE, MOST_DECADES = 1.15, 6.0
# Pieces beside the bins and the thresholds' jumps (see Life._averaged, panel_edges).
PIECES_OF_START, PIECES_OF_LAW = 13, 6
# Most seconds where no wall_time is given.
MOST_SECONDS = 100.0
# Round-off of the force per mean threshold travelled, in mean thresholds.
ROUND_OFF = 1e-14
# Tightest tolerance, in changes of a survival over the last place of a position: rounding moves it by half of that, and
# panels keep at least 0.32 of a tolerance. Tighter, panels of narrow laws are halved until `wall_time` is over.
FROM_ROUNDED_POSITIONS = 1.25
# Farthest position that counts there, in mean thresholds: default tolerances stay what they are for laws wider than a
# millionth.
FAR = 50.0


def solve_rigid(
    contacts: Contacts,
    drive: Drive,
    life: Life,
    tolerance: float,
    progress: Progress,
    until: float = np.inf,
) -> Solution:
    """F along the path of a rigid slider (paper, Eq. Q6), for contacts of any life, see `solve`; it stops at the
    reading `until` of time.monotonic(). force_error is the error of the worst panel plus what panels do not see
    (March.unseen_error: survivals and sums over births), times the longest stretch, plus round-off; see ErrorBudget."""
    began, mean = clock.perf_counter(), contacts.mean_threshold
    motion, arrivals = motion_of(drive, mean, life.timeless and not contacts.waiting_time)
    check_lives(contacts, motion, life)
    march = march_of(contacts, motion, life, max(tolerance, finest(motion, life, mean)), until)
    march.run()
    # a march that was stopped has solved the points up to the end of its last panel; without a panel not even X = 0
    solved = march.solved
    solved_until = solved.end * (1.0 + ROUNDED_END) if solved.count else -np.inf
    kept = arrivals <= (solved_until if march.unfinished else np.inf)
    worst_fraction = solved.error.max(initial=0.0 if solved.count else np.inf) + march.unseen_error
    if worst_fraction > RESOLVED:
        worst_fraction = np.inf
    # a share of the contacts, times the longest stretch that one of them has, is a force
    fraction_in_means = march.longest_stretch / mean
    rounding_in_means = round_off(march.motion, mean, march.steady_since)
    error = float(worst_fraction * fraction_in_means + rounding_in_means)
    progress(error)
    reason = why_above(march, error, tolerance, rounding_in_means / fraction_in_means)
    success, message = outcome(contacts, error, tolerance, reason)
    if march.unfinished:
        end = f"X = {motion.at(np.array(solved.end)):.6g}"
        success, message = False, f"stopped at {end} by wall_time, the path is cut there; {message}"
    t = np.minimum(arrivals[kept], march.steady_since)
    # contacts that broke within the last delay are out
    holding = 1.0 - (breaks_until(march, t) - breaks_until(march, t - march.births.delay))
    if fault := march.fault or unconserved(holding, tolerance, float(worst_fraction)):
        success, message, error = False, fault, np.inf
    return Solution(
        path=drive.path[kept],
        time=drive.arrival_times()[kept],
        force=_read(march, solved.force, t),
        force_error=error,
        holding=holding,
        run_time=clock.perf_counter() - began,
        nodes=solved.count * polynomials.DEGREE,
        success=success,
        message=message,
        _march=march,
        _by_index=drive.time is not None or (not drive.forward and bool(contacts.laws)),
        _arrivals=arrivals[kept],
    )


def why_above(march: March, error: float, tolerance: float, rounding: float) -> str:
    """Why the error is above the tolerance (both in mean thresholds): the largest part of it, and what to do.
    `rounding` is the round-off as a share of the contacts, as the other parts are."""
    above = f"error estimate {error:.1e} is above the tolerance {tolerance:.1e}"
    solved = march.solved
    if not solved.count:
        hint = "; no panel was solved, and F is not known even at X = 0"
        return f"{above}{hint}; loosen the tolerance" + ", or give more time" * march.unfinished
    panel = int(np.argmax(solved.error))
    near = f"near X = {march.motion.at(solved.begin[panel]):.6g}"
    largest = max(march.jumps, key=lambda jump: jump.size, default=None)
    if largest is not None and largest.size == solved.error[panel]:
        near = f"{near}: {_of_jumps(march, largest)}"
    parts = {
        f"a panel {near}": solved.error[panel],
        "survivals of the contacts' laws": march.survival_error,
        "sums over births on earlier legs": march.unseen_error - march.survival_error,
        "round-off along the path": rounding,
    }
    if np.isinf(error):
        return f"nothing is known of the force: its breaks are not resolved {near}"
    most = max(parts, key=lambda each: parts[each])
    return f"{above}, most of it that of {most}; loosen the tolerance"


def _of_jumps(march: March, worst: Jump) -> str:
    """In words, where the number of contacts jumps most, and first, and what may be wrong there."""
    clock = "a travel of " if march.life.timeless and not march.births.delay else "t = "
    said = f"the number of contacts jumps by {worst.size:.1e} at {clock}{worst.time:.6g}, on leg {worst.leg} (from 0)"
    first = march.jumps[0]
    if first.time < worst.time:
        said += f", and first at {clock}{first.time:.6g}, on leg {first.leg}"
    if first.behind_edge:
        return f"{said}, right behind an edge: a sum over births is wrong there, or before"
    return f"{said}, where no edge is, or a sum over births is wrong there, or before"


def motion_of(drive: Drive, mean: float, timeless: bool = False) -> tuple[Motion, Array]:
    """The slider's motion to just beyond the path's end, and the times (`timeless`: distances travelled) of the path's
    points. InputError for a path too long (one that turns is limited by rounding), or a move after too long a rest."""
    away = np.abs(drive.path) / mean
    furthest, most = int(np.argmax(away)), FURTHEST if drive.forward else FURTHEST_TURN
    if not away[furthest] <= most:
        point = -1 if furthest == away.size - 1 else furthest
        limit = "follow at most" if drive.forward else "a path may turn round within"
        fault = f"is {away[furthest]:.3g} mean thresholds; {limit} {most:.0e} of them"
        refuse(f"path[{point}]", drive.path[furthest], fault)
    moves = np.diff(drive.path, prepend=0.0)
    times = np.asarray(np.abs(moves).cumsum()) if timeless else drive.arrival_times()
    steps = np.diff(times, prepend=0.0)
    moved = np.flatnonzero(steps > 0.0)
    speed = float(moves[moved[-1]] / steps[moved[-1]]) if moved.size else drive.velocity
    longer = BEYOND_END * mean / abs(speed or drive.velocity)
    knots = np.concatenate([[0.0], times, [times[-1] + longer]])
    motion = Motion(knots, np.concatenate([[0.0], drive.path, [drive.path[-1] + longer * speed]]))
    before = float((motion.times[:-1] * np.abs(motion.speeds)).max() / mean)
    if not before <= LONGEST_BEFORE:
        hint = f"a threshold is passed in {1.0 / before:.0e} of the time before: lost in rounding; rest shorter"
        refuse("time[-1]", times[-1], hint)
    return motion, times


def check_lives(contacts: Contacts, motion: Motion, life: Life) -> None:
    """Raise InputError where heat breaks contacts so fast that times lose their digits, or lives are too many."""
    if life.timeless or contacts.thermal is None:
        return
    scale = contacts.thermal.rates.scale
    times = LOOKED_AT[:, None] / scale
    at_rest = Motion(np.array([0.0, times[-1, 0]]), np.zeros(2))
    history = at_rest.history(times, np.zeros((1, 1)))
    survival = roughly_holding(life, reforming_law(contacts), history)
    lasts = float(times[min(int((survival > 0.5).sum()), times.size - 1), 0])
    moving = float(np.diff(motion.times)[motion.speeds != 0.0].sum())
    most = FURTHEST if motion.one_leg else MOST_LIVES_TURN
    if moving > most * lasts:
        many = f"contacts break some {moving / lasts:.0e} times on the path, of which {most:.0e}"
        refuse("attempt_frequency or scale", scale, f"{many} can be followed there; slide faster")
    if lasts < SHORTEST_BESIDE_DELAY * contacts.waiting_time:
        fault = f"contacts hold for {lasts:.0e}, too short to follow beside the delay"
        refuse("delay", contacts.waiting_time, fault)


def march_of(
    contacts: Contacts,
    motion: Motion,
    life: Life,
    tolerance: float,
    until: float = np.inf,
    most: float = np.inf,
) -> March:
    """The march along a motion, with panels that end where the number of breaks may bend; `most` is the
    largest force of a contact born, divided by <k> (a length), where the caller knows it."""
    reforming, mean = reforming_law(contacts), contacts.mean_threshold
    if until == np.inf and contacts.thermal is not None and contacts.thermal.closure == "exact":
        check_averages(contacts, motion, life, tolerance)
    moving = np.abs(motion.speeds[motion.speeds != 0.0])
    if contacts.thermal is not None and life.bends.size and moving.size:
        # later F and F' show the layer
        given = 0.0, life.bends, contacts.relative_stiffness(life.bends)
        layers = contacts.thermal.rates.reached(np.log(moving.min()) + LOG_OF_LAYER, *given)
        life = copy(life)
        life.bends = np.union1d(life.bends, layers[layers > THIN_LAYER * life.bends])
    stretch = min(longest_stretch(contacts, motion, life), most)
    budget = ErrorBudget.divide(tolerance, life, round_off(motion, mean), stretch, mean)
    births = Births(life, reforming, motion, contacts.waiting_time, budget.births, until, stretch)
    plan = edges(births, contacts.start, budget.panels)
    if plan.too_many_jumps:
        fault = "exact values break together more often on this path than can be followed"
        hint = "give them a width, as in gaussian(mean, std), or shorten the path"
        raise InputError(f"thresholds: {fault}; {hint}")
    guess = first_width(life, budget.panels)
    return March(births, contacts.start, plan.times, budget.panels, guess)


def check_averages(contacts: Contacts, motion: Motion, life: Life, tolerance: float) -> None:
    """Raise InputError where averages over a spread start, of sums over thresholds, would take minutes: both are over
    pieces."""
    bins, jumps = contacts.start.breakpoints.size, life.bends.size
    pieces = (PIECES_OF_START + bins + 3 * jumps) * (PIECES_OF_LAW + jumps)
    travelled = min(float(np.ptp(motion.positions)) / life.largest_stretch, 1.0)
    decades = np.clip(np.log10(1e-3 / tolerance), 0.0, MOST_DECADES)
    seconds = OF_PIECE * travelled * pieces * FOR_DECADE**decades
    if jumps and not contacts.start.is_single and seconds > MOST_SECONDS:
        fault = f"a spread start with {bins} edges of bins, beside {jumps} bends of the thresholds' density"
        hint = "take a smooth density for both, fewer bins or a larger tolerance; or in master.solve give wall_time"
        raise InputError(f"start: {fault} and heat, takes some {seconds:.0f} s; {hint}")


def finest(motion: Motion, life: Life, mean: float) -> float:
    """The tightest tolerance that rounded positions allow for."""
    farthest = min(float(np.abs(motion.positions).max()), FAR * mean)
    return float(FROM_ROUNDED_POSITIONS * np.spacing(farthest) / life.resolution_length)


def longest_stretch(contacts: Contacts, motion: Motion, life: Life) -> float:
    """The longest |x| that a contact may have: turns an error of the number into one of the force."""
    ends = [*contacts.start.span, *reforming_law(contacts).span]
    most = max(abs(end) for end in ends) + float(np.ptp(motion.positions))
    return max(min(life.largest_stretch, most), LEAST_STRETCH * contacts.mean_threshold)


def round_off(motion: Motion, mean: float, steady_since: float = np.inf) -> float:
    """Round-off of the force, in mean thresholds; none is added once breaks are steady."""
    places = motion.at(np.minimum(motion.times, steady_since))
    return ROUND_OFF * (1.0 + float(np.abs(np.diff(places)).sum()) / mean)


def breaks_until(march: March, t: Array) -> Array:
    """Breaks per contact up to times t, those of lumps included; 0 before t = 0."""
    before = np.append(0.0, np.cumsum(march.solved.breaks[:-1, -1]))
    out = _read(march, before[:, None] + march.solved.breaks, np.maximum(t, 0.0))
    for lump in march.lumps[1:]:
        out = out + lump.weight * (t >= lump.birth - march.births.delay)
    return np.where(t < 0.0, 0.0, out)


def _read(march: March, values: Array, t: Array) -> Array:
    """Values at times t, shape (n,), from those at the panels' beginnings and nodes. A time at which one panel
    ends and the next begins is read on the next: at a jump that is the value after it, at a turn the later leg."""
    begin, width, knots = march.solved.begin, march.solved.width, march.motion.times
    breaks_begin_own_leg = march.solved.breaks_begin_own_leg
    # at a jump, a time that rounding puts just before it is read after it; elsewhere values are continuous
    rounded = ROUNDED * begin + SAME_TIME * (breaks_begin_own_leg + width.min(initial=np.inf))
    read_from = begin - np.where(_begin_at_jumps(march, rounded), rounded, 0.0)
    panel = clipped(np.searchsorted(read_from, t, "right") - 1, 0, begin.size - 1)
    # counted from the beginning of the leg, as the panels are: after a long hold times have few digits
    leg_begins = knots[
        np.searchsorted(knots, (begin - breaks_begin_own_leg + 0.5 * width)[panel], "right") - 1
    ]
    place = clipped((t - leg_begins - breaks_begin_own_leg[panel]) / width[panel], 0.0, 1.0)
    return np.asarray(np.einsum("ij,ij->i", polynomials.values(place), values[panel]))


def _begin_at_jumps(march: March, rounded: Array) -> npt.NDArray[np.bool_]:
    """Which panels begin within `rounded` (a time each) of a jump of the number of breaks or of the force, which is
    where contacts break together, and where they form again one delay later."""
    born = np.array([lump.birth for lump in march.lumps[1:]])
    jumps = np.sort(np.concatenate([born, born - march.births.delay, [np.inf]]))
    begin = march.solved.begin
    after = jumps[np.searchsorted(jumps, begin - rounded)]
    return after <= begin + rounded
